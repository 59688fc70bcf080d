"""Bundle adjustment with free parameters chosen for each camera, and its cross-validation."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.progress import Progress, Silent
from vomstudio.photogrammetry.align.priors import HELD, Freedom, parameter_names
from vomstudio.photogrammetry.base.colmap import cancellable, colmap

# Observations farther off are no observations of that point (as in COLMAP's mapper).
MAX_ERROR_PX = 4.0
MIN_ANGLE_DEG = 1.5
# Residuals of good observations are about half a pixel; wrong matches pull by less, the farther off
# they are (Cauchy).
LOSS_PX = 0.5
_TOLERANCE = 1e-5
# Every so many tie points judge cameras that were adjusted without them.
_HELD_OUT = 5


def adjust(
    reconstruction: Any,
    freedoms: Mapping[int, Freedom],
    *,
    threads: int = -1,
    rounds: int = 2,
    covariance: bool = True,
    progress: Progress | None = None,
) -> dict[int, FloatArray]:
    """Refine poses, points and what `freedoms` (by camera) leaves free, in place; then drop bad
    observations, and again. Observations count less the farther off they are.

    Returns the formal covariance (k, k) of the k free parameters of each camera, for residuals of
    unit variance; cameras are missing where it could not be had. Raises Cancelled.
    """
    pycolmap = colmap()
    found: dict[int, FloatArray] = {}
    for left in range(rounds, 0, -1):
        adjuster = adjuster_of(reconstruction, freedoms, threads, loss_px=LOSS_PX)
        cancellable(lambda _token, a=adjuster: a.solve(), progress or Silent())  # type: ignore[misc]
        if covariance and left == 1:
            # Of residuals that all count alike, as their RMS by which it is multiplied.
            alike = adjuster_of(reconstruction, freedoms, threads)
            found = covariances_of(reconstruction, alike, freedoms)
        manager = pycolmap.ObservationManager(reconstruction)
        manager.filter_all_points3D(MAX_ERROR_PX, MIN_ANGLE_DEG)
    return found


def cross_validation_error(
    reconstruction: Any,
    freedoms: Mapping[int, Freedom],
    *,
    threads: int = -1,
    progress: Progress | None = None,
) -> float:
    """Mean reprojection error, pixels, of every fifth tie point in 3 photos or more, of cameras
    that were adjusted without those points; NaN where there are none. `reconstruction` stays.

    Raises Cancelled.
    """
    pycolmap = colmap()
    ids = sorted(reconstruction.point3D_ids())
    long = [i for i in ids if reconstruction.point3D(i).track.length() >= 3]
    unseen = set(long[::_HELD_OUT])
    if not unseen or len(unseen) == len(ids):
        return float("nan")
    fitted, judged = (
        pycolmap.Reconstruction(reconstruction),
        pycolmap.Reconstruction(reconstruction),
    )
    for i in ids:
        (fitted if i in unseen else judged).delete_point3D(i)
    adjuster = adjuster_of(fitted, freedoms, threads, loss_px=LOSS_PX)
    cancellable(lambda _token: adjuster.solve(), progress or Silent())
    for number in fitted.cameras:
        judged.camera(number).params = fitted.camera(number).params
    for image in judged.reg_image_ids():
        pose = fitted.image(image).frame.rig_from_world
        judged.image(image).frame.rig_from_world = pose
    points = adjuster_of(judged, {}, threads, poses=False)
    cancellable(lambda _token: points.solve(), progress or Silent())
    judged.update_point_3d_errors()
    return float(judged.compute_mean_reprojection_error())


def free_parameters(camera: Any, freedom: Freedom) -> list[int]:
    """Places of a camera's free parameters."""
    free = {
        "f": freedom.focal,
        "c": freedom.centre,
        "k1": freedom.distortion,
        "k2": freedom.second,
    }
    names = parameter_names(str(camera.model_name))
    return [i for i, name in enumerate(names) if free.get(name, free.get(name[0], False))]


def free_in(problem: Any, camera: Any, freedom: Freedom) -> None:
    """Hold what `freedom` does not free of a camera whose parameters are all free in `problem`."""
    import pyceres

    free = free_parameters(camera, freedom)
    held = [i for i in range(len(camera.params)) if i not in free]
    if held and problem.has_parameter_block(camera.params):
        manifold = pyceres.SubsetManifold(len(camera.params), held)
        problem.set_manifold(camera.params, owned_by_colmap(manifold))


def owned_by_colmap(thing: Any) -> Any:
    """The thing, which Python must not delete: COLMAP's problem deletes its parts itself."""
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(thing))
    return thing


def adjuster_of(
    reconstruction: Any,
    freedoms: Mapping[int, Freedom],
    threads: int,
    *,
    poses: bool = True,
    gauge: bool = True,
    loss_px: float | None = None,
) -> Any:
    """A bundle adjuster in which each camera has its own free parameters (COLMAP frees a kind of
    parameter of all cameras or of none).

    Frames without a pose are removed from `reconstruction`, with their images and with cameras that
    have no other: COLMAP estimates covariances only if every frame has a pose.

    gauge : two cameras hold the frame; False where something else does
    loss_px : residual from which observations count clearly less; None if all count alike
    """
    pycolmap = colmap()
    # The module of the problem is registered by this import.
    import pyceres  # noqa: F401

    reconstruction.tear_down()
    options = pycolmap.BundleAdjustmentOptions()
    options.print_summary = False
    options.refine_focal_length = options.refine_extra_params = True
    options.refine_principal_point = True
    options.ceres.solver_options.num_threads = threads
    if loss_px is not None:
        options.ceres.loss_function_type = pycolmap.LossFunctionType.CAUCHY
        options.ceres.loss_function_scale = loss_px
        # A robust sum creeps for 100 steps to where one in a million of it is left.
        options.ceres.solver_options.function_tolerance = _TOLERANCE
    config = pycolmap.BundleAdjustmentConfig()
    images = sorted(reconstruction.reg_image_ids())
    for image in images:
        config.add_image(image)
        if not poses:
            config.set_constant_rig_from_world_pose(reconstruction.image(image).frame_id)
    if poses and gauge:
        config.fix_gauge(pycolmap.BundleAdjustmentGauge.TWO_CAMS_FROM_WORLD)
    numbers = sorted({reconstruction.image(i).camera_id for i in images})
    free = [n for n in numbers if freedoms.get(n, HELD) != HELD]
    for number in numbers:
        if number not in free:
            config.set_constant_cam_intrinsics(number)
    adjuster = pycolmap.create_default_ceres_bundle_adjuster(options, config, reconstruction)
    for number in free:
        free_in(adjuster.problem, reconstruction.camera(number), freedoms[number])
    return adjuster


def covariances_of(
    reconstruction: Any, adjuster: Any, freedoms: Mapping[int, Freedom]
) -> dict[int, FloatArray]:
    """Of each camera's free parameters, for residuals of unit variance, where it can be had."""
    pycolmap = colmap()
    estimate = pycolmap.estimate_ba_covariance(
        pycolmap.BACovarianceOptions(), reconstruction, adjuster
    )
    found = {}
    if estimate is not None:
        for number, freedom in freedoms.items():
            if not reconstruction.exists_camera(number):
                continue
            camera = reconstruction.camera(number)
            if free_parameters(camera, freedom):
                matrix = estimate.get_other_params_cov(camera.params)
                if matrix is not None:
                    found[number] = np.array(matrix, np.float64)
    return found
