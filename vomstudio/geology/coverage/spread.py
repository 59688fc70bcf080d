"""How far apart picks of the same structure lie, beside the errors that they state.

Near their mean, the poles or lines of the picks of one structure are points of the plane that
touches the sphere there (logarithmic map); a stated error is an ellipse in that plane. A pick that
is wrong by sigma along each axis differs from its repeat by sqrt(2) sigma, so that k pairs give
sigma^2 = sum of squared angles / 4k with 2k degrees of freedom, and its interval from chi square.
With stated covariances C the weighted sum of squares about the mean of each structure is chi square
with 2 (m - 1) degrees of freedom for m picks, for a pair d (C1 + C2)^-1 d.

Dahlberg 1940, Statistical Methods for Medical and Biological Students, on errors from pairs; Mardia
and Jupp 2000, Directional Statistics, 9.3, on the tangent plane.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.geometry.rotation_errors import CHI2_TWO

_SMALLEST_VARIANCE = 1e-18
"""Radians squared: a stated error of nothing is none."""
NOTICED_WITH = 0.8
"""The chance with which a factor is called noticeable."""


@dataclass(frozen=True, eq=False)
class Structure:
    """One structure picked m times. rows : (m,) of the picks; places : (m, 2) in the tangent plane
    at their mean, radians; covariances : (m, 2, 2) stated, zero where none is"""

    rows: IntArray
    places: FloatArray
    covariances: FloatArray

    @property
    def stated(self) -> bool:
        """Whether all picks state an error."""
        smallest = np.linalg.eigvalsh(self.covariances)[:, 0]
        return bool((smallest > _SMALLEST_VARIANCE).all())

    def squares(self) -> float:
        """Sum of squares about the mean, radians squared."""
        return float(((self.places - self.places.mean(axis=0)) ** 2).sum())

    def chi_square(self) -> float:
        """Sum of squares about the weighted mean, in the stated covariances."""
        weights = np.linalg.inv(self.covariances)
        sums = np.einsum("mij,mj->i", weights, self.places)
        off = self.places - np.linalg.solve(weights.sum(axis=0), sums)
        return float(np.einsum("mi,mij,mj->", off, weights, off))


@dataclass(frozen=True)
class Spread:
    """n : repeats, each of two degrees of freedom; sigma_deg : of one pick along one axis, with its
    95 % interval; error95_deg : the half-angle that holds 95 % of the picks, with the same"""

    n: int
    sigma_deg: float
    sigma_low_deg: float
    sigma_high_deg: float
    error95_deg: float
    error95_low_deg: float
    error95_high_deg: float


@dataclass(frozen=True)
class HeldErrors:
    """Whether the stated errors hold. n : repeats whose picks all state one

    chi_square, degrees_of_freedom : p is the chance of as much or more where the errors hold
    factor : by which the stated errors would have to be multiplied, with its 95 % interval
    noticeable_factor : errors that are too small by this would be noticed in four cases of five
    within95 : repeats within the joint 95 % region of both picks, as a share with its 95 % interval
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
class Between:
    """Whether interpreters differ by more than each one's own repeats (F test).

    ratio : of the variances; p : the chance of as much or more where they do not differ
    """

    n: int
    within_n: int
    ratio: float
    p: float


def structures(
    vectors: FloatArray, axes: FloatArray, groups: Sequence[Sequence[int]]
) -> list[Structure]:
    """vectors : (n, 3) unit, axial, World; axes : (n, 2, 3) tangent vectors at them one standard
    deviation long, radians, zero where none is stated; groups : rows of each structure, the first
    pick first."""
    return [_structure(vectors, axes, np.asarray(rows, np.int64)) for rows in groups]


