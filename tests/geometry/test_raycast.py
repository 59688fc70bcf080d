"""Rays against surfaces whose height is known in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from vomstudio.geometry.rays.raycast import cast_grid, cast_quarters

UTM = np.array([576_700.0, 5_188_150.0, 160.0])


def folded_sheet(n: int = 60) -> tuple[np.ndarray, np.ndarray]:
    """Corners (m, 3, 3) of a 30 x 30 m sheet at UTM coordinates, folded along x: z = |x| / 2."""
    g = np.linspace(-15, 15, n + 1)
    x, y = np.meshgrid(g, g)
    v = np.stack([x, y, np.abs(x) / 2], -1).reshape(-1, 3) + UTM
    i = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    a, b, c, d = (k.ravel() for k in (i[:-1, :-1], i[:-1, 1:], i[1:, :-1], i[1:, 1:]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)])
    return v[faces], faces


def heap(seed: int = 7, m: int = 400) -> tuple[np.ndarray, np.ndarray]:
    """Triangles of all sizes and attitudes, one behind the other."""
    rng = np.random.default_rng(seed)
    size = 10 ** rng.uniform(-1.5, 0.7, (m, 1, 1))
    points = rng.uniform(-3, 3, (m, 1, 3)) + size * rng.normal(size=(m, 3, 3))
    return points.reshape(-1, 3), np.arange(3 * m, dtype=np.int32).reshape(m, 3)


def test_rays_through_a_grid_meet_what_embree_meets() -> None:
    points, faces = heap()
    everything = np.arange(len(faces), dtype=np.int32)
    place = {"left": -4.0, "top": -3.5, "step": 0.031}
    grid = cast_grid(points, faces, everything, **place, width=240, height=220)
    x = -4.0 + (np.arange(240) + 0.5) * 0.031
    y = -3.5 + (np.arange(220) + 0.5) * 0.031
    starts = np.stack([*(k.ravel() for k in np.meshgrid(x, y)), np.full(240 * 220, -99.0)], 1)
    scene = EmbreeScene(robust=True)
    TriangleMesh(scene, points[faces].astype(np.float32))
    along = np.tile(np.array([[0, 0, 1]], np.float32), (len(starts), 1))
    hits = scene.run(starts.astype(np.float32), along, query="INTERSECT", output=True)
    same = grid.face.ravel() == hits["primID"].astype(np.int32)
    assert same.mean() > 0.9995  # float32 decides otherwise at an edge now and then
    both = same & (grid.face.ravel() >= 0)
    assert both.mean() > 0.5
    assert np.abs(grid.depth.ravel() - (hits["tfar"] - 99.0))[both].max() < 1e-4
    u, v = grid.weights.reshape(-1, 2)[both].T
    assert np.abs(u - hits["u"][both]).max() < 1e-3
    assert np.abs(v - hits["v"][both]).max() < 1e-3


def test_quarters_are_the_grid_of_half_the_step() -> None:
    points, faces = heap(8)
    everything = np.arange(len(faces), dtype=np.int32)
    wanted = np.random.default_rng(1).uniform(size=(50, 60)) < 0.3
    quarters = cast_quarters(points, faces, everything, wanted, left=-3.0, top=-3.0, step=0.1)
    fine = cast_grid(
        points, faces, everything, left=-3.0, top=-3.0, step=0.05, width=120, height=100
    )
    blocks = fine.face.reshape(50, 2, 60, 2).transpose(0, 2, 1, 3).reshape(50, 60, 4)
    assert (quarters.face == blocks[wanted]).all()


def test_no_grid_ray_slips_through_the_seams() -> None:
    corners, _ = folded_sheet(30)
    points = np.ascontiguousarray((corners.reshape(-1, 3) - UTM) * (1, 1, -1))
    flat = np.arange(len(points), dtype=np.int32).reshape(-1, 3)
    everything = np.arange(len(flat), dtype=np.int32)
    # Through vertices and along edges.
    hits = cast_grid(
        points, flat, everything, left=-14.75, top=-14.75, step=0.5, width=59, height=59
    )
    assert (hits.face >= 0).all()
    assert hits.depth == pytest.approx(
        np.broadcast_to(-np.abs(np.linspace(-14.5, 14.5, 59)) / 2, (59, 59))
    )
