"""Refinement of the fit of a model to a reference by a full similarity.

Open3D's ICP is not sufficient: its point-to-plane variant has no scale, and it reports neither the
influence of each point nor the directions in which the surfaces can slide along each other.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import tr
from vomstudio.registration.by_model.planes import ModelPlanes, ReferencePlanes
from vomstudio.registration.similarity import Similarity, jacobians

_TUKEY_CONSTANT = 4.685
"""Tuning constant with 95 % efficiency for normal errors (Holland & Welsch 1977)."""
_MAD_TO_SIGMA = 1.4826
_MAX_ITERATIONS = 40
_MIN_PLACES = 60
_MIN_INFORMATION = 1e-8
"""Share of the largest eigenvalue below which information is due to rounding."""
_ROUNDING = 1e-6
"""Lower limit of sigma as a share of the radius, for identical surfaces. Smaller test shifts would
only measure the rounding of coordinates."""
_MAX_NOISE_SHARE = 0.5
"""Share of information due to noise of the normals above which a direction is undetermined."""
_TEST_SHIFT_SIGMAS = 0.3
"""Shift used to measure the response, in sigmas of the mean residual."""
_MIN_RESPONSE = 0.3
"""Minimum response of a determined direction, relative to the response by the normals."""


@dataclass(frozen=True, eq=False)
class Refinement:
    """Refined fit.

    Attributes
    ----------
    fit : Similarity
        Similarity from the model to the World frame.
    rotation_centre : (3,) array
        Mean of the used points in the World frame.
    size : float
        RMS distance of the used points from `rotation_centre`, metres.
    places : (k, 3) array
        Used points in the World frame.
    residuals : (k,) array
        Residuals of the used points along the normals of the reference, metres.
    design : (k, 7) array
        Derivatives of the residuals by the seven parameters, in units of `size`.
    influence, slope : (k,) array
        First and second derivatives of the robust loss.
    sigma : float
        Robust standard deviation of the residuals.
    determined_axes : (7, d) array
        Determined directions; see `determined_directions`.
    response : (d, d) array
        Change of the summed `influence` in the determined directions per shift along them; the
        identity for noise-free normals of flat surfaces.
    scale_response : (7,) array or None
        Change of rotation, scale and translation (m) about `rotation_centre` per relative error of
        a fixed scale, or None if the scale was fitted.
    """

    fit: Similarity
    rotation_centre: FloatArray
    size: float
    places: FloatArray
    residuals: FloatArray
    design: FloatArray
    influence: FloatArray
    slope: FloatArray
    sigma: float
    determined_axes: FloatArray
    response: FloatArray
    scale_response: FloatArray | None = None

    @property
    def information(self) -> FloatArray:
        """Information matrix (7, 7) of the parameters."""
        return np.asarray((self.design * self.slope[:, None]).T @ self.design, np.float64)


def refine(
    model: ModelPlanes,
    reference: ReferencePlanes,
    start: Similarity,
    *,
    include_scale: bool,
    progress: Progress,
) -> Refinement:
    """Refine a fit from a start within the radius of the reference.

    Parameters
    ----------
    model : ModelPlanes
    reference : ReferencePlanes
    start : Similarity
    include_scale : bool
        Whether the scale is estimated.
    progress : Progress
        Progress indicator, which may raise Cancelled.

    Raises
    ------
    GeometryError
        If the model and the reference overlap too little.
    """
    progress.stage(tr("Refining the fit"), _MAX_ITERATIONS)
    fit = start
    for iteration in range(_MAX_ITERATIONS):
        result = _linearise(model, reference, fit, include_scale)
        step = _newton_step(result)
        fit = _apply_step(fit, step, result.rotation_centre, result.size)
        progress.step(iteration + 1)
        # Stop below a hundredth of the standard error of the mean, in metres at the rim.
        if np.abs(step).max() * result.size < 0.01 * result.sigma / np.sqrt(len(result.residuals)):
            break
    result = _linearise(model, reference, fit, include_scale)
    response = _response(model, reference, result, include_scale)
    values, axes = np.linalg.eigh((response + response.T) / 2.0)
    responding_axes = axes[:, values > _MIN_RESPONSE]
    result = replace(
        result,
        determined_axes=result.determined_axes @ responding_axes,
        response=responding_axes.T @ response @ responding_axes,
    )
    if include_scale:
        return result
    return replace(result, scale_response=_scale_response(model, reference, result))


def _scale_response(
    model: ModelPlanes, reference: ReferencePlanes, result: Refinement
) -> FloatArray:
    """Compute numerically the response (7,) of a fit to a relative error of its fixed scale."""
    step = _TEST_SHIFT_SIGMAS * result.sigma / result.size
    gradients = []
    for sign in (1.0, -1.0):
        scaled_step = _apply_step(
            result.fit, sign * step * np.eye(7)[3], result.rotation_centre, result.size
        )
        shifted_result = _linearise(model, reference, scaled_step, False, result)
        gradients.append(
            result.determined_axes.T @ (shifted_result.design.T @ shifted_result.influence)
        )
    influence_change = (gradients[0] - gradients[1]) / (2.0 * step)
    change = -result.determined_axes @ np.linalg.solve(result.response, influence_change)
    change[4:] *= result.size
    change[3] = 1.0
    return np.asarray(change, np.float64)


def _response(
    model: ModelPlanes, reference: ReferencePlanes, result: Refinement, include_scale: bool
) -> FloatArray:
    """Measure `Refinement.response` (d, d) by small shifts of the model."""
    step = _TEST_SHIFT_SIGMAS * result.sigma * np.sqrt(len(result.residuals))
    columns = []
    for direction in result.determined_axes.T:
        gradients = []
        for sign in (1.0, -1.0):
            fit = _apply_step(
                result.fit, sign * step * direction, result.rotation_centre, result.size
            )
            shifted_result = _linearise(model, reference, fit, include_scale, result)
            gradients.append(
                result.determined_axes.T @ (shifted_result.design.T @ shifted_result.influence)
            )
        columns.append((gradients[0] - gradients[1]) / (2.0 * step))
    return np.column_stack(columns) if columns else np.zeros((0, 0))


def _linearise(
    model: ModelPlanes,
    reference: ReferencePlanes,
    fit: Similarity,
    include_scale: bool,
    previous: Refinement | None = None,
) -> Refinement:
    """Linearise the fit at a similarity.

    If `previous` is given, its centre, size and sigma are used.
    """
    matches = reference.match(model, fit)
    if len(matches.residuals) < _MIN_PLACES:
        raise GeometryError(Finding("reference.few-places", places=len(matches.residuals)))
    sigma = max(
        _MAD_TO_SIGMA * float(np.median(np.abs(matches.residuals))), _ROUNDING * reference.radius
    )
    if previous is not None:
        sigma = previous.sigma
    # Points with much larger residuals belong to parts that have changed.
    is_near = np.abs(matches.residuals) < _TUKEY_CONSTANT * sigma
    positions, misclosures, normal = (
        matches.places[is_near],
        matches.residuals[is_near],
        matches.normal[is_near],
    )
    centre = positions.mean(axis=0) if previous is None else previous.rotation_centre
    size = max(float(np.sqrt(((positions - centre) ** 2).sum(axis=1).mean())), 1e-9)
    if previous is not None:
        size = previous.size
    column_scales = np.array([1.0, 1.0, 1.0, 1.0, size, size, size])
    full_jacobian = jacobians(positions - centre) * column_scales
    if not include_scale:
        full_jacobian[:, :, 3] = 0.0
    design = np.einsum("nx,nxk->nk", normal, full_jacobian)
    scaled_squares = np.minimum((misclosures / (_TUKEY_CONSTANT * sigma)) ** 2, 1.0)
    influence = misclosures * (1.0 - scaled_squares) ** 2
    slope = (1.0 - scaled_squares) * (1.0 - 5.0 * scaled_squares)
    # Information that the noise of the normals alone contributes.
    weight = slope * matches.normal_variance[is_near]
    noise = np.einsum("n,nxk,nxl->kl", weight, full_jacobian, full_jacobian, optimize=True)
    noise -= (design * weight[:, None]).T @ design
    information = (design * slope[:, None]).T @ design
    directions = determined_directions(information, noise)
    return Refinement(
        fit,
        centre,
        size,
        positions,
        misclosures,
        design,
        influence,
        slope,
        sigma,
        directions,
        np.eye(directions.shape[1]),
    )


def determined_directions(information: FloatArray, noise: FloatArray) -> FloatArray:
    """Return the determined directions, scaled to unit information.

    The information in the other directions is at the level of rounding, or mostly due to noise.

    Parameters
    ----------
    information, noise : (7, 7) ndarray

    Returns
    -------
    (7, d) ndarray
    """
    values, axes = np.linalg.eigh(information)
    has_information = values > _MIN_INFORMATION * max(values[-1], 1e-300)
    scaled_axes = axes[:, has_information] / np.sqrt(values[has_information])
    fractions, rotation_of_axes = np.linalg.eigh(scaled_axes.T @ noise @ scaled_axes)
    is_signal = fractions <= _MAX_NOISE_SHARE
    return np.asarray(scaled_axes @ rotation_of_axes[:, is_signal], np.float64)


def _newton_step(result: Refinement) -> FloatArray:
    """Return the parameter change (7,) in units of the size, zero in free directions.

    The change is computed by Fisher scoring: the mean slope replaces the slope of each point, which
    is negative for distant points.
    """
    design = result.design @ result.determined_axes
    if not design.shape[1]:
        return np.zeros(7)
    weight = max(float(result.slope.mean()), 0.2)
    step = np.linalg.lstsq(weight * design.T @ design, design.T @ result.influence, rcond=1e-12)[0]
    return -np.asarray(result.determined_axes @ step, np.float64)


def _apply_step(fit: Similarity, step: FloatArray, centre: FloatArray, size: float) -> Similarity:
    from scipy.spatial.transform import Rotation

    rotation = Rotation.from_rotvec(step[:3]).as_matrix()
    scale_factor = float(np.exp(np.clip(step[3], -0.5, 0.5)))
    shift = step[4:] * size
    return Similarity(
        fit.scale * scale_factor,
        rotation @ fit.rotation,
        scale_factor * rotation @ (fit.translation - centre) + centre + shift,
    )
