"""What a measurement asks of a model: the spacing around the pick, and the face it lies on."""

from __future__ import annotations

import numpy as np
import pytest

from vomstudio.geometry.surface import VertexSurface


def face(spacing: float, normal: np.ndarray, size: float = 4.0, seed: int = 0) -> np.ndarray:
    """Grid points of a rough plane with unit normal `normal` at UTM coordinates."""
    rng = np.random.default_rng(seed)
    steps = np.arange(0.0, size, spacing)
    u, v = np.meshgrid(steps, steps)
    e1 = np.linalg.svd(normal[None])[2][1]
    e2 = np.cross(normal, e1)
    points = u.reshape(-1, 1) * e1 + v.reshape(-1, 1) * e2
    rough = 0.1 * spacing * rng.standard_normal((len(points), 1))
    return points + rough * normal + np.array([465_123.0, 4_612_345.0, 820.0])


@pytest.mark.parametrize("built", [False, True])
@pytest.mark.parametrize("spacing", [0.02, 0.1])
def test_resolution_is_the_spacing_of_the_grid(built, spacing):
    points = face(spacing, np.array([0.0, -1.0, 0.0]))
    surface = VertexSurface(points)
    if built:
        surface.build()
    trace = points[:: len(points) // 7] + 0.3 * spacing
    assert surface.resolution_near(trace) == pytest.approx(spacing, rel=0.15)


def test_resolution_is_that_of_the_part_that_was_picked():
    fine = face(0.02, np.array([0.0, -1.0, 0.0]))
    coarse = face(0.2, np.array([0.0, -1.0, 0.0])) + np.array([100.0, 0.0, 0.0])
    surface = VertexSurface(np.concatenate([coarse, fine]))
    surface.build()
    assert surface.resolution_near(fine[:5]) == pytest.approx(0.02, rel=0.15)
    assert surface.resolution_near(coarse[:5]) == pytest.approx(0.2, rel=0.15)


def test_vertices_that_stand_twice_on_a_seam_do_not_count_as_spacing():
    points = face(0.05, np.array([0.0, -1.0, 0.0]))
    surface = VertexSurface(np.repeat(points, 2, axis=0))
    assert surface.resolution_near(points[40:43]) == pytest.approx(0.05, rel=0.2)


@pytest.mark.parametrize("built", [False, True])
def test_the_answers_do_not_depend_on_the_tree(built):
    points = face(0.1, np.array([0.6, -0.8, 0.0]), seed=3)
    plain, tree = VertexSurface(points), VertexSurface(points)
    tree.build()
    trace = points[[5, 200, 700, 900]]
    assert plain.resolution_near(trace) == pytest.approx(tree.resolution_near(trace), rel=1e-12)
    np.testing.assert_allclose(plain.outcrop_normal(trace), tree.outcrop_normal(trace))


@pytest.mark.parametrize("normal", [(0.0, -1.0, 0.0), (0.6, -0.8, 0.0), (0.3, -0.4, np.sqrt(0.75))])
def test_the_outcrop_normal_is_that_of_the_face_around_a_trace_across_it(normal):
    normal = np.array(normal)
    points = face(0.02, normal)
    along = np.linspace(0.1, 0.9, 9)
    corner, far = points.min(axis=0), points.max(axis=0)
    trace = corner + along[:, None] * (far - corner)
    near = points[[np.argmin(((points - p) ** 2).sum(axis=1)) for p in trace]]
    found = VertexSurface(points).outcrop_normal(near)
    angle = np.degrees(np.arccos(min(1.0, abs(found @ normal))))
    assert angle < 2.0


def test_too_little_surface_has_no_face():
    line = np.stack([np.linspace(0, 1, 50), np.zeros(50), np.zeros(50)], axis=1)
    assert VertexSurface(line).outcrop_normal(line[::10]) is None
    assert VertexSurface(line[:2]).outcrop_normal(line[:2]) is None
    assert VertexSurface(line[:1]).resolution_near(line[:1]) is None
