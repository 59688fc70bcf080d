"""Where a plane ceases to hold: the part of a surface that lies in one plane with most of it.

A plane is fitted that large deviations do not draw to themselves (iteratively reweighted least
squares: first absolute deviations, then Tukey's biweight; Holland & Welsch 1977, Communications in
Statistics A6, 813-827). What departs from it by more than its scatter and the model's noise allow,
in pieces larger than single cells, is where it does not hold.

Where a third of the surface or more bends away, such a plane is a compromise that fits neither
part. So planes are also grown from parts of the surface, each over all that lies within its own
scatter. On a surface that is one plane, however rough, or a smoothly bent one they grow over the
whole (on every one of 200 self-affine surfaces with H from 0.3 to 0.9); where one stops at far less
scatter than the whole has, the surface is broken, and the largest such part holds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray

SCATTERS = 4.0
"""Robust standard deviations from which on a departure is none of the surface's own roughness."""
LEAST_SHARE = 0.03
"""Of the surface; less is not worth a trim."""
_BIWEIGHT = 4.685
_ROUNDS = 30
_MAD = 1.4826
_MOST_CELLS = 40_000
BROKEN = 0.7
"""Of the scatter about the plane of all, and of that about a paraboloid: the scatter about a part
of the surface is less than that only where the surface is broken."""
_LEAST_PART = 0.25
_SEEDS_A_SIDE, _SEED_SIZE, _GROWN_CELLS = 4, 1.0 / 3.0, 6_000


@dataclass(frozen=True, eq=False)
class Holding:
    """holds : (rows, columns) where the plane holds; departs : share of the known cells where it
    does not; limit : departures beyond this, m; plane : (3,) of the robust plane, height = a + b
    column + c row; other : where the surface is broken, the largest other plane, and other_share of
    the known cells that lie in it"""

    holds: BoolArray
    departs: float
    limit: float
    plane: FloatArray
    other: FloatArray | None = None
    other_share: float = 0.0

    @property
    def trims(self) -> bool:
        """Whether leaving out what departs is worth it."""
        return self.departs >= LEAST_SHARE


def where_it_holds(heights: FloatArray, noise: float) -> Holding:
    """Of a raster of heights over any plane near it, NaN where unknown. noise : standard deviation
    of the heights that is the model's own."""
    from scipy import ndimage

    known = np.isfinite(heights)
    row, column = np.nonzero(known)
    values = heights[known]
    plane, scatter = _robust_plane(row, column, values)
    parts = _parts(row, column, values, noise, scatter)
    if parts:
        plane, scatter, _ = parts[0]
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
    departs = float(1.0 - holds.sum() / n) if n else 0.0
    if len(parts) < 2:
        return Holding(holds, departs, limit, plane)
    return Holding(
        holds, departs, limit, plane, parts[1][0], float((parts[1][2] & ~parts[0][2]).mean())
    )


def _parts(
    row: IntArray,
    column: IntArray,
    values: FloatArray,
    noise: float,
    scatter: float,
) -> list[tuple[FloatArray, float, BoolArray]]:
    """Where the surface is broken, the plane of its largest part, the scatter about it, and which
    of some cells lie in it; and the same of the largest other part, if there is one.

    scatter : about the plane of all"""
    step = max(1, round(float(np.sqrt(len(values) / _GROWN_CELLS))))
    some = (row % step == 0) & (column % step == 0)
    row, column, z = row[some], column[some], values[some]
    if len(z) < 9 * _SEEDS_A_SIDE**2:
        return []
    x = (column - column.min()) / max(float(np.ptp(column)), 1.0)
    y = (row - row.min()) / max(float(np.ptp(row)), 1.0)
    columns = np.stack([np.ones(len(z)), column, row], axis=1).astype(np.float64)
    curved = np.stack([np.ones(len(z)), x, y, x * x, x * y, y * y], axis=1)
    bent = _scatter(z - curved @ np.linalg.lstsq(curved, z, rcond=None)[0])
    most = BROKEN * min(scatter, bent)
    if most <= noise:
        return []
    found = []
    for start in np.linspace(0.0, 1.0 - _SEED_SIZE, _SEEDS_A_SIDE):
        of_rows = (y >= start) & (y <= start + _SEED_SIZE)
        for first in np.linspace(0.0, 1.0 - _SEED_SIZE, _SEEDS_A_SIDE):
            seed = of_rows & (x >= first) & (x <= first + _SEED_SIZE)
            grown = _grown(columns, z, seed, noise)
            if grown is not None and grown[1] < most and grown[2].mean() >= _LEAST_PART:
                found.append(grown)
    if not found:
        return []
    # A compromise that spreads over the break scatters more than a part on one side of it.
    sharp = 2.0 * min(each[1] for each in found)
    found = sorted((each for each in found if each[1] <= sharp), key=lambda each: -each[2].sum())
    others = [each for each in found if (each[2] & found[0][2]).sum() < 0.3 * each[2].sum()]
    return [found[0], *others[:1]]


def _grown(
    columns: FloatArray, z: FloatArray, inside: BoolArray, noise: float
) -> tuple[FloatArray, float, BoolArray] | None:
    """The plane of some cells, grown over all that lie within its scatter."""
    plane: FloatArray = np.zeros(3)
    scatter = 0.0
    for _ in range(_ROUNDS // 2):
        if inside.sum() < 30:
            return None
        plane = np.asarray(np.linalg.lstsq(columns[inside], z[inside], rcond=None)[0])
        away = z - columns @ plane
        # What is exact to the digit scatters by rounding.
        scatter = max(_scatter(away[inside]), noise, 1e-9 * float(np.abs(z).max()))
        within = np.abs(away) <= SCATTERS * scatter
        if np.array_equal(within, inside):
            break
        inside = within
    return plane, scatter, inside


def _scatter(away: FloatArray) -> float:
    return _MAD * float(np.median(np.abs(away)))


def _robust_plane(row: IntArray, column: IntArray, values: FloatArray) -> tuple[FloatArray, float]:
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
