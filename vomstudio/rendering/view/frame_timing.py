"""How long drawing takes on this machine, learned from how long it took."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

SLOW_FRAME_S = 0.050
"""What takes longer is not drawn anew at every step of a drag."""
BATCH_S = 0.025
"""Length of a piece of a frame that is drawn in pieces; a busy machine makes it several times
that."""
MOVING_S = 0.040
"""A frame of a cloud's stand-ins may take this long."""
FIRST_SETS = 3
"""Sets of a cloud's points at most in the first picture of a movement."""
FRESH = 3.0
"""The first drawing of a part, which takes it to the graphics card, against the next."""
STEADY_ELEMENTS = 20_000
"""Fewer say more about what every frame costs than about themselves."""


class Drawable(Protocol):
    elements: int
    weight: float
    uploaded: bool


class Pace:
    """Seconds for parts, and how many sets of a cloud's points a moving picture can afford."""

    def __init__(self) -> None:
        self._seconds_per_element = 4e-7
        self.moving_sets = 1

    def expected(self, parts: Sequence[Drawable]) -> float:
        """Seconds that drawing these parts will take."""
        rate = self._seconds_per_element
        return sum(p.elements * p.weight * (1.0 if p.uploaded else FRESH) for p in parts) * rate

    def learn(self, parts: Sequence[Drawable], seconds: float) -> None:
        """Drawing these parts has taken so long; fresh ones teach nothing."""
        elements = sum(p.elements * p.weight for p in parts)
        if not elements or not all(p.uploaded for p in parts):
            return
        change = seconds / elements - self._seconds_per_element
        # Slower at once, faster by and by: a piece that takes too long holds the window up.
        part = 0.5 if change > 0.0 else 0.3
        self._seconds_per_element += part * min(1.0, elements / STEADY_ELEMENTS) * change

    def begin_moving(self) -> None:
        """What has been afforded from near by, with most points out of the picture, says little
        about the first picture of the next movement."""
        self.moving_sets = min(self.moving_sets, FIRST_SETS)

    def learn_moving(self, seconds: float, most: int) -> None:
        """A frame of `moving_sets` sets, of at most `most` there are, has taken so long."""
        if seconds > MOVING_S:
            self.moving_sets = max(1, min(self.moving_sets, most) - (1 if seconds < 0.08 else 2))
        elif seconds < 0.6 * MOVING_S and self.moving_sets < most:
            self.moving_sets += 1

    def next_batch(self, pending: Sequence[Drawable], seconds: float = BATCH_S) -> int:
        """How many of the first pending parts, at least one, to draw in one go."""
        spent = 0.0
        for count, part in enumerate(pending):
            spent += self.expected([part])
            if count and spent > seconds:
                return count
        return len(pending)


def point_weight(pixels: float) -> float:
    """Cost of a point this many pixels wide against one of a pixel, measured on llvmpipe."""
    return 1.0 + pixels * pixels / 35.0
