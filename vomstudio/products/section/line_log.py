"""Log along a line of a project, bounded by points on it or by traces across it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geology.beds.log_options import LogOptions
from vomstudio.geology.orientation import Plane, angle_between_planes
from vomstudio.project.bed_descriptions import POINT_PREFIX
from vomstudio.project.measurement import Measurement, common_error_deg, pick_scatter_m
from vomstudio.project.records import Feature, LoggedFeature

if TYPE_CHECKING:
    from vomstudio.geology.beds.bed_log import BedLog


POINTS, TRACES, BOTH = "points", "traces", "both"
_DEFAULT_REACH_SHARE = 0.05
"""Default maximum distance of a trace from the line, as a share of the line's length."""
_MAX_DEVIATING_SHARE = 0.2
"""Maximum share of traces whose planes differ from the common plane beyond 95 % errors."""
_ROUNDING_DEG = 0.1
"""Tolerance for rounding errors of traces without scatter."""
_MAX_BEDDING_ERROR_DEG = 10.0
"""Maximum error of the bedding; larger ones dominate the error of a thickness."""


@dataclass(frozen=True)
class RockDescription:
    """Lithology and notes of a bed, stored at the boundary at which the bed begins."""

    lithology: str = ""
    notes: str = ""


@dataclass(frozen=True, eq=False)
class LogRequest:
    """Input of a log along a line.

    Parameters
    ----------
    line_id : str
    line : Measurement
        Line with points (n, 3) in the World frame.
    of : {"points", "traces", "both"}
        Source of the boundaries of the log.
    traces, names : mappings
        Measured traces and their names, by id.
    bed : Plane or None
        Attitude of the beds. If None, it is fitted to the traces.
    options : LogOptions
    reach_m : float or None
        Maximum distance of a trace from the line. If None, the default is used.
    words : mapping
        Lithology and notes (RockDescription) by the key of their boundary.
    is_metric : bool
        Whether lengths are in metres.
    overturned_ids : frozenset of str
        Ids of traces whose bed is marked as overturned.
    """

    line_id: str
    line: Measurement
    of: str
    traces: Mapping[str, Measurement]
    names: Mapping[str, str]
    bed: Plane | None
    options: LogOptions
    reach_m: float | None
    words: Mapping[str, RockDescription]
    is_metric: bool
    overturned_ids: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Boundary:
    """Boundary of an interval of a log along a line.

    Attributes
    ----------
    key : str
        Id of a trace, or `POINT_PREFIX` and the index of a point of the line.
    name : str
        Name of the trace or point.
    position : (float, float, float)
        Position in the World frame, m.
    """

    key: str
    name: str
    position: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class LogResult:
    """Log along a line, with the boundaries and the bedding used.

    Attributes
    ----------
    boundaries : tuple of Boundary
        Boundaries in their order along the line.
    base_keys : tuple of str
        Key of the boundary at the base of each interval.
    bed_ids : tuple of str
        Ids of the traces to which the bedding was fitted.
    """

    request: LogRequest
    boundaries: tuple[Boundary, ...]
    bed: Plane
    bed95_deg: float
    sigma_m: float
    reach_m: float
    log: BedLog
    base_keys: tuple[str, ...]
    bed_ids: tuple[str, ...]


def read_rock_descriptions(line: Feature) -> dict[str, RockDescription]:
    """Return the lithology and notes of the beds along a line, by boundary key."""
    beds = line.beds if isinstance(line, LoggedFeature) else ()
    return {key: RockDescription(lithology, notes) for key, lithology, notes in beds}


def compute_log(request: LogRequest) -> LogResult:
    """Compute a log along a line, as `vomstudio log` does. Raises VomError."""
    from vomstudio.geology.beds.bed_log import bed_log

    max_distance = _max_distance(request)
    boundaries = _boundaries(request, max_distance)
    bed = _determine_bedding(request, boundaries, max_distance)
    sigma = request.options.sigma_m
    if sigma is None:
        crossing_traces = [
            request.traces[boundary.key]
            for boundary in boundaries
            if boundary.key in request.traces
        ]
        # The line itself follows the face, so its deviation from a plane is not an error.
        sigma = pick_scatter_m([replace(request.line, fit=None), *crossing_traces])
    # Intervals refer to their boundaries by name, so the names must be unique.
    labels = unique_names([boundary.name for boundary in boundaries])
    descriptions = [request.words.get(boundary.key, RockDescription()) for boundary in boundaries]
    log = bed_log(
        [boundary.position for boundary in boundaries],
        bed.plane,
        names=labels,
        lithologies=[word.lithology for word in descriptions],
        notes=[word.notes for word in descriptions],
        sigma_m=sigma,
        bed_error_deg=bed.error95_deg,
        overturned=request.options.overturned,
    )
    if not bed.are_parallel or bed.fit95_deg > _MAX_BEDDING_ERROR_DEG:
        warning = Finding("log.beds-not-parallel", count=len(bed.ids), error_deg=bed.fit95_deg)
        log = replace(log, warnings=(*log.warnings, warning))
    overturned = sum(boundary.key in request.overturned_ids for boundary in boundaries)
    if overturned and not request.options.overturned:
        warning = Finding("log.overturned-beds", count=overturned)
        log = replace(log, warnings=(*log.warnings, warning))
    keys = dict(zip(labels, (boundary.key for boundary in boundaries), strict=True))
    bases = tuple(keys[interval.base] for interval in log.intervals)
    return LogResult(
        request,
        tuple(boundaries),
        bed.plane,
        bed.error95_deg,
        sigma,
        max_distance,
        log,
        bases,
        bed.ids,
    )


