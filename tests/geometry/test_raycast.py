"""Rays against surfaces whose height is known in closed form."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from vomstudio.errors import GeometryError
from vomstudio.geometry.raycast import RayCaster, cast_grid, cast_quarters

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


def test_distances_at_utm_are_exact_to_a_micrometre() -> None:
    corners, _ = folded_sheet()
    xy = np.random.default_rng(0).uniform(-14.9, 14.9, (5000, 2))
    starts = np.column_stack([xy, np.full(5000, 700.0)]) + UTM
    hits = RayCaster(corners).cast(starts, (0, 0, -2.0))
    assert (hits.face >= 0).all()
    assert np.abs(hits.distance - (700.0 - np.abs(xy[:, 0]) / 2)).max() < 1e-6


def test_slanting_rays_meet_the_plane_where_they_should() -> None:
    corners, _ = folded_sheet()
    rng = np.random.default_rng(1)
    # To points on the limb x > 0, from the side that it faces.
    target = np.column_stack([rng.uniform(1, 14, 500), rng.uniform(-14, 14, 500)])
    target = np.column_stack([target, target[:, 0] / 2]) + UTM
    direction = np.column_stack(
        [rng.uniform(0.3, 1, 500), rng.uniform(-0.5, 0.5, 500), -np.ones(500)]
    )
    far = rng.uniform(200, 2000, 500)
    unit = direction / np.linalg.norm(direction, axis=1, keepdims=True)
    starts = target - unit * far[:, None]
    hits = RayCaster(corners).cast(starts, direction)
    ends = starts + unit * hits.distance[:, None]
    straight = np.abs(hits.distance - far) < 1e-5
    # Some rays meet the other limb first; they end on it.
    assert straight.mean() > 0.5
    assert np.abs(ends[:, 2] - UTM[2] - np.abs(ends[:, 0] - UTM[0]) / 2).max() < 1e-6


def test_weights_rebuild_the_point() -> None:
    corners, _ = folded_sheet()
    xy = np.random.default_rng(2).uniform(-14, 14, (300, 2))
    starts = np.column_stack([xy, np.full(300, 50.0)]) + UTM
    hits = RayCaster(corners).cast(starts, (0, 0, -1.0))
    u, v = hits.weights.T
    a, b, c = (corners[hits.face, k] for k in range(3))
    found = (1 - u - v)[:, None] * a + u[:, None] * b + v[:, None] * c
    assert np.abs(found[:, :2] - starts[:, :2]).max() < 1e-6


def test_no_ray_slips_through_the_seams() -> None:
    corners, _ = folded_sheet(30)
    g = np.linspace(-14.5, 14.5, 59)  # through vertices and along edges
    x, y = np.meshgrid(g, g)
    starts = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 90.0)]) + UTM
    assert (RayCaster(corners).cast(starts, (0, 0, -1.0)).face >= 0).all()


def test_a_ray_that_meets_nothing_says_so_and_a_ray_from_behind_hits_the_back() -> None:
    corners, _ = folded_sheet(4)
    caster = RayCaster(corners)
    above = UTM + (0.3, 0.2, 50.0)
    hits = caster.cast(np.stack([above, above]), [(0, 0, 1.0), (0, 0, -1.0)])
    assert hits.face[0] == -1
    assert hits.distance[0] == np.inf
    assert hits.face[1] >= 0
    assert caster.cast(UTM + (0.3, 0.2, -50.0), (0, 0, 1.0)).face[0] >= 0


def test_nothing_to_cast_at_is_refused() -> None:
    with pytest.raises(GeometryError):
        RayCaster(np.empty((0, 3, 3)))
    with pytest.raises(GeometryError):
        RayCaster(np.full((1, 3, 3), np.nan))


def test_embree_waits_for_the_first_caster() -> None:
    code = "import vomstudio.geometry.raycast, sys; assert 'embreex' not in sys.modules"
    assert subprocess.run([sys.executable, "-c", code], timeout=60).returncode == 0


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
    hits = RayCaster(points[faces]).cast(starts, (0, 0, 1.0))
    same = grid.face.ravel() == hits.face
    assert same.mean() > 0.9995  # float32 decides otherwise at an edge now and then
    both = same & (hits.face >= 0)
    assert both.mean() > 0.5
    assert np.abs(grid.depth.ravel() - (hits.distance - 99.0))[both].max() < 1e-9
    assert np.abs(grid.weights.reshape(-1, 2) - hits.weights)[both].max() < 1e-7


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
