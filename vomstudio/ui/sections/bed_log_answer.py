"""What the panel of logs asks, worked out in a thread, as the command does."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from vomstudio.document.measurement import Measurement
from vomstudio.errors import InputError, VomError
from vomstudio.files.atomic import atomic_write, write_bytes
from vomstudio.files.spreadsheet_cells import guarded
from vomstudio.geology.orientation import Plane
from vomstudio.ui.forms.copied_command import Word, Words, numbers_text
from vomstudio.ui.forms.error_fields import scatter_of
from vomstudio.words import tr

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
    of it; sigma_m, reach_m : None for the likely ones; words : by the key of a boundary"""

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


@dataclass(frozen=True)
class Boundary:
    """key : of its words: the id of a trace, or that of the line with the number of its point"""

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


def answer(question: LogQuestion) -> LogAnswer | VomError:
    """In a thread: what `vomstudio log` says of these boundaries."""
    from vomstudio.geology.beds.bed_log import bed_log

    q = question
    try:
        reach = _reach(q)
        boundaries = _boundaries(q, reach)
        bed, bed95 = _bed(q, boundaries)
        sigma = q.sigma_m
        if sigma is None:
            met = [q.traces[b.key] for b in boundaries if b.key in q.traces]
            sigma = scatter_of([q.line, *met])
        # Names tell the boundaries of an interval apart, so each is another one.
        told = _each_another([b.name for b in boundaries])
        said = [q.words.get(b.key, RockWords()) for b in boundaries]
        found = bed_log(
            [b.place for b in boundaries], bed, names=told,
            lithologies=[w.lithology for w in said], notes=[w.notes for w in said],
            sigma_m=sigma, bed_error_deg=bed95, overturned=q.overturned,
        )  # fmt: skip
    except VomError as error:
        return error
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
            key = f"{q.line_id}#{i}"
            found.append((at, Boundary(key, str(i + 1), (point[0], point[1], point[2]))))
    if q.of in (TRACES, BOTH):
        traces = {id_: m.points for id_, m in q.traces.items() if id_ != q.line_id}
        for crossing in crossings(points, traces, reach):
            x, y, z = crossing.place.tolist()
            name = q.names[crossing.name]
            found.append((crossing.along_m, Boundary(crossing.name, name, (x, y, z))))
    unit = "m" if q.metric else tr("units")
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


def _each_another(names: list[str]) -> list[str]:
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


# --- what is taken away ---------------------------------------------------------------------------
def draw_figure(answered: LogAnswer, dpi: float = 130.0) -> bytes:
    """In a thread: the figure as PNG."""
    file = io.BytesIO()
    _write_figure(answered, file, "png", dpi)
    return file.getvalue()


def write(answered: LogAnswer, path: Path) -> VomError | None:
    """In a thread: the table, or the figure, by the ending; in place of what is there."""
    from vomstudio.tables.log_table import about_log, write_log

    ending = path.suffix.lower().removeprefix(".")
    try:
        if ending == "csv":
            about = about_log(answered.bed, answered.bed95_deg)
            write_log(path, answered.log, about=about, force=True)
        else:
            with atomic_write(path, True) as temporary:
                _write_figure(answered, temporary, ending, 300.0)
    except VomError as error:
        return error
    return None


def _write_figure(answered: LogAnswer, target: io.BytesIO | Path, format_: str, dpi: float) -> None:
    from vomstudio.products.section.bed_log_figure import write_log_figure
    from vomstudio.tables.log_table import about_log

    about = about_log(answered.bed, answered.bed95_deg)
    write_log_figure(
        target, answered.log, format=format_, about=about, metric=answered.question.metric, dpi=dpi
    )


def write_boundaries(answered: LogAnswer, path: Path) -> None:
    """The table that the command reads, in place of what is there. Raises TargetError."""
    file = io.StringIO()
    out = csv.writer(file, lineterminator="\n")
    out.writerow(["name", "x", "y", "z", "lithology", "notes"])
    words = answered.question.words
    told = _each_another([b.name for b in answered.boundaries])
    for name, boundary in zip(told, answered.boundaries, strict=True):
        said = words.get(boundary.key, RockWords())
        place = numbers_text(boundary.place).split(",")
        out.writerow([guarded(name), *place, guarded(said.lithology), guarded(said.notes)])
    write_bytes(path, file.getvalue().encode(), force=True)


def words_of(answered: LogAnswer, table: Path) -> Words:
    """The command that says the same of this table of boundaries, and draws it."""
    bed = answered.bed
    options: list[tuple[str, Word]] = [("--bed", f"{bed.dip_direction_deg!r}/{bed.dip_deg!r}")]
    if answered.sigma_m:
        options.append(("--sigma", float(answered.sigma_m)))
    if answered.bed95_deg:
        options.append(("--bed-error", float(answered.bed95_deg)))
    beside = table.with_name(f"{table.stem}_result")
    said: list[Word | tuple[str, Word]] = ["log", table, *options]
    if answered.question.overturned:
        said.append("--overturned")
    return [*said, ("-o", beside.with_suffix(".csv")), ("--plot", beside.with_suffix(".svg"))]
