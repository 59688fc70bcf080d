"""What distributions say of a set of orientations: how concentrated, how sure, and do they fit.

The tests of uniformity are Bingham's of axes and Rayleigh's of directions, this one corrected for
small samples (Mardia & Jupp 2000, Directional Statistics, 10.4.1 and 10.7.1). Confidence of the
tensor's axes free of a model is that of Prentice (1984, Biometrika 71, 361-365; Fisher, Lewis &
Embleton 1987, 6.3.1); that of Bingham's model is Bingham's (1974), sigma_ij^2 =
1 / (2 n (Si - Sj) (ki - kj)), as Tanaka (1999) corrected the factor which is often quoted. All of
them are ellipses of direction cosines (Anderson 1963, Annals of Mathematical Statistics 34,
122-148), joint, 95 %, with F(2, n - 2) in place of chi-square (free of a model F(2, m - 2) for the
first axis and F(2, m - 3) for the others, m being the effective number of weighted axes, and
residuals of the jackknife: simulated coverage of clusters and girdles is 93 to 98 %). Where two
eigenvalues may be the same, the axes may be any two of a plane, and have no region: by the test of
rotational symmetry (Fisher, Lewis & Embleton 1987, 6.3.1) and by their ratio (F), which few axes of
a narrow girdle show better.
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
    FEW_FOR_FIT,
    Bingham,
    bingham_fit,
    bingham_of,
    fisher_fit,
    kent_fit,
    kent_of,
)
from vomstudio.geology.statistics import effective_number

_MOST_SHARE = 0.9

APART_P, APART_RATIO_P = 0.05, 0.005
"""Below this two eigenvalues are not the same: by their difference, and by their ratio, whose test
is of axes that stray normally."""

FEW_FOR_KENT = 12
"""Fewer directions are seldom shown to be elongated, and those that are happen to lie in a line:
the region of their mean, which is then too narrow across it, would hold two of three means only."""

ELONGATED_P = 0.05
"""Below this a cluster is called elongated, and Kent's distribution is given."""


@dataclass(frozen=True)
class LineFigures:
    """An axis: trend in [0, 360), plunge downward, degrees."""

    trend_deg: float
    plunge_deg: float


@dataclass(frozen=True)
class AxisConfidence:
    """Semi-axes of the joint 95 % region of an axis, degrees, and the direction of the larger."""

    max_deg: float
    min_deg: float
    toward: LineFigures


@dataclass(frozen=True)
class BinghamFigures:
    """Bingham's distribution: concentrations k1 <= k2 <= 0 along the tensor's third and second
    axis (the first has 0); the 95 % regions of the three axes under it, None of a weighted set;
    fit_p : chance of a scatter as unlike it as this one, None where it was not tested."""

    k1: float
    k2: float
    confidence95: tuple[AxisConfidence | None, AxisConfidence | None, AxisConfidence | None]
    fit_p: float | None


@dataclass(frozen=True)
class KentFigures:
    """Kent's distribution of an elongated cluster: its mean, the direction in which it is longest,
    kappa and beta, the semi-axes of the joint 95 % ellipse of the mean (the larger along `major`).
    elongated_p : chance of a round cluster as long as this one; fit_p : as in `BinghamFigures`."""

    trend_deg: float
    plunge_deg: float
    kappa: float
    beta: float
    major: LineFigures
    max_confidence95_deg: float
    min_confidence95_deg: float
    elongated_p: float
    fit_p: float | None


@dataclass(frozen=True)
class UniformityFigures:
    """test : "Bingham" of axes, "Rayleigh" of directions; p : chance of so uneven a scatter where
    no orientation is preferred, None of fewer than 5."""

    test: str
    statistic: float
    degrees_of_freedom: int
    p: float | None


def line_figures(vector: FloatArray) -> LineFigures:
    """Of a vector (3,), taken as an axis."""
    line = Line.from_vector(vector)
    return LineFigures(line.trend_deg, line.plunge_deg)


