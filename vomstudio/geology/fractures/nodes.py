"""Nodes of a map of traces: free ends (I), abutting ends (Y), crossings (X).

After Sanderson & Nixon (2015), The use of topology in fracture network characterization, Journal of
Structural Geology 72, 55-66: by the branches that meet, one at an I, three at a Y, four at an X.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray, ObjectArray
from vomstudio.geology.fractures.pieces import Pieces

_REACH = 10.0
"""Of the tolerance: how far along the trace an end may lie beyond the crossing that it is taken to;
traces that meet at an acute angle cross long before they are a tolerance apart."""


@dataclass(frozen=True)
class Mended:
    """An end that the tolerance moved. what : gap (it stopped short of a trace), overshoot (it ran
    past one), edge (it stopped short of the edge of the area); trace, other : their numbers, other
    None at an edge; x, y : the end as drawn; distance_m : how far it was from the other"""

    what: str
    trace: int
    other: int | None
    x: float
    y: float
    distance_m: float


@dataclass(frozen=True)
class NodeCounts:
    """I, Y, X : free ends, abutting ends, crossings; E : ends on the edge of the area; L : places
    where two traces meet end to end; other : where more than four branches meet"""

    I: int  # noqa: E741
    Y: int
    X: int
    E: int
    L: int
    other: int


@dataclass(frozen=True, eq=False)
class Nodes:
    """Nodes of a fracture network.

    Parameters
    ----------
    counts : NodeCounts
    mended : tuple of Mended
        Ends that were snapped to another trace.
    points : (k, 2) array
    branches : (k,) array
        Number of branches that meet at each point.
    overlaps : int
        Number of pairs of pieces that overlap.
    """

    counts: NodeCounts
    mended: tuple[Mended, ...]
    points: FloatArray
    branches: IntArray
    overlaps: int


@dataclass(frozen=True, eq=False)
class _Touches:
    """end, other, distance (k,) : which end of a piece lies within the tolerance of which piece"""

    end: IntArray
    other: IntArray
    distance: FloatArray


def nodes_of(pieces: Pieces, snap_m: float = 0.0, area: object = None) -> Nodes:
    """Find the nodes of pieces whose ends may miss each other by snap_m; 0: by rounding only.

    A trace that crosses or touches itself makes no node. Crossings on the edge of the area, and
    ends on it, are none either.
    """
    import shapely

    tolerance = max(snap_m, pieces.rounding_m)
    ends = pieces.ends().reshape(-1, 2)
    cut = pieces.cut.ravel().copy()
    piece = np.repeat(np.arange(len(pieces)), 2)
    closed = np.asarray(shapely.is_closed(pieces.lines))
    tree = shapely.STRtree(pieces.lines)
    free = np.flatnonzero(~cut & ~closed[piece])
    touches = _touching(tree, pieces.lines, ends, piece, free, tolerance)
    crossing, pair, overlaps = _crossings(tree, pieces.lines)
    group, node_count = _grouped(ends, free, crossing, pair, touches, piece, tolerance)
    degree, is_edge = _branches(
        group, node_count, free, piece, pair, touches, _at_cut_ends(crossing, ends[cut], tolerance)
    )
    places = _places(group, node_count, ends[free], crossing)
    kept = ~is_edge
    counts = NodeCounts(
        I=int(np.sum(degree[kept] == 1)),
        Y=int(np.sum(degree[kept] == 3)),
        X=int(np.sum(degree[kept] == 4)),
        E=int(cut.sum()),
        L=int(np.sum(degree[kept] == 2)),
        other=int(np.sum(degree[kept] > 4)),
    )
    mended = _mended(pieces, ends, piece, free, touches, pair) + _mended_edges(
        pieces, ends, piece, cut, area
    )
    return Nodes(counts, tuple(mended), places[kept], degree[kept], overlaps)


def _touching(
    tree: object,
    lines: ObjectArray,
    ends: FloatArray,
    piece: IntArray,
    free: IntArray,
    tolerance: float,
) -> _Touches:
    import shapely

    points = shapely.points(ends[free])
    at, other = tree.query(points, predicate="dwithin", distance=tolerance)  # type: ignore[attr-defined]
    foreign = piece[free[at]] != other
    at, other = at[foreign], other[foreign]
    return _Touches(free[at], other, np.asarray(shapely.distance(points[at], lines[other])))


def _crossings(tree: object, lines: ObjectArray) -> tuple[FloatArray, IntArray, int]:
    """(m, 2) places where two pieces meet, (m, 2) the two; and how many run over each other."""
    import shapely

    one, two = tree.query(lines, predicate="intersects")  # type: ignore[attr-defined]
    once = one < two
    one, two = one[once], two[once]
    parts, of = shapely.get_parts(shapely.intersection(lines[one], lines[two]), return_index=True)
    point = shapely.get_type_id(parts) == 0
    over = len(np.unique(of[~point]))
    places = shapely.get_coordinates(parts[point]).reshape(-1, 2)
    return places, np.stack([one[of[point]], two[of[point]]], axis=1).astype(np.int64), over


def _grouped(
    ends: FloatArray,
    free: IntArray,
    crossing: FloatArray,
    pair: IntArray,
    touches: _Touches,
    piece: IntArray,
    tolerance: float,
) -> tuple[IntArray, int]:
    """(free + crossings,) the node of each free end and each crossing, and how many there are."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    count = len(free) + len(crossing)
    if not count:
        return np.zeros(0, np.int64), 0
    points = np.vstack([ends[free], crossing])
    links = [cKDTree(points).query_pairs(tolerance, output_type="ndarray").reshape(-1, 2)]
    # An end that ran past a trace belongs to the crossing with it.
    place_of = np.full(len(ends), -1, np.int64)
    place_of[free] = np.arange(len(free))
    key: dict[tuple[int, int], list[int]] = {}
    for row, (a, b) in enumerate(pair.tolist()):
        key.setdefault((a, b), []).append(row)
    extra = []
    for end, other in zip(touches.end.tolist(), touches.other.tolist(), strict=True):
        own = int(piece[end])
        for row in key.get((min(own, other), max(own, other)), ()):
            if np.hypot(*(crossing[row] - ends[end])) <= _REACH * tolerance:
                extra.append((place_of[end], len(free) + row))
    links.append(np.asarray(extra, np.int64).reshape(-1, 2))
    joined = np.vstack(links)
    graph = coo_array((np.ones(len(joined)), (joined[:, 0], joined[:, 1])), shape=(count, count))
    found, group = connected_components(graph, directed=False)
    return group.astype(np.int64), int(found)


