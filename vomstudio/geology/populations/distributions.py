"""Distributions of a set of orientations: concentration, confidence and goodness of fit.

Uniformity is tested by Bingham's test for axes and Rayleigh's test for directions, corrected for
small samples (Mardia & Jupp 2000, Directional Statistics, 10.4.1 and 10.7.1). The model-free
confidence regions of the axes of the tensor follow Prentice (1984, Biometrika 71, 361-365; Fisher,
Lewis & Embleton 1987, 6.3.1). The model-based regions follow Bingham (1974), sigma_ij^2 = 1 / (2 n
(Si - Sj) (ki - kj)), with the common factor corrected by Tanaka (1999). All regions are joint 95 %
ellipses of direction cosines (Anderson 1963, Annals of Mathematical Statistics 34, 122-148), with
F(2, n - 2) in place of chi-square. The model-free regions use F(2, m - 2) for the first axis and
F(2, m - 3) for the others, where m is the effective number of weighted axes, and jackknife
residuals; the simulated coverage for clusters and girdles is 93 to 98 %. If two eigenvalues may be
equal, the axes may be any two directions of a plane and have no region. This is decided by the test
of rotational symmetry (Fisher, Lewis & Embleton 1987, 6.3.1) and by the ratio of the eigenvalues
(F), which is more powerful for a few axes of a narrow girdle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Line
from vomstudio.geology.populations.probabilities import chi2_tail, f_tail
from vomstudio.geology.populations.sphere_models import (
    MIN_FIT_DIRECTIONS,
    Bingham,
    bingham_p,
    estimate_bingham,
    estimate_kent,
    fisher_model_p,
    kent_p,
)
from vomstudio.geology.statistics import effective_number

MAX_LEVERAGE = 0.9

DIFFERENCE_SIGNIFICANCE, RATIO_SIGNIFICANCE = 0.05, 0.005
"""Significance levels for distinct eigenvalues, by their difference and by their ratio; the test of
the ratio assumes normal deviations.
"""

MIN_DIRECTIONS_FOR_KENT = 12
"""Minimum number of directions for Kent's distribution. Fewer directions that are significantly
elongated lie in a line by chance: the region of their mean would be too narrow across the line,
with a coverage of only two thirds.
"""

ELONGATION_SIGNIFICANCE = 0.05
"""Significance level of the elongation of a cluster at which Kent's distribution is reported."""


@dataclass(frozen=True)
class LineAttitude:
    """Axis in degrees: trend in [0, 360) and plunge (positive downward)."""

    trend_deg: float
    plunge_deg: float


@dataclass(frozen=True)
class AxisConfidence:
    """Joint 95 % confidence region of an axis.

    It consists of the semi-axes in degrees and the direction of the larger semi-axis.
    """

    max_deg: float
    min_deg: float
    toward: LineAttitude


@dataclass(frozen=True)
class BinghamFigures:
    """Fitted Bingham distribution.

    Attributes
    ----------
    k1, k2 : float
        Concentrations k1 <= k2 <= 0 along the third and second axis of the tensor; the
        concentration along the first axis is 0.
    confidence95 : tuple
        Model-based 95 % region of each of the three axes; None if undefined or for a weighted set.
    fit_p : float or None
        p-value of the goodness of fit; None if not tested.
    """

    k1: float
    k2: float
    confidence95: tuple[AxisConfidence | None, AxisConfidence | None, AxisConfidence | None]
    fit_p: float | None


@dataclass(frozen=True)
class KentFigures:
    """Kent distribution fitted to an elongated cluster.

    Attributes
    ----------
    trend_deg, plunge_deg : float
        Mean direction, degrees.
    kappa, beta : float
    major : LineAttitude
        Direction of the elongation.
    max_confidence95_deg, min_confidence95_deg : float
        Semi-axes of the joint 95 % ellipse of the mean in degrees; the larger one is along `major`.
    elongated_p : float
        p-value for the hypothesis of a round cluster.
    fit_p : float or None
        p-value of the goodness of fit; None if not tested.
    """

    trend_deg: float
    plunge_deg: float
    kappa: float
    beta: float
    major: LineAttitude
    max_confidence95_deg: float
    min_confidence95_deg: float
    elongated_p: float
    fit_p: float | None


