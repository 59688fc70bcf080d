"""Fit of a model to a registered reference."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.results import HIDDEN_IN_JSON
from vomstudio.core.words import to_translate, tr
from vomstudio.registration.by_model.matching import match
from vomstudio.registration.by_model.planes import RADIUS, ModelPlanes, ReferencePlanes, thin_points
from vomstudio.registration.by_model.refining import Refinement, refine
from vomstudio.registration.by_model.subsets import JackknifeError, jackknife_error
from vomstudio.registration.similarity import Similarity
from vomstudio.registration.similarity_observation import SimilarityObservation

NAME = "reference"
FREE_PARAMETERS = {
    "slide": to_translate("a shift along the surface"),
    "turn": to_translate("a rotation"),
    "scale": to_translate("the scale"),
}
"""Names of undetermined parameters."""
_CAPTURE_SHARE = 0.05
"""Initial maximum distance of correspondences, as a share of the diagonal of the reference."""
_MAX_MATCHED_POINTS = 300_000
_FIXED_SCALE_SIGMA = 1e-4
"""Relative one-sigma error that sets the weight of a fixed scale."""
_MIN_OVERLAP, _PARTIAL_OVERLAP = 0.02, 0.3
_ROUNDING = 1e-6
"""Share of the model size below which residuals are rounding errors."""
_MIN_COMPONENT = 0.1
"""Minimum component of a free direction, in units of the size, that is reported."""


@dataclass(frozen=True, eq=False)
class ModelFit:
    """Fit of a model to a reference.

    Attributes
    ----------
    observation : SimilarityObservation
        The fit as an observation for the adjustment with other observations.
    places : int
        Number of used positions on the model, each the mean of the points within `radius_m`.
    overlap : float
        Share of all positions that are used.
    rms_m : float
        Robust RMS of their residuals, metres.
    blocks, block_m : int, float
        Number and size of the blocks of the jackknife.
    free : tuple of str
        Names of the parameters that the surfaces do not determine.
    """

    observation: SimilarityObservation = field(metadata=HIDDEN_IN_JSON)
    places: int
    radius_m: float
    overlap: float
    rms_m: float
    blocks: int
    block_m: float
    free: tuple[str, ...]
    warnings: tuple[Finding, ...] = field(metadata=HIDDEN_IN_JSON)


def fit_to_reference(
    model: FloatArray,
    reference: FloatArray,
    start: Similarity,
    *,
    spacing: tuple[float, float],
    include_scale: bool,
    stable: BoolArray | None = None,
    scale_error: float | None = None,
    progress: Progress | None = None,
) -> ModelFit:
    """Fit a model to a reference by ICP, and refine all parameters with jackknife errors.

    Parameters
    ----------
    model : (n, 3) array
        Points in the model frame.
    reference : (m, 3) array
        Points in the World frame, metres.
    start : Similarity
        Similarity from the model to the World frame, accurate to a twentieth of the size of the
        reference.
    spacing : (float, float)
        Point spacing of the model and of the reference, metres.
    include_scale : bool
        Whether the scale is estimated.
    stable : (m,) array of bool, optional
        Points of the reference that have not moved; by default all points.
    scale_error : float, optional
        Relative one-sigma error of a fixed scale, which is propagated to rotation and translation.
    progress : Progress, optional
        Progress indicator, which may raise Cancelled.

    Raises
    ------
    GeometryError
        If the model and the stable part of the reference do not overlap sufficiently.
    """
    progress = progress or SilentProgress()
    target = reference if stable is None else reference[stable]
    if not len(target):
        raise GeometryError(Finding("reference.nothing-stable"))
    radius = RADIUS * max(spacing)
    diagonal = float(np.linalg.norm(np.ptp(reference, axis=0)))
    max_distance = max(_CAPTURE_SHARE * diagonal, radius)
    _require_near(start(model), reference, max_distance)
    thinned_model = thin_points(model, spacing[0] / start.scale, _MAX_MATCHED_POINTS)
    fit = match(
        thinned_model,
        target,
        start,
        max_distance=max_distance,
        min_distance=radius,
        progress=progress,
    )
    target_planes = ReferencePlanes(target, radius)
    for _ in range(2 if include_scale else 1):
        # Repeat with the radius that follows from the estimated scale.
        model_planes = ModelPlanes(model, radius / fit.scale)
        refinement = refine(
            model_planes, target_planes, fit, include_scale=include_scale, progress=progress
        )
        fit = refinement.fit
    matched_share = len(refinement.residuals) / max(model_planes.count, 1)
    if matched_share < _MIN_OVERLAP:
        raise GeometryError(
            Finding("reference.little-overlap", share_percent=100.0 * matched_share)
        )
    jackknife = jackknife_error(refinement, radius)
    whitening = jackknife.whitening
    if not include_scale:
        scale_row = np.zeros((1, 7))
        scale_row[0, 3] = 1.0 / _FIXED_SCALE_SIGMA
        whitening = np.vstack([whitening, scale_row])
    free_parameters = _free_parameters(refinement, include_scale)
    return ModelFit(
        SimilarityObservation(
            [NAME],
            refinement.fit,
            refinement.rotation_centre,
            whitening,
            refinement.size,
            scale_error=0.0 if include_scale else scale_error or 0.0,
            scale_response=refinement.scale_response,
        ),
        len(refinement.residuals),
        radius,
        matched_share,
        refinement.sigma,
        jackknife.blocks,
        jackknife.side_m,
        free_parameters,
        tuple(_findings(refinement, jackknife, matched_share, free_parameters)),
    )


def _require_near(placed_points: FloatArray, reference: FloatArray, max_distance: float) -> None:
    from scipy.spatial import cKDTree

    step = max(1, len(placed_points) // 5000)
    thinned_reference = reference[:: max(1, len(reference) // 200_000)]
    distance, _ = cKDTree(thinned_reference).query(
        placed_points[::step], distance_upper_bound=max_distance
    )
    if np.isfinite(distance).mean() > _MIN_OVERLAP:
        return
    centre_distance = float(np.linalg.norm(placed_points.mean(axis=0) - reference.mean(axis=0)))
    raise GeometryError(Finding("reference.apart", apart_m=centre_distance))


def _free_parameters(refinement: Refinement, include_scale: bool) -> tuple[str, ...]:
    """Return the names of the undetermined parameters."""
    unknowns = 7 if include_scale else 6
    if refinement.determined_axes.shape[1] >= unknowns:
        return ()
    parameter_indices = [0, 1, 2, 4, 5, 6, *([3] if include_scale else [])]
    axes = np.linalg.svd(
        (refinement.determined_axes.T @ refinement.information)[:, parameter_indices]
    )[2]
    null_space = axes[refinement.determined_axes.shape[1] :]
    components = np.linalg.norm(null_space, axis=0)
    names = []
    if components[3:6].max() > _MIN_COMPONENT:
        names.append(tr(FREE_PARAMETERS["slide"]))
    if components[:3].max() > _MIN_COMPONENT:
        names.append(tr(FREE_PARAMETERS["turn"]))
    if include_scale and components[6] > _MIN_COMPONENT:
        names.append(tr(FREE_PARAMETERS["scale"]))
    return tuple(names)


def _findings(
    refinement: Refinement,
    jackknife: JackknifeError,
    matched_share: float,
    free_names: tuple[str, ...],
) -> list[Finding]:
    findings = []
    if free_names:
        findings.append(Finding("reference.little-relief", free=list(free_names)))
    if matched_share < _PARTIAL_OVERLAP:
        findings.append(Finding("reference.partial", share_percent=100.0 * matched_share))
    # Rounding errors are also correlated.
    if jackknife.is_correlated and refinement.sigma > _ROUNDING * refinement.size:
        findings.append(Finding("reference.bent", side_m=jackknife.side_m))
    return findings
