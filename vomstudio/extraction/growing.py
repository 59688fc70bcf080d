"""Pieces of a surface that lie in one plane, found by growing: which element is of which.

Seeds are taken in order of planarity; what is grown is settled (every element goes to the nearest
plane of those around it), and neighbours that are one plane within their scatter become one.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, Int32Array, IntArray
from vomstudio.core.progress import Progress
from vomstudio.core.words import tr
from vomstudio.extraction.elements import Elements, middle_of
from vomstudio.extraction.kernels import grouped, grow, renumbered, settle, sums_of
from vomstudio.extraction.point_neighbours import NEIGHBOURS
from vomstudio.geometry.kernels.jit import for_kernels

NONE, OUT = -1, -2
_PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
# Of the resolution around: what natural faces and the noise of their models need.
_REACH_OF_SPACING = 1.0
_REACH_OF_NOISE = 3.0
_SEEDS = 50_000
_SETTLED = 4
_SCATTERS = 3.5
"""Beyond so many standard deviations from its plane an element is none of a facet."""
_WIDER = 1.25
"""Two facets are one plane where the scatter about the common one is at most this many times that
about their own."""


_PARALLEL_DEG = 2.0
_TURNING = 0.125
"""Of the turn from one piece of a bend to the next, what normals turn within one of the two from
its middle to its outer third: 0.3 on a cylinder, and about nothing beside an edge of planes."""
_PARTS = (0.35, 0.65, 0.93)
_TURNING_ROUND, _FEWEST_BESIDE = 0.06, 3
"""The same on the mean of all that are beside one, if these are so many."""
_LOOKED_AT, _FEWEST_TURNING, _MOST_FACETS = 1500, 30, 500
_LOOSE = 0.35
"""A slice of a cloud without a surface, as clutter is, has more neighbours than this beside it that
are of no facet."""


@dataclass(frozen=True, eq=False)
class Planes:
    """Of f facets, from the moments of their elements.

    centre (f, 3) from the elements' origin on, normal (f, 3), rms (f,), area (f,), count (f,)
    scatter (f, 3, 3) covariance of their places, weighted by area; squares (f,) sum of how far each
        may lie off, squared, if that is told
    """

    centre: FloatArray
    normal: FloatArray
    rms: FloatArray
    area: FloatArray
    count: IntArray
    scatter: FloatArray
    squares: FloatArray


def reach_of(elements: Elements, max_distance: float | None) -> FloatArray:
    """(n,) how far each element may lie from a plane: m, or None for the local spacing, or three
    times the local noise."""
    if max_distance is not None:
        return np.full(len(elements), max_distance)
    noise = np.nan_to_num(elements.noise)
    # At edges the local scatter is relief and no noise: no more than is usual around.
    # Around what has a normal: cells with a few scattered points may be many.
    told = noise[np.isfinite(elements.normals[:, 0])]
    usual = middle_of(told) if len(told) else 0.0
    wide = np.minimum(noise, 2.0 * usual)
    wide *= _REACH_OF_NOISE
    np.maximum(wide, _REACH_OF_SPACING * elements.spacing, out=wide)
    if elements.of == "face":
        # Large and small faces of one mesh are as true as each other.
        wide = np.minimum(wide, max(float(np.median(wide)), 1e-300))
    return for_kernels(wide, np.float64)


def grown(
    elements: Elements,
    *,
    angle_deg: float,
    reach: FloatArray,
    least_count: int,
    least_area: float,
    usual: float,
    progress: Progress,
    begun: Int32Array | None = None,
) -> Int32Array:
    """(n,) facet of each element, from 0 on, -1 for none.

    reach : (n,) how far each element may lie from the plane, `usual` their median; least_count,
        least_area : smaller facets are left out unless they reach one of the two; begun : (n,)
        facets that are known
    Raises Cancelled through `progress`, whose steps are seeds.
    """
    n = len(elements)
    labels = np.full(n, NONE, np.int32) if begun is None else for_kernels(begun, np.int32)
    usable = np.isfinite(elements.normals[:, 0]) & np.isfinite(reach)
    labels[~usable] = OUT
    rows, amid = np.arange(n), None
    if begun is not None:
        listed = np.diff(elements.starts) > 0
        rows, closed = np.flatnonzero(listed), np.flatnonzero(~listed)
        amid = _sums(elements, labels, closed, _count(labels), reach=reach)
    free = rows[labels[rows] == NONE]
    worth = np.nan_to_num(elements.variation[free], nan=1.0)
    order = free[np.argsort(worth, kind="stable")]
    queue, sums = np.empty(n, np.int32), np.zeros(10)
    cosine = float(np.cos(np.radians(angle_deg)))
    progress.stage(tr("Growing facets"), len(order))
    label = _count(labels)
    for first in range(0, len(order), _SEEDS):
        last = min(first + _SEEDS, len(order))
        label = grow(
            order,
            first,
            last,
            elements.places,
            elements.normals,
            elements.areas,
            elements.inner,
            reach,
            elements.starts,
            elements.near,
            cosine,
            least_count,
            least_area,
            labels,
            queue,
            label,
            sums,
        )
        progress.step(last)
    progress.stage(tr("Merging facets"), None)
    for _ in range(2):
        labels = _settled(elements, rows, amid, reach, usual, cosine, labels)
        labels, amid = _merged(elements, rows, amid, reach, angle_deg, labels)
        progress.step(0)
    labels = _settled(elements, rows, amid, reach, usual, cosine, labels)
    return _without_small(
        elements, rows, planes_of(elements, labels, rows, amid), labels, least_count, least_area
    )


@dataclass(frozen=True, eq=False)
class _Sums:
    """Of facets the sums of weight, first and second moments about places (f, 3) that are known
    (f,), and of how far elements may lie off, squared (f, 11); and their number (f,)."""

    about: FloatArray
    known: BoolArray
    sums: FloatArray
    count: IntArray

    def longer(self, f: int) -> _Sums:
        """A copy, for so many facets."""
        more = f - len(self.known)
        return _Sums(
            np.concatenate([self.about, np.zeros((more, 3))]),
            np.concatenate([self.known, np.zeros(more, np.bool_)]),
            np.concatenate([self.sums, np.zeros((more, 11))]),
            np.concatenate([self.count, np.zeros(more, np.int64)]),
        )

    def joined(self, number: IntArray) -> _Sums:
        """Of facets that are one where their numbers (f,) are the same."""
        new = _no_sums(int(number.max(initial=-1)) + 1)
        own = np.flatnonzero(self.known)
        new.known[number[own]] = True
        new.about[number[own][::-1]] = self.about[own][::-1]
        shift, sums = self.about[own] - new.about[number[own]], self.sums[own].copy()
        weight, first = sums[:, 0], sums[:, 1:4].copy()
        for at, (i, j) in enumerate(_PAIRS):
            sums[:, 4 + at] += (
                first[:, i] * shift[:, j]
                + first[:, j] * shift[:, i]
                + weight * shift[:, i] * shift[:, j]
            )
        sums[:, 1:4] += weight[:, None] * shift
        np.add.at(new.sums, number[own], sums)
        np.add.at(new.count, number[own], self.count[own])
        return new


def _no_sums(f: int) -> _Sums:
    return _Sums(np.zeros((f, 3)), np.zeros(f, np.bool_), np.zeros((f, 11)), np.zeros(f, np.int64))


def _sums(
    elements: Elements,
    labels: Int32Array,
    rows: IntArray,
    f: int,
    amid: _Sums | None = None,
    reach: FloatArray | None = None,
) -> _Sums:
    found = _no_sums(f) if amid is None else amid.longer(f)
    own = for_kernels(labels, np.int32)
    sums_of(
        rows,
        elements.places,
        elements.areas,
        elements.inner,
        np.zeros(1) if reach is None else reach,
        own,
        found.about,
        found.known,
        found.sums,
        found.count,
    )
    return found


def planes_of(
    elements: Elements,
    labels: Int32Array,
    rows: IntArray | None = None,
    amid: _Sums | None = None,
    reach: FloatArray | None = None,
) -> Planes:
    """The planes of facets 0 to the largest label, weighted by area. amid : the sums of all
    elements but those of the rows, where they are known"""
    rows = np.arange(len(labels)) if rows is None else rows
    found = _sums(elements, labels, rows, _count(labels), amid, reach)
    area = found.sums[:, 0]
    means = found.sums[:, 1:] / np.where(area > 0.0, area, 1.0)[:, None]
    mean = means[:, :3]
    scatter = np.empty((len(area), 3, 3))
    for at, (i, j) in enumerate(_PAIRS):
        scatter[:, i, j] = scatter[:, j, i] = means[:, 3 + at] - mean[:, i] * mean[:, j]
    values, vectors = np.linalg.eigh(scatter)
    return Planes(
        found.about + mean,
        np.ascontiguousarray(vectors[:, :, 0]),
        np.sqrt(np.maximum(values[:, 0], 0.0)),
        area,
        found.count,
        scatter,
        found.sums[:, 10],
    )


def limits_of(planes: Planes, usual: float) -> FloatArray:
    """(f,) how far from its plane an element of a facet may lie at most, by the facet's scatter.
    usual : the median of how far elements may lie from a plane"""
    return for_kernels(np.maximum(_SCATTERS * planes.rms, 0.1 * usual), np.float64)


def _settled(
    elements: Elements,
    rows: IntArray,
    amid: _Sums | None,
    reach: FloatArray,
    usual: float,
    cosine: float,
    labels: Int32Array,
) -> Int32Array:
    for _ in range(_SETTLED):
        planes = planes_of(elements, labels, rows, amid)
        if not len(planes.area):
            return labels
        out = np.empty(len(rows), np.int32)
        changed = settle(
            rows,
            elements.places,
            elements.normals,
            reach,
            elements.starts,
            elements.near,
            cosine,
            for_kernels(planes.centre, np.float64),
            for_kernels(planes.normal, np.float64),
            limits_of(planes, usual),
            labels,
            out,
        )
        labels[rows] = out
        if changed <= 1e-4 * len(labels):
            break
    return labels


def _merged(
    elements: Elements,
    rows: IntArray,
    amid: _Sums | None,
    reach: FloatArray,
    angle_deg: float,
    labels: Int32Array,
) -> tuple[Int32Array, _Sums | None]:
    """Neighbours that are one plane become one; the labels, and the sums of what is amid."""
    f = _count(labels)
    if f < 2:
        return labels, amid
    pairs = _touching(elements, labels, f, rows)
    planes = planes_of(elements, labels, rows, amid, reach)
    owner = np.arange(f)
    weight = planes.area.copy()
    mean, normal, rms = planes.centre.copy(), planes.normal.copy(), planes.rms.copy()
    scatter = planes.scatter.copy()
    limit = np.sqrt(planes.squares / np.maximum(planes.count, 1))
    cosine = np.abs((normal[pairs[:, 0]] * normal[pairs[:, 1]]).sum(axis=1))
    likely = cosine >= np.cos(np.radians(angle_deg))
    pairs = pairs[likely][np.argsort(-cosine[likely], kind="stable")]
    for one, two in pairs.tolist():
        a, b = _root(owner, one), _root(owner, two)
        if a == b or weight[a] <= 0.0 or weight[b] <= 0.0:
            continue
        total = weight[a] + weight[b]
        apart = mean[b] - mean[a]
        joint = (
            weight[a] * scatter[a]
            + weight[b] * scatter[b]
            + weight[a] * weight[b] / total * np.outer(apart, apart)
        ) / total
        values, vectors = np.linalg.eigh(joint)
        common = float(np.sqrt(max(values[0], 0.0)))
        own = np.sqrt((weight[a] * rms[a] ** 2 + weight[b] * rms[b] ** 2) / total)
        allowed = max(_WIDER * own, 0.1 * min(limit[a], limit[b]))
        if common > allowed:
            continue
        # Of a small one beside a large the common scatter tells nothing: it must lie in that plane.
        small, large = (a, b) if weight[a] < weight[b] else (b, a)
        off = abs(float((mean[small] - mean[large]) @ normal[large]))
        tilt = abs(float(normal[small] @ vectors[:, 0]))
        width = np.sqrt(max(float(np.trace(scatter[small])), 0.0))
        rise = width * np.sqrt(max(1.0 - tilt * tilt, 0.0))
        if off > 2.0 * max(rms[large], 0.05 * limit[large]) or rise > 2.0 * max(
            rms[small], 0.05 * limit[small]
        ):
            continue
        owner[b] = a
        mean[a] = mean[a] + (weight[b] / total) * apart
        weight[a], scatter[a], normal[a], rms[a] = total, joint, vectors[:, 0], common
    roots = np.array([_root(owner, i) for i in range(f)])
    _, number = np.unique(roots, return_inverse=True)
    # The last two stand for NONE and OUT, which are counted from the end.
    out = np.empty_like(labels)
    renumbered(labels, np.append(number, [OUT, NONE]).astype(np.int32), out)
    return out, None if amid is None else amid.longer(f).joined(number)


def _root(owner: IntArray, i: int) -> int:
    while owner[i] != i:
        owner[i] = owner[owner[i]]
        i = int(owner[i])
    return i


def _touching(
    elements: Elements, labels: Int32Array, f: int, rows: IntArray | None = None
) -> IntArray:
    """(p, 2) facets that have neighbouring elements, each pair once. rows : of those that have
    neighbours, all where they are not told"""
    number = np.diff(elements.starts)
    own = (labels, number) if rows is None else (labels[rows], number[rows])
    source = np.repeat(*own)
    target = labels[elements.near]
    border = (source != target) & (source >= 0) & (target >= 0)
    a, b = source[border].astype(np.int64), target[border].astype(np.int64)
    key = np.unique(np.minimum(a, b) * f + np.maximum(a, b))
    return np.stack([key // f, key % f], axis=1)


def _without_small(
    elements: Elements,
    rows: IntArray,
    planes: Planes,
    labels: Int32Array,
    least_count: int,
    least_area: float,
) -> Int32Array:
    """Numbered by area, the largest first; -1 for elements of facets that are too small."""
    kept = (planes.count >= least_count) | ((planes.area >= least_area) & (planes.area > 0.0))
    kept &= _looseness(elements, rows, planes, labels) <= _LOOSE
    order = np.argsort(-np.where(kept, planes.area, -1.0), kind="stable")
    # The last two stand for NONE and OUT.
    number = np.full(len(planes.area) + 2, NONE, np.int32)
    number[order[: int(kept.sum())]] = np.arange(int(kept.sum()))
    out = np.empty_like(labels)
    renumbered(labels, number, out)
    return out


def _looseness(
    elements: Elements, rows: IntArray, planes: Planes, labels: Int32Array
) -> FloatArray:
    """(f,) of the facets' neighbours in all, the share that is of no facet."""
    f = len(planes.area)
    if elements.of != "point":
        return np.zeros(f)
    source = np.repeat(labels[rows], np.diff(elements.starts)[rows])
    inside = source >= 0
    free = labels[elements.near[inside]] < 0
    own = source[inside]
    listed = labels[rows]
    # Points without a list lie amid their facet.
    amid = planes.count - np.bincount(listed[listed >= 0], minlength=f)
    full = np.bincount(own, minlength=f) + NEIGHBOURS * amid
    return np.asarray(np.bincount(own, free, f) / np.maximum(full, 1))


