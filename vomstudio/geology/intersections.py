"""Intersection line of two planes, with its error.

Let the ellipse C be the error of the normal n of a plane (joint 95 %, tangent to the sphere). The
deviation of a line l in the plane from the plane is then sqrt(l' C l). A line that must lie in both
planes deviates by a vector e perpendicular to the line, with e . n1 = s1 and e . n2 = s2. Both
deviations are independent, so the joint 95 % region of e is the ellipse that they span. This
ellipse becomes longer as the angle between the planes decreases (Fisher, Lewis & Embleton 1987,
propagation of errors, ch. 3).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import Line
from vomstudio.geology.statistics import flip_to_hemisphere, orientation_tensor
from vomstudio.geometry.plane_errors import SIGNIFICANCE, joint_quantile

MIN_ANGLE_DEG = 0.01

NORMAL_QUANTILE95 = 1.959963984540054
"""Two-sided 95 % quantile of the normal distribution in standard deviations."""


@dataclass(frozen=True, eq=False)
class UncertainPlane:
    """Plane with the uncertainty of its normal.

    Attributes
    ----------
    normal : (3,) ndarray
        Upward unit vector.
    spread95 : (3, 3) ndarray or None
        Matrix C. The ellipse x' C^-1 x <= 1 in the tangent plane of the sphere at the normal is the
        joint 95 % region; None if unknown.
    degrees_of_freedom : float
        Degrees of freedom of the variance estimate.
    roughness : float
        Standard deviation of the points about the plane, m.
    """

    normal: FloatArray
    spread95: FloatArray | None
    degrees_of_freedom: float = math.inf
    roughness: float = 0.0


@dataclass(frozen=True, eq=False)
class IntersectionLine:
    """Intersection line of two planes.

    Attributes
    ----------
    line : Line
        Intersection line as an axis that plunges downward.
    angle_deg : float
        Angle between the planes, 0 to 90 degrees.
    max_confidence95_deg, min_confidence95_deg : float or None
        Semi-axes of the joint 95 % region of the line, degrees; None if the error of one of the
        planes is unknown.
    confidence_axis : (3,) ndarray or None
        Direction of the larger semi-axis.
    """

    line: Line
    angle_deg: float
    max_confidence95_deg: float | None
    min_confidence95_deg: float | None
    confidence_axis: FloatArray | None


def uncertain_plane(
    normal: npt.ArrayLike,
    tilt: npt.ArrayLike,
    max_confidence95_deg: float | None,
    min_confidence95_deg: float | None,
    dof: float = math.inf,
) -> UncertainPlane:
    """Create a plane with the error of its normal from the results of a fit.

    Parameters
    ----------
    normal : (3,) array_like
    tilt : (3,) array_like
        Direction in the plane toward which the normal is most uncertain.
    max_confidence95_deg, min_confidence95_deg : float or None
        Semi-axes of the joint 95 % region, degrees.
    dof : float
        Degrees of freedom of the residuals.

    Returns
    -------
    UncertainPlane
    """
    n = np.asarray(normal, dtype=np.float64)
    if max_confidence95_deg is None or min_confidence95_deg is None:
        return UncertainPlane(n, None)
    e2 = np.asarray(tilt, dtype=np.float64)
    e1 = np.cross(e2, n)
    limits = np.minimum([min_confidence95_deg, max_confidence95_deg], 89.9)
    t1, t2 = np.tan(np.radians(limits))
    return UncertainPlane(n, t1**2 * np.outer(e1, e1) + t2**2 * np.outer(e2, e2), dof)


def deviation95(
    plane: UncertainPlane, vector: npt.ArrayLike, *, is_joint: bool = True
) -> float | None:
    """Return the 95 % error of a vector in a plane, normal to the plane.

    Parameters
    ----------
    plane : UncertainPlane
    vector : (3,) array_like
    is_joint : bool
        If True, return the half-width of the joint region; if False, that of the interval of this
        value alone (Student's t instead of Fisher's F).

    Returns
    -------
    float or None
        In the unit of the vector; None if the error of the plane is unknown.
    """
    if plane.spread95 is None:
        return None
    v = np.asarray(vector, dtype=np.float64)
    width = math.sqrt(max(float(v @ plane.spread95 @ v), 0.0))
    return width if is_joint else width * _marginal_factor(plane.degrees_of_freedom)


def t95(dof: float) -> float:
    """Return the two-sided 95 % quantile of Student's t.

    Parameters
    ----------
    dof : float
        Degrees of freedom.

    Returns
    -------
    float
    """
    from scipy.special import stdtrit

    return NORMAL_QUANTILE95 if math.isinf(dof) else float(stdtrit(dof, 1.0 - SIGNIFICANCE / 2.0))


def _marginal_factor(dof: float) -> float:
    if math.isinf(dof):
        return NORMAL_QUANTILE95 / math.sqrt(-2.0 * math.log(SIGNIFICANCE))
    return t95(dof) / math.sqrt(dof * float(joint_quantile(np.array([dof]))[0]))


def mean_plane(planes: Sequence[UncertainPlane]) -> UncertainPlane:
    """Compute the axial mean of the planes of one set, with its error.

    The error is Hotelling's T^2 in the tangent plane at the mean, with F(2, n - 2). Two or three
    planes do not determine the shape of their scatter, which is then assumed to be equal in all
    directions, with F(2, 2 (n - 1)). A single plane is returned with its own error.

    Raises
    ------
    GeometryError
        If `planes` is empty.
    """
    if not planes:
        raise GeometryError(Finding("sets.no-members"))
    if len(planes) == 1:
        return planes[0]
    normals = np.array([plane.normal for plane in planes])
    n = len(normals)
    mean = orientation_tensor(normals)[1][0]
    deviations = flip_to_hemisphere(normals, mean)
    deviations = deviations - (deviations @ mean)[:, None] * mean
    scatter = deviations.T @ deviations
    dof = n - 2.0
    if n <= 3:
        dof = 2.0 * (n - 1.0)
        scatter = float(np.trace(scatter)) * (np.eye(3) - np.outer(mean, mean))
    region = float(joint_quantile(np.array([dof]))[0]) * scatter / n
    return UncertainPlane(mean if mean[2] >= 0.0 else -mean, region, dof)


def scatter_deg(planes: Sequence[UncertainPlane], mean: UncertainPlane) -> float:
    """Return the axial root-mean-square angle between planes and their mean.

    Parameters
    ----------
    planes : sequence of UncertainPlane
    mean : UncertainPlane

    Returns
    -------
    float
        Degrees.
    """
    if not planes:
        return 0.0
    normals = np.array([plane.normal for plane in planes])
    sine = np.linalg.norm(np.cross(normals, mean.normal), axis=1)
    angles = np.arctan2(sine, np.abs(normals @ mean.normal))
    return float(np.degrees(np.sqrt(np.mean(angles**2))))


def intersection_line(a: UncertainPlane, b: UncertainPlane) -> IntersectionLine:
    """Compute the intersection line of two planes, with its error.

    Raises
    ------
    GeometryError
        If the planes are parallel.
    """
    cross_product = np.cross(a.normal, b.normal)
    sine = float(np.linalg.norm(cross_product))
    angle = float(np.degrees(np.arctan2(sine, abs(float(a.normal @ b.normal)))))
    if angle < MIN_ANGLE_DEG:
        raise GeometryError(Finding("planes.parallel"))
    line = cross_product / sine
    major_deg = minor_deg = axis = None
    if a.spread95 is not None and b.spread95 is not None:
        deviations = np.array([line @ a.spread95 @ line, line @ b.spread95 @ line])
        # In coordinates perpendicular to the line, n1 and n2 are the rows of a 2 x 2 system.
        u = a.normal
        v = np.cross(line, u)
        rows = np.array([[1.0, 0.0], [float(b.normal @ u), float(b.normal @ v)]])
        inverse = np.linalg.inv(rows)
        squares, axes = np.linalg.eigh(inverse @ np.diag(deviations) @ inverse.T)
        minor_deg, major_deg = np.degrees(np.arctan(np.sqrt(np.maximum(squares, 0.0)))).tolist()
        axis = axes[0, 1] * u + axes[1, 1] * v
    return IntersectionLine(Line.from_vector(line), angle, major_deg, minor_deg, axis)
