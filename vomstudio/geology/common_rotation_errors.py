"""What an uncertain registration does to what is computed from many orientations.

All that was measured on one model turns with it: the error is common to its planes and lines, and
that of their mean or fold axis does not shrink with their number. To first order a small turn w_k
of the model k moves a unit vector x of it by w_k x x; a result (a mean, an axis) that depends on
the vectors moves by D_1 dx_1 + D_2 dx_2 + ..., so that its covariance is the sum over the models of
J_k C_k J_k' with J_k the sum over its vectors of D_i times the turn's effect on x_i (propagation of
errors). Where all vectors are of one model the result turns with it: J = that of x itself. The
derivative of a principal axis is the textbook one of an eigenvector (Magnus 1985, Econometric
Theory 1, 179-191).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray, IntArray
from vomstudio.geology.orientation import Line
from vomstudio.geometry.rotation_errors import CHI2_TWO, across

NO_TURN = -1
_SAME = 1e-12


@dataclass(frozen=True, eq=False)
class Turns:
    """How n vectors turn with registrations of known error.

    group : (n,) the row of `rotations` for each; NO_TURN for one that does not turn (a compass
        reading), or of whose registration no error is known
    rotations : (k, 3, 3) covariances of independent rotations, radians squared about east, north,
        up
    """

    group: IntArray
    rotations: FloatArray

    def __len__(self) -> int:
        return len(self.group)

    @property
    def known(self) -> bool:
        """Whether any of them has an error of registration."""
        return bool((self.group >= 0).any())

    def of(self, chosen: npt.ArrayLike) -> Turns:
        """Those of some of the vectors: indices, or (n,) booleans."""
        return Turns(self.group[np.asarray(chosen)], self.rotations)


def together(rotations: Sequence[tuple[object, FloatArray | None]]) -> Turns:
    """Of vectors with, each, what it was registered by (equal keys turn together) and the (3, 3)
    covariance of that; None where it is not known."""
    keys: dict[object, int] = {}
    found: list[FloatArray] = []
    group = []
    for key, rotation in rotations:
        if rotation is None:
            group.append(NO_TURN)
            continue
        if key not in keys:
            keys[key] = len(found)
            found.append(np.asarray(rotation, np.float64))
        group.append(keys[key])
    return Turns(np.array(group, np.int64), np.array(found, np.float64).reshape(-1, 3, 3))


@dataclass(frozen=True, eq=False)
class Moved:
    """Vectors (n, 3) with what each registration does to them: (n, k, 3, 3) by a small turn about
    east, north, up."""

    vectors: FloatArray
    by: FloatArray
    rotations: FloatArray

    def covariance(self) -> FloatArray:
        """(n, 3, 3), radians squared."""
        turned = self.by @ self.rotations @ np.swapaxes(self.by, -1, -2)
        return np.asarray(turned.sum(axis=1))

    def result(self, vector: FloatArray, derivative: FloatArray) -> Moved:
        """A vector (3,) that moves by the sum of derivative[i] (3, 3) times the vectors' moves."""
        by = np.einsum("nij,nkjl->kil", derivative, self.by)
        return Moved(np.asarray(vector, np.float64)[None], by[None], self.rotations)


def moved(vectors: npt.ArrayLike, turns: Turns) -> Moved:
    """Unit vectors (n, 3) as their registrations move them."""
    v = np.asarray(vectors, np.float64).reshape(-1, 3)
    by = np.zeros((len(v), len(turns.rotations), 3, 3))
    rows = np.flatnonzero(turns.group >= 0)
    # w x v = -(v x w)
    by[rows, turns.group[rows]] = -across(v[rows])
    return Moved(v, by, turns.rotations)


def joined(parts: Sequence[Moved]) -> Moved:
    """Results that rest on the same registrations, as vectors of a further one."""
    return Moved(
        np.concatenate([part.vectors for part in parts]),
        np.concatenate([part.by for part in parts]),
        parts[0].rotations,
    )


def principal_axis(given: Moved, values: FloatArray, axes: FloatArray, index: int) -> Moved:
    """One of the principal axes of the vectors' orientation tensor; values, axes as
    `statistics.orientation_tensor` gives them."""
    x, axis = given.vectors, axes[index]
    n = len(x)
    derivative = np.zeros((n, 3, 3))
    for j in range(3):
        apart = values[index] - values[j]
        if j == index or abs(apart) < _SAME:
            continue
        pull = (x @ axis)[:, None] * axes[j] + (x @ axes[j])[:, None] * axis
        derivative += axes[j][None, :, None] * pull[:, None, :] / (n * apart)
    return given.result(axis, derivative)


