"""Registration of the model by the GPS positions of its cameras."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.geology.bowing import fit_bowing
from vomstudio.photogrammetry.align.photo_protocol import PhotoLike
from vomstudio.photogrammetry.align.priors import Calibration
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.georeferencing.gps_priors import (
    HEIGHT_ERROR_FACTOR,
    adjust_to_positions,
    known_centres,
)
from vomstudio.photogrammetry.georeferencing.placement import (
    MAX_ROTATION_ERROR_DEG,
    Placement,
    placement_errors,
)
from vomstudio.photogrammetry.georeferencing.world_frame import integer_origin, place_in_world
from vomstudio.registration.scatter import Scatter, drift_findings, estimate_scatter
from vomstudio.registration.similarity import (
    fit_robustly,
    is_nearly_collinear,
)

if TYPE_CHECKING:
    from vomstudio.core.progress import Progress


_WARNING_ROTATION_DEG = 2.0
_MIN_SPREAD_M = 0.5
# Ratio of the stated horizontal 68 % radius to the standard deviation of one coordinate.
_RADIUS_PER_SIGMA = 1.5
# 68 % radius of a typical receiver.
_DEFAULT_ACCURACY_M = 3.0
ABOVE_SEA_LEVEL, ABOVE_ELLIPSOID = "above sea level", "above the ellipsoid"


@dataclass(frozen=True, eq=False, kw_only=True)
class GpsReport(Placement):
    """Registration by the GPS positions of the photos.

    Parameters
    ----------
    names : tuple of str
        Names of the photos with a position.
    positions : (n, 3) array
        Positions in the World frame, as stated by the photos.
    residuals_m : (n, 3) array
        Position in the model minus GPS position: east, north, up.
    used : (n,) bool array
        Whether each position was used; False if it was excluded as wrong.
    rms_m : float
        RMS length of the residuals of the used positions.
    heights : str
        ABOVE_SEA_LEVEL or ABOVE_ELLIPSOID.
    """

    names: tuple[str, ...]
    positions: FloatArray
    residuals_m: FloatArray
    used: BoolArray
    rms_m: float
    heights: str


def place_by_gps(
    scene: SparseScene,
    photos: Sequence[PhotoLike],
    crs: str | None = None,
    *,
    cameras: Sequence[Calibration] = (),
    threads: int = -1,
    progress: Progress | None = None,
) -> tuple[SparseScene, GpsReport]:
    """Register the scene by GPS positions of photos, and adjust it with them if useful.

    See `gps_priors` for the adjustment.

    Parameters
    ----------
    scene : SparseScene
    photos : sequence of PhotoLike
    crs : str, optional
        Projected CRS in metres, "EPSG:n". By default, the UTM zone (WGS 84) of the photos.
    cameras : sequence of Calibration
        Calibrated cameras. If given, their errors are included in the stated errors.
    threads : int
    progress : Progress, optional

    Raises
    ------
    GeometryError
        If the positions cannot place the scene.
    UsageError, InputError
        If the CRS cannot be used.
    """
    rows, placed_photos = _photos_with_position(scene, photos)
    crs = select_crs(placed_photos, crs)
    world = world_positions(placed_photos, crs)
    spread = world - world.mean(axis=0)
    # Use the horizontal spread: a receiver that has lost its satellites repeats a position,
    # although its heights may still vary.
    if float(np.linalg.norm(spread[:, :2], axis=1).max()) < _MIN_SPREAD_M:
        raise GeometryError(
            Finding(
                "gps-equal",
                "error",
                value=len(placed_photos),
                photos=[photo.name for photo in placed_photos],
            )
        )
    centres = scene.centres[rows]
    stated_accuracy = _stated_accuracy(placed_photos)
    _require_not_collinear(centres, spread)
    origin = integer_origin(world)
    local_points = world - origin
    # A receiver that does not state its accuracy may drift, so positions within its drift are not
    # treated as wrong.
    min_sigma = 2.5 * (stated_accuracy or _DEFAULT_ACCURACY_M / 2)
    fit, is_used = fit_robustly(centres, local_points, min_sigma=min_sigma)
    scatter = _estimate_scatter(fit(centres), local_points, is_used, stated_accuracy)
    position_sigmas = _position_sigmas(placed_photos, stated_accuracy or scatter.horizontal_sigma)
    adjusted_scene, gps_adjustment = adjust_to_positions(
        place_in_world(scene, fit, origin, crs),
        rows,
        local_points,
        position_sigmas,
        threads=threads,
        progress=progress,
    )
    residuals = fit(centres) - local_points
    if gps_adjustment.adjusted:
        _, is_used = fit_robustly(adjusted_scene.centres[rows], local_points, min_sigma=min_sigma)
        scatter = _estimate_scatter(
            adjusted_scene.centres[rows], local_points, is_used, stated_accuracy
        )
        residuals = adjusted_scene.centres[rows] - local_points
    used_indices = np.asarray(rows)[is_used]
    report = GpsReport(
        **placement_errors(
            adjusted_scene,
            cameras,
            scatter,
            lambda other: other.centres[used_indices],
            local_points[is_used],
            lenses=gps_adjustment.lenses if gps_adjustment.adjusted else None,
            centres=known_centres(used_indices, local_points[is_used], position_sigmas[is_used]),
        ),
        scale=fit.scale,
        crs=crs,
        adjusted=gps_adjustment.adjusted,
        decisions=(gps_adjustment.reason, *(lens.reason for lens in gps_adjustment.lenses)),
        lenses=gps_adjustment.lenses,
        bowing=fit_bowing(
            world[is_used], residuals[is_used], extent=adjusted_scene.points + np.array(origin)
        ),
        names=tuple(photo.name for photo in placed_photos),
        positions=world,
        residuals_m=residuals,
        used=is_used,
        rms_m=float(np.sqrt((residuals[is_used] ** 2).sum(1).mean())),
        heights=_height_reference(placed_photos),
    )
    warnings = [
        *_gps_findings(report, scene, placed_photos),
        *drift_findings({"cameras": scatter.drift}),
    ]
    return adjusted_scene, replace(report, warnings=tuple(warnings))


def _photos_with_position(
    scene: SparseScene, photos: Sequence[PhotoLike]
) -> tuple[list[int], list[PhotoLike]]:
    """Return the rows of the views with a GPS position, and their photos.

    Raises GeometryError if there are fewer than three.
    """
    photo_by_name = {photo.name: photo for photo in photos}
    rows, placed_photos = [], []
    for row, view in enumerate(scene.views):
        photo = photo_by_name.get(view.name)
        if photo is not None and has_position(photo):
            rows.append(row)
            placed_photos.append(photo)
    if not placed_photos:
        raise GeometryError(Finding("gps-few", "error", total=len(scene.views), photos=(), value=0))
    if len(placed_photos) < 3:
        raise GeometryError(
            Finding(
                "gps-few",
                "error",
                value=len(placed_photos),
                total=len(scene.views),
                photos=[photo.name for photo in placed_photos],
            )
        )
    return rows, placed_photos


def _estimate_scatter(
    centres: FloatArray, local_points: FloatArray, is_used: BoolArray, stated_sigma: float | None
) -> Scatter:
    """Estimate the errors of a registration by camera positions.

    Raises GeometryError if the positions do not determine the registration.

    centres, local_points : (n, 3) camera centres and GPS positions
    """
    position_sigmas = (
        None
        if stated_sigma is None
        else np.array([stated_sigma, stated_sigma, HEIGHT_ERROR_FACTOR * stated_sigma])
    )
    scatter = estimate_scatter(
        local_points[is_used], (centres - local_points)[is_used], position_sigmas, is_ordered=True
    )
    sigma = scatter.horizontal_sigma
    centred_positions = local_points[is_used] - local_points[is_used].mean(axis=0)
    baseline = float(np.sqrt((centred_positions**2).sum(1).mean()))
    if sigma > 0.5 * baseline:
        raise GeometryError(Finding("gps.imprecise", sigma_m=sigma, spread_m=baseline))
    worst_rotation = scatter.worst_rotation_deg
    if worst_rotation > MAX_ROTATION_ERROR_DEG:
        raise GeometryError(Finding("gps.rotation", sigma_m=sigma, rotation_deg=worst_rotation))
    return scatter


def select_crs(photos: Sequence[PhotoLike], crs: str | None) -> str:
    """Return the requested CRS after checking it, or the UTM zone of the photos.

    Raises UsageError if the unit of the CRS is not the metre.
    """
    from vomstudio.io.gis.crs import parse_crs, utm_zone

    if crs is not None:
        code, unit = parse_crs(crs)
        if unit != 1.0:
            raise UsageError(Finding("frame.not-in-metres", crs=code), field="CRS")
        return code
    longitude = float(np.median([p.longitude_deg for p in photos]))
    latitude = float(np.median([p.latitude_deg for p in photos]))
    return utm_zone(longitude, latitude)


def world_positions(photos: Sequence[PhotoLike], crs: str) -> FloatArray:
    """Return the east, north and stated altitude (n, 3) of the photos.

    Raises GeometryError if a position lies outside the area of the CRS.
    """
    from vomstudio.io.gis.crs import degrees_to_grid

    to_grid = degrees_to_grid(crs)
    rows = []
    for photo in photos:
        position = to_grid(float(photo.longitude_deg or 0), float(photo.latitude_deg or 0))
        if position is None:
            raise GeometryError(Finding("crs.outside-area", photo=photo.name, crs=crs))
        rows.append((*position, float(photo.altitude_m or 0)))
    return np.array(rows, np.float64)


def has_position(photo: PhotoLike) -> bool:
    """Return whether a photo states latitude, longitude and altitude."""
    values = (photo.latitude_deg, photo.longitude_deg, photo.altitude_m)
    return all(v is not None and math.isfinite(v) for v in values)


def _stated_accuracy(photos: Sequence[PhotoLike]) -> float | None:
    """Return the typical stated error of one coordinate, or None if few photos state it."""
    stated_accuracies = [p.gps_accuracy_m for p in photos if p.gps_accuracy_m]
    return (
        float(np.median(stated_accuracies)) / _RADIUS_PER_SIGMA
        if len(stated_accuracies) > len(photos) / 2
        else None
    )


def _position_sigmas(photos: Sequence[PhotoLike], default_m: float) -> FloatArray:
    """Return the horizontal error (n,) of each photo, by default `default_m`."""
    return np.array([(p.gps_accuracy_m or 0) / _RADIUS_PER_SIGMA or default_m for p in photos])


def _require_not_collinear(centres: FloatArray, spread: FloatArray) -> None:
    """Raise GeometryError if the cameras are collinear in the scene or according to GPS."""
    if is_nearly_collinear(centres) or is_nearly_collinear(spread):
        raise GeometryError(Finding("collinear", "error", photos=(), value=None))


def _height_reference(photos: Sequence[PhotoLike]) -> str:
    ellipsoid = sum(p.altitude_reference == "ellipsoid" for p in photos)
    return ABOVE_ELLIPSOID if ellipsoid > len(photos) / 2 else ABOVE_SEA_LEVEL


def _gps_findings(
    report: GpsReport, scene: SparseScene, photos: Sequence[PhotoLike]
) -> Iterator[Finding]:
    yield from report.findings(_WARNING_ROTATION_DEG, "gps")
    excluded_names = [n for n, u in zip(report.names, report.used, strict=True) if not u]
    if excluded_names:
        yield Finding(
            "cameras.left-out",
            count=len(excluded_names),
            photos=excluded_names,
        )
    references = {p.altitude_reference for p in photos if p.altitude_reference}
    if len(references) > 1:
        yield Finding("gps.mixed-heights")
    if len(report.names) < len(scene.views):
        yield Finding("gps.missing", count=len(scene.views) - len(report.names))
