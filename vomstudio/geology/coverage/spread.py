"""Scatter of repeated picks of the same structure, compared with their stated errors.

Near their mean, the poles or lines of the picks of one structure are points in the tangent plane of
the sphere (logarithmic map), and a stated error is an ellipse in this plane. If a pick has an error
of sigma along each axis, its difference from a repeat has an error of sqrt(2) sigma. For k pairs,
sigma^2 is the sum of squared angles / 4k with 2k degrees of freedom, and its interval follows from
chi-square. If covariances C are stated, the weighted sum of squares about the mean of each
structure follows chi-square with 2 (m - 1) degrees of freedom for m picks; for a pair, it is d (C1
+ C2)^-1 d.

References: Dahlberg 1940, Statistical Methods for Medical and Biological Students, for errors from
pairs; Mardia and Jupp 2000, Directional Statistics, 9.3, for the tangent plane.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.geometry.rotation_errors import CHI2_TWO

MIN_VARIANCE = 1e-18
"""Minimum variance of a stated error, radians squared; smaller ones are treated as missing."""
TEST_POWER = 0.8
"""Probability with which the test must detect a factor for it to be considered noticeable."""


@dataclass(frozen=True, eq=False)
class RepeatedStructure:
    """Structure that was picked m times.

    Attributes
    ----------
    rows : (m,) ndarray of int
        Row indices of the picks.
    positions : (m, 2) ndarray
        Picks in the tangent plane at their mean, radians.
    covariances : (m, 2, 2) ndarray
        Stated covariances, radians squared; zero if no error is stated.
    """

    rows: IntArray
    positions: FloatArray
    covariances: FloatArray

    @property
    def has_stated_errors(self) -> bool:
        """Whether all picks have a stated error."""
        smallest_variances = np.linalg.eigvalsh(self.covariances)[:, 0]
        return bool((smallest_variances > MIN_VARIANCE).all())

    def squares(self) -> float:
        """Return the sum of squares about the mean, radians squared."""
        return float(((self.positions - self.positions.mean(axis=0)) ** 2).sum())

    def chi_square(self) -> float:
        """Return the sum of squares about the weighted mean, scaled by the stated covariances."""
        weights = np.linalg.inv(self.covariances)
        sums = np.einsum("mij,mj->i", weights, self.positions)
        residuals = self.positions - np.linalg.solve(weights.sum(axis=0), sums)
        return float(np.einsum("mi,mij,mj->", residuals, weights, residuals))


@dataclass(frozen=True)
class PickSpread:
    """Scatter of the picks about their structures.

    Attributes
    ----------
    n : int
        Number of repeats, each of which has two degrees of freedom.
    sigma_deg, sigma_low_deg, sigma_high_deg : float
        Standard deviation of a single pick along one axis with its 95 % interval, degrees.
    error95_deg, error95_low_deg, error95_high_deg : float
        Half-angle that contains 95 % of the picks, with its 95 % interval, degrees.
    """

    n: int
    sigma_deg: float
    sigma_low_deg: float
    sigma_high_deg: float
    error95_deg: float
    error95_low_deg: float
    error95_high_deg: float


@dataclass(frozen=True)
class StatedErrorTest:
    """Result of the test whether the stated errors explain the scatter of repeated picks.

    Attributes
    ----------
    n : int
        Number of repeats of structures whose picks all have a stated error.
    chi_square, degrees_of_freedom, p : float
        Test statistic, and p-value for the hypothesis that the errors are large enough.
    factor, factor_low, factor_high : float
        Factor by which the stated errors are too small, with its 95 % interval.
    noticeable_factor : float
        Factor that the test would detect with a probability of 80 %.
    within95, within95_share, within95_low, within95_high
        Number and share of the repeats that are within the joint 95 % region of both picks, and
        the 95 % interval of this share.
    """

    n: int
    chi_square: float
    degrees_of_freedom: int
    p: float
    factor: float
    factor_low: float
    factor_high: float
    noticeable_factor: float
    within95: int
    within95_share: float
    within95_low: float
    within95_high: float


@dataclass(frozen=True)
class InterpreterTest:
    """Result of the F test whether interpreters differ by more than their own repeats.

    Attributes
    ----------
    n, within_n : int
        Number of comparisons between interpreters, and within interpreters.
    ratio : float
        Ratio of the variances.
    p : float
        p-value for the hypothesis that interpreters do not differ.
    """

    n: int
    within_n: int
    ratio: float
    p: float


def group_structures(
    vectors: FloatArray, axes: FloatArray, groups: Sequence[Sequence[int]]
) -> list[RepeatedStructure]:
    """Group picks by structure in the tangent plane at the mean of each structure.

    Parameters
    ----------
    vectors : (n, 3) ndarray
        Axial unit vectors in the World frame.
    axes : (n, 2, 3) ndarray
        Tangent vectors with the length of one standard deviation, radians; zero if no error is
        stated.
    groups : sequence of sequence of int
        Row indices of the picks of each structure, starting with the first pick.

    Returns
    -------
    list of RepeatedStructure
    """
    return [_build_structure(vectors, axes, np.asarray(rows, np.int64)) for rows in groups]


def _build_structure(vectors: FloatArray, axes: FloatArray, rows: IntArray) -> RepeatedStructure:
    picks = vectors[rows]
    signs = np.where(picks @ picks[0] < 0.0, -1.0, 1.0)
    picks = picks * signs[:, None]
    mean = picks.sum(axis=0)
    mean /= np.linalg.norm(mean)
    frame = np.linalg.svd(mean[None])[2][1:]
    cosine = np.clip(picks @ mean, -1.0, 1.0)
    offsets = picks - cosine[:, None] * mean
    sine = np.linalg.norm(offsets, axis=1)
    angle = np.arctan2(sine, cosine)
    stretch = np.where(sine > 0.0, angle / np.maximum(sine, 1e-300), 1.0)
    # Parallel transport to the mean along the great circle.
    tangents = axes[rows] * signs[:, None, None]
    projections = (tangents @ mean) / (1.0 + cosine)[:, None]
    projected_tangents = (tangents - projections[..., None] * (picks + mean)[:, None]) @ frame.T
    return RepeatedStructure(
        rows,
        (stretch[:, None] * offsets) @ frame.T,
        np.einsum("maj,mak->mjk", projected_tangents, projected_tangents),
    )


def measure_spread(structures: Sequence[RepeatedStructure]) -> PickSpread | None:
    """Measure the scatter of repeated picks about their structures.

    Parameters
    ----------
    structures : sequence of RepeatedStructure

    Returns
    -------
    PickSpread or None
        None if there are no repeats.
    """
    return _build_pick_spread(
        sum(structure.squares() for structure in structures),
        sum(len(structure.rows) - 1 for structure in structures),
    )


def _build_pick_spread(squares: float, n: int) -> PickSpread | None:
    from scipy.stats import chi2

    if n < 1:
        return None
    degrees_of_freedom = 2 * n
    low, high = (
        squares / float(chi2.ppf(probability, degrees_of_freedom)) for probability in (0.975, 0.025)
    )
    sigmas = [float(np.degrees(np.sqrt(v))) for v in (squares / degrees_of_freedom, low, high)]
    factor95 = float(np.sqrt(CHI2_TWO))
    return PickSpread(n, *sigmas, *(factor95 * sigma for sigma in sigmas))


def check_stated_errors(structures: Sequence[RepeatedStructure]) -> StatedErrorTest | None:
    """Test whether the stated errors explain the scatter of repeated picks.

    Parameters
    ----------
    structures : sequence of RepeatedStructure

    Returns
    -------
    StatedErrorTest or None
        None if no repeated structure has a stated error for all its picks.
    """
    from scipy.stats import beta, chi2

    stated_structures = [
        structure
        for structure in structures
        if structure.has_stated_errors and len(structure.rows) > 1
    ]
    n = sum(len(stated_structure.rows) - 1 for stated_structure in stated_structures)
    if not n:
        return None
    chi_square, degrees_of_freedom = (
        sum(stated_structure.chi_square() for stated_structure in stated_structures),
        2 * n,
    )
    low, high = (
        np.sqrt(chi_square / float(chi2.ppf(q, degrees_of_freedom))) for q in (0.975, 0.025)
    )
    n_within = sum(
        int(
            sum(
                squared_difference(stated_structure, 0, k) <= CHI2_TWO
                for k in range(1, len(stated_structure.rows))
            )
        )
        for stated_structure in stated_structures
    )
    low_share = float(beta.ppf(0.025, n_within, n - n_within + 1)) if n_within else 0.0
    high_share = float(beta.ppf(0.975, n_within + 1, n - n_within)) if n_within < n else 1.0
    return StatedErrorTest(
        n,
        chi_square,
        degrees_of_freedom,
        float(chi2.sf(chi_square, degrees_of_freedom)),
        float(np.sqrt(chi_square / degrees_of_freedom)),
        float(low),
        float(high),
        float(
            np.sqrt(
                chi2.ppf(0.95, degrees_of_freedom) / chi2.ppf(1.0 - TEST_POWER, degrees_of_freedom)
            )
        ),
        n_within,
        n_within / n,
        low_share,
        high_share,
    )


def squared_difference(structure: RepeatedStructure, i: int, k: int) -> float:
    """Return the squared difference of two picks, scaled by their stated covariances.

    It follows chi-square with two degrees of freedom if the errors are correct.

    Parameters
    ----------
    structure : RepeatedStructure
    i, k : int
        Indices of the two picks in the structure.

    Returns
    -------
    float
    """
    difference = structure.positions[i] - structure.positions[k]
    return float(
        difference
        @ np.linalg.solve(structure.covariances[i] + structure.covariances[k], difference)
    )


def compare_interpreters(
    structures: Sequence[RepeatedStructure], interpreters: Sequence[str]
) -> tuple[dict[str, PickSpread], InterpreterTest | None]:
    """Measure the scatter of the repeats of each interpreter, and compare interpreters.

    The sum of squares about the mean of a structure is split into the sums about the mean of each
    interpreter and the remaining sum between interpreters.

    Parameters
    ----------
    structures : sequence of RepeatedStructure
    interpreters : sequence of str
        Interpreter of each of the n picks.

    Returns
    -------
    spreads : dict of str to PickSpread
        Scatter of the picks of each interpreter who repeated their own picks.
    test : InterpreterTest or None
        None unless some picks were repeated by the same interpreter and some by another one.
    """
    from scipy.stats import f

    squares: dict[str, float] = {}
    counts: dict[str, int] = {}
    between_squares = 0.0
    between_n = 0
    for structure in structures:
        names = np.array([interpreters[row] for row in structure.rows.tolist()], object)
        structure_interpreters = sorted(set(names.tolist()))
        between_sum = structure.squares()
        for name in structure_interpreters:
            interpreter_picks = structure.positions[names == name]
            within_squares_sum = float(
                ((interpreter_picks - interpreter_picks.mean(axis=0)) ** 2).sum()
            )
            squares[name] = squares.get(name, 0.0) + within_squares_sum
            counts[name] = counts.get(name, 0) + len(interpreter_picks) - 1
            between_sum -= within_squares_sum
        between_squares += max(between_sum, 0.0)
        between_n += len(structure_interpreters) - 1
    spreads = {
        name: spread
        for name in sorted(counts)
        if (spread := _build_pick_spread(squares[name], counts[name])) is not None
    }
    within_n, within_squares = sum(counts.values()), sum(squares.values())
    if not within_n or not between_n or not within_squares > 0.0:
        return spreads, None
    ratio = (between_squares / between_n) / (within_squares / within_n)
    return spreads, InterpreterTest(
        between_n, within_n, ratio, float(f.sf(ratio, 2 * between_n, 2 * within_n))
    )
