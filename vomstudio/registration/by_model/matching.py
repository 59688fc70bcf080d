"""A model brought to a reference near which it lies: ICP from coarse to fine (Open3D).

Point to plane (Chen & Medioni 1992, Image and Vision Computing 10, 145) with Tukey's biweight; each
step halves the distance within which points may belong to each other, and the size of the cells to
whose means the points are thinned.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.progress import Progress
from vomstudio.core.words import tr
from vomstudio.registration.similarity import Similarity

_CELLS = 4.0
"""In the distance of a step: cells this small show what the points of it can tell."""
_NEIGHBOURS = 20
_LEAST = 12
_ITERATIONS = 40
_STEPS = 8


def match(
    model: FloatArray,
    reference: FloatArray,
    start: Similarity,
    *,
    farthest: float,
    nearest: float,
    progress: Progress,
) -> Similarity:
    """The start, turned and shifted so that the model (n, 3) lies on the reference (m, 3), World.

    farthest, nearest : metres within which points may belong to each other at first and at last
    Raises Cancelled through `progress`.
    """
    from scipy.spatial.transform import Rotation

    moved = start(model)
    origin = np.round(reference.mean(axis=0))
    # No step looks closer than the last one.
    source, target = (
        _cloud(points - origin).voxel_down_sample(nearest / _CELLS) for points in (moved, reference)
    )
    turn: FloatArray = np.eye(4)
    distances = [farthest]
    while distances[-1] > nearest and len(distances) < _STEPS:
        distances.append(max(distances[-1] / 2.0, nearest))
    progress.stage(tr("Matching surfaces, coarse to fine"), len(distances))
    for number, distance in enumerate(distances):
        turn = _step(source, target, turn, distance)
        progress.step(number + 1)
    rotation = Rotation.from_matrix(turn[:3, :3]).as_matrix()
    shift = turn[:3, 3] + origin - rotation @ origin
    return Similarity(start.scale, rotation @ start.rotation, rotation @ start.translation + shift)


def _cloud(points: FloatArray) -> Any:
    import open3d

    # Its stubs lack overloads.
    o3d: Any = open3d
    return o3d.t.geometry.PointCloud(o3d.core.Tensor(np.ascontiguousarray(points)))


def _step(source: Any, target: Any, turn: FloatArray, distance: float) -> FloatArray:
    import open3d

    o3d: Any = open3d
    icp = o3d.t.pipelines.registration
    cell = distance / _CELLS
    thin, there = source.voxel_down_sample(cell), target.voxel_down_sample(cell)
    if min(len(thin.point.positions), len(there.point.positions)) < _LEAST:
        return turn
    there.estimate_normals(max_nn=_NEIGHBOURS)
    kernel = icp.robust_kernel.RobustKernel(
        icp.robust_kernel.RobustKernelMethod.TukeyLoss, distance / 2.0, 1.0
    )
    try:
        found = icp.icp(
            thin,
            there,
            distance,
            turn,
            icp.TransformationEstimationPointToPlane(kernel),
            icp.ICPConvergenceCriteria(1e-7, 1e-7, _ITERATIONS),
        )
    except RuntimeError:  # no pair of points, or a plane along which all slide
        return turn
    matrix = np.asarray(found.transformation.numpy(), np.float64)
    sound = np.isfinite(matrix).all() and abs(np.linalg.det(matrix[:3, :3]) - 1.0) < 1e-3
    return matrix if sound else turn
