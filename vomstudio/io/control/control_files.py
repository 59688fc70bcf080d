"""Ground control as other programs write it, told apart by what is in the file: MicMac's and
Metashape's XML, OpenDroneMap's list. Tables of our own are read by `io.control`."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from vomstudio.errors import InputError, UsageError
from vomstudio.io.control import metashape, micmac
from vomstudio.io.control.opendronemap import is_odm, read_odm
from vomstudio.io.control.tables import CONTROL, MARKS, ControlPoint, Mark
from vomstudio.io.text.tables import read_table
from vomstudio.io.text.xml_tree import is_xml, read_xml

_IN_COMMENT = re.compile(r"[#\s]*(?:CRS\s*[:=]?\s*)?(EPSG:\d+\b|[A-Z]+CRS\[.*\])", re.IGNORECASE)

ODM_LIST = "gcp_list.txt"


def points_of(path: str | Path) -> list[ControlPoint] | None:
    """The points of a file of another program; None for a table. Raises InputError."""
    return None if (found := _read(Path(path))) is None else found[0]


def crs_of(path: str | Path) -> str | None:
    """The CRS that the file states, "EPSG:n" (or WKT) with metres; None where it states none.

    A table states it in a comment that begins with it: `# EPSG:32633`, or WKT in one line.
    Its points are in metres; those in degrees in a file of another program are read as those of
    their UTM zone. Raises InputError.
    """
    path = Path(path)
    if (found := _read(path)) is not None:
        return found[1]
    for comment in read_table(path).comments:
        if stated := _IN_COMMENT.match(comment):
            return _in_metres(path, (), stated[1], _line_of(path, comment))[1]
    return None


def marks_of(path: str | Path) -> list[Mark] | None:
    """The marks of a file of another program; None for a table. Raises InputError."""
    path = Path(path)
    if is_xml(path):
        root = read_xml(path)
        if root.tag == metashape.TOP:
            return metashape.marks_of(path, root)
        return micmac.marks_of(path, root)
    return list(read_odm(path).marks) if is_odm(path) else None


def marks_beside(control: Path) -> Path:
    """Where the marks of a control file are unless another file is named: in it, or beside it."""
    if is_odm(control):
        return control
    if is_xml(control) and read_xml(control).tag == metashape.TOP:
        return control
    return control.with_name(MARKS)


def find_control(photos: Path) -> tuple[Path, Path] | None:
    """Control and marks that lie in the folder of the photos or beside it; None where they do
    not both."""
    for folder in (photos, photos.parent):
        if (folder / CONTROL).is_file() and (folder / MARKS).is_file():
            return folder / CONTROL, folder / MARKS
        if is_odm(folder / ODM_LIST):
            return folder / ODM_LIST, folder / ODM_LIST
    return None


def agreed_crs(control: Path, crs: str | None) -> str | None:
    """The CRS of a model placed by this file: the one asked for, which must be that of the file
    where it states one, or else the file's; None for a local frame. Raises UsageError."""
    from vomstudio.io.gis.crs import parse_crs

    stated = crs_of(control)
    if crs is None:
        return stated
    code, unit = parse_crs(crs)
    if unit != 1.0:
        raise UsageError("is not in metres; choose one that is", field="CRS")
    if stated not in (None, code):
        raise UsageError(
            f"{code} is not that of {control.name}, which is in {stated}; leave it out, or convert "
            "the points",
            field="CRS",
        )
    return code


def _read(path: Path) -> tuple[list[ControlPoint], str | None] | None:
    if is_xml(path):
        root = read_xml(path)
        if root.tag != metashape.TOP:
            return micmac.points_of(path, root), None
        points = metashape.points_of(path, root)
        crs = metashape.crs_of(path, root)
        return _in_metres(path, points, crs)
    if is_odm(path):
        odm = read_odm(path)
        return _in_metres(path, odm.points, odm.crs, odm.line)
    return None


def _line_of(path: Path, comment: str) -> int | None:
    """The line of a comment of a table; None where its encoding hides it."""
    lines = path.read_bytes().decode("utf-8-sig", "replace").splitlines()
    bare = (text.strip() for text in lines)
    return next(
        (n for n, t in enumerate(bare, 1) if t[:1] == "#" and t[1:].strip() == comment), None
    )


def _in_metres(
    path: Path, points: Sequence[ControlPoint], text: str | None, line: int | None = None
) -> tuple[list[ControlPoint], str | None]:
    """Points in a projected CRS; longitude and latitude become those of their UTM zone.

    points : none of a table, which is not read in degrees
    """
    from pyproj import CRS
    from pyproj.exceptions import CRSError

    from vomstudio.io.gis.crs import from_degrees, parse_crs, utm_zone

    if text is None or text.upper().startswith(("LOCAL", "ENGCRS", "ENGINEERING")):
        return list(points), None
    try:
        crs = CRS.from_user_input(text)
        horizontal = crs.sub_crs_list[0] if crs.is_compound else crs
        if horizontal.is_geographic and not points:
            raise InputError(
                f"{crs.name} is in degrees, and a table is read in metres; give the points in "
                "metres, such as those of their UTM zone, and its code",
                file=path,
                line=line,
            )
        if horizontal.is_geographic:
            for point in points:
                if abs(point.position[0]) > 180 or abs(point.position[1]) > 90:
                    raise _nowhere(path, line, point)
            code = utm_zone(points[0].position[0], points[0].position[1])
            to_grid = from_degrees(code, horizontal.to_wkt())
            moved = []
            for point in points:
                place = to_grid(point.position[0], point.position[1])
                if place is None:
                    raise _nowhere(path, line, point)
                moved.append(replace(point, position=(*place, point.position[2])))
            return moved, code
        code, unit = parse_crs(horizontal.to_wkt())
    except (CRSError, InputError) as error:
        if isinstance(error, InputError) and error.file is not None:
            raise
        raise InputError(
            f"its projection '{text[:60]}' is not known here; write a code such as EPSG:32633",
            file=path,
            line=line,
        ) from error
    if unit != 1.0:
        raise InputError(f"{crs.name} is not in metres; convert the points", file=path, line=line)
    return list(points), code


def _nowhere(path: Path, line: int | None, point: ControlPoint) -> InputError:
    return InputError(f"{point.label} is at no longitude and latitude", file=path, line=line)
