"""Effects of the sampling window on the number, length and intensity of traces."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.geology.fractures.length_laws import Parameter, Window
from vomstudio.geology.fractures.pieces import TracePieces, line_segments

N_SIZES, MAX_CIRCLES = 8, 64
MAX_UNMAPPED_SHARE = 0.2
"""Maximum share of an area outside the hull of the traces that is not reported."""
Z95 = 1.959963984540054


@dataclass(frozen=True)
class IntensityAtSize:
    """P21 in circles of one radius within the area.

    Attributes
    ----------
    windows : int
        Number of circles.
    independent : float
        Area divided by that of a circle, the maximum number of circles without overlap.
    P21_1_per_m, std_1_per_m, min_1_per_m, max_1_per_m : float
        Mean, standard deviation, minimum and maximum, 1/m.
    """

    radius_m: float
    windows: int
    independent: float
    P21_1_per_m: float
    std_1_per_m: float
    min_1_per_m: float
    max_1_per_m: float


@dataclass(frozen=True)
class CircleEstimates:
    """Estimates from a circular window that do not require trace lengths.

    According to Mauldon, Dunne & Rohrbaugh 2001, Journal of Structural Geology 23, 247-258, n
    crossings of the circle and m ends inside it give the intensity n / 4r, the density m / 2 pi r^2
    and the mean length pi r n / 2m, which is None if there are no ends.
    """

    n: int
    m: int
    intensity_1_per_m: float
    density_1_per_m2: float
    mean_length_m: float | None


def circle_estimates(pieces: TracePieces, radius: float) -> CircleEstimates:
    """Estimate the intensity, density and mean length of traces from a circle.

    Parameters
    ----------
    pieces : TracePieces
    radius : float
        Radius in metres.

    Returns
    -------
    CircleEstimates
    """
    n = int(pieces.is_cut.sum())
    m = 2 * len(pieces) - n
    mean = math.pi * radius * n / (2 * m) if m else None
    return CircleEstimates(n, m, n / (4 * radius), m / (2 * math.pi * radius**2), mean)


def mean_length_from_ends(lengths: FloatArray, cut_ends: FloatArray) -> Parameter | None:
    """Return the mean length of complete traces from the pieces observed in a window.

    It is the total length divided by half the number of ends inside the window. Neither censoring
    nor the preferential sampling of long traces causes a bias, because each of the two
    ends of a trace is observed with the same probability regardless of its position (Pahl 1981,
    International Journal of Rock Mechanics 18, 221-228; Zhang & Einstein 1998). The 95 % interval
    is that of a ratio of sums over independent pieces.

    Parameters
    ----------
    lengths : (n,) ndarray
        Lengths of the pieces, m.
    cut_ends : (n,) ndarray
        Number of ends of each piece that lie on the edge.

    Returns
    -------
    Parameter or None
        None if no end is inside the window.
    """
    trace_fractions = (2.0 - cut_ends) / 2.0
    n_complete_traces = float(trace_fractions.sum())
    if n_complete_traces <= 0:
        return None
    mean = float(lengths.sum()) / n_complete_traces
    if len(lengths) < 2:
        return Parameter(mean, None, None)
    n = len(lengths)
    error = (
        math.sqrt(n / (n - 1) * float(np.sum((lengths - mean * trace_fractions) ** 2)))
        / n_complete_traces
    )
    factor = math.exp(min(Z95 * error / mean, 50.0))
    return Parameter(mean, mean / factor, mean * factor)


def trace_directions(pieces: TracePieces) -> FloatArray:
    """Return the directions of pieces from start to end.

    The direction of a closed piece is that of its longest segment.

    Parameters
    ----------
    pieces : TracePieces

    Returns
    -------
    (n, 2) ndarray
        Unit vectors.
    """
    ends = pieces.ends()
    segments = ends[:, 1] - ends[:, 0]
    length = np.hypot(*segments.T)
    for i in np.flatnonzero(length <= pieces.rounding_m):
        start, end, _ = line_segments(pieces.lines[i : i + 1])
        step = end - start
        segments[i] = step[int(np.argmax(np.hypot(*step.T)))]
        length[i] = np.hypot(*segments[i])
    return np.asarray(segments / np.maximum(length, 1e-300)[:, None])


def fit_window(pieces: TracePieces, area: Any) -> Window:
    """Return the sampling window: the area and its mean width across the traces.

    Each direction is weighted by the number of ends of its traces inside the area.

    Parameters
    ----------
    pieces : TracePieces
    area : shapely Polygon

    Returns
    -------
    Window
    """
    import shapely

    weights = 2.0 - pieces.is_cut.sum(axis=1)
    if weights.sum() <= 0:
        weights = np.ones(len(pieces))
    # Group directions into classes of one degree, because there may be thousands of edges and
    # traces.
    x, y = trace_directions(pieces).T
    degree = np.round(np.degrees(np.arctan2(y, x))).astype(int) % 180
    shares = np.bincount(degree, weights, minlength=180) / weights.sum()
    angle = np.radians(np.arange(180))
    rings = shapely.get_parts(shapely.boundary(area))
    start, end, _ = line_segments(rings)
    dx, dy = (end - start).T
    crossed_widths = np.abs(np.cos(angle)[:, None] * dy - np.sin(angle)[:, None] * dx).sum(axis=1)
    return Window(float(area.area), float(shares @ crossed_widths) / 2.0)


def share_outside_hull(lines: Any, area: Any) -> float:
    """Return the share of an area that is outside the convex hull of all traces.

    Parameters
    ----------
    lines : (n,) ndarray of object
        Shapely lines.
    area : shapely Polygon

    Returns
    -------
    float
    """
    import shapely

    hull = shapely.convex_hull(shapely.multilinestrings(shapely.get_parts(lines)))
    return 1.0 - float(shapely.area(shapely.intersection(area, hull)) / shapely.area(area))


def intensity_by_size(pieces: TracePieces, area: Any) -> tuple[IntensityAtSize, ...]:
    """Compute P21 in circles of increasing size.

    The sizes range from one that contains a few traces to the largest that fits into the area. For
    each size, up to 64 circles are placed on a regular grid.

    Parameters
    ----------
    pieces : TracePieces
    area : shapely Polygon

    Returns
    -------
    tuple of IntensityAtSize
        Empty if there are no traces, or if no circle fits into the area.
    """
    import shapely

    if not len(pieces):
        return ()
    max_radius = shapely.length(shapely.maximum_inscribed_circle(area, tolerance=_tolerance(area)))
    mean_spacing = float(area.area) / max(float(pieces.lengths().sum()), 1e-300)
    radii = np.geomspace(min(2 * mean_spacing, 0.25 * max_radius), 0.95 * max_radius, N_SIZES)
    start, end, _ = line_segments(pieces.lines)
    tree = shapely.STRtree(shapely.linestrings(np.stack([start, end], axis=1)))
    intensities = []
    for radius in radii:
        centres = _circle_centres(area, float(radius))
        if not len(centres):
            continue
        boxes = shapely.box(*(centres - radius).T, *(centres + radius).T)
        circle_row, segment = tree.query(boxes)
        lengths_inside = _length_in_circle(
            start[segment], end[segment], centres[circle_row], float(radius)
        )
        values = np.bincount(circle_row, lengths_inside, minlength=len(centres)) / (
            math.pi * radius**2
        )
        intensities.append(
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
    return tuple(intensities)


def _tolerance(area: Any) -> float:
    return 1e-3 * math.sqrt(float(area.area))


def _circle_centres(area: Any, radius: float) -> FloatArray:
    """Return the centres (k, 2) of up to 64 circles that fit into the area."""
    import shapely

    centre_area = area.buffer(-radius)
    if centre_area.is_empty:
        return np.zeros((0, 2))
    low_x, low_y, high_x, high_y = centre_area.bounds
    spacing = max(math.sqrt(float(centre_area.area) / MAX_CIRCLES), 1e-9)
    while True:
        x, y = (
            np.linspace(low, high, max(int((high - low) / spacing), 0) + 2)[1:-1]
            if high - low > spacing
            else np.array([(low + high) / 2])
            for low, high in ((low_x, high_x), (low_y, high_y))
        )
        grid = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        shapely.prepare(centre_area)
        centres = grid[shapely.contains_xy(centre_area, grid[:, 0], grid[:, 1])]
        if len(centres) <= MAX_CIRCLES:
            break
        spacing *= 1.1
    if len(centres):
        return np.asarray(centres)
    point = shapely.point_on_surface(centre_area)
    return np.array([[point.x, point.y]])


def _length_in_circle(
    start: FloatArray, end: FloatArray, centre: FloatArray, radius: float
) -> FloatArray:
    """Return the lengths (k,) of segments inside circles, pair by pair."""
    segments = end - start
    length = np.hypot(*segments.T)
    unit = segments / np.maximum(length, 1e-300)[:, None]
    centre_offsets = centre - start
    chord_midpoint = np.einsum("ij,ij->i", centre_offsets, unit)
    squared_distance = np.einsum("ij,ij->i", centre_offsets, centre_offsets) - chord_midpoint**2
    half_chord = np.sqrt(np.maximum(radius**2 - squared_distance, 0.0))
    lengths_inside = np.minimum(chord_midpoint + half_chord, length) - np.maximum(
        chord_midpoint - half_chord, 0.0
    )
    return np.asarray(np.where(half_chord > 0, np.maximum(lengths_inside, 0.0), 0.0))
