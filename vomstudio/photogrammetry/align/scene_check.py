"""Survey check after the alignment, based on the tie points."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.core.findings import Finding
from vomstudio.geometry.plane_sizes import PlaneSizes
from vomstudio.photogrammetry.align.lens_check import lens_findings
from vomstudio.photogrammetry.survey.camera_positions import width_to_length_ratio
from vomstudio.photogrammetry.survey.check_limits import Limits
from vomstudio.photogrammetry.survey.check_results import (
    PhotoFigures,
    SurveyReport,
    assess,
    collect_advice,
    sort_by_severity,
)

if TYPE_CHECKING:
    from vomstudio.geometry.cameras import View
    from vomstudio.photogrammetry.align.priors import Calibration
    from vomstudio.photogrammetry.base.scene import SparseScene


_MIN_PHOTO_POINTS = 50
_MAX_ERROR_PX = 2.0


def check_scene(
    scene: SparseScene,
    *,
    unregistered_names: Sequence[str] = (),
    other_parts: Sequence[SparseScene] = (),
    blur: dict[str, float] | None = None,
    cameras: Sequence[Calibration] = (),
    planes: PlaneSizes | None = None,
    other_findings: Sequence[Finding] = (),
    limits: Limits | None = None,
) -> SurveyReport:
    """Check an aligned scene.

    Parameters
    ----------
    scene : SparseScene
    unregistered_names : sequence of str
        Photos without a pose.
    other_parts : sequence of SparseScene
        The other connected components.
    blur : dict, optional
        Blur sigma of each photo, from the check before the alignment.
    cameras : sequence of Calibration
    planes : PlaneSizes, optional
        Plane sizes of the finished model. By default, those expected for unregistered photos with
        the median pixel size of the scene.
    other_findings : sequence of Finding
        Findings of other stages.
    limits : Limits, optional
    """
    limits = limits or Limits()
    if not scene.views:
        finding = Finding(
            "unregistered",
            "error",
            photos=tuple(unregistered_names),
            value=float(len(unregistered_names)),
            total=len(unregistered_names),
        )
        return SurveyReport(
            "after", (), (finding,), assess([finding], None), None, None, collect_advice([finding])
        )
    gsd = photo_pixel_sizes(scene)
    views = mean_views(scene)
    overlap = overlap_matrix(scene)
    normal = face_normal(scene)
    obliquities_deg = obliquity_deg(scene, normal)
    findings = [
        *_registration_findings(scene, unregistered_names, other_parts),
        *_point_findings(scene, views, overlap, limits),
        *_size_findings(scene, gsd, limits),
        *_direction_findings(scene, limits),
        *_position_findings(scene, gsd, limits),
        *_line_findings(scene, limits),
        *lens_findings(cameras),
        *_orientation_findings(planes, limits),
        *other_findings,
    ]
    findings = list(sort_by_severity(findings))
    known_gsd = gsd[np.isfinite(gsd)]
    median = float(np.median(known_gsd)) if len(known_gsd) else None
    expected_planes = planes or (None if median is None else PlaneSizes.from_pixel_size(median))
    is_metric = _is_metric(scene)
    textbook_findings = None if expected_planes is None else expected_planes.textbook
    figures = tuple(
        PhotoFigures(
            view.name,
            _finite_or_none(gsd[i]) if is_metric else None,
            None if blur is None else blur.get(view.name),
            _finite_or_none(views[i]),
            None,
            _finite_or_none(overlap[i].max() if len(scene.views) > 1 else math.nan),
            _finite_or_none(obliquities_deg[i]),
            None if is_metric else _finite_or_none(gsd[i]),
        )
        for i, view in enumerate(scene.views)
    )
    return SurveyReport(
        "after",
        figures,
        tuple(findings),
        assess(findings, median, is_metric=is_metric, planes=planes),
        median if is_metric else None,
        textbook_findings if is_metric else None,
        collect_advice(findings),
        () if expected_planes is None else expected_planes.curve(is_metric=is_metric),
        None if is_metric else median,
        None if is_metric else textbook_findings,
    )


def photo_pixel_sizes(scene: SparseScene) -> FloatArray:
    """Return the pixel size on the rock (v,) of each photo; NaN if it has no points.

    This is the median depth of a photo's tie points divided by its focal length in
    pixels (eq. 18).
    """
    sizes = np.full(len(scene.views), np.nan)
    for i, view in enumerate(scene.views):
        rows = scene.observed_points(i)
        depth = view.depths(scene.points[rows])
        depth = depth[depth > 0]
        if len(depth):
            sizes[i] = float(np.median(depth)) / (sum(view.intrinsics.focal) / 2.0)
    return sizes


def mean_views(scene: SparseScene) -> FloatArray:
    """Return the mean number (v,) of views of each photo's tie points; NaN if it has none."""
    lengths = scene.track_lengths[scene.track_points].astype(np.float64)
    total = np.bincount(scene.track_views, lengths, len(scene.views))
    count = np.bincount(scene.track_views, minlength=len(scene.views))
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(total / np.where(count > 0, count, np.nan))


