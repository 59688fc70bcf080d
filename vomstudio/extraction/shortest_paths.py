"""Paths of least cost through a graph, with or without a cost for turns."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, Int32Array, IntArray
from vomstudio.extraction.surface_graph import Graph

N_HEADINGS = 16
MAX_HEADING_ERROR_DEG = 34.0
"""Maximum angle between an arc and its heading.

Neighbouring arcs of a picture are 45 degrees apart. Both are within this angle of the heading
between them, so a zigzag between them is not a turn."""
TURN_COST = 1.0
"""Cost of a right-angle turn, in typical arcs away from the contact."""
# Maximum number of nodes that are searched with turns, for an interactive response; for larger
# graphs, the shortest path is used.
_MAX_NODES = 15_000
# Maximum distance, in arcs, between the final path and the path with the fewest turns.
_CORRIDOR_ARCS = 4
_FORBIDDEN_COST = 1e6
# Factor that allows for rounding in the lower bound of the remaining cost.
_BOUND_SCALE = 1.0 - 1e-9


def shortest_path(graph: Graph, start: int, end: int, costs: FloatArray) -> IntArray | None:
    """Find the path of least cost between two nodes (Dijkstra 1959).

    Parameters
    ----------
    graph : Graph
    start, end : int
        Start and end node.
    costs : (n,) array
        Cost per metre at each node.

    Returns
    -------
    (k,) int array or None
        Nodes from `start` to `end`; None if the nodes are not connected.
    """
    min_cost = _BOUND_SCALE * float(costs.min()) if len(costs) else 0.0
    result = _search_costs(graph, start, end, costs, max(min_cost, 0.0))
    return None if result is None else _backtrack_path(result[1], start, end)


def straightest_path(
    graph: Graph, start: int, end: int, costs: FloatArray, turn_cost: float = TURN_COST
) -> IntArray | None:
    """Find the path of least cost within the corridor of the path with the fewest turns.

    At a crossing of two contacts, the path stays on the contact that it follows: `path_with_turns`
    selects the contact, and within its corridor the path of least cost stays near the middle.

    Parameters
    ----------
    graph : Graph
    start, end : int
        Start and end node.
    costs : (n,) array
        Cost per metre at each node.
    turn_cost : float
        Cost of a right-angle turn, in typical arcs of cost 1. If 0, `shortest_path` is used.

    Returns
    -------
    (k,) int array or None
        Nodes from `start` to `end`; None if the nodes are not connected.
    """
    path = path_with_turns(graph, start, end, costs, turn_cost)
    if path is None or turn_cost <= 0.0:
        return path
    is_in_corridor = _find_corridor(graph, path)
    return shortest_path(graph, start, end, np.where(is_in_corridor, costs, _FORBIDDEN_COST))


def path_with_turns(
    graph: Graph, start: int, end: int, costs: FloatArray, turn_cost: float = TURN_COST
) -> IntArray | None:
    """Find the path with the lowest total cost of length and turns.

    The state of the search includes a heading, one of 16 directions in the best-fit plane of the
    nodes. An arc within `MAX_HEADING_ERROR_DEG` of the heading does not count as a turn. If the
    search would visit too many nodes, the path of least cost is returned regardless of its turns.

    Parameters
    ----------
    graph : Graph
    start, end : int
        Start and end node.
    costs : (n,) ndarray
        Cost per metre at each node.
    turn_cost : float, optional
        Cost of a right-angle turn, in typical arcs of cost 1. If 0, `shortest_path` is used.

    Returns
    -------
    (k,) ndarray of int or None
        Nodes of the path; None if no path connects the two nodes.
    """
    n = len(graph.places)
    if turn_cost <= 0.0:
        return shortest_path(graph, start, end, costs)
    # The remaining cost without turns guides the search (A*), so that only few states are visited.
    costs_to_end = _search_costs(graph, end, start, costs, 0.0)
    if costs_to_end is None:
        return None
    remaining_costs = np.minimum(costs_to_end[0], costs_to_end[0][start]) * _BOUND_SCALE
    from vomstudio.extraction.path_kernels import search_least_turning

    capacity = min(n, _MAX_NODES)
    slot_nodes, state_count = np.empty(capacity, np.int32), capacity * N_HEADINGS
    predecessors, heap, heap_positions = (np.empty(state_count, np.int32) for _ in range(3))
    state = search_least_turning(
        graph.places,
        graph.plane_coordinates,
        graph.starts,
        graph.neighbours,
        costs,
        start,
        end,
        remaining_costs,
        turn_cost * graph.typical_arc_length / (N_HEADINGS / 4),
        N_HEADINGS,
        np.cos(np.radians(MAX_HEADING_ERROR_DEG)),
        np.full(n, -1, np.int32),
        slot_nodes,
        np.empty(state_count),
        predecessors,
        np.empty(state_count),
        heap,
        heap_positions,
    )
    if state == -2:
        return _backtrack_path(costs_to_end[1], end, start)[::-1]
    if state < 0:
        return None
    path = [state]
    while predecessors[path[-1]] >= 0:
        path.append(int(predecessors[path[-1]]))
    nodes = slot_nodes[np.array(path[::-1], np.int64) // N_HEADINGS].astype(np.int64)
    return np.asarray(nodes[np.append(True, np.diff(nodes) != 0)])


def _search_costs(
    graph: Graph, start: int, end: int, costs: FloatArray, min_cost: float
) -> tuple[FloatArray, Int32Array] | None:
    """Return the cost of reaching each node, and its predecessor.

    Return None if the nodes are not connected.
    """
    from vomstudio.extraction.path_kernels import search_least_cost

    n = len(graph.places)
    distance, predecessors, heap = np.full(n, np.inf), np.empty(n, np.int32), np.empty(n, np.int32)
    is_connected = search_least_cost(
        graph.places,
        graph.starts,
        graph.neighbours,
        costs,
        start,
        end,
        min_cost,
        distance,
        predecessors,
        np.empty(n),
        heap,
        np.full(n, -1, np.int32),
    )
    return (distance, predecessors) if is_connected else None


def _backtrack_path(predecessors: Int32Array, start: int, end: int) -> IntArray:
    path = [end]
    while path[-1] != start:
        path.append(int(predecessors[path[-1]]))
    return np.array(path[::-1], np.int64)


def _find_corridor(graph: Graph, path: IntArray) -> BoolArray:
    """Return which nodes (n,) are within `_CORRIDOR_ARCS` arcs of a path."""
    is_inside = np.zeros(len(graph.places), np.bool_)
    is_inside[path] = True
    front = np.unique(path)
    for _ in range(_CORRIDOR_ARCS):
        first = graph.starts[front]
        count = graph.starts[front + 1] - first
        index = np.repeat(first - (np.cumsum(count) - count), count) + np.arange(int(count.sum()))
        reached_nodes = np.unique(graph.neighbours[index]).astype(np.int64)
        front = reached_nodes[~is_inside[reached_nodes]]
        is_inside[front] = True
    return is_inside
