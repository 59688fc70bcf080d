"""Traces and planes in XML files of CloudCompare's Compass plugin.

The plugin writes the tree of objects (`ccCompassExport::SaveXML` in CloudCompare's qCompass).
Coordinates are local: a cloud states the scale and the shift to global coordinates.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Plane
from vomstudio.io.gate.stated_crs import StatedCrs, table_crs
from vomstudio.io.text.xml_tree import Element, read_xml
from vomstudio.project.imports.compass_names import object_name
from vomstudio.project.imports.listed_rows import (
    ListedRow,
    ReadingReport,
    plane_from_angles,
    to_number,
)

_TAGS = (
    *("CONTAINER", "GEO_OBJECT", "CLOUD", "SNE", "PLANE", "TRACE", "LINEATION", "POLYLINE"),
    *("FACET", "THICKNESS", "OBJECT"),
)
_ROOT = re.compile(rb"(?:\xef\xbb\xbf)?\s*(?:<\?xml[^>]*\?>)?\s*<([A-Z_]+)[\s>]")
Shift = tuple[float, float, float, float]
"""Scale, and x, y and z of the shift of a cloud."""
_NO_SHIFT: Shift = (1.0, 0.0, 0.0, 0.0)


def is_compass_xml(head: bytes) -> bool:
    """Return whether a file is an XML export of Compass.

    Parameters
    ----------
    head : bytes
        First bytes of the file.
    """
    match = _ROOT.match(head)
    return match is not None and match[1].decode("ascii") in _TAGS


@dataclass(frozen=True)
class _Place:
    """Position of an element in the tree."""

    groups: tuple[str, ...] = ()
    structure: str = ""
    shift: Shift | None = None


def compass_xml_rows(path: Path, report: ReadingReport) -> Iterator[ListedRow]:
    """Yield traces, polylines, lineations, planes and facets of a file.

    A plane that belongs to a trace is the stated orientation of the trace.

    Raises
    ------
    InputError
        If the file is not XML.
    """
    root = read_xml(path)
    shifts = {shift for element in root.iter("CLOUD", "SNE") if (shift := _shift(element))}
    frame, findings = table_crs(path, ())
    report.findings += findings
    # Without clouds the coordinates are global.
    common_shift = next(iter(shifts or {_NO_SHIFT})) if len(shifts) < 2 else None
    for element, place in _walk(root, _Place(shift=common_shift)):
        name = str(element.get("name", ""))
        if element.tag == "THICKNESS":
            report.skipped.append((name or element.tag, Finding("import.no-counterpart")))
            continue
        row = _row(element, place, frame)
        if row is None:
            continue
        if place.shift is None and row.layer != "lineations":
            report.skipped.append((name or element.tag, Finding("import.several-shifts")))
            continue
        yield row


def _walk(element: Element, place: _Place) -> Iterator[tuple[Element, _Place]]:
    """Yield the elements that may be features, with their places."""
    name = str(element.get("name", ""))
    if element.tag in ("TRACE", "POLYLINE", "LINEATION", "PLANE", "FACET", "THICKNESS"):
        yield element, place
        if element.tag in ("TRACE", "FACET"):
            # Their planes and contours belong to them.
            return
    place = replace(
        place,
        groups=(*place.groups, name) if name else place.groups,
        structure=name if element.tag == "GEO_OBJECT" else place.structure,
        shift=_shift(element) or place.shift,
    )
    for child in element:
        if child.tag in _TAGS:
            yield from _walk(child, place)


def _row(element: Element, place: _Place, frame: StatedCrs) -> ListedRow | None:
    """Return the row of an element, or None if it has no points or orientation."""
    name = str(element.get("name", ""))
    notes = ".".join([*place.groups, name])
    row = ListedRow(
        "traces",
        np.empty((0, 3)),
        {"name": object_name(name)},
        frame,
        place.groups,
        notes=notes,
        structure=place.structure,
    )
    if element.tag in ("TRACE", "POLYLINE"):
        lists = element.find("POINTS")
        if lists is None:
            return None
        points = _global(_columns(lists), place.shift or _NO_SHIFT)
        plane = next(iter(element.iter("PLANE")), None)
        return replace(row, points=points, plane=None if plane is None else _plane(plane))
    if element.tag == "LINEATION":
        # The plugin writes the ends in global coordinates.
        ends = [_point(element, f"{end}{{}}") for end in "SE"]
        return replace(row, layer="lineations", points=np.array(ends))
    plane = _plane(element)
    if plane is None:
        return None
    centre = _global(np.array([_point(element, "C{}")]), place.shift or _NO_SHIFT)
    return replace(row, layer="planes", points=centre, plane=plane)


def _plane(element: Element) -> Plane | None:
    angles = [to_number(element.findtext(tag)) for tag in ("DipDir", "Dip")]
    if all(angle == angle for angle in angles):
        return plane_from_angles(*angles)
    normal = np.array(_point(element, "N{}"))
    is_valid = bool(np.isfinite(normal).all() and normal.any())
    return Plane.from_normal(normal) if is_valid else None


def _point(element: Element, pattern: str) -> list[float]:
    return [to_number(element.findtext(pattern.format(axis))) for axis in "xyz"]


def _columns(lists: Element) -> FloatArray:
    """Return the points (n, 3) of the lists x, y and z; missing values are NaN."""
    columns = []
    for axis in "xyz":
        cells = (lists.findtext(axis) or "").strip().rstrip(",").split(",")
        columns.append([to_number(cell) for cell in cells if cell.strip()])
    points = np.full((max(map(len, columns)), 3), np.nan)
    for position, column in enumerate(columns):
        points[: len(column), position] = column
    return points


def _shift(element: Element) -> Shift | None:
    values = [
        to_number(element.findtext(tag))
        for tag in ("GLOBAL_SCALE", "GLOBAL_X", "GLOBAL_Y", "GLOBAL_Z")
    ]
    if not np.isfinite(values).all() or values[0] == 0.0:
        return None
    scale, x, y, z = values
    return scale, x, y, z


def _global(points: FloatArray, shift: Shift) -> FloatArray:
    """Convert local coordinates (`ccShiftedObject::toGlobal3d`)."""
    scale, *offset = shift
    return np.asarray(points / scale - np.array(offset), np.float64)
