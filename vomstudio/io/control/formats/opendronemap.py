"""Ground control file `gcp_list.txt` of OpenDroneMap.

The first line states the projection. Each further line is a mark `x y z pixel_x pixel_y photo
[label]`; the name of the photo may contain blanks. Marks without labels belong to the same point if
their coordinates are equal.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from math import isfinite
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import is_regular_file, open_regular_file, read_small_file
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.io.control.format import ControlFormat
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.io.control.projection import project_points
from vomstudio.io.text.encodings import convert_to_utf8, decode_text

MAX_BYTES = 64 << 20
_PHOTO_SUFFIXES = (".jpg", ".jpeg", ".tif", ".tiff", ".png", ".dng", ".heic")
_UTM = re.compile(r"WGS84\s+UTM\s+(\d{1,2})\s*([NS])", re.IGNORECASE)
_HEADER = re.compile(r"(EPSG:\s*\d+(?:\s*\+\s*\d+)?|WGS84\s+UTM\b.*|\+proj=.*)", re.IGNORECASE)


@dataclass(frozen=True)
class OdmControl:
    """Content of a `gcp_list.txt` file.

    `crs` is in a form that pyproj accepts, and `line` is the line number of the header.
    """

    crs: str
    line: int
    points: tuple[ControlPoint, ...]
    marks: tuple[Mark, ...]


def read_points(path: Path) -> list[ControlPoint]:
    """Return the points of a file. Raises InputError with line and column."""
    return _projected_points(path)[0]


def read_crs(path: Path) -> str | None:
    """Return the CRS of a file. Raises InputError with line and column."""
    return _projected_points(path)[1]


def read_marks(path: Path) -> list[Mark]:
    """Return the marks of a file. Raises InputError with line and column."""
    return list(read_odm(path).marks)


def _projected_points(path: Path) -> tuple[list[ControlPoint], str | None]:
    odm = read_odm(path)
    return project_points(path, odm.points, odm.crs, odm.line)


def is_odm(path: str | Path) -> bool:
    """Return whether the first line is a projection; False if the file is unreadable."""
    if not is_regular_file(path):
        return False
    try:
        with open_regular_file(path) as stream:
            header = convert_to_utf8(stream.read(1 << 16)).decode("utf-8", "ignore")
        for text in header.splitlines():
            if text.strip() and not text.startswith("#"):
                return _HEADER.fullmatch(text.strip()) is not None
    except (InputError, OSError):
        pass
    return False


def read_odm(path: str | Path) -> OdmControl:
    """Read a `gcp_list.txt` file. Raises InputError with line and column."""
    path = Path(path)
    try:
        lines = decode_text(read_small_file(path, MAX_BYTES)).splitlines()
    except OSError as error:
        raise InputError(Finding("file.unreadable", reason=error.strerror), file=path) from error
    except UnicodeDecodeError as error:
        raise InputError(
            Finding(
                "file.damaged", format="UTF-8", reason=tr("some bytes are not valid characters")
            ),
            file=path,
        ) from error
    rows = [
        (line_number, text.strip())
        for line_number, text in enumerate(lines, start=1)
        if text.strip() and not text.startswith("#")
    ]
    if not rows or _HEADER.fullmatch(rows[0][1]) is None:
        raise InputError(
            Finding("control.no-projection"), file=path, line=rows[0][0] if rows else 1
        )
    first_line_number, header = rows[0]
    points: dict[str, tuple[int, ControlPoint]] = {}
    labels_by_position: dict[tuple[float, float, float], str] = {}
    marks: dict[tuple[str, str], tuple[int, Mark]] = {}
    for line, text in rows[1:]:
        cells = [cell.strip() for cell in text.split("\t")] if "\t" in text else text.split()
        if len(cells) < 6:
            raise InputError(
                Finding(
                    "table.column-count",
                    count=len(cells),
                    columns=("x", "y", "z", "pixel_x", "pixel_y", "photo"),
                ),
                file=path,
                line=line,
            )
        x, y, z, u, v = (
            _number(path, line, name, cell)
            for name, cell in zip(("x", "y", "z", "pixel_x", "pixel_y"), cells, strict=False)
        )
        position = (x, y, z)
        photo, label = _photo_and_label(cells[5:])
        label = label or labels_by_position.setdefault(
            position, f"GCP{len(labels_by_position) + 1}"
        )
        first_line, first_point = points.setdefault(label, (line, ControlPoint(label, position)))
        if first_point.position != position:
            raise InputError(
                Finding("control.other-coordinates", label=label, first_line=first_line),
                file=path,
                line=line,
            )
        first_line, _ = marks.setdefault((label, photo), (line, Mark(label, photo, u, v)))
        if first_line != line:
            raise InputError(
                Finding("control.mark-repeated", label=label, photo=photo, first_line=first_line),
                file=path,
                line=line,
            )
    if not points:
        raise InputError(Finding("control.no-points"), file=path)
    return OdmControl(
        parse_projection(path, first_line_number, header),
        first_line_number,
        tuple(point for _, point in points.values()),
        tuple(mark for _, mark in marks.values()),
    )


def _photo_and_label(cells: list[str]) -> tuple[str, str]:
    """Return the name of the photo, which may contain blanks, and the label or ""."""
    end = 1
    for count in range(1, len(cells) + 1):
        if Path(cells[count - 1]).suffix.lower() in _PHOTO_SUFFIXES:
            end = count
            break
    label = cells[end] if len(cells) > end else ""
    return " ".join(cells[:end]).replace("\\", "/"), label


def parse_projection(path: Path, line: int, header: str) -> str:
    """Return the projection in the first line of a file, in a form that pyproj accepts.

    Raises InputError.
    """
    if header.casefold().startswith("wgs84"):
        match = _UTM.fullmatch(header)
        if match is None or not 1 <= int(match[1]) <= 60:
            raise InputError(Finding("frame.unknown-crs", crs=header[:40]), file=path, line=line)
        return f"EPSG:{(32600 if match[2].upper() == 'N' else 32700) + int(match[1])}"
    return header.replace(" ", "") if header.casefold().startswith("epsg") else header


def _number(path: Path, line: int, name: str, cell: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = float("nan")
    if not isfinite(value):
        raise InputError(
            Finding("table.not-a-number", cell=cell[:40]), file=path, line=line, field=name
        )
    return value


CONTROL_FORMAT = ControlFormat(
    to_translate("OpenDroneMap ground control list"),
    matches=is_odm,
    points=read_points,
    marks=read_marks,
    crs=read_crs,
    has_marks=True,
    default_names=("gcp_list.txt",),
    extensions=(".txt",),
)
