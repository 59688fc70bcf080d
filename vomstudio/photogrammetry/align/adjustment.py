"""Bundle adjustment with separate free parameters per camera, and its cross-validation."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.photogrammetry.align.priors import ALL_FIXED, Freedom, parameter_names
from vomstudio.photogrammetry.base.colmap import colmap, run_cancellable

# Observations with larger errors are dropped (as in COLMAP's mapper).
MAX_ERROR_PX = 4.0
MIN_ANGLE_DEG = 1.5
# Scale of the Cauchy loss: residuals of good observations are about half a pixel.
LOSS_SCALE_PX = 0.5
_FUNCTION_TOLERANCE = 1e-5
# One in this many tie points is left out for cross-validation.
_FOLD_SIZE = 5


def adjust(
    reconstruction: Any,
    freedoms: Mapping[int, Freedom],
    *,
    threads: int = -1,
    rounds: int = 2,
    includes_covariance: bool = True,
    progress: Progress | None = None,
) -> dict[int, FloatArray]:
    """Refine poses, points and free camera parameters in place, and drop outliers.

    Large residuals are down-weighted.

    Parameters
    ----------
    reconstruction : pycolmap.Reconstruction
    freedoms : mapping
        Free parameters of each camera, by camera number.
    threads : int
        Number of threads; -1 uses all cores.
    rounds : int
        Number of times the adjustment and the outlier filter are repeated.
    includes_covariance : bool
        Whether to estimate the covariances of the camera parameters.
    progress : Progress, optional

    Returns
    -------
    dict of int to (k, k) array
        Formal covariance of the k free parameters of each camera, for residuals of unit variance.
        Cameras whose covariance cannot be estimated are omitted. Empty if `includes_covariance` is
        False.

    Raises
    ------
    Cancelled
        If `progress` requests it.
    """
    pycolmap = colmap()
    covariances: dict[int, FloatArray] = {}
    for remaining_rounds in range(rounds, 0, -1):
        adjuster = create_adjuster(reconstruction, freedoms, threads, loss_px=LOSS_SCALE_PX)
        run_cancellable(lambda _token, a=adjuster: a.solve(), progress or SilentProgress())  # type: ignore[misc]
        if includes_covariance and remaining_rounds == 1:
            # Use equal weights, as does the RMS by which the covariance is multiplied.
            unweighted_problem = create_adjuster(reconstruction, freedoms, threads)
            covariances = estimate_covariances(reconstruction, unweighted_problem, freedoms)
        manager = pycolmap.ObservationManager(reconstruction)
        manager.filter_all_points3D(MAX_ERROR_PX, MIN_ANGLE_DEG)
    return covariances


def cross_validation_error(
    reconstruction: Any,
    freedoms: Mapping[int, Freedom],
    *,
    threads: int = -1,
    progress: Progress | None = None,
) -> float:
    """Return the mean error of tie points left out of the adjustment, in pixels.

    Every fifth tie point that is seen in at least three photos is left out when the cameras are
    adjusted. Returns NaN if there are no such points or no others. `reconstruction` is not changed.
    Raises Cancelled.
    """
    pycolmap = colmap()
    ids = sorted(reconstruction.point3D_ids())
    long_track_ids = [i for i in ids if reconstruction.point3D(i).track.length() >= 3]
    validation_ids = set(long_track_ids[::_FOLD_SIZE])
    if not validation_ids or len(validation_ids) == len(ids):
        return float("nan")
    fitted_reconstruction, validation_reconstruction = (
        pycolmap.Reconstruction(reconstruction),
        pycolmap.Reconstruction(reconstruction),
    )
    for i in ids:
        (
            fitted_reconstruction if i in validation_ids else validation_reconstruction
        ).delete_point3D(i)
    adjuster = create_adjuster(fitted_reconstruction, freedoms, threads, loss_px=LOSS_SCALE_PX)
    run_cancellable(lambda _token: adjuster.solve(), progress or SilentProgress())
    for number in fitted_reconstruction.cameras:
        validation_reconstruction.camera(number).params = fitted_reconstruction.camera(
            number
        ).params
    for image in validation_reconstruction.reg_image_ids():
        pose = fitted_reconstruction.image(image).frame.rig_from_world
        validation_reconstruction.image(image).frame.rig_from_world = pose
    point_adjuster = create_adjuster(validation_reconstruction, {}, threads, includes_poses=False)
    run_cancellable(lambda _token: point_adjuster.solve(), progress or SilentProgress())
    validation_reconstruction.update_point_3d_errors()
    return float(validation_reconstruction.compute_mean_reprojection_error())


def free_parameter_indices(camera: Any, freedom: Freedom) -> list[int]:
    """Return the indices of a camera's free parameters."""
    is_free_by_name = {
        "f": freedom.focal,
        "c": freedom.centre,
        "k1": freedom.distortion,
        "k2": freedom.second_radial,
    }
    names = parameter_names(str(camera.model_name))
    return [
        i
        for i, name in enumerate(names)
        if is_free_by_name.get(name, is_free_by_name.get(name[0], False))
    ]


