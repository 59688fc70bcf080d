"""A log along a line of a project: its boundaries are points of the line, or traces across it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from vomstudio.document.bed_words import POINT
from vomstudio.document.measurement import Measurement, scatter_of
from vomstudio.document.records import Feature, Logged
from vomstudio.errors import InputError, VomError
from vomstudio.geology.orientation import Plane
from vomstudio.words import tr, tr_n

if TYPE_CHECKING:
    from vomstudio.geology.beds.bed_log import BedLog

Array = npt.NDArray[np.float64]

POINTS, TRACES, BOTH = "points", "traces", "both"
_REACH = 0.05
"""Of the line's length: how near a trace has to come where nothing was typed."""


@dataclass(frozen=True)
class RockWords:
    """What is said of a bed, at the boundary where it begins."""

    lithology: str = ""
    notes: str = ""


@dataclass(frozen=True, eq=False)
class LogQuestion:
    """line : (n, 3) World, and line_id of its feature; of : POINTS, TRACES or BOTH; traces :
    measured, by id, and names by id; bed : None for the one that is fitted to the traces; bed95_deg
    of it; sigma_m, reach_m : None for the likely ones; words : by the key of a boundary; marked :
    traces that say that their bed is overturned"""

    line_id: str
    line: Measurement
    of: str
    traces: Mapping[str, Measurement]
    names: Mapping[str, str]
    bed: Plane | None
    bed95_deg: float
    sigma_m: float | None
    reach_m: float | None
    overturned: bool
    words: Mapping[str, RockWords]
    metric: bool
    marked: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Boundary:
    """key : of its words: the id of a trace, or POINT and the number of the line's own point"""

    key: str
    name: str
    place: tuple[float, float, float]


@dataclass(frozen=True, eq=False)
class LogAnswer:
    """boundaries : in the order along the line; base_keys : of each interval of the log"""

    question: LogQuestion
    boundaries: tuple[Boundary, ...]
    bed: Plane
    bed95_deg: float
    sigma_m: float
    reach_m: float
    log: BedLog
    base_keys: tuple[str, ...]


def words_along(line: Feature) -> dict[str, RockWords]:
    """What the line's record says of the beds, by the key of their boundary."""
    beds = line.beds if isinstance(line, Logged) else ()
    return {key: RockWords(lithology, notes) for key, lithology, notes in beds}


def answer(question: LogQuestion) -> LogAnswer | VomError:
    """What `vomstudio log` says of these boundaries, or why it says nothing."""
    from vomstudio.geology.beds.bed_log import bed_log

    q = question
    try:
        reach = _reach(q)
        boundaries = _boundaries(q, reach)
        bed, bed95 = _bed(q, boundaries)
        sigma = q.sigma_m
        if sigma is None:
            met = [q.traces[b.key] for b in boundaries if b.key in q.traces]
            # The line itself follows the face: how it strays from a plane is no error.
            sigma = scatter_of([replace(q.line, fit=None), *met])
        # Names tell the boundaries of an interval apart, so each is another one.
        told = told_apart([b.name for b in boundaries])
        said = [q.words.get(b.key, RockWords()) for b in boundaries]
        found = bed_log(
            [b.place for b in boundaries], bed, names=told,
            lithologies=[w.lithology for w in said], notes=[w.notes for w in said],
            sigma_m=sigma, bed_error_deg=bed95, overturned=q.overturned,
        )  # fmt: skip
    except VomError as error:
        return error
    turned = sum(b.key in q.marked for b in boundaries)
    if turned and not q.overturned:
        warning = tr_n(
            "{count} of the boundaries is on a bed that is marked as overturned, and the log "
            "counts upwards. Say that the beds are overturned where younger ones lie below.",
            "{count} of the boundaries are on beds that are marked as overturned, and the log "
            "counts upwards. Say that the beds are overturned where younger ones lie below.",
            turned,
        )
        found = replace(found, warnings=(*found.warnings, warning))
    keys = dict(zip(told, (b.key for b in boundaries), strict=True))
    bases = tuple(keys[interval.base] for interval in found.intervals)
    return LogAnswer(q, tuple(boundaries), bed, bed95, sigma, reach, found, bases)


def _reach(q: LogQuestion) -> float:
    from vomstudio.geometry.lines import path_length

    return _REACH * path_length(q.line.points) if q.reach_m is None else q.reach_m


def _boundaries(q: LogQuestion, reach: float) -> list[Boundary]:
    """In the order along the line. Raises InputError where there are fewer than two."""
    from vomstudio.geology.beds.log_boundaries import crossings

    found: list[tuple[float, Boundary]] = []
    points = q.line.points
    if q.of in (POINTS, BOTH):
        along = np.concatenate([[0.0], np.linalg.norm(np.diff(points, axis=0), axis=1).cumsum()])
        for i, (at, point) in enumerate(zip(along.tolist(), points.tolist(), strict=True)):
            key = f"{POINT}{i}"
            found.append((at, Boundary(key, str(i + 1), (point[0], point[1], point[2]))))
    if q.of in (TRACES, BOTH):
        traces = {id_: m.points for id_, m in q.traces.items() if id_ != q.line_id}
        for crossing in crossings(points, traces, reach):
            x, y, z = crossing.place.tolist()
            name = q.names[crossing.name]
            found.append((crossing.along_m, Boundary(crossing.name, name, (x, y, z))))
    if len(found) < 2:
        unit = "m" if q.metric else tr("units")
        raise InputError(
            tr(
                "{count} of the traces come within {reach:.3g} {unit} of the line; a log needs two "
                "boundaries. Allow a larger distance, or take the points of the line.",
                count=len(found), reach=reach, unit=unit,
            )
        )  # fmt: skip
    return [boundary for _, boundary in sorted(found, key=lambda each: each[0])]


def _bed(q: LogQuestion, boundaries: list[Boundary]) -> tuple[Plane, float]:
    """The taken plane, else that of the traces: those that cross the line, where they count. Raises
    InputError or GeometryError."""
    from vomstudio.geology.beds.common_attitude import bed_of

    if q.bed is not None:
        return q.bed, q.bed95_deg
    ids = [b.key for b in boundaries if b.key in q.traces] or list(q.traces)
    if not ids:
        raise InputError(
            tr("Select a plane of the bedding and take it: there are no traces to fit.")
        )
    bed, error = bed_of([q.traces[id_].points for id_ in ids])
    return bed, error or 0.0


def told_apart(names: list[str]) -> list[str]:
    """Those that come again are told apart by a number."""
    taken: set[str] = set()
    told = []
    for name in names:
        said, k = name, 2
        while said in taken:
            said, k = f"{name} ({k})", k + 1
        taken.add(said)
        told.append(said)
    return told
