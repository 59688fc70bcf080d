"""Prediction of drawing times on this computer from earlier measurements."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

SLOW_FRAME_S = 0.050
"""Maximum duration of a frame that is drawn at every step of a drag."""
BATCH_S = 0.025
"""Target duration of one step of a frame that is drawn incrementally; on a busy computer it takes
several times as long."""
MAX_MOVING_FRAME_S = 0.040
"""Target duration of a frame of a cloud's coarse nodes."""
MAX_INITIAL_SETS = 3
"""Maximum number of sets of cloud points in the first picture of a movement."""
UPLOAD_COST_FACTOR = 3.0
"""Cost of the first drawing of a part, which includes its upload, relative to later drawings."""
STEADY_ELEMENTS = 20_000
"""Number of elements below which the fixed cost of a frame dominates."""


class Drawable(Protocol):
    """Part of a picture whose drawing time is predicted."""

    elements: int
    weight: float
    is_uploaded: bool


class Pace:
    """Prediction of drawing times, and of the cloud points drawn while the view moves."""

    def __init__(self) -> None:
        self._seconds_per_element = 4e-7
        self.moving_sets = 1

    def estimate_seconds(self, parts: Sequence[Drawable]) -> float:
        """Return the expected drawing time of parts, seconds."""
        rate = self._seconds_per_element
        return (
            sum(
                p.elements * p.weight * (1.0 if p.is_uploaded else UPLOAD_COST_FACTOR)
                for p in parts
            )
            * rate
        )

    def record_frame(self, parts: Sequence[Drawable], seconds: float) -> None:
        """Update the prediction with a measured drawing time.

        Frames with newly uploaded parts are ignored.
        """
        elements = sum(p.elements * p.weight for p in parts)
        if not elements or not all(p.is_uploaded for p in parts):
            return
        change = seconds / elements - self._seconds_per_element
        # Increases immediately and decreases gradually, because a step that takes too long
        # blocks the window.
        part = 0.5 if change > 0.0 else 0.3
        self._seconds_per_element += part * min(1.0, elements / STEADY_ELEMENTS) * change

    def begin_moving(self) -> None:
        """Limit the number of sets at the start of a movement.

        The number from a close view does not apply, because most points were outside that
        picture.
        """
        self.moving_sets = min(self.moving_sets, MAX_INITIAL_SETS)

    def record_moving_frame(self, seconds: float, max_sets: int) -> None:
        """Update the number of sets, up to `max_sets`, with the time of a moving frame."""
        if seconds > MAX_MOVING_FRAME_S:
            self.moving_sets = max(
                1, min(self.moving_sets, max_sets) - (1 if seconds < 0.08 else 2)
            )
        elif seconds < 0.6 * MAX_MOVING_FRAME_S and self.moving_sets < max_sets:
            self.moving_sets += 1

    def next_batch(self, pending_drawables: Sequence[Drawable], seconds: float = BATCH_S) -> int:
        """Return the number of pending parts, at least one, to draw in the next step."""
        total_s = 0.0
        for count, part in enumerate(pending_drawables):
            total_s += self.estimate_seconds([part])
            if count and total_s > seconds:
                return count
        return len(pending_drawables)


def point_weight(pixels: float) -> float:
    """Return the cost of drawing a point relative to one pixel, as measured on llvmpipe."""
    return 1.0 + pixels * pixels / 35.0
