"""The last bundle adjustment, in which every camera has its own freedom, and what it is worth."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.photogrammetry.engine import cancellable, colmap
from vomstudio.photogrammetry.priors import HELD, Freedom
from vomstudio.progress import Progress, Silent

# Observations farther off are no observations of that point (as in COLMAP's mapper).
MAX_ERROR_PX = 4.0
MIN_ANGLE_DEG = 1.5


def adjust(
    reconstruction: Any,
    freedoms: Mapping[int, Freedom],
    *,
    threads: int = -1,
    rounds: int = 2,
    covariance: bool = True,
    progress: Progress | None = None,
) -> dict[int, npt.NDArray[np.float64]]:
    """Refine poses, points and what `freedoms` (by camera) leaves free, in place; then drop bad
    observations, and again.

    Returns the formal covariance (k, k) of the k free parameters of each camera, for residuals of
    unit variance; cameras are missing where it could not be had. Raises Cancelled.
    """
    pycolmap = colmap()
    found: dict[int, npt.NDArray[np.float64]] = {}
    for left in range(rounds, 0, -1):
        for group in _groups(freedoms):
            adjuster = _adjuster(reconstruction, group, threads)
            cancellable(lambda _token, a=adjuster: a.solve(), progress or Silent())  # type: ignore[misc]
            if covariance and left == 1:
                found |= _covariances(reconstruction, adjuster, group)
        manager = pycolmap.ObservationManager(reconstruction)
        manager.filter_all_points3D(MAX_ERROR_PX, MIN_ANGLE_DEG)
    return found


def _groups(freedoms: Mapping[int, Freedom]) -> list[dict[int, Freedom]]:
    """COLMAP frees the focal lengths, or the distortion, of all cameras or of none; where cameras
    differ, they take turns, the others held meanwhile."""
    groups: dict[Freedom, dict[int, Freedom]] = {}
    for number in sorted(freedoms):
        if freedoms[number] != HELD:
            groups.setdefault(freedoms[number], {})[number] = freedoms[number]
    return list(groups.values()) or [{}]


def free_parameters(camera: Any, freedom: Freedom) -> list[int]:
    """Places of a camera's free parameters."""
    free = list(camera.focal_length_idxs()) if freedom.focal else []
    return sorted(free + (list(camera.extra_params_idxs()) if freedom.distortion else []))


def _adjuster(reconstruction: Any, freedoms: Mapping[int, Freedom], threads: int) -> Any:
    """Of cameras with the same freedom of the focal length; all others are held."""
    pycolmap = colmap()
    options = pycolmap.BundleAdjustmentOptions()
    options.print_summary = False
    options.refine_focal_length = any(f.focal for f in freedoms.values())
    options.refine_extra_params = any(f.distortion for f in freedoms.values())
    options.ceres.solver_options.num_threads = threads
    config = pycolmap.BundleAdjustmentConfig()
    images = sorted(reconstruction.reg_image_ids())
    for image in images:
        config.add_image(image)
    config.fix_gauge(pycolmap.BundleAdjustmentGauge.TWO_CAMS_FROM_WORLD)
    for number in sorted({reconstruction.image(i).camera_id for i in images}):
        if number not in freedoms:
            config.set_constant_cam_intrinsics(number)
    return pycolmap.create_default_ceres_bundle_adjuster(options, config, reconstruction)


def _covariances(
    reconstruction: Any, adjuster: Any, freedoms: Mapping[int, Freedom]
) -> dict[int, npt.NDArray[np.float64]]:
    pycolmap = colmap()
    estimate = pycolmap.estimate_ba_covariance(
        pycolmap.BACovarianceOptions(), reconstruction, adjuster
    )
    found = {}
    if estimate is not None:
        for number, freedom in freedoms.items():
            camera = reconstruction.camera(number)
            if free_parameters(camera, freedom):
                matrix = estimate.get_other_params_cov(camera.params)
                if matrix is not None:
                    found[number] = np.array(matrix, np.float64)
    return found