def resultant(given: Moved, signs: FloatArray | None = None) -> Moved:
    """The direction of the sum of the vectors; signs : (n,) by which each is turned round first."""
    s = np.ones(len(given.vectors)) if signs is None else signs
    total = s @ given.vectors
    length = float(np.linalg.norm(total))
    mean = total / length
    flat = (np.eye(3) - np.outer(mean, mean)) / length
    return given.result(mean, s[:, None, None] * flat)


def laid_into(line: Moved, plane: Moved) -> Moved:
    """A line (one) that is turned into the plane with this normal (one), in which it nearly lies:
    along the plane it strays by itself, across it with the plane."""
    normal, given = plane.vectors[0], line.vectors[0]
    flat = given - normal * (given @ normal)
    flat = flat / np.linalg.norm(flat)
    beside = np.cross(normal, flat)
    derivative = np.array([np.outer(beside, beside), -np.outer(normal, flat)])
    return joined([line, plane]).result(flat, derivative)


def meeting(first: Moved, second: Moved) -> Moved:
    """The line in which two planes meet, of which these are the normals (one each)."""
    a, b = first.vectors[0], second.vectors[0]
    cross = np.cross(a, b)
    sine = float(np.linalg.norm(cross))
    line = cross / sine
    flat = (np.eye(3) - np.outer(line, line)) / sine
    # d(a x b) = -(b x da) + a x db
    derivative = np.array([-flat @ across(b[None])[0], flat @ across(a[None])[0]])
    return joined([first, second]).result(line, derivative)


@dataclass(frozen=True, eq=False)
class Region:
    """A joint 95 % region on the sphere: half-angles, and the direction (3,) of the larger one."""

    largest_deg: float
    smallest_deg: float
    axis: FloatArray

    @property
    def line(self) -> Line:
        """The direction of the larger half-angle, as an axis."""
        return Line.from_vector(self.axis)


def region(
    vector: npt.ArrayLike,
    covariance: npt.ArrayLike | None,
    own: tuple[float, float, npt.ArrayLike] | None = None,
) -> Region:
    """The joint 95 % region of a unit vector (3,).

    covariance : (3, 3) radians squared, by its registrations; None for nothing
    own : half-angles of the region without them, degrees, and the direction (3,) of the larger one
    """
    v = np.asarray(vector, np.float64)
    spread = np.zeros((3, 3)) if covariance is None else CHI2_TWO * np.asarray(covariance)
    if own is not None:
        spread = spread + squared_region(v, *own)
    basis = _across_basis(v)
    squares, directions = np.linalg.eigh(basis @ spread @ basis.T)
    # The cone of a few scattered directions may be wider than that.
    most = 90.0 if own is None else max(90.0, own[0])
    angles = np.minimum(np.degrees(np.sqrt(np.maximum(squares, 0.0))), most)
    return Region(float(angles[1]), float(angles[0]), directions[:, 1] @ basis)


def squared_region(
    vector: FloatArray, largest_deg: float, smallest_deg: float, toward: npt.ArrayLike
) -> FloatArray:
    """Return the (3, 3) matrix whose eigenvalues are the squares of a region's half-angles.

    They are in radians squared, along `toward` (3,) and across it; the covariance of the vector is
    the matrix divided by CHI2_TWO.
    """
    first = np.asarray(toward, np.float64)
    first = first - vector * (first @ vector)
    first = first / np.linalg.norm(first)
    second = np.cross(vector, first)
    along = np.radians(largest_deg) ** 2 * np.outer(first, first)
    return np.asarray(along + np.radians(smallest_deg) ** 2 * np.outer(second, second))


def region_of_line(
    vector: npt.ArrayLike,
    covariance: npt.ArrayLike | None,
    largest_deg: float | None,
    smallest_deg: float | None,
    toward: npt.ArrayLike | None,
) -> Region | None:
    """`region` of a line whose own half-angles may not be known (None); toward : None for a round
    region."""
    if largest_deg is None or smallest_deg is None:
        return None
    own = cone(vector, largest_deg) if toward is None else (largest_deg, smallest_deg, toward)
    return region(vector, covariance, own)


def cone(vector: npt.ArrayLike, half_angle_deg: float) -> tuple[float, float, FloatArray]:
    """A round region, as `region` takes it."""
    return half_angle_deg, half_angle_deg, _across_basis(np.asarray(vector, np.float64))[0]


def _across_basis(v: FloatArray) -> FloatArray:
    """(2, 3) unit vectors at right angles to v and each other."""
    first = np.cross(v, np.eye(3)[int(np.argmin(np.abs(v)))])
    first = first / np.linalg.norm(first)
    return np.array([first, np.cross(v, first)])
