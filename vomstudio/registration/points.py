"""A model placed by points that are known in both frames, and how well it then is known.

The similarity minimises the squares of the residuals, each divided by the error of its coordinate
(Umeyama 1991 for equal errors, Gauss-Newton from there for unequal ones). Its covariance is that of
linear least squares: good for rotations known to some 20 degrees.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.errors import GeometryError
from vomstudio.geology.orientation import Line
from vomstudio.registration.similarity import (
    Similarity,
    fit_similarity,
    jacobian,
    nearly_on_a_line,
)
from vomstudio.reprs import Shown
from vomstudio.words import tr

Array = npt.NDArray[np.float64]

_STEPS = 20
_SMALL = 1e-12
_WARN_DEG = 1.0
_SURE = 0.99


@dataclass(frozen=True)
class PointResidual:
    """dx, dy, dz, error_m : fitted less given, World, and its length; pixels : None, since no marks
    in photos take part"""

    label: str
    dx: float
    dy: float
    dz: float
    error_m: float
    pixels: float | None = None


@dataclass(frozen=True)
class RotationError:
    """Of the rotation, one sigma each, degrees."""

    about_up: float
    about_east: float
    about_north: float


@dataclass(frozen=True)
class WeakestAxis:
    """The axis about which the model is held worst, and its 95 % error, degrees."""

    trend_deg: float
    plunge_deg: float
    error_deg: float


@dataclass(frozen=True)
class RotationError95:
    """The same three at 95 %, each by itself, and the worst axis of all."""

    about_up: float
    about_east: float
    about_north: float
    weakest: WeakestAxis


@dataclass(frozen=True)
class Known:
    """What the registration has fixed."""

    north: bool = True
    vertical: bool = True
    scale: bool = True
    position: bool = True


@dataclass(frozen=True, repr=False)
class PointRegistration(Shown):
    """A similarity from the model to World, and what it leaves over.

    matrix : 4 x 4, acts on column vectors of the model; scale : metres per unit of the model
    control : points that entered the fit; check : points that did not
    rms_control_m, rms_check_m : of the residuals' lengths, None without such points
    rotation_error_deg, rotation_error_95_deg, scale_error_95 (a share of the scale) : from the
        errors given, else from the residuals (Student's t with 3 n - 7 degrees of freedom)
    """

    matrix: tuple[tuple[float, ...], ...]
    scale: float
    control: tuple[PointResidual, ...]
    check: tuple[PointResidual, ...]
    rms_control_m: float | None
    rms_check_m: float | None
    rotation_error_deg: RotationError
    rotation_error_95_deg: RotationError95
    scale_error_95: float
    known: Known
    warnings: tuple[str, ...]

    def __call__(self, points: npt.ArrayLike) -> Array:
        """(n, 3) World of model points (n, 3)."""
        m = np.asarray(self.matrix)
        return np.asarray(np.asarray(points, np.float64) @ m[:3, :3].T + m[:3, 3])

    def as_dict(self) -> dict[str, Any]:
        """Ready for JSON."""
        return asdict(self)


def register_points(
    model: Array,
    world: Array,
    sigma_m: Array | None = None,
    check: npt.NDArray[np.bool_] | None = None,
    labels: Sequence[str] | None = None,
) -> PointRegistration:
    """The registration by pairs of points.

    model, world : (n, 3); sigma_m : (n, 3) one-sigma errors of the World coordinates, None to take
    them as equal and from the residuals; check : (n,) True for points that only judge
    Raises GeometryError for fewer than three control points, or control points on one line.
    """
    is_check = np.zeros(len(model), bool) if check is None else np.asarray(check, bool)
    names = list(labels) if labels is not None else [str(i + 1) for i in range(len(model))]
    used = ~is_check
    if used.sum() >= 3 and (nearly_on_a_line(world[used]) or nearly_on_a_line(model[used])):
        raise GeometryError(
            tr(
                "The control points lie on one line, about which the model could turn. Add "
                "one beside it."
            )
        )
    weights = np.ones_like(world) if sigma_m is None else 1.0 / sigma_m**2
    fit = _fitted(model[used], world[used], weights[used])
    residuals = fit(model) - world
    control, checked = (_residuals(names, residuals, which) for which in (used, is_check))
    covariance, factor, warnings = _errors(
        fit, model[used], residuals[used], weights[used], sigma_m is not None
    )
    rotation, rotation95 = _rotation_errors(covariance[:3, :3], factor)
    warnings += _remarks(control, checked, rotation)
    warnings += _mirrored(model[used], world[used], fit)
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = fit.scale * fit.rotation, fit.translation
    return PointRegistration(
        tuple(tuple(float(v) for v in row) for row in matrix),
        fit.scale,
        control,
        checked,
        _rms(control),
        _rms(checked),
        rotation,
        rotation95,
        factor * float(np.sqrt(covariance[3, 3])),
        Known(),
        tuple(warnings),
    )


def _fitted(a: Array, b: Array, weights: Array) -> Similarity:
    """(n, 3) weights of the coordinates of b."""
    fit = fit_similarity(a, b, weights.mean(axis=1))
    if np.ptp(weights) <= _SMALL * weights.max():
        return fit
    for _ in range(_STEPS):
        normal, right, centre = _normal_equations(fit, a, fit(a) - b, weights)
        step: Array = np.asarray(-np.linalg.solve(normal, right), np.float64)
        fit = _moved(fit, step, centre)
        if np.abs(step[:4]).max() < _SMALL:
            break
    return fit


def _normal_equations(
    fit: Similarity, a: Array, residuals: Array, weights: Array
) -> tuple[Array, Array, Array]:
    """(7, 7) information and (7,) gradient of a small turn, scale and shift about a centre (3,)."""
    placed = fit(a)
    share = weights.mean(axis=1) / weights.mean(axis=1).sum()
    centre = share @ placed
    moves = np.array([jacobian(p) for p in placed - centre])
    normal = np.einsum("nij,ni,nik->jk", moves, weights, moves)
    right = np.einsum("nij,ni,ni->j", moves, weights, residuals)
    return normal, right, centre


def _moved(fit: Similarity, step: Array, centre: Array) -> Similarity:
    """After a turn step[:3] (rad) about World axes, a relative scale step[3], a shift step[4:]."""
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_rotvec(step[:3]).as_matrix()
    grow = 1.0 + float(step[3])
    rotation = turn @ fit.rotation
    translation = grow * turn @ (fit.translation - centre) + centre + step[4:]
    return Similarity(fit.scale * grow, rotation, translation)


def _errors(
    fit: Similarity, a: Array, residuals: Array, weights: Array, stated: bool
) -> tuple[Array, float, list[str]]:
    """(7, 7) covariance, what makes 95 % of one sigma, and sentences."""
    from scipy.stats import chi2, norm, t

    normal, _, _ = _normal_equations(fit, a, residuals, weights)
    covariance: Array = np.asarray(np.linalg.inv(normal), np.float64)
    freedom = 3 * len(a) - 7
    squares = float((weights * residuals**2).sum())
    if not stated:
        return covariance * squares / freedom, float(t.ppf(0.975, freedom)), []
    warnings = []
    if squares > chi2.ppf(_SURE, freedom):
        warnings.append(
            f"the residuals are {np.sqrt(squares / freedom):.1f} times what the stated accuracies "
            "allow: a point may be wrong, or the accuracies are too small"
        )
    return covariance, float(norm.ppf(0.975)), warnings


def _rotation_errors(covariance: Array, factor: float) -> tuple[RotationError, RotationError95]:
    east, north, up = (float(v) for v in np.degrees(np.sqrt(np.diag(covariance))))
    values, axes = np.linalg.eigh(covariance)
    line = Line.from_vector(axes[:, -1])
    worst = factor * float(np.degrees(np.sqrt(max(values[-1], 0.0))))
    return RotationError(up, east, north), RotationError95(
        factor * up,
        factor * east,
        factor * north,
        WeakestAxis(line.trend_deg, line.plunge_deg, worst),
    )


def _residuals(
    names: Sequence[str], residuals: Array, which: npt.NDArray[np.bool_]
) -> tuple[PointResidual, ...]:
    return tuple(
        PointResidual(names[i], dx, dy, dz, float(np.linalg.norm([dx, dy, dz])))
        for i, (dx, dy, dz) in enumerate(residuals.tolist())
        if which[i]
    )


def _rms(points: Sequence[PointResidual]) -> float | None:
    return float(np.sqrt(np.mean([p.error_m**2 for p in points]))) if points else None


def _remarks(
    control: Sequence[PointResidual], check: Sequence[PointResidual], error: RotationError
) -> list[str]:
    said = []
    if len(control) < 4:
        said.append("3 control points leave nothing over to find a mistake with; use 4 or more")
    if not check:
        said.append("no check points judge the model independently of the points that placed it")
    if max(error.about_up, error.about_east, error.about_north) > _WARN_DEG:
        tilt = float(np.hypot(error.about_east, error.about_north))
        said.append(
            f"the control points leave the model turned by about {error.about_up:.1f}° and tilted "
            f"by about {tilt:.1f}°: dips and dip directions can be wrong by as much; "
            "spread the points wider"
        )
    return said


def _mirrored(a: Array, b: Array, fit: Similarity) -> list[str]:
    """Whether points that fit badly are a mirror image of the others."""
    left = float(((fit(a) - b) ** 2).sum())
    over = float(((b - b.mean(axis=0)) ** 2).sum())
    flipped = a * [1.0, 1.0, -1.0]
    again = fit_similarity(flipped, b)
    if left > 1e-6 * over and float(((again(flipped) - b) ** 2).sum()) < 0.01 * left:
        return ["the points fit as a mirror image: two axes of one of the frames are exchanged"]
    return []
