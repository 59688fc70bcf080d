"""Bundle adjustment of a registered scene with control points, marks and GPS positions."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.geometry.triangulation import triangulate
from vomstudio.photogrammetry.align.adjustment import (
    LOSS_SCALE_PX,
    create_adjuster,
    estimate_covariances,
    transfer_to_colmap,
)
from vomstudio.photogrammetry.align.mapping import convert_camera, point_errors, residuals
from vomstudio.photogrammetry.align.priors import MIN_PHOTOS_DISTORTION, Freedom, correlation_factor
from vomstudio.photogrammetry.base.colmap import colmap, run_cancellable
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.registration.marks.mark_errors import HAND_MARK_ERROR_PX

_MIN_NOISE_PX = 0.05
# Camera positions with larger residuals, in sigmas, are down-weighted.
_OUTLIER_SIGMAS = 2.0
# Weights depend on the residuals: iterate while they change by a fifth or more.
_MAX_ROUNDS = 3
_WEIGHT_TOLERANCE = 0.2


@dataclass(frozen=True, eq=False)
class KnownPoint:
    """Ground point in the frame of the scene.

    Attributes
    ----------
    position : (3,) array or None
        Position of the point; None if it only ties photos together.
    sigma : float
        Standard deviation of each coordinate.
    views : (k,) array
        Rows of the views in which the point is marked.
    pixels : (k, 2) array
        Marks in these views.
    mark_px : float
        Error of a mark in one direction, in pixels.
    """

    position: FloatArray | None
    sigma: float
    views: IntArray
    pixels: FloatArray
    mark_px: float = HAND_MARK_ERROR_PX


@dataclass(frozen=True, eq=False)
class KnownCentre:
    """Camera position in the scene frame: row of the view, position (3,) and sigma (3,)."""

    view: int
    position: FloatArray
    sigma: FloatArray


def bundle_adjust(
    scene: SparseScene,
    points: Sequence[KnownPoint],
    centres: Sequence[KnownCentre] = (),
    *,
    free_lenses: Collection[Intrinsics] = (),
    threads: int = -1,
    progress: Progress | None = None,
) -> SparseScene:
    """Adjust poses and tie points to marks, control points and GPS positions.

    Observations are weighted by their errors. Outliers among tie points and camera positions are
    down-weighted (Cauchy). Tie points are weighted as correlated with their neighbours (see
    `noise_px`).

    Parameters
    ----------
    scene : SparseScene
    points : sequence of KnownPoint
    centres : sequence of KnownCentre
    free_lenses : collection of Intrinsics
        Lenses whose focal length is refined. k1 is refined for all lenses with at least two photos,
        and all other parameters are fixed.
    threads : int
        Number of threads; -1 uses all cores.
    progress : Progress, optional

    Raises
    ------
    Cancelled
        If `progress` requests it.
    """
    for _ in range(_MAX_ROUNDS):
        noise = noise_px(scene)
        problem = _Problem(scene, points, centres, free_lenses, noise, threads, LOSS_SCALE_PX)
        run_cancellable(lambda _token, p=problem: p.adjuster.solve(), progress or SilentProgress())  # type: ignore[misc]
        scene, lenses = _update_scene(scene, problem.reconstruction)
        free_lenses = [lenses[lens] for lens in free_lenses]
        if abs(math.log(noise_px(scene) / noise)) < _WEIGHT_TOLERANCE:
            break
    return scene


def focal_length_sigmas(
    scene: SparseScene,
    points: Sequence[KnownPoint],
    centres: Sequence[KnownCentre] = (),
    *,
    free_lenses: Collection[Intrinsics],
    threads: int = -1,
) -> dict[Intrinsics, float]:
    """Return the relative one-sigma errors of the focal lengths of free lenses.

    They follow from tie points, control points and GPS positions, and are infinite if undetermined.
    """
    noise = noise_px(scene)
    problem = _Problem(scene, points, centres, free_lenses, noise, threads)
    covariances = estimate_covariances(problem.reconstruction, problem.adjuster, problem.freedoms)
    sigmas = {}
    for lens in free_lenses:
        covariance = covariances.get(problem.numbers[lens])
        variance = float("inf") if covariance is None else float(covariance[0, 0])
        is_known = math.isfinite(variance) and variance > 0
        sigmas[lens] = noise * math.sqrt(variance) / lens.focal[0] if is_known else float("inf")
    return sigmas


def noise_px(scene: SparseScene) -> float:
    """Return the error of a correlated tie point observation in one direction, in pixels."""
    misclosures = residuals(scene)
    is_finite = np.isfinite(misclosures).all(axis=1)
    if not is_finite.any():
        return 1.0
    # RMS of a two-dimensional Gaussian from its mean length, which is robust to a few outliers.
    rms = float(np.linalg.norm(misclosures[is_finite], axis=1).mean()) / math.sqrt(math.pi / 2)
    return max(_MIN_NOISE_PX, rms * correlation_factor(int(is_finite.sum()), len(scene.views)))


class _Problem:
    """Bundle adjustment problem in which residuals of tie points have unit weight.

    The weights of all other observations are relative to `noise`, the error of a tie point.

    Attributes
    ----------
    adjuster
        Bundle adjuster of `reconstruction`.
    numbers : dict
        Camera number of each lens.
    freedoms : dict
        Free parameters of each camera, by camera number.
    """

    def __init__(
        self,
        scene: SparseScene,
        points: Sequence[KnownPoint],
        centres: Sequence[KnownCentre],
        free_lenses: Collection[Intrinsics],
        noise: float,
        threads: int,
        loss_px: float | None = None,
    ) -> None:
        pycolmap = colmap()
        # This import registers the module of the cost functions.
        import pyceres.factors
        import pycolmap.cost_functions as costs

        self.reconstruction, self.numbers = convert_scene(scene)
        count = Counter(view.intrinsics for view in scene.views)
        self.freedoms = {
            number: Freedom(lens in free_lenses, count[lens] >= MIN_PHOTOS_DISTORTION)
            for lens, number in self.numbers.items()
        }
        has_datum = bool(centres) or sum(p.position is not None for p in points) >= 3
        self.adjuster = create_adjuster(
            self.reconstruction,
            self.freedoms,
            threads,
            fixes_gauge=not has_datum,
            loss_px=loss_px,
        )
        add = self.adjuster.problem.add_residual_block
        for point in points:
            mark_covariance = np.eye(2) * (point.mark_px / noise) ** 2
            start = point.position
            if start is None:
                start = triangulate([scene.views[r] for r in point.views], point.pixels)
            number = self.reconstruction.add_point3D(start, pycolmap.Track())
            place = self.reconstruction.point3D(number).xyz
            for row, pixel in zip(point.views, point.pixels, strict=True):
                image = self.reconstruction.image(int(row) + 1)
                camera = self.reconstruction.camera(image.camera_id)
                ray_cost = costs.ReprojErrorCost(camera.model, mark_covariance, pixel)
                pose = image.frame.rig_from_world.params
                add(transfer_to_colmap(ray_cost), None, [place, pose, camera.params])
            if point.position is not None:
                prior = pyceres.factors.NormalPrior(
                    point.position, np.eye(3) * (point.sigma / noise) ** 2
                )
                add(transfer_to_colmap(prior), None, [place])
        for centre in centres:
            frame = self.reconstruction.image(centre.view + 1).frame
            covariance = np.diag((centre.sigma / noise) ** 2)
            prior_cost = costs.AbsolutePosePositionPriorCost(covariance, centre.position)
            loss = pyceres.CauchyLoss(_OUTLIER_SIGMAS * noise)
            # Residuals are in units of sigma / noise.
            add(
                transfer_to_colmap(prior_cost),
                transfer_to_colmap(loss),
                [frame.rig_from_world.params],
            )


def convert_scene(scene: SparseScene) -> tuple[Any, dict[Intrinsics, int]]:
    """Convert a scene to a COLMAP reconstruction, with the camera number of each lens.

    View i becomes image i + 1, and tie point i becomes point i + 1.
    """
    pycolmap = colmap()
    reconstruction = pycolmap.Reconstruction()
    cameras: dict[Intrinsics, int] = {}
    slot = np.zeros(len(scene.track_views), np.int64)
    for row, view in enumerate(scene.views):
        observation_rows = np.flatnonzero(scene.track_views == row)
        slot[observation_rows] = np.arange(len(observation_rows))
        lens = view.intrinsics
        if lens not in cameras:
            cameras[lens] = len(cameras) + 1
            camera = pycolmap.Camera(
                model=lens.model, width=lens.width, height=lens.height, params=list(lens.params)
            )
            camera.camera_id = cameras[lens]
            reconstruction.add_camera_with_trivial_rig(camera)
        image = pycolmap.Image(
            name=f"{row + 1:06d}",
            keypoints=scene.track_pixels[observation_rows].astype(np.float64),
            camera_id=cameras[lens],
            image_id=row + 1,
        )
        pose = pycolmap.Rigid3d(np.column_stack([view.rotation, view.translation]))
        reconstruction.add_image_with_trivial_frame(image, pose)
    for i in range(len(scene.points)):
        track = pycolmap.Track()
        for k in range(scene.track_offsets[i], scene.track_offsets[i + 1]):
            track.add_element(int(scene.track_views[k]) + 1, int(slot[k]))
        reconstruction.add_point3D(scene.points[i], track)
    return reconstruction, cameras


def _update_scene(
    scene: SparseScene, reconstruction: Any
) -> tuple[SparseScene, dict[Intrinsics, Intrinsics]]:
    """Return the adjusted scene, and the adjusted lens of each original lens."""
    lenses = {number: convert_camera(camera) for number, camera in reconstruction.cameras.items()}
    views, adjusted_lenses = [], {}
    for row, view in enumerate(scene.views):
        image = reconstruction.image(row + 1)
        adjusted_lenses[view.intrinsics] = lenses[image.camera_id]
        pose = np.asarray(image.cam_from_world().matrix(), np.float64)
        rotation, translation = np.ascontiguousarray(pose[:, :3]), pose[:, 3].copy()
        views.append(View(view.name, lenses[image.camera_id], rotation, translation))
    points = np.array([reconstruction.point3D(i + 1).xyz for i in range(len(scene.points))])
    scene = replace(scene, views=tuple(views), points=points.reshape(-1, 3))
    return replace(scene, errors_px=point_errors(scene)), adjusted_lenses
