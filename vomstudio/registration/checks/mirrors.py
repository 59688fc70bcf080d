"""Checks for points that fit as a mirror image, and for models placed upside down.

A similarity cannot mirror. If easting and northing of points on flat ground are swapped, it rotates
the model upside down, which fits nearly as well as the correct position.
"""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.registration.checks.comparison import Misfit, is_far_better_fit, residual_misfit
from vomstudio.registration.checks.point_order import find_row_order
from vomstudio.registration.observations import Points
from vomstudio.registration.similarity import fit_robustly

_SIGNIFICANCE = 0.001
# Number of points, and residual as a share of the extent, from which outliers are considered.
_MIN_POINTS_WITH_OUTLIERS, _MIN_RESIDUAL_SHARE = 7, 0.01
_MIRROR_FACTORS = np.array([1.0, 1.0, -1.0])
_MAX_TILT_DEG = 90.0
# Tilt limit for an unknown up direction; one random frame in 130 is tilted this far.
_MAX_TILT_UNKNOWN_UP_DEG = 170.0


def fits_as_mirror(model: FloatArray, world: FloatArray) -> bool:
    """Return whether points fit far better as a mirror image, and not in another row order.

    Parameters
    ----------
    model, world : (n, 3) ndarray

    Returns
    -------
    bool
    """
    mirror_misfit, misfit = (
        residual_misfit(model * _MIRROR_FACTORS, world),
        residual_misfit(model, world),
    )
    if mirror_misfit is None or misfit is None:
        return False
    if not is_far_better_fit(mirror_misfit, misfit, _SIGNIFICANCE):
        # An outlier affects both interpretations, so compare them without it.
        return mirror_misfit.variance < misfit.variance and _inliers_fit_as_mirror(
            model, world, misfit
        )
    order = find_row_order(model, world)
    return order is None or order.misfit.variance > mirror_misfit.variance


def _inliers_fit_as_mirror(model: FloatArray, world: FloatArray, misfit: Misfit) -> bool:
    """Return whether all but a few outliers fit as a mirror image."""
    n = len(model)
    squared_extent = float(((world - world.mean(axis=0)) ** 2).sum()) / n
    if (
        n < _MIN_POINTS_WITH_OUTLIERS
        or 3.0 * misfit.variance < _MIN_RESIDUAL_SHARE**2 * squared_extent
    ):
        return False
    try:
        _, is_inlier = fit_robustly(model * _MIRROR_FACTORS, world)
    except GeometryError:
        return False
    if is_inlier.all() or int((~is_inlier).sum()) > n // 3:
        return False
    # The points were selected for the mirror image, so test at a higher significance.
    inlier_misfit, mirror_misfit = (
        residual_misfit(positions[is_inlier], world[is_inlier])
        for positions in (model, model * _MIRROR_FACTORS)
    )
    return is_far_better_fit(mirror_misfit, inlier_misfit, _SIGNIFICANCE**2)


def mirror_findings(points: Points | None) -> list[Finding]:
    """Return a finding if points fit much better as a mirror image.

    Parameters
    ----------
    points : Points or None

    Returns
    -------
    list of Finding
    """
    if points is None or not fits_as_mirror(points.model, points.world):
        return []
    return [Finding("control.swapped-columns", labels=(), points=points.name)]


def upside_down_findings(
    rotation: FloatArray, up: FloatArray | None, points: Points | None
) -> list[Finding]:
    """Return a finding if a registration rotates the model upside down.

    Parameters
    ----------
    rotation : (3, 3) array
        Rotation from the model to the World frame.
    up : (3,) array or None
        Up direction of the model, stated by its file or the user. If None, it is unknown, and the
        finding requires that the points do not exclude a mirror image.
    points : Points or None
    """
    axis = np.array([0.0, 0.0, 1.0]) if up is None else up / np.linalg.norm(up)
    tilt = float(np.degrees(np.arccos(np.clip((rotation @ axis)[2], -1.0, 1.0))))
    if up is not None:
        if tilt <= _MAX_TILT_DEG:
            return []
        return [Finding("registration.upside-down", tip_deg=tilt)]
    if tilt <= _MAX_TILT_UNKNOWN_UP_DEG or points is None or _is_mirror_excluded(points):
        return []
    return [Finding("registration.upside-down-or-mirror", tip_deg=tilt)]


def _is_mirror_excluded(points: Points) -> bool:
    """Return whether the points fit far better than their mirror image."""
    misfit = residual_misfit(points.model, points.world)
    return is_far_better_fit(
        misfit, residual_misfit(points.model * _MIRROR_FACTORS, points.world), _SIGNIFICANCE
    )
