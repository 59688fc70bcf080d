"""Disconnected components of an alignment joined by markers that were set by hand in photos of
both.

A marker is located in each component where its rays meet there, so it needs two photos of each.
Three that are not in one line give the similarity between two components (Umeyama 1991, never a
mirror); then cameras and tie points of both are adjusted with the rays of all markers. Components
that both show three control points or more are joined by these instead, and adjusted when the model
is registered.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding, finding_of
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
    nearly_on_a_line,
    rotation_covariance,
)

FEWEST = 3
# Markers that miss by so many pixels at most are never called wrong.
_MARK_PX = 3.0
_WARN_DEG = 1.0


@dataclass(frozen=True)
class MarkerFit:
    """A marker of two parts: miss_px is the distance of its two places after the similarity, in
    pixels of the photos there; used is False for one that contradicts the others."""

    label: str
    miss_px: float
    used: bool


@dataclass(frozen=True)
class Junction:
    """photos : (of the one part, of the other, which took over the frame of the one)
    by : "markers" or "control points"
    markers : those seen in both
    scale : units of the other part to those of the one
    error_px : mean of the tie points after the adjustment; before_px : before it
    rotation_error_deg : about the three axes, one sigma, of one part against the other; None by
        control points, where the placing tells
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
        """Of the markers that were used."""
        misses = [m.miss_px for m in self.markers if m.used]
        return math.sqrt(sum(m * m for m in misses) / len(misses)) if misses else None


@dataclass(frozen=True)
class JoinReport:
    """joined : in their order; not_joined : why, for each component that was not joined"""

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
    """Join components where markers or control points allow it.

    Returns the components that are left, the one with most photos first, and what was done.

    marks : of tie markers and of control points; labels that are not in `control` are tie markers
    Raises Cancelled.
    """
    left = list(parts)
    joined: list[Junction] = []
    failed: dict[tuple[str, str], Finding] = {}
    surveyed = [point for point in control if not point.check]
    while len(left) > 1:
        links = [
            (_common_points(left[i], left[j], marks, surveyed), i, j)
            for i in range(len(left))
            for j in range(i + 1, len(left))
            if _pair(left[i], left[j]) not in failed
        ]
        count, i, j = max(links, key=lambda link: (link[0], -link[1], -link[2]), default=(0, 0, 0))
        if count < FEWEST:
            break
        try:
            whole, junction = _join(left[i], left[j], marks, surveyed, threads, progress)
        except GeometryError as error:
            failed[_pair(left[i], left[j])] = finding_of(error)
            continue
        joined.append(junction)
        left = [whole, *(p for k, p in enumerate(left) if k not in (i, j))]
        left.sort(key=lambda part: -len(part.views))
    not_joined = []
    for part in left[1:]:
        cause = failed.get(_pair(left[0], part)) or _missing(left[0], part, marks)
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
    return tuple(left), JoinReport(tuple(joined), tuple(not_joined))


def _pair(one: SparseScene, other: SparseScene) -> tuple[str, str]:
    """Names a pair of parts that has been tried."""
    return "\n".join(v.name for v in one.views), "\n".join(v.name for v in other.views)


# ------------------------------------------------------------------------------------------------
def _places(scene: SparseScene, marks: Sequence[Mark]) -> dict[str, FloatArray]:
    """Markers that the photos of a part locate."""
    found, _ = marks_by_point(scene, marks)
    places = {label: seen_at.place(scene) for label, seen_at in found.items()}
    return {label: place for label, place in places.items() if np.isfinite(place).all()}


def _common_points(
    one: SparseScene, other: SparseScene, marks: Sequence[Mark], control: Sequence[ControlPoint]
) -> int:
    """How many markers join two parts, or how many control points the one with fewer has."""
    a, b = _places(one, marks), _places(other, marks)
    common = len(a.keys() & b.keys())
    if common >= FEWEST:
        return common
    labels = {point.label for point in control}
    return min(len(labels & a.keys()), len(labels & b.keys()))


def _join(
    one: SparseScene,
    other: SparseScene,
    marks: Sequence[Mark],
    control: Sequence[ControlPoint],
    threads: int,
    progress: Progress | None,
) -> tuple[SparseScene, Junction]:
    a, b = _places(one, marks), _places(other, marks)
    common = [label for label in a if label in b]
    photos = (len(one.views), len(other.views))
    if len(common) < FEWEST:
        fit = _by_control(a, b, control)
        whole = merged(one, other, fit)
        error = mean_error(whole)
        return whole, Junction(photos, "control points", (), fit.scale, error, error, None, ())
    here, there = np.array([a[c] for c in common]), np.array([b[c] for c in common])
    if nearly_on_a_line(here) or nearly_on_a_line(there):
        raise GeometryError(Finding("join.collinear"))
    pixel = _pixel_size(one, other, here, there)
    fit, used = fit_robustly(there, here, floor=2 * _MARK_PX * pixel)
    misses = np.linalg.norm(fit(there) - here, axis=1)
    rough = merged(one, other, fit)
    before = mean_error(rough)
    wrong = {label for label, good in zip(common, used, strict=True) if not good}
    seen, _ = marks_by_point(rough, [mark for mark in marks if mark.label not in wrong])
    known = [
        KnownPoint(None, 0.0, seen_at.views, seen_at.pixels)
        for seen_at in seen.values()
        if np.isfinite(seen_at.place(rough)).all()
    ]
    whole = bundle_adjust(rough, known, threads=threads, progress=progress)
    after = mean_error(whole)
    if not after <= 1.2 * before + 0.1:
        worst = common[int(misses.argmax())]
        raise GeometryError(
            Finding(
                "join.contradicted",
                markers=len(common),
                after_px=after,
                before_px=before,
                marker=worst,
                residual_px=misses.max() / pixel,
            )
        )
    markers = tuple(
        MarkerFit(label, float(miss / pixel), bool(good))
        for label, miss, good in zip(common, misses, used, strict=True)
    )
    freedom = 3 * int(used.sum()) - 7
    sigma = max(math.sqrt(float((misses[used] ** 2).sum()) / freedom), pixel)
    turn = np.degrees(np.sqrt(np.diag(rotation_covariance(here[used], sigma))))
    turned = (float(turn[0]), float(turn[1]), float(turn[2]))
    warnings = _warnings(markers, turned)
    return whole, Junction(
        photos, "markers", markers, fit.scale, before, after, turned, tuple(warnings)
    )