def overlap_matrix(scene: SparseScene, grid: int = 8) -> FloatArray:
    """Return the overlap (v, v): the share of photo i that photo j also shows.

    The diagonal is zero. Positions in the picture are assigned the depth of the nearest tie point.
    (The tie points themselves lie where photos overlap, so they would exaggerate the overlap.)
    Occlusion is ignored.
    """
    count = len(scene.views)
    overlaps = np.zeros((count, count))
    steps = (np.arange(grid) + 0.5) / grid
    for i, view in enumerate(scene.views):
        is_in_view = scene.track_views == i
        depths = view.depths(scene.points[scene.track_points[is_in_view]])
        tie_pixels = scene.track_pixels[is_in_view][depths > 0].astype(np.float64)
        depths = depths[depths > 0]
        if not len(depths):
            continue
        x, y = np.meshgrid(steps * view.intrinsics.width, steps * view.intrinsics.height)
        pixels = np.column_stack([x.ravel(), y.ravel()])
        nearest_points = ((pixels[:, None] - tie_pixels[None]) ** 2).sum(axis=2).argmin(axis=1)
        rays = view.intrinsics.rays(pixels)
        is_visible = np.isfinite(rays).all(axis=1)
        camera = rays[is_visible] * depths[nearest_points[is_visible], None]
        positions = (camera - view.translation) @ view.rotation
        for j, other_view in enumerate(scene.views):
            if i != j and len(positions):
                overlaps[i, j] = _is_on_photo(other_view, positions).mean()
    return overlaps


def face_normal(scene: SparseScene) -> FloatArray:
    """Return the unit normal of the plane fitted to the tie points, towards the cameras.

    With fewer than three points, the result is opposite to the direction of the first view.
    """
    points = scene.points
    if len(points) < 3:
        return -np.asarray(scene.views[0].direction)
    centre = np.median(points, axis=0)
    distances = np.linalg.norm(points - centre, axis=1)
    near_points = points[distances <= np.quantile(distances, 0.9)]
    _, _, axes = np.linalg.svd(near_points - near_points.mean(axis=0), full_matrices=False)
    normal = axes[-1]
    return np.asarray(normal * (1.0 if (scene.centres.mean(axis=0) - centre) @ normal > 0 else -1))


def obliquity_deg(scene: SparseScene, normal: FloatArray) -> FloatArray:
    """Return the angle (v,) between each view direction and the normal of the face.

    Both sides of the face are treated alike, since an object may be photographed all around.
    """
    axes = np.array([view.direction for view in scene.views])
    return np.asarray(np.degrees(np.arccos(np.clip(np.abs(axes @ normal), 0.0, 1.0))))


def _is_on_photo(view: View, points: FloatArray) -> BoolArray:
    """Return which points lie in front of the camera and inside its picture."""
    # NaN compares as false.
    return view.contains(view.project(points))


