"""Nodes of a trace map: free ends (I), abutting ends (Y) and crossings (X).

The classification follows Sanderson & Nixon (2015), The use of topology in fracture network
characterization, Journal of Structural Geology 72, 55-66: one branch ends at an I node, three meet
at a Y node, and four at an X node.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, IntArray, ObjectArray
from vomstudio.geology.fractures.pieces import TracePieces

MAX_OFFSET_RATIO = 10.0
"""Maximum distance along a trace between its end and the crossing to which it is snapped, in
multiples of the tolerance. Traces at an acute angle cross far from the point where they come within
the tolerance.
"""


@dataclass(frozen=True)
class SnappedEnd:
    """End of a trace that was moved within the tolerance.

    Attributes
    ----------
    what : {"gap", "overshoot", "edge"}
        Kind of correction: the end stopped short of a trace, overshot a trace, or stopped short of
        the edge of the area.
    trace, other : int
        Numbers of the traces, from 1; None for `other` at an edge.
    x, y : float
        Position of the end as drawn, m.
    distance_m : float
        Distance between the end and the other trace or the edge, m.
    """

    what: str
    trace: int
    other: int | None
    x: float
    y: float
    distance_m: float


@dataclass(frozen=True)
class NodeCounts:
    """Numbers of nodes by type.

    I, Y and X are free ends, abutting ends and crossings. E are ends on the edge of the area, L are
    points where two traces meet end to end, and `other` are points where more than four branches
    meet.
    """

    I: int  # noqa: E741
    Y: int
    X: int
    E: int
    L: int
    other: int


@dataclass(frozen=True, eq=False)
class Nodes:
    """Nodes of a fracture network and the ends that were snapped.

    Attributes
    ----------
    counts : NodeCounts
    mended : tuple of SnappedEnd
        Ends that were snapped to another trace or to the edge of the area.
    points : (k, 2) ndarray
    branches : (k,) ndarray
        Number of branches that meet at each node.
    overlaps : int
        Number of pairs of pieces that overlap.
    """

    counts: NodeCounts
    mended: tuple[SnappedEnd, ...]
    points: FloatArray
    branches: IntArray
    overlaps: int


@dataclass(frozen=True, eq=False)
class _TouchingEnds:
    """Ends within the tolerance of another piece: end, other piece and distance (k,)."""

    end: IntArray
    other_piece: IntArray
    distance: FloatArray


def find_nodes(pieces: TracePieces, snap_m: float = 0.0, area: object = None) -> Nodes:
    """Find the nodes of a map of traces.

    A trace that crosses or touches itself does not form a node there. Crossings and ends on the
    edge of the area are not nodes either.

    Parameters
    ----------
    pieces : TracePieces
    snap_m : float
        Tolerance for the ends of traces, m; 0 allows only for rounding.
    area : shapely polygon, optional

    Returns
    -------
    Nodes
    """
    import shapely

    tolerance = max(snap_m, pieces.rounding_m)
    ends = pieces.ends().reshape(-1, 2)
    is_cut = pieces.is_cut.ravel().copy()
    piece = np.repeat(np.arange(len(pieces)), 2)
    is_closed = np.asarray(shapely.is_closed(pieces.lines))
    tree = shapely.STRtree(pieces.lines)
    free_rows = np.flatnonzero(~is_cut & ~is_closed[piece])
    touching_ends = _find_touching_ends(tree, pieces.lines, ends, piece, free_rows, tolerance)
    crossing, pair, overlaps = _find_crossings(tree, pieces.lines)
    group, node_count = _group_nodes(
        ends, free_rows, crossing, pair, touching_ends, piece, tolerance
    )
    degree, is_edge = _count_branches(
        group,
        node_count,
        free_rows,
        piece,
        pair,
        touching_ends,
        _crossings_at_cut_ends(crossing, ends[is_cut], tolerance),
    )
    positions = _node_positions(group, node_count, ends[free_rows], crossing)
    is_inner = ~is_edge
    counts = NodeCounts(
        I=int(np.sum(degree[is_inner] == 1)),
        Y=int(np.sum(degree[is_inner] == 3)),
        X=int(np.sum(degree[is_inner] == 4)),
        E=int(is_cut.sum()),
        L=int(np.sum(degree[is_inner] == 2)),
        other=int(np.sum(degree[is_inner] > 4)),
    )
    snapped_ends = _snapped_ends(pieces, ends, piece, touching_ends, pair) + _ends_snapped_to_edge(
        pieces, ends, piece, is_cut, area
    )
    return Nodes(counts, tuple(snapped_ends), positions[is_inner], degree[is_inner], overlaps)


def _find_touching_ends(
    tree: object,
    lines: ObjectArray,
    ends: FloatArray,
    piece: IntArray,
    free_indices: IntArray,
    tolerance: float,
) -> _TouchingEnds:
    import shapely

    points = shapely.points(ends[free_indices])
    rows, touched_pieces = tree.query(points, predicate="dwithin", distance=tolerance)  # type: ignore[attr-defined]
    is_other_trace = piece[free_indices[rows]] != touched_pieces
    rows, touched_pieces = rows[is_other_trace], touched_pieces[is_other_trace]
    return _TouchingEnds(
        free_indices[rows],
        touched_pieces,
        np.asarray(shapely.distance(points[rows], lines[touched_pieces])),
    )


def _find_crossings(tree: object, lines: ObjectArray) -> tuple[FloatArray, IntArray, int]:
    """Return the crossings of pieces: points (m, 2), piece rows (m, 2) and number of overlaps."""
    import shapely

    first_rows, second_rows = tree.query(lines, predicate="intersects")  # type: ignore[attr-defined]
    is_ordered = first_rows < second_rows
    first_rows, second_rows = first_rows[is_ordered], second_rows[is_ordered]
    parts, pair_row = shapely.get_parts(
        shapely.intersection(lines[first_rows], lines[second_rows]), return_index=True
    )
    is_point = shapely.get_type_id(parts) == 0
    n_overlaps = len(np.unique(pair_row[~is_point]))
    positions = shapely.get_coordinates(parts[is_point]).reshape(-1, 2)
    return (
        positions,
        np.stack([first_rows[pair_row[is_point]], second_rows[pair_row[is_point]]], axis=1).astype(
            np.int64
        ),
        n_overlaps,
    )


def _group_nodes(
    ends: FloatArray,
    free_indices: IntArray,
    crossing: FloatArray,
    pair: IntArray,
    touching_ends: _TouchingEnds,
    piece: IntArray,
    tolerance: float,
) -> tuple[IntArray, int]:
    """Return the node of each free end and of each crossing, and the number of nodes."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    count = len(free_indices) + len(crossing)
    if not count:
        return np.zeros(0, np.int64), 0
    points = np.vstack([ends[free_indices], crossing])
    links = [cKDTree(points).query_pairs(tolerance, output_type="ndarray").reshape(-1, 2)]
    # An end that overshoots a trace belongs to their crossing.
    free_end_rows = np.full(len(ends), -1, np.int64)
    free_end_rows[free_indices] = np.arange(len(free_indices))
    crossings_by_pair: dict[tuple[int, int], list[int]] = {}
    for row, (first_piece, second_piece) in enumerate(pair.tolist()):
        crossings_by_pair.setdefault((first_piece, second_piece), []).append(row)
    added_links = []
    for end, touched_piece in zip(
        touching_ends.end.tolist(), touching_ends.other_piece.tolist(), strict=True
    ):
        end_piece = int(piece[end])
        for row in crossings_by_pair.get(
            (min(end_piece, touched_piece), max(end_piece, touched_piece)), ()
        ):
            if np.hypot(*(crossing[row] - ends[end])) <= MAX_OFFSET_RATIO * tolerance:
                added_links.append((free_end_rows[end], len(free_indices) + row))
    links.append(np.asarray(added_links, np.int64).reshape(-1, 2))
    edges = np.vstack(links)
    graph = coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(count, count))
    n_nodes, group = connected_components(graph, directed=False)
    return group.astype(np.int64), int(n_nodes)


