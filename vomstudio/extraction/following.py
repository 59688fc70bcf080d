"""A line that follows a contact between way-points: the path of least cost over the surface.

The idea is that of Compass's trace (Thiele et al. 2017, Solid Earth 8, 1241), the path that of
Dijkstra (1959). The cost of a metre is between nearly nothing where the surface looks as the
contact does, and one; so a path is the shortest where nothing is to be seen.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.errors import GeometryError, UsageError
from vomstudio.extraction.surface_graph import Graph, SurfaceGraph
from vomstudio.words import tr

Array = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

COSTS = ("colour", "dark", "light", "gradient", "curvature")
"""The others are names of fields."""

# A metre on the contact costs this much of one beside it.
_LEAST = 0.02
# Of the values in the corridor, in percent, what counts as nothing and as all: a thin bed is a
# small part of them.
_LOW, _HIGH = 0.2, 98.0
STRETCH = 1.4
# Steps of smoothing that follow each other: a bed of up to some ten nodes has a middle.
_VALLEY = (2, 4, 8)
_MARGIN = 12.0
_WHOLE_NODES = 3_000_000
# Chroma shows contacts that lightness does not.
_CHROMA = 1.5


@dataclass(frozen=True, eq=False)
class Path:
    """points : (n, 3) in the frame of the surface; length : along it; snaps : (w,) distance of each
    way-point from where the path passes it; at : (w,) rows of points"""

    points: Array
    length: float
    snaps: Array
    at: Ints


class Follower:
    """Follows contacts on one surface, with one cost.

    cost : "colour" (likeness to the colours at the way-points), "dark", "light", "gradient" (edges
        of lightness), "curvature" (edges and furrows of the surface), or the name of a field, whose
        low values are followed
    Raises UsageError for a cost that the model does not have.
    """

    def __init__(self, surface: SurfaceGraph, cost: str = "colour") -> None:
        self.surface, self.cost = surface, cost
        coloured = surface.data.colors is not None or surface.textures is not None
        if cost in ("colour", "dark", "light", "gradient"):
            if not coloured:
                fields = ", ".join(surface.data.fields)
                raise UsageError(
                    tr("The model has no colours. Follow its curvature.")
                    if not fields
                    else tr(
                        "The model has no colours. Follow its curvature, or one of its fields: "
                        "{fields}.",
                        fields=fields,
                    ),
                    field="--cost",
                )
        elif cost != "curvature" and cost not in surface.data.fields:
            raise UsageError(
                tr(
                    "There is no cost or field '{name}'. There are: {known}.",
                    name=cost,
                    known=", ".join((*COSTS, *surface.data.fields)),
                ),
                field="--cost",
            )

    def follow(self, way_points: Array, *, whole: bool = False) -> Path:
        """The path through way-points (w, 3), at least two.

        whole : search all of the surface where it is not too large or textured, so that the path is
            the best of all; else in corridors
        Raises GeometryError where the way-points are one place, or the surface between two of them
        does not hang together.
        """
        world = np.asarray(way_points, np.float64).reshape(-1, 3)
        given = world - self.surface.origin
        if len(given) < 2:
            raise GeometryError(tr("A path needs at least two way-points."))
        surface = self.surface
        refined = surface.is_mesh and surface.textures is not None
        legs: list[Array] = []
        snaps, at = np.zeros(len(given)), np.zeros(len(given), np.int64)
        tints = self._tints(given)
        if whole and not refined and len(surface.places) <= _WHOLE_NODES:
            legs = self._through(surface.whole, given, tints)
        else:
            for i in range(len(given) - 1):
                legs.append(self._leg(given[i], given[i + 1], tints, i))
        line: list[Array] = []
        for i, leg in enumerate(legs):
            if i == 0:
                snaps[0] = np.linalg.norm(leg[0] - world[0])
            else:
                leg = leg[1:] if len(leg) and np.array_equal(leg[0], line[-1][-1]) else leg
            if len(leg):
                line.append(leg)
            at[i + 1] = sum(map(len, line)) - 1
            snaps[i + 1] = np.linalg.norm(line[-1][-1] - world[i + 1])
        points = np.concatenate(line)
        if len(points) < 2:
            raise GeometryError(tr("All way-points are at one place of the model."))
        length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
        return Path(points, length, snaps, at)

    def _leg(self, one: Array, other: Array, tints: Array | None, number: int) -> Array:
        spacing = self._spacing(one, other)
        stretch = STRETCH
        while True:
            margin = (2.0 * _MARGIN if stretch > STRETCH else _MARGIN) * spacing
            graph = self.surface.corridor(one, other, stretch, margin)
            ends = _nearest(graph.places, np.stack([one, other]))
            path = _path(graph, ends[0], ends[1], self._costs(graph, tints))
            if path is not None:
                return self.surface.world(graph, path)
            if len(graph.places) >= len(self.surface.places) or stretch > 50.0:
                raise _apart(number)
            stretch *= 3.0

    def _through(self, graph: Graph, given: Array, tints: Array | None) -> list[Array]:
        """The best of all paths, leg by leg. What the best within the corridor costs bounds the
        search."""
        tree = self.surface.tree
        nodes = np.asarray(tree.query(given)[1], np.int64)
        weights = _weights(graph, costs := self._costs(graph, tints))
        legs = []
        for i in range(len(nodes) - 1):
            near = np.asarray(
                tree.query(self._leg(given[i], given[i + 1], tints, i) - self.surface.origin)[1],
                np.int64,
            )
            step = np.linalg.norm(np.diff(graph.places[near], axis=0), axis=1)
            known = float((step * 0.5 * (costs[near[:-1]] + costs[near[1:]])).sum())
            path = _shortest(weights, int(nodes[i]), int(nodes[i + 1]), known * 1.001 + 1e-12)
            if path is None:
                raise _apart(i)
            legs.append(self.surface.world(graph, path))
        return legs

    def _spacing(self, one: Array, other: Array) -> float:
        places = self.surface.places
        k = min(9, len(places))
        distance = self.surface.tree.query(np.stack([one, other]), k=k)[0]
        # Of k points in a disc.
        return float(np.median(distance[:, -1] * np.sqrt(np.pi / k)))

    # --- costs -------------------------------------------------------------------------------
    def _tints(self, given: Array) -> Array | None:
        """(w, 3) colours at the way-points, as they are compared."""
        if self.cost != "colour":
            return None
        surface = self.surface
        found = []
        for point in given:
            graph = surface.corridor(point, point, 1.0, 4.0 * self._spacing(point, point))
            assert graph.colours is not None
            colours = _smoothed(graph, graph.colours)
            found.append(colours[_nearest(graph.places, point[None])[0]])
        return _compared(np.array(found))

    def _costs(self, graph: Graph, tints: Array | None) -> Array:
        """(n,) cost of a metre at each node."""
        if tints is not None:
            assert graph.colours is not None
            own = _compared(_smoothed(graph, graph.colours))
            off = np.min(
                [np.linalg.norm(own - tint, axis=1) for tint in np.unique(tints, axis=0)], axis=0
            )
            value = off / max(float(np.percentile(off, _HIGH)), 1e-9)
        else:
            value = self._value(graph)
            low, high = np.nanpercentile(value, [_LOW, _HIGH])
            value = (value - low) / max(high - low, 1e-12)
            value = np.where(np.isfinite(value), value, 1.0)
        valley = _valley(graph, np.clip(value, 0.0, 1.0))
        return np.asarray(_LEAST + (1.0 - _LEAST) * valley**2)

    def _value(self, graph: Graph) -> Array:
        if self.cost == "curvature":
            return -graph.roughness
        if self.cost not in COSTS:
            return graph.fields[self.cost]
        assert graph.colours is not None
        light = _smoothed(graph, graph.colours) @ np.array([0.299, 0.587, 0.114])
        if self.cost == "dark":
            return np.asarray(light)
        if self.cost == "light":
            return np.asarray(-light)
        return -_gradient(graph, np.asarray(light))


def _gradient(graph: Graph, light: Array) -> Array:
    """Root mean square change of lightness per metre along the arcs of each node."""
    arcs = graph.arcs.tocoo()
    i, j = arcs.coords
    change = ((light[i] - light[j]) / np.maximum(arcs.data, 1e-12)) ** 2
    n = len(light)
    sums = np.bincount(i, change, n) + np.bincount(j, change, n)
    number = np.bincount(i, minlength=n) + np.bincount(j, minlength=n)
    return np.asarray(np.sqrt(sums / np.maximum(number, 1)))


def _smoothed(graph: Graph, values: Array, times: int = 1) -> Array:
    """The mean (n, c) of each node's values and its neighbours', so many times over."""
    from scipy.sparse import csr_array

    arcs = graph.arcs
    n = arcs.shape[0]
    ones = csr_array((np.ones(len(arcs.data)), arcs.indices, arcs.indptr), shape=(n, n))
    back = ones.T.tocsr()
    number = 1.0 + np.diff(arcs.indptr) + np.bincount(arcs.indices, minlength=n)
    for _ in range(times):
        values = (values + ones @ values + back @ values) / number[:, None]
    return np.asarray(values)


def _valley(graph: Graph, value: Array) -> Array:
    """The mean of values (n,) and of what smoothing leaves of them: least in the middle of a bed.

    Inside a bed of one colour the shortest way cuts the corners from side to side, which tilts its
    plane: always outward where the bed bends back, so that the residuals do not tell.
    """
    total, last = value, value
    for times in _VALLEY:
        last = _smoothed(graph, last[:, None], times)[:, 0]
        total = total + last
    return np.asarray(total / (len(_VALLEY) + 1))


def _compared(colours: Array) -> Array:
    """Red, green, blue as lightness and two chroma (opponent colours)."""
    r, g, b = colours.T
    return np.stack(
        [(r + g + b) / 3.0, _CHROMA * (r - g) / 2.0, _CHROMA * (2.0 * b - r - g) / 4.0], axis=1
    )


def _nearest(places: Array, points: Array) -> Ints:
    return np.array([np.argmin(((places - p) ** 2).sum(axis=1)) for p in points], np.int64)


def _weights(graph: Graph, costs: Array) -> object:
    from scipy.sparse import csr_array

    arcs = graph.arcs
    source = np.repeat(np.arange(arcs.shape[0]), np.diff(arcs.indptr))
    data = arcs.data * (0.5 * (costs[source] + costs[arcs.indices]))
    # Two places at no distance still are an arc.
    data = np.maximum(data, 1e-15)
    return csr_array((data, arcs.indices, arcs.indptr), shape=arcs.shape)


def _path(graph: Graph, one: int, other: int, costs: Array) -> Ints | None:
    return _shortest(_weights(graph, costs), one, other)


def _shortest(weights: object, one: int, other: int, limit: float = np.inf) -> Ints | None:
    """Nodes from one to the other at no more than this cost; None where there is no way."""
    from scipy.sparse.csgraph import dijkstra

    distance, before = dijkstra(
        weights, directed=False, indices=one, return_predecessors=True, limit=limit
    )
    if not np.isfinite(distance[other]):
        return None
    path = [other]
    while path[-1] != one:
        path.append(int(before[path[-1]]))
    return np.array(path[::-1], np.int64)


def _apart(number: int) -> GeometryError:
    return GeometryError(
        tr(
            "The way-points {one} and {other} are on parts of the model that do not hang together. "
            "Set way-points on one part.",
            one=number + 1,
            other=number + 2,
        )
    )
