"""Bend of a whole face, which makes its plane only a local attitude.

A face with a roughness wavelength as long as the face itself is part of a wave. Its plane may have
a small error, but the attitude of the surface over several of these faces differs from it by an
angle as large as the bend of the face. The bend is measured by a quadratic surface through the
means of equal cells, which explains little of any shorter roughness.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vomstudio.geometry.patches import equal_cells

MAX_POINTS = 6_000
CELLS_PER_SIDE, MIN_CELLS, POINTS_PER_CELL = 6, 4, 4
SIGNIFICANCE = 0.01
MIN_EXPLAINED_SHARE = 0.4
"""Minimum share of the scatter of the cell means about the plane that the quadratic surface
explains.
"""
DISC_WIDTH_SIGMA = 4.0
"""Diameter of a disc of uniform points in standard deviations."""


def measure_bend(points: npt.ArrayLike, normal: npt.ArrayLike) -> float | None:
    """Measure the difference in attitude between opposite edges of a face.

    Parameters
    ----------
    points : (n, 3) array_like
        Points of the face, in any frame. If there are more than 6,000, a regular sample is used.
    normal : (3,) array_like
        Normal of its plane.

    Returns
    -------
    float or None
        Degrees, in the direction of the maximum bend. None if the bend is not significant at 1 %,
        if most of the relief is shorter roughness, or if there are too few points.
    """
    from scipy.special import fdtrc

    xyz = np.asarray(points, np.float64).reshape(-1, 3)
    xyz = xyz[:: max(1, -(-len(xyz) // MAX_POINTS))]
    cells_per_side = min(CELLS_PER_SIDE, int(np.sqrt(len(xyz) / POINTS_PER_CELL)))
    n = np.asarray(normal, np.float64)
    if cells_per_side < MIN_CELLS or not np.isfinite(n).all():
        return None
    local_points = xyz - xyz.mean(axis=0)
    plane_coordinates, h = local_points @ np.linalg.svd(n[None])[2][1:].T, local_points @ n
    v, u = (plane_coordinates @ np.linalg.eigh(plane_coordinates.T @ plane_coordinates)[1]).T
    cell = equal_cells(u, v, cells_per_side)
    count = np.bincount(cell)
    a, b, mean = (np.bincount(cell, x) / count for x in (u, v, h))
    sigma_u, sigma_v = float(a.std()), float(b.std())
    if not (sigma_u > 0.0 and sigma_v > 0.0):
        return None
    a, b = a / sigma_u, b / sigma_v
    plane = np.column_stack([np.ones_like(a), a, b])
    quadratic_columns = np.column_stack([plane, a * a, a * b, b * b])
    coefficients = np.linalg.lstsq(quadratic_columns, mean, rcond=None)[0]
    plane_residuals = mean - plane @ np.linalg.lstsq(plane, mean, rcond=None)[0]
    quadratic_residuals = mean - quadratic_columns @ coefficients
    plane_squares, quadratic_squares = (
        float(plane_residuals @ plane_residuals),
        float(quadratic_residuals @ quadratic_residuals),
    )
    dof = len(mean) - quadratic_columns.shape[1]
    if (
        plane_squares - quadratic_squares < MIN_EXPLAINED_SHARE * plane_squares
        or not plane_squares > 0.0
    ):
        return None
    if (
        quadratic_squares > 0.0
        and fdtrc(3, dof, (plane_squares - quadratic_squares) / 3.0 / (quadratic_squares / dof))
        > SIGNIFICANCE
    ):
        return None
    hessian = np.array(
        [
            [2.0 * coefficients[3] / sigma_u**2, coefficients[4] / sigma_u / sigma_v],
            [coefficients[4] / sigma_u / sigma_v, 2.0 * coefficients[5] / sigma_v**2],
        ]
    )
    extent = DISC_WIDTH_SIGMA * np.diag([float(u.std()), float(v.std())])
    return float(2.0 * np.degrees(np.arctan(0.5 * np.linalg.norm(hessian @ extent, 2))))
