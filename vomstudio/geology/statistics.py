"""Statistics of sets of orientations.

Axial data (poles, lineations, fold axes: a vector and its opposite are the same thing) are
described by the orientation tensor (1/n) sum x x^T with eigenvalues S1 >= S2 >= S3, sum 1
(Scheidegger 1965; Woodcock 1977, GSA Bulletin 88, 1231-1236); directed data by Fisher's (1953)
resultant. Axial data are never averaged by summing vectors as they come.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.errors import GeometryError
from vomstudio.geology.common_turns import Region, Turns, cone, moved, region, resultant
from vomstudio.geology.orientation import Array, Line
from vomstudio.reprs import Shown
from vomstudio.words import tr

ZERO_EIGENVALUE = 1e-20
"""S3 below this is a set that lies exactly in a plane: orientations equal to 1e-10 rad."""


def unit_vectors(vectors: npt.ArrayLike) -> Array:
    """(n, 3) unit vectors. Raises GeometryError for an empty set, zero or non-finite vectors."""
    v = np.atleast_2d(np.asarray(vectors, dtype=np.float64))
    if v.ndim != 2 or v.shape[1] != 3 or len(v) == 0:
        raise GeometryError(tr("No orientations: a set needs at least one."))
    length = np.linalg.norm(v, axis=1)
    bad = ~np.isfinite(length) | (length == 0)
    if bad.any():
        raise GeometryError(
            tr(
                "Orientation {number} of {count} is not a direction; leave it out.",
                number=int(np.argmax(bad)) + 1,
                count=len(v),
            )
        )
    return np.asarray(v / length[:, None])


def orientation_tensor(vectors: npt.ArrayLike) -> tuple[Array, Array]:
    """Eigenvalues (3,) S1 >= S2 >= S3 with sum 1, and axes (3, 3): row i is the unit eigenvector
    of S(i+1), pointing down (toward the trend in [0, 180) where horizontal).

    Computed by singular values of the vectors, which keep the digits that squaring loses: S3 of a
    set that lies in a plane comes out as 1e-32 rather than 1e-17.
    """
    v = unit_vectors(vectors)
    rows = v if len(v) >= 3 else np.vstack([v, np.zeros((3 - len(v), 3))])
    _, singular, axes = np.linalg.svd(rows, full_matrices=False)
    values = singular**2
    values = values / values.sum()
    down = np.array([Line.from_vector(axis).vector() for axis in axes])
    signs = np.sign(np.sum(down * axes, axis=1))
    return values, axes * signs[:, None]


def woodcock(eigenvalues: npt.ArrayLike) -> tuple[float | None, float | None]:
    """Woodcock's (1977) shape K = ln(S1/S2) / ln(S2/S3) and strength C = ln(S1/S3).

    K is None where S2 = S3; C is None (infinite) where S3 = 0, and K is then its limit 0.
    """
    s1, s2, s3 = (float(s) for s in np.asarray(eigenvalues, dtype=np.float64))
    if s3 < ZERO_EIGENVALUE:
        return (0.0 if s2 >= ZERO_EIGENVALUE else None), None
    flat = math.log(s2 / s3)
    shape = math.log(s1 / s2) / flat if flat > 1e-9 else None
    return shape, math.log(s1 / s3)


def vollmer(eigenvalues: npt.ArrayLike) -> tuple[float, float, float]:
    """Point, girdle and random indexes P = S1 - S2, G = 2 (S2 - S3), R = 3 S3, sum 1 (Vollmer
    1990, GSA Bulletin 102, 786-791)."""
    s1, s2, s3 = (float(s) for s in np.asarray(eigenvalues, dtype=np.float64))
    return s1 - s2, 2.0 * (s2 - s3), 3.0 * s3


def axial_mean(vectors: npt.ArrayLike) -> Line:
    """Mean of axial data: the tensor's first axis. Raises GeometryError where S1 = S2, which
    leaves no preferred axis."""
    values, axes = orientation_tensor(vectors)
    if values[0] - values[1] < 1e-12:
        raise GeometryError(tr("The orientations have no mean: they spread evenly over a plane."))
    return Line.from_vector(axes[0])


def flip_to(vectors: npt.ArrayLike, axis: npt.ArrayLike) -> Array:
    """(n, 3) the same axes, each pointing into the hemisphere of `axis`."""
    v = unit_vectors(vectors)
    return np.where((v @ np.asarray(axis, dtype=np.float64) < 0)[:, None], -v, v)


@dataclass(frozen=True)
class Fisher:
    """Fisher's (1953) statistics of n directions.

    R: length of the resultant. kappa = (n - 1) / (n - R), None where all directions are the same
    (infinite). alpha95_deg: half-angle of the cone that holds the true mean with 95 %
    (joint, exact: cos a = 1 - ((n - R) / R) (20^(1 / (n - 1)) - 1)), None where no cone does.
    """

    mean: Line
    n: int
    R: float
    kappa: float | None
    alpha95_deg: float | None


def fisher(vectors: npt.ArrayLike, directed: bool) -> Fisher:
    """Fisher's statistics of unit vectors (n, 3); axial data are first flipped into the hemisphere
    of the tensor's first axis. Whether axial data are clustered enough for that is
    `no_fisher_reason`'s question. Raises GeometryError where the resultant vanishes."""
    v = unit_vectors(vectors)
    if not directed:
        v = flip_to(v, orientation_tensor(v)[1][0])
    n = len(v)
    total = v.sum(axis=0)
    resultant = float(np.linalg.norm(total))
    if resultant < 1e-9 * n:
        raise GeometryError(tr("The directions cancel out: they have no mean."))
    mean = total / resultant
    # n - R without cancellation: each term is 1 - cos of the angle to the mean.
    lack = 0.5 * float(np.sum((v - mean) ** 2))
    same = lack < n * ZERO_EIGENVALUE
    kappa = None if n < 2 or same else (n - 1) / lack
    alpha: float | None = None
    if n >= 2:
        versine = lack / resultant * math.expm1(math.log(20.0) / (n - 1))
        if versine <= 2.0:
            # cos a = 1 - versine, in the form that keeps small angles exact
            alpha = math.degrees(2.0 * math.asin(math.sqrt(versine / 2.0)))
    return Fisher(Line.from_vector(mean, directed=directed), n, resultant, kappa, alpha)


