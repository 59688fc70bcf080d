"""Analysis of a surface patch relative to its plane.

The analysis includes a map of deviations, the part for which the plane is valid, the roughness by
direction, and profiles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.results import HIDDEN_IN_JSON
from vomstudio.geology.orientation import Line, Plane
from vomstudio.geology.profiles import DEFAULT_THRESHOLDS, Thresholds
from vomstudio.geology.quality import judge
from vomstudio.geology.roughness import increments
from vomstudio.geology.roughness.gaps import missing_variance
from vomstudio.geology.roughness.planar_part import PlanarPart, find_planar_part
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.heights.bends import measure_bend
from vomstudio.geometry.heights.levels import level_findings, level_gap
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.moment_planes import fit_moments
from vomstudio.geometry.patches import face_areas, face_points, moments
from vomstudio.geometry.planes import FittedPlane
from vomstudio.geometry.resolution import NEIGHBOUR_COUNTS, neighbour_statistics
from vomstudio.geometry.vectors import strike_and_dip_lines
from vomstudio.io.models.opening import resolution
from vomstudio.products.elevation.heights import compute_heights
from vomstudio.products.elevation.planning import HeightPlan, plan_heights
from vomstudio.project.tables.orientation_table import Row, plane_row

MIN_CELLS = 100
MAX_CELLS = 1_000_000
NOISE_EDGES = 0.25
"""Noise of a mesh, in mean edge lengths.

