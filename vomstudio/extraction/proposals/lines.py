"""Lines on a surface that are stronger than noise, and their p-values.

The evidence is the cost of a followed trace compared with its surroundings. Nodes with strong
evidence form connected pieces, and a line is the longest path through a piece. The p-value is the
share of surrogates in which the same search finds a line that is as strong. Surrogates are noise
with the values of the surface and the correlation of its neighbours, after Theiler et al. (1992),
Physica D 58, 77.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from vomstudio.core.arrays import FloatArray, Int32Array, IntArray
from vomstudio.extraction.path_costs import COLOUR_COSTS, contact_values, smooth_values
from vomstudio.extraction.shortest_paths import shortest_path
from vomstudio.extraction.surface_graph import Graph
from vomstudio.extraction.trace_options import ONNX_COST

N_SURROGATES = 49
# Smoothing passes for the evidence, and for the background with which it is compared.
_EVIDENCE_SMOOTHING_PASSES, _BACKGROUND_SMOOTHING_PASSES = 2, 64
# Minimum evidence of a line, in standard deviations of the noise.
_MIN_EVIDENCE = 0.8
# Limit of the local noise, so that a strong contact nearby does not count as noise.
_MAX_NOISE = 3.0
_MIN_NOISE = 0.5
_MAX_SMOOTHING_PASSES = 16
# Minimum ratio of the distance between the ends of a line to its length; a line that turns back is
# cut.
_MIN_STRAIGHTNESS = 0.6
_SEED = 20240229


@dataclass(frozen=True, eq=False)
class LineCandidate:
    """Line that is a candidate for a proposal.

    Parameters
    ----------
    nodes : (k,) int array
        Nodes of the graph in order along the line.
    length : float
        Length in metres.
    evidence : float
        Mean evidence along the line, in standard deviations of the noise.
    strength : float
        Evidence times the square root of the length in typical arc lengths, by which lines are
        ranked.
    """

    nodes: IntArray
    length: float
    evidence: float
    strength: float


def compute_evidence(graph: Graph, cost: str) -> FloatArray:
    """Compute how much each node stands out from its surroundings.

    Parameters
    ----------
    graph : Graph
    cost : str
        One of `COST_NAMES` except "colour", or the name of a field whose low values are searched.

    Returns
    -------
    (n,) array
        Evidence in standard deviations of the local noise.
    """
    raw_values = -contact_values(graph, cost)
    is_unknown = ~np.isfinite(raw_values)
    raw_values[is_unknown] = np.median(raw_values[~is_unknown]) if not is_unknown.all() else 0.0
    smoothed_evidence = smooth_values(graph, raw_values, _EVIDENCE_SMOOTHING_PASSES)
    deviation = smoothed_evidence - smooth_values(
        graph, smoothed_evidence, _BACKGROUND_SMOOTHING_PASSES
    )
    spread = 1.4826 * float(np.median(np.abs(deviation)))
    # Rounding errors of constant values are not noise.
    if spread <= 1e-9 * float(np.abs(raw_values).max(initial=0.0)):
        spread = float(deviation.std())
    if spread <= 1e-9 * float(np.abs(raw_values).max(initial=0.0)):
        return np.zeros(len(raw_values))
    local_deviation = smooth_values(
        graph, np.minimum(np.abs(deviation), _MAX_NOISE * spread), _BACKGROUND_SMOOTHING_PASSES
    )
    noise = spread * np.maximum(
        local_deviation / max(float(np.median(local_deviation)), 1e-300), _MIN_NOISE
    )
    evidence = deviation / noise
    evidence[is_unknown] = 0.0
    return np.asarray(evidence)


def find_lines(
    graph: Graph, evidence: FloatArray, min_length: float, max_lines: int
) -> list[LineCandidate]:
    """Find the strongest lines that have at least a minimum length.

    Parameters
    ----------
    graph : Graph
    evidence : (n,) array
    min_length : float
        Minimum length of a line, m.
    max_lines : int
        Maximum number of lines.

    Returns
    -------
    list of LineCandidate
    """
    arc = graph.typical_arc_length
    lines: list[LineCandidate] = []
    for nodes, piece in _iterate_components(
        graph, np.flatnonzero(evidence > _MIN_EVIDENCE), min_length / arc
    ):
        lines += _trace_lines(nodes, piece, evidence, min_length, arc, max_lines)
    return sorted(lines, key=lambda line: -line.strength)[:max_lines]


def simulate_strengths(
    graph: Graph, evidence: FloatArray, cost: str, min_length: float, check: Callable[[int], None]
) -> FloatArray:
    """Simulate noise and return the strength of the strongest line in each surrogate.

    Parameters
    ----------
    graph : Graph
    evidence : (n,) array
    cost : str
        Cost from which the evidence was computed.
    min_length : float
        Minimum length of a line, m.
    check : callable
        Function that is called with the number of completed surrogates; it may raise Cancelled.

    Returns
    -------
    (N_SURROGATES,) array
        Strengths in ascending order; 0 for surrogates that contain no line.
    """
    pool = np.sort(evidence)
    if cost in ("dark", "light") or cost not in (*COLOUR_COSTS, "curvature", ONNX_COST):
        # Contacts are on one side of the median; the other side represents the noise.
        median = np.median(pool)
        low = pool[pool <= median]
        pool = np.concatenate([low, (2.0 * median - low)[::-1]])
    generator = np.random.default_rng(_SEED)
    pass_count = _match_smoothing(graph, evidence, generator)
    quantiles = (np.arange(len(evidence)) + 0.5) / max(len(evidence), 1)
    values = np.interp(quantiles, (np.arange(len(pool)) + 0.5) / len(pool), pool)
    null_strengths = np.zeros(N_SURROGATES)
    for i in range(N_SURROGATES):
        check(i)
        noise = smooth_values(graph, generator.standard_normal(len(evidence)), pass_count)
        surrogate = np.empty(len(noise))
        surrogate[np.argsort(noise)] = values
        lines = find_lines(graph, surrogate, min_length, 1)
        null_strengths[i] = lines[0].strength if lines else 0.0
    return np.sort(null_strengths)


def line_p_value(strength: float, null_strengths: FloatArray) -> float:
    """Return the p-value of a line, the probability that noise has an equally strong one.

    Parameters
    ----------
    strength : float
    null_strengths : (k,) ndarray
        Sorted strengths of the strongest lines in the noise surrogates.

    Returns
    -------
    float
        p-value between 1 / (k + 1) and 1.
    """
    exceedance_count = len(null_strengths) - int(
        np.searchsorted(null_strengths, strength, side="left")
    )
    return (1 + exceedance_count) / (1 + len(null_strengths))


def _match_smoothing(graph: Graph, evidence: FloatArray, rng: np.random.Generator) -> int:
    """Return the number of smoothing passes at which noise is as correlated as the evidence."""
    source = np.repeat(np.arange(len(evidence)), np.diff(graph.starts))
    is_background = np.abs(evidence) < _MAX_NOISE
    is_background_pair = is_background[source] & is_background[graph.neighbours]
    target = _correlation(
        evidence, source[is_background_pair], graph.neighbours[is_background_pair]
    )
    noise = rng.standard_normal(len(evidence))
    # A difference that may be random does not require another pass.
    tolerance = 2.0 / np.sqrt(max(len(evidence), 1))
    for pass_count in range(_MAX_SMOOTHING_PASSES):
        if _correlation(noise, source, graph.neighbours) >= target - tolerance:
            return pass_count
        noise = smooth_values(graph, noise)
    return _MAX_SMOOTHING_PASSES


def _correlation(values: FloatArray, first: IntArray, second: Int32Array) -> float:
    a, b = values[first], values[second]
    if len(a) < 2 or a.std() == 0.0 or b.std() == 0.0:
        return 0.0
    return float(np.corrcoef(a, b)[0, 1])


def _iterate_components(
    graph: Graph, nodes: IntArray, min_arcs: float
) -> Iterator[tuple[IntArray, Graph]]:
    """Yield the connected pieces of nodes: the nodes and the graph of each piece.

    Pieces that have too few nodes for a line of `min_arcs` arcs are skipped.
    """
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    n = len(graph.places)
    number = np.full(n, -1, np.int64)
    number[nodes] = np.arange(len(nodes))
    count = np.diff(graph.starts)[nodes]
    index = np.repeat(graph.starts[nodes] - (np.cumsum(count) - count), count)
    source_numbers = np.repeat(np.arange(len(nodes)), count)
    neighbour_numbers = number[graph.neighbours[index + np.arange(len(index))]]
    is_inside = neighbour_numbers >= 0
    source_numbers, neighbour_numbers = source_numbers[is_inside], neighbour_numbers[is_inside]
    arcs = csr_array(
        (np.ones(len(source_numbers), np.int8), (source_numbers, neighbour_numbers)),
        shape=(len(nodes),) * 2,
    )
    pieces, label = connected_components(arcs, directed=False)
    order = np.argsort(label, kind="stable")
    node_position = np.empty(len(order), np.int64)
    node_position[order] = np.arange(len(order))
    order_by_source = np.argsort(node_position[source_numbers], kind="stable")
    neighbours = node_position[neighbour_numbers[order_by_source]]
    starts = np.concatenate(
        [[0], np.cumsum(np.bincount(node_position[source_numbers], minlength=len(nodes)))]
    ).astype(np.int64)
    ends = np.concatenate([[0], np.cumsum(np.bincount(label, minlength=pieces))])
    for first_row, last_row in zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True):
        # An arc can be several times longer than the typical arc.
        if 3 * (last_row - first_row) < min_arcs or last_row - first_row < 2:
            continue
        piece_nodes = nodes[order[first_row:last_row]]
        begin, end = starts[first_row], starts[last_row]
        yield (
            piece_nodes,
            Graph(
                np.ascontiguousarray(graph.places[piece_nodes]),
                starts[first_row : last_row + 1] - begin,
                (neighbours[begin:end] - first_row).astype(np.int32),
                None,
                {},
                partial(np.zeros, last_row - first_row),
                piece_nodes,
            ),
        )


def _trace_lines(
    nodes: IntArray,
    piece: Graph,
    evidence: FloatArray,
    min_length: float,
    arc: float,
    max_lines: int,
) -> list[LineCandidate]:
    """Find the longest path through a piece, and repeat this for each remaining branch.

    Paths are cut where they turn back. The search ends once `max_lines` lines have been found.
    """
    from scipy.spatial import cKDTree

    lines: list[LineCandidate] = []
    remaining = [(nodes, piece)]
    while remaining and len(lines) < max_lines:
        part_nodes, part = remaining.pop()
        # The piece is too small for the required distance between the ends of a line.
        if np.linalg.norm(np.ptp(part.places, axis=0)) < _MIN_STRAIGHTNESS * min_length:
            continue
        path = _longest_path(part, evidence[part_nodes])
        length = _polyline_length(part.places[path])
        if length < min_length:
            continue
        for line_nodes in _split_at_turns(part.places, path):
            line_length = _polyline_length(part.places[line_nodes])
            if line_length >= min_length:
                mean = float(evidence[part_nodes[line_nodes]].mean())
                strength = mean * float(np.sqrt(line_length / arc))
                lines.append(LineCandidate(part_nodes[line_nodes], line_length, mean, strength))
        width = max(3.0 * arc, 1.5 * len(part_nodes) * arc / len(path))
        is_far = cKDTree(part.places[path]).query(part.places)[0] > width
        branch_nodes = np.flatnonzero(is_far)
        remaining += [
            (part_nodes[rows], branch)
            for rows, branch in _iterate_components(part, branch_nodes, min_length / arc)
        ]
    return lines


def _split_at_turns(positions: FloatArray, path: IntArray) -> list[IntArray]:
    """Cut a path where it turns back, and return the parts that are straight enough."""
    straight_paths, remaining = [], [path]
    while remaining:
        part = remaining.pop()
        if len(part) < 3:
            continue
        line = positions[part]
        chord = line[-1] - line[0]
        chord_length = float(np.linalg.norm(chord))
        if chord_length >= _MIN_STRAIGHTNESS * _polyline_length(line):
            straight_paths.append(part)
            continue
        offsets = line - line[0]
        if chord_length > 0.0:
            offsets = offsets - np.outer(offsets @ chord / chord_length**2, chord)
        corner_row = 1 + int(np.linalg.norm(offsets, axis=1)[1:-1].argmax())
        remaining += [part[: corner_row + 1], part[corner_row:]]
    return straight_paths


def _polyline_length(positions: FloatArray) -> float:
    return float(np.linalg.norm(np.diff(positions, axis=0), axis=1).sum())


def _longest_path(piece: Graph, evidence: FloatArray) -> IntArray:
    """Return the path between two nodes of a piece that are nearly as far apart as possible."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import dijkstra

    source = np.repeat(np.arange(len(piece.places)), np.diff(piece.starts))
    edge_lengths = np.linalg.norm(piece.places[piece.neighbours] - piece.places[source], axis=1)
    shape = (len(piece.places),) * 2
    arcs = csr_array((np.maximum(edge_lengths, 1e-12), piece.neighbours, piece.starts), shape=shape)
    start_node = int(np.argmax(dijkstra(arcs, indices=0)))
    end_node = int(np.argmax(dijkstra(arcs, indices=start_node)))
    costs = 1.0 / np.maximum(evidence, _MIN_EVIDENCE) ** 2
    path = shortest_path(piece, start_node, end_node, costs)
    assert path is not None
    return path
