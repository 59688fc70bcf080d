"""Check for points whose values have another meaning than those of the other points.

Examples are heights in another system or unit, or columns swapped in some rows. Such rows are too
numerous to be outvoted by the others, and none of them stands out as an outlier.
"""

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
from vomstudio.registration.checks.comparison import Misfit, is_far_better_fit, residual_misfit
from vomstudio.registration.similarity import Similarity, fit_similarity

_FOOT_M = 0.3048
_MIN_POINTS, _MAX_POINTS = 5, 40
# Residual as a share of the extent below which points are not checked.
_MIN_RESIDUAL_SHARE = 0.005
_SIGNIFICANCE = 0.001
# Maximum share of the variance that remains after an explanation.
_MAX_REMAINING_VARIANCE = 0.05
_MAX_TRIPLES = 150


class MixedValues(NamedTuple):
    """Rows that require another interpretation of their values.

    `offset_m` is the offset added to their heights, or None for other kinds.
    """

    kind: str
    mask: BoolArray
    offset_m: float | None
    misfit: Misfit


def find_mixed_values(model: FloatArray, world: FloatArray) -> MixedValues | None:
    """Find rows of points that fit far better under another interpretation of their values.

    Parameters
    ----------
    model, world : (n, 3) ndarray

    Returns
    -------
    MixedValues or None
        Rows, or None if no rows fit far better.
    """
    n = len(model)
    misfit = residual_misfit(model, world) if _MIN_POINTS <= n <= _MAX_POINTS else None
    if misfit is None:
        return None
    squared_extent = float(((world - world.mean(axis=0)) ** 2).sum()) / n
    if 3.0 * misfit.variance < _MIN_RESIDUAL_SHARE**2 * squared_extent:
        return None
    fits = list(_fit_triples(model, world))
    best_mixture: MixedValues | None = None
    for kind, changed_coordinates in (
        ("feet", world * [1.0, 1.0, _FOOT_M]),
        ("exchanged", world[:, [1, 0, 2]]),
        ("offset", None),
    ):
        candidate = _best_division(kind, fits, model, world, changed_coordinates)
        if candidate is not None and (
            best_mixture is None or candidate.misfit.variance < best_mixture.misfit.variance
        ):
            best_mixture = candidate
    # Each division of the points into two groups is one of many tests.
    test_count = 3.0 * 2.0 ** (n - 1)
    if (
        best_mixture is None
        or best_mixture.misfit.variance > _MAX_REMAINING_VARIANCE * misfit.variance
    ):
        return None
    return (
        best_mixture
        if is_far_better_fit(best_mixture.misfit, misfit, _SIGNIFICANCE / test_count)
        else None
    )


def _best_division(
    kind: str,
    fits: Sequence[Similarity],
    model: FloatArray,
    world: FloatArray,
    changed_coordinates: FloatArray | None,
) -> MixedValues | None:
    best_division: tuple[float, BoolArray, float] | None = None
    for fit in fits:
        residuals = fit(model) - world
        squares = (residuals**2).sum(axis=1)
        if changed_coordinates is not None:
            changed_squares = ((residuals + world - changed_coordinates) ** 2).sum(axis=1)
            cost, mask, offset = (
                float(np.minimum(squares, changed_squares).sum()),
                changed_squares < squares,
                0.0,
            )
        else:
            horizontal_squares = (residuals[:, :2] ** 2).sum(axis=1)
            offsets = residuals[:, 2]
            changed_squares_by_offset = (
                horizontal_squares + (offsets[None, :] - offsets[:, None]) ** 2
            )
            costs = np.minimum(squares[None, :], changed_squares_by_offset).sum(axis=1)
            index = int(costs.argmin())
            cost, mask, offset = (
                float(costs[index]),
                changed_squares_by_offset[index] < squares,
                float(offsets[index]),
            )
        if best_division is None or cost < best_division[0]:
            best_division = cost, mask, offset
    if best_division is None:
        return None
    _, mask, offset = best_division
    count = int(mask.sum())
    if not 1 <= count < len(model) or (
        changed_coordinates is None and min(count, len(model) - count) < 2
    ):
        return None
    if changed_coordinates is None:
        return _fit_offset(model, world, mask, offset)
    misfit = residual_misfit(model, np.where(mask[:, None], changed_coordinates, world))
    return None if misfit is None else MixedValues(kind, mask, None, misfit)


def _fit_offset(
    model: FloatArray, world: FloatArray, mask: BoolArray, offset: float
) -> MixedValues | None:
    """Fit the height offset of some rows by three steps of parabolic interpolation.

    Returns None if the points are too few or the fit fails.
    """

    def misfit_at(value: float) -> Misfit | None:
        return residual_misfit(model, world + np.outer(mask, [0.0, 0.0, value]), extra_unknowns=1)

    step = max(0.05 * abs(offset), 1e-3)
    for _ in range(3):
        misfits = [misfit_at(offset + sign * step) for sign in (-1.0, 0.0, 1.0)]
        if any(item is None for item in misfits):
            return None
        variance_below, middle, variance_above = (
            item.variance for item in misfits if item is not None
        )
        curvature = variance_below - 2.0 * middle + variance_above
        if not curvature > 0.0:
            break
        offset += float(
            np.clip(
                0.5 * step * (variance_below - variance_above) / curvature, -5.0 * step, 5.0 * step
            )
        )
        step *= 0.3
    misfit = misfit_at(offset)
    return None if misfit is None else MixedValues("offset", mask, offset, misfit)


def _fit_triples(model: FloatArray, world: FloatArray) -> Iterator[Similarity]:
    n = len(model)
    all_triples = itertools.combinations(range(n), 3)
    rng = np.random.default_rng(0)
    is_exhaustive = math.comb(n, 3) <= _MAX_TRIPLES
    triples = (
        all_triples
        if is_exhaustive
        else (rng.choice(n, 3, replace=False) for _ in range(_MAX_TRIPLES))
    )
    for triple in triples:
        rows = np.asarray(triple)
        try:
            yield fit_similarity(model[rows], world[rows])
        except GeometryError:
            continue


def mixed_row_findings(
    labels: Sequence[str], model: FloatArray, world: FloatArray
) -> list[Finding]:
    """Return a finding if some points are in another unit or column order than the others.

    Parameters
    ----------
    labels : sequence of str
    model, world : (n, 3) ndarray

    Returns
    -------
    list of Finding
    """
    mixed_values = find_mixed_values(model, world)
    if mixed_values is None:
        return []
    mask, offset = mixed_values.mask, mixed_values.offset_m
    if offset is not None and 2 * mask.sum() > len(labels):
        mask, offset = ~mask, -offset
    names = [labels[int(row)] for row in np.flatnonzero(mask)]
    if offset is not None:
        return [Finding("control.height-offset", labels=names, offset_m=offset)]
    if mixed_values.kind == "feet":
        axes = tr("heights of {labels}", labels=", ".join(names))
        return [Finding("control.other-unit", axes=axes, unit=tr("feet"), factor=_FOOT_M)]
    return [Finding("control.swapped-columns", labels=names)]