A mesh smooths the noise of its points but not systematic errors: depths from photos have errors of
about a pixel, and an edge is a few pixels long."""
MIN_DISTANCE_EDGES = 3.0
"""Minimum distance for roughness, in mesh edges or cloud spacings; below it, models are smooth."""
_NOISE_SAMPLES = 500
# Deviations below this number of rounding units of the largest coordinate or height are rounding
# errors.
_ROUNDING_UNITS = 16.0


@dataclass(frozen=True)
class Trim:
    """Part of a patch for which the plane is not valid.

    Parameters
    ----------
    share : float
        Share of the surface that this part covers.
    limit_m : float
        Minimum deviation from the plane in this part.
    turn_deg : float
        Angle between the planes fitted with and without this part.
    plane : dict
        Table row of the plane fitted without this part.
    """

    share: float
    limit_m: float
    turn_deg: float
    plane: Row


@dataclass(frozen=True)
class DirectionRoughness:
    """Hurst exponent along one direction of the plane.

    Attributes
    ----------
    rake_deg : float
        Rake of the direction from the right-hand-rule strike, [0, 180).
    trend_deg, plunge_deg : float
        Trend and plunge of the direction.
    H, error95 : float
        Exponent and its 95 % error.
    """

    rake_deg: float
    trend_deg: float
    plunge_deg: float
    H: float
    error95: float


@dataclass(frozen=True)
class Hurst:
    """Hurst exponent of all directions, for distances between `from_m` and `to_m`.

    Attributes
    ----------
    directions : tuple of DirectionRoughness
        Exponent along each direction.
    """

    H: float
    error95: float
    from_m: float
    to_m: float
    directions: tuple[DirectionRoughness, ...]


@dataclass(frozen=True)
class SmoothestLine:
    """Direction in the plane along which the surface is smoothest.

    Attributes
    ----------
    error95_deg : float
        95 % error of the rake.
    ratio : float
        Roughness across the line divided by that along it.
    p : float
        p-value of this ratio for an isotropic surface.
    """

    rake_deg: float
    trend_deg: float
    plunge_deg: float
    error95_deg: float
    ratio: float
    p: float


@dataclass(frozen=True, eq=False)
class Profile:
    """Deviations along a line in the plane, through the centre of the patch.

    Parameters
    ----------
    name : {"along", "across"}
    distance_m, deviation_m : (n,) arrays
    points : (n, 3) array
        Points on the surface in the World frame, m.
    """

    name: str
    distance_m: FloatArray
    deviation_m: FloatArray
    points: FloatArray


@dataclass(frozen=True, eq=False, repr=False)
class SurfaceFigures(PrintableResult):
    """Roughness of a patch relative to its plane.

    Parameters
    ----------
    plane : Row
    rms_m, lowest_m, highest_m : float
        RMS, minimum and maximum of the deviations from the plane, positive along its upward normal.
    noise_m : float
        Noise of the model.
    noise_from : {"given", "points", "mesh"}
        Source of the noise.
    cells : int
        Number of cells of the map.
    cell_m : float
        Cell size of the map.
    bent_share : float
        Share of the mean square deviation that a paraboloid explains.
    trim : Trim or None
        Part for which the plane is not valid; None if the plane fits the whole patch.
    hurst : Hurst or None
        Hurst exponent; if None, `hurst_reason` states why.
    smoothest : SmoothestLine or None
        Smoothest direction; if None, `smoothest_reason` states why.
    warnings : tuple of Finding
    deviations : (rows, columns) array
        Map of the deviations, m; NaN in cells without data.
    plan : HeightPlan or None
        Geometry of the map.
    point_deviations : (n,) array
        Deviation of each point of the patch, m.
    holds : (n,) bool array
        Whether the plane fits at each point.
    profiles : tuple of Profile
    """

    plane: Row
    rms_m: float
    lowest_m: float
    highest_m: float
    noise_m: float
    noise_from: str
    cells: int
    cell_m: float
    bent_share: float
    trim: Trim | None
    hurst: Hurst | None
    hurst_reason: Finding | None
    smoothest: SmoothestLine | None
    smoothest_reason: Finding | None
    warnings: tuple[Finding, ...]
    deviations: FloatArray = field(
        default_factory=lambda: np.zeros((0, 0)), metadata=HIDDEN_IN_JSON
    )
    plan: HeightPlan | None = field(default=None, metadata=HIDDEN_IN_JSON)
    point_deviations: FloatArray = field(
        default_factory=lambda: np.zeros(0), metadata=HIDDEN_IN_JSON
    )
    holds: BoolArray = field(default_factory=lambda: np.zeros(0, np.bool_), metadata=HIDDEN_IN_JSON)
    profiles: tuple[Profile, ...] = field(default=(), metadata=HIDDEN_IN_JSON)


def analyse(
    data: Mesh | PointCloud,
    *,
    noise_m: float | None = None,
    cell_m: float | None = None,
    model: str = "",
    frame: str = "local",
    thresholds: Thresholds = DEFAULT_THRESHOLDS,
    progress: Progress | None = None,
) -> SurfaceFigures:
    """Analyse the roughness of a patch relative to its plane.

    Parameters
    ----------
    data : Mesh or PointCloud
        The patch without its surroundings, in the World frame, m.
    noise_m : float, optional
        Standard deviation of the heights of the model. By default, the scatter of the points of a
        cloud about local planes, or a quarter of the mean edge of a mesh.
    cell_m : float, optional
        Cell size of the map. By default, the mean edge or spacing.
    model, frame : str
        Names that are written to the table row of the plane.
    thresholds : Thresholds
    progress : Progress, optional

    Raises
    ------
    UsageError
        If the map would be too large.
    GeometryError
        If no plane can be fitted to the patch, or if the patch is too small for a map.
    Cancelled
    """
    points, fit, area = _fit_patch(data)
    edge = resolution(data)
    noise, source = _estimate_noise(data, noise_m, edge)
    plane = Plane.from_normal(fit.normal)
    plan = plan_heights(data, plane, to_world=np.eye(4), gsd=cell_m)
    if plan.grid.width * plan.grid.height > MAX_CELLS:
        count = plan.grid.width * plan.grid.height
        raise UsageError(
            Finding("raster.too-many-cells", count=count, maximum=MAX_CELLS), field="--gsd"
        )
    heights, _ = compute_heights(data, plan, None, progress)
    base = fit.centroid[2] if plan.is_map else (fit.centroid - plan.reference) @ plane.normal()
    deviations = np.asarray(heights, np.float64) - float(base)
    cells = int(np.isfinite(deviations).sum())
    if cells < MIN_CELLS:
        raise GeometryError(
            Finding("patch.too-small", count=cells, least=MIN_CELLS, cell_m=plan.grid.gsd)
        )
    row = _row(fit, points, area, edge, model, frame, thresholds)
    planar_part = find_planar_part(deviations, noise)
    trim, is_within_noise = _trim(
        points, fit, deviations, plan, planar_part, edge, model, frame, thresholds
    )
    rounding = _ROUNDING_UNITS * max(
        float(np.finfo(values.dtype).eps * np.nanmax(np.abs(values)))
        for values in (points, heights)
    )
    offset = (points - fit.centroid) @ np.asarray(fit.axes).T
    is_cloud = not (isinstance(data, Mesh) and len(data.faces))
    is_known_point = np.isfinite(offset).all(axis=1)
    missing_variance_m2 = (
        missing_variance(offset[is_known_point, :2], offset[is_known_point, 2], noise)
        if is_cloud
        else 0.0
    )
    roughness = _roughness(deviations, plan, plane, (noise, missing_variance_m2), edge, rounding)
    known_deviations = deviations[np.isfinite(deviations)]
    line = roughness["smoothest"]
    return SurfaceFigures(
        plane=row,
        rms_m=float(np.sqrt((known_deviations**2).mean())),
        lowest_m=float(known_deviations.min()),
        highest_m=float(known_deviations.max()),
        noise_m=noise,
        noise_from=source,
        cells=len(known_deviations),
        cell_m=plan.grid.gsd,
        trim=trim,
        warnings=_warnings(
            roughness["bent_share"], trim, planar_part, known_deviations, noise, plan.grid.gsd
        ),
        deviations=deviations,
        plan=plan,
        point_deviations=(points - fit.centroid) @ plane.normal(),
        holds=is_within_noise,
        profiles=_sample_profiles(
            deviations, plan, float(base), 90.0 if line is None else line.rake_deg
        ),
        **roughness,
    )


def _fit_patch(data: Mesh | PointCloud) -> tuple[FloatArray, FittedPlane, float | None]:
    """Return the points (n, 3) of a patch, its plane, and its area if it is a mesh."""
    if isinstance(data, Mesh) and len(data.faces):
        faces = np.arange(len(data.faces))
        known_moments = moments(*face_points(data, faces))
        points, area = np.asarray(data.vertices, np.float64), float(face_areas(data, faces).sum())
    else:
        points = np.asarray(data.vertices if isinstance(data, Mesh) else data.points, np.float64)
        known_moments, area = moments(points[np.isfinite(points).all(axis=1)]), None
    return (
        points,
        fit_moments(
            known_moments.n, known_moments.mean, known_moments.scatter, known_moments.n_effective
        ),
        area,
    )


def _row(
    fit: FittedPlane,
    points: FloatArray,
    area: float | None,
    edge: float,
    model: str,
    frame: str,
    thresholds: Thresholds,
) -> Row:
    resolution_m = max(edge, fit.rms or 0.0) if math.isfinite(edge) else None
    finite_points = points[np.isfinite(points).all(axis=1)]
    bend = measure_bend(finite_points, fit.normal)
    verdict = judge(
        fit,
        resolution_m=resolution_m,
        outcrop_normal=None,
        kind="patch",
        thresholds=thresholds,
        surface_findings=level_findings(level_gap(finite_points, fit.normal)),
        bend_deg=bend,
    )
    return plane_row(
        fit,
        verdict,
        id="1",
        area_m2=area,
        resolution_m=resolution_m,
        verdict_kind="patch",
        bend_deg=bend,
        model=model,
        frame=frame,
    )


def _estimate_noise(
    data: Mesh | PointCloud, stated_noise_m: float | None, edge: float
) -> tuple[float, str]:
    if stated_noise_m is not None:
        return stated_noise_m, "given"
    if isinstance(data, Mesh) and len(data.faces):
        return NOISE_EDGES * edge, "mesh"
    from scipy.spatial import cKDTree

    points = np.asarray(data.vertices if isinstance(data, Mesh) else data.points, np.float64)
    points = points[np.isfinite(points).all(axis=1)]
    local_points = points - points.mean(axis=0)
    position = local_points[:: max(1, len(local_points) // _NOISE_SAMPLES)]
    _, neighbours = cKDTree(local_points).query(
        position, k=min(NEIGHBOUR_COUNTS[0], len(local_points))
    )
    _, noises = neighbour_statistics(local_points[neighbours])
    return float(np.median(noises[np.isfinite(noises)])), "points"


def _trim(
    points: FloatArray,
    fit: FittedPlane,
    deviations: FloatArray,
    plan: HeightPlan,
    planar_part: PlanarPart,
    edge: float,
    model: str,
    frame: str,
    thresholds: Thresholds,
) -> tuple[Trim | None, BoolArray]:
    """Return the part to exclude (or None), and a mask (n,) of points where the plane fits."""
    from scipy.ndimage import distance_transform_edt

    if not planar_part.is_trimmed:
        return None, np.ones(len(points), np.bool_)
    position = np.linalg.inv(plan.cell_to_world) @ np.c_[points, np.ones(len(points))].T
    column, row = np.floor(position[:2]).astype(np.int64)
    row, column = (
        np.clip(row, 0, planar_part.is_planar.shape[0] - 1),
        np.clip(column, 0, planar_part.is_planar.shape[1] - 1),
    )
    # Classify points beside known cells like the nearest known cell.
    nearest_cells = distance_transform_edt(
        ~np.isfinite(deviations), return_distances=False, return_indices=True
    )
    is_within_noise = np.asarray(planar_part.is_planar[tuple(nearest_cells)][row, column])
    try:
        known_moments = moments(points[is_within_noise])
        planar_fit = fit_moments(
            known_moments.n, known_moments.mean, known_moments.scatter, known_moments.n_effective
        )
    except GeometryError:
        return None, np.ones(len(points), np.bool_)
    angle = math.degrees(math.acos(min(abs(float(planar_fit.normal @ fit.normal)), 1.0)))
    planar_row = _row(planar_fit, points[is_within_noise], None, edge, model, frame, thresholds)
    return Trim(planar_part.deviating_share, planar_part.limit, angle, planar_row), is_within_noise


def _roughness(
    deviations: FloatArray,
    plan: HeightPlan,
    plane: Plane,
    noise_and_missing_variance: tuple[float, float],
    edge: float,
    rounding: float,
) -> dict[str, Any]:
    """Return `bent_share`, `hurst` and `smoothest`, or the reasons for missing values.

    Parameters
    ----------
    deviations : (rows, columns) array
        Map of the deviations, m.
    plan : HeightPlan
    plane : Plane
    noise_and_missing_variance : (float, float)
        Noise of the model, m, and variance that is missing from its map, m².
    edge : float
        Mean edge or spacing of the model, m.
    rounding : float
        Rounding error of the heights, m.
    """
    noise, missing_variance_m2 = noise_and_missing_variance
    detrended, bent_share = _remove_bend(deviations)
    min_distance = MIN_DISTANCE_EDGES * edge
    results: dict[str, Any] = {
        "bent_share": bent_share,
        "hurst": None,
        "hurst_reason": None,
        "smoothest": None,
        "smoothest_reason": None,
    }
    if float(np.nanmax(deviations) - np.nanmin(deviations)) <= rounding:
        reason = Finding("roughness.flat")
        return {**results, "bent_share": 0.0, "hurst_reason": reason, "smoothest_reason": reason}
    variations = increments.measure_variations(deviations, plan.grid.gsd, min_distance)
    if variations is None:
        reason = Finding("roughness.small-patch", shortest_m=min_distance)
        return {**results, "hurst_reason": reason, "smoothest_reason": reason}
    exponent = increments.fit_exponent(variations, noise, missing_variance_m2)
    resolved_range = increments.resolved_range(variations, noise)
    if (
        exponent is None
        and resolved_range is not None
        and resolved_range[0] <= 1.01 * float(variations.lags[0])
    ):
        results["hurst_reason"] = Finding(
            "roughness.short-range", from_m=resolved_range[0], to_m=resolved_range[1]
        )
    elif exponent is None:
        results["hurst_reason"] = Finding("roughness.below-noise", noise_m=noise)
    elif not exponent.is_single:
        results["hurst_reason"] = Finding(
            "roughness.several-exponents", short=exponent.short, long=exponent.long
        )
    elif not exponent.H + exponent.error95 > 0.0 or not exponent.H - exponent.error95 < 1.0:
        results["hurst_reason"] = Finding("roughness.invalid-exponent", exponent=exponent.H)
    else:
        directions = tuple(
            DirectionRoughness(
                *_line(variation.angle_deg, plan, plane), variation.H, variation.error95
            )
            for variation in increments.fit_directional_exponents(
                variations, noise, missing_variance_m2
            )
        )
        results["hurst"] = Hurst(
            exponent.H, exponent.error95, exponent.from_m, exponent.to_m, directions
        )
    detrended_variations = increments.measure_variations(detrended, plan.grid.gsd, min_distance)
    line = (
        None
        if detrended_variations is None
        else increments.find_smoothest_direction(detrended_variations, noise)
    )
    if line is None or math.isnan(line.p):
        results["smoothest_reason"] = Finding("roughness.direction-below-noise", noise_m=noise)
    elif not line.is_significant:
        results["smoothest_reason"] = Finding("roughness.no-direction", p=line.p)
    else:
        results["smoothest"] = SmoothestLine(
            *_line(line.angle_deg, plan, plane), line.error95_deg, line.ratio, line.p
        )
    return results


def _remove_bend(deviations: FloatArray) -> tuple[FloatArray, float]:
    """Subtract a paraboloid, and return its share of the mean square."""
    is_known = np.isfinite(deviations)
    row, column = np.nonzero(is_known)
    x = column / max(deviations.shape[1] - 1, 1) - 0.5
    y = row / max(deviations.shape[0] - 1, 1) - 0.5
    columns = np.stack([np.ones(len(x)), x, y, x * x, x * y, y * y], axis=1)
    values = deviations[is_known]
    detrended_heights = values - columns @ np.linalg.lstsq(columns, values, rcond=None)[0]
    result = np.full(deviations.shape, np.nan)
    result[is_known] = detrended_heights
    square_sum = float((values**2).sum())
    return result, 1.0 - float(
        (detrended_heights**2).sum()
    ) / square_sum if square_sum > 0.0 else 0.0


def _line(angle_deg: float, plan: HeightPlan, plane: Plane) -> tuple[float, float, float]:
    """Return the rake, trend and plunge of a direction on the map of deviations.

    `angle_deg` is measured from the rows (to the right) towards the columns (downwards).
    """
    angle = math.radians(angle_deg)
    vector = math.cos(angle) * plan.frame.right + math.sin(angle) * plan.frame.down
    line = Line.from_vector(vector).to_downward()
    strike, down = _axes(plane)
    rake = math.degrees(math.atan2(float(vector @ down), float(vector @ strike))) % 180.0
    return (0.0 if rake > 180.0 - 1e-9 else rake), line.trend_deg, line.plunge_deg


def _axes(plane: Plane) -> tuple[FloatArray, FloatArray]:
    strike, down = strike_and_dip_lines(
        np.array([plane.dip_direction_deg]), np.array([plane.dip_deg])
    )
    return strike[0], down[0]


def _sample_profiles(
    deviations: FloatArray, plan: HeightPlan, base: float, rake_deg: float
) -> tuple[Profile, ...]:
    """Sample profiles along and across a rake, through the centre of the known cells."""
    rows, columns = np.nonzero(np.isfinite(deviations))
    centre = np.array([columns.mean(), rows.mean()])
    angle, (strike, down) = math.radians(rake_deg), _axes(plan.plane)
    vector = math.cos(angle) * strike + math.sin(angle) * down
    projections = np.array([vector @ plan.frame.right, vector @ plan.frame.down])
    profiles = []
    for name, direction in (
        ("along", projections),
        ("across", np.array([-projections[1], projections[0]])),
    ):
        max_distance = math.hypot(*deviations.shape)
        steps = np.arange(-max_distance, max_distance)
        position = centre + steps[:, None] * direction
        column, row = np.floor(position + 0.5).astype(np.int64).T
        is_inside = (column >= 0) & (row >= 0)
        is_inside &= (column < deviations.shape[1]) & (row < deviations.shape[0])
        steps, column, row = steps[is_inside], column[is_inside], row[is_inside]
        values = deviations[row, column]
        is_known = np.isfinite(values)
        cells = np.c_[column + 0.5, row + 0.5, values + base, np.ones(len(values))][is_known]
        profiles.append(
            Profile(
                name,
                steps[is_known] * plan.grid.gsd,
                values[is_known],
                (cells @ plan.cell_to_world.T)[:, :3],
            )
        )
    return tuple(profiles)


def _warnings(
    bent_share: float,
    trim: Trim | None,
    planar_part: PlanarPart,
    deviations: FloatArray,
    noise: float,
    cell: float,
) -> tuple[Finding, ...]:
    warnings = []
    if trim is not None:
        warnings.append(
            Finding("patch.partly-planar", share_percent=100.0 * trim.share, turn_deg=trim.turn_deg)
        )
    if trim is not None and planar_part.remaining_plane is not None:
        first_normal, second_normal = (
            np.array([-plane[1] / cell, -plane[2] / cell, 1.0])
            for plane in (planar_part.plane, planar_part.remaining_plane)
        )
        angle = math.atan2(
            float(np.linalg.norm(np.cross(first_normal, second_normal))),
            abs(float(first_normal @ second_normal)),
        )
        warnings.append(
            Finding(
                "patch.two-planes",
                angle_deg=math.degrees(angle),
                share_percent=100.0 * (1.0 - trim.share),
                other_percent=100.0 * planar_part.other_share,
            )
        )
    robust_sigma = 1.4826 * float(np.median(np.abs(deviations - np.median(deviations))))
    if bent_share > 0.9 and robust_sigma > 2.0 * noise:
        warnings.append(Finding("patch.bent", share_percent=100.0 * bent_share))
    return tuple(warnings)
