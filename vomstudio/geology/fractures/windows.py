"""Traces seen through a window: what its size and edge do to their number, length and intensity."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.geology.fractures.length_laws import Parameter, Window
from vomstudio.geology.fractures.pieces import Pieces, segments_of

_SIZES, _PLACES = 8, 64
BEYOND = 0.2
"""Of an area: more of it beyond the outermost traces is said to be so."""
_Z95 = 1.959963984540054


@dataclass(frozen=True)
class IntensityAtSize:
    """P21 in circles of one radius that lie wholly in the area: how many, their mean, standard
    deviation, least and most in 1/m; independent : how many of them the area would hold side by
    side"""

    radius_m: float
    windows: int
    independent: float
    P21_1_per_m: float
    std_1_per_m: float
    min_1_per_m: float
    max_1_per_m: float


@dataclass(frozen=True)
class CircleEstimates:
    """What a circle tells without any length (Mauldon, Dunne & Rohrbaugh 2001, Journal of
    Structural Geology 23, 247-258): n crossings of its rim, m ends inside; intensity n / 4r,
    density m / 2 pi r^2, mean length pi r n / 2m, None without ends"""

    n: int
    m: int
    intensity_1_per_m: float
    density_1_per_m2: float
    mean_length_m: float | None


def circle_estimates(pieces: Pieces, radius: float) -> CircleEstimates:
    n = int(pieces.cut.sum())
    m = 2 * len(pieces) - n
    mean = math.pi * radius * n / (2 * m) if m else None
    return CircleEstimates(n, m, n / (4 * radius), m / (2 * math.pi * radius**2), mean)


def mean_by_ends(lengths: FloatArray, cut_ends: FloatArray) -> Parameter | None:
    """The mean length of whole traces, from pieces (n,) seen in a window: all length over half the
    number of ends inside.

    Neither cutting off nor the preference for long traces disturbs it, since every trace has two
    ends, and each is seen with the same chance wherever it lies (Pahl 1981, International Journal
    of Rock Mechanics 18, 221-228; Zhang & Einstein 1998). The 95 % interval is that of a ratio of
    sums over independent pieces. None where no end is inside.
    """
    traces = (2.0 - cut_ends) / 2.0
    total = float(traces.sum())
    if total <= 0:
        return None
    mean = float(lengths.sum()) / total
    if len(lengths) < 2:
        return Parameter(mean, None, None)
    n = len(lengths)
    error = math.sqrt(n / (n - 1) * float(np.sum((lengths - mean * traces) ** 2))) / total
    span = math.exp(min(_Z95 * error / mean, 50.0))
    return Parameter(mean, mean / span, mean * span)


def directions_of(pieces: Pieces) -> FloatArray:
    """(n, 2) unit vectors from start to end of each piece; of closed ones of their longest part."""
    ends = pieces.ends()
    along = ends[:, 1] - ends[:, 0]
    length = np.hypot(*along.T)
    for i in np.flatnonzero(length <= pieces.rounding_m):
        start, end, _ = segments_of(pieces.lines[i : i + 1])
        step = end - start
        along[i] = step[int(np.argmax(np.hypot(*step.T)))]
        length[i] = np.hypot(*along[i])
    return np.asarray(along / np.maximum(length, 1e-300)[:, None])


def window_of(pieces: Pieces, area: Any) -> Window:
    """The area with its mean width across the traces, each direction as frequent as ends of such
    traces inside."""
    import shapely

    weights = 2.0 - pieces.cut.sum(axis=1)
    if weights.sum() <= 0:
        weights = np.ones(len(pieces))
    # Directions in classes of a degree: an edge of thousands of corners meets thousands of traces.
    x, y = directions_of(pieces).T
    degree = np.round(np.degrees(np.arctan2(y, x))).astype(int) % 180
    share = np.bincount(degree, weights, minlength=180) / weights.sum()
    turn = np.radians(np.arange(180))
    rings = shapely.get_parts(shapely.boundary(area))
    start, end, _ = segments_of(rings)
    dx, dy = (end - start).T
    across = np.abs(np.cos(turn)[:, None] * dy - np.sin(turn)[:, None] * dx).sum(axis=1)
    return Window(float(area.area), float(share @ across) / 2.0)


def share_beyond(lines: Any, area: Any) -> float:
    """Of an area that part which lies outside the convex hull of all traces (n,), in it or not."""
    import shapely

    hull = shapely.convex_hull(shapely.multilinestrings(shapely.get_parts(lines)))
    return 1.0 - float(shapely.area(shapely.intersection(area, hull)) / shapely.area(area))


def intensity_by_size(pieces: Pieces, area: Any) -> tuple[IntensityAtSize, ...]:
    """P21 in circles of growing size, up to 64 of each on a regular grid, from the smallest that
    holds a few traces to the largest that fits. Empty where nothing fits, or nothing is there."""
    import shapely

    if not len(pieces):
        return ()
    largest = shapely.length(shapely.maximum_inscribed_circle(area, tolerance=_tolerance(area)))
    mean_gap = float(area.area) / max(float(pieces.lengths().sum()), 1e-300)
    radii = np.geomspace(min(2 * mean_gap, 0.25 * largest), 0.95 * largest, _SIZES)
    start, end, _ = segments_of(pieces.lines)
    tree = shapely.STRtree(shapely.linestrings(np.stack([start, end], axis=1)))
    found = []
    for radius in radii:
        centres = _centres(area, float(radius))
        if not len(centres):
            continue
        boxes = shapely.box(*(centres - radius).T, *(centres + radius).T)
        at, segment = tree.query(boxes)
        inside = _inside_circle(start[segment], end[segment], centres[at], float(radius))
        values = np.bincount(at, inside, minlength=len(centres)) / (math.pi * radius**2)
        found.append(
            IntensityAtSize(
                float(radius),
                len(centres),
                float(area.area / (math.pi * radius**2)),
                float(values.mean()),
                float(values.std(ddof=1)) if len(values) > 1 else 0.0,
                float(values.min()),
                float(values.max()),
            )
        )
    return tuple(found)


def _tolerance(area: Any) -> float:
    return 1e-3 * math.sqrt(float(area.area))


def _centres(area: Any, radius: float) -> FloatArray:
    """(k, 2) places at which a circle fits into the area, at most 64."""
    import shapely

    room = area.buffer(-radius)
    if room.is_empty:
        return np.zeros((0, 2))
    low_x, low_y, high_x, high_y = room.bounds
    spacing = max(math.sqrt(float(room.area) / _PLACES), 1e-9)
    while True:
        x, y = (
            np.linspace(low, high, max(int((high - low) / spacing), 0) + 2)[1:-1]
            if high - low > spacing
            else np.array([(low + high) / 2])
            for low, high in ((low_x, high_x), (low_y, high_y))
        )
        grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        shapely.prepare(room)
        kept = grid[shapely.contains_xy(room, grid[:, 0], grid[:, 1])]
        if len(kept) <= _PLACES:
            break
        spacing *= 1.1
    if len(kept):
        return np.asarray(kept)
    point = shapely.point_on_surface(room)
    return np.array([[point.x, point.y]])


def _inside_circle(
    start: FloatArray, end: FloatArray, centre: FloatArray, radius: float
) -> FloatArray:
    """(k,) the length of segments inside circles, pair by pair."""
    along = end - start
    length = np.hypot(*along.T)
    unit = along / np.maximum(length, 1e-300)[:, None]
    to_centre = centre - start
    middle = np.einsum("ij,ij->i", to_centre, unit)
    off = np.einsum("ij,ij->i", to_centre, to_centre) - middle**2
    half = np.sqrt(np.maximum(radius**2 - off, 0.0))
    inside = np.minimum(middle + half, length) - np.maximum(middle - half, 0.0)
    return np.asarray(np.where(half > 0, np.maximum(inside, 0.0), 0.0))
