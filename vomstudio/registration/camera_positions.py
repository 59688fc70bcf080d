"""Conversion, checks and outliers of camera positions in the CRS of a model."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import GeometryError, InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.coordinate_limits import check_longitude_latitude
from vomstudio.io.control.observation_tables import Positions
from vomstudio.registration.checks.heights import constant_height_findings, missing_height_findings
from vomstudio.registration.checks.mirrors import fits_as_mirror
from vomstudio.registration.checks.mixed_values import mixed_row_findings
from vomstudio.registration.checks.point_order import row_order_findings
from vomstudio.registration.coordinate_checks import (
    degree_findings,
    find_misplaced_points,
    misreading_findings,
)
from vomstudio.registration.observations import Points
from vomstudio.registration.selection import select_names
from vomstudio.registration.similarity import fit_robustly, is_nearly_collinear

_MIN_DISTANCE_M = 0.01  # minimum plausible distance between photos
ToGrid = Callable[[float, float], tuple[float, float] | None]


def positions_in_metres(
    positions: Positions, crs: str | None, findings: list[Finding]
) -> tuple[Positions, str | None, tuple[float, float] | None]:
    """Convert camera positions to metres in the CRS of the model.

    Positions without a height, or with a height reference other than that of most, are excluded.

    Parameters
    ----------
    positions : Positions
    crs : str or None
        "EPSG:n" or WKT of the model. If None, the CRS of the file is used.
    findings : list of Finding
        List to which findings about assumptions and excluded positions are appended.

    Returns
    -------
    positions : Positions
    crs : str or None
        CRS of the model.
    place : (float, float) or None
        Longitude and latitude of a point among the positions, or None if unknown.

    Raises
    ------
    InputError
        If the CRS of the file cannot be used, if no position has a height, or if a position is
        invalid or outside the area of the CRS.
    UsageError
        If the positions are in degrees and `crs` is None.
    """
    positions, crs, to_grid = _find_conversions(positions, crs)
    positions = _drop_missing_heights(positions, findings)
    if to_grid is None:
        return positions, crs, None
    locations = positions.coordinates.copy()
    degrees = _to_degrees(positions, to_grid[1])
    _refuse_swapped_degrees(positions, degrees, crs)
    for row, (longitude, latitude) in enumerate(degrees.tolist()):
        grid_position = to_grid[0](longitude, latitude)
        if grid_position is None:
            raise InputError(
                Finding("crs.outside-area", photo=positions.photos[row], crs=crs),
                file=positions.file,
            )
        locations[row, :2] = grid_position
    median = np.median(degrees, axis=0)
    findings.append(_heights_finding(positions, float(median[0]), float(median[1])))
    converted_positions = replace(positions, coordinates=locations, is_in_degrees=False, crs=crs)
    return converted_positions, crs, (float(median[0]), float(median[1]))


def _find_conversions(
    positions: Positions, crs: str | None
) -> tuple[Positions, str | None, tuple[ToGrid, ToGrid | None] | None]:
    """Return the positions, the CRS, and the conversions to that CRS.

    The first conversion is from longitude and latitude to the CRS of the model. The second is from
    x and y of the file to longitude and latitude, or None if the file contains these. If one of the
    two CRS is unknown, there are no conversions (None).
    """
    from pyproj import CRS, Transformer
    from pyproj.exceptions import CRSError

    from vomstudio.io.gis.crs import degrees_to_grid, parse_crs, utm_zone

    file_crs = None
    if positions.crs is not None:
        try:
            file_crs = CRS.from_user_input(positions.crs)
        except CRSError as error:
            raise _unknown_crs_error(positions) from error
        file_crs = file_crs.sub_crs_list[0] if file_crs.is_compound else file_crs
        if file_crs.is_geographic:
            positions = replace(positions, is_in_degrees=True)
        elif crs is None:
            code, unit = parse_crs(file_crs.to_wkt())
            if unit != 1.0:
                raise InputError(
                    Finding("frame.not-in-metres", crs=file_crs.name),
                    file=positions.file,
                    line=positions.line,
                )
            crs = code
    if positions.is_in_degrees:
        if crs is None:
            first_position = positions.coordinates[0]
            zone = ""
            if check_longitude_latitude(float(first_position[0]), float(first_position[1])) is None:
                zone = utm_zone(float(first_position[0]), float(first_position[1]))
            raise UsageError(
                Finding("cameras.in-degrees", zone=zone or "EPSG:32633"),
                field="--crs",
            )
        base = "EPSG:4326" if file_crs is None else file_crs.to_wkt()
        return positions, crs, (degrees_to_grid(crs, base), None)
    if file_crs is None or crs is None:
        return positions, crs, None
    to_degrees = Transformer.from_crs(file_crs, "EPSG:4326", always_xy=True)

    def to_longitude_latitude(x: float, y: float) -> tuple[float, float] | None:
        longitude, latitude = to_degrees.transform(x, y)[:2]
        is_finite = np.isfinite([longitude, latitude]).all()
        return (float(longitude), float(latitude)) if is_finite else None

    return positions, crs, (degrees_to_grid(crs), to_longitude_latitude)


def _unknown_crs_error(positions: Positions) -> InputError:
    return InputError(
        Finding("frame.unknown-crs", crs=(positions.crs or "")[:60]),
        file=positions.file,
        line=positions.line,
    )


def _to_degrees(positions: Positions, convert: ToGrid | None) -> FloatArray:
    """Return longitude and latitude (n, 2). Raises InputError if they are invalid."""
    degrees = positions.coordinates[:, :2].copy()
    for row, (x, y) in enumerate(positions.coordinates[:, :2].tolist()):
        position = (x, y) if convert is None else convert(x, y)
        photo = positions.photos[row]
        if position is None:
            finding = Finding("crs.outside-area", photo=photo, crs=positions.crs)
            raise InputError(finding, file=positions.file)
        if (reason := check_longitude_latitude(*position)) is not None:
            if convert is None and check_longitude_latitude(y, x) is None:
                raise _swapped_degrees_error(positions, photo, x, y)
            raise InputError(reason, file=positions.file, field=photo)
        degrees[row] = position
    return degrees


def _refuse_swapped_degrees(positions: Positions, degrees: FloatArray, crs: str | None) -> None:
    """Raise InputError if positions are in the area of the CRS only with swapped degrees."""
    from pyproj import CRS

    area = CRS.from_user_input(crs).area_of_use if crs is not None else None
    if area is None:
        return
    west, south, east, north = area.bounds

    def are_in_range(longitude: FloatArray, latitude: FloatArray) -> bool:
        is_around = (longitude - west) % 360.0 <= (east - west) % 360.0
        return bool((is_around & (latitude >= south) & (latitude <= north)).mean() > 0.5)

    if not are_in_range(*degrees.T) and are_in_range(degrees[:, 1], degrees[:, 0]):
        raise _swapped_degrees_error(positions, positions.photos[0], *degrees[0].tolist())


def _swapped_degrees_error(
    positions: Positions, photo: str, longitude: float, latitude: float
) -> InputError:
    finding = Finding(
        "control.swapped-degrees", "error", label=photo, longitude=longitude, latitude=latitude
    )
    return InputError(finding, file=positions.file)


# --- heights ----------------------------------------------------------------------------------
def _drop_missing_heights(positions: Positions, findings: list[Finding]) -> Positions:
    has_height = np.isfinite(positions.coordinates[:, 2])
    if not has_height.any():
        raise InputError(
            Finding("cameras.no-heights"),
            file=positions.file,
        )
    if not has_height.all():
        findings.append(
            Finding(
                "cameras.without-height",
                count=int((~has_height).sum()),
                photos=select_names(positions.photos, ~has_height),
            )
        )
    references = np.array([_normalise_reference(reference) for reference in positions.heights])
    if len(references):
        most_common_reference = Counter(references[has_height].tolist()).most_common(1)[0][0]
        has_other_reference = has_height & (references != most_common_reference)
        if has_other_reference.any():
            findings.append(
                Finding(
                    "cameras.other-heights",
                    count=int(has_other_reference.sum()),
                    usual=_reference_name(most_common_reference),
                    photos=select_names(positions.photos, has_other_reference),
                )
            )
            has_height &= ~has_other_reference
    if has_height.all():
        return positions
    rows = np.flatnonzero(has_height)
    return replace(
        positions,
        photos=tuple(positions.photos[i] for i in rows),
        coordinates=positions.coordinates[rows],
        sigma=positions.sigma[rows],
        heights=tuple(positions.heights[i] for i in rows) if positions.heights else (),
    )


def _normalise_reference(reference: str) -> str:
    return "sea level" if reference == "below sea level" else reference


def _reference_name(reference: str) -> str:
    return {
        "ellipsoid": tr("above the ellipsoid"),
        "sea level": tr("above sea level"),
    }.get(reference, tr("unknown reference"))


def _heights_finding(positions: Positions, longitude: float, latitude: float) -> Finding:
    """Report the reference of the heights, as far as the photos state it."""
    from vomstudio.io.gis.heights import geoid_height_m

    geoid_m = geoid_height_m(longitude, latitude)
    reference = _normalise_reference(positions.heights[0]) if positions.heights else ""
    return Finding(
        "cameras.heights",
        reference=_reference_name(reference),
        heights=reference or None,
        geoid=tr("up to 100 m") if geoid_m is None else tr("{height:+.1f} m", height=geoid_m),
        geoid_m=geoid_m,
    )


# --- misread positions ------------------------------------------------------------------------
def require_separate_positions(world: FloatArray) -> None:
    """Check that positions of cameras are neither in degrees nor all equal.

    Parameters
    ----------
    world : (n, 3) ndarray

    Raises
    ------
    GeometryError
        If the positions are in degrees or all equal.
    """
    if degrees := degree_findings(world, distance_m=_MIN_DISTANCE_M):
        raise GeometryError(degrees[0])
    if len(world) > 1 and float(np.ptp(world[:, :2], axis=0).max()) < _MIN_DISTANCE_M:
        raise GeometryError(Finding("gps-equal", "error", value=len(world), photos=()))


def select_consistent_cameras(
    labels: Sequence[str],
    model: FloatArray,
    world: FloatArray,
    sigma: FloatArray,
    *,
    is_alone: bool,
    crs: str | None = None,
) -> tuple[Points, list[Finding], list[Finding]]:
    """Select the camera positions that are consistent with most other positions.

    Parameters
    ----------
    labels : sequence of str
    model, world, sigma : (n, 3) array
    is_alone : bool
        Whether no other observations determine the position of the model.
    crs : str, optional
        CRS of the World frame.

    Returns
    -------
    cameras : Points
    suspicions : list of Finding
        Findings about suspicious positions.
    exclusions : list of Finding
        Findings about excluded positions.

    Raises
    ------
    GeometryError
        If the positions are in degrees or all equal, or if they are the only observations and
        collinear.
    """
    require_separate_positions(world)
    misplacement_findings, is_far = find_misplaced_points(labels, model, world, crs)
    misplacement_findings = [
        *(missing_height_findings(labels, model, world) or misplacement_findings)
    ]
    is_used = ~is_far
    used_rows = np.flatnonzero(is_used)
    is_collinear = is_nearly_collinear(model[used_rows]) or is_nearly_collinear(world[used_rows])
    if is_alone and len(labels) >= 3 and is_collinear:
        collinear_finding = Finding("collinear", "error", photos=list(labels), value=None)
        raise GeometryError(
            misplacement_findings[0] if misplacement_findings else collinear_finding
        )
    if len(used_rows) >= 3:
        findings, affects_all = _check_positions(
            [labels[int(i)] for i in used_rows], model[used_rows], world[used_rows]
        )
        misplacement_findings += findings
        if not affects_all:
            is_used[used_rows] = _is_inlier(model[used_rows], world[used_rows], sigma[used_rows])
    exclusions: list[Finding] = []
    if not is_used.all():
        exclusions.append(
            Finding(
                "cameras.left-out",
                count=int((~is_used).sum()),
                photos=select_names(labels, ~is_used),
            )
        )
    rows = np.flatnonzero(is_used)
    cameras = Points(
        [labels[int(i)] for i in rows], model[rows], world[rows], sigma[rows], "cameras"
    )
    return cameras, misplacement_findings, exclusions


def _check_positions(
    labels: Sequence[str], model: FloatArray, world: FloatArray
) -> tuple[list[Finding], bool]:
    """Return findings about all positions, and whether they affect all of them."""
    findings: list[Finding] = [
        *(
            constant_height_findings(model, world)
            or row_order_findings(labels, model, world, is_photo_table=True)
        )
    ]
    if findings or fits_as_mirror(model, world):
        return findings, True
    mixed_findings = mixed_row_findings(labels, model, world)
    return mixed_findings or misreading_findings(model, world, include_mirrors=False), False


def _is_inlier(model: FloatArray, world: FloatArray, sigma: FloatArray) -> BoolArray:
    known_sigma = sigma[np.isfinite(sigma)]
    min_sigma = 3 * float(known_sigma.max()) if len(known_sigma) else 0.0
    # Positions on a line are consistent with any rotation about it.
    with suppress(GeometryError):
        return fit_robustly(model, world, min_sigma=min_sigma)[1]
    return np.ones(len(model), bool)
