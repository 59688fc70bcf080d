"""Registration of the model by the GPS positions of its cameras."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from vomstudio.core.findings import Finding
from vomstudio.errors import GeometryError, UsageError
from vomstudio.geology.bowing import Bowing, LensBend, bowing_of
from vomstudio.photogrammetry.align.photo_like import PhotoLike
from vomstudio.photogrammetry.align.priors import Calibration
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.place.control_adjustment import MAX_ROTATION_ERROR_DEG
from vomstudio.photogrammetry.place.gps_priors import (
    HEIGHTS_WORSE,
    GpsAdjustment,
    adjust_to_positions,
    known_centres,
)
from vomstudio.photogrammetry.place.ground_calibration import LensVerdict
from vomstudio.photogrammetry.place.lens_errors import LensEffect, lens_effect, same
from vomstudio.photogrammetry.place.world_frame import integer_origin, moved
from vomstudio.registration.remarks import bowing_findings, lens_findings
from vomstudio.registration.scatter import drift_findings, scale_findings, scatter_of
from vomstudio.registration.similarity import (
    Similarity,
    fit_robustly,
    fit_similarity,
    nearly_on_a_line,
)

if TYPE_CHECKING:
    from vomstudio.progress import Progress

Array = npt.NDArray[np.float64]

_WARN_DEG = 2.0
_SAME_SPOT_M = 0.5
# Receivers state a horizontal radius of 68 %, which is so many errors of one coordinate.
_RADIUS = 1.5
# Radius of 68 % of an ordinary receiver's positions.
_DEFAULT_ACCURACY_M = 3.0


@dataclass(frozen=True, eq=False)
class GpsReport:
    """names : photos with a position
    residuals_m : (n, 3) model less GPS, east, north, up
    used : (n,) False for positions that were left out as wrong
    rms_m : of the used residuals' lengths
    sigma_m, sigma_height_m : error of a horizontal coordinate and of a height: what the residuals
        say, or what the receiver states where that is more
    scale : units of the scene to metres
    scale_error : relative, one sigma
    rotation_error_deg : (about east, about north, about up), one sigma
    tilt_error_deg : of the vertical; what dips may be wrong by
    heights : "above sea level" or "above the ellipsoid", as the photos state
    adjusted : whether the positions entered the adjustment; decisions : why or why not, and what
        became of the lenses, in words; lenses : the latter in numbers
    covariance : (7, 7) as in `Scatter`, about `centre` (World), with what the lenses may do to the
        model; positions : (n, 3) World, as stated
    bowing : by the residuals of the positions that count; lens_bend : by the errors of the lenses,
        None where these are not known
    """

    names: tuple[str, ...]
    residuals_m: Array
    used: npt.NDArray[np.bool_]
    rms_m: float
    sigma_m: float
    sigma_height_m: float
    scale: float
    scale_error: float
    rotation_error_deg: tuple[float, float, float]
    tilt_error_deg: float
    crs: str
    heights: str
    adjusted: bool
    decisions: tuple[Finding, ...]
    lenses: tuple[LensVerdict, ...]
    warnings: tuple[Finding, ...]
    covariance: Array
    centre: tuple[float, float, float]
    positions: Array
    bowing: Bowing | None
    lens_bend: LensBend | None


def place_by_gps(
    scene: SparseScene,
    photos: Sequence[PhotoLike],
    crs: str | None = None,
    *,
    cameras: Sequence[Calibration] = (),
    threads: int = -1,
    progress: Progress | None = None,
) -> tuple[SparseScene, GpsReport]:
    """Place the scene by the positions that the photos state, and adjust it with them where they
    are good enough (see `gps_priors`).

    crs : a projected CRS in metres, "EPSG:n"; None for the UTM zone (WGS 84) of the photos
    cameras : as they were calibrated; what is wrong with their lenses is in the errors then
    Raises GeometryError where the positions cannot place it, with the reason; UsageError or
    InputError for a CRS that cannot be used.
    """
    rows, placed = _photos_with_position(scene, photos)
    crs = crs_of(placed, crs)
    world = world_positions(placed, crs)
    spread = world - world.mean(axis=0)
    # In plan: a receiver that has lost its satellites repeats a place and may still vary heights.
    if float(np.linalg.norm(spread[:, :2], axis=1).max()) < _SAME_SPOT_M:
        raise GeometryError(
            Finding(
                "gps-equal", "error", value=len(placed), photos=[photo.name for photo in placed]
            )
        )
    centres = scene.centres[rows]
    stated = _stated_accuracy(placed)
    _check_not_on_a_line(centres, spread)
    origin = integer_origin(world)
    local = world - origin
    # A receiver that states nothing is one that wanders: nothing within its reach is called wrong.
    floor = 2.5 * (stated or _DEFAULT_ACCURACY_M / 2)
    fit, used = fit_robustly(centres, local, floor=floor)
    quality = _quality(fit(centres), local, used, stated)
    each = _each_sigma(placed, stated or quality.sigma)
    better, entered = adjust_to_positions(
        moved(scene, fit, origin, crs), rows, local, each, threads=threads, progress=progress
    )
    if entered.adjusted:
        _, used = fit_robustly(better.centres[rows], local, floor=floor)
        quality = _quality(better.centres[rows], local, used, stated)
    middle = world[used].mean(axis=0)
    effect = _of_lenses(better, cameras, entered, (rows, local, each, used))
    covariance = quality.covariance + (0.0 if effect is None else effect.covariance)
    turn = np.degrees(np.sqrt(np.diag(covariance)[:3]))
    report = GpsReport(
        tuple(photo.name for photo in placed),
        quality.residuals,
        used,
        float(np.sqrt((quality.residuals[used] ** 2).sum(1).mean())),
        quality.sigma,
        quality.sigma_height,
        fit.scale,
        float(np.sqrt(covariance[3, 3])),
        (float(turn[0]), float(turn[1]), float(turn[2])),
        math.hypot(turn[0], turn[1]),
        crs,
        _heights(placed),
        entered.adjusted,
        (entered.reason, *(lens.reason for lens in entered.lenses)),
        entered.lenses,
        (),
        covariance,
        (float(middle[0]), float(middle[1]), float(middle[2])),
        world,
        bowing_of(
            world[used],
            quality.residuals[used],
            extent=better.points + np.array(origin),
        ),
        None if effect is None else effect.bend,
    )
    said = [*_warnings(report, scene, placed), *drift_findings({"cameras": quality.drift})]
    report = replace(report, warnings=tuple(said))
    return better, report


def _of_lenses(
    scene: SparseScene,
    cameras: Sequence[Calibration],
    entered: GpsAdjustment,
    given: tuple[Sequence[int], Array, Array, npt.NDArray[np.bool_]],
) -> LensEffect | None:
    """What the errors of the lenses do to it. given : rows of the views, their positions, the
    errors of these and which of them count"""
    rows, local, each, used = given
    some = np.asarray(rows)[used]

    def again(other: SparseScene) -> Similarity:
        return fit_similarity(other.centres[some], local[used])

    about = local[used].mean(axis=0)
    if not entered.adjusted:
        return lens_effect(scene, cameras, about, again)
    centres = known_centres(some, local[used], each[used])
    return lens_effect(scene, cameras, about, same, centres=centres, lenses=entered.lenses)


def _photos_with_position(
    scene: SparseScene, photos: Sequence[PhotoLike]
) -> tuple[list[int], list[PhotoLike]]:
    """Rows of the views that have a GPS position, and their photos. Raises GeometryError for fewer
    than three."""
    by_name = {photo.name: photo for photo in photos}
    rows, placed = [], []
    for row, view in enumerate(scene.views):
        photo = by_name.get(view.name)
        if photo is not None and has_position(photo):
            rows.append(row)
            placed.append(photo)
    if not placed:
        raise GeometryError(Finding("gps-few", "error", total=len(scene.views), photos=(), value=0))
    if len(placed) < 3:
        raise GeometryError(
            Finding(
                "gps-few",
                "error",
                value=len(placed),
                total=len(scene.views),
                photos=[photo.name for photo in placed],
            )
        )
    return rows, placed


@dataclass(frozen=True, eq=False)
class _Quality:
    """residuals : (n, 3); sigma : of a horizontal coordinate; turn_deg : (3,) about the axes"""

    residuals: Array
    sigma: float
    sigma_height: float
    scale_error: float
    turn_deg: Array
    covariance: Array
    drift: float


def _quality(
    centres: Array, local: Array, used: npt.NDArray[np.bool_], stated: float | None
) -> _Quality:
    """Accuracy of a registration by cameras (n, 3) at GPS positions (n, 3). Raises GeometryError
    where they do not determine it."""
    residuals = centres - local
    each = None if stated is None else np.array([stated, stated, HEIGHTS_WORSE * stated])
    scatter = scatter_of(local[used], residuals[used], each, in_order=True)
    sigma = float(np.sqrt((scatter.sigma[:2] ** 2).mean()))
    inside = local[used] - local[used].mean(axis=0)
    baseline = float(np.sqrt((inside**2).sum(1).mean()))
    if sigma > 0.5 * baseline:
        raise GeometryError(Finding("gps.imprecise", sigma_m=sigma, spread_m=baseline))
    worst = math.degrees(math.sqrt(float(np.linalg.eigvalsh(scatter.rotation)[-1])))
    if worst > MAX_ROTATION_ERROR_DEG:
        raise GeometryError(Finding("gps.rotation", sigma_m=sigma, rotation_deg=worst))
    turn = np.degrees(np.sqrt(np.diag(scatter.rotation)))
    return _Quality(
        residuals,
        sigma,
        float(scatter.sigma[2]),
        scatter.scale_error,
        turn,
        scatter.covariance,
        scatter.drift,
    )


def crs_of(photos: Sequence[PhotoLike], crs: str | None) -> str:
    """The CRS asked for, checked, or the UTM zone of the photos."""
    from vomstudio.io.gis.crs import parse_crs, utm_zone

    if crs is not None:
        code, unit = parse_crs(crs)
        if unit != 1.0:
            raise UsageError(Finding("frame.not-in-metres", crs=code), field="CRS")
        return code
    longitude = float(np.median([p.longitude_deg for p in photos]))
    latitude = float(np.median([p.latitude_deg for p in photos]))
    return utm_zone(longitude, latitude)


def world_positions(photos: Sequence[PhotoLike], crs: str) -> Array:
    """(n, 3) east, north and the stated altitude. Raises GeometryError outside of the CRS."""
    from vomstudio.io.gis.crs import from_degrees

    to_grid = from_degrees(crs)
    rows = []
    for photo in photos:
        place = to_grid(float(photo.longitude_deg or 0), float(photo.latitude_deg or 0))
        if place is None:
            raise GeometryError(Finding("crs.outside-area", photo=photo.name, crs=crs))
        rows.append((*place, float(photo.altitude_m or 0)))
    return np.array(rows, np.float64)


def has_position(photo: PhotoLike) -> bool:
    """Whether it states latitude, longitude and altitude."""
    values = (photo.latitude_deg, photo.longitude_deg, photo.altitude_m)
    return all(v is not None and math.isfinite(v) for v in values)


def _stated_accuracy(photos: Sequence[PhotoLike]) -> float | None:
    """Of one coordinate, of most photos."""
    stated = [p.gps_accuracy_m for p in photos if p.gps_accuracy_m]
    return float(np.median(stated)) / _RADIUS if len(stated) > len(photos) / 2 else None


def _each_sigma(photos: Sequence[PhotoLike], usual: float) -> Array:
    """(n,) of one horizontal coordinate of each photo; `usual` where it states none."""
    return np.array([(p.gps_accuracy_m or 0) / _RADIUS or usual for p in photos])


def _check_not_on_a_line(centres: Array, spread: Array) -> None:
    """Raises GeometryError where the cameras stand on one line, in the scene or by GPS."""
    if nearly_on_a_line(centres) or nearly_on_a_line(spread):
        raise GeometryError(Finding("collinear", "error", photos=(), value=None))


def _heights(photos: Sequence[PhotoLike]) -> str:
    ellipsoid = sum(p.altitude_reference == "ellipsoid" for p in photos)
    return "above the ellipsoid" if ellipsoid > len(photos) / 2 else "above sea level"


def _warnings(
    report: GpsReport, scene: SparseScene, photos: Sequence[PhotoLike]
) -> Iterator[Finding]:
    if report.tilt_error_deg > _WARN_DEG or report.rotation_error_deg[2] > _WARN_DEG:
        yield Finding(
            "registration.weak-rotation",
            sigma_m=report.sigma_m,
            azimuth_deg=report.rotation_error_deg[2],
            tilt_deg=report.tilt_error_deg,
            by="gps",
        )
    yield from scale_findings(report.scale_error)
    yield from bowing_findings(report.bowing)
    yield from lens_findings(report.lens_bend, report.bowing)
    left = [n for n, u in zip(report.names, report.used, strict=True) if not u]
    if left:
        yield Finding(
            "cameras.left-out",
            count=len(left),
            photos=left,
        )
    references = {p.altitude_reference for p in photos if p.altitude_reference}
    if len(references) > 1:
        yield Finding("gps.mixed-heights")
    if len(report.names) < len(scene.views):
        yield Finding("gps.missing", count=len(scene.views) - len(report.names))