def no_fisher_reason(vectors: npt.ArrayLike, directed: bool) -> str | None:
    """Why Fisher's statistics would mislead for this set, or None where they are sound.

    A single one; axial data that are no cluster, that is whose point index P is not the largest of
    Vollmer's three (1990): flipping and averaging a girdle or a uniform scatter has no meaning.
    Woodcock's K alone would also refuse tight clusters of an elongated shape.
    """
    v = unit_vectors(vectors)
    n = len(v)
    if n < 2:
        return tr("n = 1: a Fisher mean needs at least 2")
    if directed:
        if float(np.linalg.norm(v.sum(axis=0))) < 1e-9 * n:
            return tr("the directions cancel out: there is no mean")
        return None
    point, girdle, random = vollmer(orientation_tensor(v)[0])
    if max(girdle, random) <= point:
        return None
    numbers = tr(
        "Vollmer P = {point:.2f}, G = {girdle:.2f}, R = {random:.2f}",
        point=point,
        girdle=girdle,
        random=random,
    )
    if girdle > random:
        return tr(
            "girdle, not a cluster ({numbers}); the tensor's axes describe the set", numbers=numbers
        )
    return tr("no preferred orientation, close to a uniform scatter ({numbers})", numbers=numbers)


@dataclass(frozen=True)
class LineFigures:
    """An axis: trend in [0, 360), plunge downward, degrees."""

    trend_deg: float
    plunge_deg: float


@dataclass(frozen=True)
class FisherFigures:
    """Fisher's mean direction and statistics, as in `Fisher`.

    registration_error_deg : larger half-angle of the 95 % region by which the registrations of the
    models can turn the mean, None where none is known; it does not shrink with n. total95_deg :
    that of alpha95 and the registration together, as far as they are known
    """

    trend_deg: float
    plunge_deg: float
    kappa: float | None
    alpha95_deg: float | None
    R: float
    registration_error_deg: float | None = None
    total95_deg: float | None = None