@dataclass(frozen=True)
class UniformityTest:
    """Result of a test of uniformity: "Bingham" for axes, "Rayleigh" for directions.

    For fewer than 5 vectors, p is undefined (None).
    """

    test: str
    statistic: float
    degrees_of_freedom: int
    p: float | None


def line_attitude(vector: FloatArray) -> LineAttitude:
    """Return the trend and plunge of a vector treated as an axis.

    Parameters
    ----------
    vector : (3,) ndarray

    Returns
    -------
    LineAttitude
    """
    line = Line.from_vector(vector)
    return LineAttitude(line.trend_deg, line.plunge_deg)


def f95(denominator_dof: float) -> float:
    """Return the 95 % quantile of F(2, `denominator_dof`) in closed form.

    Parameters
    ----------
    denominator_dof : float

    Returns
    -------
    float
    """
    return denominator_dof / 2.0 * math.expm1(2.0 / denominator_dof * math.log(20.0))


def assess_uniformity(v: FloatArray, is_directed: bool) -> UniformityTest:
    """Test unit vectors for uniformity.

    Parameters
    ----------
    v : (n, 3) ndarray
    is_directed : bool
        Whether the vectors are directed rather than axial.

    Returns
    -------
    UniformityTest
    """
    n = len(v)
    if is_directed:
        rayleigh_statistic = 3.0 * n * float(np.sum(v.mean(axis=0) ** 2))
        statistic = (1.0 - 0.5 / n) * rayleigh_statistic + rayleigh_statistic**2 / (10.0 * n)
        dof, name = 3, "Rayleigh"
    else:
        tensor = v.T @ v / n
        statistic = 7.5 * n * (float(np.sum(tensor**2)) - 1.0 / 3.0)
        dof, name = 5, "Bingham"
    p = chi2_tail(dof, statistic) if n >= 5 else None
    return UniformityTest(name, statistic, dof, p)


def axes_confidence(
    v: FloatArray, eigenvalues: FloatArray, axes: FloatArray, weights: FloatArray | None = None
) -> tuple[AxisConfidence | None, AxisConfidence | None, AxisConfidence | None]:
    """Compute the model-free 95 % regions of the axes of the orientation tensor.

    Parameters
    ----------
    v : (n, 3) ndarray
        Unit vectors.
    eigenvalues : (3,) ndarray
        Eigenvalues of the orientation tensor.
    axes : (3, 3) ndarray
        Eigenvectors of the orientation tensor as rows.
    weights : (n,) ndarray, optional

    Returns
    -------
    tuple of AxisConfidence or None
        None if there are fewer than 5 vectors, or if the eigenvalue may be equal to another one.
    """
    n = len(v)
    w = np.ones(n) if weights is None else weights / weights.mean()
    projections = v @ axes.T

    def axis_confidence(i: int) -> AxisConfidence | None:
        j, k = (axis_index for axis_index in range(3) if axis_index != i)
        if n < 5 or not all(
            _are_distinct(eigenvalues, projections, i, axis_index, w) for axis_index in (j, k)
        ):
            return None
        differences = np.array([eigenvalues[i] - eigenvalues[j], eigenvalues[i] - eigenvalues[k]])
        influence = projections[:, [i]] * projections[:, [j, k]] / differences * w[:, None]
        # Use jackknife residuals, because vectors with a large leverage have smaller residuals
        # (MacKinnon & White 1985, Journal of Econometrics 29, 305).
        leverage = (
            w[:, None] * (projections[:, [i]] ** 2 - projections[:, [j, k]] ** 2) / differences / n
        )
        influence = influence / (1.0 - np.clip(leverage, -MAX_LEVERAGE, MAX_LEVERAGE))
        dof = max(effective_number(w) - (2.0 if i == 0 else 3.0), 1.0)
        return _build_axis_confidence(influence.T @ influence / n**2, axes[[j, k]], dof)

    return axis_confidence(0), axis_confidence(1), axis_confidence(2)


