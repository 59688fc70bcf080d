"""Adjustment of a scene with its control points if this improves the scene.

A bundle adjustment bends the model to fit the control points. If these are wrong, or less accurate
than the shape determined by the photos, the bent model is worse than one placed by a similarity.
The two are therefore compared at points that are used for neither of them, and the better one is
used.
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
from vomstudio.photogrammetry.georeferencing.world_frame import place_in_world
from vomstudio.registration.marks.mark_errors import HAND_MARK_ERROR_PX
from vomstudio.registration.scatter import Scatter, estimate_scatter
from vomstudio.registration.similarity import (
    Similarity,
    fit_robustly,
    fit_similarity,
    is_nearly_collinear,
)

_MIN_ERROR_PX = 0.1
_N_FOLDS = 3
# Tolerances of the comparison: the scatter of a few points is uncertain by a quarter, and residuals
# by a fraction of a pixel.
_MAX_RESIDUAL_RATIO, _RESIDUAL_TOLERANCE_PX = 1.25, 0.5
_MIN_POINTS_TO_COMPARE = 5
"""Minimum number of control points for comparing the scene with and without bending.

Check points are not used, since they would then no longer be independent."""


@dataclass(frozen=True, eq=False)
class ControlFit:
    """Similarity fitted to the consistent control points (rows), and their scatter."""

    fit: Similarity
    used: list[int]
    scatter: Scatter

    @property
    def sigma(self) -> float:
        """Standard deviation of a horizontal coordinate, in metres."""
        return self.scatter.horizontal_sigma


@dataclass(frozen=True, eq=False)
class GroundPoints:
    """Marked control points and tie points, prepared for the registration.

    Attributes
    ----------
    control, control_marks : sequence
        The control points and their marks.
    local_positions : (n, 3) array
        Coordinates of the control points minus `origin`.
    fitting_rows : list of int
        Rows of the points that can place the scene.
    ties : list of PointMarks
        Markers without coordinates, which only tie photos together.
    surveyed_sigma : float
        Typical stated error of a coordinate, m; 0 if no errors are stated.
    pixel : float
        Size of a pixel on the ground, in metres.
    min_sigma : float
        Minimum sigma, m; points with smaller residuals are not treated as outliers.
    mark_px : float
        Error of a mark in one direction, in pixels.
    """

    control: Sequence[ControlPoint]
    control_marks: list[PointMarks]
    local_positions: FloatArray
    origin: tuple[int, int, int]
    fitting_rows: list[int]
    ties: list[PointMarks]
    surveyed_sigma: float
    pixel: float
    min_sigma: float
    mark_px: float

    def locate_points(self, scene: SparseScene, rows: Sequence[int]) -> FloatArray:
        """Return the positions (n, 3) of the points in `rows` in a scene."""
        return np.array([self.control_marks[row].place(scene) for row in rows])

    def fit_scene(self, scene: SparseScene) -> ControlFit:
        """Robustly fit the similarity from the scene to the control points.

        Raises GeometryError if the scene does not locate the points, or if they do not determine
        the similarity.
        """
        positions = self.locate_points(scene, self.fitting_rows)
        if not np.isfinite(positions).all():
            raise GeometryError(Finding("control.not-located"))
        targets = self.local_positions[list(self.fitting_rows)]
        require_width(positions)
        fit, is_inlier = fit_robustly(positions, targets, min_sigma=self.min_sigma)
        misses = (fit(positions) - targets)[is_inlier]
        used_rows = [i for i, is_good in zip(self.fitting_rows, is_inlier, strict=True) if is_good]
        stated_errors = self.errors(scene, fit, used_rows) if self.surveyed_sigma else None
        scatter = estimate_scatter(targets[is_inlier], misses, stated_errors, is_ordered=True)
        # Even with exact coordinates, the error is a fraction of a pixel.
        if not scatter.covariance.any():
            scatter = estimate_scatter(targets[is_inlier], misses, _MIN_ERROR_PX * self.pixel)
        worst_rotation = scatter.worst_rotation_deg
        if not worst_rotation <= MAX_ROTATION_ERROR_DEG:
            raise GeometryError(
                Finding(
                    "control.contradicts",
                    sigma_m=float(np.sqrt((scatter.sigma**2).mean())),
                    rotation_deg=worst_rotation,
                )
            )
        return ControlFit(fit, used_rows, scatter)

    def errors(self, scene: SparseScene, fit: Similarity, rows: Sequence[int]) -> FloatArray:
        """Return the covariances (n, 3, 3) of points, from survey accuracy and scatter of marks.

        fit : similarity from the scene to the control points
        """
        rotation = fit.scale * fit.rotation
        errors = []
        for row in rows:
            mark_covariance = self.control_marks[row].covariance(scene, self.mark_px)
            point_sigma = self.control[row].sigma_m or self.surveyed_sigma
            errors.append(rotation @ mark_covariance @ rotation.T + point_sigma**2 * np.eye(3))
        return np.array(errors)

    def rms_residual_m(self, scene: SparseScene, rows: Sequence[int]) -> float:
        """Return the RMS residual of points in a placed scene, in metres.

        Returns infinity if a point cannot be located.
        """
        squared_distances = (
            (self.locate_points(scene, rows) - self.local_positions[list(rows)]) ** 2
        ).sum(axis=1)
        return float(np.sqrt(np.nan_to_num(squared_distances, nan=np.inf).mean()))

    def adjust_scene(
        self,
        placed_scene: SparseScene,
        fit: ControlFit,
        threads: int,
        progress: Progress | None,
    ) -> tuple[SparseScene, tuple[LensVerdict, ...]]:
        """Adjust the scene with the points of a fit and all tie markers."""
        known_points = self.known_points(fit.used, fit.sigma)
        return adjust_to_ground(placed_scene, known_points, threads=threads, progress=progress)

    def known_points(self, used_indices: Sequence[int], sigma: float) -> list[KnownPoint]:
        """Return the used points and all tie markers as input of an adjustment."""
        usual_sigma = max(self.surveyed_sigma or sigma, self.pixel)
        mark_px = max(HAND_MARK_ERROR_PX, self.mark_px)
        known_points = [
            KnownPoint(
                self.local_positions[i],
                self.control[i].sigma_m or usual_sigma,
                self.control_marks[i].views,
                self.control_marks[i].pixels,
                mark_px,
            )
            for i in used_indices
        ]
        return known_points + [
            KnownPoint(None, 0.0, tie.views, tie.pixels, mark_px) for tie in self.ties
        ]


@dataclass(frozen=True, eq=False)
class BendingResult:
    """Result of the adjustment to control points.

    scene : scene adjusted with the control points; None if the similarity alone is better
    fit : fit of the control points in this scene, or in the original one if it is None
    refusal : reason why the scene was not adjusted; None if it was adjusted
    """

    scene: SparseScene | None
    fit: ControlFit
    lenses: tuple[LensVerdict, ...]
    decisions: tuple[Finding, ...]
    refusal: Finding | None


def bend_to_control(
    ground_points: GroundPoints,
    placed_scene: SparseScene,
    first_fit: ControlFit,
    threads: int,
    progress: Progress | None,
) -> BendingResult:
    """Adjust the scene with the control points if this improves it."""
    adjusted_scene, lenses = ground_points.adjust_scene(placed_scene, first_fit, threads, progress)
    second_fit = _fitted_or_none(ground_points, adjusted_scene)
    # A wrong lens makes good points scatter and contradict each other, so judge them again without
    # it.
    if second_fit is not None and (
        second_fit.used != first_fit.used
        or (not ground_points.surveyed_sigma and second_fit.sigma < 0.7 * first_fit.sigma)
    ):
        adjusted_scene, lenses = ground_points.adjust_scene(
            placed_scene, second_fit, threads, progress
        )
        second_fit = _fitted_or_none(ground_points, adjusted_scene)
    # Control points that no bundle of rays can fit bend the model, which shows in the tie points.
    if second_fit is None or not mean_error(adjusted_scene) <= 1.2 * mean_error(placed_scene) + 0.1:
        refusal = Finding("control.contradicts-photos")
        return BendingResult(None, first_fit, (), (), refusal)
    decisions = [lens.reason for lens in lenses]
    if ground_points.ties:
        decisions.append(Finding("control.tie-points", count=len(ground_points.ties)))
    misses = _cross_validation_residuals(
        ground_points, placed_scene, adjusted_scene, second_fit, threads, progress
    )
    if misses is not None:
        bent_residuals, rigid_residuals = misses
        values = {"adjusted_m": bent_residuals, "similarity_m": rigid_residuals}
        if (
            bent_residuals > _MAX_RESIDUAL_RATIO * rigid_residuals
            and bent_residuals - rigid_residuals > _RESIDUAL_TOLERANCE_PX * ground_points.pixel
        ):
            return BendingResult(
                None,
                first_fit,
                (),
                (),
                Finding("control.not-adjusted", **values),
            )
        decisions.append(Finding("control.adjusted", **values))
    return BendingResult(adjusted_scene, second_fit, lenses, tuple(decisions), None)


def _fitted_or_none(ground_points: GroundPoints, scene: SparseScene) -> ControlFit | None:
    """Fit an adjusted scene, or return None if it did not converge or cannot be fitted."""
    if not _has_converged(scene):
        return None
    try:
        return ground_points.fit_scene(scene)
    except GeometryError:
        return None


def _has_converged(scene: SparseScene) -> bool:
    """Return whether the result of an adjustment is finite."""
    return bool(
        np.isfinite(scene.points).all()
        and np.isfinite(scene.centres).all()
        and math.isfinite(mean_error(scene))
    )


def _cross_validation_residuals(
    ground_points: GroundPoints,
    placed_scene: SparseScene,
    adjusted_sparse_scene: SparseScene,
    fit: ControlFit,
    threads: int,
    progress: Progress | None,
) -> tuple[float, float] | None:
    """Return the cross-validation residuals of control points, leaving out a third in turn.

    These are the RMS residuals, in metres, of the points left out: first in the scene adjusted to
    the remaining points (infinite if an adjustment fails), then in the scene only placed by them.
    Returns None if there are too few points.
    """
    if len(fit.used) < _MIN_POINTS_TO_COMPARE:
        return None
    bent_residuals, rigid_residuals = [], []
    for k in range(_N_FOLDS):
        left_out_rows = fit.used[k::_N_FOLDS]
        other_rows = [i for i in fit.used if i not in left_out_rows]
        try:
            require_width(ground_points.local_positions[other_rows])
            second_fit = fit_similarity(
                ground_points.locate_points(placed_scene, other_rows),
                ground_points.local_positions[other_rows],
            )
        except GeometryError:
            continue
        start = place_in_world(placed_scene, second_fit, ground_points.origin, placed_scene.crs)
        # Use the lenses of the complete adjustment, because estimating them takes most of the time.
        views = zip(start.views, adjusted_sparse_scene.views, strict=True)
        start_scene = replace(
            start, views=tuple(replace(v, intrinsics=b.intrinsics) for v, b in views)
        )
        known_points = ground_points.known_points(other_rows, fit.sigma)
        trial = bundle_adjust(start_scene, known_points, threads=threads, progress=progress)
        if not _has_converged(trial):
            return math.inf, ground_points.rms_residual_m(start, left_out_rows)
        bent_residuals += [ground_points.rms_residual_m(trial, [i]) for i in left_out_rows]
        rigid_residuals += [ground_points.rms_residual_m(start, [i]) for i in left_out_rows]
    if not bent_residuals:
        return None
    return float(np.sqrt(np.mean(np.square(bent_residuals)))), float(
        np.sqrt(np.mean(np.square(rigid_residuals)))
    )


def require_width(local_points: FloatArray) -> None:
    """Raise GeometryError if points (n, 3) are collinear."""
    if is_nearly_collinear(local_points):
        raise GeometryError(Finding("control.collinear"))
