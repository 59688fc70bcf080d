"""Two readings of the same points, held against each other by what a similarity leaves over."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.registration.similarity import fit_similarity

# Of squares, beside those of the points from their middle: less is rounding.
_ROUNDING = 1e-18
_UNKNOWNS = 7


@dataclass(frozen=True)
class Left:
    """What a fit leaves over. variance : of one coordinate; free : how many free misses it is as
    good as, fewer where one axis misses by more than the others (Satterthwaite 1946)"""

    variance: float
    free: float


def left_over(model: FloatArray, world: FloatArray, more: int = 0) -> Left | None:
    """By points of the model (n, 3) with their coordinates (n, 3); None where they leave nothing
    over, or cannot be fitted. more : unknowns beside those of the similarity"""
    freedom = 3 * len(model) - _UNKNOWNS - more
    if freedom < 1:
        return None
    local = world - world.mean(axis=0)
    try:
        fit = fit_similarity(model, local)
    except GeometryError:
        return None
    axes = ((fit(model) - local) ** 2).sum(axis=0)
    squares = float(axes.sum())
    least = _ROUNDING * float((local**2).sum())
    if squares <= least:
        return Left(max(least, 1e-300) / freedom, float(freedom))
    return Left(squares / freedom, freedom / 3.0 * squares**2 / float((axes**2).sum()))


def far_better(other: Left | None, given: Left | None, chance: float) -> bool:
    """Whether the other reading fits better than it would by chance, were the given one right."""
    from scipy.stats import f

    if other is None or given is None:
        return False
    # By the upper tail: a chance of 1e-9 taken from one loses its digits.
    return given.variance > other.variance * float(f.isf(chance, given.free, other.free))
