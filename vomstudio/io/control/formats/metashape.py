"""Markers with their coordinates and marks in photos, in XML files exported by Metashape."""

from __future__ import annotations

from pathlib import Path

from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate
from vomstudio.io.control.format import ControlFormat
from vomstudio.io.control.formats.micmac import find_single_xml
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.io.control.projection import project_points
from vomstudio.io.text.xml_tree import (
    Element,
    UniqueKeys,
    attribute,
    element_error,
    is_xml,
    number,
    read_xml,
)

ROOT_TAG = "document"


def matches(path: Path) -> bool:
    """Return whether the root element is that of Metashape.

    Raises InputError for damaged XML.
    """
    return is_xml(path) and read_xml(path).tag == ROOT_TAG


def read_points(path: Path) -> list[ControlPoint]:
    """Return the points of a file. Raises InputError with line and element."""
    return _projected_points(path)[0]


def read_crs(path: Path) -> str | None:
    """Return the CRS of a file, or None. Raises InputError with line and element."""
    return _projected_points(path)[1]


def _projected_points(path: Path) -> tuple[list[ControlPoint], str | None]:
    root = read_xml(path)
    return project_points(path, _points(path, root), _stated_crs(path, root))


def _chunk(path: Path, root: Element) -> Element:
    chunks = [chunk for chunk in root.iter("chunk") if chunk.find("markers") is not None]
    if len(chunks) != 1:
        raise InputError(
            Finding("control.no-chunk")
            if not chunks
            else Finding("control.several-chunks", count=len(chunks)),
            file=path,
            field=root.tag,
        )
    return chunks[0]


def _points(path: Path, root: Element) -> list[ControlPoint]:
    """Return the markers that have coordinates.

    Markers that are disabled in the reference pane are check points.

    Raises InputError with line and element.
    """
    points = []
    labels = UniqueKeys(path)
    for marker in _markers(_chunk(path, root)):
        reference = marker.find("reference")
        if reference is None or "x" not in reference.attrib:
            continue
        label = attribute(path, marker, "label")
        labels.add(label, marker, "table.repeated-label", label=label)
        x, y, z = (_number(path, reference, name) for name in "xyz")
        errors = [_number(path, reference, n) for n in ("sx", "sy", "sz") if n in reference.attrib]
        sigma = (sum(error * error for error in errors) / len(errors)) ** 0.5 if errors else None
        check = reference.get("enabled", "true").casefold() in ("false", "0")
        points.append(ControlPoint(label, (x, y, z), sigma or None, check))
    if not points:
        raise InputError(Finding("control.no-points"), file=path)
    return points


def read_marks(path: Path) -> list[Mark]:
    """Return the marks that were placed or confirmed by hand ("pinned").

    Valid marks for which a file does not state this are included. Raises InputError with line and
    element.
    """
    chunk = _chunk(path, read_xml(path))
    cameras = chunk.find("cameras")
    names = {
        attribute(path, camera, "id"): attribute(path, camera, "label")
        for camera in ([] if cameras is None else cameras.iter("camera"))
    }
    labels = {
        attribute(path, marker, "id"): attribute(path, marker, "label")
        for marker in _markers(chunk)
    }
    frames = chunk.find("frames")
    marks = []
    for marker in frames.iter("marker") if frames is not None else ():
        label = _require_known(path, marker, "marker_id", labels)
        for location in marker.findall("location"):
            pinned_text = location.get("pinned", location.get("valid", "true"))
            if pinned_text.casefold() in ("false", "0"):
                continue
            photo = _require_known(path, location, "camera_id", names)
            marks.append(
                Mark(label, photo, _number(path, location, "x"), _number(path, location, "y"))
            )
    if not marks:
        raise InputError(Finding("control.no-marks"), file=path)
    return marks


def _stated_crs(path: Path, root: Element) -> str | None:
    """Return the CRS of the chunk with the markers, or None. Raises InputError."""
    for reference in _chunk(path, root).findall("reference"):
        if crs_text := (reference.text or "").strip():
            return str(crs_text)
    return None


def _markers(chunk: Element) -> list[Element]:
    markers_element = chunk.find("markers")
    return [] if markers_element is None else list(markers_element.iter("marker"))


def _number(path: Path, element: Element, name: str) -> float:
    return number(path, element, attribute(path, element, name), name)


def _require_known(path: Path, element: Element, name: str, values_by_key: dict[str, str]) -> str:
    key = attribute(path, element, name)
    if key not in values_by_key:
        raise element_error(path, element, Finding("control.unknown-key", name=name, key=key))
    return values_by_key[key]


def find_points(folder: Path) -> Path | None:
    """Return the only XML file in the folder that has markers with coordinates, or None.

    Parameters
    ----------
    folder : Path

    Returns
    -------
    Path or None
    """
    path = find_single_xml(folder, lambda head: f"<{ROOT_TAG}" in head and "<chunk" in head)
    if path is None:
        return None
    try:
        return path if read_points(path) else None
    except (InputError, UsageError):
        return None


CONTROL_FORMAT = ControlFormat(
    to_translate("Metashape markers (XML)"),
    matches=matches,
    points=read_points,
    marks=read_marks,
    crs=read_crs,
    has_marks=True,
    find_points=find_points,
    extensions=(".xml",),
)
