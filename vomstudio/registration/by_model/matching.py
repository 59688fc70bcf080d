"""Coarse-to-fine matching of a model to a nearby reference by ICP (Open3D).

The method is point-to-plane ICP (Chen & Medioni 1992, Image and Vision Computing 10, 145) with
Tukey's biweight. Each step halves the maximum distance of correspondences and the cell size of the
thinned points.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.progress import Progress
from vomstudio.core.words import tr
from vomstudio.registration.similarity import Similarity

_CELLS_PER_DISTANCE = 4.0
"""Cells per correspondence distance; smaller cells add no information."""
_N_NEIGHBOURS = 20
_MIN_POINTS = 12
_MAX_ITERATIONS = 40
_MAX_STEPS = 8


def match(
    model: FloatArray,
    reference: FloatArray,
    start: Similarity,
    *,
    max_distance: float,
    min_distance: float,
    progress: Progress,
) -> Similarity:
    """Rotate and translate a model to match a reference.

    Parameters
    ----------
    model : (n, 3) array
        Points in the model frame.
    reference : (m, 3) array
        Points in the World frame, metres.
    start : Similarity
    max_distance, min_distance : float
        Maximum distance of correspondences in the first and in the last step, metres.
    progress : Progress
        Progress indicator, which may raise Cancelled.
    """
    from scipy.spatial.transform import Rotation

    placed_points = start(model)
    origin = np.round(reference.mean(axis=0))
    # No step needs more detail than the last one.
    source, target = (
        _cloud(points - origin).voxel_down_sample(min_distance / _CELLS_PER_DISTANCE)
        for points in (placed_points, reference)
    )
    transform_matrix: FloatArray = np.eye(4)
    distances = [max_distance]
    while distances[-1] > min_distance and len(distances) < _MAX_STEPS:
        distances.append(max(distances[-1] / 2.0, min_distance))
    progress.stage(tr("Matching surfaces, coarse to fine"), len(distances))
    for level, distance in enumerate(distances):
        transform_matrix = _step(source, target, transform_matrix, distance)
        progress.step(level + 1)
    rotation = Rotation.from_matrix(transform_matrix[:3, :3]).as_matrix()
    shift = transform_matrix[:3, 3] + origin - rotation @ origin
    return Similarity(start.scale, rotation @ start.rotation, rotation @ start.translation + shift)


def _cloud(points: FloatArray) -> Any:
    import open3d

    # The Open3D stubs lack overloads.
    o3d: Any = open3d
    return o3d.t.geometry.PointCloud(o3d.core.Tensor(np.ascontiguousarray(points)))


def _step(source: Any, target: Any, transform_matrix: FloatArray, distance: float) -> FloatArray:
    import open3d

    o3d: Any = open3d
    icp = o3d.t.pipelines.registration
    cell = distance / _CELLS_PER_DISTANCE
    thinned_source, thinned_target = source.voxel_down_sample(cell), target.voxel_down_sample(cell)
    if min(len(thinned_source.point.positions), len(thinned_target.point.positions)) < _MIN_POINTS:
        return transform_matrix
    thinned_target.estimate_normals(max_nn=_N_NEIGHBOURS)
    kernel = icp.robust_kernel.RobustKernel(
        icp.robust_kernel.RobustKernelMethod.TukeyLoss, distance / 2.0, 1.0
    )
    try:
        result = icp.icp(
            thinned_source,
            thinned_target,
            distance,
            transform_matrix,
            icp.TransformationEstimationPointToPlane(kernel),
            icp.ICPConvergenceCriteria(1e-7, 1e-7, _MAX_ITERATIONS),
        )
    except RuntimeError:  # no correspondences, or a plane along which all points slide
        return transform_matrix
    matrix = np.asarray(result.transformation.numpy(), np.float64)
    is_valid = np.isfinite(matrix).all() and abs(np.linalg.det(matrix[:3, :3]) - 1.0) < 1e-3
    return matrix if is_valid else transform_matrix