def _by_control(
    a: dict[str, FloatArray], b: dict[str, FloatArray], control: Sequence[ControlPoint]
) -> Similarity:
    """Of the one part to the other, each placed by control points of its own."""
    fits = []
    middle = np.mean([point.position for point in control], axis=0)
    for places in (a, b):
        own = [point for point in control if point.label in places]
        here = np.array([places[point.label] for point in own])
        world = np.array([point.position for point in own]) - middle
        if nearly_on_a_line(world):
            raise GeometryError(Finding("control.collinear"))
        fits.append(fit_similarity(here, world))
    first, back = fits[1], fits[0].inverse
    return Similarity(
        back.scale * first.scale,
        back.rotation @ first.rotation,
        back(first.translation)[0],
    )


def _pixel_size(one: SparseScene, other: SparseScene, here: FloatArray, there: FloatArray) -> float:
    """The larger of the two parts' pixels at the markers, in the units of the one."""
    scale = fit_similarity(there, here).scale
    return max(one.pixel_at(here), other.pixel_at(there) * scale)


def _missing(one: SparseScene, other: SparseScene, marks: Sequence[Mark]) -> Finding:
    """Report the markers that joining the components needs.

    The finding lists those that cannot be located in one of the two: they are marked in only one of
    its photos, or from one position.
    """
    a, b = _places(one, marks), _places(other, marks)
    common = sorted(a.keys() & b.keys())
    once = set()
    for scene, located in ((one, a), (other, b)):
        seen, _ = marks_by_point(scene, marks)
        once |= {label for label in seen if label not in located}
    return Finding(
        "join.few-markers",
        size=len(other.views),
        common=len(common),
        least=FEWEST,
        markers=common,
        not_located=sorted(once),
    )


def _warnings(markers: Sequence[MarkerFit], turned: tuple[float, float, float]) -> list[Finding]:
    warnings: list[Finding] = []
    out = [marker.label for marker in markers if not marker.used]
    if out:
        warnings.append(Finding("control.left-out", labels=out))
    if len(markers) - len(out) == FEWEST:
        warnings.append(Finding("control.no-redundancy", count=FEWEST, least=FEWEST + 1))
    if max(turned) > _WARN_DEG:
        warnings.append(Finding("join.rotation", rotation_deg=max(turned)))
    return warnings


# ------------------------------------------------------------------------------------------------
def merged(one: SparseScene, other: SparseScene, fit: Similarity) -> SparseScene:
    """Both in the frame of the one, with views in the order of their names; a photo that is in both
    is that of the one. `fit` takes the other to the one."""
    own = {view.name for view in one.views}
    other = _without(other, own)
    moved = [v.moved(fit.scale, fit.rotation, fit.translation) for v in other.views]
    views = [*one.views, *moved]
    order = sorted(range(len(views)), key=lambda row: views[row].name)
    row_of = np.empty(len(views), np.int32)
    row_of[order] = np.arange(len(views), dtype=np.int32)
    rows = row_of[np.concatenate([one.track_views, other.track_views + len(one.views)])]
    points = np.concatenate([one.track_points, other.track_points + len(one.points)])
    sorting = np.lexsort((rows, points))
    lengths = np.concatenate([one.track_lengths, other.track_lengths])
    return replace(
        one,
        views=tuple(views[row] for row in order),
        points=np.concatenate([one.points, fit(other.points)]),
        colors=np.concatenate([one.colors, other.colors]),
        errors_px=np.concatenate([one.errors_px, other.errors_px]),
        track_offsets=np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64),
        track_views=rows[sorting].astype(np.int32),
        track_pixels=np.concatenate([one.track_pixels, other.track_pixels])[sorting],
    )


def _without(scene: SparseScene, names: set[str]) -> SparseScene:
    """Less some photos, and the points that fewer than two of the others see."""
    stays = np.array([view.name not in names for view in scene.views], np.bool_)
    if stays.all():
        return scene
    seen = stays[scene.track_views]
    count = np.bincount(scene.track_points[seen], minlength=len(scene.points))
    kept = count >= 2
    seen &= kept[scene.track_points]
    row_of = np.cumsum(stays) - 1
    return replace(
        scene,
        views=tuple(v for v, stay in zip(scene.views, stays, strict=True) if stay),
        points=scene.points[kept],
        colors=scene.colors[kept],
        errors_px=scene.errors_px[kept],
        track_offsets=np.concatenate([[0], np.cumsum(count[kept])]).astype(np.int64),
        track_views=row_of[scene.track_views[seen]].astype(np.int32),
        track_pixels=scene.track_pixels[seen],
    )
