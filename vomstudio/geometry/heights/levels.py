"""Whether the points of a patch lie at several levels, as on two planes a step apart, or in two
layers, as of two scans that do not fit: one plane of all of them is between them.

Steps are told by means of small cells of the patch, which scatter much less than points, so that
steps of twice the noise stand out: once the plane that the pieces have in common is taken off, the
means are at some levels and hardly any between. Of a wave, or of roughness, many are between.
Layers over each other have no such cells; they are told by two humps of the points' heights, which
need three times the noise.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray, Int16Array
from vomstudio.core.findings import Finding
from vomstudio.geometry.patches import equal_cells

FEWEST = 200
"""Fewer points tell no step of some times their noise."""
_LOOKED_AT = 6_000
# Points in a cell; cells a side at least, and those whose attitudes are taken. With fewer cells
# waves are steps.
_PER_CELL, _LEAST_SIDE, _WIDE = 16.0, 6, 5
# Ours, of the local scatter, of the standard error of a cell's mean, and of the grid of a file.
_STEP, _SURE, _GRIDS = 1.5, 4.5, 1.5
# A level has at least such a share of the cells; between two there are at most so many beside those
# of the smaller one. Of a sine wave's there are 0.7, of an even spread 1. Without any step means
# scatter by their standard error.
_LEAST_SHARE, _BETWEEN, _BAND = 0.07, 0.3, 0.2
_FLAT = 1.6
_TURNS, _MOST_LEVELS = 12, 4
# Of heights: the width over which they are counted, of their standard deviation; the valley beside
# the lower hump, within cells and on the whole, where waves have humps as well; humps that are no
# chance.
_SMOOTH, _VALLEY, _DEEP, _CHANCE = 0.35, 0.9, 0.6, 4.0
_BINS = 256
_EXACT = 1e-9
_FARTHEST = 32_000


def level_gap(points: npt.ArrayLike, normal: npt.ArrayLike) -> float | None:
    """How far apart the levels are in which points (n, 3) of one patch lie, in their unit; None
    where they lie in one, or cannot tell. normal : (3,) of the patch's plane."""
    xyz = np.asarray(points, np.float64)
    if len(xyz) < FEWEST:
        return None
    if len(xyz) > _LOOKED_AT:
        xyz = xyz[np.random.default_rng(0).choice(len(xyz), _LOOKED_AT, replace=False)]
    n = np.asarray(normal, np.float64)
    local = xyz - xyz.mean(axis=0)
    grid = float(np.abs(n) @ grid_steps(xyz))
    _, _, basis = np.linalg.svd(n[None])
    flat, h = local @ basis[1:].T, local @ n
    _, axes = np.linalg.eigh(flat.T @ flat)
    v, u = (flat @ axes).T
    extent = max(float(np.ptp(u)), float(np.ptp(v)))
    if not h.std() > _EXACT * extent:
        return None
    slopes = _slopes(u, v, h)
    side = int(np.sqrt(len(u) / _PER_CELL))
    if side < _LEAST_SIDE:
        return _of_layers(h, _VALLEY, grid)
    cell = equal_cells(_rounded(u), _rounded(v), side)
    count = np.bincount(cell, minlength=side * side).astype(np.float64)
    a, b, mean = (np.bincount(cell, x, side * side) / count for x in (u, v, h))
    inside = h - mean[cell] - slopes[0] * (u - a[cell]) - slopes[1] * (v - b[cell])
    # Within most cells there is no step.
    square = np.bincount(cell, inside**2) / np.maximum(count - 1.0, 1.0)
    noise = float(np.sqrt(np.median(square)))
    error = noise / float(np.sqrt(np.median(count)))
    least = max(_STEP * noise, _SURE * error, _GRIDS * grid)
    gap = _of_cells(a, b, mean, slopes, _FLAT * error)
    if gap is not None and gap >= least:
        return gap
    gap = _of_layers(h, _DEEP, grid)
    return _of_layers(inside, _VALLEY, grid) if gap is None else gap


def level_findings(gap_m: float | None) -> list[Finding]:
    """Return why a plane through points in such levels is not good; nothing for None."""
    return [] if gap_m is None else [Finding("plane.levels", gap_m=gap_m)]


def bend_findings(is_bent: bool) -> list[Finding]:
    """Return why the plane of a piece of a curved face is not good; nothing for another."""
    return [Finding("plane.bowed")] if is_bent else []


