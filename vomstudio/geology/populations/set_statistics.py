"""Statistics of a single set of orientations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import PrintableResult
from vomstudio.geology.common_rotation_errors import (
    ConfidenceRegion,
    RotationErrors,
    cone,
    differentiate_vectors,
    region,
    resultant,
)
from vomstudio.geology.populations.distributions import (
    AxisConfidence,
    BinghamFigures,
    KentFigures,
    LineAttitude,
    UniformityTest,
    assess_uniformity,
    axes_confidence,
    fisher_p,
    fit_bingham,
    fit_kent,
    line_attitude,
)
from vomstudio.geology.populations.error_weights import (
    OrientationErrors,
    WeightFigures,
    weights_by_error,
)
from vomstudio.geology.statistics import (
    Fisher,
    effective_number,
    fisher,
    flip_to_hemisphere,
    has_dominant_weights,
    no_fisher_reason,
    orientation_tensor,
    unit_vectors,
    vollmer,
    woodcock,
)


@dataclass(frozen=True)
class FisherFigures:
    """Fisher's mean direction and statistics. See `Fisher`.

    Attributes
    ----------
    registration_error_deg : float or None
        Larger half-angle of the 95 % region of the mean due to the registrations, degrees; None if
        unknown. It does not decrease with n.
    total95_deg : float or None
        Total of alpha95 and the registration error (if known), degrees; None if alpha95 is
        undefined.
    fit_p : float or None
        p-value of the fit of Fisher's distribution; None if not tested.
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
    """Eigenvalues S1 >= S2 >= S3 of the orientation tensor, whose sum is 1, and their axes.

    `confidence95` contains the model-free region of each axis, None if undefined.
    """

    eigenvalues: tuple[float, float, float]
    axes: tuple[LineAttitude, LineAttitude, LineAttitude]
    confidence95: tuple[AxisConfidence | None, AxisConfidence | None, AxisConfidence | None]


@dataclass(frozen=True)
class WoodcockFigures:
    """Woodcock's shape K (None if S2 = S3) and strength C (None if infinite)."""

    K: float | None
    C: float | None


@dataclass(frozen=True)
class VollmerIndices:
    """Vollmer's point, girdle and random indices, whose sum is 1."""

    P: float
    G: float
    R: float


@dataclass(frozen=True, repr=False)
class SetStatistics(PrintableResult):
    """Statistics of a single set of orientations.

    Attributes
    ----------
    n : int
    of : {"poles", "lines"}
    axial : bool
        True if a vector and its opposite are equivalent.
    fisher : FisherFigures or None
        None if a mean would be misleading.
    fisher_reason : Finding or None
        Reason why `fisher`, or some of its figures, are missing.
    bingham_reason, kent_reason : Finding or None
        Reasons why these distributions are missing.
    weights : WeightFigures or None
        None if all weights are equal.
    """

    n: int
    of: str
    axial: bool
    fisher: FisherFigures | None
    fisher_reason: Finding | None
    tensor: TensorFigures
    woodcock: WoodcockFigures
    vollmer: VollmerIndices
    bingham: BinghamFigures | None
    bingham_reason: Finding | None
    kent: KentFigures | None
    kent_reason: Finding | None
    uniformity: UniformityTest
    weights: WeightFigures | None


def mean_regions(
    vectors: npt.ArrayLike,
    fisher_mean: Fisher,
    is_directed: bool,
    rotation_errors: RotationErrors | None,
    weights: FloatArray | None = None,
) -> tuple[ConfidenceRegion | None, ConfidenceRegion | None]:
    """Compute the 95 % regions of a Fisher mean, due to the registrations and in total.

    Parameters
    ----------
    vectors : (n, 3) array_like
    fisher_mean : Fisher
    is_directed : bool
    rotation_errors : RotationErrors or None
        Errors of the registrations of the vectors.
    weights : (n,) ndarray, optional

    Returns
    -------
    registration, total : ConfidenceRegion or None
        None if unknown. If no registration error is known, the total is the region of the mean
        alone.
    """
    mean = fisher_mean.mean.vector()
    mean_region = None if fisher_mean.alpha95_deg is None else cone(mean, fisher_mean.alpha95_deg)
    if rotation_errors is None or not rotation_errors.has_known_errors:
        return None, None if mean_region is None else region(mean, None, mean_region)
    v = unit_vectors(vectors)
    signs = np.ones(len(v))
    if not is_directed:
        # Flip axes in the same way as `fisher`.
        signs = np.where(v @ orientation_tensor(v, weights)[1][0] < 0.0, -1.0, 1.0)
    if weights is not None:
        signs = signs * weights
    covariance = resultant(differentiate_vectors(v, rotation_errors), signs).covariance()[0]
    return region(mean, covariance), None if mean_region is None else region(
        mean, covariance, mean_region
    )


