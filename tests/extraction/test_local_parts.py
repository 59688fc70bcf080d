"""The piece of a model that is looked at."""

from __future__ import annotations

import numpy as np

from tests.extraction.planes_by_construction import grid_mesh
from vomstudio.extraction.local_parts import extract_visible_part
from vomstudio.geometry.cloud import PointCloud


def walls() -> PointCloud:
    """Two walls, one 10 m behind the other, seen from the south."""
    x, z = np.meshgrid(np.arange(0.0, 10.0, 0.1), np.arange(0.0, 5.0, 0.1))
    near = np.stack([x.ravel(), np.zeros(x.size), z.ravel()], axis=1)
    return PointCloud(np.concatenate([near, near + [0.0, 10.0, 0.0]]))


def test_nearest_surface_on_the_ray_is_selected() -> None:
    cloud = walls()
    for toward in ((7.0, 10.0, 2.0), (7.0, 0.0, 2.0), (7.0, -3.0, 2.0)):
        part = extract_visible_part(cloud, (7.0, -20.0, 2.0), toward, 300)
        assert len(part.points) == 300
        own = cloud.points[part.points]
        assert np.array_equal(part.data.points, own)
        assert (own[:, 1] == 0.0).all()
        assert np.linalg.norm(own - [7.0, 0.0, 2.0], axis=1).max() < 1.2


def test_ray_without_hit_selects_points_nearest_its_end() -> None:
    part = extract_visible_part(walls(), (50.0, -20.0, 2.0), (50.0, 0.0, 2.0), 50)
    assert (walls().points[part.points][:, 0] > 8.0).all()


def test_part_of_mesh_keeps_its_faces_and_their_indices() -> None:
    mesh = grid_mesh(np.zeros((50, 50)), 0.1)
    part = extract_visible_part(mesh, (2.0, 2.0, 10.0), (2.0, 2.0, 0.0), 400)
    assert 0 < len(part.faces) < len(mesh.faces)
    assert np.array_equal(
        part.data.vertices[part.data.faces], mesh.vertices[mesh.faces[part.faces]]
    )


def test_small_model_is_used_whole() -> None:
    cloud = walls()
    part = extract_visible_part(cloud, (0.0, -5.0, 0.0), (0.0, 0.0, 0.0), 10**6)
    assert len(part.points) == len(cloud.points)
