"""Checks for heights that were not measured: constant heights and placeholders."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.registration.checks.comparison import is_far_better_fit, residual_misfit
from vomstudio.registration.selection import select_names
from vomstudio.registration.similarity import fit_similarity

# Heights of valid points are seldom all equal, so a low significance suffices.
_SIGNIFICANCE = 0.01
# Residuals as a share of the extent, below which other causes are possible.
_MIN_RESIDUAL_SHARE_FEW_POINTS, _MIN_RESIDUAL_SHARE = 0.003, 0.002
# Points from which an affine fit of x and y is redundant.
_MIN_POINTS_AFFINE = 5
# Placeholders of tables for missing heights.
_PLACEHOLDERS = (0.0, -9999.0, 9999.0, -99999.0, -32767.0, -32768.0)
_MIN_P_VALUE = 1e-4
# Number of unknowns of horizontal coordinates as an affine image of the model.
_AFFINE_UNKNOWN_COUNT = 8


def constant_height_findings(model: FloatArray, world: FloatArray) -> list[Finding]:
    """Return a finding if all points have the same height and this contradicts the model.

    Parameters
    ----------
    model, world : (n, 3) ndarray

    Returns
    -------
    list of Finding
    """
    if len(world) < 3 or np.ptp(world[:, 2]) > 0.0 or not _contradicts_model(model, world):
        return []
    return [Finding("control.constant-heights", height=float(world[0, 2]))]


def missing_height_findings(
    labels: Sequence[str], model: FloatArray, world: FloatArray
) -> list[Finding]:
    """Return a finding if some points have a placeholder instead of a height.

    Parameters
    ----------
    labels : sequence of str
    model, world : (n, 3) ndarray

    Returns
    -------
    list of Finding
    """
    is_placeholder = np.isin(world[:, 2], _PLACEHOLDERS)
    if not is_placeholder.any() or int((~is_placeholder).sum()) < 3:
        return []
    misfit, remaining_misfit = (
        residual_misfit(model, world),
        residual_misfit(model[~is_placeholder], world[~is_placeholder]),
    )
    if not is_far_better_fit(remaining_misfit, misfit, _MIN_P_VALUE):
        return []
    return [
        Finding(
            "control.missing-heights",
            labels=select_names(labels, is_placeholder),
            height=float(world[is_placeholder, 2][0]),
        )
    ]


def _contradicts_model(model: FloatArray, world: FloatArray) -> bool:
    n = len(world)
    local_points = world - world.mean(axis=0)
    try:
        fit = fit_similarity(model, local_points)
    except GeometryError:
        return False
    squares = float(((fit(model) - local_points) ** 2).sum())
    squared_extent = float((local_points**2).sum())
    if n < _MIN_POINTS_AFFINE:
        return squares > _MIN_RESIDUAL_SHARE_FEW_POINTS**2 * squared_extent and (
            n < 4 or _is_off_plane(model, fit.scale, squares)
        )
    if squares <= _MIN_RESIDUAL_SHARE**2 * squared_extent:
        return False
    from scipy.stats import f

    # Residuals of the points when their heights are ignored.
    design = np.column_stack([model - model.mean(axis=0), np.ones(n)])
    fitted_points = design @ np.linalg.lstsq(design, local_points[:, :2], rcond=None)[0]
    affine_squares = float(((fitted_points - local_points[:, :2]) ** 2).sum())
    dof = 2 * n - _AFFINE_UNKNOWN_COUNT
    extra_dof = 3 * n - 7 - dof
    limit = float(f.isf(_SIGNIFICANCE, extra_dof, dof))
    return (squares - affine_squares) / extra_dof > limit * max(
        affine_squares, 1e-18 * squared_extent
    ) / dof


def _is_off_plane(model: FloatArray, scale: float, squares: float) -> bool:
    """Return whether four points are far enough from a common plane to explain their misfit.

    `squares` is the sum of their squared residuals.
    """
    axes = np.linalg.svd(model - model.mean(axis=0), compute_uv=False)
    return bool((scale * axes[2]) ** 2 > 0.1 * squares)
