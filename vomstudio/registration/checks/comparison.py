"""Comparison of two interpretations of the same points by the residuals of a similarity."""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.registration.similarity import fit_similarity

# Share of the squared extent below which squared residuals are rounding errors.
_ROUNDING = 1e-18
_UNKNOWN_COUNT = 7


@dataclass(frozen=True)
class Misfit:
    """Residuals of a fit.

    Attributes
    ----------
    variance : float
        Variance of one coordinate, m².
    degrees_of_freedom : float
        Effective redundancy, lower if one axis has larger residuals (Satterthwaite 1946).
    """

    variance: float
    degrees_of_freedom: float


def residual_misfit(model: FloatArray, world: FloatArray, extra_unknowns: int = 0) -> Misfit | None:
    """Return the residual variance of a similarity between points (n, 3).

    Parameters
    ----------
    model, world : (n, 3) array
    extra_unknowns : int
        Number of unknowns in addition to those of the similarity.

    Returns
    -------
    Misfit or None
        Misfit, or None if there is no redundancy or the fit fails.
    """
    degrees_of_freedom = 3 * len(model) - _UNKNOWN_COUNT - extra_unknowns
    if degrees_of_freedom < 1:
        return None
    local_points = world - world.mean(axis=0)
    try:
        fit = fit_similarity(model, local_points)
    except GeometryError:
        return None
    axes = ((fit(model) - local_points) ** 2).sum(axis=0)
    squares = float(axes.sum())
    min_squares = _ROUNDING * float((local_points**2).sum())
    if squares <= min_squares:
        return Misfit(max(min_squares, 1e-300) / degrees_of_freedom, float(degrees_of_freedom))
    return Misfit(
        squares / degrees_of_freedom, degrees_of_freedom / 3.0 * squares**2 / float((axes**2).sum())
    )


def is_far_better_fit(
    other_misfit: Misfit | None, reference: Misfit | None, significance: float
) -> bool:
    """Return whether another interpretation fits significantly better than the reference.

    Parameters
    ----------
    other_misfit, reference : Misfit or None
        Misfits of the other interpretation and of the reference.
    significance : float

    Returns
    -------
    bool
    """
    from scipy.stats import f

    if other_misfit is None or reference is None:
        return False
    # The upper tail preserves the digits of small probabilities.
    return reference.variance > other_misfit.variance * float(
        f.isf(significance, reference.degrees_of_freedom, other_misfit.degrees_of_freedom)
    )
