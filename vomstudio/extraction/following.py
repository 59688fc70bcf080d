"""A line that follows a contact between way-points: the path of least cost over the surface.

The idea is that of Compass's trace (Thiele et al. 2017, Solid Earth 8, 1241), the path that of
Dijkstra (1959).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.extraction.path_costs import COSTS, OF_COLOURS, node_costs, tint
from vomstudio.extraction.shortest_paths import shortest, straightest
from vomstudio.extraction.surface_graph import Graph, SurfaceGraph

Leg = tuple[FloatArray, FloatArray]
"""Points (n, 3) from one way-point to the next, and what a metre at each costs, as in `Path`."""

STRETCH = 1.4
_MARGIN = 12.0
_WHOLE_NODES = 3_000_000
# A corridor of more than this part of the nodes, and of more than so many, is not cut out.
_MOST_OF_ALL = 0.15
_FEW_NODES = 50_000


@dataclass(frozen=True, eq=False)
class Path:
    """points : (n, 3) in the frame of the surface; length : along it; snaps : (w,) distance of each
    way-point from where the path passes it; at : (w,) rows of points; costs : (n,) of a metre at
    each point, in medians of the surface around the path"""

    points: FloatArray
    length: float
    snaps: FloatArray
    at: IntArray
    costs: FloatArray


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
        if cost in OF_COLOURS:
            if not coloured:
                raise UsageError(Finding("model.no-colours"), field="--cost")
        elif cost != "curvature" and cost not in surface.data.fields:
            raise UsageError(
                Finding("option.not-a-choice", value=cost, choices=(*COSTS, *surface.data.fields)),
                field="--cost",
            )

    def follow(self, way_points: FloatArray, *, whole: bool = False) -> Path:
        """The path through way-points (w, 3), at least two.

        whole : search all of the surface where it is not too large or textured, so that the path is
            the best of all; else in corridors
        Raises GeometryError where the way-points are one place, or the surface between two of them
        does not hang together.
        """
        world = np.asarray(way_points, np.float64).reshape(-1, 3)
        given = world - self.surface.origin
        if len(given) < 2:
            raise GeometryError(Finding("feature.too-few-points", count=2 - len(given), minimum=2))
        surface = self.surface
        legs: list[Leg] = []
        snaps, at = np.zeros(len(given)), np.zeros(len(given), np.int64)
        tints = self._tints(given)
        if whole and not surface.refines and len(surface.places) <= _WHOLE_NODES:
            legs = self._through(surface.whole, given, tints)
        else:
            for i in range(len(given) - 1):
                legs.append(self._leg(given[i], given[i + 1], tints, i))
        line: list[FloatArray] = []
        costs: list[FloatArray] = []
        for i, (leg, cost) in enumerate(legs):
            if i == 0:
                snaps[0] = np.linalg.norm(leg[0] - world[0])
            elif len(leg) and np.array_equal(leg[0], line[-1][-1]):
                leg, cost = leg[1:], cost[1:]
            if len(leg):
                line.append(leg)
                costs.append(cost)
            at[i + 1] = sum(map(len, line)) - 1
            snaps[i + 1] = np.linalg.norm(line[-1][-1] - world[i + 1])
        points = np.concatenate(line)
        if len(points) < 2:
            raise GeometryError(Finding("points.coincident"))
        length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
        return Path(points, length, snaps, at, np.concatenate(costs))

    def _leg(
        self, one: FloatArray, other: FloatArray, tints: FloatArray | None, number: int
    ) -> Leg:
        spacing = self._spacing(one, other)
        stretch, before = STRETCH, 0
        # In a graph of points and vertices the nearest of all may be one that is not reached.
        reached = float(self.surface.tree.query(other)[0]) * (1.0 + 1e-9) + 1e-12
        if self._covers(one, other, spacing):
            return self._over_whole(one, other, tints, number)
        while True:
            margin = (2.0 * _MARGIN if stretch > STRETCH else _MARGIN) * spacing
            graph = self.surface.corridor(one, other, stretch, margin)
            ends = _nearest(graph.places, np.stack([one, other]))
            if np.linalg.norm(graph.places[ends[1]] - other) <= reached:
                costs = self._costs(graph, tints)
                path = straightest(graph, int(ends[0]), int(ends[1]), costs)
                if path is not None:
                    return self.surface.world(graph, path), costs[path] / np.median(costs)
            if len(graph.places) in (before, len(self.surface.places)) or stretch > 50.0:
                raise _apart(number)
            stretch, before = 3.0 * stretch, len(graph.places)

    def _covers(self, one: FloatArray, other: FloatArray, spacing: float) -> bool:
        """Whether the corridor would be so much of the surface that it costs more than all of it,
        of which what a metre costs is kept."""
        places = len(self.surface.places)
        if places > _WHOLE_NODES or self.surface.refines:
            return False
        far = float(np.linalg.norm(other - one))
        reach = STRETCH * far + _MARGIN * spacing
        area = 0.25 * np.pi * reach * np.sqrt(reach**2 - far**2)
        return bool(area > _MOST_OF_ALL * places * spacing**2 and area > _FEW_NODES * spacing**2)

    def _over_whole(
        self, one: FloatArray, other: FloatArray, tints: FloatArray | None, number: int
    ) -> Leg:
        graph = self.surface.whole
        ends = np.asarray(self.surface.tree.query(np.stack([one, other]))[1], np.int64)
        costs = self._whole_costs(tints)
        path = straightest(graph, int(ends[0]), int(ends[1]), costs)
        if path is None:
            raise _apart(number)
        return self.surface.world(graph, path), costs[path] / np.median(costs)

    def _whole_costs(self, tints: FloatArray | None) -> FloatArray:
        """(n,) of a metre at each node of the whole surface, reckoned once for each colour."""
        colours = b"" if tints is None else tints.tobytes()
        known = self.surface.kept_costs.get(self.cost)
        if known is None or known[0] != colours:
            known = colours, self._costs(self.surface.whole, tints)
            self.surface.kept_costs[self.cost] = known
        return known[1]

    def _through(self, graph: Graph, given: FloatArray, tints: FloatArray | None) -> list[Leg]:
        """The best of all paths, leg by leg."""
        nodes = np.asarray(self.surface.tree.query(given)[1], np.int64)
        costs = self._whole_costs(tints)
        usual = np.median(costs)
        legs = []
        for i in range(len(nodes) - 1):
            path = shortest(graph, int(nodes[i]), int(nodes[i + 1]), costs)
            if path is None:
                raise _apart(i)
            legs.append((self.surface.world(graph, path), costs[path] / usual))
        return legs

    def _spacing(self, one: FloatArray, other: FloatArray) -> float:
        places = self.surface.places
        k = min(9, len(places))
        distance = self.surface.tree.query(np.stack([one, other]), k=k)[0]
        # Of k points in a disc.
        return float(np.median(distance[:, -1] * np.sqrt(np.pi / k)))

    # --- costs -------------------------------------------------------------------------------
    def _tints(self, given: FloatArray) -> FloatArray | None:
        """(w, 3) colours at the way-points, as they are compared."""
        if self.cost != "colour":
            return None
        surface = self.surface
        found = []
        for point in given:
            graph = surface.corridor(point, point, 1.0, 4.0 * self._spacing(point, point))
            found.append(tint(graph, int(_nearest(graph.places, point[None])[0])))
        return np.array(found)

    def _costs(self, graph: Graph, tints: FloatArray | None) -> FloatArray:
        """(n,) cost of a metre at each node."""
        return node_costs(graph, self.cost, tints)


def _nearest(places: FloatArray, points: FloatArray) -> IntArray:
    return np.array([np.argmin(((places - p) ** 2).sum(axis=1)) for p in points], np.int64)


def _apart(number: int) -> GeometryError:
    return GeometryError(Finding("path.separate-parts", first=number + 1, second=number + 2))
