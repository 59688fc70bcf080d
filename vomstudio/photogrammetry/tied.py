"""Adjusting a placed scene together with what is known of the ground: control points and GPS."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.photogrammetry.adjustment import given
from vomstudio.photogrammetry.engine import cancellable, colmap
from vomstudio.photogrammetry.mapping import intrinsics_of, point_errors
from vomstudio.photogrammetry.scene import SparseScene
from vomstudio.progress import Progress, Silent

Array = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class KnownPoint:
    """A point of the ground in the frame of the scene.

    position : (3,) or None for a point that only ties photos together
    sigma : of each of its coordinates
    views : (k,) rows of the views in which it is marked; pixels : (k, 2)
    """

    position: Array | None
    sigma: float
    views: npt.NDArray[np.int64]
    pixels: Array


@dataclass(frozen=True, eq=False)
class KnownCentre:
    """A camera position in the frame of the scene: row of the view, (3,), (3,) sigma."""

    view: int
    position: Array
    sigma: Array


def adjust_tied(
    scene: SparseScene,
    points: Sequence[KnownPoint],
    centres: Sequence[KnownCentre] = (),
    *,
    threads: int = -1,
    progress: Progress | None = None,
) -> SparseScene:
    """The scene with poses and tie points refined, lenses held, so that marks, control points and
    GPS fit, each by its own error; a mark counts as one observation of a tie point.

    Raises Cancelled.
    """
    pycolmap = colmap()
    # The module of the cost functions is registered by this import.
    import pyceres.factors
    import pycolmap.cost_functions as costs

    reconstruction, numbers = reconstruction_of(scene, points)
    options = pycolmap.BundleAdjustmentOptions()
    options.print_summary = False
    options.refine_focal_length = False
    options.refine_extra_params = False
    options.ceres.solver_options.num_threads = threads
    config = pycolmap.BundleAdjustmentConfig()
    for image in sorted(reconstruction.reg_image_ids()):
        config.add_image(image)
    if not centres and sum(p.position is not None for p in points) < 3:
        config.fix_gauge(pycolmap.BundleAdjustmentGauge.TWO_CAMS_FROM_WORLD)
    adjuster = pycolmap.create_default_ceres_bundle_adjuster(options, config, reconstruction)
    for number, point in zip(numbers, points, strict=True):
        if point.position is not None:
            prior = pyceres.factors.NormalPrior(point.position, np.eye(3) * point.sigma**2)
            block = reconstruction.point3D(number).xyz
            adjuster.problem.add_residual_block(given(prior), None, [block])
    for centre in centres:
        frame = reconstruction.image(centre.view + 1).frame
        prior = costs.AbsolutePosePositionPriorCost(np.diag(centre.sigma**2), centre.position)
        adjuster.problem.add_residual_block(
            given(prior), given(pyceres.CauchyLoss(2.0)), [frame.rig_from_world.params]
        )
    cancellable(lambda _token: adjuster.solve(), progress or Silent())
    return _updated(scene, reconstruction)


def reconstruction_of(
    scene: SparseScene, points: Sequence[KnownPoint] = ()
) -> tuple[Any, list[int]]:
    """(COLMAP's reconstruction of a scene and of `points`, numbers of the latter).

    View i is image i + 1, tie point i is number i + 1.
    """
    pycolmap = colmap()
    reconstruction = pycolmap.Reconstruction()
    cameras: dict[Intrinsics, int] = {}
    pixels: list[list[Array]] = [[] for _ in scene.views]
    slot = np.zeros(len(scene.track_views), np.int64)
    for row in range(len(scene.views)):
        mine = np.flatnonzero(scene.track_views == row)
        slot[mine] = np.arange(len(mine))
        pixels[row].append(scene.track_pixels[mine].astype(np.float64))
    counts = [len(p[0]) for p in pixels]
    known_slots = []
    for point in points:
        taken = []
        for row, pixel in zip(point.views, point.pixels, strict=True):
            pixels[row].append(np.asarray(pixel, np.float64).reshape(1, 2))
            taken.append(counts[row])
            counts[row] += 1
        known_slots.append(taken)
    for row, view in enumerate(scene.views):
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
            keypoints=np.concatenate(pixels[row]),
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
    numbers = []
    for point, taken in zip(points, known_slots, strict=True):
        track = pycolmap.Track()
        for row, place in zip(point.views, taken, strict=True):
            track.add_element(int(row) + 1, place)
        start = point.position
        if start is None:
            start = triangulate([scene.views[r] for r in point.views], point.pixels)
        numbers.append(int(reconstruction.add_point3D(start, track)))
    return reconstruction, numbers


def _updated(scene: SparseScene, reconstruction: Any) -> SparseScene:
    lenses = {number: intrinsics_of(camera) for number, camera in reconstruction.cameras.items()}
    views = []
    for row, view in enumerate(scene.views):
        image = reconstruction.image(row + 1)
        pose = np.asarray(image.cam_from_world().matrix(), np.float64)
        rotation, translation = np.ascontiguousarray(pose[:, :3]), pose[:, 3].copy()
        views.append(View(view.name, lenses[image.camera_id], rotation, translation))
    points = np.array([reconstruction.point3D(i + 1).xyz for i in range(len(scene.points))])
    scene = replace(scene, views=tuple(views), points=points.reshape(-1, 3))
    return replace(scene, errors_px=point_errors(scene))


def triangulate(views: Sequence[View], pixels: npt.ArrayLike) -> Array:
    """(3,) the point whose projections miss `pixels` (k, 2) in the k views least; NaN where the
    rays do not say (fewer than two, or parallel).

    Nearest point of the rays, then Gauss-Newton on the pixels.
    """
    marks = np.asarray(pixels, np.float64).reshape(-1, 2)
    if len(views) < 2:
        return np.full(3, np.nan)
    normal, right = np.zeros((3, 3)), np.zeros(3)
    for view, mark in zip(views, marks, strict=True):
        ray = view.rays(mark)[0]
        across = np.eye(3) - np.outer(ray, ray)
        normal += across
        right += across @ view.centre
    if not np.isfinite(normal).all() or np.linalg.cond(normal) > 1e8:
        return np.full(3, np.nan)
    point = np.linalg.solve(normal, right)
    step = 1e-6 * max(1e-9, float(np.linalg.norm(point - views[0].centre)))
    offsets = np.vstack([np.zeros(3), np.eye(3) * step, -np.eye(3) * step])
    for _ in range(10):
        seen = np.array([view.project(point + offsets) for view in views])
        miss = (marks - seen[:, 0]).ravel()
        jacobian = ((seen[:, 1:4] - seen[:, 4:]) / (2 * step)).transpose(0, 2, 1).reshape(-1, 3)
        if not np.isfinite(jacobian).all():
            return np.full(3, np.nan)
        change = np.linalg.lstsq(jacobian, miss, rcond=None)[0]
        point = point + change
        if np.linalg.norm(change) < step:
            break
    return np.asarray(point)
