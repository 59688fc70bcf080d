"""Paths of least cost through a graph: the plain one, and one that turns as little as it can."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, Int32Array, IntArray
from vomstudio.extraction.surface_graph import Graph

HEADINGS = 16
WIDEST_DEG = 34.0
"""An arc may be this far from the heading: two neighbouring ones of a picture, 45 degrees apart,
are within reach of the one in the middle, so that a line between them zigzags without turning."""
TURN = 1.0
"""To turn by a right angle costs as much as so many usual arcs beside the contact."""
# So many nodes are looked at, which keeps it live; where more are needed the plain way is taken.
_MOST_NODES = 15_000
# A path may be moved so many arcs to the side of where it turns least.
_BESIDE = 4
_FORBIDDEN = 1e6
# What is known of the rest may be off by rounding.
_SURE = 1.0 - 1e-9


def shortest(graph: Graph, one: int, other: int, costs: FloatArray) -> IntArray | None:
    """Nodes from one to the other on the way that costs least (Dijkstra 1959); None where there is
    no way. costs : (n,) of a metre at each node."""
    least = _SURE * float(costs.min()) if len(costs) else 0.0
    found = _searched(graph, one, other, costs, max(least, 0.0))
    return None if found is None else _back(found[1], one, other)


def straightest(
    graph: Graph, one: int, other: int, costs: FloatArray, turn: float = TURN
) -> IntArray | None:
    """As `shortest`, where to turn costs too: so a path that follows one of two contacts goes on
    along it where they cross.

    That says which contact it is; on this the path is the plain one, which keeps to its middle as
    closely as the nodes allow.
    turn : of a right angle, in usual arcs at the cost of 1 a metre; 0 for the plain way
    """
    way = turned(graph, one, other, costs, turn)
    if way is None or turn <= 0.0:
        return way
    tube = _beside(graph, way)
    return shortest(graph, one, other, np.where(tube, costs, _FORBIDDEN))


def turned(
    graph: Graph, one: int, other: int, costs: FloatArray, turn: float = TURN
) -> IntArray | None:
    """The path on which lengths and turns together cost least.

    A heading is part of the state of the search: one of 16 around the circle, in the plane that
    fits the nodes best. An arc within 34 degrees of it costs no turn.
    """
    n = len(graph.places)
    if turn <= 0.0:
        return shortest(graph, one, other, costs)
    # What is left to go, without turns, leads the search: it looks at few states beside the way.
    back = _searched(graph, other, one, costs, 0.0)
    if back is None:
        return None
    rest = np.minimum(back[0], back[0][one]) * _SURE
    from vomstudio.extraction.path_kernels import least_turning

    room = min(n, _MOST_NODES)
    met, states = np.empty(room, np.int32), room * HEADINGS
    before, heap, place = (np.empty(states, np.int32) for _ in range(3))
    state = least_turning(
        graph.places,
        graph.flat,
        graph.starts,
        graph.near,
        costs,
        one,
        other,
        rest,
        turn * graph.usual_arc / (HEADINGS / 4),
        HEADINGS,
        np.cos(np.radians(WIDEST_DEG)),
        np.full(n, -1, np.int32),
        met,
        np.empty(states),
        before,
        np.empty(states),
        heap,
        place,
    )
    if state == -2:
        return _back(back[1], other, one)[::-1]
    if state < 0:
        return None
    path = [state]
    while before[path[-1]] >= 0:
        path.append(int(before[path[-1]]))
    found = met[np.array(path[::-1], np.int64) // HEADINGS].astype(np.int64)
    return np.asarray(found[np.append(True, np.diff(found) != 0)])


def _searched(
    graph: Graph, one: int, other: int, costs: FloatArray, least: float
) -> tuple[FloatArray, Int32Array] | None:
    """What it costs to each node that was reached, and from where; None where there is no way."""
    from vomstudio.extraction.path_kernels import least_cost

    n = len(graph.places)
    distance, before, heap = np.full(n, np.inf), np.empty(n, np.int32), np.empty(n, np.int32)
    met = least_cost(
        graph.places,
        graph.starts,
        graph.near,
        costs,
        one,
        other,
        least,
        distance,
        before,
        np.empty(n),
        heap,
        np.full(n, -1, np.int32),
    )
    return (distance, before) if met else None


def _back(before: Int32Array, one: int, other: int) -> IntArray:
    path = [other]
    while path[-1] != one:
        path.append(int(before[path[-1]]))
    return np.array(path[::-1], np.int64)


def _beside(graph: Graph, path: IntArray) -> BoolArray:
    """(n,) the nodes that are at most some arcs from a path."""
    near_it = np.zeros(len(graph.places), np.bool_)
    near_it[path] = True
    fresh = np.unique(path)
    for _ in range(_BESIDE):
        first, count = graph.starts[fresh], np.diff(graph.starts)[fresh]
        at = np.repeat(first - (np.cumsum(count) - count), count) + np.arange(int(count.sum()))
        met = np.unique(graph.near[at]).astype(np.int64)
        fresh = met[~near_it[met]]
        near_it[fresh] = True
    return near_it