def _crossings_at_cut_ends(
    crossing: FloatArray, cut_ends: FloatArray, tolerance: float
) -> IntArray:
    """Return the rows of crossings at which a piece was cut by the edge."""
    from scipy.spatial import cKDTree

    if not len(crossing) or not len(cut_ends):
        return np.zeros(0, np.int64)
    distance, _ = cKDTree(cut_ends).query(crossing, distance_upper_bound=tolerance)
    return np.flatnonzero(np.isfinite(distance))


def _count_branches(
    group: IntArray,
    count: int,
    free_indices: IntArray,
    piece: IntArray,
    pair: IntArray,
    touching_ends: _TouchingEnds,
    edge_crossings: IntArray,
) -> tuple[IntArray, BoolArray]:
    """Return the number of branches (count,) at each node, and which nodes are on the edge."""
    n_free_ends = len(free_indices)
    end_node = np.full(2 * (int(piece.max(initial=-1)) + 1), -1, np.int64)
    end_node[free_indices] = group[:n_free_ends]
    # Count each piece once at each of its nodes.
    nodes = np.concatenate(
        [group[:n_free_ends], np.repeat(group[n_free_ends:], 2), end_node[touching_ends.end]]
    )
    involved_pieces = np.concatenate([piece[free_indices], pair.ravel(), touching_ends.other_piece])
    node_pieces = np.unique(np.stack([nodes, involved_pieces], axis=1), axis=0)
    node_ends = np.unique(np.stack([group[:n_free_ends], piece[free_indices]], axis=1), axis=0)
    passing_counts = np.bincount(node_pieces[:, 0], minlength=count)
    ending_counts = np.bincount(node_ends[:, 0], minlength=count)
    is_edge = np.zeros(count, np.bool_)
    is_edge[group[n_free_ends:][edge_crossings]] = True
    return (2 * passing_counts - ending_counts).astype(np.int64), is_edge


