"""A straight line through picked points, and how well its direction is known."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.errors import GeometryError
from vomstudio.geometry.plane_errors import joint_quantile
from vomstudio.geometry.plane_limits import LARGEST, ROUNDINGS
from vomstudio.words import tr

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LineFit:
    """centroid (3,) and direction (3,), a unit vector that points down (axial), World; n points;
    length along the line and rms distance from it, m. confidence95_deg: half-angle of the joint
    95 % cone; None for two points, which leave no redundancy."""

    n: int
    centroid: Floats
    direction: Floats
    length: float
    rms: float
    confidence95_deg: float | None


def fit_line(points: npt.ArrayLike) -> LineFit:
    """The line of least squared distances through points (n, 3), World, m.

    Each point errs across the line in two directions, so the residual variance has 2 n - 4 degrees
    of freedom; with sxx the sum of squares along the line the direction is known to
    tan^2 t = 2 F(0.95; 2, 2 n - 4) s^2 / sxx, exact for equal independent errors in the limit of
    small angles. Raises GeometryError for fewer than 2 points, or all at one place.
    """
    xyz = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    n = len(xyz)
    if n < 2:
        raise GeometryError(tr("A line needs at least 2 points; pick more."))
    if not (np.abs(xyz) < LARGEST).all():
        raise GeometryError(tr("A line has coordinates that are not finite numbers; remove them."))
    local = xyz - xyz[0]
    mean = local.mean(axis=0)
    local = local - mean
    _, singular, axes = np.linalg.svd(local, full_matrices=False)
    rounding = ROUNDINGS * float(np.finfo(np.float64).eps) * float(np.abs(xyz).max())
    if singular[0] <= rounding * np.sqrt(n):
        raise GeometryError(
            tr("All points of a line are at the same place; pick them farther apart.")
        )
    direction = axes[0] if axes[0, 2] <= 0.0 else -axes[0]
    along = local @ direction
    across = float((singular[1:] ** 2).sum())
    confidence = None
    if n > 2:
        free = 2.0 * n - 4.0
        # joint_quantile is 2 F / dof, and s^2 = across / free.
        tangent = float(joint_quantile(np.array([free]))[0]) * across / float(singular[0] ** 2)
        confidence = float(np.degrees(np.arctan(np.sqrt(tangent))))
    return LineFit(
        n=n,
        centroid=xyz[0] + mean,
        direction=direction,
        length=float(np.ptp(along)),
        rms=float(np.sqrt(across / n)),
        confidence95_deg=confidence,
    )


def path_length(points: npt.ArrayLike) -> float:
    """Length of the polyline through points (n, 3), in their unit."""
    xyz = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    return float(np.linalg.norm(np.diff(xyz, axis=0), axis=1).sum())


def ring_area(points: npt.ArrayLike) -> float:
    """Area of the closed ring through points (n, 3), as seen from where it looks largest."""
    xyz = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    local = xyz - xyz[0]
    return float(0.5 * np.linalg.norm(np.cross(local, np.roll(local, -1, axis=0)).sum(axis=0)))
