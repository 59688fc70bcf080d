"""4x4 similarities, points at one place, and boxes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from vomstudio.geometry import transform
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.coincident_points import position_keys, weld_points
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.plane_discs import disc
from vomstudio.geometry.progressive_order import arrange

TURN = Rotation.from_euler("xyz", [20, -50, 130], degrees=True)
SHIFT = np.array([500_000.0, 4_600_000.0, 800.0])


def similarity(scale: float = 2.5) -> np.ndarray:
    rows = np.eye(4)
    rows[:3, :3] = scale * TURN.as_matrix()
    rows[:3, 3] = SHIFT
    return rows


def test_similarity_transforms_points_and_inverts() -> None:
    points = np.random.default_rng(0).normal(size=(7, 3))
    rows = similarity()
    there = transform.apply(rows, points)
    assert there == pytest.approx(2.5 * TURN.apply(points) + SHIFT)
    assert transform.apply(transform.invert(rows), there) == pytest.approx(points, abs=1e-8)
    assert transform.apply(rows.tolist(), points[0])[0] == pytest.approx(there[0])
    assert transform.matrix(rows.tolist()).dtype == np.float64


@pytest.mark.parametrize("scale", [0.001, 1.0, 2.5, 304.8])
def test_directions_turn_and_keep_their_length(scale: float) -> None:
    vectors = np.random.default_rng(1).normal(size=(5, 3))
    assert transform.scale_factor(similarity(scale)) == pytest.approx(scale)
    assert transform.rotate(similarity(scale), vectors) == pytest.approx(TURN.apply(vectors))


def test_a_mirror_has_a_positive_scale() -> None:
    assert transform.scale_factor(np.diag([-2.0, 2.0, 2.0, 1.0])) == pytest.approx(2.0)


def test_coincident_points_share_one_index() -> None:
    rng = np.random.default_rng(2)
    grid = rng.integers(-3, 4, (2000, 3)) * 0.1 + SHIFT
    number = weld_points(grid)
    _, theirs = np.unique(grid, axis=0, return_inverse=True)
    assert sorted(set(number.tolist())) == list(range(number.max() + 1))
    pairs = set(zip(number.tolist(), theirs.ravel().tolist(), strict=True))
    assert len(pairs) == number.max() + 1 == theirs.max() + 1


def test_position_keys_treat_negative_zero_as_zero_and_depend_on_axis_order() -> None:
    zero, minus = position_keys(np.array([[0.0, 1.0, 2.0], [-0.0, 1.0, 2.0]]))
    assert zero == minus
    orders = np.array([[1, 2, 3], [1, 3, 2], [2, 1, 3], [2, 3, 1], [3, 1, 2], [3, 2, 1]], float)
    assert len(set(position_keys(orders).tolist())) == 6
    rows = np.random.default_rng(3).normal(size=(100_000, 3))
    assert len(np.unique(position_keys(rows))) == 100_000
    # Small whole numbers differ in a few bits only.
    whole = np.stack(np.meshgrid(*[np.arange(40.0)] * 3), axis=-1).reshape(-1, 3)
    assert len(np.unique(position_keys(whole))) == 64_000


def test_model_bounds_are_those_of_its_points() -> None:
    points = np.random.default_rng(4).normal(size=(50, 3)) * [3, 1, 9] + SHIFT
    wanted = [points.min(axis=0), points.max(axis=0)]
    assert np.array_equal(Mesh(points, np.zeros((0, 3), np.int32)).bounds, wanted)
    cloud = PointCloud(points)
    assert np.array_equal(cloud.bounds, wanted)
    assert cloud.count == 50
    assert np.array_equal(cloud.position(7), points[7])


def test_bounds_of_arranged_cloud_ignore_invalid_points() -> None:
    points = np.random.default_rng(5).normal(size=(500, 3)) * [3, 1, 9] + SHIFT
    points[7], points[99, 1] = np.nan, np.inf
    sound = np.delete(points, [7, 99], axis=0)
    cloud = PointCloud(points, arrangement=arrange(points))
    assert np.array_equal(cloud.bounds, [sound.min(axis=0), sound.max(axis=0)])
    assert cloud.count == 500
    # An order of nothing says nothing of it.
    cloud = PointCloud(sound, arrangement=arrange(points[:0]))
    assert np.array_equal(cloud.bounds, [sound.min(axis=0), sound.max(axis=0)])


def test_mesh_without_materials_has_no_material_faces() -> None:
    bare = Mesh(np.eye(3), np.array([[0, 1, 2]], np.int32))
    assert bare.materials == ()
    assert bare.material_offsets.tolist() == [0]
    assert bare.uv is bare.colors is None
    assert dict(bare.fields) == {}


@pytest.mark.parametrize("normal", [(0, 0, 1), (1, 0, 0), (0, -1, 0), (0.48, 0.6, 0.64)])
def test_disc_is_round_flat_and_counterclockwise(normal: tuple[float, ...]) -> None:
    ring = disc(SHIFT, normal, 3.0, 36) - SHIFT
    assert ring.shape == (36, 3)
    assert disc(SHIFT, normal, 3.0).shape == (48, 3)
    assert np.linalg.norm(ring, axis=1) == pytest.approx(np.full(36, 3.0))
    assert ring @ np.asarray(normal) == pytest.approx(np.zeros(36), abs=1e-8)
    steps = np.linalg.norm(ring - np.roll(ring, 1, axis=0), axis=1)
    assert steps == pytest.approx(np.full(36, 6.0 * np.sin(np.pi / 36)))
    # Anticlockwise as seen from the tip of the normal.
    turns = np.cross(ring, np.roll(ring, -1, axis=0)) @ np.asarray(normal)
    assert (turns > 0.0).all()
