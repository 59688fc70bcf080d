"""What is said of one set of orientations: all its statistics in one object."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import PrintableResult
from vomstudio.geology.common_rotation_errors import Region, Turns, cone, moved, region, resultant
from vomstudio.geology.populations.distributions import (
    AxisConfidence,
    BinghamFigures,
    KentFigures,
    LineFigures,
    UniformityFigures,
    axes_confidence,
    bingham,
    fisher_p,
    kent,
    line_figures,
    uniformity,
)
from vomstudio.geology.populations.error_weights import Errors, WeightFigures, weights_of
from vomstudio.geology.statistics import (
    Fisher,
    effective_number,
    few_decide,
    fisher,
    flip_to,
    no_fisher_reason,
    orientation_tensor,
    unit_vectors,
    vollmer,
    woodcock,
)


@dataclass(frozen=True)
class FisherFigures:
    """Fisher's mean direction and statistics, as in `Fisher`.

    registration_error_deg : larger half-angle of the 95 % region by which the registrations of the
    models can turn the mean, None where none is known; it does not shrink with n. total95_deg :
    that of alpha95 and the registration together, as far as they are known. fit_p : chance of a
    scatter as unlike Fisher's law as this one, None where it was not tested
    """

    trend_deg: float
    plunge_deg: float
    kappa: float | None
    alpha95_deg: float | None
    R: float
    registration_error_deg: float | None = None
    total95_deg: float | None = None
    fit_p: float | None = None


@dataclass(frozen=True)
class TensorFigures:
    """Eigenvalues S1 >= S2 >= S3 of the orientation tensor, sum 1, and their axes. confidence95 :
    of each axis, free of a model; None where it is not defined"""

    eigenvalues: tuple[float, float, float]
    axes: tuple[LineFigures, LineFigures, LineFigures]
    confidence95: tuple[AxisConfidence | None, AxisConfidence | None, AxisConfidence | None]


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
class SetStatistics(PrintableResult):
    """What is said of one set of orientations.

    n : how many. of : "poles" of planes, or "lines". axial : a vector and its opposite are the same
    fisher : None where a mean would mislead. fisher_reason : why, or what is missing in it
    tensor, woodcock, vollmer : as in `orientation_tensor`, `woodcock`, `vollmer`
    bingham, kent, uniformity : as in `distributions`; bingham_reason, kent_reason : why they are
    None. weights : None where each counts alike
    """

    n: int
    of: str
    axial: bool
    fisher: FisherFigures | None
    fisher_reason: Finding | None
    tensor: TensorFigures
    woodcock: WoodcockFigures
    vollmer: VollmerFigures
    bingham: BinghamFigures | None
    bingham_reason: Finding | None
    kent: KentFigures | None
    kent_reason: Finding | None
    uniformity: UniformityFigures
    weights: WeightFigures | None


def mean_regions(
    vectors: npt.ArrayLike,
    found: Fisher,
    directed: bool,
    turns: Turns | None,
    weights: FloatArray | None = None,
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
        signs = np.where(v @ orientation_tensor(v, weights)[1][0] < 0.0, -1.0, 1.0)
    if weights is not None:
        signs = signs * weights
    covariance = resultant(moved(v, turns), signs).covariance()[0]
    return region(mean, covariance), None if own is None else region(mean, covariance, own)


def set_statistics(
    vectors: npt.ArrayLike,
    of: str = "poles",
    directed: bool = False,
    turns: Turns | None = None,
    errors: Errors | None = None,
) -> SetStatistics:
    """The statistics of one set.

    vectors: (n, 3), poles of planes (of="poles") or lines (of="lines"). turns: what is known of
    their registrations. errors: weight each by its own. Raises GeometryError for an empty set.
    """
    if of not in ("poles", "lines"):
        raise ValueError(of)
    v = unit_vectors(vectors)
    weights, said = (None, None) if errors is None else weights_of(v, errors)
    values, axes = orientation_tensor(v, weights)
    found, reason = _fisher_figures(v, of, directed, turns, weights)
    bingham_found, bingham_reason = bingham(v, values, axes, weights)
    kent_found, kent_reason = None, reason
    if found is not None and found.kappa is not None:
        one_way = v if directed else flip_to(v, axes[0])
        kent_found, kent_reason = kent(one_way, directed, weights)
    s1, s2, s3 = (float(s) for s in values)
    first, second, third = (line_figures(axis) for axis in axes)
    return SetStatistics(
        len(v),
        of,
        not directed,
        found,
        reason,
        TensorFigures(
            (s1, s2, s3), (first, second, third), axes_confidence(v, values, axes, weights)
        ),
        WoodcockFigures(*woodcock(values)),
        VollmerFigures(*vollmer(values)),
        bingham_found,
        bingham_reason,
        kent_found,
        kent_reason,
        uniformity(v, directed),
        said,
    )


def _fisher_figures(
    v: FloatArray, of: str, directed: bool, turns: Turns | None, weights: FloatArray | None
) -> tuple[FisherFigures | None, Finding | None]:
    """Or why there are none; or what is missing in them."""
    reason = no_fisher_reason(v, directed)
    if reason is not None:
        return None, reason
    f = fisher(v, directed, weights)
    alone, total = mean_regions(v, f, directed, turns, weights)
    mean = f.mean.vector()
    one_way = v if directed else flip_to(v, mean)
    found = FisherFigures(
        f.mean.trend_deg,
        f.mean.plunge_deg,
        f.kappa,
        f.alpha95_deg,
        f.R,
        None if alone is None else alone.largest_deg,
        None if total is None else total.largest_deg,
        fisher_p(one_way, mean, f.kappa) if weights is None else None,
    )
    if f.kappa is None:
        reason = Finding("fisher.identical")
    elif weights is not None and few_decide(weights):
        reason = Finding("fisher.few-decide", n=len(v), worth=effective_number(weights))
    elif f.alpha95_deg is None:
        reason = Finding("fisher.too-scattered")
    return found, reason