def _are_distinct(
    eigenvalues: FloatArray, axis_cosines: FloatArray, i: int, j: int, weights: FloatArray
) -> bool:
    """Return whether eigenvalues i and j differ significantly."""
    larger_eigenvalue, smaller_eigenvalue = (
        max(eigenvalues[i], eigenvalues[j]),
        max(min(eigenvalues[i], eigenvalues[j]), 0.0),
    )
    if larger_eigenvalue - smaller_eigenvalue < 1e-12:
        return False
    length = np.average((axis_cosines[:, i] ** 2 + axis_cosines[:, j] ** 2) ** 2, weights=weights)
    if (
        math.exp(
            -effective_number(weights) * (larger_eigenvalue - smaller_eigenvalue) ** 2 / length
        )
        < DIFFERENCE_SIGNIFICANCE
    ):
        return True
    dof = len(axis_cosines) - 1.0
    return (
        smaller_eigenvalue == 0.0
        or f_tail(dof, dof, larger_eigenvalue / smaller_eigenvalue) < RATIO_SIGNIFICANCE
    )


def _build_axis_confidence(
    covariance: FloatArray, basis: FloatArray, degrees_of_freedom: float
) -> AxisConfidence | None:
    """Return the region of a covariance (2, 2) along two axes (2, 3), radians squared."""
    squares, directions = np.linalg.eigh(covariance)
    sines = np.sqrt(np.maximum(squares, 0.0) * 2.0 * f95(degrees_of_freedom))
    # The quadratic form applies to direction cosines (Anderson 1963), that is, to sines: if it
    # exceeds 1, the axis is undetermined in that direction.
    minor_deg, major_deg = np.degrees(np.arcsin(np.minimum(sines, 1.0))).tolist()
    return AxisConfidence(major_deg, minor_deg, line_attitude(directions[:, 1] @ basis))


def fit_bingham(
    v: FloatArray, eigenvalues: FloatArray, axes: FloatArray, weights: FloatArray | None = None
) -> tuple[BinghamFigures | None, Finding | None]:
    """Fit a Bingham distribution to axes (n, 3) with a given orientation tensor.

    Returns
    -------
    figures : BinghamFigures or None
    finding : Finding or None
        Reason if the distribution was not fitted.
    """
    n = len(v)
    if n < 4:
        return None, Finding("bingham.too-few", n=n, minimum=4)
    model = estimate_bingham(eigenvalues)
    if model is None:
        return None, Finding("bingham.no-scatter")
    if weights is not None:
        # Bingham's regions assume equal scatter and do not apply to a weighted set.
        return BinghamFigures(model.k1, model.k2, (None, None, None), None), None
    fit_p = None if n < MIN_FIT_DIRECTIONS else bingham_p(model, v @ axes.T)
    return BinghamFigures(
        model.k1, model.k2, _bingham_confidence(model, v, eigenvalues, axes), fit_p
    ), None


def _bingham_confidence(
    model: Bingham, v: FloatArray, eigenvalues: FloatArray, axes: FloatArray
) -> tuple[AxisConfidence | None, AxisConfidence | None, AxisConfidence | None]:
    k = np.array([0.0, model.k2, model.k1])
    n, projections = len(v), v @ axes.T
    weights = np.ones(n)

    def axis_confidence(i: int) -> AxisConfidence | None:
        other_axes = [j for j in range(3) if j != i]
        products = np.array([(eigenvalues[i] - eigenvalues[j]) * (k[i] - k[j]) for j in other_axes])
        if n < 5 or float(products.min()) < 1e-12:
            return None
        if not all(_are_distinct(eigenvalues, projections, i, j, weights) for j in other_axes):
            return None
        return _build_axis_confidence(
            np.diag(1.0 / (2.0 * (n - 2.0) * products)), axes[other_axes], n - 2.0
        )

    return axis_confidence(0), axis_confidence(1), axis_confidence(2)


