"""Errors that an uncertain registration causes in results of many orientations.

Everything measured on one model rotates with it: the error is common to its planes and lines, and
the error of their mean or fold axis does not decrease with their number. To first order, a small
rotation w_k of model k moves a unit vector x of this model by w_k x x. A result (a mean, an axis)
that depends on the vectors moves by D_1 dx_1 + D_2 dx_2 + ..., so its covariance is the sum over
the models of J_k C_k J_k', where J_k is the sum over the vectors of the model of D_i times the
effect of the rotation on x_i (propagation of errors). If all vectors belong to one model, the
result rotates with it: J is then that of x itself. The derivative of a principal axis is that of an
eigenvector (Magnus 1985, Econometric Theory 1, 179-191).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.geology.orientation import Line
from vomstudio.geometry.rotation_errors import CHI2_TWO, cross_matrix

UNKNOWN_GROUP = -1
MIN_EIGENVALUE_GAP = 1e-12


@dataclass(frozen=True, eq=False)
class RotationErrors:
    """Uncertain rotations of n vectors due to their registrations.

    Attributes
    ----------
    group : (n,) ndarray of int
        Row of `rotations` for each vector; UNKNOWN_GROUP for a vector that does not rotate (a
        compass reading) or whose registration has no known error.
    rotations : (k, 3, 3) ndarray
        Covariances of independent rotations about east, north and up, radians squared.
    """

    group: IntArray
    rotations: FloatArray

    def __len__(self) -> int:
        return len(self.group)

    @property
    def has_known_errors(self) -> bool:
        """Whether at least one vector has a registration with a known error."""
        return bool((self.group >= 0).any())

    def of(self, rows: npt.ArrayLike) -> RotationErrors:
        """Return the errors of selected vectors, given by indices or a mask (n,)."""
        return RotationErrors(self.group[np.asarray(rows)], self.rotations)


def group_rotation_errors(rotations: Sequence[tuple[object, FloatArray | None]]) -> RotationErrors:
    """Group vectors by their registration.

    Parameters
    ----------
    rotations : sequence of (object, (3, 3) ndarray or None)
        Registration of each vector (vectors with equal keys rotate together) and its covariance,
        radians squared; None if the covariance is unknown.

    Returns
    -------
    RotationErrors
    """
    keys: dict[object, int] = {}
    covariances: list[FloatArray] = []
    group = []
    for key, rotation in rotations:
        if rotation is None:
            group.append(UNKNOWN_GROUP)
            continue
        if key not in keys:
            keys[key] = len(covariances)
            covariances.append(np.asarray(rotation, np.float64))
        group.append(keys[key])
    return RotationErrors(
        np.array(group, np.int64), np.array(covariances, np.float64).reshape(-1, 3, 3)
    )


@dataclass(frozen=True, eq=False)
class VectorsWithDerivatives:
    """Vectors (n, 3) with their derivatives with respect to small rotations.

    The derivatives (n, k, 3, 3) are taken with respect to rotations about east, north and up.
    """

    vectors: FloatArray
    derivatives: FloatArray
    rotations: FloatArray

    def covariance(self) -> FloatArray:
        """Return the covariances (n, 3, 3) of the vectors, radians squared."""
        contributions = self.derivatives @ self.rotations @ np.swapaxes(self.derivatives, -1, -2)
        return np.asarray(contributions.sum(axis=1))

    def propagate(self, vector: FloatArray, derivative: FloatArray) -> VectorsWithDerivatives:
        """Return a vector (3,) that depends on these vectors through derivatives (n, 3, 3)."""
        derivatives = np.einsum("nij,nkjl->kil", derivative, self.derivatives)
        return VectorsWithDerivatives(
            np.asarray(vector, np.float64)[None], derivatives[None], self.rotations
        )


def differentiate_vectors(
    vectors: npt.ArrayLike, rotations: RotationErrors
) -> VectorsWithDerivatives:
    """Return unit vectors and their derivatives with respect to their registrations.

    Parameters
    ----------
    vectors : (n, 3) array_like
    rotations : RotationErrors
        Registrations of the vectors.

    Returns
    -------
    VectorsWithDerivatives
    """
    v = np.asarray(vectors, np.float64).reshape(-1, 3)
    derivatives = np.zeros((len(v), len(rotations.rotations), 3, 3))
    rows = np.flatnonzero(rotations.group >= 0)
    # w x v = -(v x w)
    derivatives[rows, rotations.group[rows]] = -cross_matrix(v[rows])
    return VectorsWithDerivatives(v, derivatives, rotations.rotations)


def concatenate_vectors(parts: Sequence[VectorsWithDerivatives]) -> VectorsWithDerivatives:
    """Combine results that depend on the same registrations as inputs of another result.

    Parameters
    ----------
    parts : sequence of VectorsWithDerivatives

    Returns
    -------
    VectorsWithDerivatives
    """
    return VectorsWithDerivatives(
        np.concatenate([part.vectors for part in parts]),
        np.concatenate([part.derivatives for part in parts]),
        parts[0].rotations,
    )


def principal_axis(
    vectors_with_derivatives: VectorsWithDerivatives,
    eigenvalues: FloatArray,
    axes: FloatArray,
    index: int,
) -> VectorsWithDerivatives:
    """Return a principal axis of an orientation tensor, with its derivatives.

    Parameters
    ----------
    vectors_with_derivatives : VectorsWithDerivatives
    eigenvalues, axes : (3,) and (3, 3) ndarray
        Eigenvalues and eigenvectors returned by `statistics.orientation_tensor`.
    index : int
        Row of the axis in `axes`.

    Returns
    -------
    VectorsWithDerivatives
    """
    x, axis = vectors_with_derivatives.vectors, axes[index]
    n = len(x)
    derivative = np.zeros((n, 3, 3))
    for j in range(3):
        gap = eigenvalues[index] - eigenvalues[j]
        if j == index or abs(gap) < MIN_EIGENVALUE_GAP:
            continue
        product = (x @ axis)[:, None] * axes[j] + (x @ axes[j])[:, None] * axis
        derivative += axes[j][None, :, None] * product[:, None, :] / (n * gap)
    return vectors_with_derivatives.propagate(axis, derivative)


def resultant(
    vectors_with_derivatives: VectorsWithDerivatives, signs: FloatArray | None = None
) -> VectorsWithDerivatives:
    """Return the direction of the sum of vectors.

    Parameters
    ----------
    vectors_with_derivatives : VectorsWithDerivatives
    signs : (n,) ndarray, optional
        Factor of each vector, 1 or -1.

    Returns
    -------
    VectorsWithDerivatives
    """
    s = np.ones(len(vectors_with_derivatives.vectors)) if signs is None else signs
    total = s @ vectors_with_derivatives.vectors
    length = float(np.linalg.norm(total))
    mean = total / length
    projector = (np.eye(3) - np.outer(mean, mean)) / length
    return vectors_with_derivatives.propagate(mean, s[:, None, None] * projector)


def project_line(
    line: VectorsWithDerivatives, plane: VectorsWithDerivatives
) -> VectorsWithDerivatives:
    """Project a line onto a plane that nearly contains it.

    Within the plane, the line moves with its own rotation; perpendicular to it, with the plane.

    Parameters
    ----------
    line : VectorsWithDerivatives
    plane : VectorsWithDerivatives
        Normal of the plane.

    Returns
    -------
    VectorsWithDerivatives
    """
    normal, direction = plane.vectors[0], line.vectors[0]
    projected_direction = direction - normal * (direction @ normal)
    projected_direction = projected_direction / np.linalg.norm(projected_direction)
    horizontal_axis = np.cross(normal, projected_direction)
    derivative = np.array(
        [np.outer(horizontal_axis, horizontal_axis), -np.outer(normal, projected_direction)]
    )
    return concatenate_vectors([line, plane]).propagate(projected_direction, derivative)


def intersect_planes(
    first: VectorsWithDerivatives, second: VectorsWithDerivatives
) -> VectorsWithDerivatives:
    """Return the intersection line of two planes.

    Parameters
    ----------
    first, second : VectorsWithDerivatives
        Normals of the planes.

    Returns
    -------
    VectorsWithDerivatives
    """
    a, b = first.vectors[0], second.vectors[0]
    cross_product = np.cross(a, b)
    sine = float(np.linalg.norm(cross_product))
    line = cross_product / sine
    projector = (np.eye(3) - np.outer(line, line)) / sine
    # d(a x b) = -(b x da) + a x db
    derivative = np.array(
        [-projector @ cross_matrix(b[None])[0], projector @ cross_matrix(a[None])[0]]
    )
    return concatenate_vectors([first, second]).propagate(line, derivative)


@dataclass(frozen=True, eq=False)
class ConfidenceRegion:
    """Joint 95 % region on the sphere: half-angles and the direction (3,) of the larger one."""

    largest_deg: float
    smallest_deg: float
    axis: FloatArray

    @property
    def line(self) -> Line:
        """Direction of the larger half-angle as an axis."""
        return Line.from_vector(self.axis)


def region(
    vector: npt.ArrayLike,
    covariance: npt.ArrayLike | None,
    vector_region: tuple[float, float, npt.ArrayLike] | None = None,
) -> ConfidenceRegion:
    """Compute the joint 95 % region of a unit vector (3,).

    Parameters
    ----------
    vector : (3,) array_like
    covariance : (3, 3) array_like or None
        Covariance caused by the registrations, radians squared.
    vector_region : (float, float, (3,) array_like), optional
        Half-angles of the region without registrations in degrees, and the direction of the larger
        one.

    Returns
    -------
    ConfidenceRegion
    """
    v = np.asarray(vector, np.float64)
    spread = np.zeros((3, 3)) if covariance is None else CHI2_TWO * np.asarray(covariance)
    if vector_region is not None:
        spread = spread + region_matrix(v, *vector_region)
    basis = _tangent_basis(v)
    squares, directions = np.linalg.eigh(basis @ spread @ basis.T)
    # The cone of a few scattered directions can be wider than 90 degrees.
    max_angle_deg = 90.0 if vector_region is None else max(90.0, vector_region[0])
    angles = np.minimum(np.degrees(np.sqrt(np.maximum(squares, 0.0))), max_angle_deg)
    return ConfidenceRegion(float(angles[1]), float(angles[0]), directions[:, 1] @ basis)


def region_matrix(
    vector: FloatArray, largest_deg: float, smallest_deg: float, direction: npt.ArrayLike
) -> FloatArray:
    """Return the (3, 3) matrix whose eigenvalues are the squared half-angles of a region.

    Parameters
    ----------
    vector : (3,) ndarray
    largest_deg, smallest_deg : float
        Half-angles, degrees.
    direction : (3,) array_like
        Direction of the larger half-angle.

    Returns
    -------
    (3, 3) ndarray
        Radians squared; the covariance of the vector is this matrix divided by CHI2_TWO.
    """
    major_direction = np.asarray(direction, np.float64)
    major_direction = major_direction - vector * (major_direction @ vector)
    major_direction = major_direction / np.linalg.norm(major_direction)
    (a, b, c), (x, y, z) = vector, major_direction
    # `np.cross` takes ten times as long for a single pair.
    minor_direction = np.array([b * z - c * y, c * x - a * z, a * y - b * x])
    major_part = np.radians(largest_deg) ** 2 * np.outer(major_direction, major_direction)
    return np.asarray(
        major_part + np.radians(smallest_deg) ** 2 * np.outer(minor_direction, minor_direction)
    )


def line_confidence_region(
    vector: npt.ArrayLike,
    covariance: npt.ArrayLike | None,
    largest_deg: float | None,
    smallest_deg: float | None,
    direction: npt.ArrayLike | None,
) -> ConfidenceRegion | None:
    """Compute the joint 95 % region of a line.

    Parameters
    ----------
    vector : (3,) array_like
    covariance : (3, 3) array_like or None
        Covariance caused by the registrations, radians squared.
    largest_deg, smallest_deg : float or None
        Half-angles of the line itself, degrees.
    direction : (3,) array_like or None
        Direction of the larger half-angle. If None, the region is circular.

    Returns
    -------
    ConfidenceRegion or None
        None if the half-angles are unknown.
    """
    if largest_deg is None or smallest_deg is None:
        return None
    line_region = (
        cone(vector, largest_deg) if direction is None else (largest_deg, smallest_deg, direction)
    )
    return region(vector, covariance, line_region)


def cone(vector: npt.ArrayLike, half_angle_deg: float) -> tuple[float, float, FloatArray]:
    """Return a circular region in the form that `region` expects.

    Parameters
    ----------
    vector : (3,) array_like
    half_angle_deg : float

    Returns
    -------
    tuple
        Both half-angles in degrees, and any direction perpendicular to the vector.
    """
    return half_angle_deg, half_angle_deg, _tangent_basis(np.asarray(vector, np.float64))[0]


def _tangent_basis(v: FloatArray) -> FloatArray:
    """Return two unit vectors (2, 3) perpendicular to v and to each other."""
    first_tangent = np.cross(v, np.eye(3)[int(np.argmin(np.abs(v)))])
    first_tangent = first_tangent / np.linalg.norm(first_tangent)
    return np.array([first_tangent, np.cross(v, first_tangent)])
