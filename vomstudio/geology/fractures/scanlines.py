"""Traces along scanlines: frequency and spacing, corrected for the intersection angle."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray, ObjectArray
from vomstudio.geology.fractures.intervals import (
    MIN_DISPERSION_COUNT,
    UNKNOWN_INTERVAL,
    Interval,
    are_regular,
    crossings_per_trace,
    density_interval,
    empty_interval,
    line_dispersion,
    regular_half_width,
)
from vomstudio.geology.fractures.pieces import line_segments


@dataclass(frozen=True, eq=False)
class Crossings:
    """Crossings of traces and scanlines, in order along each scanline.

    Attributes
    ----------
    trace, scanline : (n,) ndarray of int
        Row indices.
    position_m : (n,) ndarray
        Distance from the start of the scanline, m.
    angle_deg : (n,) ndarray
        Acute angle between the trace and the scanline, degrees.
    weight : (n,) ndarray
        Terzaghi's weight 1 / sin(angle), limited by the cap.
    lengths_m : (k,) ndarray
        Lengths of the scanlines, m.
    capped : int
        Number of weights that were reduced by the cap.
    overlaps : int
        Number of traces that run along a scanline.
    """

    trace: IntArray
    scanline: IntArray
    position_m: FloatArray
    angle_deg: FloatArray
    weight: FloatArray
    lengths_m: FloatArray
    capped: int
    overlaps: int

    @property
    def length_m(self) -> float:
        """Total length of all scanlines, m."""
        return float(self.lengths_m.sum())


@dataclass(frozen=True)
class Spacing:
    """Spacing of n crossings on scanlines.

    Names that contain 95 denote 95 % intervals (see `intervals`).

    Attributes
    ----------
    P10_1_per_m : float
        Number of crossings per length.
    mean_m, std_m : float or None
        Mean and standard deviation of the gaps between neighbours along the line, m; `gaps` is the
        number of gaps.
    cv : float or None
        Ratio of std_m to mean_m: near 1 for random positions, lower for regular and higher for
        clustered ones.
    true_mean_m : float or None
        Mean gap perpendicular to the traces in metres; each gap is multiplied by the mean
        sine of the angles at its two ends.
    P21_1_per_m : float
        Sum of the weights divided by the length (Terzaghi's 1965 correction), which estimates the
        trace length per area of a plane.
    dispersion : float
        Variance of the number of crossings relative to that of random crossings; below 1 only if
        the gaps are significantly regular.
    capped : int
        Number of weights that were reduced by the cap.
    """

    n: int
    gaps: int
    P10_1_per_m: float
    P10_95_1_per_m: Interval
    mean_m: float | None
    mean_95_m: Interval
    std_m: float | None
    cv: float | None
    true_mean_m: float | None
    true_mean_95_m: Interval
    P21_1_per_m: float
    P21_95_1_per_m: Interval
    dispersion: float
    capped: int


def find_crossings(
    lines: ObjectArray, scanlines: ObjectArray, max_weight: float | None = None
) -> Crossings:
    """Find the crossings of traces with scanlines.

    Traces that run along a scanline do not cross it and are counted as overlaps.

    Parameters
    ----------
    lines : (n,) ndarray of object
        Traces, as shapely lines.
    scanlines : (k,) ndarray of object
        Shapely lines.
    max_weight : float, optional
        Maximum weight. If None, weights are not limited.

    Returns
    -------
    Crossings
    """
    import shapely

    start, end, trace_of_segment = line_segments(lines)
    starts, ends, line = line_segments(scanlines)
    traces = shapely.linestrings(np.stack([start, end], axis=1))
    parts = shapely.linestrings(np.stack([starts, ends], axis=1))
    distances_before = np.zeros(len(starts))
    steps = np.hypot(*(ends - starts).T)
    for k in range(len(scanlines)):
        line_rows = np.flatnonzero(line == k)
        distances_before[line_rows] = np.cumsum(steps[line_rows]) - steps[line_rows]
    part, segment = shapely.STRtree(traces).query(parts, predicate="intersects")
    intersection_points = shapely.intersection(parts[part], traces[segment])
    is_point = shapely.get_type_id(intersection_points) == 0
    overlaps = len(np.unique(trace_of_segment[segment[~is_point]]))
    part, segment = part[is_point], segment[is_point]
    xy = shapely.get_coordinates(intersection_points[is_point])
    line_distances = distances_before[part] + np.hypot(*(xy - starts[part]).T)
    trace_vector, line_vector = end[segment] - start[segment], ends[part] - starts[part]
    cross_products = np.abs(
        trace_vector[:, 0] * line_vector[:, 1] - trace_vector[:, 1] * line_vector[:, 0]
    )
    sine = cross_products / np.maximum(np.hypot(*trace_vector.T) * np.hypot(*line_vector.T), 1e-300)
    order = np.lexsort((line_distances, line[part]))
    trace, scanline = trace_of_segment[segment][order], line[part][order]
    line_distances, sine = line_distances[order], sine[order]
    # A vertex of a trace that lies on the scanline belongs to two segments of the trace.
    is_repeated = np.zeros(len(order), np.bool_)
    for shift in range(1, min(4, len(order))):
        is_repeated[shift:] |= (
            (trace[shift:] == trace[:-shift])
            & (scanline[shift:] == scanline[:-shift])
            & (
                line_distances[shift:] - line_distances[:-shift]
                < 1e-9 * max(1.0, float(line_distances.max(initial=0.0)))
            )
        )
    trace, scanline, line_distances, sine = (
        v[~is_repeated] for v in (trace, scanline, line_distances, sine)
    )
    weight = 1.0 / np.maximum(sine, 1e-12)
    capped_count = 0
    if max_weight is not None:
        capped_count = int(np.sum(weight > max_weight))
        weight = np.minimum(weight, max_weight)
    return Crossings(
        trace,
        scanline,
        line_distances,
        np.degrees(np.arcsin(np.minimum(sine, 1.0))),
        weight,
        np.asarray(np.bincount(line, steps, minlength=len(scanlines)), np.float64),
        capped_count,
        overlaps,
    )


def measure_spacing(
    crossings: Crossings, is_member: BoolArray, max_weight: float | None = None
) -> Spacing:
    """Measure the spacing of the crossings of one set.

    Parameters
    ----------
    crossings : Crossings
    is_member : (n,) ndarray of bool
        True for crossings of the set.
    max_weight : float, optional
        Maximum weight. If None, weights are not limited.

    Returns
    -------
    Spacing
    """
    line, line_distances = crossings.scanline[is_member], crossings.position_m[is_member]
    sine = np.sin(np.radians(crossings.angle_deg[is_member]))
    is_same = line[1:] == line[:-1]
    gaps = (line_distances[1:] - line_distances[:-1])[is_same]
    true_gaps = gaps * ((sine[1:] + sine[:-1]) / 2)[is_same]
    mean = float(gaps.mean()) if len(gaps) else None
    true_mean = float(true_gaps.mean()) if len(true_gaps) else None
    std = float(gaps.std(ddof=1)) if len(gaps) > 1 else None
    cv = std / mean if std is not None and mean else None
    trace, weights = crossings.trace[is_member], crossings.weight[is_member]
    size = crossings.length_m
    frequency_95, mean_95, dispersion = _intervals(crossings, is_member, gaps, cv)
    ratio = true_mean / mean if true_mean is not None and mean else None
    weights_by_trace = np.bincount(trace, weights).astype(np.float64)
    return Spacing(
        n=len(line_distances),
        gaps=len(gaps),
        P10_1_per_m=len(line_distances) / size,
        P10_95_1_per_m=frequency_95,
        mean_m=mean,
        mean_95_m=mean_95,
        std_m=std,
        cv=cv,
        true_mean_m=true_mean,
        true_mean_95_m=_scale_interval(mean_95, ratio),
        P21_1_per_m=float(weights.sum()) / size,
        P21_95_1_per_m=density_interval(weights_by_trace, size, max(dispersion, 1.0)),
        dispersion=dispersion,
        capped=0
        if max_weight is None
        else int(np.sum(1.0 / np.maximum(sine, 1e-12) > max_weight * (1 + 1e-12))),
    )


def _intervals(
    crossings: Crossings,
    is_member: BoolArray,
    gaps: FloatArray,
    coefficient_of_variation: float | None,
) -> tuple[Interval, Interval, float]:
    """Return the intervals of frequency (1/m) and mean gap (m), and the dispersion.

    The mean gap is the reciprocal of the frequency, and so is its interval, unless the gaps are
    regular: both intervals then follow from the scatter of the gaps, as in a renewal process (Cox
    1962, Renewal theory).
    """
    line, line_distances, size = (
        crossings.scanline[is_member],
        crossings.position_m[is_member],
        crossings.length_m,
    )
    n, lines = len(line_distances), len(crossings.lengths_m)
    if not n:
        return empty_interval(size), UNKNOWN_INTERVAL, 1.0
    weights = crossings_per_trace(crossings.trace[is_member])
    # Parallel scanlines cross the same traces again, which does not add information.
    repeats = float(np.sum(weights**2)) / n
    if coefficient_of_variation is not None and are_regular(gaps, repeats):
        dof = len(gaps) / repeats
        half_width = regular_half_width(coefficient_of_variation, dof)
        mean = float(gaps.mean())
        # Each line starts and ends at a random position between two traces.
        dispersion = coefficient_of_variation**2 + lines / (6.0 * n)
        error = regular_half_width(math.sqrt(dispersion * n * repeats) * math.sqrt(dof), dof)
        frequency_95 = max(n - error, 0.0) / size, (n + error) / size
        return frequency_95, (mean * math.exp(-half_width), mean * math.exp(half_width)), dispersion
    distances_before = np.cumsum(crossings.lengths_m) - crossings.lengths_m
    dispersion = line_dispersion(distances_before[line] + line_distances, size)
    if coefficient_of_variation is not None and len(gaps) >= MIN_DISPERSION_COUNT:
        dispersion = max(dispersion, coefficient_of_variation**2)
    low, high = density_interval(weights, size, dispersion)
    if not len(gaps) or not low or not high:
        return (low, high), UNKNOWN_INTERVAL, dispersion
    return (low, high), (1.0 / high, 1.0 / low), dispersion


def _scale_interval(interval: Interval, factor: float | None) -> Interval:
    low, high = interval
    if low is None or high is None or factor is None:
        return UNKNOWN_INTERVAL
    return low * factor, high * factor


def axial_mean_deg(azimuth_deg: FloatArray, weights: FloatArray) -> tuple[float | None, float]:
    """Return the weighted axial mean of azimuths and its resultant.

    Parameters
    ----------
    azimuth_deg, weights : (n,) ndarray

    Returns
    -------
    mean : float or None
        Mean in degrees, in [0, 180); None if undefined.
    resultant : float
        Resultant length, 0 to 1.
    """
    total_weight = float(weights.sum())
    if total_weight <= 0:
        return None, 0.0
    angle = np.radians(2 * azimuth_deg)
    east, north = (
        float(weights @ np.sin(angle)) / total_weight,
        float(weights @ np.cos(angle)) / total_weight,
    )
    length = math.hypot(east, north)
    if length < 1e-9:
        return None, length
    return math.degrees(math.atan2(east, north)) / 2 % 180.0, min(length, 1.0)


def assign_ranges(azimuth_deg: FloatArray, ranges: Sequence[tuple[float, float]]) -> IntArray:
    """Return the clockwise range that contains each azimuth or its opposite.

    Parameters
    ----------
    azimuth_deg : (n,) ndarray
    ranges : sequence of tuple of float
        First and last azimuth of each range, degrees.

    Returns
    -------
    (n,) ndarray of int
        Index of the range; -1 if no range contains the azimuth.
    """
    range_indices = np.full(len(azimuth_deg), -1, np.int64)
    for i, (low, high) in enumerate(ranges):
        width = (high - low) % 180.0 or 180.0
        is_inside = (azimuth_deg - low) % 180.0 <= width
        range_indices[is_inside & (range_indices < 0)] = i
    return range_indices