def _finite_or_none(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


# ------------------------------------------------------------------------------------------------
def _orientation_findings(planes: PlaneSizes | None, limits: Limits) -> list[Finding]:
    """Report a registration error that affects every direction measured on the model."""
    if planes is None or planes.registration_deg <= limits.registration_deg:
        return []
    return [Finding("rotation", photos=(), value=planes.registration_deg)]


def _registration_findings(
    scene: SparseScene, unregistered_names: Sequence[str], parts: Sequence[SparseScene]
) -> list[Finding]:
    findings = []
    total = len(scene.views) + len(unregistered_names) + sum(len(part.views) for part in parts)
    if unregistered_names:
        unregistered_share = len(unregistered_names) / total
        findings.append(
            Finding(
                "unregistered",
                "error" if unregistered_share > 0.5 else "warning",
                photos=tuple(unregistered_names),
                value=float(len(unregistered_names)),
                total=total,
            )
        )
    if parts:
        names = tuple(view.name for part in parts for view in part.views)
        findings.append(
            Finding(
                "parts",
                photos=names,
                value=float(len(parts) + 1),
                sizes=[len(p.views) for p in (scene, *parts)],
            )
        )
    if len(scene.views) < 5:
        findings.append(
            Finding("few-photos", photos=(), value=float(len(scene.views)), count=len(scene.views))
        )
    return findings


def _point_findings(
    scene: SparseScene, views: FloatArray, overlap: FloatArray, limits: Limits
) -> list[Finding]:
    findings = []
    names = [view.name for view in scene.views]
    counts = np.bincount(scene.track_views, minlength=len(names))
    weak_photos = tuple(n for n, c in zip(names, counts, strict=True) if c < _MIN_PHOTO_POINTS)
    if weak_photos:
        findings.append(
            Finding(
                "weak-photos",
                photos=weak_photos,
                value=float(counts.min()),
                least=_MIN_PHOTO_POINTS,
            )
        )
    view_counts = count_views_of_points(scene)
    if len(names) >= limits.min_photos and len(view_counts):
        median = float(np.median(view_counts))
        if median < limits.views:
            photos_with_few_views = tuple(
                n for n, v in zip(names, views, strict=True) if not v >= 3.0
            )
            findings.append(Finding("few-views", photos=photos_with_few_views, value=median))
    if len(names) > 1:
        best_overlap = overlap.max(axis=1)
        low_overlap = tuple(
            n for n, b in zip(names, best_overlap, strict=True) if b < limits.overlap
        )
        if low_overlap:
            findings.append(
                Finding(
                    "low-overlap",
                    photos=low_overlap,
                    value=float(best_overlap.min()),
                    overlap=100 * float(best_overlap[best_overlap < limits.overlap].max()),
                )
            )
    errors = scene.errors_px[np.isfinite(scene.errors_px)]
    if len(errors) and float(np.median(errors)) > _MAX_ERROR_PX:
        findings.append(Finding("high-error", photos=(), value=float(np.median(errors))))
    return findings


def count_views_of_points(scene: SparseScene, max_points: int = 2000) -> IntArray:
    """Count the photos (n,) that show each tie point, whether it is matched there or not.

    Occlusion is ignored. Points are skipped at regular intervals, so that fewer than twice
    `max_points` points are used.
    """
    step = max(1, len(scene.points) // max_points)
    points = scene.points[::step]
    counts = np.zeros(len(points), np.int64)
    for view in scene.views:
        counts += _is_on_photo(view, points)
    return counts


def _size_findings(scene: SparseScene, gsd: FloatArray, limits: Limits) -> list[Finding]:
    is_known = np.isfinite(gsd)
    if is_known.sum() < 2:
        return []
    ratio = float(gsd[is_known].max() / gsd[is_known].min())
    if ratio <= limits.gsd_ratio:
        return []
    median = float(np.median(gsd[is_known]))
    has_far_size = (
        np.abs(np.log(np.where(is_known, gsd, median) / median)) > math.log(limits.gsd_ratio) / 2
    )
    names = tuple(
        view.name for view, is_far in zip(scene.views, has_far_size, strict=True) if is_far
    )
    return [Finding("gsd-spread", photos=names, value=ratio)]


def _direction_findings(scene: SparseScene, limits: Limits) -> list[Finding]:
    axes = np.array([view.direction for view in scene.views])
    if len(axes) < 3:
        return []
    centre = axes.mean(axis=0)
    norm = float(np.linalg.norm(centre))
    if norm < 0.2:
        return []
    angles = np.sort(np.degrees(np.arccos(np.clip(axes @ centre / norm, -1.0, 1.0))))
    spread = float(angles[-max(2, math.ceil(0.1 * len(angles)))])
    if spread >= limits.doming_deg:
        return []
    return [Finding("one-direction", photos=(), value=spread, source="poses")]


def _position_findings(scene: SparseScene, gsd: FloatArray, limits: Limits) -> list[Finding]:
    """Report turned or zoomed photos taken from the same position (textbook 3.2.1)."""
    centres = scene.centres
    turned_photos: list[tuple[str, str]] = []
    for i in range(len(centres)):
        for j in range(i + 1, len(centres)):
            a, b = scene.views[i], scene.views[j]
            focal = [sum(v.intrinsics.focal) / 2 for v in (a, b)]
            distance = float(np.nanmean([gsd[i] * focal[0], gsd[j] * focal[1]]))
            if not math.isfinite(distance):
                continue
            if np.linalg.norm(centres[i] - centres[j]) > limits.max_baseline_ratio * distance:
                continue
            angle = math.degrees(math.acos(float(np.clip(a.direction @ b.direction, -1, 1))))
            first_focal, second_focal = (
                f / max(v.intrinsics.width, v.intrinsics.height)
                for f, v in zip(focal, (a, b), strict=True)
            )
            if (
                angle > limits.turn_deg
                or max(first_focal / second_focal, second_focal / first_focal) > limits.zoom
            ):
                turned_photos.append((a.name, b.name))
    if not turned_photos:
        return []
    names = tuple(dict.fromkeys(name for pair in turned_photos for name in pair))
    return [Finding("same-position", photos=names, value=float(len(turned_photos)))]


def _is_metric(scene: SparseScene) -> bool:
    return scene.scaled or scene.crs is not None


def _line_findings(scene: SparseScene, limits: Limits) -> list[Finding]:
    """Find collinear cameras, which cannot register a model (textbook 3.2.2)."""
    if len(scene.views) < 3:
        return []
    width = width_to_length_ratio(scene.centres)
    if width >= limits.min_width_ratio:
        return []
    crosswise_width = width * float(np.linalg.norm(scene.centres.std(axis=0)))
    return [Finding("collinear", photos=(), value=width, width=crosswise_width)]
