"""Where two planes meet, and how well that line is known.

A plane's normal n known to within the ellipse C (joint 95 %, tangent to the sphere) lets the line
stray from the plane by sqrt(l' C l), l being the line. A line that must lie in both planes strays
by a vector e at right angles to itself with e . n1 = s1, e . n2 = s2; as the two strays are
independent, the joint 95 % region of e is the ellipse that they span. The narrower the angle
between the planes, the longer it is (Fisher, Lewis & Embleton 1987, propagation of errors, ch. 3).
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
from vomstudio.geology.statistics import flip_to, orientation_tensor
from vomstudio.geometry.plane_errors import LEVEL, joint_quantile

PARALLEL_DEG = 0.01

STRAY95 = 1.959963984540054
"""Standard deviations either side that hold 95 % of normal errors."""


@dataclass(frozen=True, eq=False)
class UncertainPlane:
    """normal (3,) upward unit vector; spread95 (3, 3) the matrix C whose ellipse x' C^-1 x <= 1 in
    the plane tangent to the sphere at the normal is its joint 95 % region; None: unknown. free:
    the degrees of freedom of the variance behind it. roughness: standard deviation of its points
    from it, m."""

    normal: FloatArray
    spread95: FloatArray | None
    free: float = math.inf
    roughness: float = 0.0


@dataclass(frozen=True, eq=False)
class IntersectionLine:
    """line: axial, plunging down. angle_deg: between the planes, 0 to 90. max/min_confidence95_deg:
    semi-axes of the joint 95 % region of the line, confidence_axis (3,) the direction of the larger
    one; None where the error of a plane is unknown."""

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
    free: float = math.inf,
) -> UncertainPlane:
    """Of a fitted plane: `tilt` (3,) is the direction in the plane toward which its normal strays
    most, `free` the degrees of freedom of its residuals."""
    n = np.asarray(normal, dtype=np.float64)
    if max_confidence95_deg is None or min_confidence95_deg is None:
        return UncertainPlane(n, None)
    e2 = np.asarray(tilt, dtype=np.float64)
    e1 = np.cross(e2, n)
    limits = np.minimum([min_confidence95_deg, max_confidence95_deg], 89.9)
    t1, t2 = np.tan(np.radians(limits))
    return UncertainPlane(n, t1**2 * np.outer(e1, e1) + t2**2 * np.outer(e2, e2), free)


def stray95(plane: UncertainPlane, vector: npt.ArrayLike, *, joint: bool = True) -> float | None:
    """How far a vector (3,) in the plane may leave it, 95 %, in the unit of the vector; None where
    the plane's error is unknown. joint: the half-width of the joint region, else the interval of
    this one figure alone (Student's t against Fisher's F of two)."""
    if plane.spread95 is None:
        return None
    v = np.asarray(vector, dtype=np.float64)
    width = math.sqrt(max(float(v @ plane.spread95 @ v), 0.0))
    return width if joint else width * _marginal(plane.free)


def t95(free: float) -> float:
    """How many standard deviations either side hold 95 % (Student)."""
    from scipy.special import stdtrit

    return STRAY95 if math.isinf(free) else float(stdtrit(free, 1.0 - LEVEL / 2.0))


def _marginal(free: float) -> float:
    if math.isinf(free):
        return STRAY95 / math.sqrt(-2.0 * math.log(LEVEL))
    return t95(free) / math.sqrt(free * float(joint_quantile(np.array([free]))[0]))


def mean_plane(planes: Sequence[UncertainPlane]) -> UncertainPlane:
    """The mean of planes of one set, axially (orientation tensor), with the error of the mean from
    their scatter; of a single plane its own.

    Hotelling's T^2 in the plane tangent at the mean, F with 2 and n - 2 degrees of freedom; of two
    or three planes, which do not tell the shape of their scatter, it is taken as equal in all
    directions, F with 2 and 2 (n - 1).
    """
    if not planes:
        raise GeometryError(Finding("sets.no-members"))
    if len(planes) == 1:
        return planes[0]
    normals = np.array([p.normal for p in planes])
    n = len(normals)
    mean = orientation_tensor(normals)[1][0]
    strays = flip_to(normals, mean)
    strays = strays - (strays @ mean)[:, None] * mean
    scatter = strays.T @ strays
    free = n - 2.0
    if n <= 3:
        free = 2.0 * (n - 1.0)
        scatter = float(np.trace(scatter)) * (np.eye(3) - np.outer(mean, mean))
    spread = float(joint_quantile(np.array([free]))[0]) * scatter / n
    return UncertainPlane(mean if mean[2] >= 0.0 else -mean, spread, free)


def scatter_deg(planes: Sequence[UncertainPlane], mean: UncertainPlane) -> float:
    """Root mean square angle of planes from their mean, axially."""
    if not planes:
        return 0.0
    normals = np.array([plane.normal for plane in planes])
    sine = np.linalg.norm(np.cross(normals, mean.normal), axis=1)
    angles = np.arctan2(sine, np.abs(normals @ mean.normal))
    return float(np.degrees(np.sqrt(np.mean(angles**2))))


def intersection_line(a: UncertainPlane, b: UncertainPlane) -> IntersectionLine:
    """Raises GeometryError where the planes are parallel."""
    cross = np.cross(a.normal, b.normal)
    sine = float(np.linalg.norm(cross))
    angle = float(np.degrees(np.arctan2(sine, abs(float(a.normal @ b.normal)))))
    if angle < PARALLEL_DEG:
        raise GeometryError(Finding("planes.parallel"))
    line = cross / sine
    largest = smallest = axis = None
    if a.spread95 is not None and b.spread95 is not None:
        strays = np.array([line @ a.spread95 @ line, line @ b.spread95 @ line])
        # Coordinates across the line, in which n1 and n2 are the rows of a 2 x 2 system.
        u = a.normal
        v = np.cross(line, u)
        rows = np.array([[1.0, 0.0], [float(b.normal @ u), float(b.normal @ v)]])
        back = np.linalg.inv(rows)
        squares, axes = np.linalg.eigh(back @ np.diag(strays) @ back.T)
        smallest, largest = np.degrees(np.arctan(np.sqrt(np.maximum(squares, 0.0)))).tolist()
        axis = axes[0, 1] * u + axes[1, 1] * v
    return IntersectionLine(Line.from_vector(line), angle, largest, smallest, axis)
