"""Where two planes meet, and how well that line is known.

A plane's normal n known to within the ellipse C (joint 95 %, tangent to the sphere) lets the line
stray from the plane by sqrt(l' C l), l being the line. A line that must lie in both planes strays
by a vector e at right angles to itself with e . n1 = s1, e . n2 = s2; as the two strays are
independent, the joint 95 % region of e is the ellipse that they span. The narrower the angle
between the planes, the longer it is (Fisher, Lewis & Embleton 1987, propagation of errors, ch. 3).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.errors import GeometryError
from vomstudio.geology.orientation import Line, Plane
from vomstudio.geology.statistics import flip_to, orientation_tensor

Floats = npt.NDArray[np.float64]

PARALLEL_DEG = 0.01


@dataclass(frozen=True, eq=False)
class UncertainPlane:
    """normal (3,) upward unit vector; spread95 (3, 3) the matrix C whose ellipse x' C^-1 x <= 1 in
    the plane tangent to the sphere at the normal is its joint 95 % region; None: unknown."""

    normal: Floats
    spread95: Floats | None


@dataclass(frozen=True, eq=False)
class IntersectionLine:
    """line: axial, plunging down. angle_deg: between the planes, 0 to 90. max/min_confidence95_deg:
    semi-axes of the joint 95 % region of the line; None where the error of a plane is unknown."""

    line: Line
    angle_deg: float
    max_confidence95_deg: float | None
    min_confidence95_deg: float | None


def uncertain_plane(
    normal: npt.ArrayLike,
    axes: npt.ArrayLike,
    max_confidence95_deg: float | None,
    min_confidence95_deg: float | None,
) -> UncertainPlane:
    """Of a fitted plane: its axes e1, e2, e3 (rows); the normal strays most along e2."""
    n = np.asarray(normal, dtype=np.float64)
    if max_confidence95_deg is None or min_confidence95_deg is None:
        return UncertainPlane(n, None)
    e1, e2 = np.asarray(axes, dtype=np.float64)[:2]
    limits = np.minimum([min_confidence95_deg, max_confidence95_deg], 89.9)
    t1, t2 = np.tan(np.radians(limits))
    return UncertainPlane(n, t1**2 * np.outer(e1, e1) + t2**2 * np.outer(e2, e2))


def mean_plane(planes: Sequence[UncertainPlane]) -> UncertainPlane:
    """The mean of planes of one set, axially (orientation tensor), with the error of the mean from
    their scatter, F with n - 1 degrees of freedom; of a single plane its own."""
    if not planes:
        raise GeometryError("A set without planes has no mean; choose another set.")
    if len(planes) == 1:
        return planes[0]
    normals = np.array([p.normal for p in planes])
    n = len(normals)
    mean = orientation_tensor(normals)[1][0]
    strays = flip_to(normals, mean)
    strays = strays - (strays @ mean)[:, None] * mean
    free = n - 1.0
    f95 = free / 2.0 * np.expm1(2.0 / free * np.log(20.0))
    return UncertainPlane(
        mean if mean[2] >= 0.0 else -mean, 2.0 * f95 * (strays.T @ strays) / (free * n)
    )


def intersection_line(a: UncertainPlane, b: UncertainPlane) -> IntersectionLine:
    """Raises GeometryError where the planes are parallel."""
    cross = np.cross(a.normal, b.normal)
    sine = float(np.linalg.norm(cross))
    angle = float(np.degrees(np.arctan2(sine, abs(float(a.normal @ b.normal)))))
    if angle < PARALLEL_DEG:
        raise GeometryError("The two planes are parallel: they do not meet in a line.")
    line = cross / sine
    largest = smallest = None
    if a.spread95 is not None and b.spread95 is not None:
        strays = np.array([line @ a.spread95 @ line, line @ b.spread95 @ line])
        # Coordinates across the line, in which n1 and n2 are the rows of a 2 x 2 system.
        u = a.normal
        v = np.cross(line, u)
        rows = np.array([[1.0, 0.0], [float(b.normal @ u), float(b.normal @ v)]])
        back = np.linalg.inv(rows)
        squares = np.linalg.eigvalsh(back @ np.diag(strays) @ back.T)
        smallest, largest = np.degrees(np.arctan(np.sqrt(np.maximum(squares, 0.0)))).tolist()
    return IntersectionLine(Line.from_vector(line), angle, largest, smallest)


def plane_of(uncertain: UncertainPlane) -> Plane:
    return Plane.from_normal(uncertain.normal)
