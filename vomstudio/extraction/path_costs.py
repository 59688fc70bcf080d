"""What a metre of a path costs: between nearly nothing where a surface looks as a contact does, and
one; so a path is the shortest where nothing is to be seen."""

from __future__ import annotations

from functools import partial

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.extraction.surface_graph import Graph
from vomstudio.geometry.kernels.pieces import split_work

COSTS = ("colour", "dark", "light", "gradient", "curvature")
"""The others are names of fields."""
OF_COLOURS = ("colour", "dark", "light", "gradient")

# A metre on the contact costs this much of one beside it.
_LEAST = 0.02
# Of the values in the corridor, in percent, what counts as nothing and as all: a thin bed is a
# small part of them.
_LOW, _HIGH = 0.2, 98.0
# Steps of smoothing that follow each other: a bed of up to some ten nodes has a middle.
_VALLEY = (2, 4, 8)
# Chroma shows contacts that lightness does not.
_CHROMA = 1.5
# An edge is looked for in lightness that is smoothed so often.
_BLUR = 3
_LIGHTNESS = np.array([0.299, 0.587, 0.114])


def tint(graph: Graph, node: int) -> FloatArray:
    """(3,) the colour at a node, as `node_costs` compares it."""
    assert graph.colours is not None
    around = np.append(graph.near[graph.starts[node] : graph.starts[node + 1]], node)
    return np.asarray(compared(graph.colours[around].mean(axis=0)[None])[0])


def node_costs(graph: Graph, cost: str, tints: FloatArray | None = None) -> FloatArray:
    """(n,) cost of a metre at each node. tints : (w, 3) colours to follow, for "colour"."""
    if cost == "colour":
        assert graph.colours is not None
        assert tints is not None
        own = compared(np.stack([smoothed(graph, c) for c in graph.colours.T], axis=1))
        off = np.full(len(own), np.inf)
        for wanted in np.unique(tints, axis=0):
            np.minimum(off, ((own - wanted) ** 2).sum(axis=1), out=off)
        value = np.sqrt(off)
        value /= max(float(np.percentile(value, _HIGH)), 1e-9)
    else:
        value = looked_for(graph, cost)
        sound = np.isfinite(value)
        whole = bool(sound.all())
        known = value if whole else value[sound]
        low, high = np.percentile(known, [_LOW, _HIGH]) if len(known) else (0.0, 0.0)
        value = (value - low) / max(high - low, 1e-12)
        if not whole:
            value[~sound] = 1.0
    valley = _valley(graph, np.clip(value, 0.0, 1.0))
    return np.asarray(_LEAST + (1.0 - _LEAST) * valley**2)


def smoothed(graph: Graph, values: FloatArray, times: int = 1) -> FloatArray:
    """The mean (n,) of each node's value and its neighbours', so many times over."""
    from vomstudio.extraction.path_kernels import means

    now, next_ = np.array(values, np.float64), np.empty(len(values))
    with split_work(len(values)) as run:
        for _ in range(times):
            run(partial(means, graph.starts, graph.near, now, next_))
            now, next_ = next_, now
    return now


def looked_for(graph: Graph, cost: str) -> FloatArray:
    """(n,) of any cost but "colour": least where a contact is."""
    from vomstudio.extraction.path_kernels import slopes

    if cost == "curvature":
        return -graph.roughness
    if cost not in COSTS:
        return np.array(graph.fields[cost], np.float64)
    assert graph.colours is not None
    light = smoothed(graph, graph.colours @ _LIGHTNESS, _BLUR if cost == "gradient" else 1)
    if cost == "dark":
        return light
    if cost == "light":
        return -light
    steep = np.empty((len(light), 3))
    slopes(graph.places, graph.starts, graph.near, light, steep)
    return np.asarray(-np.linalg.norm(steep, axis=1))


def _valley(graph: Graph, value: FloatArray) -> FloatArray:
    """The mean of values (n,) and of what smoothing leaves of them: least in the middle of a bed.

    Inside a bed of one colour the shortest way cuts the corners from side to side, which tilts its
    plane: always outward where the bed bends back, so that the residuals do not tell.
    """
    total, last = value.copy(), value
    for times in _VALLEY:
        last = smoothed(graph, last, times)
        total += last
    total /= len(_VALLEY) + 1
    return total


def compared(colours: FloatArray) -> FloatArray:
    """Red, green, blue as lightness and two chroma (opponent colours)."""
    r, g, b = colours.T
    return np.stack(
        [(r + g + b) / 3.0, _CHROMA * (r - g) / 2.0, _CHROMA * (2.0 * b - r - g) / 4.0], axis=1
    )
