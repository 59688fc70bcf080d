"""Paths of least cost, plain and with turns, against other searches and over crossings."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from vomstudio.extraction.path_costs import node_costs
from vomstudio.extraction.pixel_graph import pixel_graph
from vomstudio.extraction.shortest_paths import (
    MAX_HEADING_ERROR_DEG,
    N_HEADINGS,
    path_with_turns,
    shortest_path,
    straightest_path,
)
from vomstudio.extraction.surface_graph import Graph


def graph_of(picture: np.ndarray) -> Graph:
    grey = np.repeat(np.clip(picture, 0, 255).astype(np.uint8)[..., None], 3, axis=2)
    height, width = picture.shape
    return pixel_graph(grey, (slice(0, height), slice(0, width)), np.ones(picture.shape, bool))


def arcs(graph: Graph, costs: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    first = np.repeat(np.arange(len(graph.places)), np.diff(graph.starts))
    length = np.linalg.norm(graph.places[first] - graph.places[graph.neighbours], axis=1)
    return (
        first,
        graph.neighbours.astype(int),
        length * 0.5 * (costs[first] + costs[graph.neighbours]),
    )


def cost_of(graph: Graph, costs: np.ndarray, path: np.ndarray) -> float:
    length = np.linalg.norm(np.diff(graph.places[path], axis=0), axis=1)
    return float((length * 0.5 * (costs[path[1:]] + costs[path[:-1]])).sum())


@pytest.mark.parametrize("seed", range(6))
def test_shortest_path_cost_matches_scipy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    graph = graph_of(rng.uniform(0, 255, (30, 37)))
    costs = rng.uniform(0.02, 1.0, len(graph.places))
    one, other = rng.integers(0, len(costs), 2).tolist()
    first, neighbours, step = arcs(graph, costs)
    n = len(costs)
    best = dijkstra(csr_array((step, (first, neighbours)), (n, n)), indices=one)[other]
    path = shortest_path(graph, one, other, costs)
    assert cost_of(graph, costs, path) == pytest.approx(best, rel=1e-12)


@pytest.mark.parametrize("seed", range(6))
def test_straightest_path_cost_matches_scipy_on_heading_graph(seed: int) -> None:
    rng = np.random.default_rng(seed)
    graph = graph_of(rng.uniform(0, 255, (13, 17)))
    costs = rng.uniform(0.02, 1.0, len(graph.places)) ** 2
    one, other = rng.integers(0, len(costs), 2).tolist()
    turn = float(rng.uniform(0.1, 3.0))
    n = len(costs)
    # The graph of headings written out: arcs within reach of a heading, and turns.
    first, neighbours, step = arcs(graph, costs)
    plane_coordinates = graph.plane_coordinates
    way = plane_coordinates[neighbours] - plane_coordinates[first]
    rows, ends, prices = [], [], []
    each = turn * graph.typical_arc_length * 4 / N_HEADINGS
    for h in range(N_HEADINGS):
        angle = 2.0 * np.pi * h / N_HEADINGS
        cosine = way @ [np.cos(angle), np.sin(angle)] / np.linalg.norm(way, axis=1)
        off = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
        free = off <= MAX_HEADING_ERROR_DEG
        rows += [
            first[free] * N_HEADINGS + h,
            np.arange(n) * N_HEADINGS + h,
            np.arange(n) * N_HEADINGS + h,
        ]
        ends += [
            neighbours[free] * N_HEADINGS + h,
            np.arange(n) * N_HEADINGS + (h + 1) % N_HEADINGS,
            np.arange(n) * N_HEADINGS + (h - 1) % N_HEADINGS,
        ]
        prices += [step[free], np.full(n, each), np.full(n, each)]
    whole = csr_array(
        (np.concatenate(prices), (np.concatenate(rows), np.concatenate(ends))),
        (n * N_HEADINGS, n * N_HEADINGS),
    )
    starts = one * N_HEADINGS + np.arange(N_HEADINGS)
    far = dijkstra(whole, indices=starts)[:, other * N_HEADINGS : (other + 1) * N_HEADINGS].min()
    path = path_with_turns(graph, one, other, costs, turn)
    assert path[0] == one
    assert path[-1] == other
    # The least that turning along the path found can cost, by all its courses of headings.
    spent = np.zeros(N_HEADINGS)
    turns = np.arange(N_HEADINGS)
    apart = np.abs(turns[:, None] - turns)
    apart = each * np.minimum(apart, N_HEADINGS - apart)
    for a, b in pairwise(path.tolist()):
        spent = (spent[:, None] + apart).min(axis=0)
        angle = np.degrees(np.arctan2(*(plane_coordinates[b] - plane_coordinates[a])[::-1]))
        off = np.abs((360.0 / N_HEADINGS * turns - angle + 180.0) % 360.0 - 180.0)
        spent[off > MAX_HEADING_ERROR_DEG] = np.inf
    assert cost_of(graph, costs, path) + spent.min() == pytest.approx(far, rel=1e-9)


def test_zero_turn_cost_gives_shortest_path() -> None:
    rng = np.random.default_rng(1)
    graph = graph_of(rng.uniform(0, 255, (20, 20)))
    costs = rng.uniform(0.02, 1.0, len(graph.places))
    assert np.array_equal(
        straightest_path(graph, 3, 390, costs, 0.0), shortest_path(graph, 3, 390, costs)
    )


def test_disconnected_nodes_have_no_path() -> None:
    mask = np.ones((9, 9), bool)
    mask[:, 4] = False
    picture = np.zeros((9, 9, 3), np.uint8)
    graph = pixel_graph(picture, (slice(0, 9), slice(0, 9)), mask)
    costs = np.ones(len(graph.places))
    assert shortest_path(graph, 0, len(costs) - 1, costs) is None
    assert straightest_path(graph, 0, len(costs) - 1, costs) is None


def crossed(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, tuple[int, int]]:
    """A bed with one a little darker beside it and dark joints across both: the picture, how far
    each pixel is from the bed, and its two ends."""
    height, width = 90, 200
    y, x = np.mgrid[0:height, 0:width].astype(float)
    bow = 2.0 * np.sin(x / rng.uniform(25, 40) + rng.uniform(0, 6))
    own = 38.0 + bow
    beside = own + rng.uniform(9, 16)
    light = 180.0 + 10.0 * rng.standard_normal(y.shape)
    light -= 110.0 * np.exp(-(((y - own) / 1.5) ** 2))
    light -= 120.0 * np.exp(-(((y - beside) / 1.5) ** 2))
    for at in rng.uniform((30, 140), (60, 170)):
        light -= 120.0 * np.exp(-(((x - at - 0.2 * (y - 45)) / 1.5) ** 2))
    off = np.abs(y - own)
    row = [round(float(own[0, i])) for i in (4, width - 5)]
    return light, off, (row[0] * width + 4, row[1] * width + width - 5)


def kept(turning: bool, count: int = 40) -> float:
    """The share of paths that stay within four pixels of the bed that their ends are on."""
    rng, held = np.random.default_rng(7), 0
    for _ in range(count):
        light, off, (one, other) = crossed(rng)
        graph = graph_of(light)
        costs = node_costs(graph, "dark")
        path = (straightest_path if turning else shortest_path)(graph, one, other, costs)
        held += bool(off.ravel()[path].max() < 4.0)
    return held / count


@pytest.mark.full
def test_a_path_stays_on_its_bed_where_darker_lines_cross_it() -> None:
    assert kept(False) < 0.5
    assert kept(True) > 0.85


def test_turn_cost_does_not_reduce_accuracy_on_bent_line() -> None:
    rng = np.random.default_rng(3)
    y, x = np.mgrid[0:120, 0:200].astype(float)
    true = 60.0 + 25.0 * np.sin(x / 18.0)
    light = 180.0 + 10.0 * rng.standard_normal(y.shape)
    light -= 100.0 * np.exp(-(((y - true) / 2.0) ** 2))
    graph = graph_of(light)
    costs = node_costs(graph, "dark")
    one, other = (round(float(true[0, i])) * 200 + i for i in (4, 195))
    far = []
    for path in (
        shortest_path(graph, one, other, costs),
        straightest_path(graph, one, other, costs),
    ):
        places = graph.places[path, :2] - 0.5
        curve = np.column_stack([np.linspace(0, 199, 4000), np.zeros(4000)])
        curve[:, 1] = 60.0 + 25.0 * np.sin(curve[:, 0] / 18.0)
        far.append(np.linalg.norm(places[:, None] - curve, axis=2).min(axis=1).max())
    assert far[1] < max(far[0], 1.5) + 0.5
