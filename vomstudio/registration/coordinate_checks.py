"""Checks of control points for typical mistakes.

The mistakes are swapped columns or labels, degrees, feet, a wrong zone or a wrong model frame.

Each check reports a finding with a proposal; no coordinates are changed.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import GeometryError, InputError
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.io.gate.metric import check_metric
from vomstudio.registration.checks.area_of_use import (
    AREA_TOLERANCE_DEG,
    area_distance_function,
    is_inside_area,
)
from vomstudio.registration.checks.heights import constant_height_findings, missing_height_findings
from vomstudio.registration.checks.labels import coincident_point_findings, similar_label_findings
from vomstudio.registration.checks.mirrors import fits_as_mirror
from vomstudio.registration.checks.mixed_values import mixed_row_findings
from vomstudio.registration.checks.point_groups import (
    distances_agree,
    find_larger_group,
    find_points_in_degrees,
    mixed_degree_findings,
    select_group_at_model,
    separate_group_findings,
)
from vomstudio.registration.checks.point_order import row_order_findings
from vomstudio.registration.observations import Points
from vomstudio.registration.similarity import fit_robustly, fit_similarity

_FOOT_M = 0.3048
_UNITS = (
    (1000.0, to_translate("millimetres")),
    (100.0, to_translate("centimetres")),
    (1.0 / _FOOT_M, to_translate("feet")),
    (0.001, to_translate("kilometres")),
)
# Maximum ratio of residuals for which another interpretation of the numbers is proposed.
_MAX_RESIDUAL_RATIO = 0.3
_MIN_STEEPNESS = 5.0
_MIN_RESIDUAL_SHARE = 0.01
_MIN_POINTS = 5
# Multiple of the median distance from the centre beyond which a point is misplaced.
_OUTLIER_FACTOR = 30.0
# Maximum number of points among which swapped labels are searched.
_MAX_POINTS = 60
_MAX_SWAPPED_RATIO = 0.1
# Maximum relative difference between a scale and a unit factor, if the scale is that accurate.
_SCALE_TOLERANCE = 0.005
# Maximum offset of coordinates that belong to a neighbouring zone.
_MAX_ZONE_OFFSET_DEG = 15.0
_MAX_COORDINATE_KM = 20_000.0
# Maximum rotation of a model that is already in its CRS by a registration.
_MAX_TURN_DEG = 20.0
# Multiple of the extent of the model beyond which control points do not belong to it.
_MAX_OFFSET_FACTOR = 10.0


def point_findings(
    control: Points,
    labels: Sequence[str],
    world: FloatArray,
    model: FloatArray | None = None,
    crs: str | None = None,
) -> list[Finding]:
    """Check whether the coordinates of control points were misinterpreted.

    Parameters
    ----------
    control : Points
        Points used in the fit.
    labels, world, model : sequence of str, (n, 3) array
        All points, including check points; `model` is taken from `control` by default.
    crs : str, optional
        CRS of the World frame.
    """
    duplicate_findings: list[Finding] = [
        *similar_label_findings(labels),
        *coincident_point_findings(labels, world),
    ]
    if degrees := degree_findings(world):
        return [*duplicate_findings, *degrees]
    all_points = control.model if model is None else model
    if missing_heights := missing_height_findings(labels, all_points, world):
        return [*duplicate_findings, *missing_heights]
    if misplacements := find_misplaced_points(labels, all_points, world, crs)[0]:
        return [*duplicate_findings, *misplacements]
    if constant_heights := constant_height_findings(control.model, control.world):
        return [*duplicate_findings, *constant_heights]
    if fits_as_mirror(control.model, control.world):
        # Mirror images are reported after the fit, because other interpretations of a mirror image
        # may fit by chance.
        return duplicate_findings
    control_arrays = (control.labels, control.model, control.world)
    readings: Sequence[Finding] = mixed_row_findings(*control_arrays) or misreading_findings(
        *control_arrays[1:], include_mirrors=False
    )
    readings = (
        readings or swapped_label_findings(*control_arrays) or row_order_findings(*control_arrays)
    )
    return [*duplicate_findings, *readings]


# --- single points ----------------------------------------------------------------------------
def is_far_from_others(world: FloatArray) -> BoolArray:
    """Find the points that are far from most other points.

    Parameters
    ----------
    world : (n, 3) ndarray

    Returns
    -------
    (n,) ndarray of bool
    """
    if len(world) < 4:
        return np.zeros(len(world), bool)
    distances = np.linalg.norm(world - np.median(world, axis=0), axis=1)
    median = float(np.median(distances))
    return (
        np.asarray(distances > _OUTLIER_FACTOR * median)
        if median > 0
        else np.zeros(len(world), bool)
    )


def find_misplaced_points(
    labels: Sequence[str], model: FloatArray, world: FloatArray, crs: str | None
) -> tuple[list[Finding], BoolArray]:
    """Find points that are misplaced relative to the correct points.

    Parameters
    ----------
    labels : sequence of str
    model, world : (n, 3) ndarray
    crs : str or None
        CRS of the World frame, whose area of use determines which points are correct.

    Returns
    -------
    findings : list of Finding
    misplaced : (n,) ndarray of bool
        Mask of the misplaced points; all False if it is unclear which points are correct.
    """
    degrees = find_points_in_degrees(model, world)
    if degrees.any():
        return mixed_degree_findings(labels, degrees), degrees
    is_far = is_far_from_others(world)
    if is_far.any() and distances_agree(model, world):
        return [], is_far & False
    reference_rows = ~is_far if is_far.any() else find_larger_group(model, world)
    if reference_rows is None:
        return [], is_far
    is_correct = select_group_at_model(model, world, reference_rows, is_inside_area(world, crs))
    if is_correct is None:
        return [*separate_group_findings(labels, world, reference_rows)], np.zeros(len(world), bool)
    return far_point_findings(labels, world, ~is_correct), ~is_correct


def far_point_findings(
    labels: Sequence[str], world: FloatArray, is_far: BoolArray
) -> list[Finding]:
    """Return findings about points far from the others, with the probable cause.

    Parameters
    ----------
    labels : sequence of str
    world : (n, 3) ndarray
    is_far : (n,) ndarray of bool
        Mask of the points that are far from the others.

    Returns
    -------
    list of Finding
    """
    if not is_far.any():
        return []
    median = np.median(world[~is_far], axis=0)
    max_distance = float(np.linalg.norm(world[~is_far] - median, axis=1).max())
    max_near_distance = _OUTLIER_FACTOR * max(max_distance, 1.0)
    swapped_rows: list[int] = []
    far_rows: list[int] = []
    rows_by_unit: dict[str, list[int]] = {}
    for row in np.flatnonzero(is_far):
        # Near the origin of local coordinates, divided values are always close to the others.
        is_far_from_origin = np.linalg.norm(median) > max_near_distance
        units = [
            unit
            for unit in _UNITS
            if is_far_from_origin
            and np.linalg.norm(world[row] / unit[0] - median) <= max_near_distance
        ]
        if np.linalg.norm(world[row, [1, 0, 2]] - median) <= max_near_distance:
            swapped_rows.append(int(row))
        elif units:
            rows_by_unit.setdefault(units[0][1], []).append(int(row))
        else:
            far_rows.append(int(row))
    metres_by_unit = {tr(unit): 1.0 / times for times, unit in _UNITS}
    findings: list[Finding] = [
        other_unit_finding(
            ", ".join(labels[row] for row in rows), tr(unit), metres_by_unit[tr(unit)]
        )
        for unit, rows in rows_by_unit.items()
    ]
    if swapped_rows:
        names = [labels[row] for row in swapped_rows]
        findings.append(Finding("control.swapped-columns", labels=names))
    if far_rows:
        distance = float(np.linalg.norm(world[far_rows] - median, axis=1).min())
        findings.append(
            Finding(
                "control.far-away",
                labels=[labels[row] for row in far_rows],
                distance_m=distance,
                extent_m=max_distance,
            )
        )
    return findings


def swapped_label_findings(
    labels: Sequence[str], model: FloatArray, world: FloatArray
) -> list[Finding]:
    """Return a finding if two points fit the others after their labels are swapped.

    Parameters
    ----------
    labels : sequence of str
    model, world : (n, 3) ndarray

    Returns
    -------
    list of Finding
    """
    if not _MIN_POINTS <= len(labels) <= _MAX_POINTS:
        return []
    rms = _rms(model, world)
    if rms is None or rms < _MIN_RESIDUAL_SHARE * _rms_radius(world):
        return []
    best_swap: tuple[float, int, int] | None = None
    for i, k in combinations(range(len(labels)), 2):
        label_order = np.arange(len(labels))
        label_order[[i, k]] = k, i
        rms_misfit = _rms(model, world[label_order])
        if rms_misfit is not None and (best_swap is None or rms_misfit < best_swap[0]):
            best_swap = rms_misfit, i, k
    if best_swap is None or best_swap[0] > _MAX_SWAPPED_RATIO * rms:
        return []
    # If only one point is wrong, excluding it explains the misfit as well.
    for excluded_row in best_swap[1:]:
        is_remaining = np.arange(len(labels)) != excluded_row
        rms_misfit = _rms(model[is_remaining], world[is_remaining])
        if rms_misfit is not None and rms_misfit < 2.0 * best_swap[0]:
            return []
    return [
        Finding(
            "control.swapped-labels",
            first=labels[best_swap[1]],
            second=labels[best_swap[2]],
            after_m=best_swap[0],
            before_m=rms,
        )
    ]


# --- all points -------------------------------------------------------------------------------
def degree_findings(world: FloatArray, *, distance_m: float = 0.0) -> list[Finding]:
    """Return a finding if x and y look like degrees.

    Parameters
    ----------
    world : (n, 3) ndarray
    distance_m : float, optional
        Minimum plausible extent of the points, metres.

    Returns
    -------
    list of Finding
    """
    if len(world) < 3:
        return []
    extents = np.ptp(world, axis=0)
    horizontal_extent = float(max(extents[:2]))
    for x, y, is_swapped in ((0, 1, False), (1, 0, True)):
        is_inside = (np.abs(world[:, x]) <= 180).all() and (np.abs(world[:, y]) <= 90).all()
        if is_inside and (
            0.0 < horizontal_extent < distance_m
            or (horizontal_extent < 1.0 and extents[2] > 100 * horizontal_extent)
        ):
            return [
                Finding(
                    "frame.maybe-degrees",
                    span=horizontal_extent,
                    height=float(extents[2]),
                    latitude_first=is_swapped,
                )
            ]
    return []


def misreading_findings(
    model: FloatArray, world: FloatArray, *, include_mirrors: bool = True
) -> list[Finding]:
    """Return a finding if coordinates fit the model better in another unit or column order.

    Parameters
    ----------
    model, world : (n, 3) ndarray
    include_mirrors : bool, optional
        Whether swapped x and y are tried.

    Returns
    -------
    list of Finding
    """
    if len(model) < _MIN_POINTS:
        return []
    rms = _residual_share(model, world)
    if rms is None or rms < (
        _MIN_RESIDUAL_SHARE if not _is_steep(world) else 0.1 * _MIN_RESIDUAL_SHARE
    ):
        return []
    heights, feet = tr("heights"), tr("feet")
    readings = [
        (world * [1.0, 1.0, _FOOT_M], other_unit_finding(heights, feet, _FOOT_M)),
        (world * [_FOOT_M, _FOOT_M, 1.0], other_unit_finding("x, y", feet, _FOOT_M)),
    ]
    readings += [
        (world * [1.0, 1.0, 1.0 / times], other_unit_finding(heights, tr(unit), 1.0 / times))
        for times, unit in _UNITS[:2]
        if _is_steep(world)
    ]
    if include_mirrors:
        # All mirror images fit equally well, so the residuals do not show which one is present.
        readings.append((world[:, [1, 0, 2]], Finding("control.swapped-columns", labels=())))
    better_readings = [
        (misfit, finding)
        for converted_world, finding in readings
        if (misfit := _residual_share(model, converted_world)) is not None
        and misfit < _MAX_RESIDUAL_RATIO * rms
    ]
    return [min(better_readings, key=lambda pair: pair[0])[1]] if better_readings else []


def other_unit_finding(axes: str, unit: str, factor: float) -> Finding:
    """Return the finding for coordinates that seem to be in another unit.

    Parameters
    ----------
    axes : str
        Description of the coordinates.
    unit : str
        Name of the unit.
    factor : float
        Metres per unit.
    """
    return Finding("control.other-unit", axes=axes, unit=unit, factor=factor)


def _is_steep(world: FloatArray) -> bool:
    """Return whether points (n, 3) extend much farther vertically than horizontally.

    The heights of other points are not tried in millimetres and centimetres, because smaller
    heights always fit flat ground better.
    """
    return float(np.ptp(world[:, 2])) > _MIN_STEEPNESS * float(
        np.linalg.norm(np.ptp(world[:, :2], axis=0))
    )


def scale_unit_findings(scale: float, scale_error_95: float | None) -> list[Finding]:
    """Return a finding if the scale of a registration equals a unit factor, such as feet.

    Parameters
    ----------
    scale : float
        Metres per unit of the model.
    scale_error_95 : float or None
        Relative 95 % error of the scale.

    Returns
    -------
    list of Finding
    """
    if scale_error_95 is None or scale_error_95 > 4 * _SCALE_TOLERANCE:
        return []
    tolerance = max(_SCALE_TOLERANCE, scale_error_95)
    for times, unit in _UNITS:
        if abs(scale / times - 1.0) < tolerance:
            return [
                Finding("control.scale-of-unit", scale=scale, unit=tr(unit), factor=1.0 / times)
            ]
    return []


def check_area(world: FloatArray, crs: str | None, *, is_converted: bool = False) -> list[Finding]:
    """Check that a projected CRS is metric at the control points or cameras.

    Parameters
    ----------
    world : (n, 3) float
        Coordinates in `crs`.
    crs : str or None
        Projected CRS in metres.
    is_converted : bool
        Whether the coordinates were converted from longitude and latitude, so that their unit is
        correct.

    Returns
    -------
    list of Finding
        ``frame.outside-area`` if the coordinates are outside the area of use;
        ``control.other-unit`` if they would be inside it in feet or kilometres.

    Raises
    ------
    InputError
        If the CRS is not metric there, with ``control.other-unit`` or the code of
        `vomstudio.io.gate.metric.check_metric`.
    """
    if crs is None or not len(world):
        return []
    x, y = np.median(world, axis=0)[:2].tolist()
    hint = None if is_converted else _area_unit_finding(x, y, crs)
    try:
        findings = check_metric(crs, np.array([[x, y], [x, y]]), field="--crs")
    except InputError as error:
        if hint is None or error.code == "frame.swapped-axes":
            raise
        raise InputError(hint, field="--crs") from error
    return [*([] if hint is None else [hint]), *findings]


def _area_unit_finding(x: float, y: float, crs: str) -> Finding | None:
    """Return a finding about the unit in which a position would be in the area of use.

    Returns None if the position is already in the area, or in no unit.
    """
    distance_to_area = area_distance_function(crs)
    if (
        distance_to_area is None
        or (distance_deg := distance_to_area(x, y)[0]) <= AREA_TOLERANCE_DEG
    ):
        return None
    if distance_to_area(y, x)[0] == 0.0:
        return None
    units = (
        (1000.0, tr("kilometres"), max(abs(x), abs(y)) < _MAX_COORDINATE_KM),
        (_FOOT_M, tr("feet"), distance_deg > _MAX_ZONE_OFFSET_DEG),
    )
    for factor, unit, is_plausible in units:
        if is_plausible and distance_to_area(x * factor, y * factor)[0] == 0.0:
            return other_unit_finding("x, y", unit, factor)
    return None


# --- model ------------------------------------------------------------------------------------
def require_on_model(model: FloatArray, extent: FloatArray | None) -> None:
    """Check that points on the model (n, 3) are near it.

    If they are not, their table is in another frame, for example with an offset subtracted.

    Parameters
    ----------
    model : (n, 3) float
    extent : (m, 3) float or None
        Points distributed over the model.

    Raises
    ------
    GeometryError
        If most points are far from the model.
    """
    if extent is None or not len(extent) or not len(model):
        return
    low, high = extent.min(axis=0), extent.max(axis=0)
    diagonal = float(np.linalg.norm(high - low))
    offset = np.maximum(np.maximum(low - model, model - high), 0.0)
    if (
        diagonal > 0
        and float(np.median(np.linalg.norm(offset, axis=1))) > _MAX_OFFSET_FACTOR * diagonal
    ):
        points_centre, model_centre = np.median(model, axis=0), (low + high) / 2
        raise GeometryError(
            Finding(
                "registration.off-model",
                x=float(points_centre[0]),
                y=float(points_centre[1]),
                z=float(points_centre[2]),
                mx=float(model_centre[0]),
                my=float(model_centre[1]),
                mz=float(model_centre[2]),
            )
        )


def relocation_findings(extent: FloatArray, placed_points: FloatArray, crs: str) -> list[Finding]:
    """Return a finding if a registration moves or rotates a georeferenced model considerably.

    Parameters
    ----------
    extent, placed_points : (n, 3) ndarray
        Points of the model before and after the registration.
    crs : str
        CRS of both sets of points.

    Returns
    -------
    list of Finding
    """
    from vomstudio.io.gis.crs import crs_name

    if not len(extent):
        return []
    distance_m = float(np.linalg.norm(placed_points.mean(axis=0) - extent.mean(axis=0)))
    extent_m = float(np.linalg.norm(np.ptp(extent, axis=0)))
    if distance_m <= max(_MAX_OFFSET_FACTOR * extent_m, 1000.0):
        angle = _rotation_deg(extent, placed_points)
        return (
            []
            if angle <= _MAX_TURN_DEG
            else [Finding("registration.turned", turn_deg=angle, crs=crs_name(crs))]
        )
    return [Finding("registration.moved", distance_km=distance_m / 1000.0, crs=crs_name(crs))]


def _rotation_deg(model_before: FloatArray, model_after: FloatArray) -> float:
    """Return the rotation between two sets of points (n, 3), or 0 if it is undetermined."""
    try:
        fit = fit_similarity(
            model_before - model_before.mean(axis=0), model_after - model_after.mean(axis=0)
        )
    except GeometryError:
        return 0.0
    return float(np.degrees(np.arccos(np.clip((np.trace(fit.rotation) - 1.0) / 2.0, -1.0, 1.0))))


def view_direction_findings(forward: FloatArray) -> list[Finding]:
    """Return a finding if most cameras look at the sky after the registration.

    Parameters
    ----------
    forward : (n, 3) ndarray
        Unit vectors of the view directions in the World frame.

    Returns
    -------
    list of Finding
    """
    # Photos of cave roofs and overhangs also look up, but rarely nearly all photos of a set.
    if len(forward) < 3 or float(np.median(forward[:, 2])) < 0.7:
        return []
    return [Finding("cameras.look-up", count=len(forward))]


def position_noise_findings(world: FloatArray, placed_points: FloatArray) -> list[Finding]:
    """Return a finding if the errors of camera positions are as large as their spacing.

    Parameters
    ----------
    world, placed_points : (n, 3) ndarray
        Stated positions, and positions after the registration.

    Returns
    -------
    list of Finding
    """
    rms_misfit = (
        float(np.sqrt(((placed_points - world) ** 2).sum(axis=1).mean())) if len(world) else 0.0
    )
    extent_m = _rms_radius(placed_points) if len(world) else 0.0
    if not rms_misfit > 0.5 * extent_m > 0:
        return []
    return [Finding("cameras.noise", error_m=rms_misfit, extent_m=extent_m)]


# --- common functions -------------------------------------------------------------------------
def _rms_radius(points: FloatArray) -> float:
    return float(np.sqrt(((points - points.mean(axis=0)) ** 2).sum(axis=1).mean()))


def _rms(model: FloatArray, world: FloatArray) -> float | None:
    local_points = world - world.mean(axis=0)
    try:
        fit = fit_similarity(model, local_points)
    except GeometryError:
        return None
    return float(np.sqrt(((fit(model) - local_points) ** 2).sum(axis=1).mean()))


def _residual_share(model: FloatArray, world: FloatArray) -> float | None:
    """Return the median residual of a similarity as a share of the extent of the points.

    Returns None if the points do not determine a similarity.
    """
    local_points = world - world.mean(axis=0)
    try:
        fit, _ = fit_robustly(model, local_points)
    except GeometryError:
        return None
    median_misfit = float(np.median(np.linalg.norm(fit(model) - local_points, axis=1)))
    return median_misfit / max(_rms_radius(local_points), 1e-300)