def fisher_p(v: FloatArray, mean: FloatArray, kappa: float | None) -> float | None:
    """Return the goodness-of-fit p-value of the Fisher distribution for directions.

    Parameters
    ----------
    v : (n, 3) ndarray
        Unit vectors.
    mean : (3,) ndarray
        Mean direction.
    kappa : float or None
        Concentration.

    Returns
    -------
    float or None
        None if there are too few directions, or if they are identical or weakly clustered.
    """
    if kappa is None or kappa < 5.0 or len(v) < MIN_FIT_DIRECTIONS:
        return None
    return fisher_model_p(kappa, v @ _frame_around_mean(mean).T)


def fit_kent(
    v: FloatArray, is_directed: bool, weights: FloatArray | None = None
) -> tuple[KentFigures | None, Finding | None]:
    """Fit a Kent distribution to a cluster of directions.

    Parameters
    ----------
    v : (n, 3) ndarray
        Unit vectors; axes must be flipped into one hemisphere.
    is_directed : bool
        Whether the vectors are directed rather than axial.
    weights : (n,) ndarray, optional

    Returns
    -------
    figures : KentFigures or None
    finding : Finding or None
        Reason if the distribution was not fitted.
    """
    n = len(v)
    if n < MIN_DIRECTIONS_FOR_KENT:
        return None, Finding("kent.too-few", n=n, minimum=MIN_DIRECTIONS_FOR_KENT)
    if weights is not None:
        return None, Finding("kent.weighted")
    model = estimate_kent(v)
    if model is None:
        return None, Finding("kent.not-clustered", minimum=5)
    x = v @ model.axes.T
    squares = np.mean(x[:, 1:] ** 2, axis=0)
    resultant = float(x[:, 0].mean())
    p = _elongation_p(n, 1.0 / (1.0 - resultant), float(squares[0] - squares[1]))
    if p >= ELONGATION_SIGNIFICANCE:
        return None, Finding("kent.round", p=p)
    # Kent's (1982) confidence region of the mean, in Hotelling's form.
    sines = np.sqrt(squares * 2.0 * f95(n - 2.0) / (n - 2.0)) / resultant
    major_deg, minor_deg = np.degrees(np.arcsin(np.minimum(sines, 1.0))).tolist()
    mean = Line.from_vector(model.axes[0], is_directed=is_directed)
    return KentFigures(
        mean.trend_deg,
        mean.plunge_deg,
        model.kappa,
        model.beta,
        line_attitude(model.axes[1]),
        major_deg,
        minor_deg,
        p,
        None if n < MIN_FIT_DIRECTIONS else kent_p(model, x),
    ), None


def _elongation_p(n: int, kappa: float, square_difference: float) -> float:
    """Return the p-value of Kent's (1982) test for a round cluster.

    n (kappa/2)^2 I(1/2) / I(5/2) (kappa) d^2 follows a chi-square distribution with 2 degrees of
    freedom, where d is the difference between the mean squares along and across the cluster.
    """
    # I(5/2) / I(1/2) in closed form.
    ratio = 1.0 / (1.0 + 3.0 / kappa**2 - 3.0 / (kappa * math.tanh(kappa)))
    return chi2_tail(2, n * (kappa / 2.0) ** 2 * ratio * square_difference**2)


def _frame_around_mean(mean: FloatArray) -> FloatArray:
    """Return the mean and two directions perpendicular to it as the rows of a matrix (3, 3)."""
    first_axis = np.cross(mean, np.eye(3)[int(np.argmin(np.abs(mean)))])
    first_axis /= np.linalg.norm(first_axis)
    return np.array([mean, first_axis, np.cross(mean, first_axis)])
