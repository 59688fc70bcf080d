"""Prediction of drawing times on this computer from earlier ones."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

SLOW_FRAME_S = 0.050
"""Longer frames are not drawn at every step of a drag."""
BATCH_S = 0.025
"""Length of a piece of a frame that is drawn in pieces; a busy machine makes it several times
that."""
MOVING_S = 0.040
"""Target duration of a frame of a cloud's coarse nodes."""
FIRST_SETS = 3
"""Maximum number of sets of cloud points in the first picture of a movement."""
FRESH = 3.0
"""Cost of the first drawing of a part, which uploads it, relative to the next."""
STEADY_ELEMENTS = 20_000
"""With fewer elements, the fixed cost of a frame dominates."""


class Drawable(Protocol):
    """Part of a picture whose drawing time is predicted."""

    elements: int
    weight: float
    uploaded: bool


class Pace:
    """Predicts drawing times, and how many cloud points a moving picture can afford."""

    def __init__(self) -> None:
        self._seconds_per_element = 4e-7
        self.moving_sets = 1

    def expected(self, parts: Sequence[Drawable]) -> float:
        """Return the expected time for drawing these parts, seconds."""
        rate = self._seconds_per_element
        return sum(p.elements * p.weight * (1.0 if p.uploaded else FRESH) for p in parts) * rate

    def learn(self, parts: Sequence[Drawable], seconds: float) -> None:
        """Update the prediction by a drawing time; fresh parts do not count."""
        elements = sum(p.elements * p.weight for p in parts)
        if not elements or not all(p.uploaded for p in parts):
            return
        change = seconds / elements - self._seconds_per_element
        # Increase at once, decrease gradually: a piece that takes too long blocks the window.
        part = 0.5 if change > 0.0 else 0.3
        self._seconds_per_element += part * min(1.0, elements / STEADY_ELEMENTS) * change

    def begin_moving(self) -> None:
        """Reset the number of sets at the start of a movement.

        Its value from a close view, with most points outside the picture, does not apply.
        """
        self.moving_sets = min(self.moving_sets, FIRST_SETS)

    def learn_moving(self, seconds: float, max_sets: int) -> None:
        """Update the number of sets, at most `most`, by the time of a moving frame."""
        if seconds > MOVING_S:
            self.moving_sets = max(
                1, min(self.moving_sets, max_sets) - (1 if seconds < 0.08 else 2)
            )
        elif seconds < 0.6 * MOVING_S and self.moving_sets < max_sets:
            self.moving_sets += 1

    def next_batch(self, pending: Sequence[Drawable], seconds: float = BATCH_S) -> int:
        """Return how many of the first pending parts, at least one, to draw at once."""
        total_s = 0.0
        for count, part in enumerate(pending):
            total_s += self.expected([part])
            if count and total_s > seconds:
                return count
        return len(pending)


def point_weight(pixels: float) -> float:
    """Return the cost of a point of this width relative to one pixel, measured on llvmpipe."""
    return 1.0 + pixels * pixels / 35.0
