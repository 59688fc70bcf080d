"""Where a plane ceases to hold: the part of a surface that lies in one plane with most of it.

A plane is fitted that large deviations do not draw to themselves (iteratively reweighted least
squares: first absolute deviations, then Tukey's biweight; Holland & Welsch 1977, Communications in
Statistics A6, 813-827). What departs from it by more than its scatter and the model's noise allow,
in pieces larger than single cells, is where it does not hold.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

SCATTERS = 4.0
"""Robust standard deviations from which on a departure is none of the surface's own roughness."""
LEAST_SHARE = 0.03
"""Of the surface; less is not worth a trim."""
_BIWEIGHT = 4.685
_ROUNDS = 30
_MAD = 1.4826
_MOST_CELLS = 40_000


@dataclass(frozen=True, eq=False)
class Holding:
    """holds : (rows, columns) where the plane holds; departs : share of the known cells where it
    does not; limit : departures beyond this, m; plane : (3,) of the robust plane, height = a + b
    column + c row"""

    holds: Bools
    departs: float
    limit: float
    plane: Array

    @property
    def trims(self) -> bool:
        """Whether leaving out what departs is worth it."""
        return self.departs >= LEAST_SHARE


def where_it_holds(heights: Array, noise: float) -> Holding:
    """Of a raster of heights over any plane near it, NaN where unknown. noise : standard deviation
    of the heights that is the model's own."""
    from scipy import ndimage

    known = np.isfinite(heights)
    row, column = np.nonzero(known)
    values = heights[known]
    plane, scatter = _robust_plane(row, column, values)
    limit = SCATTERS * max(scatter, noise)
    surface = (
        plane[0]
        + plane[1] * np.arange(heights.shape[1])
        + (plane[2] * np.arange(heights.shape[0])[:, None])
    )
    off = known & ~(np.abs(heights - surface) <= limit)
    # Single cells are stones and strays; what is unknown is on nobody's side.
    off = ndimage.binary_opening(off, np.ones((3, 3), bool))
    pieces, count = ndimage.label(known & ~off, np.ones((3, 3), int))
    holds = known & ~off
    if count > 1:
        size = np.bincount(pieces.ravel())[1:]
        # Islands beyond a gap in the data belong, those beyond a departure do not.
        beyond = ndimage.binary_dilation(off, np.ones((3, 3), bool), iterations=2)
        for number in range(1, count + 1):
            own = pieces == number
            if number != int(np.argmax(size)) + 1 and (own & beyond).any():
                holds &= ~own
    n = int(known.sum())
    return Holding(holds, float(1.0 - holds.sum() / n) if n else 0.0, limit, plane)


def _robust_plane(
    row: npt.NDArray[np.int64], column: npt.NDArray[np.int64], values: Array
) -> tuple[Array, float]:
    """(3,) coefficients of 1, column and row, and the robust scatter about it."""
    step = max(1, len(values) // _MOST_CELLS)
    columns = np.stack([np.ones(len(values)), column, row], axis=1)
    some, z = columns[::step], values[::step]
    weight = np.ones(len(z))
    found = np.zeros(3)
    scatter = 0.0
    for turn in range(_ROUNDS):
        root = np.sqrt(weight)
        found = np.linalg.lstsq(some * root[:, None], z * root, rcond=None)[0]
        away = np.abs(z - some @ found)
        scatter = _MAD * float(np.median(away))
        if scatter == 0.0:
            break
        if turn < _ROUNDS // 2:
            weight = 1.0 / np.maximum(away, 0.05 * scatter)
        else:
            weight = np.maximum(1.0 - (away / (_BIWEIGHT * scatter)) ** 2, 0.0) ** 2
    return found, scatter
