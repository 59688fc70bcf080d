"""Which labels can be shown without lying on one another, in pixels; no Qt, no VTK."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

CELL = 4
"""Pixels per cell of the occupancy grid."""


class LabelGrid:
    """Takes rectangles as long as they touch none that was taken before."""

    def __init__(self, width: float, height: float) -> None:
        self.width, self.height = width, height
        self._taken = np.zeros((int(height) // CELL + 2, int(width) // CELL + 2), np.bool_)

    def block(self, x: float, y: float, width: float, height: float) -> None:
        """Keep a rectangle free of labels."""
        self._taken[self._cells(x, y, width, height)] = True

    def take(self, x: float, y: float, width: float, height: float) -> bool:
        """Take a rectangle; False (and nothing taken) where it collides or leaves the image."""
        if x < 0 or y < 0 or x + width > self.width or y + height > self.height:
            return False
        cells = self._cells(x, y, width, height)
        if self._taken[cells].any():
            return False
        self._taken[cells] = True
        return True

    def _cells(self, x: float, y: float, width: float, height: float) -> tuple[slice, slice]:
        return (
            slice(max(int(y) // CELL, 0), max(int(y + height) // CELL + 1, 0)),
            slice(max(int(x) // CELL, 0), max(int(x + width) // CELL + 1, 0)),
        )


def place_labels(
    grid: LabelGrid,
    anchors: npt.NDArray[np.float64],
    sizes: npt.NDArray[np.float64],
    order: npt.NDArray[np.int64],
    gap: float = 7.0,
) -> dict[int, tuple[float, float]]:
    """Top left corners of the labels that fit, tried in `order` beside their anchors (n, 2).

    Each is tried to the right of its anchor and above, then left, then below.
    """
    placed: dict[int, tuple[float, float]] = {}
    for i in order:
        x, y = anchors[i]
        if not (np.isfinite(x) and np.isfinite(y)):
            continue
        width, height = sizes[i]
        for corner in (
            (x + gap, y - gap - height),
            (x + gap, y + gap),
            (x - gap - width, y - gap - height),
            (x - gap - width, y + gap),
        ):
            if grid.take(corner[0], corner[1], width, height):
                placed[int(i)] = (float(corner[0]), float(corner[1]))
                break
    return placed
