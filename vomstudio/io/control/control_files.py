"""Ground control from files of any format: points, marks, the CRS, and where they are found."""

from __future__ import annotations

from pathlib import Path

from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.geometry.coordinate_limits import why_no_coordinate
from vomstudio.io.control.points import CONTROL, MARKS, ControlPoint, Mark
from vomstudio.io.control.registry import choose_format, find_formats


def read_control(path: str | Path) -> list[ControlPoint]:
    """The points of a file. Raises InputError with file, line and column or element."""
    path = Path(path)
    points = choose_format(path).points(path)
    for point in points:
        if (finding := why_no_coordinate(point.position)) is not None:
            raise InputError(finding, file=path, field=point.label)
    return points


def read_marks(path: str | Path) -> list[Mark]:
    """The marks of a file. Raises InputError with file, line and column or element."""
    path = Path(path)
    return choose_format(path).marks(path)


def crs_of(path: str | Path) -> str | None:
    """The CRS of the points of a file, "EPSG:n" (or WKT) with metres; None where it states none.

    Points in degrees are read as those of their UTM zone. Raises InputError.
    """
    path = Path(path)
    return choose_format(path).crs(path)


def marks_beside(control: Path) -> Path:
    """Where the marks of a control file are unless another file is named: in it, or beside it."""
    format_ = choose_format(control)
    if format_.holds_marks:
        return control
    usual = control.with_name(MARKS)
    if not usual.is_file() and format_.marks_beside is not None:
        return format_.marks_beside(control) or usual
    return usual


def find_control(photos: Path) -> tuple[Path, Path] | None:
    """Control and marks that lie in the folder of the photos or beside it; None where they do
    not both."""
    for folder in (photos, photos.parent):
        if (folder / CONTROL).is_file() and (folder / MARKS).is_file():
            return folder / CONTROL, folder / MARKS
        for format_ in find_formats().all:
            for name in format_.found_as:
                if format_.matches(folder / name):
                    return folder / name, marks_beside(folder / name)
    return None


def _first_exchanged(control: Path, stated: str, code: str) -> Finding | None:
    """Return ``control.swapped-degrees`` if points would be in another zone, `code`, with longitude
    and latitude exchanged."""
    from vomstudio.io.gis.crs import to_degrees, utm_zone

    points = read_control(control)
    if not points:
        return None
    x, y, _ = points[0].position
    degrees = to_degrees(stated, [x], [y])
    if degrees is None:
        return None
    longitude, latitude = float(degrees[0][0]), float(degrees[1][0])
    is_exchanged = abs(longitude) <= 90.0 and utm_zone(latitude, longitude) == code
    if not is_exchanged or stated != utm_zone(longitude, latitude):
        return None
    label = points[0].label
    return Finding(
        "control.swapped-degrees", "error", label=label, longitude=longitude, latitude=latitude
    )


def agreed_crs(control: Path, crs: str | None) -> str | None:
    """The CRS of a model placed by this file: the one asked for, which must be that of the file
    where it states one, or else the file's; None for a local frame. Raises UsageError."""
    from vomstudio.io.gis.crs import metric_crs

    stated = crs_of(control)
    if crs is None:
        return stated
    code = metric_crs(crs, "CRS")
    if stated is not None and stated != code:
        if (exchanged := _first_exchanged(control, stated, code)) is not None:
            raise InputError(exchanged, file=control)
        raise UsageError(
            Finding("frame.other-crs", crs=code, control=control.name, stated=stated), field="CRS"
        )
    return code
