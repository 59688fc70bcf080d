"""Lines that stand out of the noise of a surface, and how likely noise alone makes such ones.

The evidence is what a followed trace looks for, against its surroundings on the surface. Places
where it stands out hang together in pieces, and a line is the longest way through one. The doubt is
the share of surrogates in which the same search finds a line as strong: noise with the values of
the surface and the likeness of its neighbours, after Theiler et al. (1992), Physica D 58, 77.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from vomstudio.core.arrays import FloatArray, Int32Array, IntArray
from vomstudio.extraction.path_costs import OF_COLOURS, looked_for, smoothed
from vomstudio.extraction.shortest_paths import shortest
from vomstudio.extraction.surface_graph import Graph
from vomstudio.extraction.trace_options import ONNX

SURROGATES = 49
# Steps of smoothing: of the evidence, and of the surroundings that it is held against.
_FINE, _WIDE = 2, 64
# Evidence of a line is above this, in standard deviations of the noise.
_STANDS_OUT = 0.8
# A strong contact beside a place is not its noise.
_MOST_NOISE = 3.0
_LEAST_NOISE = 0.5
_MOST_SMOOTHING = 16
# A line's ends are at least so much of its length apart; what turns back is cut there.
_LEAST_REACH = 0.6
_SEED = 20240229


@dataclass(frozen=True, eq=False)
class Line:
    """nodes : of the graph, in their order; length : along it; evidence : its mean, in standard
    deviations of the noise; strength : by which lines are compared, evidence times the root of the
    length in arcs"""

    nodes: IntArray
    length: float
    evidence: float
    strength: float


def evidence_of(graph: Graph, cost: str) -> FloatArray:
    """(n,) how far each node stands out of its surroundings, in standard deviations of the noise
    there. cost : of COSTS but "colour", or a field, whose low values are looked for."""
    raw = -looked_for(graph, cost)
    unknown = ~np.isfinite(raw)
    raw[unknown] = np.median(raw[~unknown]) if not unknown.all() else 0.0
    fine = smoothed(graph, raw, _FINE)
    off = fine - smoothed(graph, fine, _WIDE)
    spread = 1.4826 * float(np.median(np.abs(off)))
    # The rounding of what is equal everywhere is no noise.
    if spread <= 1e-9 * float(np.abs(raw).max(initial=0.0)):
        spread = float(off.std())
    if spread <= 1e-9 * float(np.abs(raw).max(initial=0.0)):
        return np.zeros(len(raw))
    own = smoothed(graph, np.minimum(np.abs(off), _MOST_NOISE * spread), _WIDE)
    noise = spread * np.maximum(own / max(float(np.median(own)), 1e-300), _LEAST_NOISE)
    found = off / noise
    found[unknown] = 0.0
    return np.asarray(found)


def find_lines(graph: Graph, evidence: FloatArray, least_length: float, most: int) -> list[Line]:
    """The lines at least so long, the strongest first."""
    arc = graph.usual_arc
    found: list[Line] = []
    for nodes, piece in _pieces(graph, np.flatnonzero(evidence > _STANDS_OUT), least_length / arc):
        found += _lines_of(nodes, piece, evidence, least_length, arc, most)
    return sorted(found, key=lambda line: -line.strength)[:most]


def strongest_in_noise(
    graph: Graph, evidence: FloatArray, cost: str, least_length: float, check: Callable[[int], None]
) -> FloatArray:
    """(SURROGATES,) strength of the strongest line in each of them, 0 for none, in rising order.

    check : called with the number of those that are done; it may raise Cancelled
    """
    pool = np.sort(evidence)
    if cost in ("dark", "light") or cost not in (*OF_COLOURS, "curvature", ONNX):
        # Contacts are on one side of the middle; the other side tells the noise.
        middle = np.median(pool)
        low = pool[pool <= middle]
        pool = np.concatenate([low, (2.0 * middle - low)[::-1]])
    random = np.random.default_rng(_SEED)
    times = _smoothing(graph, evidence, random)
    shares = (np.arange(len(evidence)) + 0.5) / max(len(evidence), 1)
    values = np.interp(shares, (np.arange(len(pool)) + 0.5) / len(pool), pool)
    strongest = np.zeros(SURROGATES)
    for i in range(SURROGATES):
        check(i)
        noise = smoothed(graph, random.standard_normal(len(evidence)), times)
        surrogate = np.empty(len(noise))
        surrogate[np.argsort(noise)] = values
        lines = find_lines(graph, surrogate, least_length, 1)
        strongest[i] = lines[0].strength if lines else 0.0
    return np.sort(strongest)


def doubt_of(strength: float, strongest: FloatArray) -> float:
    """The chance that the strongest line in noise is as strong as this, from 1 / 50 to 1."""
    reached = len(strongest) - int(np.searchsorted(strongest, strength, side="left"))
    return (1 + reached) / (1 + len(strongest))


def _smoothing(graph: Graph, evidence: FloatArray, random: np.random.Generator) -> int:
    """How often white noise is smoothed until neighbours are as alike as those of the evidence."""
    source = np.repeat(np.arange(len(evidence)), np.diff(graph.starts))
    calm = np.abs(evidence) < _MOST_NOISE
    both = calm[source] & calm[graph.near]
    wanted = _likeness(evidence, source[both], graph.near[both])
    noise = random.standard_normal(len(evidence))
    # What differs by chance alone does not ask for one step more.
    slack = 2.0 / np.sqrt(max(len(evidence), 1))
    for times in range(_MOST_SMOOTHING):
        if _likeness(noise, source, graph.near) >= wanted - slack:
            return times
        noise = smoothed(graph, noise)
    return _MOST_SMOOTHING


def _likeness(values: FloatArray, one: IntArray, other: Int32Array) -> float:
    a, b = values[one], values[other]
    if len(a) < 2 or a.std() == 0.0 or b.std() == 0.0:
        return 0.0
    return float(np.corrcoef(a, b)[0, 1])


def _pieces(graph: Graph, nodes: IntArray, least: float) -> Iterator[tuple[IntArray, Graph]]:
    """What hangs together of these nodes, each as the graph's nodes and a graph of its own; those
    of fewer nodes than a line of `least` arcs could have are left out."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    n = len(graph.places)
    number = np.full(n, -1, np.int64)
    number[nodes] = np.arange(len(nodes))
    count = np.diff(graph.starts)[nodes]
    at = np.repeat(graph.starts[nodes] - (np.cumsum(count) - count), count)
    one = np.repeat(np.arange(len(nodes)), count)
    other = number[graph.near[at + np.arange(len(at))]]
    inside = other >= 0
    one, other = one[inside], other[inside]
    arcs = csr_array((np.ones(len(one), np.int8), (one, other)), shape=(len(nodes),) * 2)
    pieces, label = connected_components(arcs, directed=False)
    order = np.argsort(label, kind="stable")
    place = np.empty(len(order), np.int64)
    place[order] = np.arange(len(order))
    by_source = np.argsort(place[one], kind="stable")
    near = place[other[by_source]]
    starts = np.concatenate([[0], np.cumsum(np.bincount(place[one], minlength=len(nodes)))]).astype(
        np.int64
    )
    ends = np.concatenate([[0], np.cumsum(np.bincount(label, minlength=pieces))])
    for first, last in zip(ends[:-1].tolist(), ends[1:].tolist(), strict=True):
        # An arc may be some times as long as the usual one.
        if 3 * (last - first) < least or last - first < 2:
            continue
        own = nodes[order[first:last]]
        begin, end = starts[first], starts[last]
        yield (
            own,
            Graph(
                np.ascontiguousarray(graph.places[own]),
                starts[first : last + 1] - begin,
                (near[begin:end] - first).astype(np.int32),
                None,
                {},
                partial(np.zeros, last - first),
                own,
            ),
        )


