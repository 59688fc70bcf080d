"""What is said of the beds of a log along a line, kept with the line. Pure, as `project.edits`
are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.matrices import Point
from vomstudio.project.edit import Edit, change
from vomstudio.project.figures import Subject
from vomstudio.project.records import Feature, Logged, Record, get, get_feature

POINT = "#"
"""Before the number of a point of the line, from 0, by which a boundary there is named."""


def describe_bed(
    records: Mapping[str, Record], line_id: str, boundary: str, lithology: str, notes: str
) -> Edit:
    """Say what the bed is that begins at a boundary; nothing where both are empty. boundary : the
    id of a trace, or POINT and the number of a point of the line. Raises DocumentError for a line
    that is not there or has no log, and where nothing would change."""
    line = get(records, line_id, Logged)
    if line is None:
        raise DocumentError(Finding("bed.no-line"))
    said = {each[0]: each for each in line.beds}
    said.pop(boundary, None)
    if lithology or notes:
        said[boundary] = (boundary, lithology, notes)
    beds = tuple(said[key] for key in sorted(said))
    if beds == tuple(sorted(line.beds)):
        raise DocumentError(Finding("edit.no-change"))
    return change(records, f"Describe a bed along {line.name}", {line_id: line.but(beds=beds)})


def with_vertices(feature: Feature, vertices: Sequence[Point]) -> dict[str, Any]:
    """The fields of a line that change with its vertices: words stay with the point at which they
    were said, whatever comes before it, and go with one that is taken away."""
    found: dict[str, Any] = {"vertices": tuple(vertices)}
    if not isinstance(feature, Logged) or not feature.beds:
        return found
    if len(vertices) != len(feature.vertices):
        found["beds"] = tuple(_moved(feature, found["vertices"]))
    return found


def _moved(line: Logged, vertices: tuple[Point, ...]) -> list[tuple[str, str, str]]:
    beds = []
    for boundary, lithology, notes in line.beds:
        if boundary.startswith(POINT):
            number = _number(boundary)
            if not 0 <= number < len(line.vertices) or line.vertices[number] not in vertices:
                continue
            boundary = f"{POINT}{vertices.index(line.vertices[number])}"
        beds.append((boundary, lithology, notes))
    return beds


def bed_lines(feature: Any, records: Mapping[str, Record]) -> list[str]:
    """A sentence for each bed, for tables and layers that have no column for it."""
    if not isinstance(feature, Logged):
        return []
    said = []
    for boundary, lithology, notes in feature.beds:
        what = ", ".join(filter(None, (lithology, notes)))
        if boundary.startswith(POINT):
            number = _number(boundary) + 1
            said.append(tr("bed from point {number}: {what}", number=number, what=what))
        elif (trace := get_feature(records, boundary)) is not None:
            said.append(tr("bed from {trace}: {what}", trace=trace.name, what=what))
    return said


def notes_with_beds(subject: Subject) -> str:
    """The notes of a line, and what was said of the beds along it."""
    beds = bed_lines(subject.feature, subject.records)
    return "; ".join(filter(None, (subject.feature.notes, *beds)))


def _number(boundary: str) -> int:
    digits = boundary.removeprefix(POINT)
    return int(digits) if digits.isdecimal() else -1