def set_statistics(
    vectors: npt.ArrayLike,
    of: str = "poles",
    is_directed: bool = False,
    rotation_errors: RotationErrors | None = None,
    errors: OrientationErrors | None = None,
) -> SetStatistics:
    """Compute the statistics of a set of orientations.

    Parameters
    ----------
    vectors : (n, 3) array_like
        Poles of planes, or lines.
    of : {"poles", "lines"}
    is_directed : bool
        True if the lines are directed.
    rotation_errors : RotationErrors, optional
        Errors of the registrations of the vectors.
    errors : OrientationErrors, optional
        Individual errors from which weights are computed.

    Returns
    -------
    SetStatistics

    Raises
    ------
    GeometryError
        If the set is empty.
    ValueError
        If `of` is unknown.
    """
    if of not in ("poles", "lines"):
        raise ValueError(of)
    v = unit_vectors(vectors)
    weights, weight_figures = (None, None) if errors is None else weights_by_error(v, errors)
    eigenvalues, axes = orientation_tensor(v, weights)
    fisher_figures, reason = _fisher_figures(v, is_directed, rotation_errors, weights)
    bingham_figures, bingham_reason = fit_bingham(v, eigenvalues, axes, weights)
    kent_figures, kent_reason = None, reason
    if fisher_figures is not None and fisher_figures.kappa is not None:
        aligned_vectors = v if is_directed else flip_to_hemisphere(v, axes[0])
        kent_figures, kent_reason = fit_kent(aligned_vectors, is_directed, weights)
    s1, s2, s3 = (float(value) for value in eigenvalues)
    first_line, second_line, third_line = (line_attitude(axis) for axis in axes)
    return SetStatistics(
        len(v),
        of,
        not is_directed,
        fisher_figures,
        reason,
        TensorFigures(
            (s1, s2, s3),
            (first_line, second_line, third_line),
            axes_confidence(v, eigenvalues, axes, weights),
        ),
        WoodcockFigures(*woodcock(eigenvalues)),
        VollmerIndices(*vollmer(eigenvalues)),
        bingham_figures,
        bingham_reason,
        kent_figures,
        kent_reason,
        assess_uniformity(v, is_directed),
        weight_figures,
    )


def _fisher_figures(
    v: FloatArray,
    is_directed: bool,
    rotation_errors: RotationErrors | None,
    weights: FloatArray | None,
) -> tuple[FisherFigures | None, Finding | None]:
    """Return Fisher's statistics, or None if they do not apply, and the reason."""
    reason = no_fisher_reason(v, is_directed)
    if reason is not None:
        return None, reason
    fisher_mean = fisher(v, is_directed, weights)
    registration_region, total_region = mean_regions(
        v, fisher_mean, is_directed, rotation_errors, weights
    )
    mean = fisher_mean.mean.vector()
    aligned_vectors = v if is_directed else flip_to_hemisphere(v, mean)
    figures = FisherFigures(
        fisher_mean.mean.trend_deg,
        fisher_mean.mean.plunge_deg,
        fisher_mean.kappa,
        fisher_mean.alpha95_deg,
        fisher_mean.R,
        None if registration_region is None else registration_region.largest_deg,
        None if total_region is None else total_region.largest_deg,
        fisher_p(aligned_vectors, mean, fisher_mean.kappa) if weights is None else None,
    )
    if fisher_mean.kappa is None:
        reason = Finding("fisher.identical")
    elif weights is not None and has_dominant_weights(weights):
        reason = Finding("fisher.few-decide", n=len(v), worth=effective_number(weights))
    elif fisher_mean.alpha95_deg is None:
        reason = Finding("fisher.too-scattered")
    return figures, reason
