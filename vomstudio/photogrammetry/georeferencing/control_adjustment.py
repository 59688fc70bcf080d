"""A scene adjusted with its control points, and whether that makes it better.

A bundle adjustment bends the model to the control points. Where these are wrong, or known worse
than the photos know the shape, the bent model is worse than the one that a similarity places: both
are judged by points that they are not made of, and the better one is kept.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.io.control.points import ControlPoint
from vomstudio.photogrammetry.align.mapping import mean_error
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.georeferencing.ground_adjustment import KnownPoint, bundle_adjust
from vomstudio.photogrammetry.georeferencing.ground_calibration import LensVerdict, adjust_to_ground
from vomstudio.photogrammetry.georeferencing.mark_observations import PointMarks
from vomstudio.photogrammetry.georeferencing.placement import MAX_ROTATION_ERROR_DEG
from vomstudio.photogrammetry.georeferencing.world_frame import moved
from vomstudio.registration.marks.mark_errors import HAND_MARK_PX
from vomstudio.registration.scatter import Scatter, scatter_of
from vomstudio.registration.similarity import (
    Similarity,
    fit_robustly,
    fit_similarity,
    nearly_on_a_line,
)

_PART_OF_PIXEL = 0.1
_FOLDS = 3
# A handful of points knows its own scatter to a quarter, and nothing is known to a part of a pixel.
_CLEARLY_WORSE, _PART_OF_A_MISS = 1.25, 0.5
_FEWEST_TO_JUDGE = 5
"""Control points from which on the model is judged with and without bending. Check points take no
part in it: they would tell the truth no longer."""


@dataclass(frozen=True, eq=False)
class ControlFit:
    """used : rows of the control points that agree; scatter : of these"""

    fit: Similarity
    used: list[int]
    scatter: Scatter

    @property
    def sigma(self) -> float:
        """Standard deviation of a horizontal coordinate, m."""
        return self.scatter.horizontal_sigma


@dataclass(frozen=True, eq=False)
class GroundPoints:
    """Control points and tie points that are marked, prepared for the registration.

    control, seen : the points, and where they are marked
    local : (n, 3) their places less `origin`
    fitting : rows of those that can place the scene
    ties : markers without coordinates that tie photos together
    surveyed : usual error of a coordinate, as stated; 0 where none is
    pixel : metres of a pixel on the ground
    floor : misses below it contradict nothing
    mark_px : error of a mark in one direction
    """

    control: Sequence[ControlPoint]
    seen: list[PointMarks]
    local: FloatArray
    origin: tuple[int, int, int]
    fitting: list[int]
    ties: list[PointMarks]
    surveyed: float
    pixel: float
    floor: float
    mark_px: float

    def places(self, scene: SparseScene, rows: Sequence[int]) -> FloatArray:
        """Return the places (n, 3) of some of the points in a scene."""
        return np.array([self.seen[row].place(scene) for row in rows])

    def fitted(self, scene: SparseScene) -> ControlFit:
        """Fit the similarity from the scene to the control points, robustly.

        Raises GeometryError if the scene does not locate them, or they do not determine it.
        """
        places = self.places(scene, self.fitting)
        if not np.isfinite(places).all():
            raise GeometryError(Finding("control.not-located"))
        wanted = self.local[list(self.fitting)]
        require_width(places)
        fit, good = fit_robustly(places, wanted, floor=self.floor)
        misses = (fit(places) - wanted)[good]
        used = [i for i, keep in zip(self.fitting, good, strict=True) if keep]
        stated = self.errors(scene, fit, used) if self.surveyed else None
        scatter = scatter_of(wanted[good], misses, stated, is_ordered=True)
        # What is exact in every digit is not known better than a part of a pixel.
        if not scatter.covariance.any():
            scatter = scatter_of(wanted[good], misses, _PART_OF_PIXEL * self.pixel)
        worst = scatter.worst_rotation_deg
        if not worst <= MAX_ROTATION_ERROR_DEG:
            raise GeometryError(
                Finding(
                    "control.contradicts",
                    sigma_m=float(np.sqrt((scatter.sigma**2).mean())),
                    rotation_deg=worst,
                )
            )
        return ControlFit(fit, used, scatter)

    def errors(self, scene: SparseScene, fit: Similarity, rows: Sequence[int]) -> FloatArray:
        """Return the covariances (n, 3, 3) of points: surveyed accuracy and scatter of the marks.

        fit : from the scene to the control points
        """
        turn = fit.scale * fit.rotation
        errors = []
        for row in rows:
            marked = self.seen[row].covariance(scene, self.mark_px)
            surveyed = self.control[row].sigma_m or self.surveyed
            errors.append(turn @ marked @ turn.T + surveyed**2 * np.eye(3))
        return np.array(errors)

    def off(self, scene: SparseScene, rows: Sequence[int]) -> float:
        """Root mean square distance of these points from where they are in a placed scene, m."""
        squares = ((self.places(scene, rows) - self.local[list(rows)]) ** 2).sum(axis=1)
        return float(np.sqrt(np.nan_to_num(squares, nan=np.inf).mean()))

    def adjusted(
        self,
        placed: SparseScene,
        fit: ControlFit,
        threads: int,
        progress: Progress | None,
    ) -> tuple[SparseScene, tuple[LensVerdict, ...]]:
        """Adjust the scene with the points of a fit and all ties."""
        known = self.known(fit.used, fit.sigma)
        return adjust_to_ground(placed, known, threads=threads, progress=progress)

    def known(self, used: Sequence[int], sigma: float) -> list[KnownPoint]:
        """Return these points and all ties as input of an adjustment."""
        usual = max(self.surveyed or sigma, self.pixel)
        mark_px = max(HAND_MARK_PX, self.mark_px)
        known = [
            KnownPoint(
                self.local[i],
                self.control[i].sigma_m or usual,
                self.seen[i].views,
                self.seen[i].pixels,
                mark_px,
            )
            for i in used
        ]
        return known + [KnownPoint(None, 0.0, tie.views, tie.pixels, mark_px) for tie in self.ties]


@dataclass(frozen=True, eq=False)
class Bent:
    """scene : adjusted with the control points; None where the similarity alone is better
    fit : of the points in it; refusal : why it was not adjusted, None if it was
    """

    scene: SparseScene | None
    fit: ControlFit
    lenses: tuple[LensVerdict, ...]
    decisions: tuple[Finding, ...]
    refusal: Finding | None


def bent_to(
    ground: GroundPoints,
    placed: SparseScene,
    first: ControlFit,
    threads: int,
    progress: Progress | None,
) -> Bent:
    """The scene adjusted with the control points where that makes it better."""
    better, lenses = ground.adjusted(placed, first, threads, progress)
    again = _fitted_or_none(ground, better)
    # A wrong lens makes good points contradict each other, and scatter: judged again without it.
    if again is not None and (
        again.used != first.used or (not ground.surveyed and again.sigma < 0.7 * first.sigma)
    ):
        better, lenses = ground.adjusted(placed, again, threads, progress)
        again = _fitted_or_none(ground, better)
    # Control points that no bundle of rays can meet bend the model: the tie points tell.
    if again is None or not mean_error(better) <= 1.2 * mean_error(placed) + 0.1:
        refusal = Finding("control.contradicts-photos")
        return Bent(None, first, (), (), refusal)
    decisions = [lens.reason for lens in lenses]
    if ground.ties:
        decisions.append(Finding("control.tie-points", count=len(ground.ties)))
    misses = _misses_of_others(ground, placed, better, again, threads, progress)
    if misses is not None:
        bent, stiff = misses
        values = {"adjusted_m": bent, "similarity_m": stiff}
        if bent > _CLEARLY_WORSE * stiff and bent - stiff > _PART_OF_A_MISS * ground.pixel:
            return Bent(
                None,
                first,
                (),
                (),
                Finding("control.not-adjusted", **values),
            )
        decisions.append(Finding("control.adjusted", **values))
    return Bent(better, again, lenses, tuple(decisions), None)


def _fitted_or_none(ground: GroundPoints, scene: SparseScene) -> ControlFit | None:
    """Fit an adjusted scene; None if the adjustment failed, or lost the control points."""
    if not _is_sound(scene):
        return None
    try:
        return ground.fitted(scene)
    except GeometryError:
        return None


def _is_sound(scene: SparseScene) -> bool:
    """Whether an adjustment came to an end at all."""
    return bool(
        np.isfinite(scene.points).all()
        and np.isfinite(scene.centres).all()
        and math.isfinite(mean_error(scene))
    )


def _misses_of_others(
    ground: GroundPoints,
    placed: SparseScene,
    better: SparseScene,
    fit: ControlFit,
    threads: int,
    progress: Progress | None,
) -> tuple[float, float] | None:
    """Root mean square distances in metres by which control points miss that a model is not made
    of, each third in turn: of the one adjusted to the others, and of the one placed by them. None
    where there are too few."""
    if len(fit.used) < _FEWEST_TO_JUDGE:
        return None
    bent, stiff = [], []
    for k in range(_FOLDS):
        out = fit.used[k::_FOLDS]
        rest = [i for i in fit.used if i not in out]
        try:
            require_width(ground.local[rest])
            again = fit_similarity(ground.places(placed, rest), ground.local[rest])
        except GeometryError:
            continue
        start = moved(placed, again, ground.origin, placed.crs)
        # With the lenses that all points have given: finding them takes most of the time.
        views = zip(start.views, better.views, strict=True)
        begun = replace(start, views=tuple(replace(v, intrinsics=b.intrinsics) for v, b in views))
        known = ground.known(rest, fit.sigma)
        trial = bundle_adjust(begun, known, threads=threads, progress=progress)
        if not _is_sound(trial):
            return math.inf, ground.off(start, out)
        bent += [ground.off(trial, [i]) for i in out]
        stiff += [ground.off(start, [i]) for i in out]
    if not bent:
        return None
    return float(np.sqrt(np.mean(np.square(bent)))), float(np.sqrt(np.mean(np.square(stiff))))


def require_width(local: FloatArray) -> None:
    """Raises GeometryError where points (n, 3) lie on one line."""
    if nearly_on_a_line(local):
        raise GeometryError(Finding("control.collinear"))
