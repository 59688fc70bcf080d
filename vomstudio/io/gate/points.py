"""Conversion of table coordinates to the World frame: east, north, up in metres."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.geometry.units import METRES_PER_UNIT
from vomstudio.io.gate.axes import (
    assumed_frame_findings,
    choose_axes,
    crs_reading_finding,
    require_crs,
)
from vomstudio.io.gate.frame_options import DEFAULT_FRAME, FrameOptions
from vomstudio.io.gate.metric import check_metric, degrees_finding
from vomstudio.io.gate.reprojection import Reprojection
from vomstudio.io.gate.stated_crs import StatedCrs, table_crs
from vomstudio.io.gis.axis_units import StatedAxes, axes_problem, unit_findings, unit_text
from vomstudio.io.gis.crs import crs_name, metric_crs, world_crs


@dataclass(frozen=True)
class ModelFrame:
    """Frame of the model to which points belong.

    Parameters
    ----------
    crs : str or None
        CRS of the World frame in metres, or None if the model has no CRS.
    """

    crs: str | None = None


@dataclass(frozen=True, eq=False)
class WorldPoints:
    """Points in the World frame.

    Parameters
    ----------
    points : (n, 3) float64
        East, north and up in metres.
    crs : str or None
        CRS of the World frame, or None for local coordinates.
    findings : tuple of Finding
        Findings about assumptions and conversions.
    """

    points: FloatArray
    crs: str | None = None
    findings: tuple[Finding, ...] = ()


def points_to_world(
    points: FloatArray,
    *,
    file: Path,
    comments: Sequence[str] = (),
    stated_crs: StatedCrs | None = None,
    options: FrameOptions = DEFAULT_FRAME,
    model: ModelFrame | None = None,
) -> WorldPoints:
    """Determine the frame of the points of a table and convert them to the World frame.

    Parameters
    ----------
    points : (n, 3) float
        Coordinates as in the file; rows with NaN are preserved.
    file : Path
        Path of the table, for error messages and for `NAME.prj` next to it.
    comments : sequence of str
        Comments of the table, which may state its CRS.
    stated_crs : StatedCrs, optional
        Statement of the file about its CRS, if the file is not a table with comments.
    options : FrameOptions
        Frame options of the caller.
    model : ModelFrame, optional
        Frame of the model to which the points belong. Points whose table states another CRS are
        converted to it; points without a stated frame are assumed to be in the World frame of the
        model.

    Returns
    -------
    WorldPoints
        Points in the World frame, with ``frame.assumed`` if neither table, options nor model define
        the frame.

    Raises
    ------
    InputError
        If the coordinates are not metric (``frame.degrees``, ``frame.geocentric``,
        ``frame.depths``, ``frame.other-axes``, ``frame.not-metric``, ``frame.undefined-place``) and
        are not converted by `options.to_crs`.
    UsageError
        If options contradict the table or each other.
    """
    points = np.ascontiguousarray(points, np.float64)
    findings: tuple[Finding, ...] = ()
    if stated_crs is None:
        stated_crs, findings = table_crs(file, comments)
    if options.up == "y":
        # x is East, y is Up, z is South.
        points = np.ascontiguousarray(points[:, [0, 2, 1]] * [1.0, -1.0, 1.0])
    axes, axis_findings = choose_axes(stated_crs.text, options, file=file)
    findings += axis_findings
    if options.to_crs is not None:
        require_crs(axes, file)
    if axes.kind == "none":
        return _local_points(points, stated_crs, findings, options, file, model)
    target = options.to_crs or (None if model is None else model.crs)
    bounds = _bounds(points)
    if target is not None and (options.to_crs is not None or not _is_same_crs(axes, target)):
        return _reproject(points, axes, target, findings, file)
    reason = axes_problem(axes, bounds)
    if reason is not None:
        raise InputError(reason, file=file, field="CRS")
    findings += unit_findings(axes)
    if axes.crs is None or axes.unit_m is None:
        # A local system has units but no position on Earth.
        return WorldPoints(points * axes.metres, None if model is None else model.crs, findings)
    field = "--crs" if options.crs is not None else "CRS"
    metric_findings = check_metric(axes.crs, bounds[:, :2], file=file, field=field)
    if model is not None and model.crs is None:
        findings += (Finding("frame.model-without-crs", file=file.name, crs=crs_name(axes.crs)),)
    world = world_crs(axes.crs, axes.unit_m)
    return WorldPoints(points * axes.metres, world, (*findings, *metric_findings))


def _local_points(
    points: FloatArray,
    stated_crs: StatedCrs,
    findings: tuple[Finding, ...],
    options: FrameOptions,
    file: Path,
    model: ModelFrame | None,
) -> WorldPoints:
    unit_m = stated_crs.unit_m or 1.0 if options.unit is None else METRES_PER_UNIT[options.unit]
    if unit_m != 1.0:
        points = points * unit_m
        unit_name = next(
            (name for name, metres in METRES_PER_UNIT.items() if metres == unit_m), None
        )
        unit = f"{unit_m:g} m" if unit_name is None else unit_text(unit_name)
        findings += (Finding("frame.unit-converted", unit=unit, height_unit=unit),)
    if options.unit is None and model is None:
        finding = degrees_finding(_bounds(points))
        findings += () if finding is None else (finding.with_file(file.name),)
    if model is None:
        findings += assumed_frame_findings(
            file,
            options,
            up=options.up or "z",
            unit=options.unit or "m",
            has_up=stated_crs.is_local,
            has_unit=stated_crs.is_local,
            severity="info",
        )
    return WorldPoints(points, None if model is None else model.crs, findings)


def _reproject(
    points: FloatArray, axes: StatedAxes, target: str, findings: tuple[Finding, ...], file: Path
) -> WorldPoints:
    """Convert points to another CRS and check that it is metric there.

    Raises InputError if a point is outside the CRS or the CRS is not metric there.
    """
    source = axes.crs
    if source is None:
        reason = axes_problem(axes, _bounds(points))
        finding = reason or crs_reading_finding(file, axes.kind)
        raise InputError(finding, file=file, field="CRS")
    code = metric_crs(target, "--to-crs")
    reprojection = Reprojection.create(source, code, height_factor=axes.metres[2])
    is_finite = np.isfinite(points).all(axis=1)
    world_points = np.full_like(points, np.nan)
    try:
        world_points[is_finite] = reprojection.apply(points[is_finite])
        metric_findings = check_metric(
            code, _bounds(world_points)[:, :2], file=file, field="--to-crs"
        )
    except InputError as error:
        if axes.kind == "geographic" and _has_swapped_axes(points[is_finite], reprojection, code):
            finding = Finding("frame.swapped-axes", file=file.name, crs=crs_name(source))
            raise InputError(finding, file=file, field="x") from error
        raise
    return WorldPoints(world_points, code, (*findings, reprojection.finding, *metric_findings))


def _has_swapped_axes(points: FloatArray, reprojection: Reprojection, code: str) -> bool:
    """Return whether points are metric in the target CRS if their degrees are swapped."""
    try:
        swapped_points = reprojection.apply(points[:, [1, 0, 2]])
        return not check_metric(code, _bounds(swapped_points)[:, :2])
    except InputError:
        return False


def _is_same_crs(axes: StatedAxes, world: str) -> bool:
    """Return whether a CRS is that of the World frame, apart from its unit."""
    from pyproj import CRS

    if axes.crs is None:
        return axes.kind == "local"
    if axes.crs == world or axes.unit_m is None:
        return axes.crs == world
    metric_world_crs = world_crs(axes.crs, axes.unit_m)
    return metric_world_crs == world or CRS.from_user_input(metric_world_crs).equals(
        CRS.from_user_input(world), True
    )


def _bounds(points: FloatArray) -> FloatArray:
    finite_points = points[np.isfinite(points).all(axis=1)]
    if not len(finite_points):
        return np.full((2, 3), np.nan)
    return np.array([finite_points.min(axis=0), finite_points.max(axis=0)])