def fix_parameters(problem: Any, camera: Any, freedom: Freedom) -> None:
    """Keep constant the camera parameters that `freedom` does not free."""
    import pyceres

    free_indices = free_parameter_indices(camera, freedom)
    fixed_indices = [i for i in range(len(camera.params)) if i not in free_indices]
    if fixed_indices and problem.has_parameter_block(camera.params):
        manifold = pyceres.SubsetManifold(len(camera.params), fixed_indices)
        problem.set_manifold(camera.params, transfer_to_colmap(manifold))


def transfer_to_colmap(part: Any) -> Any:
    """Transfer the ownership of a part of a problem to COLMAP, and return the part.

    The problem then deletes the part, and Python does not.
    """
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(part))
    return part


def create_adjuster(
    reconstruction: Any,
    freedoms: Mapping[int, Freedom],
    threads: int,
    *,
    includes_poses: bool = True,
    fixes_gauge: bool = True,
    loss_px: float | None = None,
) -> Any:
    """Create a bundle adjuster in which each camera has its own free parameters.

    COLMAP itself can only free a parameter for all cameras or for none. Frames without a pose are
    removed from `reconstruction` together with their images and cameras, because COLMAP estimates
    covariances only if every frame has a pose.

    Parameters
    ----------
    reconstruction : pycolmap.Reconstruction
    freedoms : mapping
        Free parameters by camera number; other cameras are fixed.
    threads : int
        Number of threads; -1 uses all cores.
    includes_poses : bool
        Whether the poses are free.
    fixes_gauge : bool
        Whether two cameras fix the coordinate frame; False if other observations fix it.
    loss_px : float, optional
        Scale of the robust loss. If None, all observations have equal weights.
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
        # With a robust loss, the last millionth of the improvement would take 100 more steps.
        options.ceres.solver_options.function_tolerance = _FUNCTION_TOLERANCE
    config = pycolmap.BundleAdjustmentConfig()
    images = sorted(reconstruction.reg_image_ids())
    for image in images:
        config.add_image(image)
        if not includes_poses:
            config.set_constant_rig_from_world_pose(reconstruction.image(image).frame_id)
    if includes_poses and fixes_gauge:
        config.fix_gauge(pycolmap.BundleAdjustmentGauge.TWO_CAMS_FROM_WORLD)
    numbers = sorted({reconstruction.image(i).camera_id for i in images})
    free_camera_ids = [n for n in numbers if freedoms.get(n, ALL_FIXED) != ALL_FIXED]
    for number in numbers:
        if number not in free_camera_ids:
            config.set_constant_cam_intrinsics(number)
    adjuster = pycolmap.create_default_ceres_bundle_adjuster(options, config, reconstruction)
    for number in free_camera_ids:
        fix_parameters(adjuster.problem, reconstruction.camera(number), freedoms[number])
    return adjuster


def estimate_covariances(
    reconstruction: Any, adjuster: Any, freedoms: Mapping[int, Freedom]
) -> dict[int, FloatArray]:
    """Estimate the covariance of the free parameters of each camera, by camera number.

    The covariances are for residuals of unit variance. Cameras whose covariance cannot be estimated
    are omitted.
    """
    pycolmap = colmap()
    estimate = pycolmap.estimate_ba_covariance(
        pycolmap.BACovarianceOptions(), reconstruction, adjuster
    )
    covariances = {}
    if estimate is not None:
        for number, freedom in freedoms.items():
            if not reconstruction.exists_camera(number):
                continue
            camera = reconstruction.camera(number)
            if free_parameter_indices(camera, freedom):
                matrix = estimate.get_other_params_cov(camera.params)
                if matrix is not None:
                    covariances[number] = np.array(matrix, np.float64)
    return covariances
