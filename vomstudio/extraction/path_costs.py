"""Cost per metre of a path at each node of a surface.

The cost is close to zero at points that look like a contact, and one elsewhere. Without a contact,
the path of least cost is therefore the shortest path.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.extraction.surface_graph import Graph
from vomstudio.geometry.kernels.pieces import split_work

COST_NAMES = ("colour", "dark", "light", "gradient", "curvature")
"""Names of the costs; any other name refers to a field."""
COLOUR_COSTS = ("colour", "dark", "light", "gradient")

# Cost per metre on a contact, relative to the cost away from it.
_MIN_COST = 0.02
# Percentiles of the values in a corridor that represent the lowest and the highest value: a thin
# bed covers only a small part of the corridor.
_LOW_PERCENTILE, _HIGH_PERCENTILE = 0.2, 98.0
# Numbers of smoothing passes: a bed about ten nodes wide still has a distinct middle.
_VALLEY_SMOOTHING_PASSES = (2, 4, 8)
# Weight of the chroma relative to the lightness.
_CHROMA_WEIGHT = 1.5
# Number of smoothing passes of the lightness before its gradient is computed.
_N_GRADIENT_PASSES = 3
_LIGHTNESS_WEIGHTS = np.array([0.299, 0.587, 0.114])


def node_colour(graph: Graph, node: int) -> FloatArray:
    """Return the mean opponent colour of a node and its neighbours.

    Parameters
    ----------
    graph : Graph
    node : int

    Returns
    -------
    (3,) ndarray
    """
    assert graph.colours is not None
    rows = np.append(graph.neighbours[graph.starts[node] : graph.starts[node + 1]], node)
    return np.asarray(opponent_colours(graph.colours[rows].mean(axis=0)[None])[0])


def node_costs(graph: Graph, cost: str, target_colours: FloatArray | None = None) -> FloatArray:
    """Compute the cost per metre at each node of a graph.

    Parameters
    ----------
    graph : Graph
    cost : str
        One of `COST_NAMES`, or the name of a field whose low values are followed.
    target_colours : (w, 3) array, optional
        Opponent colours to follow; required for the cost "colour".

    Returns
    -------
    (n,) array
        Dimensionless costs between 0 and 1.
    """
    if cost == "colour":
        assert graph.colours is not None
        assert target_colours is not None
        colours = smooth_opponent_colours(graph)
        squared_distances = np.full(len(graph.places), np.inf)
        for target in np.unique(target_colours, axis=0):
            # Column by column: a sum over rows of three is many times slower.
            deviation = (colours[0] - target[0]) ** 2
            for axis in (1, 2):
                deviation += (colours[axis] - target[axis]) ** 2
            np.minimum(squared_distances, deviation, out=squared_distances)
        value = np.sqrt(squared_distances)
        value /= max(float(np.percentile(value, _HIGH_PERCENTILE)), 1e-9)
    else:
        value = contact_values(graph, cost)
        is_finite = np.isfinite(value)
        is_complete = bool(is_finite.all())
        finite_costs = value if is_complete else value[is_finite]
        low, high = (
            np.percentile(finite_costs, [_LOW_PERCENTILE, _HIGH_PERCENTILE])
            if len(finite_costs)
            else (0.0, 0.0)
        )
        value = (value - low) / max(high - low, 1e-12)
        if not is_complete:
            value[~is_finite] = 1.0
    valley = _deepen_valleys(graph, np.clip(value, 0.0, 1.0))
    return np.asarray(_MIN_COST + (1.0 - _MIN_COST) * valley**2)


def smooth_opponent_colours(graph: Graph) -> FloatArray:
    """Return the opponent colours (3, n) of the nodes, averaged with their neighbours.

    They do not depend on the colours that are followed, and are cached in the graph.

    Parameters
    ----------
    graph : Graph
        Graph whose nodes have colours.
    """
    name = "smooth opponent colours"
    if name not in graph.cache:
        assert graph.colours is not None
        smooth_colours = np.stack([smooth_values(graph, c) for c in graph.colours.T], axis=1)
        graph.cache[name] = np.ascontiguousarray(opponent_colours(smooth_colours).T)
    return graph.cache[name]


def smooth_values(graph: Graph, values: FloatArray, n_passes: int = 1) -> FloatArray:
    """Average the value of each node with the values of its neighbours.

    Parameters
    ----------
    graph : Graph
    values : (n,) ndarray
    n_passes : int, optional
        Number of repetitions.

    Returns
    -------
    (n,) ndarray
    """
    from vomstudio.extraction.path_kernels import average_neighbours

    current_values, smoothed_values = np.array(values, np.float64), np.empty(len(values))
    with split_work(len(values)) as run:
        for _ in range(n_passes):
            run(
                partial(
                    average_neighbours,
                    graph.starts,
                    graph.neighbours,
                    current_values,
                    smoothed_values,
                )
            )
            current_values, smoothed_values = smoothed_values, current_values
    return current_values


def contact_values(graph: Graph, cost: str) -> FloatArray:
    """Compute the values on which a cost other than "colour" is based, lowest on a contact.

    Parameters
    ----------
    graph : Graph
    cost : str
        Name of the cost.

    Returns
    -------
    (n,) ndarray
    """
    from vomstudio.extraction.path_kernels import compute_gradients

    if cost == "curvature":
        return -graph.roughness
    if cost not in COST_NAMES:
        return np.array(graph.fields[cost], np.float64)
    assert graph.colours is not None
    lightness = smooth_values(
        graph, graph.colours @ _LIGHTNESS_WEIGHTS, _N_GRADIENT_PASSES if cost == "gradient" else 1
    )
    if cost == "dark":
        return lightness
    if cost == "light":
        return -lightness
    gradients = np.empty((len(lightness), 3))
    compute_gradients(graph.places, graph.starts, graph.neighbours, lightness, gradients)
    return np.asarray(-np.linalg.norm(gradients, axis=1))


def _deepen_valleys(graph: Graph, value: FloatArray) -> FloatArray:
    """Average values (n,) with smoothed versions, so that the middle of a bed is lowest.

    Within a bed of uniform colour, the shortest path cuts corners from side to side. This tilts the
    plane systematically without being visible in the residuals.
    """
    total, previous_values = value.copy(), value
    for pass_count in _VALLEY_SMOOTHING_PASSES:
        previous_values = smooth_values(graph, previous_values, pass_count)
        total += previous_values
    total /= len(_VALLEY_SMOOTHING_PASSES) + 1
    return total


def opponent_colours(colours: FloatArray) -> FloatArray:
    """Convert red, green and blue to lightness and two weighted chroma components.

    Parameters
    ----------
    colours : (n, 3) ndarray

    Returns
    -------
    (n, 3) ndarray
    """
    r, g, b = colours.T
    return np.stack(
        [
            (r + g + b) / 3.0,
            _CHROMA_WEIGHT * (r - g) / 2.0,
            _CHROMA_WEIGHT * (2.0 * b - r - g) / 4.0,
        ],
        axis=1,
    )
