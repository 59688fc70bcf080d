"""Joining of disconnected components of an alignment by markers set in photos of each.

A marker is located in each component by two or more photos. Three markers that are not collinear
determine the similarity between two components (Umeyama 1991, without mirroring). The cameras and
tie points of both components are then adjusted together with the rays of all markers. If there are
fewer common markers, but both components show three or more control points, they are joined by
these, and adjusted during the registration.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding, to_finding
from vomstudio.core.progress import Progress
from vomstudio.io.control.points import ControlPoint, Mark
from vomstudio.photogrammetry.align.mapping import mean_error
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.georeferencing.ground_adjustment import KnownPoint, bundle_adjust
from vomstudio.photogrammetry.georeferencing.mark_observations import marks_by_point
from vomstudio.registration.similarity import (
    Similarity,
    fit_robustly,
    fit_similarity,
    is_nearly_collinear,
    rotation_covariance,
)

MIN_COMMON_POINTS = 3
# Markers with smaller residuals, in pixels, are never treated as outliers.
_MIN_MARKER_PX = 3.0
_WARNING_ROTATION_DEG = 1.0


@dataclass(frozen=True)
class MarkerFit:
    """Fit of a marker that two parts have in common.

    miss_px : distance between its two positions after the similarity, in pixels of its photos
    used : False if the marker is an outlier
    """

    label: str
    miss_px: float
    used: bool


@dataclass(frozen=True)
class Junction:
    """Two joined parts.

    Attributes
    ----------
    photos : (int, int)
        Number of photos of the first part, and of the other part, which is transformed.
    by : {"markers", "control points"}
    markers : tuple of MarkerFit
        Markers that both parts have in common.
    scale : float
        Units of the first part per unit of the other.
    before_px, error_px : float
        Mean error of the tie points before and after the adjustment.
    rotation_error_deg : (float, float, float) or None
        Rotation error of one part relative to the other about the three axes, one sigma. None if
        the parts were joined by control points, in which case the registration reports it.
    """

    photos: tuple[int, int]
    by: str
    markers: tuple[MarkerFit, ...]
    scale: float
    before_px: float
    error_px: float
    rotation_error_deg: tuple[float, float, float] | None
    warnings: tuple[Finding, ...]

    @property
    def rms_px(self) -> float | None:
        """RMS residual of the markers that are not outliers; None if there are no markers."""
        misses = [m.miss_px for m in self.markers if m.used]
        return math.sqrt(sum(m * m for m in misses) / len(misses)) if misses else None


@dataclass(frozen=True)
class JoinReport:
    """Parts in the order in which they were joined, and reasons why others were not."""

    joined: tuple[Junction, ...]
    not_joined: tuple[Finding, ...]


def join_components(
    parts: Sequence[SparseScene],
    marks: Sequence[Mark],
    control: Sequence[ControlPoint] = (),
    *,
    threads: int = -1,
    progress: Progress | None = None,
) -> tuple[tuple[SparseScene, ...], JoinReport]:
    """Join components by markers or control points.

    Parameters
    ----------
    parts : sequence of SparseScene
    marks : sequence of Mark
        Marks of tie markers and of control points. Labels that are not in `control` belong to tie
        markers.
    control : sequence of ControlPoint
    threads : int
        Number of threads; -1 uses all cores.
    progress : Progress, optional

    Returns
    -------
    parts : tuple of SparseScene
        Remaining components, the one with the most photos first.
    report : JoinReport

    Raises
    ------
    Cancelled
        If `progress` requests it.
    """
    remaining = list(parts)
    junctions: list[Junction] = []
    failures: dict[tuple[str, str], Finding] = {}
    surveyed_control = [point for point in control if not point.check]
    while len(remaining) > 1:
        links = [
            (_common_points(remaining[i], remaining[j], marks, surveyed_control), i, j)
            for i in range(len(remaining))
            for j in range(i + 1, len(remaining))
            if _pair_key(remaining[i], remaining[j]) not in failures
        ]
        count, i, j = max(links, key=lambda link: (link[0], -link[1], -link[2]), default=(0, 0, 0))
        if count < MIN_COMMON_POINTS:
            break
        try:
            joined_scene, junction = _join(
                remaining[i], remaining[j], marks, surveyed_control, threads, progress
            )
        except GeometryError as error:
            failures[_pair_key(remaining[i], remaining[j])] = to_finding(error)
            continue
        junctions.append(junction)
        remaining = [joined_scene, *(p for k, p in enumerate(remaining) if k not in (i, j))]
        remaining.sort(key=lambda part: -len(part.views))
    not_joined = []
    for part in remaining[1:]:
        cause = failures.get(_pair_key(remaining[0], part)) or _missing_points_finding(
            remaining[0], part, marks
        )
        not_joined.append(
            Finding(
                "join.not-joined",
                size=len(part.views),
                photos=[view.name for view in part.views],
                reason=cause.message,
                reason_code=cause.code,
                **{name: value for name, value in cause.values.items() if name != "size"},
            )
        )
    return tuple(remaining), JoinReport(tuple(junctions), tuple(not_joined))


def _pair_key(first: SparseScene, second: SparseScene) -> tuple[str, str]:
    """Return a key that identifies a pair of parts."""
    return "\n".join(v.name for v in first.views), "\n".join(v.name for v in second.views)


# ------------------------------------------------------------------------------------------------
def _triangulated_positions(scene: SparseScene, marks: Sequence[Mark]) -> dict[str, FloatArray]:
    """Return the positions of the markers that the photos of a part can locate."""
    marks_by_label, _ = marks_by_point(scene, marks)
    positions = {label: point_marks.place(scene) for label, point_marks in marks_by_label.items()}
    return {label: position for label, position in positions.items() if np.isfinite(position).all()}


def _common_points(
    first: SparseScene, second: SparseScene, marks: Sequence[Mark], control: Sequence[ControlPoint]
) -> int:
    """Return the number of points that can join two parts.

    These are the common markers. If there are too few, it is the smaller of the numbers of control
    points that the two parts show.
    """
    a, b = _triangulated_positions(first, marks), _triangulated_positions(second, marks)
    common_count = len(a.keys() & b.keys())
    if common_count >= MIN_COMMON_POINTS:
        return common_count
    labels = {point.label for point in control}
    return min(len(labels & a.keys()), len(labels & b.keys()))


def _join(
    first: SparseScene,
    second: SparseScene,
    marks: Sequence[Mark],
    control: Sequence[ControlPoint],
    threads: int,
    progress: Progress | None,
) -> tuple[SparseScene, Junction]:
    a, b = _triangulated_positions(first, marks), _triangulated_positions(second, marks)
    common_labels = [label for label in a if label in b]
    photos = (len(first.views), len(second.views))
    if len(common_labels) < MIN_COMMON_POINTS:
        fit = _fit_by_control(a, b, control)
        joined_scene = merge_scenes(first, second, fit)
        error = mean_error(joined_scene)
        return joined_scene, Junction(
            photos, "control points", (), fit.scale, error, error, None, ()
        )
    first_positions, second_positions = (
        np.array([a[c] for c in common_labels]),
        np.array([b[c] for c in common_labels]),
    )
    if is_nearly_collinear(first_positions) or is_nearly_collinear(second_positions):
        raise GeometryError(Finding("join.collinear"))
    pixel = _pixel_size(first, second, first_positions, second_positions)
    fit, is_used = fit_robustly(
        second_positions, first_positions, min_sigma=2 * _MIN_MARKER_PX * pixel
    )
    distances = np.linalg.norm(fit(second_positions) - first_positions, axis=1)
    initial_scene = merge_scenes(first, second, fit)
    error_before = mean_error(initial_scene)
    wrong_labels = {
        label for label, is_good in zip(common_labels, is_used, strict=True) if not is_good
    }
    marks_by_label, _ = marks_by_point(
        initial_scene, [mark for mark in marks if mark.label not in wrong_labels]
    )
    known_points = [
        KnownPoint(None, 0.0, point_marks.views, point_marks.pixels)
        for point_marks in marks_by_label.values()
        if np.isfinite(point_marks.place(initial_scene)).all()
    ]
    joined_scene = bundle_adjust(initial_scene, known_points, threads=threads, progress=progress)
    error_after = mean_error(joined_scene)
    if not error_after <= 1.2 * error_before + 0.1:
        worst_label = common_labels[int(distances.argmax())]
        raise GeometryError(
            Finding(
                "join.contradicted",
                markers=len(common_labels),
                after_px=error_after,
                before_px=error_before,
                marker=worst_label,
                residual_px=distances.max() / pixel,
            )
        )
    markers = tuple(
        MarkerFit(label, float(miss / pixel), bool(is_good))
        for label, miss, is_good in zip(common_labels, distances, is_used, strict=True)
    )
    freedom = 3 * int(is_used.sum()) - 7
    sigma = max(math.sqrt(float((distances[is_used] ** 2).sum()) / freedom), pixel)
    rotation = np.degrees(np.sqrt(np.diag(rotation_covariance(first_positions[is_used], sigma))))
    rotation_vector = (float(rotation[0]), float(rotation[1]), float(rotation[2]))
    warnings = _joining_findings(markers, rotation_vector)
    return joined_scene, Junction(
        photos,
        "markers",
        markers,
        fit.scale,
        error_before,
        error_after,
        rotation_vector,
        tuple(warnings),
    )


def _fit_by_control(
    a: dict[str, FloatArray], b: dict[str, FloatArray], control: Sequence[ControlPoint]
) -> Similarity:
    """Return the similarity between two parts that are each registered by control points."""
    fits = []
    centre = np.mean([point.position for point in control], axis=0)
    for positions in (a, b):
        common_points = [point for point in control if point.label in positions]
        model_positions = np.array([positions[point.label] for point in common_points])
        world = np.array([point.position for point in common_points]) - centre
        if is_nearly_collinear(world):
            raise GeometryError(Finding("control.collinear"))
        fits.append(fit_similarity(model_positions, world))
    first, inverse_fit = fits[1], fits[0].inverse
    return Similarity(
        inverse_fit.scale * first.scale,
        inverse_fit.rotation @ first.rotation,
        inverse_fit(first.translation)[0],
    )


def _pixel_size(
    first: SparseScene,
    second: SparseScene,
    first_positions: FloatArray,
    second_positions: FloatArray,
) -> float:
    """Return the larger of two parts' pixel sizes at the markers, in units of the first part."""
    scale = fit_similarity(second_positions, first_positions).scale
    return max(
        first.median_pixel_size(first_positions), second.median_pixel_size(second_positions) * scale
    )


