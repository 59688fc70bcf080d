"""Survey check after the alignment: the same questions, answered by the tie points."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray
from vomstudio.core.findings import Finding
from vomstudio.geometry.plane_sizes import PlaneSizes
from vomstudio.photogrammetry.align.lens_check import of_lenses
from vomstudio.photogrammetry.survey.camera_positions import straightness
from vomstudio.photogrammetry.survey.check_limits import Limits
from vomstudio.photogrammetry.survey.check_results import (
    PhotoFigures,
    SurveyReport,
    advice_for,
    assess,
    by_severity,
)

if TYPE_CHECKING:
    from vomstudio.geometry.cameras import View
    from vomstudio.photogrammetry.align.priors import Calibration
    from vomstudio.photogrammetry.base.scene import SparseScene


_WEAK_POINTS = 50
_HIGH_ERROR_PX = 2.0


def check_scene(
    scene: SparseScene,
    *,
    unregistered: Sequence[str] = (),
    other_parts: Sequence[SparseScene] = (),
    blur: dict[str, float] | None = None,
    cameras: Sequence[Calibration] = (),
    planes: PlaneSizes | None = None,
    further: Sequence[Finding] = (),
    limits: Limits | None = None,
) -> SurveyReport:
    """Findings, figures and verdict for an aligned scene.

    unregistered : names of photos without a pose
    other_parts : further disconnected components
    blur : sigma by name, from the check before
    cameras : their calibration by the alignment
    planes : what the finished model tells of planes, where there is one; None: what photos of this
        pixel size let expect, without a registration
    further : findings of other stages
    """
    limits = limits or Limits()
    if not scene.views:
        finding = Finding(
            "unregistered",
            "error",
            photos=tuple(unregistered),
            value=float(len(unregistered)),
            total=len(unregistered),
        )
        return SurveyReport(
            "after", (), (finding,), assess([finding], None), None, None, advice_for([finding])
        )
    gsd = photo_pixel_sizes(scene)
    views = mean_views(scene)
    overlap = shared_view(scene)
    normal = face_normal(scene)
    oblique = obliquity_deg(scene, normal)
    findings = [
        *_of_registration(scene, unregistered, other_parts),
        *_of_points(scene, views, overlap, limits),
        *_of_sizes(scene, gsd, limits),
        *_of_directions(scene, limits),
        *_of_places(scene, gsd, limits),
        *_of_line(scene, limits),
        *of_lenses(cameras),
        *_of_orientation(planes, limits),
        *further,
    ]
    findings = list(by_severity(findings))
    known = gsd[np.isfinite(gsd)]
    middle = float(np.median(known)) if len(known) else None
    told = planes or (None if middle is None else PlaneSizes.of_pixels(middle))
    metric = _is_metric(scene)
    textbook = None if told is None else told.textbook
    figures = tuple(
        PhotoFigures(
            view.name,
            _or_none(gsd[i]) if metric else None,
            None if blur is None else blur.get(view.name),
            _or_none(views[i]),
            None,
            _or_none(overlap[i].max() if len(scene.views) > 1 else math.nan),
            _or_none(oblique[i]),
            None if metric else _or_none(gsd[i]),
        )
        for i, view in enumerate(scene.views)
    )
    return SurveyReport(
        "after",
        figures,
        tuple(findings),
        assess(findings, middle, metric=metric, planes=planes),
        middle if metric else None,
        textbook if metric else None,
        advice_for(findings),
        () if told is None else told.curve(metric=metric),
        None if metric else middle,
        None if metric else textbook,
    )


def photo_pixel_sizes(scene: SparseScene) -> FloatArray:
    """(v,) length on the rock per pixel: median depth of a photo's tie points over its focal
    length (eq. 18 in pixels); NaN without points."""
    sizes = np.full(len(scene.views), np.nan)
    for i, view in enumerate(scene.views):
        rows = scene.seen_by(i)
        depth = view.depths(scene.points[rows])
        depth = depth[depth > 0]
        if len(depth):
            sizes[i] = float(np.median(depth)) / (sum(view.intrinsics.focal) / 2.0)
    return sizes


def mean_views(scene: SparseScene) -> FloatArray:
    """(v,) mean number of photos that see the tie points of each photo; NaN without points."""
    lengths = scene.track_lengths[scene.track_points].astype(np.float64)
    total = np.bincount(scene.track_views, lengths, len(scene.views))
    count = np.bincount(scene.track_views, minlength=len(scene.views))
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(total / np.where(count > 0, count, np.nan))


def shared_view(scene: SparseScene, grid: int = 8) -> FloatArray:
    """(v, v) share of photo i's picture that lies on photo j: the overlap of the two; the diagonal
    is 0.

    Places all over the picture are taken to be as deep as the nearest tie point in it. (The tie
    points themselves lie where photos overlap, and would flatter them.) Occlusion is not looked at.
    """
    count = len(scene.views)
    shares = np.zeros((count, count))
    steps = (np.arange(grid) + 0.5) / grid
    for i, view in enumerate(scene.views):
        mine = scene.track_views == i
        depths = view.depths(scene.points[scene.track_points[mine]])
        at = scene.track_pixels[mine][depths > 0].astype(np.float64)
        depths = depths[depths > 0]
        if not len(depths):
            continue
        x, y = np.meshgrid(steps * view.intrinsics.width, steps * view.intrinsics.height)
        pixels = np.column_stack([x.ravel(), y.ravel()])
        nearest = ((pixels[:, None] - at[None]) ** 2).sum(axis=2).argmin(axis=1)
        rays = view.intrinsics.rays(pixels)
        seen = np.isfinite(rays).all(axis=1)
        camera = rays[seen] * depths[nearest[seen], None]
        places = (camera - view.translation) @ view.rotation
        for j, other in enumerate(scene.views):
            if i != j and len(places):
                shares[i, j] = _lies_on(other, places).mean()
    return shares


def face_normal(scene: SparseScene) -> FloatArray:
    """Unit normal of the plane that fits the tie points best, towards the cameras."""
    points = scene.points
    if len(points) < 3:
        return -np.asarray(scene.views[0].direction)
    centre = np.median(points, axis=0)
    away = np.linalg.norm(points - centre, axis=1)
    near = points[away <= np.quantile(away, 0.9)]
    _, _, axes = np.linalg.svd(near - near.mean(axis=0), full_matrices=False)
    normal = axes[-1]
    return np.asarray(normal * (1.0 if (scene.centres.mean(axis=0) - centre) @ normal > 0 else -1))


def obliquity_deg(scene: SparseScene, normal: FloatArray) -> FloatArray:
    """(v,) angle between each view direction and the perpendicular to the face, on whichever side
    of it the camera stands: an object may be photographed all around."""
    axes = np.array([view.direction for view in scene.views])
    return np.asarray(np.degrees(np.arccos(np.clip(np.abs(axes @ normal), 0.0, 1.0))))


def _lies_on(view: View, points: FloatArray) -> BoolArray:
    """Which points are before the camera and inside its picture."""
    # What is not defined is compared as false.
    return view.contains(view.project(points))


def _or_none(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


# ------------------------------------------------------------------------------------------------
def _of_orientation(planes: PlaneSizes | None, limits: Limits) -> list[Finding]:
    """Every direction on the model is off by what its registration is."""
    if planes is None or planes.registration_deg <= limits.registration_deg:
        return []
    return [Finding("rotation", photos=(), value=planes.registration_deg)]


def _of_registration(
    scene: SparseScene, unregistered: Sequence[str], parts: Sequence[SparseScene]
) -> list[Finding]:
    found = []
    total = len(scene.views) + len(unregistered) + sum(len(part.views) for part in parts)
    if unregistered:
        share = len(unregistered) / total
        found.append(
            Finding(
                "unregistered",
                "error" if share > 0.5 else "warning",
                photos=tuple(unregistered),
                value=float(len(unregistered)),
                total=total,
            )
        )
    if parts:
        names = tuple(view.name for part in parts for view in part.views)
        found.append(
            Finding(
                "parts",
                photos=names,
                value=float(len(parts) + 1),
                sizes=[len(p.views) for p in (scene, *parts)],
            )
        )
    if len(scene.views) < 5:
        found.append(
            Finding("few-photos", photos=(), value=float(len(scene.views)), count=len(scene.views))
        )
    return found


def _of_points(
    scene: SparseScene, views: FloatArray, overlap: FloatArray, limits: Limits
) -> list[Finding]:
    found = []
    names = [view.name for view in scene.views]
    counts = np.bincount(scene.track_views, minlength=len(names))
    weak = tuple(n for n, c in zip(names, counts, strict=True) if c < _WEAK_POINTS)
    if weak:
        found.append(
            Finding("weak-photos", photos=weak, value=float(counts.min()), least=_WEAK_POINTS)
        )
    seen = places_seen(scene)
    if len(names) >= limits.fewest_photos and len(seen):
        middle = float(np.median(seen))
        if middle < limits.views:
            few = tuple(n for n, v in zip(names, views, strict=True) if not v >= 3.0)
            found.append(Finding("few-views", photos=few, value=middle))
    if len(names) > 1:
        best = overlap.max(axis=1)
        thin = tuple(n for n, b in zip(names, best, strict=True) if b < limits.overlap)
        if thin:
            found.append(
                Finding(
                    "low-overlap",
                    photos=thin,
                    value=float(best.min()),
                    overlap=100 * float(best[best < limits.overlap].max()),
                )
            )
    errors = scene.errors_px[np.isfinite(scene.errors_px)]
    if len(errors) and float(np.median(errors)) > _HIGH_ERROR_PX:
        found.append(Finding("high-error", photos=(), value=float(np.median(errors))))
    return found


def places_seen(scene: SparseScene, most: int = 2000) -> IntArray:
    """(n,) in how many photos each tie point lies (up to `most` of them, evenly taken), whether it
    was matched there or not. Occlusion is not looked at."""
    step = max(1, len(scene.points) // most)
    points = scene.points[::step]
    seen = np.zeros(len(points), np.int64)
    for view in scene.views:
        seen += _lies_on(view, points)
    return seen


def _of_sizes(scene: SparseScene, gsd: FloatArray, limits: Limits) -> list[Finding]:
    known = np.isfinite(gsd)
    if known.sum() < 2:
        return []
    ratio = float(gsd[known].max() / gsd[known].min())
    if ratio <= limits.gsd_ratio:
        return []
    middle = float(np.median(gsd[known]))
    off = np.abs(np.log(np.where(known, gsd, middle) / middle)) > math.log(limits.gsd_ratio) / 2
    names = tuple(view.name for view, far in zip(scene.views, off, strict=True) if far)
    return [Finding("gsd-spread", photos=names, value=ratio)]


def _of_directions(scene: SparseScene, limits: Limits) -> list[Finding]:
    axes = np.array([view.direction for view in scene.views])
    if len(axes) < 3:
        return []
    middle = axes.mean(axis=0)
    norm = float(np.linalg.norm(middle))
    if norm < 0.2:
        return []
    away = np.sort(np.degrees(np.arccos(np.clip(axes @ middle / norm, -1.0, 1.0))))
    spread = float(away[-max(2, math.ceil(0.1 * len(away)))])
    if spread >= limits.doming_deg:
        return []
    return [Finding("one-direction", photos=(), value=spread, source="poses")]


def _of_places(scene: SparseScene, gsd: FloatArray, limits: Limits) -> list[Finding]:
    """One position, one photo (textbook 3.2.1)."""
    centres = scene.centres
    turned: list[tuple[str, str]] = []
    for i in range(len(centres)):
        for j in range(i + 1, len(centres)):
            a, b = scene.views[i], scene.views[j]
            focal = [sum(v.intrinsics.focal) / 2 for v in (a, b)]
            distance = float(np.nanmean([gsd[i] * focal[0], gsd[j] * focal[1]]))
            if not math.isfinite(distance):
                continue
            if np.linalg.norm(centres[i] - centres[j]) > limits.same_place * distance:
                continue
            turn = math.degrees(math.acos(float(np.clip(a.direction @ b.direction, -1, 1))))
            one, two = (
                f / max(v.intrinsics.width, v.intrinsics.height)
                for f, v in zip(focal, (a, b), strict=True)
            )
            if turn > limits.turn_deg or max(one / two, two / one) > limits.zoom:
                turned.append((a.name, b.name))
    if not turned:
        return []
    names = tuple(dict.fromkeys(name for pair in turned for name in pair))
    return [Finding("same-position", photos=names, value=float(len(turned)))]


def _is_metric(scene: SparseScene) -> bool:
    return scene.scaled or scene.crs is not None


def _of_line(scene: SparseScene, limits: Limits) -> list[Finding]:
    """Collinear cameras cannot register a model (textbook 3.2.2)."""
    if len(scene.views) < 3:
        return []
    width = straightness(scene.centres)
    if width >= limits.straight:
        return []
    across = width * float(np.linalg.norm(scene.centres.std(axis=0)))
    return [Finding("collinear", photos=(), value=width, width=across)]
