"""The graph of a surface and its parts, against scipy."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from vomstudio.extraction.following import Follower
from vomstudio.extraction.path_costs import node_costs, smooth_opponent_colours, smooth_values
from vomstudio.extraction.surface_graph import Graph, SurfaceGraph, _unique_edges
from vomstudio.geometry.cloud import PointCloud


def sheets(count: int, rng: np.random.Generator) -> np.ndarray:
    """Points of two parallel sheets of 4 x 4 m, half a metre apart."""
    points = rng.uniform(0.0, 4.0, (count, 3))
    points[:, 2] = 0.05 * np.sin(3.0 * points[:, 0])
    points[::2, 2] += 0.5
    return points


def arcs(graph: Graph) -> tuple[np.ndarray, np.ndarray]:
    return np.repeat(np.arange(len(graph.places)), np.diff(graph.starts)), graph.neighbours.astype(
        int
    )


def test_cloud_graph_lists_each_neighbour_once_in_both_directions() -> None:
    graph = SurfaceGraph(PointCloud(sheets(4000, np.random.default_rng(0)))).whole_graph
    first, second = arcs(graph)
    pairs = set(zip(first.tolist(), second.tolist(), strict=True))
    assert len(pairs) == len(first)
    assert all((b, a) in pairs and a != b for a, b in pairs)


@pytest.mark.parametrize(("length", "many"), [(0.3, False), (1.5, True)])
def test_corridor_is_connected_part_within_its_ellipsoid(length: float, many: bool) -> None:
    surface = SurfaceGraph(PointCloud(sheets(20_000, np.random.default_rng(1))))
    one = np.array([1.0, 2.0, 0.05 * np.sin(3.0)]) - surface.origin
    other = one + [length, 0.0, 0.0]
    result = surface.corridor(one, other, 1.4, 0.2)
    reach = 1.4 * length + 0.2
    whole_graph, places = surface.whole_graph, surface.places
    by_way = sum(np.linalg.norm(places - end, axis=1) for end in (one, other))
    inside = by_way <= reach
    first, second = arcs(whole_graph)
    both = inside[first] & inside[second]
    n = len(places)
    joined = csr_array((np.ones(both.sum()), (first[both], second[both])), (n, n))
    label = connected_components(joined, directed=False)[1]
    expected = inside & (label == label[int(surface.tree.query(one)[1])])
    assert (expected.sum() > n / 50) == many
    assert (expected.sum() < inside.sum()) == many, (
        "The other sheet is within reach of the long one."
    )
    assert set(map(tuple, result.places)) == set(map(tuple, places[expected]))
    here = both & expected[first] & expected[second]
    a, b = arcs(result)
    ends = {(*p, *q) for p, q in zip(result.places[a], result.places[b], strict=True)}
    assert ends == {
        (*p, *q) for p, q in zip(places[first[here]], places[second[here]], strict=True)
    }


@pytest.mark.full
def test_long_paths_follow_colour_of_their_own_ends() -> None:
    """What a metre costs is kept for the whole surface; it is that of one colour."""
    rng = np.random.default_rng(2)
    points = rng.uniform(0.0, [6.0, 3.0, 0.0], (120_000, 3))
    points[:, 2] = 0.02 * np.sin(5.0 * points[:, 0])
    lines = {1.0: (200, 40, 40), 2.0: (40, 40, 200)}
    colours = np.full((len(points), 3), 150, np.uint8)
    for y, colour in lines.items():
        colours[np.abs(points[:, 1] - y - 0.15 * np.sin(points[:, 0])) < 0.04] = colour
    surface = SurfaceGraph(PointCloud(points, colors=colours))
    follower = Follower(surface, "colour")
    x = np.array([0.2, 5.8])
    for y in (1.0, 2.0, 1.0):
        ends = np.column_stack([x, y + 0.15 * np.sin(x), 0.02 * np.sin(5.0 * x)])
        path = follower.follow(ends).points
        assert surface.cached_costs, "So long a way is searched for over the whole surface."
        assert np.abs(path[:, 1] - y - 0.15 * np.sin(path[:, 0])).max() < 0.06
        shortest = follower.follow(ends, uses_whole_surface=True).points
        assert np.abs(shortest[:, 1] - y - 0.15 * np.sin(shortest[:, 0])).max() < 0.06


@pytest.mark.full
@pytest.mark.parametrize("count", [500, 130_000])
def test_smoothing_is_the_mean_of_each_point_and_its_neighbours(count: int) -> None:
    """Of few in one piece, of many in one on each processor."""
    graph = SurfaceGraph(PointCloud(sheets(count, np.random.default_rng(3)))).whole_graph
    n = len(graph.places)
    first, second = arcs(graph)
    joined = csr_array((np.ones(len(first)), (first, second)), (n, n))
    values = expected = np.random.default_rng(4).standard_normal(n)
    for _ in range(3):
        expected = (expected + joined @ expected) / (1.0 + np.diff(graph.starts))
    assert np.allclose(smooth_values(graph, values, 3), expected, rtol=0.0, atol=1e-12)


def test_nodes_are_in_order_of_their_first_vertex() -> None:
    """Neighbours in the file are then neighbours in memory."""
    rng = np.random.default_rng(5)
    points = rng.uniform(0.0, 4.0, (500, 3))
    again = rng.integers(0, 500, 300)
    surface = SurfaceGraph(PointCloud(np.concatenate([points, points[again]])))
    assert np.array_equal(surface.row, np.arange(500))
    assert np.array_equal(surface.places + surface.origin, points)


def test_mesh_edges_are_unique_and_sorted() -> None:
    faces = np.random.default_rng(6).permuted(np.arange(60).reshape(20, 3) % 17, axis=1)
    first, second = _unique_edges(faces, 17)
    pairs = {tuple(sorted((int(f[i]), int(f[i - 1])))) for f in faces for i in range(3)}
    assert list(zip(first.tolist(), second.tolist(), strict=True)) == sorted(pairs)


def test_smooth_colours_are_computed_once_for_several_targets() -> None:
    rng = np.random.default_rng(7)
    colours = rng.integers(0, 256, (400, 3)).astype(np.uint8)
    surface = SurfaceGraph(PointCloud(sheets(400, rng), colors=colours))
    graph = surface.whole_graph
    first = smooth_opponent_colours(graph)
    node_costs(graph, "colour", np.zeros((1, 3)))
    assert smooth_opponent_colours(graph) is first
    fresh = SurfaceGraph(surface.data).whole_graph
    target = np.array([[40.0, 5.0, -3.0], [90.0, 0.0, 8.0]])
    assert np.array_equal(node_costs(graph, "colour", target), node_costs(fresh, "colour", target))