def _missing_points_finding(
    first: SparseScene, second: SparseScene, marks: Sequence[Mark]
) -> Finding:
    """Report the markers that are still needed to join two components.

    The finding lists the markers that cannot be located in one of the components, because they are
    marked in only one of its photos or from only one position.
    """
    a, b = _triangulated_positions(first, marks), _triangulated_positions(second, marks)
    common_labels = sorted(a.keys() & b.keys())
    not_located = set()
    for scene, located_positions in ((first, a), (second, b)):
        marks_by_label, _ = marks_by_point(scene, marks)
        not_located |= {label for label in marks_by_label if label not in located_positions}
    return Finding(
        "join.few-markers",
        size=len(second.views),
        common=len(common_labels),
        least=MIN_COMMON_POINTS,
        markers=common_labels,
        not_located=sorted(not_located),
    )


def _joining_findings(
    markers: Sequence[MarkerFit], rotation_bounds: tuple[float, float, float]
) -> list[Finding]:
    warnings: list[Finding] = []
    outlier_labels = [marker.label for marker in markers if not marker.used]
    if outlier_labels:
        warnings.append(Finding("control.left-out", labels=outlier_labels))
    if len(markers) - len(outlier_labels) == MIN_COMMON_POINTS:
        warnings.append(
            Finding("control.no-redundancy", count=MIN_COMMON_POINTS, least=MIN_COMMON_POINTS + 1)
        )
    if max(rotation_bounds) > _WARNING_ROTATION_DEG:
        warnings.append(Finding("join.rotation", rotation_deg=max(rotation_bounds)))
    return warnings