def _structure(vectors: FloatArray, axes: FloatArray, rows: IntArray) -> Structure:
    own = vectors[rows]
    signs = np.where(own @ own[0] < 0.0, -1.0, 1.0)
    own = own * signs[:, None]
    mean = own.sum(axis=0)
    mean /= np.linalg.norm(mean)
    frame = np.linalg.svd(mean[None])[2][1:]
    cosine = np.clip(own @ mean, -1.0, 1.0)
    aside = own - cosine[:, None] * mean
    sine = np.linalg.norm(aside, axis=1)
    angle = np.arctan2(sine, cosine)
    stretch = np.where(sine > 0.0, angle / np.maximum(sine, 1e-300), 1.0)
    # Along the great circle to the mean: an axis keeps its length and its angle with the way.
    tangents = axes[rows] * signs[:, None, None]
    along = (tangents @ mean) / (1.0 + cosine)[:, None]
    moved = (tangents - along[..., None] * (own + mean)[:, None]) @ frame.T
    return Structure(
        rows, (stretch[:, None] * aside) @ frame.T, np.einsum("maj,mak->mjk", moved, moved)
    )


def spread_of(found: Sequence[Structure]) -> Spread | None:
    """None without repeats."""
    return _spread(sum(s.squares() for s in found), sum(len(s.rows) - 1 for s in found))


def _spread(squares: float, n: int) -> Spread | None:
    from scipy.stats import chi2

    if n < 1:
        return None
    free = 2 * n
    low, high = (squares / float(chi2.ppf(share, free)) for share in (0.975, 0.025))
    sigmas = [float(np.degrees(np.sqrt(v))) for v in (squares / free, low, high)]
    wide = float(np.sqrt(CHI2_TWO))
    return Spread(n, *sigmas, *(wide * sigma for sigma in sigmas))


def held_errors(found: Sequence[Structure]) -> HeldErrors | None:
    """None where no repeat and its first pick both state an error."""
    from scipy.stats import beta, chi2

    own = [s for s in found if s.stated and len(s.rows) > 1]
    n = sum(len(s.rows) - 1 for s in own)
    if not n:
        return None
    total, free = sum(s.chi_square() for s in own), 2 * n
    low, high = (np.sqrt(total / float(chi2.ppf(q, free))) for q in (0.975, 0.025))
    within = sum(int(sum(apart(s, 0, k) <= CHI2_TWO for k in range(1, len(s.rows)))) for s in own)
    least = float(beta.ppf(0.025, within, n - within + 1)) if within else 0.0
    most = float(beta.ppf(0.975, within + 1, n - within)) if within < n else 1.0
    return HeldErrors(
        n,
        total,
        free,
        float(chi2.sf(total, free)),
        float(np.sqrt(total / free)),
        float(low),
        float(high),
        float(np.sqrt(chi2.ppf(0.95, free) / chi2.ppf(1.0 - NOTICED_WITH, free))),
        within,
        within / n,
        least,
        most,
    )


def apart(one: Structure, i: int, k: int) -> float:
    """Squared difference of two of its picks in their stated covariances; chi square with two
    degrees of freedom where these hold."""
    off = one.places[i] - one.places[k]
    return float(off @ np.linalg.solve(one.covariances[i] + one.covariances[k], off))


def by_interpreter(
    found: Sequence[Structure], interpreters: Sequence[str]
) -> tuple[dict[str, Spread], Between | None]:
    """What each interpreter's own repeats scatter, by name, and whether several differ by more.

    interpreters : (n,) of each pick. Of the squares about the mean of a structure, those about each
    interpreter's own mean are that one's scatter, the rest is between them. The test is None where
    nobody repeated an own pick, or nobody another's.
    """
    from scipy.stats import f

    squares: dict[str, float] = {}
    counts: dict[str, int] = {}
    between = 0.0
    between_n = 0
    for one in found:
        names = np.array([interpreters[row] for row in one.rows.tolist()], object)
        own = sorted(set(names.tolist()))
        left = one.squares()
        for name in own:
            mine = one.places[names == name]
            inside = float(((mine - mine.mean(axis=0)) ** 2).sum())
            squares[name] = squares.get(name, 0.0) + inside
            counts[name] = counts.get(name, 0) + len(mine) - 1
            left -= inside
        between += max(left, 0.0)
        between_n += len(own) - 1
    spreads = {
        name: spread
        for name in sorted(counts)
        if (spread := _spread(squares[name], counts[name])) is not None
    }
    within_n, within = sum(counts.values()), sum(squares.values())
    if not within_n or not between_n or not within > 0.0:
        return spreads, None
    ratio = (between / between_n) / (within / within_n)
    return spreads, Between(
        between_n, within_n, ratio, float(f.sf(ratio, 2 * between_n, 2 * within_n))
    )
