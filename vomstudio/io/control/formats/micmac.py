"""MicMac XML files of ground points and marks (GCPConvert and SaisieAppuis).

Points are stored in DicoAppuisFlottant, and marks in SetOfMesureAppuisFlottants.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import open_regular_file
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

POINTS_TAG, MARKS_TAG = "DicoAppuisFlottant", "SetOfMesureAppuisFlottants"
_POINT_TAG, _PHOTO_TAG, _MARK_TAG = "OneAppuisDAF", "MesureAppuiFlottant1Im", "OneMesureAF1I"
# Default for points without a stated error; it is a weight and not a length.
_DEFAULT_WEIGHTS = (1.0, 1.0, 1.0)
HEAD_BYTES, MAX_FILES = 4096, 200


def read_points(path: Path) -> list[ControlPoint]:
    """Return the ground points of a file.

    The error is the root mean square of the three numbers of `Incertitude` in metres; None if they
    are missing or have the default values 1 1 1. Raises InputError with line and element.
    """
    root = read_xml(path)
    elements = [element for top in root.iter(POINTS_TAG) for element in top.findall(_POINT_TAG)]
    if not elements:
        finding = (
            Finding("control.only-marks")
            if next(root.iter(MARKS_TAG), None) is not None
            else Finding("control.no-points")
        )
        raise InputError(finding, file=path, field=root.tag)
    points = []
    labels = UniqueKeys(path)
    for element in elements:
        label = words(path, element, "NamePt")
        labels.add(label, element, "table.repeated-label", "NamePt", label=label)
        x, y, z = numbers(path, element.find("Pt"), words(path, element, "Pt"), 3)
        points.append(ControlPoint(label, (x, y, z), _sigma(path, element)))
    return points


def read_crs(path: Path) -> None:
    """Return None because MicMac files do not state a CRS.

    Raises
    ------
    InputError
        If the points are not valid.
    """
    read_points(path)


def _sigma(path: Path, point: Element) -> float | None:
    element = point.find("Incertitude")
    if element is None:
        return None
    stated_numbers = numbers(path, element, element.text or "", 3)
    if stated_numbers == _DEFAULT_WEIGHTS:
        return None
    if min(stated_numbers) <= 0:
        raise element_error(path, element, Finding("table.not-positive"))
    return float((sum(value * value for value in stated_numbers) / 3) ** 0.5)


def read_marks(path: Path) -> list[Mark]:
    """Return the marks of a file, with pixel coordinates as written.

    Raises InputError with line and element.
    """
    root = read_xml(path)
    photos = [element for top in root.iter(MARKS_TAG) for element in top.findall(_PHOTO_TAG)]
    marks = []
    labels = UniqueKeys(path)
    for photo in photos:
        name = words(path, photo, "NameIm").replace("\\", "/")
        for element in photo.findall(_MARK_TAG):
            label = words(path, element, "NamePt")
            x, y = numbers(path, element.find("PtIm"), words(path, element, "PtIm"), 2)
            labels.add(
                (label, name), element, "control.mark-repeated", "NamePt", label=label, photo=name
            )
            marks.append(Mark(label, name, x, y))
    if not marks:
        finding = Finding("control.no-marks")
        if next(root.iter(POINTS_TAG), None) is not None:
            finding = Finding("control.only-points")
        raise InputError(finding, file=path, field=root.tag)
    return marks


def find_marks(path: Path) -> Path | None:
    """Return the only other XML file in the folder that has marks but no points, or None."""
    return find_single_xml(
        path.parent, lambda head: MARKS_TAG in head and POINTS_TAG not in head, path
    )


def find_points(folder: Path) -> Path | None:
    """Return the only XML file in the folder that has points, or None.

    Parameters
    ----------
    folder : Path

    Returns
    -------
    Path or None
    """
    return find_single_xml(folder, lambda head: POINTS_TAG in head)


def find_single_xml(
    folder: Path, matches: Callable[[str], bool], excluded_path: Path | None = None
) -> Path | None:
    """Return the only XML file with a matching beginning in a folder, or None.

    None is also returned if several files match. The first `MAX_FILES` files are searched.

    Parameters
    ----------
    folder : Path
    matches : callable
        Function that returns whether the first `HEAD_BYTES` bytes of a file, as text, match.
    excluded_path : Path, optional
        File that is not searched.
    """
    candidates = []
    for file in sorted(folder.glob("*.[xX][mM][lL]"))[:MAX_FILES]:
        try:
            with open_regular_file(file) as stream:
                header = stream.read(HEAD_BYTES).decode("utf-8", "replace")
        except (InputError, OSError):
            continue
        if file != excluded_path and matches(header):
            candidates.append(file)
    return candidates[0] if len(candidates) == 1 else None


# It accepts any XML file that no other format recognises, and reports what is missing.
CONTROL_FORMAT = ControlFormat(
    to_translate("MicMac ground points (XML)"),
    matches=is_xml,
    points=read_points,
    marks=read_marks,
    crs=read_crs,
    is_certain=False,
    extensions=(".xml",),
    find_marks=find_marks,
    find_points=find_points,
)
