"""Single rays against a model."""

from __future__ import annotations

import numpy as np
import pytest

from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.rays.raytree import RayTree

CORNER = np.array([364_520.0, 4_721_864.0, 846.0])


def rough_sheet(n: int = 40, seed: int = 1, at: np.ndarray = CORNER) -> Mesh:
    """A height field over a unit grid, seen from above."""
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(n, dtype=float), np.arange(n, dtype=float))
    points = np.column_stack([x.ravel(), y.ravel(), rng.normal(0, 0.8, n * n)]) + at
    row = np.arange(n * n).reshape(n, n)
    a, b, c, d = row[:-1, :-1], row[:-1, 1:], row[1:, 1:], row[1:, :-1]
    faces = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    return Mesh(points, faces.astype(np.int32))


def first_of_all(mesh: Mesh, start: np.ndarray, way: np.ndarray) -> tuple[int, float]:
    """Every face is asked (Moeller & Trumbore 1997)."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    p = np.cross(way, c - a)
    det = ((b - a) * p).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        u = ((start - a) * p).sum(axis=1) / det
        q = np.cross(start - a, b - a)
        v, t = (q @ way) / det, ((c - a) * q).sum(axis=1) / det
    t = np.where((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0), t, np.inf)
    return (int(t.argmin()) if np.isfinite(t.min()) else -1), float(t.min())


def test_tree_hits_match_brute_force() -> None:
    mesh = rough_sheet()
    tree = RayTree(mesh)
    rng = np.random.default_rng(2)
    starts = CORNER + rng.uniform([-10, -10, 2], [50, 50, 30], (300, 3))
    ways = CORNER + rng.uniform([0, 0, -1], [39, 39, 1], (300, 3)) - starts
    hits = tree.cast(starts, ways)
    assert (hits.index >= 0).sum() > 250
    for i in range(300):
        face, t = first_of_all(mesh, starts[i], ways[i])
        assert hits.index[i] == face
        if face >= 0:
            assert hits.distance[i] == pytest.approx(t, abs=1e-9)
            there = tree.position(face, hits.weights[i])
            assert np.abs(there - (starts[i] + t * ways[i])).max() < 1e-7


def test_ray_stops_at_its_maximum_distance() -> None:
    mesh = Mesh(np.array([[0.0, -1, -1], [0, 3, -1], [0, -1, 3]]), np.array([[0, 1, 2]], np.int32))
    tree = RayTree(mesh)
    start, way = np.array([-2.0, 0, 0]), np.array([[1.0, 0, 0]])
    assert tree.cast(start, way).distance[0] == pytest.approx(2.0)
    assert tree.cast(start, way, 1.999).index[0] == -1
    assert tree.cast(start, -way).index[0] == -1


def test_nan_vertices_and_rays_hit_nothing() -> None:
    mesh = rough_sheet(8)
    mesh.vertices[9] = np.nan
    hits = RayTree(mesh).cast(CORNER + [3.3, 4.4, 9.0], [[0, 0, -1.0], [np.nan, 0, -1]])
    assert hits.index[0] >= 0
    assert hits.index[1] == -1


def test_local_origin_is_integer_corner_below_all_valid_points() -> None:
    points = rough_sheet(8).vertices + 0.7
    wanted = np.floor(points.min(axis=0))
    for hole in (None, (9, slice(None)), (30, 1)):
        holed = points.copy()
        if hole is not None:
            holed[hole] = np.nan
        for data in (PointCloud(holed), Mesh(holed, np.array([[1, 2, 3]], np.int32))):
            assert np.array_equal(RayTree(data, 0.1).corner, wanted)
    for nothing in (np.full((3, 3), np.nan), np.zeros((0, 3))):
        nowhere = RayTree(PointCloud(nothing), 0.1)
        assert np.array_equal(nowhere.corner, np.zeros(3))
        assert nowhere.cast(np.zeros(3), [[1.0, 0, 0]]).index[0] == -1


def test_model_without_faces_is_never_hit() -> None:
    empty = Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int32))
    assert RayTree(empty).cast(np.zeros(3), [[1.0, 0, 0]]).index[0] == -1


@pytest.mark.full
def test_cloud_hit_is_the_point_nearest_to_ray_on_first_surface() -> None:
    x, y = np.meshgrid(np.arange(20) * 0.1, np.arange(20) * 0.1)
    front = np.column_stack([x.ravel(), y.ravel(), np.full(400, 1.0)])
    back = front - [0, 0, 1.0]
    tree = RayTree(PointCloud(np.concatenate([back, front]) + CORNER), max_distance=0.08)
    hits = tree.cast(CORNER + [0.52, 0.71, 5.0], [[0.0, 0.0, -2.0]])
    expected = 400 + np.hypot(x.ravel() - 0.52, y.ravel() - 0.71).argmin()
    assert hits.index[0] == expected
    assert hits.distance[0] == pytest.approx(2.0, abs=1e-9)
    assert np.isnan(hits.weights[0]).all()


def test_ray_without_direction_hits_nothing() -> None:
    mesh = rough_sheet(8)
    cloud = PointCloud(mesh.vertices)
    for tree in (RayTree(mesh), RayTree(cloud, max_distance=0.5)):
        hits = tree.cast(mesh.vertices[20], [[0.0, 0, 0], [0, 0, np.inf]])
        assert hits.index.tolist() == [-1, -1]


def nearest_of_all(
    points: np.ndarray, start: np.ndarray, way: np.ndarray, reach: float, last: float
) -> tuple[int, float]:
    """By the definition: the first point within reach of the ray, and of those at most so far
    behind it the one nearest to the ray."""
    from vomstudio.geometry.rays.raytree import SURFACE_THICKNESS

    length = np.linalg.norm(way)
    off = points - start
    t = off @ way / length**2
    away = np.linalg.norm(off - t[:, None] * way, axis=1)
    seen = (t > 0) & (t <= last) & (away <= reach)
    if not seen.any():
        return -1, np.inf
    limit = min(t[seen].min() + SURFACE_THICKNESS * reach / length, last)
    there = np.flatnonzero(seen & (t <= limit))
    best = int(there[away[there].argmin()])
    return best, float(t[best])


def test_cloud_hits_match_brute_force() -> None:
    rng = np.random.default_rng(4)
    points = rng.uniform([0, 0, 0], [10, 10, 6], (4000, 3)) + CORNER
    reach = 0.2
    tree = RayTree(PointCloud(points), max_distance=reach)
    starts = rng.uniform([-2, -2, 7], [12, 12, 12], (200, 3)) + CORNER
    ways = (rng.uniform([0, 0, 0], [10, 10, 6], (200, 3)) + CORNER - starts) * rng.uniform(
        0.2, 3.0, (200, 1)
    )
    last = rng.uniform(0.2, 9.0, 200)
    hits = tree.cast(starts, ways, last)
    met = 0
    for i in range(200):
        index, t = nearest_of_all(points, starts[i], ways[i], reach, last[i])
        assert hits.index[i] == index
        if index >= 0:
            met += 1
            assert hits.distance[i] == pytest.approx(t, abs=1e-9)
            there = tree.position(index, hits.weights[i])
            assert np.array_equal(there, points[index])
    assert 60 < met < 195


def test_hit_normals_match_the_model() -> None:
    mesh = rough_sheet(8)
    tree = RayTree(mesh)
    a, b, c = mesh.vertices[mesh.faces[11]]
    normal = np.cross(b - a, c - a)
    assert tree.normal(11) == pytest.approx(normal / np.linalg.norm(normal), abs=1e-9)
    flat = Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]], np.int32))
    assert RayTree(flat).normal(0) is None
    points = np.random.default_rng(0).normal(size=(20, 3))
    normals = np.tile(np.float32([0, 3, 4]), (20, 1))
    normals[3] = 0.0
    normals[4] = np.nan
    cloud = RayTree(PointCloud(points, normals=normals))
    assert cloud.normal(2) == pytest.approx([0, 0.6, 0.8])
    assert cloud.normal(3) is cloud.normal(4) is None
    assert RayTree(PointCloud(points)).normal(2) is None


def test_tree_boxes_contain_their_children() -> None:
    from vomstudio.geometry.rays.raytree import _build_boxes

    rng = np.random.default_rng(5)
    for n in (1, 3, 40, 333):
        low = rng.normal(size=(n, 3))
        high = low + rng.random((n, 3))
        lows, highs = _build_boxes(low, high)
        k = (len(lows) + 1) // 2
        assert k & (k - 1) == 0
        assert np.array_equal(lows[0], low.min(axis=0))
        assert np.array_equal(highs[0], high.max(axis=0))
        for node in range(k - 1):
            both = [2 * node + 1, 2 * node + 2]
            assert np.array_equal(lows[node], lows[both].min(axis=0))
            assert np.array_equal(highs[node], highs[both].max(axis=0))


def test_morton_codes_interleave_bits_and_order_points() -> None:
    from vomstudio.geometry.rays.raytree import _morton_order, _spread_bits

    rng = np.random.default_rng(6)
    numbers = np.append(rng.integers(0, 1 << 20, 200), [0, 1, (1 << 20) - 1])
    for number, found in zip(numbers, _spread_bits(numbers.astype(np.uint64)), strict=True):
        assert int(found) == sum(((int(number) >> bit) & 1) << (3 * bit) for bit in range(20))
    # The eight corners of a cube, the first axis changing quickest.
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
    mixed = rng.permutation(8)
    places = np.vstack([corners[mixed], [[np.nan, 0, 0]]]) + CORNER
    assert _morton_order(places).tolist() == np.argsort(mixed).tolist()
    assert _morton_order(np.full((2, 3), np.nan)).tolist() == []


@pytest.mark.parametrize("size", [(9.0, 2.0, 1.0), (1.0, 5.0, 0.0), (0.0, 0.0, 3.0), (0, 0, 0)])
def test_morton_order_interleaves_axes_for_any_box_shape(
    size: tuple[float, float, float],
) -> None:
    from vomstudio.geometry.rays.raytree import _morton_order

    places = np.random.default_rng(7).uniform(0.0, 1.0, (300, 3)) * size + CORNER
    longest = float(np.ptp(places, axis=0).max()) or 1.0
    cells = (places - places.min(axis=0)) / longest * ((1 << 20) - 1)
    codes = [
        [int(cell) >> bit & 1 for bit in range(19, -1, -1) for cell in place[::-1]]
        for place in cells
    ]
    assert _morton_order(places).tolist() == sorted(range(300), key=codes.__getitem__)


def around(middle: np.ndarray, size: float, count: int, seed: int) -> tuple[np.ndarray, ...]:
    """Rays from all sides and from within, of any length; every third along an axis."""
    rng = np.random.default_rng(seed)
    starts = middle + size * rng.uniform(-1.0, 1.0, (count, 3))
    ways = middle + 0.4 * size * rng.uniform(-1.0, 1.0, (count, 3)) - starts
    straight = np.eye(3)[rng.integers(0, 3, count)] * rng.choice([-1.0, 1.0], (count, 1))
    ways[::3] = straight[::3]
    ways *= 10.0 ** rng.uniform(-2.0, 1.0, (count, 1)) / np.linalg.norm(ways, axis=1)[:, None]
    last = np.where(np.arange(count) % 4, np.inf, size / np.linalg.norm(ways, axis=1))
    return starts, ways, last


@pytest.mark.parametrize("faces", [1, 4, 5, 9, 120])
def test_rays_from_all_sides_match_brute_force_on_faces(faces: int) -> None:
    rng = np.random.default_rng(faces)
    size = 0.2 + 1.5 / faces
    corners = rng.uniform(-0.6, 0.6, (faces, 1, 3)) + size * rng.normal(size=(faces, 3, 3))
    points = corners.reshape(-1, 3) + CORNER
    mesh = Mesh(points, rng.permutation(3 * faces).astype(np.int32).reshape(-1, 3))
    starts, ways, last = around(points.mean(axis=0), 3.0, 300, faces)
    tree = RayTree(mesh)
    hits = tree.cast(starts, ways, last)
    assert (hits.index >= 0).sum() >= 5
    for i in range(300):
        face, t = first_of_all(mesh, starts[i], ways[i])
        face, t = (face, t) if t < last[i] else (-1, np.inf)
        assert hits.index[i] == face
        assert hits.distance[i] == pytest.approx(t, rel=1e-6)
        assert np.isnan(hits.weights[i]).all() == (face < 0)
        if face >= 0:
            there = starts[i] + t * ways[i]
            assert hits.weights[i].sum() == pytest.approx(1.0)
            assert tree.position(face, hits.weights[i]) == pytest.approx(there, abs=1e-6)


@pytest.mark.parametrize("count", [1, 4, 5, 200])
def test_rays_from_all_sides_match_brute_force_on_points(count: int) -> None:
    points = np.random.default_rng(count).uniform(-1.0, 1.0, (count, 3)) + CORNER
    reach = 0.4
    tree = RayTree(PointCloud(points), max_distance=reach)
    starts, ways, last = around(CORNER, 3.0, 300, count)
    hits = tree.cast(starts, ways, last)
    for i in range(300):
        index, t = nearest_of_all(points, starts[i], ways[i], reach, last[i])
        assert hits.index[i] == index
        assert hits.distance[i] == pytest.approx(t, rel=1e-6)


def test_face_edge_on_or_behind_the_ray_is_not_hit() -> None:
    mesh = Mesh(np.array([[0.0, -1, -1], [0, 3, -1], [0, -1, 3]]), np.array([[0, 1, 2]], np.int32))
    tree = RayTree(mesh)
    assert tree.cast([0.0, -5, 0], [[0.0, 1, 0]]).index[0] == -1
    assert tree.cast([0.0, 0.2, 0.3], [[1.0, 0, 0]]).index[0] == -1
    for corner in mesh.vertices:
        # Through a corner or an edge it is met.
        assert tree.cast(corner + [2, 0, 0], [[-1.0, 0, 0]]).index[0] == 0
        assert tree.cast((corner + mesh.vertices[0]) / 2 + [2, 0, 0], [[-1.0, 0, 0]]).index[0] == 0


@pytest.mark.parametrize("first", range(3))
@pytest.mark.parametrize("second", range(3))
def test_no_ray_passes_through_a_shared_edge(first: int, second: int) -> None:
    a, b = np.array([0.1, 0.7, 3.0]), np.array([7.3, 5.9, 4.0])
    points = np.array([a, b, [0.3, 6.1, 1.0], [7.7, 0.2, 2.0]])
    faces = np.array([np.roll([0, 1, 2], first), np.roll([1, 0, 3], second)], np.int32)
    tree = RayTree(Mesh(points, faces))
    there = a + np.linspace(0.01, 0.99, 99)[:, None] * (b - a)
    starts = there + np.random.default_rng(3).uniform([-1, -1, 5], [1, 1, 9], (99, 3))
    hits = tree.cast(starts, there - starts)
    assert (hits.index >= 0).all()
    assert hits.distance == pytest.approx(np.ones(99))


def test_hit_position_is_on_the_face_or_is_the_point_itself() -> None:
    mesh = rough_sheet(6)
    tree = RayTree(mesh)
    weights = np.array([0.2, 0.3, 0.5])
    there = tree.position(7, weights)
    assert there == pytest.approx(weights @ mesh.vertices[mesh.faces[7]], abs=1e-9)
    cloud = RayTree(PointCloud(mesh.vertices), max_distance=0.1)
    assert np.array_equal(cloud.position(7, np.full(3, np.nan)), mesh.vertices[7])


def test_point_is_hit_within_max_distance_and_ahead_of_the_ray() -> None:
    points = np.array([[2.0, 0.5, 0.0], [-2.0, 0.0, 0.0], [0.0, 0.25, 0.0]]) + CORNER
    way = np.array([[4.0, 0.0, 0.0]])
    for reach, index in ((0.5, 0), (np.nextafter(0.5, 0.0), -1)):
        hits = RayTree(PointCloud(points), reach).cast(CORNER, way)
        assert hits.index[0] == index
    assert RayTree(PointCloud(points), 0.5).cast(CORNER, way).distance[0] == 0.5
    assert RayTree(PointCloud(points), 0.5).cast(CORNER, -way).index[0] == 1
    # One as far behind the first as a surface is thick belongs to it, and one farther does not.
    for behind, index in ((2.0, 1), (2.01, 0)):
        pair = CORNER + [[2.0, 0.5, 0.0], [2.0 + behind, 0.0, 0.0]]
        assert RayTree(PointCloud(pair), 0.5).cast(CORNER, way).index[0] == index