@dataclass(frozen=True)
class TensorFigures:
    """Eigenvalues S1 >= S2 >= S3 of the orientation tensor, sum 1, and their axes."""

    eigenvalues: tuple[float, float, float]
    axes: tuple[LineFigures, LineFigures, LineFigures]


@dataclass(frozen=True)
class WoodcockFigures:
    """Shape K, None where S2 = S3, and strength C, None where infinite."""

    K: float | None
    C: float | None


@dataclass(frozen=True)
class VollmerFigures:
    """Point, girdle and random index, sum 1."""

    P: float
    G: float
    R: float


@dataclass(frozen=True, repr=False)
class SetStatistics(Shown):
    """What is said of one set of orientations.

    n : how many. of : "poles" of planes, or "lines". axial : a vector and its opposite are the same
    fisher : None where a mean would mislead. fisher_reason : why, or what is missing in it
    tensor, woodcock, vollmer : as in `orientation_tensor`, `woodcock`, `vollmer`
    """

    n: int
    of: str
    axial: bool
    fisher: FisherFigures | None
    fisher_reason: str | None
    tensor: TensorFigures
    woodcock: WoodcockFigures
    vollmer: VollmerFigures

    def as_dict(self) -> dict[str, Any]:
        """Ready for JSON: None, never NaN."""
        return asdict(self)


def mean_regions(
    vectors: npt.ArrayLike, found: Fisher, directed: bool, turns: Turns | None
) -> tuple[Region | None, Region | None]:
    """The 95 % region by which the registrations of the vectors (n, 3) can turn their Fisher mean,
    and that of mean and registration together; None where they are not known. Without an error of
    registration the second is the mean's own."""
    mean = found.mean.vector()
    own = None if found.alpha95_deg is None else cone(mean, found.alpha95_deg)
    if turns is None or not turns.known:
        return None, None if own is None else region(mean, None, own)
    v = unit_vectors(vectors)
    signs = np.ones(len(v))
    if not directed:
        # Turned round as `fisher` does.
        signs = np.where(v @ orientation_tensor(v)[1][0] < 0.0, -1.0, 1.0)
    covariance = resultant(moved(v, turns), signs).covariance()[0]
    return region(mean, covariance), None if own is None else region(mean, covariance, own)


def set_statistics(
    vectors: npt.ArrayLike,
    of: str = "poles",
    directed: bool = False,
    turns: Turns | None = None,
) -> SetStatistics:
    """The statistics of one set.

    vectors: (n, 3), poles of planes (of="poles") or lines (of="lines"). turns: what is known of
    their registrations. Raises GeometryError for an empty set.
    """
    if of not in ("poles", "lines"):
        raise ValueError(of)
    v = unit_vectors(vectors)
    values, axes = orientation_tensor(v)
    reason = no_fisher_reason(v, directed)
    found: FisherFigures | None = None
    if reason is None:
        f = fisher(v, directed)
        alone, total = mean_regions(v, f, directed, turns)
        found = FisherFigures(
            f.mean.trend_deg,
            f.mean.plunge_deg,
            f.kappa,
            f.alpha95_deg,
            f.R,
            None if alone is None else alone.largest_deg,
            None if total is None else total.largest_deg,
        )
        if f.kappa is None:
            reason = tr("all orientations are the same: kappa is infinite")
        elif f.alpha95_deg is None:
            reason = tr("too scattered: no cone holds the mean with 95 %")
    s1, s2, s3 = (float(s) for s in values)
    first, second, third = (
        LineFigures(line.trend_deg, line.plunge_deg) for line in map(Line.from_vector, axes)
    )
    return SetStatistics(
        len(v),
        of,
        not directed,
        found,
        reason,
        TensorFigures((s1, s2, s3), (first, second, third)),
        WoodcockFigures(*woodcock(values)),
        VollmerFigures(*vollmer(values)),
    )