def _lines_of(
    nodes: IntArray, piece: Graph, evidence: FloatArray, least_length: float, arc: float, most: int
) -> list[Line]:
    """The longest way through a piece, that through the longest branch beside it, and so on."""
    from scipy.spatial import cKDTree

    found: list[Line] = []
    left = [(nodes, piece)]
    while left and len(found) < most:
        own, part = left.pop()
        # No two places of it are as far apart as the ends of a line must be.
        if np.linalg.norm(np.ptp(part.places, axis=0)) < _LEAST_REACH * least_length:
            continue
        path = _longest(part, evidence[own])
        length = _length(part.places[path])
        if length < least_length:
            continue
        for nodes_on in _unturned(part.places, path):
            along = _length(part.places[nodes_on])
            if along >= least_length:
                mean = float(evidence[own[nodes_on]].mean())
                strength = mean * float(np.sqrt(along / arc))
                found.append(Line(own[nodes_on], along, mean, strength))
        wide = max(3.0 * arc, 1.5 * len(own) * arc / len(path))
        far = cKDTree(part.places[path]).query(part.places)[0] > wide
        rest = np.flatnonzero(far)
        left += [(own[rows], one) for rows, one in _pieces(part, rest, least_length / arc)]
    return found


def _unturned(places: FloatArray, path: IntArray) -> list[IntArray]:
    """The parts of a path, cut where it turns, whose ends are far enough apart for their length."""
    found, left = [], [path]
    while left:
        part = left.pop()
        if len(part) < 3:
            continue
        line = places[part]
        chord = line[-1] - line[0]
        apart = float(np.linalg.norm(chord))
        if apart >= _LEAST_REACH * _length(line):
            found.append(part)
            continue
        off = line - line[0]
        if apart > 0.0:
            off = off - np.outer(off @ chord / apart**2, chord)
        turn = 1 + int(np.linalg.norm(off, axis=1)[1:-1].argmax())
        left += [part[: turn + 1], part[turn:]]
    return found


def _length(places: FloatArray) -> float:
    return float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())


def _longest(piece: Graph, evidence: FloatArray) -> IntArray:
    """Nodes on the way between two places of a piece that are about as far apart as any."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import dijkstra

    source = np.repeat(np.arange(len(piece.places)), np.diff(piece.starts))
    far = np.linalg.norm(piece.places[piece.near] - piece.places[source], axis=1)
    shape = (len(piece.places),) * 2
    arcs = csr_array((np.maximum(far, 1e-12), piece.near, piece.starts), shape=shape)
    one = int(np.argmax(dijkstra(arcs, indices=0)))
    other = int(np.argmax(dijkstra(arcs, indices=one)))
    costs = 1.0 / np.maximum(evidence, _STANDS_OUT) ** 2
    path = shortest(piece, one, other, costs)
    assert path is not None
    return path
