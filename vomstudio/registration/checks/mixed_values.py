"""Some points whose values mean something else than those of the others: heights of another system
or unit, or columns exchanged in some rows alone. They are so many that the others do not outvote
them, and no single one stands out."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.registration.checks.comparison import Left, far_better, left_over
from vomstudio.registration.similarity import Similarity, fit_similarity

_FOOT_M = 0.3048
_FEWEST, _MOST = 5, 40
# Of the reach: points that fit so well are not looked into.
_FITS = 0.005
_BY_CHANCE = 0.001
# Of the variance: what explains a misfit leaves little of it.
_EXPLAINS = 0.05
_TRIPLES = 150


class Mixed(NamedTuple):
    """which : (n,) are read in another way; offset_m : added to their heights, None for others"""

    kind: str
    which: BoolArray
    offset_m: float | None
    left: Left


def mixed_values(model: FloatArray, world: FloatArray) -> Mixed | None:
    """What points of the model (n, 3) fit their coordinates (n, 3) by far better with, where some
    of these are read in another way; None where nothing does."""
    n = len(model)
    given = left_over(model, world) if _FEWEST <= n <= _MOST else None
    if given is None:
        return None
    reach = float(((world - world.mean(axis=0)) ** 2).sum()) / n
    if 3.0 * given.variance < _FITS**2 * reach:
        return None
    fits = list(_fits_of_triples(model, world))
    best: Mixed | None = None
    for kind, changed in (
        ("feet", world * [1.0, 1.0, _FOOT_M]),
        ("exchanged", world[:, [1, 0, 2]]),
        ("offset", None),
    ):
        found = _some_read_so(kind, fits, model, world, changed)
        if found is not None and (best is None or found.left.variance < best.left.variance):
            best = found
    # Any of these ways to part the points in two might have fitted by chance.
    tried = 3.0 * 2.0 ** (n - 1)
    if best is None or best.left.variance > _EXPLAINS * given.variance:
        return None
    return best if far_better(best.left, given, _BY_CHANCE / tried) else None


def _some_read_so(
    kind: str,
    fits: Sequence[Similarity],
    model: FloatArray,
    world: FloatArray,
    changed: FloatArray | None,
) -> Mixed | None:
    best: tuple[float, BoolArray, float] | None = None
    for fit in fits:
        misses = fit(model) - world
        given = (misses**2).sum(axis=1)
        if changed is not None:
            other = ((misses + world - changed) ** 2).sum(axis=1)
            cost, which, offset = float(np.minimum(given, other).sum()), other < given, 0.0
        else:
            level = (misses[:, :2] ** 2).sum(axis=1)
            offsets = misses[:, 2]
            others = level + (offsets[None, :] - offsets[:, None]) ** 2
            costs = np.minimum(given[None, :], others).sum(axis=1)
            at = int(costs.argmin())
            cost, which, offset = float(costs[at]), others[at] < given, float(offsets[at])
        if best is None or cost < best[0]:
            best = cost, which, offset
    if best is None:
        return None
    _, which, offset = best
    count = int(which.sum())
    if not 1 <= count < len(model) or (changed is None and min(count, len(model) - count) < 2):
        return None
    if changed is None:
        return _with_offset(model, world, which, offset)
    left = left_over(model, np.where(which[:, None], changed, world))
    return None if left is None else Mixed(kind, which, None, left)


def _with_offset(
    model: FloatArray, world: FloatArray, which: BoolArray, offset: float
) -> Mixed | None:
    """With the offset that leaves least over: the least of a parabola, twice."""

    def tried(value: float) -> Left | None:
        return left_over(model, world + np.outer(which, [0.0, 0.0, value]), more=1)

    step = max(0.05 * abs(offset), 1e-3)
    for _ in range(3):
        left = [tried(offset + side * step) for side in (-1.0, 0.0, 1.0)]
        if any(each is None for each in left):
            return None
        below, middle, above = (each.variance for each in left if each is not None)
        bent = below - 2.0 * middle + above
        if not bent > 0.0:
            break
        offset += float(np.clip(0.5 * step * (below - above) / bent, -5.0 * step, 5.0 * step))
        step *= 0.3
    found = tried(offset)
    return None if found is None else Mixed("offset", which, offset, found)


def _fits_of_triples(model: FloatArray, world: FloatArray) -> Iterator[Similarity]:
    n = len(model)
    every = itertools.combinations(range(n), 3)
    chance = np.random.default_rng(0)
    few = math.comb(n, 3) <= _TRIPLES
    triples = every if few else (chance.choice(n, 3, replace=False) for _ in range(_TRIPLES))
    for triple in triples:
        rows = np.asarray(triple)
        try:
            yield fit_similarity(model[rows], world[rows])
        except GeometryError:
            continue


def mixed_row_findings(
    labels: Sequence[str], model: FloatArray, world: FloatArray
) -> list[Finding]:
    """Return a finding if some points are in another unit or column order than the others."""
    mixed = mixed_values(model, world)
    if mixed is None:
        return []
    which, offset = mixed.which, mixed.offset_m
    if offset is not None and 2 * which.sum() > len(labels):
        which, offset = ~which, -offset
    names = [labels[int(row)] for row in np.flatnonzero(which)]
    if offset is not None:
        return [Finding("control.height-offset", labels=names, offset_m=offset)]
    if mixed.kind == "feet":
        axes = tr("heights of {labels}", labels=", ".join(names))
        return [Finding("control.other-unit", axes=axes, unit=tr("feet"), factor=_FOOT_M)]
    return [Finding("control.swapped-columns", labels=names)]
