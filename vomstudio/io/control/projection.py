"""Conversion of control points to the CRS of a model, which is projected and in metres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.io.control.points import ControlPoint


def project_points(
    path: Path, points: Sequence[ControlPoint], text: str | None, line: int | None = None
) -> tuple[list[ControlPoint], str | None]:
    """Convert points to a projected CRS.

    Parameters
    ----------
    path : Path
        File of the points, for error messages.
    points : sequence of ControlPoint
        Points to convert; if empty, a CRS in degrees is an error.
    text : str or None
        CRS as stated by the file in `line`.
    line : int, optional
        Line in which the file states the CRS, for error messages.

    Returns
    -------
    points : list of ControlPoint
        Converted points; longitude and latitude are converted to their UTM zone.
    crs : str or None
        "EPSG:n" or WKT; None if no CRS or a local one is stated.

    Raises
    ------
    InputError
        If the CRS is unknown or not in metres, or if a point is not on Earth.
    """
    from pyproj import CRS
    from pyproj.exceptions import CRSError

    from vomstudio.io.gis.crs import degrees_to_grid, parse_crs, utm_zone

    if text is None or text.upper().startswith(("LOCAL", "ENGCRS", "ENGINEERING")):
        return list(points), None
    try:
        crs = CRS.from_user_input(text)
        horizontal_crs = crs.sub_crs_list[0] if crs.is_compound else crs
        if horizontal_crs.is_geographic and not points:
            raise InputError(
                Finding("frame.not-projected", crs=crs.name), file=path, line=line, field="CRS"
            )
        if horizontal_crs.is_geographic:
            for point in points:
                if abs(point.position[0]) > 180 or abs(point.position[1]) > 90:
                    raise _outside_crs_error(path, line, point)
            code = utm_zone(points[0].position[0], points[0].position[1])
            to_grid = degrees_to_grid(code, horizontal_crs.to_wkt())
            projected_points = []
            for point in points:
                position = to_grid(point.position[0], point.position[1])
                if position is None:
                    raise _outside_crs_error(path, line, point)
                projected_points.append(replace(point, position=(*position, point.position[2])))
            return projected_points, code
        code, unit = parse_crs(horizontal_crs.to_wkt())
    except (CRSError, InputError) as error:
        if isinstance(error, InputError) and error.file is not None:
            raise
        raise InputError(
            Finding("frame.unknown-crs", crs=text[:60]), file=path, line=line, field="CRS"
        ) from error
    if unit != 1.0:
        raise InputError(
            Finding("frame.not-in-metres", crs=crs.name), file=path, line=line, field="CRS"
        )
    return list(points), code


def _outside_crs_error(path: Path, line: int | None, point: ControlPoint) -> InputError:
    x, y, _ = point.position
    if abs(x) <= 90 < abs(y) <= 180:
        return InputError(
            Finding("control.swapped-degrees", "error", label=point.label, longitude=x, latitude=y),
            file=path,
            line=line,
        )
    return InputError(Finding("control.not-on-earth", label=point.label), file=path, line=line)
