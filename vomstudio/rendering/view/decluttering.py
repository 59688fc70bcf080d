"""Which labels can be shown without lying on one another, in pixels; no Qt, no VTK."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

CELL = 4
"""Pixels per cell of the occupancy grid."""


class LabelGrid:
    """Takes rectangles as long as they touch none that was taken before.

    A row of cells is the bits of one integer: with a thousand labels at every step of a drag, small
    slices of an array took most of the time.
    """

    def __init__(self, width: float, height: float) -> None:
        self.width, self.height = width, height
        self._rows = [0] * (int(height) // CELL + 2)

    def block(self, x: float, y: float, width: float, height: float) -> None:
        """Keep a rectangle free of labels."""
        first, last, mask = self._cells(x, y, width, height)
        for row in range(first, last):
            self._rows[row] |= mask

    def take(self, x: float, y: float, width: float, height: float) -> bool:
        """Take a rectangle; False (and nothing taken) where it collides or leaves the image."""
        if x < 0 or y < 0 or x + width > self.width or y + height > self.height:
            return False
        # As in `_cells`, but it lies inside.
        left = int(x) // CELL
        mask = ((2 << (int(x + width) // CELL - left)) - 1) << left
        rows = self._rows
        span = range(int(y) // CELL, int(y + height) // CELL + 1)
        for row in span:
            if rows[row] & mask:
                return False
        for row in span:
            rows[row] |= mask
        return True

    def is_free(self, x: float, y: float, width: float, height: float) -> bool:
        """Whether nothing of a rectangle is taken, as far as it lies in the image."""
        first, last, mask = self._cells(x, y, width, height)
        return not any(row & mask for row in self._rows[first:last])

    def _cells(self, x: float, y: float, width: float, height: float) -> tuple[int, int, int]:
        """First row, the row after the last, and the bits of the columns."""
        left = max(int(x) // CELL, 0)
        right = max(min(int(x + width), int(self.width)) // CELL + 1, left)
        first = max(int(y) // CELL, 0)
        last = max(min(int(y + height) // CELL + 1, len(self._rows)), first)
        return first, last, ((1 << (right - left)) - 1) << left


def place_labels(
    grid: LabelGrid,
    anchors: npt.NDArray[np.float64],
    sizes: npt.NDArray[np.float64],
    order: npt.NDArray[np.int64],
    gap: float = 7.0,
    corners: npt.NDArray[np.int64] | None = None,
    clear: npt.NDArray[np.float64] | None = None,
) -> dict[int, tuple[float, float]]:
    """Top left corners of the labels that fit, tried in `order` beside their anchors (n, 2).

    Each is tried to the right of its anchor and above, then below, then to the left, then in the
    middle. corners : (n,)
    which of these places a label had last, taken up again where it is free, so that labels do not
    jump about their anchors while the view turns; written anew for those that are placed. clear :
    (n,) pixels that must be free all round a label at the first place tried, or it gets none.
    """
    placed: dict[int, tuple[float, float]] = {}
    finite = np.asarray(np.isfinite(anchors).all(axis=1))
    # Plain numbers: taking them one by one out of arrays would cost more than the placing.
    wanted = order[finite[order]]
    margins = np.zeros(len(wanted)) if clear is None else clear[wanted]
    each = zip(
        wanted.tolist(),
        anchors[wanted].tolist(),
        sizes[wanted].tolist(),
        margins.tolist(),
        strict=True,
    )
    for i, (x, y), (width, height), free in each:
        # At an edge of the image it moves in.
        right = min(x + gap, grid.width - width)
        left = max(x - gap - width, 0.0)
        middle = x - width / 2.0
        above, below = y - gap - height, y + gap
        places = (
            (right, above),
            (right, below),
            (left, above),
            (left, below),
            (middle, above),
            (middle, below),
        )
        last = 0 if corners is None else int(corners[i])
        if free > 0.0:
            x0, y0 = places[last]
            if not grid.is_free(x0 - free, y0 - free, width + 2 * free, height + 2 * free):
                continue
        for k in (last, *(k for k in range(6) if k != last)):
            if grid.take(*places[k], width, height):
                placed[i] = places[k]
                if corners is not None:
                    corners[i] = k
                break
    return placed


def by_importance(
    selected: npt.NDArray[np.bool_],
    kept: npt.NDArray[np.bool_],
    extents: npt.NDArray[np.float64],
    *,
    moving: bool,
) -> npt.NDArray[np.int64]:
    """The order in which labels or symbols (n,) get their places: the selected ones, then the
    larger features. Those shown last stay before all others while the view moves, and before those
    that are not much larger when it rests: what comes and goes at every step cannot be read."""
    weight = extents if moving else extents * np.where(kept, 1.5, 1.0)
    return np.lexsort((-weight, ~kept & moving, ~selected))