def _node_positions(
    group: IntArray, count: int, ends: FloatArray, crossing: FloatArray
) -> FloatArray:
    points = np.vstack([ends, crossing]) if count else np.zeros((0, 2))
    size = np.bincount(group, minlength=count)
    return np.stack([np.bincount(group, points[:, i], count) / size for i in (0, 1)], axis=1)


def _snapped_ends(
    pieces: TracePieces,
    ends: FloatArray,
    piece: IntArray,
    touching_ends: _TouchingEnds,
    pair: IntArray,
) -> list[SnappedEnd]:
    crossing_pairs = set(map(tuple, pair.tolist()))
    nearest_ends: dict[int, tuple[float, int]] = {}
    for end, touched_piece, distance in zip(
        touching_ends.end.tolist(),
        touching_ends.other_piece.tolist(),
        touching_ends.distance.tolist(),
        strict=True,
    ):
        if distance > pieces.rounding_m and distance < nearest_ends.get(end, (np.inf, 0))[0]:
            nearest_ends[end] = (distance, touched_piece)
    snapped_ends = []
    for end, (distance, touched_piece) in sorted(nearest_ends.items()):
        end_piece = int(piece[end])
        is_crossed = (
            min(end_piece, touched_piece),
            max(end_piece, touched_piece),
        ) in crossing_pairs
        snapped_ends.append(
            SnappedEnd(
                "overshoot" if is_crossed else "gap",
                int(pieces.trace[end_piece]) + 1,
                int(pieces.trace[touched_piece]) + 1,
                float(ends[end, 0]),
                float(ends[end, 1]),
                distance,
            )
        )
    return snapped_ends


def _ends_snapped_to_edge(
    pieces: TracePieces, ends: FloatArray, piece: IntArray, is_cut: BoolArray, area: object
) -> list[SnappedEnd]:
    import shapely

    if area is None:
        return []
    rows = np.flatnonzero(is_cut)
    distance = shapely.distance(shapely.boundary(area), shapely.points(ends[rows]))
    return [
        SnappedEnd(
            "edge",
            int(pieces.trace[piece[end]]) + 1,
            None,
            float(ends[end, 0]),
            float(ends[end, 1]),
            float(edge_distance),
        )
        for end, edge_distance in zip(rows, distance, strict=True)
        if edge_distance > pieces.rounding_m
    ]
