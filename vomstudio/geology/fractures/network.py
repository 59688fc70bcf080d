"""Figures of a fracture trace map, for `vomstudio fractures`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray, ObjectArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.results import OPTIONAL_IN_JSON
from vomstudio.geology.fractures.intervals import (
    UNKNOWN_INTERVAL,
    Interval,
    area_dispersion,
    density_interval,
    empty_interval,
)
from vomstudio.geology.fractures.length_laws import (
    MIN_COMPLETE_TRACES,
    LengthFit,
    Parameter,
    fit_laws,
)
from vomstudio.geology.fractures.nodes import NodeCounts, SnappedEnd, find_nodes
from vomstudio.geology.fractures.pieces import TracePieces, clip_traces
from vomstudio.geology.fractures.scanlines import (
    Crossings,
    Spacing,
    axial_mean_deg,
    find_crossings,
    measure_spacing,
)
from vomstudio.geology.fractures.trace_plane import TracePlane, trace_azimuths_deg
from vomstudio.geology.fractures.windows import (
    MAX_UNMAPPED_SHARE,
    CircleEstimates,
    IntensityAtSize,
    circle_estimates,
    fit_window,
    intensity_by_size,
    mean_length_from_ends,
    share_outside_hull,
    trace_directions,
)

UNASSIGNED = "unassigned"


@dataclass(frozen=True)
class SamplingRegion:
    """Region in which the traces are counted.

    Attributes
    ----------
    area : shapely polygon or None
    circle : (float, float, float) or None
        x, y and radius in metres if the area is a circle.
    scanlines : (k,) ndarray of shapely lines, or None
    warnings : tuple of Finding
        Problems with the area as drawn.
    """

    area: Any = None
    circle: tuple[float, float, float] | None = None
    scanlines: ObjectArray | None = None
    warnings: tuple[Finding, ...] = ()


@dataclass(frozen=True)
class Densities:
    """P20, node-based P20 and P21 of the traces in an area, with their 95 % intervals.

    The dispersion is the variance of P21 relative to that of independent traces. All values are
    None if there is no area.
    """

    P20_1_per_m2: float | None = None
    P20_95_1_per_m2: Interval = UNKNOWN_INTERVAL
    P20_nodes_1_per_m2: float | None = None
    P20_nodes_95_1_per_m2: Interval = UNKNOWN_INTERVAL
    P21_1_per_m: float | None = None
    P21_95_1_per_m: Interval = UNKNOWN_INTERVAL
    dispersion: float | None = None


@dataclass(frozen=True)
class TraceLengths:
    """Statistics of trace lengths.

    Attributes
    ----------
    mean_m, mean_95_m
        Mean length of complete traces in metres with its 95 % interval, corrected for the edge of
        the area (see `windows.mean_length_from_ends`).
    naive_mean_m : float or None
        Mean length of the pieces, m.
    censored_share : float or None
        Share of the pieces that end at the edge of the area.
    kaplan_meier_mean_m, kaplan_meier_median_m : float or None
        Estimates for the pieces as randomly censored lengths, with the mean restricted to the
        longest length, m.
    distribution, parameters, parameters_95
        Law with the lowest AIC; if the edge of the area cuts pieces, the likelihood is that of a
        window.
    fits : tuple of LengthFit
        Fits of all laws.
    uncorrected : tuple of LengthFit
        Fits for randomly censored lengths, which overestimate the lengths in a window; empty if no
        piece is cut.
    reason : Finding or None
        Reason why no law was fitted.
    """

    n: int
    mean_m: float | None
    mean_95_m: tuple[float | None, float | None]
    naive_mean_m: float | None
    longest_m: float | None
    censored_share: float | None
    kaplan_meier_mean_m: float | None
    kaplan_meier_median_m: float | None
    distribution: str | None
    parameters: Mapping[str, float]
    parameters_95: Mapping[str, tuple[float | None, float | None]]
    fits: tuple[LengthFit, ...]
    uncorrected: tuple[LengthFit, ...]
    reason: Finding | None


@dataclass(frozen=True)
class FractureSet:
    """Figures of a set of n trace pieces.

    `strike_deg` is the length-weighted mean azimuth, 0 to 180 degrees (None if undefined), and
    `resultant` its resultant length.
    Densities and their 95 % intervals are those of `Densities`, or None if there is no area.
    `spacing` is None if there is no scanline.
    """

    name: str
    n: int
    strike_deg: float | None
    resultant: float
    length_m: float
    P20_1_per_m2: float | None
    P20_95_1_per_m2: Interval
    P21_1_per_m: float | None
    P21_95_1_per_m: Interval
    spacing: Spacing | None


@dataclass(frozen=True, repr=False)
class FractureNetwork(PrintableResult):
    """Figures of a fracture network as described in docs/cli.md.

    Figures that cannot be computed are None.
    `P21_unclipped_1_per_m` includes the parts of traces outside the area and is therefore too
    large. Names that contain 95 denote 95 % intervals. `plane` is the plane on which
    three-dimensional traces were analysed, or None for a map.
    """

    traces: int
    pieces: int
    area_m2: float | None
    P10_1_per_m: float | None
    P10_95_1_per_m: Interval
    P20_1_per_m2: float | None
    P20_95_1_per_m2: Interval
    P20_nodes_1_per_m2: float | None
    P20_nodes_95_1_per_m2: Interval
    P21_1_per_m: float | None
    P21_95_1_per_m: Interval
    P21_unclipped_1_per_m: float | None
    dispersion: float | None
    nodes: NodeCounts
    mended: tuple[SnappedEnd, ...]
    snap_m: float
    length: TraceLengths
    sets: tuple[FractureSet, ...]
    P21_by_size: tuple[IntensityAtSize, ...]
    circle: CircleEstimates | None
    scanline: Spacing | None
    scanline_m: float | None
    terzaghi_cap: float | None
    warnings: tuple[Finding, ...]
    notes: tuple[Finding, ...]
    plane: TracePlane | None = field(default=None, metadata=OPTIONAL_IN_JSON)


@dataclass(frozen=True, eq=False)
class MappedNetwork:
    """Figures of a fracture network and the trace pieces that they describe, for plots.

    `y_axis` is the direction of y: north, y of a local frame, or up in a picture of a face.
    """

    statistics: FractureNetwork
    region: SamplingRegion
    pieces: TracePieces
    sets: tuple[str, ...]
    set_indices: IntArray
    y_axis: Literal["N", "y", "up"] = "N"


def fracture_network(
    lines: ObjectArray,
    sampling_region: SamplingRegion | None = None,
    *,
    sets: Sequence[str] | None = None,
    snap_m: float = 0.0,
    terzaghi_cap: float | None = None,
    warnings: Sequence[Finding] = (),
    plane: TracePlane | None = None,
) -> MappedNetwork:
    """Compute the figures of a network of fracture traces.

    Parameters
    ----------
    lines : (n,) ndarray of shapely lines
        Traces in metres, with x East and y North.
    sampling_region : SamplingRegion, optional
    sets : (n,) sequence of str, optional
        Set of each trace; "" if it belongs to none.
    snap_m : float
        Maximum distance between the end of a trace and the trace that it abuts, m.
    terzaghi_cap : float, optional
        Maximum Terzaghi weight.
    warnings : sequence of Finding
    plane : TracePlane, optional
        Plane of three-dimensional traces; x and y are coordinates on this plane.

    Returns
    -------
    MappedNetwork

    Raises
    ------
    GeometryError
        If the area is empty or lies outside the map, or if the scanlines have no length.
    """
    import shapely

    sampling_region = sampling_region or SamplingRegion()
    findings = [*warnings, *sampling_region.warnings]
    _check_inputs(lines, sampling_region)
    area = sampling_region.area
    pieces = clip_traces(lines, area, snap_m)
    nodes = find_nodes(pieces, snap_m, area)
    findings += _warnings(lines, pieces, nodes.overlaps, nodes.counts.other)
    crossings = None
    if sampling_region.scanlines is not None:
        crossings = find_crossings(lines, sampling_region.scanlines, terzaghi_cap)
        if not len(crossings.trace):
            findings.append(Finding("fractures.scanline-without-traces"))
        if crossings.capped:
            findings.append(
                Finding("fractures.weights-capped", count=crossings.capped, maximum=terzaghi_cap)
            )
    names, set_indices = _set_indices(sets, len(lines))
    size = None if area is None else float(shapely.area(area))
    spacing = None
    if crossings is not None:
        is_crossing = np.ones(len(crossings.trace), np.bool_)
        spacing = measure_spacing(crossings, is_crossing, terzaghi_cap)
    densities = trace_densities(pieces, np.ones(len(pieces), np.bool_), area)
    network = FractureNetwork(
        traces=len(lines),
        pieces=len(pieces),
        area_m2=size,
        P10_1_per_m=None if spacing is None else spacing.P10_1_per_m,
        P10_95_1_per_m=UNKNOWN_INTERVAL if spacing is None else spacing.P10_95_1_per_m,
        P20_1_per_m2=densities.P20_1_per_m2,
        P20_95_1_per_m2=densities.P20_95_1_per_m2,
        P20_nodes_1_per_m2=None if size is None else (nodes.counts.I + nodes.counts.Y) / 2 / size,
        P20_nodes_95_1_per_m2=densities.P20_nodes_95_1_per_m2,
        P21_1_per_m=densities.P21_1_per_m,
        P21_95_1_per_m=densities.P21_95_1_per_m,
        P21_unclipped_1_per_m=None if size is None else float(shapely.length(lines).sum()) / size,
        dispersion=densities.dispersion,
        nodes=nodes.counts,
        mended=nodes.mended,
        snap_m=snap_m,
        length=describe_lengths(pieces, area),
        sets=_describe_sets(names, set_indices, pieces, area, crossings, terzaghi_cap, plane),
        P21_by_size=() if area is None else intensity_by_size(pieces, area),
        circle=None
        if sampling_region.circle is None
        else circle_estimates(pieces, sampling_region.circle[2]),
        scanline=spacing,
        scanline_m=None if crossings is None else crossings.length_m,
        terzaghi_cap=terzaghi_cap,
        warnings=tuple(findings),
        notes=(
            Finding("fractures.one-face"),
            *_coverage_note(lines, area),
        ),
        plane=plane,
    )
    return MappedNetwork(network, sampling_region, pieces, names, set_indices[pieces.trace])


def _coverage_note(lines: ObjectArray, area: Any) -> list[Finding]:
    """Report that a large part of the area may not have been mapped."""
    outside_share = 0.0 if area is None else share_outside_hull(lines, area)
    if outside_share <= MAX_UNMAPPED_SHARE:
        return []
    return [Finding("fractures.area-beyond-traces", share_percent=100.0 * outside_share)]


def describe_lengths(pieces: TracePieces, area: Any = None) -> TraceLengths:
    """Describe the trace lengths of the pieces in an area.

    Without an area, no length is censored.

    Parameters
    ----------
    pieces : TracePieces
    area : shapely Polygon, optional

    Returns
    -------
    TraceLengths
    """
    lengths, cut_counts = pieces.lengths(), pieces.is_cut.sum(axis=1)
    n = len(lengths)
    if not n:
        empty_reason = Finding("fractures.no-traces")
        return TraceLengths(0, None, (None, None), *(None,) * 6, {}, {}, (), (), empty_reason)
    window = None if area is None or not cut_counts.any() else fit_window(pieces, area)
    uncorrected = fit_laws(lengths, cut_counts)
    fits = uncorrected if window is None else fit_laws(lengths, cut_counts, window)
    mean = mean_length_from_ends(lengths, cut_counts.astype(np.float64))
    km_mean, km_median = kaplan_meier(lengths, cut_counts > 0)
    best_fit = fits[0] if fits else None
    reason = None
    if best_fit is None:
        reason = Finding("fractures.few-lengths", minimum=MIN_COMPLETE_TRACES)
    return TraceLengths(
        n=n,
        mean_m=mean.value if mean else None,
        mean_95_m=_limits(mean) if mean else (None, None),
        naive_mean_m=float(lengths.mean()),
        longest_m=float(lengths.max()),
        censored_share=float((cut_counts > 0).mean()),
        kaplan_meier_mean_m=km_mean,
        kaplan_meier_median_m=km_median,
        distribution=best_fit.distribution if best_fit else None,
        parameters={k: parameter.value for k, parameter in best_fit.parameters.items()}
        if best_fit
        else {},
        parameters_95={k: _limits(parameter) for k, parameter in best_fit.parameters.items()}
        if best_fit
        else {},
        fits=tuple(fits),
        uncorrected=tuple(uncorrected) if window is not None else (),
        reason=reason,
    )


def kaplan_meier(lengths: FloatArray, is_censored: BoolArray) -> tuple[float | None, float | None]:
    """Estimate the mean and median of censored lengths (Kaplan & Meier 1958).

    Parameters
    ----------
    lengths : (n,) ndarray
    is_censored : (n,) ndarray of bool

    Returns
    -------
    mean : float or None
        Mean restricted to the longest length.
    median : float or None
        None if the survival does not decrease to one half. Without complete lengths, both values
        are undefined (None).
    """
    from scipy.stats import CensoredData, ecdf

    if is_censored.all():
        return None, None
    survival = ecdf(CensoredData.right_censored(lengths, is_censored)).sf
    steps = np.concatenate([[0.0], survival.quantiles])
    probabilities = np.concatenate([[1.0], survival.probabilities])
    mean = float(np.sum(np.diff(steps) * probabilities[:-1]))
    rows_below_half = np.flatnonzero(survival.probabilities <= 0.5)
    return mean, float(survival.quantiles[rows_below_half[0]]) if len(rows_below_half) else None


def _limits(parameter: Parameter) -> tuple[float | None, float | None]:
    return parameter.low, parameter.high


def _check_inputs(lines: ObjectArray, sampling_region: SamplingRegion) -> None:
    import shapely

    if (
        sampling_region.scanlines is not None
        and not float(shapely.length(sampling_region.scanlines).sum()) > 0
    ):
        raise GeometryError(Finding("fractures.scanline-without-length"), field="--scanline")
    if sampling_region.area is None:
        return
    if not shapely.area(sampling_region.area) > 0:
        raise GeometryError(Finding("fractures.area-without-size"))
    if not shapely.intersects(shapely.box(*shapely.total_bounds(lines)), sampling_region.area):
        raise GeometryError(Finding("fractures.area-elsewhere"))


def _warnings(
    lines: ObjectArray, pieces: TracePieces, overlaps: int, other_count: int
) -> list[Finding]:
    import shapely

    warnings = []
    if not len(pieces):
        warnings.append(Finding("fractures.no-traces"))
    self_crossing_rows = np.flatnonzero(~shapely.is_simple(lines))
    if len(self_crossing_rows):
        warnings.append(
            Finding(
                "fractures.self-crossing",
                count=len(self_crossing_rows),
                rows=(self_crossing_rows + 1).tolist(),
            )
        )
    if overlaps:
        warnings.append(Finding("fractures.overlaps", count=overlaps))
    if other_count:
        warnings.append(Finding("fractures.other-nodes", count=other_count))
    return warnings


def trace_densities(pieces: TracePieces, is_member: BoolArray, area: Any) -> Densities:
    """Return the densities of the pieces of one set in an area.

    Parameters
    ----------
    pieces : TracePieces
    is_member : (n,) ndarray of bool
        True for pieces of the set.
    area : shapely Polygon or None

    Returns
    -------
    Densities
    """
    import shapely

    if area is None:
        return Densities()
    size = float(shapely.area(area))
    lengths = pieces.lengths()[is_member]
    ends = 2.0 - pieces.is_cut[is_member].sum(axis=1)
    if not len(lengths):
        empty = empty_interval(size)
        return Densities(0.0, empty, 0.0, empty, 0.0, (0.0, None), 1.0)
    rows = np.unique(pieces.trace[is_member], return_inverse=True)[1]
    centres = shapely.get_coordinates(shapely.centroid(pieces.lines[is_member]))
    # The pieces of a trace are counted once, at their mean position.
    positions = np.stack([np.bincount(rows, xy) for xy in centres.T], axis=-1).astype(np.float64)
    positions /= np.bincount(rows)[:, None]

    def density(weights: FloatArray) -> tuple[float, Interval, float]:
        weights_by_trace = np.bincount(rows, weights).astype(np.float64)
        dispersion = area_dispersion(positions, weights_by_trace, area)
        interval = density_interval(weights_by_trace, size, dispersion)
        return float(weights.sum()) / size, interval, dispersion

    trace_density, trace_density_95, _ = density(np.ones(len(lengths)))
    node_density, node_density_95, _ = density(ends / 2.0)
    intensity, intensity_95, dispersion = density(lengths)
    return Densities(
        trace_density,
        trace_density_95,
        node_density,
        node_density_95,
        intensity,
        intensity_95,
        dispersion,
    )


def _set_indices(sets: Sequence[str] | None, n: int) -> tuple[tuple[str, ...], IntArray]:
    """Return the set names in order of appearance (unassigned last) and the set of each trace."""
    if sets is None:
        return ("all",), np.zeros(n, np.int64)
    set_names = [name or UNASSIGNED for name in sets]
    names = list(dict.fromkeys(set_names))
    if UNASSIGNED in names:
        names.remove(UNASSIGNED)
        names.append(UNASSIGNED)
    row = {name: i for i, name in enumerate(names)}
    return tuple(names), np.array([row[name] for name in set_names], np.int64)


def _describe_sets(
    names: tuple[str, ...],
    set_indices: IntArray,
    pieces: TracePieces,
    area: Any,
    crossings: Crossings | None,
    max_weight: float | None,
    plane: TracePlane | None,
) -> tuple[FractureSet, ...]:
    azimuth, lengths = trace_azimuths_deg(trace_directions(pieces), plane), pieces.lengths()
    piece_sets = set_indices[pieces.trace]
    figures = []
    for i, name in enumerate(names):
        is_member = piece_sets == i
        strike, resultant = axial_mean_deg(azimuth[is_member], lengths[is_member])
        spacing = None
        if crossings is not None:
            spacing = measure_spacing(crossings, set_indices[crossings.trace] == i, max_weight)
        densities = trace_densities(pieces, is_member, area)
        figures.append(
            FractureSet(
                name=name,
                n=int(is_member.sum()),
                strike_deg=strike,
                resultant=resultant,
                length_m=float(lengths[is_member].sum()),
                P20_1_per_m2=densities.P20_1_per_m2,
                P20_95_1_per_m2=densities.P20_95_1_per_m2,
                P21_1_per_m=densities.P21_1_per_m,
                P21_95_1_per_m=densities.P21_95_1_per_m,
                spacing=spacing,
            )
        )
    return tuple(figures)
