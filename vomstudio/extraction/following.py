"""Paths of least cost over the surface, which follow a contact between way-points.

The method is based on the trace tool of Compass (Thiele et al. 2017, Solid Earth 8, 1241) and
Dijkstra's (1959) algorithm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.extraction.path_costs import COLOUR_COSTS, COST_NAMES, node_colour, node_costs
from vomstudio.extraction.shortest_paths import shortest_path, straightest_path
from vomstudio.extraction.surface_graph import Graph, SurfaceGraph

PathLeg = tuple[FloatArray, FloatArray]
"""Points (n, 3) between consecutive way-points, and the cost per metre at each. See `Path`."""

CORRIDOR_STRETCH_FACTOR = 1.4
_MARGIN_SPACINGS = 12.0
_MAX_WHOLE_SURFACE_NODES = 3_000_000
# Maximum size of a surface whose costs are cached, each of which takes about 100 bytes of memory.
_MAX_CACHED_NODES = 20_000_000
# A corridor that exceeds both this share and this number of nodes is not cut out of the surface.
_MAX_CORRIDOR_SHARE = 0.15
_MIN_CORRIDOR_NODES = 50_000


@dataclass(frozen=True, eq=False)
class Path:
    """Path that was followed on a surface.

    Parameters
    ----------
    points : (n, 3) array
        Points in the World frame, m.
    length : float
        Length along the path, m.
    snap_distances : (w,) array
        Distance between each way-point and its point of the path, m.
    way_point_rows : (w,) int array
        Rows of the points that correspond to the way-points.
    costs : (n,) array
        Cost per metre at each point, relative to the median over the searched part of the surface.
    """

    points: FloatArray
    length: float
    snap_distances: FloatArray
    way_point_rows: IntArray
    costs: FloatArray


class Follower:
    """Follower of contacts on one surface with one cost.

    Parameters
    ----------
    surface : SurfaceGraph
    cost : str
        "colour" (similarity to the colours at the way-points), "dark", "light", "gradient" (edges
        in lightness), "curvature" (edges and furrows of the surface), or the name of a field, whose
        low values are followed.

    Raises
    ------
    UsageError
        If the cost is not available for the model.
    """

    def __init__(self, surface: SurfaceGraph, cost: str = "colour") -> None:
        self.surface, self.cost = surface, cost
        is_coloured = surface.data.colors is not None or surface.textures is not None
        if cost in COLOUR_COSTS:
            if not is_coloured:
                raise UsageError(Finding("model.no-colours"), field="--cost")
        elif cost != "curvature" and cost not in surface.data.fields:
            raise UsageError(
                Finding(
                    "option.not-a-choice", value=cost, choices=(*COST_NAMES, *surface.data.fields)
                ),
                field="--cost",
            )

    def follow(self, way_points: FloatArray, *, uses_whole_surface: bool = False) -> Path:
        """Follow the path of least cost through way-points.

        Parameters
        ----------
        way_points : (w, 3) array
            Way-points in the World frame, m; w >= 2.
        uses_whole_surface : bool
            If True, search the whole surface unless it is too large or textured; otherwise, search
            a corridor between way-points, or the whole surface if this is faster.

        Returns
        -------
        Path

        Raises
        ------
        GeometryError
            If there are fewer than two way-points, if they coincide, or if two of them are on
            separate parts of the surface.
        """
        world = np.asarray(way_points, np.float64).reshape(-1, 3)
        local_points = world - self.surface.origin
        if len(local_points) < 2:
            raise GeometryError(
                Finding("feature.too-few-points", count=2 - len(local_points), minimum=2)
            )
        surface = self.surface
        legs: list[PathLeg] = []
        snap_distances, position = (
            np.zeros(len(local_points)),
            np.zeros(len(local_points), np.int64),
        )
        target_colours = self._way_point_colours(local_points)
        if (
            uses_whole_surface
            and not surface.can_refine
            and len(surface.places) <= _MAX_WHOLE_SURFACE_NODES
        ):
            legs = self._follow_legs(surface.whole_graph, local_points, target_colours)
        else:
            for i in range(len(local_points) - 1):
                legs.append(self._find_leg(local_points[i], local_points[i + 1], target_colours, i))
        line: list[FloatArray] = []
        costs: list[FloatArray] = []
        for i, (leg, cost) in enumerate(legs):
            if i == 0:
                snap_distances[0] = np.linalg.norm(leg[0] - world[0])
            elif len(leg) and np.array_equal(leg[0], line[-1][-1]):
                leg, cost = leg[1:], cost[1:]
            if len(leg):
                line.append(leg)
                costs.append(cost)
            position[i + 1] = sum(map(len, line)) - 1
            snap_distances[i + 1] = np.linalg.norm(line[-1][-1] - world[i + 1])
        points = np.concatenate(line)
        if len(points) < 2:
            raise GeometryError(Finding("points.coincident"))
        length = float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
        return Path(points, length, snap_distances, position, np.concatenate(costs))

    def _find_leg(
        self, start: FloatArray, goal: FloatArray, target_colours: FloatArray | None, number: int
    ) -> PathLeg:
        spacing = self._local_spacing(start, goal)
        stretch_factor, previous_count = CORRIDOR_STRETCH_FACTOR, 0
        # In a graph of points and vertices, the nearest node may not be connected.
        max_distance = float(self.surface.tree.query(goal)[0]) * (1.0 + 1e-9) + 1e-12
        if self._prefers_whole_surface(start, goal, spacing):
            return self._find_leg_on_whole_surface(start, goal, target_colours, number)
        while True:
            margin = (
                2.0 * _MARGIN_SPACINGS
                if stretch_factor > CORRIDOR_STRETCH_FACTOR
                else _MARGIN_SPACINGS
            ) * spacing
            graph = self.surface.corridor(start, goal, stretch_factor, margin)
            ends = _nearest_nodes(graph.places, np.stack([start, goal]))
            if np.linalg.norm(graph.places[ends[1]] - goal) <= max_distance:
                costs = self._compute_costs(graph, target_colours)
                path = straightest_path(graph, int(ends[0]), int(ends[1]), costs)
                if path is not None:
                    return self.surface.world(graph, path), costs[path] / np.median(costs)
            if (
                len(graph.places) in (previous_count, len(self.surface.places))
                or stretch_factor > 50.0
            ):
                raise _separate_parts_error(number)
            stretch_factor, previous_count = 3.0 * stretch_factor, len(graph.places)

    def _prefers_whole_surface(self, start: FloatArray, goal: FloatArray, spacing: float) -> bool:
        """Return whether searching the whole surface is faster than searching a corridor.

        The costs of the whole surface are cached, which pays off for large corridors. A large
        corridor of a textured mesh has too many faces to be subdivided.
        """
        positions = len(self.surface.places)
        if positions > _MAX_CACHED_NODES:
            return False
        distance = float(np.linalg.norm(goal - start))
        span = CORRIDOR_STRETCH_FACTOR * distance + _MARGIN_SPACINGS * spacing
        area = 0.25 * np.pi * span * np.sqrt(span**2 - distance**2)
        return bool(
            area > _MAX_CORRIDOR_SHARE * positions * spacing**2
            and area > _MIN_CORRIDOR_NODES * spacing**2
            and not self.surface.can_divide(start, goal, span)
        )

    def _find_leg_on_whole_surface(
        self, start: FloatArray, goal: FloatArray, target_colours: FloatArray | None, number: int
    ) -> PathLeg:
        graph = self.surface.whole_graph
        ends = np.asarray(self.surface.tree.query(np.stack([start, goal]))[1], np.int64)
        costs, typical_cost = self._whole_surface_costs(target_colours)
        path = straightest_path(graph, int(ends[0]), int(ends[1]), costs)
        if path is None:
            raise _separate_parts_error(number)
        return self.surface.world(graph, path), costs[path] / typical_cost

    def _whole_surface_costs(self, target_colours: FloatArray | None) -> tuple[FloatArray, float]:
        """Return the cached cost per metre (n,) on the whole surface, and its median."""
        colours = b"" if target_colours is None else target_colours.tobytes()
        cached_costs = self.surface.cached_costs.get(self.cost)
        if cached_costs is None or cached_costs[0] != colours:
            costs = self._compute_costs(self.surface.whole_graph, target_colours)
            cached_costs = colours, costs, float(np.median(costs))
            self.surface.cached_costs[self.cost] = cached_costs
        return cached_costs[1:]

    def _follow_legs(
        self, graph: Graph, local_points: FloatArray, target_colours: FloatArray | None
    ) -> list[PathLeg]:
        """Follow the best path through all way-points, leg by leg."""
        nodes = np.asarray(self.surface.tree.query(local_points)[1], np.int64)
        costs, typical_cost = self._whole_surface_costs(target_colours)
        legs = []
        for i in range(len(nodes) - 1):
            path = shortest_path(graph, int(nodes[i]), int(nodes[i + 1]), costs)
            if path is None:
                raise _separate_parts_error(i)
            legs.append((self.surface.world(graph, path), costs[path] / typical_cost))
        return legs

    def _local_spacing(self, start: FloatArray, goal: FloatArray) -> float:
        positions = self.surface.places
        k = min(9, len(positions))
        distance = self.surface.tree.query(np.stack([start, goal]), k=k)[0]
        # Mean spacing of k points in a disc.
        return float(np.median(distance[:, -1] * np.sqrt(np.pi / k)))

    # --- costs -------------------------------------------------------------------------------
    def _way_point_colours(self, local_points: FloatArray) -> FloatArray | None:
        """Return the opponent colours (w, 3) at the way-points.

        Return None for costs other than "colour".
        """
        if self.cost != "colour":
            return None
        surface = self.surface
        colours = []
        for point in local_points:
            graph = surface.corridor(point, point, 1.0, 4.0 * self._local_spacing(point, point))
            colours.append(node_colour(graph, int(_nearest_nodes(graph.places, point[None])[0])))
        return np.array(colours)

    def _compute_costs(self, graph: Graph, target_colours: FloatArray | None) -> FloatArray:
        return node_costs(graph, self.cost, target_colours)


def _nearest_nodes(positions: FloatArray, points: FloatArray) -> IntArray:
    return np.array([np.argmin(((positions - p) ** 2).sum(axis=1)) for p in points], np.int64)


def _separate_parts_error(number: int) -> GeometryError:
    return GeometryError(Finding("path.separate-parts", first=number + 1, second=number + 2))