# ------------------------------------------------------------------------------------------------
def merge_scenes(first: SparseScene, second: SparseScene, fit: Similarity) -> SparseScene:
    """Merge two scenes in the frame of the first, with views in the order of their names.

    If both scenes contain a photo, that of the first is used. `fit` transforms the second scene.
    """
    first_names = {view.name for view in first.views}
    second = _remove_photos(second, first_names)
    moved_views = [v.moved(fit.scale, fit.rotation, fit.translation) for v in second.views]
    views = [*first.views, *moved_views]
    order = sorted(range(len(views)), key=lambda row: views[row].name)
    new_rows = np.empty(len(views), np.int32)
    new_rows[order] = np.arange(len(views), dtype=np.int32)
    rows = new_rows[np.concatenate([first.track_views, second.track_views + len(first.views)])]
    points = np.concatenate([first.track_points, second.track_points + len(first.points)])
    observation_order = np.lexsort((rows, points))
    lengths = np.concatenate([first.track_lengths, second.track_lengths])
    return replace(
        first,
        views=tuple(views[row] for row in order),
        points=np.concatenate([first.points, fit(second.points)]),
        colors=np.concatenate([first.colors, second.colors]),
        errors_px=np.concatenate([first.errors_px, second.errors_px]),
        track_offsets=np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64),
        track_views=rows[observation_order].astype(np.int32),
        track_pixels=np.concatenate([first.track_pixels, second.track_pixels])[observation_order],
    )


def _remove_photos(scene: SparseScene, names: set[str]) -> SparseScene:
    """Remove photos, and the points that fewer than two of the remaining photos see."""
    is_used_view = np.array([view.name not in names for view in scene.views], np.bool_)
    if is_used_view.all():
        return scene
    is_observed = is_used_view[scene.track_views]
    count = np.bincount(scene.track_points[is_observed], minlength=len(scene.points))
    is_used_point = count >= 2
    is_observed &= is_used_point[scene.track_points]
    new_rows = np.cumsum(is_used_view) - 1
    return replace(
        scene,
        views=tuple(v for v, is_kept in zip(scene.views, is_used_view, strict=True) if is_kept),
        points=scene.points[is_used_point],
        colors=scene.colors[is_used_point],
        errors_px=scene.errors_px[is_used_point],
        track_offsets=np.concatenate([[0], np.cumsum(count[is_used_point])]).astype(np.int64),
        track_views=new_rows[scene.track_views[is_observed]].astype(np.int32),
        track_pixels=scene.track_pixels[is_observed],
    )
