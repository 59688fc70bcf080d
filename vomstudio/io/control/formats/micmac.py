"""MicMac's XML files of ground points (DicoAppuisFlottant) and of their marks in the photos
(SetOfMesureAppuisFlottants), as its tools GCPConvert and SaisieAppuis write them."""

from __future__ import annotations

from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import open_regular
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate
from vomstudio.io.control.format import ControlFormat
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.io.text.xml_tree import (
    Element,
    UniqueKeys,
    element_error,
    is_xml,
    numbers,
    read_xml,
    words,
)

POINTS, MARKS = "DicoAppuisFlottant", "SetOfMesureAppuisFlottants"
_POINT, _PHOTO, _MARK = "OneAppuisDAF", "MesureAppuiFlottant1Im", "OneMesureAF1I"
# What is written where nobody has stated an error: a weight, not a length.
_UNSTATED = (1.0, 1.0, 1.0)
_HEAD, _MOST_FILES = 4096, 200


def points_of(path: Path) -> list[ControlPoint]:
    """The ground points of a file; their error is the root mean square of the three numbers of
    `Incertitude`, metres, unless these are 1 1 1. Raises InputError with line and element."""
    root = read_xml(path)
    found = [each for top in root.iter(POINTS) for each in top.findall(_POINT)]
    if not found:
        said = (
            Finding("control.only-marks")
            if next(root.iter(MARKS), None) is not None
            else Finding("control.no-points")
        )
        raise InputError(said, file=path, field=root.tag)
    points = []
    labels = UniqueKeys(path)
    for each in found:
        label = words(path, each, "NamePt")
        labels.add(label, each, "table.repeated-label", "NamePt", label=label)
        x, y, z = numbers(path, each.find("Pt"), words(path, each, "Pt"), 3)
        points.append(ControlPoint(label, (x, y, z), _sigma(path, each)))
    return points


def crs_of(path: Path) -> None:
    """Such a file states none. Raises InputError for what is wrong in its points, all the same."""
    points_of(path)


def _sigma(path: Path, point: Element) -> float | None:
    element = point.find("Incertitude")
    if element is None:
        return None
    stated = numbers(path, element, element.text or "", 3)
    if stated == _UNSTATED:
        return None
    if min(stated) <= 0:
        raise element_error(path, element, Finding("table.not-positive"))
    return float((sum(value * value for value in stated) / 3) ** 0.5)


def marks_of(path: Path) -> list[Mark]:
    """The marks of a file; pixels are taken as they stand. Raises InputError with line and
    element."""
    root = read_xml(path)
    photos = [each for top in root.iter(MARKS) for each in top.findall(_PHOTO)]
    marks = []
    seen = UniqueKeys(path)
    for photo in photos:
        name = words(path, photo, "NameIm").replace("\\", "/")
        for each in photo.findall(_MARK):
            label = words(path, each, "NamePt")
            x, y = numbers(path, each.find("PtIm"), words(path, each, "PtIm"), 2)
            seen.add(
                (label, name), each, "control.mark-repeated", "NamePt", label=label, photo=name
            )
            marks.append(Mark(label, name, x, y))
    if not marks:
        said = Finding("control.no-marks")
        if next(root.iter(POINTS), None) is not None:
            said = Finding("control.only-points")
        raise InputError(said, file=path, field=root.tag)
    return marks


def marks_beside(path: Path) -> Path | None:
    """The one other XML file of the folder that has marks and no points."""
    found = []
    for other in sorted(path.parent.glob("*.[xX][mM][lL]"))[:_MOST_FILES]:
        try:
            with open_regular(other) as file:
                head = file.read(_HEAD)
        except (InputError, OSError):
            continue
        if other != path and MARKS.encode() in head and POINTS.encode() not in head:
            found.append(other)
    return found[0] if len(found) == 1 else None


# It takes whatever XML no other format knows, and says what it misses in it.
CONTROL_FORMAT = ControlFormat(
    to_translate("ground points of MicMac (XML)"),
    matches=is_xml,
    points=points_of,
    marks=marks_of,
    crs=crs_of,
    certain=False,
    extensions=(".xml",),
    marks_beside=marks_beside,
)
