"""Pure functions for the descriptions of the beds of a log, stored with its line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.matrices import Point
from vomstudio.project.edit import Edit, change
from vomstudio.project.figures import Subject
from vomstudio.project.records import Feature, LoggedFeature, Record, get, get_feature

POINT_PREFIX = "#"
"""Prefix of a boundary at a point of the line, followed by the 0-based number of the point."""


def describe_bed(
    records: Mapping[str, Record], line_id: str, boundary: str, lithology: str, notes: str
) -> Edit:
    """Describe the bed that begins at a boundary; empty texts clear its description.

    Parameters
    ----------
    records : mapping
    line_id : str
        ID of the line of the log.
    boundary : str
        ID of a trace, or `POINT_PREFIX` followed by the index of a point of the line.
    lithology : str
    notes : str

    Raises
    ------
    DocumentError
        If the line does not exist or cannot have a log, or if nothing would change.
    """
    line = get(records, line_id, LoggedFeature)
    if line is None:
        raise DocumentError(Finding("bed.no-line"))
    beds_by_boundary = {bed[0]: bed for bed in line.beds}
    beds_by_boundary.pop(boundary, None)
    if lithology or notes:
        beds_by_boundary[boundary] = (boundary, lithology, notes)
    beds = tuple(beds_by_boundary[key] for key in sorted(beds_by_boundary))
    if beds == tuple(sorted(line.beds)):
        raise DocumentError(Finding("edit.no-change"))
    return change(
        records, f"Describe a bed along {line.name}", {line_id: line.replace_fields(beds=beds)}
    )


def vertex_fields(feature: Feature, vertices: Sequence[Point]) -> dict[str, Any]:
    """Return the vertices of a feature and, if it has a log, the beds that match them.

    The description of a bed stays with its point if points are inserted before it, and is removed
    together with the point.
    """
    fields: dict[str, Any] = {"vertices": tuple(vertices)}
    if not isinstance(feature, LoggedFeature) or not feature.beds:
        return fields
    if len(vertices) != len(feature.vertices):
        fields["beds"] = tuple(_renumber_beds(feature, fields["vertices"]))
    return fields


def _renumber_beds(line: LoggedFeature, vertices: tuple[Point, ...]) -> list[tuple[str, str, str]]:
    beds = []
    for boundary, lithology, notes in line.beds:
        if boundary.startswith(POINT_PREFIX):
            boundary_number = _number(boundary)
            if (
                not 0 <= boundary_number < len(line.vertices)
                or line.vertices[boundary_number] not in vertices
            ):
                continue
            boundary = f"{POINT_PREFIX}{vertices.index(line.vertices[boundary_number])}"
        beds.append((boundary, lithology, notes))
    return beds


def bed_lines(feature: Any, records: Mapping[str, Record]) -> list[str]:
    """Return one sentence per bed, for tables and layers that have no column for beds."""
    if not isinstance(feature, LoggedFeature):
        return []
    lines = []
    for boundary, lithology, notes in feature.beds:
        description = ", ".join(filter(None, (lithology, notes)))
        if boundary.startswith(POINT_PREFIX):
            boundary_number = _number(boundary) + 1
            lines.append(
                tr("bed from point {number}: {what}", number=boundary_number, what=description)
            )
        elif (trace := get_feature(records, boundary)) is not None:
            lines.append(tr("bed from {trace}: {what}", trace=trace.name, what=description))
    return lines


def notes_with_beds(subject: Subject) -> str:
    """Return the notes of a line followed by the descriptions of its beds."""
    beds = bed_lines(subject.feature, subject.records)
    return "; ".join(filter(None, (subject.feature.notes, *beds)))


def _number(boundary: str) -> int:
    digits = boundary.removeprefix(POINT_PREFIX)
    return int(digits) if digits.isdecimal() else -1
