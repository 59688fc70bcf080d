"""Paths that stay on their contact beside parallel ones."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from tests.extraction.planes_by_construction import grid_mesh
from vomstudio.extraction import plane_prior
from vomstudio.extraction.following import Follower
from vomstudio.extraction.path_costs import appearance_costs, node_costs
from vomstudio.extraction.surface_graph import SurfaceGraph
from vomstudio.geometry.mesh import Mesh

STEP = 0.02


def wall(
    grey_of: Callable[[np.ndarray, np.ndarray], np.ndarray],
) -> tuple[Mesh, np.ndarray]:
    """A wavy surface of 3 x 2 m, grey by the distance (n,) from a plane and by x; the distance."""
    y, x = np.mgrid[0:101, 0:151] * STEP
    mesh = grid_mesh(0.25 * np.sin(2.1 * x) + 0.2 * np.sin(3.3 * y + 1.0), STEP)
    normal = np.array([np.sin(np.radians(20.0)), np.cos(np.radians(20.0)), 0.5])
    normal /= np.linalg.norm(normal)
    off = (mesh.vertices - [1.5, 1.0, 0.1]) @ normal
    grey = grey_of(off, mesh.vertices[:, 0]) + 4.0 * np.random.default_rng(1).standard_normal(
        len(off)
    )
    colours = np.repeat(np.clip(grey, 0, 255)[:, None], 3, axis=1).astype(np.uint8)
    return Mesh(mesh.vertices, mesh.faces, colors=colours), off


def two_clicks(mesh: Mesh, off: np.ndarray, x: tuple[float, float] = (0.2, 2.8)) -> np.ndarray:
    """The vertices nearest to the plane near both ends."""
    ends = []
    for place in x:
        rows = np.flatnonzero(np.abs(mesh.vertices[:, 0] - place) < 0.5 * STEP)
        ends.append(mesh.vertices[rows[np.argmin(np.abs(off[rows]))]])
    return np.array(ends)


def interrupted(off: np.ndarray, x: np.ndarray) -> np.ndarray:
    """A dark seam that is covered for 0.4 m, and there a parallel one beside it."""
    is_covered = (x > 1.2) & (x < 1.6)
    is_dark = (np.abs(off) < 0.02) & ~is_covered
    is_dark |= (np.abs(off - 0.18) < 0.02) & (x > 1.1) & (x < 1.7)
    return np.where(is_dark, 40.0, 180.0)


def test_a_path_crosses_a_gap_in_the_plane_of_its_contact(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    mesh, off = wall(interrupted)
    surface, clicks = SurfaceGraph(mesh), two_clicks(mesh, off)

    def distance() -> float:
        path = Follower(surface, "dark").follow(clicks, is_whole=True)
        rows = surface.tree.query(path.points - surface.origin)[1]
        return float(np.abs(off[rows]).max())

    assert distance() < 0.08
    monkeypatch.setattr(plane_prior, "MAX_PENALTY", 0.0)
    assert distance() > 0.14


def test_without_a_distinct_plane_the_costs_are_unchanged() -> None:
    mesh, off = wall(lambda off, x: 0.0 * off + 120.0)
    surface = SurfaceGraph(mesh)
    start, goal = two_clicks(mesh, off) - surface.origin
    costs = node_costs(surface.whole, "dark")
    typical = float(np.median(costs))
    same = plane_prior.add_plane_prior(surface.whole, costs, start, goal, typical)
    assert same is costs
    # Way-points a few arcs apart do not show a plane.
    near = plane_prior.add_plane_prior(surface.whole, costs, start, start + 4 * STEP, typical)
    assert near is costs


def test_the_cost_of_a_departure_is_limited() -> None:
    mesh, off = wall(interrupted)
    surface = SurfaceGraph(mesh)
    start, goal = two_clicks(mesh, off) - surface.origin
    costs = node_costs(surface.whole, "dark")
    typical = float(np.median(costs))
    added = plane_prior.add_plane_prior(surface.whole, costs, start, goal, typical) - costs
    assert added.min() == 0.0
    assert added.max() == pytest.approx(plane_prior.MAX_PENALTY * typical)
    assert added[np.abs(off) < 0.02].max() < 0.1 * added.max()
    assert added[np.abs(off) > 0.3].min() > 0.9 * added.max()


def test_a_path_stays_on_the_side_of_the_bed_that_was_clicked() -> None:
    """The clicks are on the upper contact of a dark bed with soft edges."""
    mesh, off = wall(lambda off, x: 180.0 - 60.0 * ((off < 0.0) & (off > -0.2)))
    surface = SurfaceGraph(mesh)
    path = Follower(surface, "colour").follow(two_clicks(mesh, off))
    rows = surface.tree.query(path.points - surface.origin)[1]
    assert np.percentile(np.abs(off[rows]), 90) < 2.5 * STEP


def test_the_appearance_is_computed_once_for_several_targets() -> None:
    mesh, off = wall(interrupted)
    graph = SurfaceGraph(mesh).whole
    rows = np.flatnonzero(np.abs(off) < 0.01)
    first = appearance_costs(graph, rows[:1])
    cached = graph.cached["appearance"]
    both = appearance_costs(graph, rows[[0, -1]])
    assert graph.cached["appearance"] is cached
    assert np.array_equal(appearance_costs(SurfaceGraph(mesh).whole, rows[[0, -1]]), both)
    assert first[rows[0]] == pytest.approx(0.02, abs=0.05)
    assert 0.0 < both.min() <= both.max() <= 1.0
