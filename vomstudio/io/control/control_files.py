"""Ground control in any format: points, marks, CRS, and default file locations."""

from __future__ import annotations

from pathlib import Path

from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.geometry.coordinate_limits import check_coordinates
from vomstudio.io.control.points import CONTROL, MARKS, ControlPoint, Mark
from vomstudio.io.control.registry import choose_format, find_formats


def read_control(path: str | Path) -> list[ControlPoint]:
    """Read the points of a file. Raises InputError with file, line and column or element."""
    path = Path(path)
    points = choose_format(path).points(path)
    for point in points:
        if (finding := check_coordinates(point.position)) is not None:
            raise InputError(finding, file=path, field=point.label)
    return points


def read_marks(path: str | Path) -> list[Mark]:
    """Read the marks of a file. Raises InputError with file, line and column or element."""
    path = Path(path)
    return choose_format(path).marks(path)


def read_crs(path: str | Path) -> str | None:
    """Return the CRS of the points in a file ("EPSG:n" or WKT, in metres), or None.

    Points in degrees are converted to their UTM zone. Returns None if the file does not state a
    CRS. Raises InputError.
    """
    path = Path(path)
    return choose_format(path).crs(path)


def marks_path(control: Path) -> Path:
    """Return the default marks file of a control file: the file itself or one next to it."""
    format_ = choose_format(control)
    if format_.has_marks:
        return control
    default_path = control.with_name(MARKS)
    if not default_path.is_file() and format_.find_marks is not None:
        return format_.find_marks(control) or default_path
    return default_path


def find_control(photos: Path) -> tuple[Path, Path] | None:
    """Return the control and marks files in or next to the photo folder, or None."""
    for folder in (photos, photos.parent):
        if (folder / CONTROL).is_file() and (folder / MARKS).is_file():
            return folder / CONTROL, folder / MARKS
        for format_ in find_formats().all:
            for name in format_.default_names:
                if format_.matches(folder / name):
                    return folder / name, marks_path(folder / name)
    return None


def find_program_control(photos: Path) -> tuple[Path, Path] | None:
    """Return the control and marks files of another program, whatever their names, or None.

    The photo folder and the folder that contains it are searched. A file is returned only if it is
    the only one of its format and its marks file exists.

    Parameters
    ----------
    photos : Path

    Returns
    -------
    (Path, Path) or None
    """
    for folder in (photos, photos.parent):
        for format_ in find_formats().all:
            if format_.find_points is None or (path := format_.find_points(folder)) is None:
                continue
            if (marks := marks_path(path)).is_file():
                return path, marks
    return None


def _swapped_degrees_finding(control: Path, stated_crs: str, code: str) -> Finding | None:
    """Return ``control.swapped-degrees`` if swapped degrees explain the other CRS, or None.

    They explain it if the first point would be in the zone `code` after swapping longitude and
    latitude.
    """
    from vomstudio.io.gis.crs import to_degrees, utm_zone

    points = read_control(control)
    if not points:
        return None
    x, y, _ = points[0].position
    degrees = to_degrees(stated_crs, [x], [y])
    if degrees is None:
        return None
    longitude, latitude = float(degrees[0][0]), float(degrees[1][0])
    is_swapped = abs(longitude) <= 90.0 and utm_zone(latitude, longitude) == code
    if not is_swapped or stated_crs != utm_zone(longitude, latitude):
        return None
    label = points[0].label
    return Finding(
        "control.swapped-degrees", "error", label=label, longitude=longitude, latitude=latitude
    )


def agreed_crs(control: Path, crs: str | None) -> str | None:
    """Return the CRS of a model placed by a control file, or None for a local frame.

    This is the requested CRS, which must match that of the file if the file states one; without a
    request, it is the CRS of the file. Raises UsageError if the two differ, or InputError if
    longitude and latitude are swapped in the file.
    """
    from vomstudio.io.gis.crs import metric_crs

    stated_crs = read_crs(control)
    if crs is None:
        return stated_crs
    code = metric_crs(crs, "CRS")
    if stated_crs is not None and stated_crs != code:
        if (
            swapped_degrees_finding := _swapped_degrees_finding(control, stated_crs, code)
        ) is not None:
            raise InputError(swapped_degrees_finding, file=control)
        raise UsageError(
            Finding("frame.other-crs", crs=code, control=control.name, stated=stated_crs),
            field="CRS",
        )
    return code