def _max_distance(request: LogRequest) -> float:
    from vomstudio.geometry.lines import path_length

    return (
        _DEFAULT_REACH_SHARE * path_length(request.line.points)
        if request.reach_m is None
        else request.reach_m
    )


def _boundaries(request: LogRequest, max_distance: float) -> list[Boundary]:
    """Find the boundaries in order along the line.

    Raises InputError if there are fewer than two.
    """
    from vomstudio.geology.beds.log_boundaries import crossings

    boundaries: list[tuple[float, Boundary]] = []
    points = request.line.points
    if request.of in (POINTS, BOTH):
        distances_along = np.concatenate(
            [[0.0], np.linalg.norm(np.diff(points, axis=0), axis=1).cumsum()]
        )
        for i, (position, point) in enumerate(
            zip(distances_along.tolist(), points.tolist(), strict=True)
        ):
            key = f"{POINT_PREFIX}{i}"
            boundaries.append((position, Boundary(key, str(i + 1), (point[0], point[1], point[2]))))
    if request.of in (TRACES, BOTH):
        traces = {
            id_: measurement.points
            for id_, measurement in request.traces.items()
            if id_ != request.line_id
        }
        for crossing in crossings(points, traces, max_distance):
            x, y, z = crossing.position.tolist()
            name = request.names[crossing.name]
            boundaries.append((crossing.position_m, Boundary(crossing.name, name, (x, y, z))))
    if len(boundaries) < 2:
        unit = "m" if request.is_metric else tr("units")
        raise InputError(
            Finding("log.too-few-boundaries", count=len(boundaries), reach=max_distance, unit=unit)
        )
    return [boundary for _, boundary in sorted(boundaries, key=lambda pair: pair[0])]


class _Bed(NamedTuple):
    """Attitude of the beds.

    Attributes
    ----------
    error95_deg, fit95_deg : float
        Total 95 % error, and 95 % error of the fit alone.
    ids : tuple of str
        Ids of the traces to which the plane is fitted.
    are_parallel : bool
        Whether these traces are parallel.
    """

    plane: Plane
    error95_deg: float
    fit95_deg: float = 0.0
    ids: tuple[str, ...] = ()
    are_parallel: bool = True


def _determine_bedding(
    request: LogRequest, boundaries: list[Boundary], max_distance: float
) -> _Bed:
    """Determine the attitude of the beds.

    It is the plane given by the user, if any. Otherwise it is fitted to the traces that are
    boundaries or, if no trace is a boundary, to the traces near the line.

    Raises
    ------
    InputError, GeometryError
        If no traces are near the line, or if these do not determine a plane.
    """
    from vomstudio.geology.beds.common_attitude import fit_common_bed

    if request.bed is not None:
        return _Bed(request.bed, request.options.bed_error_deg or 0.0)
    ids = [
        boundary.key for boundary in boundaries if boundary.key in request.traces
    ] or _find_near_traces(request, max_distance)
    if not ids:
        raise InputError(Finding("log.no-bedding"))
    common_bed = fit_common_bed([request.traces[id_].points for id_ in ids])
    fit95 = common_bed.max_confidence95_deg or 0.0
    deviating_count = sum(
        _is_deviating(request.traces[id_], common_bed.plane, fit95) for id_ in ids
    )
    are_parallel = common_bed.are_parallel and deviating_count <= _MAX_DEVIATING_SHARE * len(ids)
    error = common_error_deg(fit95, (request.traces[id_] for id_ in ids)) or 0.0
    return _Bed(common_bed.plane, error, fit95, tuple(ids), are_parallel)


def _is_deviating(trace: Measurement, common_plane: Plane, error_deg: float) -> bool:
    """Return whether a trace's own plane differs from the common one beyond 95 % errors."""
    trace_error_deg = trace.max_confidence95_deg
    if trace.plane is None or trace_error_deg is None:
        return False
    return (
        angle_between_planes(trace.plane, common_plane)
        > trace_error_deg + error_deg + _ROUNDING_DEG
    )


def _find_near_traces(request: LogRequest, max_distance: float) -> list[str]:
    """Return the ids of the traces within the maximum distance of the line.

    If there are none, those within a distance equal to the length of the line are returned.
    """
    from vomstudio.geometry.lines import nearest_approach, path_length

    distance_by_id = {
        id_: nearest_approach(request.line.points, trace.points).distance
        for id_, trace in request.traces.items()
        if id_ != request.line_id and len(trace.points) > 1
    }
    for limit in (max_distance, path_length(request.line.points)):
        if near_ids := [id_ for id_, distance in distance_by_id.items() if distance <= limit]:
            return near_ids
    return []


def unique_names(names: list[str]) -> list[str]:
    """Make names unique by appending a number to repeated ones."""
    used_names: set[str] = set()
    labels = []
    for name in names:
        label, k = name, 2
        while label in used_names:
            label, k = f"{name} ({k})", k + 1
        used_names.add(label)
        labels.append(label)
    return labels