def f95(bottom: float) -> float:
    """The 95 % point of F with (2, bottom) degrees of freedom, which has a closed form."""
    return bottom / 2.0 * math.expm1(2.0 / bottom * math.log(20.0))


def uniformity(v: FloatArray, directed: bool) -> UniformityFigures:
    """Of unit vectors (n, 3)."""
    n = len(v)
    if directed:
        raw = 3.0 * n * float(np.sum(v.mean(axis=0) ** 2))
        statistic = (1.0 - 0.5 / n) * raw + raw**2 / (10.0 * n)
        free, name = 3, "Rayleigh"
    else:
        tensor = v.T @ v / n
        statistic = 7.5 * n * (float(np.sum(tensor**2)) - 1.0 / 3.0)
        free, name = 5, "Bingham"
    p = chi2_tail(free, statistic) if n >= 5 else None
    return UniformityFigures(name, statistic, free, p)


def axes_confidence(
    v: FloatArray, values: FloatArray, axes: FloatArray, weights: FloatArray | None = None
) -> tuple[AxisConfidence | None, AxisConfidence | None, AxisConfidence | None]:
    """Of the tensor's axes, from the data alone (n, 3): None of fewer than 5, and of an axis whose
    eigenvalue may be that of another."""
    n = len(v)
    w = np.ones(n) if weights is None else weights / weights.mean()
    along = v @ axes.T

    def of(i: int) -> AxisConfidence | None:
        j, k = (other for other in range(3) if other != i)
        if n < 5 or not all(_is_apart(values, along, i, other, w) for other in (j, k)):
            return None
        apart = np.array([values[i] - values[j], values[i] - values[k]])
        pull = along[:, [i]] * along[:, [j, k]] / apart * w[:, None]
        # Each by as much as the axis would be off without it: what has a large share in it shows
        # less of its error (MacKinnon & White 1985, Journal of Econometrics 29, 305).
        share = w[:, None] * (along[:, [i]] ** 2 - along[:, [j, k]] ** 2) / apart / n
        pull = pull / (1.0 - np.clip(share, -_MOST_SHARE, _MOST_SHARE))
        free = max(effective_number(w) - (2.0 if i == 0 else 3.0), 1.0)
        return _confidence(pull.T @ pull / n**2, axes[[j, k]], free)

    return of(0), of(1), of(2)


def _is_apart(values: FloatArray, along: FloatArray, i: int, j: int, weights: FloatArray) -> bool:
    """Whether the eigenvalues i and j differ by more than chance."""
    large, small = max(values[i], values[j]), max(min(values[i], values[j]), 0.0)
    if large - small < 1e-12:
        return False
    length = np.average((along[:, i] ** 2 + along[:, j] ** 2) ** 2, weights=weights)
    if math.exp(-effective_number(weights) * (large - small) ** 2 / length) < APART_P:
        return True
    free = len(along) - 1.0
    return small == 0.0 or f_tail(free, free, large / small) < APART_RATIO_P


def _confidence(covariance: FloatArray, across: FloatArray, free: float) -> AxisConfidence | None:
    """Of a covariance (2, 2), radians squared, with so many degrees of freedom, along two axes
    (2, 3)."""
    squares, turns = np.linalg.eigh(covariance)
    reach = np.sqrt(np.maximum(squares, 0.0) * 2.0 * f95(free))
    # The quadratic form is one of direction cosines (Anderson 1963), that is of sines: where it
    # reaches 1, the axis may point anywhere along that way.
    small, large = np.degrees(np.arcsin(np.minimum(reach, 1.0))).tolist()
    return AxisConfidence(large, small, line_figures(turns[:, 1] @ across))


def bingham(
    v: FloatArray, values: FloatArray, axes: FloatArray, weights: FloatArray | None = None
) -> tuple[BinghamFigures | None, Finding | None]:
    """Of axes (n, 3) with their tensor; or why there is none."""
    n = len(v)
    if n < 4:
        return None, Finding("bingham.too-few", n=n, minimum=4)
    model = bingham_of(values)
    if model is None:
        return None, Finding("bingham.no-scatter")
    if weights is not None:
        # What is known of the axes of a weighted set is not Bingham's, of axes that stray alike.
        return BinghamFigures(model.k1, model.k2, (None, None, None), None), None
    fit = None if n < FEW_FOR_FIT else bingham_fit(model, v @ axes.T)
    return BinghamFigures(
        model.k1, model.k2, _bingham_confidence(model, v, values, axes), fit
    ), None