def _at_cut_ends(crossing: FloatArray, cut_ends: FloatArray, tolerance: float) -> IntArray:
    """Rows of crossings that lie where a piece was cut off by the edge."""
    from scipy.spatial import cKDTree

    if not len(crossing) or not len(cut_ends):
        return np.zeros(0, np.int64)
    distance, _ = cKDTree(cut_ends).query(crossing, distance_upper_bound=tolerance)
    return np.flatnonzero(np.isfinite(distance))


def _branches(
    group: IntArray,
    count: int,
    free: IntArray,
    piece: IntArray,
    pair: IntArray,
    touches: _Touches,
    at_edge: IntArray,
) -> tuple[IntArray, BoolArray]:
    """(count,) how many branches leave each node; and whether it lies on the edge."""
    n_free = len(free)
    end_node = np.full(2 * (int(piece.max(initial=-1)) + 1), -1, np.int64)
    end_node[free] = group[:n_free]
    # Every piece that has to do with a node, once for each.
    nodes = np.concatenate([group[:n_free], np.repeat(group[n_free:], 2), end_node[touches.end]])
    involved = np.concatenate([piece[free], pair.ravel(), touches.other])
    both = np.unique(np.stack([nodes, involved], axis=1), axis=0)
    ends_here = np.unique(np.stack([group[:n_free], piece[free]], axis=1), axis=0)
    passing = np.bincount(both[:, 0], minlength=count)
    ending = np.bincount(ends_here[:, 0], minlength=count)
    is_edge = np.zeros(count, np.bool_)
    is_edge[group[n_free:][at_edge]] = True
    return (2 * passing - ending).astype(np.int64), is_edge


def _places(group: IntArray, count: int, ends: FloatArray, crossing: FloatArray) -> FloatArray:
    points = np.vstack([ends, crossing]) if count else np.zeros((0, 2))
    size = np.bincount(group, minlength=count)
    return np.stack([np.bincount(group, points[:, i], count) / size for i in (0, 1)], axis=1)


def _mended(
    pieces: Pieces,
    ends: FloatArray,
    piece: IntArray,
    free: IntArray,
    touches: _Touches,
    pair: IntArray,
) -> list[Mended]:
    crossed = set(map(tuple, pair.tolist()))
    nearest: dict[int, tuple[float, int]] = {}
    for end, other, distance in zip(
        touches.end.tolist(), touches.other.tolist(), touches.distance.tolist(), strict=True
    ):
        if distance > pieces.rounding_m and distance < nearest.get(end, (np.inf, 0))[0]:
            nearest[end] = (distance, other)
    found = []
    for end, (distance, other) in sorted(nearest.items()):
        own = int(piece[end])
        over = (min(own, other), max(own, other)) in crossed
        found.append(
            Mended(
                "overshoot" if over else "gap",
                int(pieces.trace[own]) + 1,
                int(pieces.trace[other]) + 1,
                float(ends[end, 0]),
                float(ends[end, 1]),
                distance,
            )
        )
    return found


def _mended_edges(
    pieces: Pieces, ends: FloatArray, piece: IntArray, cut: BoolArray, area: object
) -> list[Mended]:
    import shapely

    if area is None:
        return []
    at = np.flatnonzero(cut)
    distance = shapely.distance(shapely.boundary(area), shapely.points(ends[at]))
    return [
        Mended(
            "edge",
            int(pieces.trace[piece[end]]) + 1,
            None,
            float(ends[end, 0]),
            float(ends[end, 1]),
            float(d),
        )
        for end, d in zip(at, distance, strict=True)
        if d > pieces.rounding_m
    ]