def grid_steps(points: FloatArray) -> FloatArray:
    """(3,) of the grid on which a file's coordinates were rounded, 0 where there is none."""
    steps = np.zeros(3)
    for axis in range(3):
        apart = np.diff(np.sort(points[:500, axis]))
        apart = np.sort(apart[apart > 0.0])
        apart = apart[apart > 1e-6 * apart[len(apart) // 2]] if len(apart) else apart
        if len(apart) < 2:
            continue
        step = float(apart[0])
        off = apart / step
        # On no grid differences are any multiple of the least one.
        if float(np.abs(off - np.round(off)).max()) < 0.02 * max(1.0, 1e-3 * off.max()):
            steps[axis] = step
    return steps


# --- steps ------------------------------------------------------------------------------------
def _of_cells(
    a: FloatArray, b: FloatArray, mean: FloatArray, slopes: FloatArray, flat: float
) -> float | None:
    """Of cells with their places and mean heights, which scatter by less than `flat` where there is
    no step. slopes : of the pieces of the plane"""
    for begin in (slopes, np.zeros(2)):
        if float(np.std(mean - begin[0] * a - begin[1] * b)) < flat:
            return None
    for begin in (slopes, np.zeros(2)):
        for levels in range(2, _MOST_LEVELS + 1):
            gap = _levels(a, b, mean, begin, levels)
            if gap is not None:
                return gap
    return None


def _levels(
    a: FloatArray, b: FloatArray, mean: FloatArray, slopes: FloatArray, number: int
) -> float | None:
    """The least distance between so many levels of cells, on a plane common to all."""
    left = mean - slopes[0] * a - slopes[1] * b
    low, high = np.quantile(left, [0.05, 0.95])
    middles = np.asarray(np.linspace(float(low), float(high), number), np.float64)
    level = np.full(len(mean), -1)
    for _ in range(_TURNS):
        now = np.abs(left[:, None] - middles[None]).argmin(axis=1)
        if np.bincount(now, minlength=number).min() < _LEAST_SHARE * len(mean):
            return None
        if (now == level).all():
            break
        level = now
        own = np.zeros((len(mean), number + 2))
        own[np.arange(len(mean)), level] = 1.0
        own[:, number], own[:, number + 1] = a, b
        slopes = np.asarray(np.linalg.lstsq(own, mean, rcond=None)[0][number:], np.float64)
        left = mean - slopes[0] * a - slopes[1] * b
        middles = np.asarray(np.bincount(level, left) / np.bincount(level), np.float64)
    middles = np.sort(middles)
    gaps = np.diff(middles)
    for low, gap in zip(middles, gaps, strict=False):
        place = (left - low) / gap
        between = int((np.abs(place - 0.5) < _BAND).sum())
        beside = min(int((np.abs(place - end) < _BAND).sum()) for end in (0.0, 1.0))
        if between > _BETWEEN * beside:
            return None
    return float(gaps.min())


def _slopes(u: FloatArray, v: FloatArray, h: FloatArray) -> FloatArray:
    """Of the pieces of the patch, the median of some wide cells: a step is in few of them."""
    cell = equal_cells(_rounded(u), _rounded(v), _WIDE)
    count = np.bincount(cell)
    a, b, c = (x - (np.bincount(cell, x) / count)[cell] for x in (u, v, h))
    aa, ab, bb, ac, bc = (np.bincount(cell, x) for x in (a * a, a * b, b * b, a * c, b * c))
    area = aa * bb - ab * ab
    sound = area > 1e-6 * aa * bb
    if not sound.any():
        return np.zeros(2)
    found = np.stack([bb * ac - ab * bc, aa * bc - ab * ac])[:, sound] / area[sound]
    return np.asarray(np.median(found, axis=1))


def _rounded(x: FloatArray) -> Int16Array:
    """In a lattice whole rows are at one place but for the tilt of the plane, and by that the
    height of a point would choose its cell. Short integers are sorted in a tenth of the time."""
    steps = np.round(x / max(1e-3 * float(x.std()), 1e-300))
    return np.clip(steps, -_FARTHEST, _FARTHEST).astype(np.int16)


# --- layers -----------------------------------------------------------------------------------
def _of_layers(h: FloatArray, deep: float, grid: float) -> float | None:
    """How far apart the two largest humps of heights are, if they are two with such a valley."""
    low, high = np.quantile(h, [0.002, 0.998])
    own = h[(h >= low) & (h <= high)]
    width = max(_SMOOTH * float(own.std()), 0.5 * grid)
    if not width > 0.0:
        return None
    reach = 4.0 * width
    count, edges = np.histogram(own, _BINS, (low - reach, high + reach))
    step = edges[1] - edges[0]
    away = np.arange(-int(reach / step), int(reach / step) + 1) * step
    kernel = np.exp(-0.5 * (away / width) ** 2)
    density = np.convolve(count, kernel, mode="same")
    peaks = np.flatnonzero((density[1:-1] > density[:-2]) & (density[1:-1] >= density[2:])) + 1
    if len(peaks) < 2:
        return None
    first, second = sorted(peaks[np.argsort(-density[peaks])[:2]].tolist())
    lower = min(density[first], density[second])
    valley = float(density[first : second + 1].min())
    # Of counts weighted by the kernel the variance is that of their squares.
    chance = _CHANCE * float(np.sqrt(np.convolve(count, kernel**2, mode="same").max()))
    gap = float(edges[second] - edges[first])
    if valley > deep * lower or lower - valley < chance or lower < 0.1 * density.max():
        return None
    return gap if gap > _GRIDS * grid else None
