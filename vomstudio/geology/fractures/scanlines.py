"""Traces along scanlines: frequency, spacing, and what the angle of the line does to both."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray, ObjectArray
from vomstudio.geology.fractures.intervals import (
    MIN_FOR_DISPERSION,
    UNKNOWN,
    Interval,
    are_regular,
    crossings_per_trace,
    density_interval,
    empty_interval,
    line_dispersion,
    regular_half_width,
)
from vomstudio.geology.fractures.pieces import segments_of


@dataclass(frozen=True, eq=False)
class Crossings:
    """Where traces meet scanlines, in order along each.

    trace, scanline : (n,) rows; along_m : (n,) from the start of the scanline; angle_deg : (n,)
    acute, between trace and scanline; weight : (n,) Terzaghi's 1 / sin of it, no more than the cap
    where there is one; lengths_m : (k,) of the scanlines; capped : weights that the cap lowered
    """

    trace: IntArray
    scanline: IntArray
    along_m: FloatArray
    angle_deg: FloatArray
    weight: FloatArray
    lengths_m: FloatArray
    capped: int
    overlaps: int

    @property
    def length_m(self) -> float:
        """Of all scanlines together."""
        return float(self.lengths_m.sum())


@dataclass(frozen=True)
class Spacing:
    """Of n crossings on scanlines. P10_1_per_m : n over the length; mean_m, std_m : gaps between
    neighbours along the line, of which there are `gaps`; cv : their ratio, near 1 where places are
    random, below where regular, above where clustered; true_mean_m : across the traces, by the sine
    of each gap's mean angle; P21_1_per_m : sum of the weights over the length, Terzaghi's (1965)
    correction, which in a plane estimates the length of traces per area; capped : weights that were
    lowered to the cap; names with 95 : the 95 % intervals (see `intervals`); dispersion : variance
    of the number of crossings over that of random ones, below 1 only if the gaps are significantly
    regular"""

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


def crossings_of(lines: ObjectArray, scanlines: ObjectArray, cap: float | None = None) -> Crossings:
    """Where traces (n,) meet scanlines (k,). cap : the largest weight, None for none. Traces that
    run along a scanline make no crossing and are counted as overlaps."""
    import shapely

    start, end, own = segments_of(lines)
    a, b, line = segments_of(scanlines)
    traces = shapely.linestrings(np.stack([start, end], axis=1))
    parts = shapely.linestrings(np.stack([a, b], axis=1))
    before = np.zeros(len(a))
    steps = np.hypot(*(b - a).T)
    for k in range(len(scanlines)):
        mine = np.flatnonzero(line == k)
        before[mine] = np.cumsum(steps[mine]) - steps[mine]
    part, segment = shapely.STRtree(traces).query(parts, predicate="intersects")
    where = shapely.intersection(parts[part], traces[segment])
    point = shapely.get_type_id(where) == 0
    overlaps = len(np.unique(own[segment[~point]]))
    part, segment = part[point], segment[point]
    xy = shapely.get_coordinates(where[point])
    along = before[part] + np.hypot(*(xy - a[part]).T)
    one, two = end[segment] - start[segment], b[part] - a[part]
    cross = np.abs(one[:, 0] * two[:, 1] - one[:, 1] * two[:, 0])
    sine = cross / np.maximum(np.hypot(*one.T) * np.hypot(*two.T), 1e-300)
    order = np.lexsort((along, line[part]))
    trace, scanline = own[segment][order], line[part][order]
    along, sine = along[order], sine[order]
    # A vertex of the trace on the line is met by both of its segments.
    again = np.zeros(len(order), np.bool_)
    for back in range(1, min(4, len(order))):
        again[back:] |= (
            (trace[back:] == trace[:-back])
            & (scanline[back:] == scanline[:-back])
            & (along[back:] - along[:-back] < 1e-9 * max(1.0, float(along.max(initial=0.0))))
        )
    trace, scanline, along, sine = (v[~again] for v in (trace, scanline, along, sine))
    weight = 1.0 / np.maximum(sine, 1e-12)
    capped = 0
    if cap is not None:
        capped = int(np.sum(weight > cap))
        weight = np.minimum(weight, cap)
    return Crossings(
        trace,
        scanline,
        along,
        np.degrees(np.arcsin(np.minimum(sine, 1.0))),
        weight,
        np.asarray(np.bincount(line, steps, minlength=len(scanlines)), np.float64),
        capped,
        overlaps,
    )


def spacing_of(crossings: Crossings, members: BoolArray, cap: float | None = None) -> Spacing:
    """Of those crossings (n,) that are members of a set."""
    line, along = crossings.scanline[members], crossings.along_m[members]
    sine = np.sin(np.radians(crossings.angle_deg[members]))
    same = line[1:] == line[:-1]
    gaps = (along[1:] - along[:-1])[same]
    true = gaps * ((sine[1:] + sine[:-1]) / 2)[same]
    mean = float(gaps.mean()) if len(gaps) else None
    true_mean = float(true.mean()) if len(true) else None
    std = float(gaps.std(ddof=1)) if len(gaps) > 1 else None
    cv = std / mean if std is not None and mean else None
    trace, weights = crossings.trace[members], crossings.weight[members]
    size = crossings.length_m
    frequency, mean_95, dispersion = _intervals(crossings, members, gaps, cv)
    ratio = true_mean / mean if true_mean is not None and mean else None
    of_traces = np.bincount(trace, weights).astype(np.float64)
    return Spacing(
        n=len(along),
        gaps=len(gaps),
        P10_1_per_m=len(along) / size,
        P10_95_1_per_m=frequency,
        mean_m=mean,
        mean_95_m=mean_95,
        std_m=std,
        cv=cv,
        true_mean_m=true_mean,
        true_mean_95_m=_scaled(mean_95, ratio),
        P21_1_per_m=float(weights.sum()) / size,
        P21_95_1_per_m=density_interval(of_traces, size, max(dispersion, 1.0)),
        dispersion=dispersion,
        capped=0 if cap is None else int(np.sum(1.0 / np.maximum(sine, 1e-12) > cap * (1 + 1e-12))),
    )


def _intervals(
    crossings: Crossings, members: BoolArray, gaps: FloatArray, cv: float | None
) -> tuple[Interval, Interval, float]:
    """Return the intervals of the frequency, 1/m, and of the mean gap, m, and the dispersion.

    The mean gap is 1 over the frequency, and so is its interval, unless the gaps are regular: then
    both follow from the scatter of the gaps, as in a renewal process (Cox 1962, Renewal theory).
    """
    line, along, size = crossings.scanline[members], crossings.along_m[members], crossings.length_m
    n, lines = len(along), len(crossings.lengths_m)
    if not n:
        return empty_interval(size), UNKNOWN, 1.0
    weights = crossings_per_trace(crossings.trace[members])
    # Parallel scanlines meet the same traces again, which tells nothing new.
    repeats = float(np.sum(weights**2)) / n
    if cv is not None and are_regular(gaps, repeats):
        free = len(gaps) / repeats
        half = regular_half_width(cv, free)
        mean = float(gaps.mean())
        # Each line begins and ends at any place between two traces.
        dispersion = cv**2 + lines / (6.0 * n)
        error = regular_half_width(math.sqrt(dispersion * n * repeats) * math.sqrt(free), free)
        frequency = max(n - error, 0.0) / size, (n + error) / size
        return frequency, (mean * math.exp(-half), mean * math.exp(half)), dispersion
    before = np.cumsum(crossings.lengths_m) - crossings.lengths_m
    dispersion = line_dispersion(before[line] + along, size)
    if cv is not None and len(gaps) >= MIN_FOR_DISPERSION:
        dispersion = max(dispersion, cv**2)
    low, high = density_interval(weights, size, dispersion)
    if not len(gaps) or not low or not high:
        return (low, high), UNKNOWN, dispersion
    return (low, high), (1.0 / high, 1.0 / low), dispersion


def _scaled(interval: Interval, factor: float | None) -> Interval:
    low, high = interval
    if low is None or high is None or factor is None:
        return UNKNOWN
    return low * factor, high * factor


def axial_mean_deg(azimuth_deg: FloatArray, weights: FloatArray) -> tuple[float | None, float]:
    """Mean of azimuths whose two ends are alike, 0 to 180, and its resultant, 0 to 1."""
    total = float(weights.sum())
    if total <= 0:
        return None, 0.0
    turn = np.radians(2 * azimuth_deg)
    east, north = float(weights @ np.sin(turn)) / total, float(weights @ np.cos(turn)) / total
    length = math.hypot(east, north)
    if length < 1e-9:
        return None, length
    return math.degrees(math.atan2(east, north)) / 2 % 180.0, min(length, 1.0)


def in_ranges(azimuth_deg: FloatArray, ranges: Sequence[tuple[float, float]]) -> IntArray:
    """(n,) the range, clockwise, that holds each azimuth or its opposite; -1 where none does."""
    found = np.full(len(azimuth_deg), -1, np.int64)
    for i, (low, high) in enumerate(ranges):
        width = (high - low) % 180.0 or 180.0
        held = (azimuth_deg - low) % 180.0 <= width
        found[held & (found < 0)] = i
    return found
