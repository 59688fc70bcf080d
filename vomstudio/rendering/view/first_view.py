"""Initial view of a model onto its exposed side."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.geometry import transform
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.vectors import wrap360

MAX_SAMPLE = 10_000
MAX_PLUNGE_DEG = 60.0
# Below this share of the total face area, the sides cancel out and no side is exposed.
MIN_ONE_SIDED_SHARE = 0.2


def first_view(data: Mesh | PointCloud, to_world: FloatArray) -> tuple[float, float]:
    """Return the trend and plunge, in degrees, of a view onto the exposed side of a model.

    A mesh is viewed against the sum of its face normals. A cloud, whose exposed side is unknown,
    is viewed along its thinnest direction, from above or from the south. The plunge is between 0
    and 60 degrees. If no side is exposed, the view is from the south with a plunge of 35 degrees.

    Parameters
    ----------
    data : Mesh or PointCloud
    to_world : (4, 4) float64
        Matrix from the file frame to the World frame.
    """
    outward = _mesh_side(data) if isinstance(data, Mesh) else _thinnest_direction(data.points)
    if outward is None:
        return 0.0, 35.0
    x, y, z = transform.rotate(to_world, [outward])[0]
    if not isinstance(data, Mesh) and (z < 0 if abs(z) > 0.5 else y > 0):
        x, y, z = -x, -y, -z
    plunge = float(np.degrees(np.arctan2(z, np.hypot(x, y))))
    # Level ground has no exposed side, so it is viewed from above with North upwards.
    trend = 0.0 if abs(plunge) > MAX_PLUNGE_DEG else wrap360(float(np.degrees(np.arctan2(-x, -y))))
    return trend, float(np.clip(plunge, 0.0, MAX_PLUNGE_DEG))


def _mesh_side(mesh: Mesh) -> FloatArray | None:
    step = max(1, len(mesh.faces) // MAX_SAMPLE)
    corners = mesh.vertices[mesh.faces[::step]]
    doubled_areas = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    total = doubled_areas.sum(axis=0)
    length = float(np.linalg.norm(total))
    if not length > MIN_ONE_SIDED_SHARE * float(np.linalg.norm(doubled_areas, axis=1).sum()):
        return None
    return np.asarray(total / length)


def _thinnest_direction(points: FloatArray) -> FloatArray | None:
    sample = points[:: max(1, len(points) // MAX_SAMPLE)]
    if len(sample) < 3:
        return None
    _, axes = np.linalg.eigh(np.cov((sample - sample.mean(axis=0)).T))
    return np.asarray(axes[:, 0])
