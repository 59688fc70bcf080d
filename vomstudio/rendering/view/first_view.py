"""The first view of a model: onto its exposed side, not its edge."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.geometry import transform
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.vectors import wrap360

_SAMPLE = 10_000
_STEEPEST_DEG = 60.0
# Under this share of all face area the sides cancel out: the model has no one exposed side.
_ONE_SIDED = 0.2


def first_view(data: Mesh | PointCloud, to_world: FloatArray) -> tuple[float, float]:
    """Trend and plunge, in degrees, of a view onto the exposed side of a model.

    A mesh is faced against the sum of its face normals; a cloud, whose side is not known, across
    its thinnest direction, from above or from the south. to_world : (4, 4).
    """
    out = _mesh_side(data) if isinstance(data, Mesh) else _thin_direction(data.points)
    if out is None:
        return 0.0, 35.0
    x, y, z = transform.rotate(to_world, [out])[0]
    if not isinstance(data, Mesh) and (z < 0 if abs(z) > 0.5 else y > 0):
        x, y, z = -x, -y, -z
    plunge = float(np.degrees(np.arctan2(z, np.hypot(x, y))))
    # Flat ground has no side: North stays up.
    trend = 0.0 if abs(plunge) > _STEEPEST_DEG else wrap360(float(np.degrees(np.arctan2(-x, -y))))
    return trend, float(np.clip(plunge, 0.0, _STEEPEST_DEG))


def _mesh_side(mesh: Mesh) -> FloatArray | None:
    step = max(1, len(mesh.faces) // _SAMPLE)
    corners = mesh.vertices[mesh.faces[::step]]
    doubled = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    total = doubled.sum(axis=0)
    length = float(np.linalg.norm(total))
    if not length > _ONE_SIDED * float(np.linalg.norm(doubled, axis=1).sum()):
        return None
    return np.asarray(total / length)


def _thin_direction(points: FloatArray) -> FloatArray | None:
    sample = points[:: max(1, len(points) // _SAMPLE)]
    if len(sample) < 3:
        return None
    _, axes = np.linalg.eigh(np.cov((sample - sample.mean(axis=0)).T))
    return np.asarray(axes[:, 0])
