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


def test_grid_rays_match_embree() -> None:
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


def test_quarter_rays_match_grid_of_half_step() -> None:
    points, faces = heap(8)
    everything = np.arange(len(faces), dtype=np.int32)
    wanted = np.random.default_rng(1).uniform(size=(50, 60)) < 0.3
    quarters = cast_quarters(points, faces, everything, wanted, left=-3.0, top=-3.0, step=0.1)
    fine = cast_grid(
        points, faces, everything, left=-3.0, top=-3.0, step=0.05, width=120, height=100
    )
    blocks = fine.face.reshape(50, 2, 60, 2).transpose(0, 2, 1, 3).reshape(50, 60, 4)
    assert (quarters.face == blocks[wanted]).all()
    assert (quarters.face >= 0).mean() > 0.5
    depth = fine.depth.reshape(50, 2, 60, 2).transpose(0, 2, 1, 3).reshape(50, 60, 4)
    assert quarters.depth == pytest.approx(depth[wanted], abs=1e-9)
    weights = fine.weights.reshape(50, 2, 60, 2, 2).transpose(0, 2, 1, 3, 4)
    assert quarters.weights == pytest.approx(weights.reshape(50, 60, 4, 2)[wanted], abs=1e-6)


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


def first_of_all(points: np.ndarray, faces: np.ndarray, x: float, y: float) -> tuple[int, float]:
    """The lowest of the triangles (in k, from 0 on) that a point lies in, by the signs of areas."""
    found = -1, np.inf
    for k, (a, b, c) in enumerate(points[faces]):
        whole = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        u = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / whole
        v = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / whole
        z = float(a[2] + u * (b[2] - a[2]) + v * (c[2] - a[2]))
        if min(u, v, 1.0 - u - v) >= 0.0 and z < found[1]:
            found = k, z
    return found


@pytest.mark.parametrize("step", [0.09, 0.4, 3.0])
@pytest.mark.parametrize(("left", "top"), [(-2.0, -1.0), (1.3, 2.2), (40.0, -1.0), (-9.0, -9.0)])
def test_grids_beside_inside_and_around_the_model_match_brute_force(
    step: float, left: float, top: float
) -> None:
    """A triangle cut by an edge of the picture is drawn up to its last pixel there."""
    points, faces = heap(9, 40)
    everything = np.arange(len(faces), dtype=np.int32)
    place = {"left": left, "top": top, "step": step}
    grid = cast_grid(points, faces, everything, **place, width=9, height=7)
    quarters = cast_quarters(points, faces, everything, np.ones((7, 9), bool), **place)
    for j in range(7):
        for i in range(9):
            face, depth = first_of_all(
                points, faces, left + (i + 0.5) * step, top + (j + 0.5) * step
            )
            assert (grid.face[j, i], grid.depth[j, i]) == (face, pytest.approx(depth))
            for q in range(4):
                x = left + (i + 0.25 + 0.5 * (q % 2)) * step
                y = top + (j + 0.25 + 0.5 * (q // 2)) * step
                face, depth = first_of_all(points, faces, x, y)
                row = j * 9 + i
                assert (quarters.face[row, q], quarters.depth[row, q]) == (
                    face,
                    pytest.approx(depth),
                )


def test_only_requested_faces_are_hit_and_edge_on_faces_never() -> None:
    points = np.array([[0, 0, 5], [4, 0, 5], [0, 4, 5], [0, 0, 2], [4, 0, 2], [0, 4, 2.0]])
    points = np.concatenate([points, [[0, 1, 0], [4, 1, 0], [2, 1, 9.0]]])
    faces = np.arange(9, dtype=np.int32).reshape(3, 3)
    for asked, wanted in (([0, 1, 2], 1), ([0, 2], 0), ([2], -1), ([1, 0], 1)):
        chosen = np.array(asked, np.int32)
        grid = cast_grid(points, faces, chosen, left=0.0, top=0.0, step=2.0, width=1, height=1)
        assert grid.face[0, 0] == wanted
        every = np.ones((1, 1), bool)
        four = cast_quarters(points, faces, chosen, every, left=0.0, top=0.0, step=2.0)
        assert (four.face == wanted).all()


@pytest.mark.parametrize("first", range(3))
@pytest.mark.parametrize("second", range(3))
@pytest.mark.parametrize("flip", [False, True])
def test_adjacent_triangles_leave_no_gap_for_any_corner_order(
    first: int, second: int, flip: bool
) -> None:
    """Rays through the edge that they share, at a slant where every product is rounded."""
    a, b = np.array([0.1, 0.7, 3.0]), np.array([7.3, 5.9, 4.0])
    points = np.array([a, b, [0.3, 6.1, 1.0], [7.7, 0.2, 2.0]])
    one, other = np.roll([0, 1, 2], first), np.roll([1, 0, 3], second)
    faces = np.array([one, other[::-1] if flip else other], np.int32)
    both = np.arange(2, dtype=np.int32)
    for t in np.linspace(0.01, 0.99, 99):
        x, y, z = a + t * (b - a)
        place = {"left": x - 0.5, "top": y - 0.5, "step": 1.0}
        hits = cast_grid(points, faces, both, **place, width=1, height=1)
        assert hits.face[0, 0] >= 0
        assert hits.depth[0, 0] == pytest.approx(z)
        place = {"left": x - 0.25, "top": y - 0.25, "step": 1.0}
        hits = cast_quarters(points, faces, both, np.ones((1, 1), bool), **place)
        assert hits.face[0, 0] >= 0
        assert hits.depth[0, 0] == pytest.approx(z)