def _count(labels: Int32Array) -> int:
    return max(int(labels.max(initial=NONE)) + 1, 0)


def bending(elements: Elements, labels: Int32Array, angle_deg: float) -> BoolArray:
    """(f,) which of the facets, the largest first, bend and go on so into another one: pieces of a
    face that is wavy or curved. Of more than some hundred only the largest are looked at.

    The two are turned by less than the angle, but not by so little that they are parallel, and the
    facet's points turn from its middle towards the other, as those on a bend do. Beside an edge
    between planes only a few of them turn, and beside a worn edge those of the edge.
    """
    f = _count(labels)
    bent = np.zeros(f, np.bool_)
    if f < 2:
        return bent
    planes = planes_of(elements, labels)
    pairs = _touching(elements, labels, f)
    turn = _angle_deg(planes.normal[pairs[:, 0]], planes.normal[pairs[:, 1]])
    pairs = pairs[(turn > _PARALLEL_DEG) & (turn < angle_deg)]
    pairs = pairs[(pairs < _MOST_FACETS).any(axis=1)]
    ends, rows = np.zeros(f + 1, np.int64), np.empty(len(labels), np.int64)
    grouped(labels, ends, rows)
    some = [rows[a:b][:: max(1, (b - a) // _LOOKED_AT)] for a, b in pairwise(ends.tolist())]
    # Where pieces are small one neighbour may not tell it, all of them together do.
    sums = np.zeros((f, 3))
    for one, two in pairs.tolist():
        own = _turning(elements, planes, some[one], one, two)
        other = _turning(elements, planes, some[two], two, one)
        for facet, (turned, error) in ((one, own), (two, other)):
            bent[facet] |= bool(turned > _TURNING + 2.0 * np.sqrt(error))
            if 0.0 < error < np.inf:
                sums[facet] += 1.0, 1.0 / error, turned / error
    known = sums[:, 0] >= _FEWEST_BESIDE
    weight = np.where(known, sums[:, 1], 1.0)
    bent |= known & (sums[:, 2] / weight > _TURNING_ROUND + 3.0 / np.sqrt(weight))
    return np.asarray(bent)


def _turning(elements: Elements, planes: Planes, rows: IntArray, one: int, two: int) -> FloatArray:
    """What of the turn from facet one to two the points of the first (its rows) have made by the
    outer third towards the second, from the middle third on, and its variance. Normals are of wide
    surroundings, and do not tell it."""
    normal, other = planes.normal[one], planes.normal[two]
    # At right angles to the line in which the two meet, which a long facet's centre is not.
    towards = other - (other @ normal) * normal
    if towards @ (planes.centre[two] - planes.centre[one]) < 0.0:
        towards = -towards
    size, whole = float(np.linalg.norm(towards)), -float(other @ towards)
    if len(rows) < _FEWEST_TURNING or size <= 0.0 or whole == 0.0:
        return np.zeros(2)
    whole /= float(other @ normal) * size
    off = elements.places[rows] - planes.centre[one]
    place, height = off @ (towards / size), off @ normal
    inner, middle, end = np.sort(place)[(np.array(_PARTS) * len(place)).astype(np.int64)]
    slopes = [
        _slope(place[own], height[own])
        for own in ((place > middle) & (place < end), (place > inner) & (place < middle))
    ]
    return np.array(
        [(slopes[0][0] - slopes[1][0]) / whole, (slopes[0][1] + slopes[1][1]) / whole**2]
    )


def _slope(place: FloatArray, height: FloatArray) -> tuple[float, float]:
    """Of heights over places, and its variance."""
    across = place - place.mean() if len(place) else place
    square = float(across @ across)
    if len(place) < 4 or square <= 0.0:
        return 0.0, np.inf
    slope = float(across @ height) / square
    left = height - height.mean() - slope * across
    return slope, float(left @ left) / (len(place) - 2) / square


def _angle_deg(one: FloatArray, other: FloatArray) -> FloatArray:
    """(k,) between axes (k, 3), degrees."""
    return np.asarray(np.degrees(np.arccos(np.minimum(np.abs((one * other).sum(axis=1)), 1.0))))