def _bingham_confidence(
    model: Bingham, v: FloatArray, values: FloatArray, axes: FloatArray
) -> tuple[AxisConfidence | None, AxisConfidence | None, AxisConfidence | None]:
    k = np.array([0.0, model.k2, model.k1])
    n, along = len(v), v @ axes.T
    weights = np.ones(n)

    def of(i: int) -> AxisConfidence | None:
        others = [j for j in range(3) if j != i]
        apart = np.array([(values[i] - values[j]) * (k[i] - k[j]) for j in others])
        if n < 5 or float(apart.min()) < 1e-12:
            return None
        if not all(_is_apart(values, along, i, j, weights) for j in others):
            return None
        return _confidence(np.diag(1.0 / (2.0 * (n - 2.0) * apart)), axes[others], n - 2.0)

    return of(0), of(1), of(2)


def fisher_p(v: FloatArray, mean: FloatArray, kappa: float | None) -> float | None:
    """Chance of a scatter of directions (n, 3) as unlike Fisher's law as this one; None of few, and
    of those that are all the same or hardly clustered."""
    if kappa is None or kappa < 5.0 or len(v) < FEW_FOR_FIT:
        return None
    return fisher_fit(kappa, v @ _about(mean).T)


def kent(
    v: FloatArray, directed: bool, weights: FloatArray | None = None
) -> tuple[KentFigures | None, Finding | None]:
    """Of a cluster of directions (n, 3), axes turned to one side; or why there is none."""
    n = len(v)
    if n < FEW_FOR_KENT:
        return None, Finding("kent.too-few", n=n, minimum=FEW_FOR_KENT)
    if weights is not None:
        return None, Finding("kent.weighted")
    model = kent_of(v)
    if model is None:
        return None, Finding("kent.not-clustered", minimum=5)
    x = v @ model.axes.T
    squares = np.mean(x[:, 1:] ** 2, axis=0)
    resultant = float(x[:, 0].mean())
    p = _elongated_p(n, 1.0 / (1.0 - resultant), float(squares[0] - squares[1]))
    if p >= ELONGATED_P:
        return None, Finding("kent.round", p=p)
    # Kent's (1982) region of the mean, in the form of Hotelling.
    reach = np.sqrt(squares * 2.0 * f95(n - 2.0) / (n - 2.0)) / resultant
    largest, smallest = np.degrees(np.arcsin(np.minimum(reach, 1.0))).tolist()
    mean = Line.from_vector(model.axes[0], directed=directed)
    return KentFigures(
        mean.trend_deg,
        mean.plunge_deg,
        model.kappa,
        model.beta,
        line_figures(model.axes[1]),
        largest,
        smallest,
        p,
        None if n < FEW_FOR_FIT else kent_fit(model, x),
    ), None


def _elongated_p(n: int, kappa: float, longer: float) -> float:
    """Kent's (1982) test of a round cluster: n (kappa/2)^2 I(1/2) / I(5/2) (kappa) longer^2 is
    chi-square with 2 degrees of freedom; longer: the mean square along less that across."""
    # I(5/2) / I(1/2) in closed form.
    ratio = 1.0 / (1.0 + 3.0 / kappa**2 - 3.0 / (kappa * math.tanh(kappa)))
    return chi2_tail(2, n * (kappa / 2.0) ** 2 * ratio * longer**2)


def _about(mean: FloatArray) -> FloatArray:
    """(3, 3) rows: the mean and two directions across it."""
    first = np.cross(mean, np.eye(3)[int(np.argmin(np.abs(mean)))])
    first /= np.linalg.norm(first)
    return np.array([mean, first, np.cross(mean, first)])
