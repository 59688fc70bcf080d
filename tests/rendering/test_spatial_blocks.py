"""The box index against looking at everything."""

from __future__ import annotations

import threading

import numpy as np

from vomstudio.geometry.mesh import Mesh
from vomstudio.rendering.prepare import preparation
from vomstudio.rendering.view import spatial_blocks
from vomstudio.rendering.view.spatial_blocks import POINTS_PER_BLOCK, PointChunk, block_boxes


def rough_mesh(n: int = 60, seed: int = 0) -> Mesh:
    rng = np.random.default_rng(seed)
    x, y = np.meshgrid(np.linspace(0, 10, n + 1), np.linspace(0, 8, n + 1))
    z = rng.normal(0, 0.3, x.shape)
    a = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    faces = np.concatenate(
        [np.stack([a, a + 1, a + n + 2], 1), np.stack([a, a + n + 2, a + n + 1], 1)]
    )
    return Mesh(np.stack([x, y, z], -1).reshape(-1, 3), faces.astype(np.int32))


def chunks_of(mesh: Mesh) -> list[spatial_blocks.FaceChunk]:
    points = mesh.vertices.astype(np.float32)
    whole = slice(0, len(mesh.faces))
    stop = threading.Event()
    made = preparation.mesh_chunks(mesh, points, None, -1, whole, stop)
    return [event.chunk for event in made]


def test_every_face_is_in_exactly_one_chunk(monkeypatch) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.setattr(preparation, "FACES_PER_CHUNK", 1000)
    mesh = rough_mesh()
    chunks = chunks_of(mesh)
    assert len(chunks) == 8
    ids = np.concatenate([c.face_ids for c in chunks])
    np.testing.assert_array_equal(np.sort(ids), np.arange(len(mesh.faces)))
    for chunk in chunks:
        np.testing.assert_array_equal(chunk.vertex_ids[chunk.faces], mesh.faces[chunk.face_ids])


def test_the_first_face_along_a_ray_is_the_nearest_of_all(monkeypatch) -> None:  # type: ignore[no-untyped-def]
    monkeypatch.setattr(preparation, "FACES_PER_CHUNK", 1000)
    mesh = rough_mesh()
    chunks = chunks_of(mesh)
    corners = mesh.vertices.astype(np.float32).astype(np.float64)[mesh.faces]
    rng = np.random.default_rng(1)
    met = 0
    for _ in range(200):
        origin = np.array([*rng.uniform(-2, 12, 2), rng.choice([-5.0, 5.0])])
        direction = np.array([*rng.uniform(0, 8, 2), 0.0]) - origin
        direction /= np.linalg.norm(direction)
        t, _, _, ok = spatial_blocks.ray_triangles(origin, direction, *corners.transpose(1, 0, 2))
        t = np.where(ok, t, np.inf)
        expected = int(np.argmin(t)) if ok.any() else None
        found = spatial_blocks.first_face(chunks, origin, direction)
        met += found is not None
        assert (found is None) == (expected is None)
        if found is not None and expected is not None:
            assert t[found] == t[expected]
    assert met > 100


def test_ray_along_a_box_face_hits_the_box() -> None:
    low, high = np.zeros((1, 3)), np.ones((1, 3))
    ahead = np.array([0.0, 0.0, 1.0])
    assert spatial_blocks.are_boxes_hit(low, high, np.array([0.5, 1.0, -3.0]), ahead)[0]
    assert not spatial_blocks.are_boxes_hit(low, high, np.array([0.5, 1.5, -3.0]), ahead)[0]
    assert not spatial_blocks.are_boxes_hit(low, high, np.array([0.5, 0.5, 3.0]), ahead)[0]


def test_points_near_a_ray_are_all_found() -> None:
    rng = np.random.default_rng(2)
    points = rng.uniform(-5, 5, (20_000, 3)).astype(np.float32)
    order = np.argsort(spatial_blocks.morton(points, points.min(axis=0), 10.0))
    chunks = [
        PointChunk(points[ids], ids, block_boxes(points[ids], points[ids], POINTS_PER_BLOCK))
        for ids in np.array_split(order, 3)
    ]
    origin, direction = np.array([0.3, -20.0, 0.1]), np.array([0.05, 1.0, 0.02])
    direction /= np.linalg.norm(direction)
    boxes = (
        np.stack([c.blocks.low.min(axis=0) for c in chunks]),
        np.stack([c.blocks.high.max(axis=0) for c in chunks]),
    )
    rows, depth, off = spatial_blocks.points_near_ray(chunks, boxes, origin, direction, 0.1, 0.01)
    q = points - origin
    along = q @ direction
    far = np.linalg.norm(q - along[:, None] * direction, axis=1)
    expected = np.flatnonzero(far <= 0.1 + 0.01 * along)
    np.testing.assert_array_equal(np.sort(rows), expected)
    assert len(rows) > 5
    np.testing.assert_allclose(depth, along[rows], rtol=1e-6)
    assert (off <= 1.0).all()
    first, near, _ = spatial_blocks.points_near_ray(
        chunks, boxes, origin, direction, 0.1, 0.01, 2.0
    )
    assert set(first) <= set(rows)
    assert near.min() == depth.min()


def test_texture_scale_counts_image_widths_per_metre() -> None:
    corners = np.array([[[0, 0, 0], [2.0, 0, 0], [0, 2.0, 0]]], np.float32)
    uv = np.array([[[0, 0], [1.0, 0], [0, 1.0]]], np.float32)
    assert preparation.uv_per_metre(corners, uv) == 0.5
