"""A model placed by all that is known of its place, and what a geologist must know of that."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.errors import GeometryError
from vomstudio.geology.orientation import Line
from vomstudio.registration.adjustment import Adjusted, adjust
from vomstudio.registration.blunders import Blunder, find_blunders
from vomstudio.registration.observations import Observed, Points
from vomstudio.registration.similarity import Similarity, fit_similarity, nearly_on_a_line
from vomstudio.reprs import Shown
from vomstudio.words import tr, tr_n

Array = npt.NDArray[np.float64]

_Z95 = 1.959963984540054
_WARN_DEG = 1.0
_WARN_SCALE = 0.01
# One sigma of a turn or of the relative scale above which it is as good as not known.
_UNKNOWN_RAD = np.radians(30.0)
_UNKNOWN_SCALE = 0.5
# An unknown turn that is the same all around reaches this far into each axis.
_INTO = 0.05
_WORTH = 0.8


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
    """Of the rotation, one sigma each, degrees; None where nothing determines it."""

    about_up: float | None
    about_east: float | None
    about_north: float | None


@dataclass(frozen=True)
class WeakestAxis:
    """The axis about which the model is held worst, and its 95 % error, degrees."""

    trend_deg: float
    plunge_deg: float
    error_deg: float | None


@dataclass(frozen=True)
class RotationError95:
    """The same three at 95 %, each by itself, and the worst axis of all."""

    about_up: float | None
    about_east: float | None
    about_north: float | None
    weakest: WeakestAxis


@dataclass(frozen=True)
class WorthAdding:
    """Where, in World, one more control point lessens the worst error of the rotation most: that
    error (95 %, degrees) before and after."""

    x: float
    y: float
    z: float
    error_before_deg: float
    error_after_deg: float


@dataclass(frozen=True)
class Known:
    """What the registration has fixed."""

    north: bool = True
    vertical: bool = True
    scale: bool = True
    position: bool = True

    @property
    def all(self) -> bool:
        return self.north and self.vertical and self.scale and self.position


@dataclass(frozen=True, repr=False)
class Placed(Shown):
    """A similarity from the model to World, and what it leaves over.

    matrix : 4 x 4, acts on column vectors of the model; scale : metres per unit of the model
    control : points that entered the fit; check : points that did not
    rms_control_m, rms_check_m : of the residuals' lengths, None without such points
    rotation_error_deg, rotation_error_95_deg, scale_error_95 (a share of the scale) : from the
        errors given, else from the residuals (Student's t with the degrees of freedom that these
        leave)
    covariance : (7, 7) of turns about east, north and up (rad), a relative change of scale and a
        shift (m), about `centre` (World); one sigma of a normal distribution with the same 95 %
    """

    matrix: tuple[tuple[float, ...], ...]
    scale: float
    control: tuple[PointResidual, ...]
    check: tuple[PointResidual, ...]
    rms_control_m: float | None
    rms_check_m: float | None
    rotation_error_deg: RotationError
    rotation_error_95_deg: RotationError95
    scale_error_95: float | None
    worth_adding: WorthAdding | None
    known: Known
    blunders: tuple[Blunder, ...]
    warnings: tuple[str, ...]
    covariance: tuple[tuple[float, ...], ...]
    centre: tuple[float, float, float]

    def __call__(self, points: npt.ArrayLike) -> Array:
        """(n, 3) World of model points (n, 3)."""
        m = np.asarray(self.matrix)
        return np.asarray(np.asarray(points, np.float64) @ m[:3, :3].T + m[:3, 3])

    def as_dict(self) -> dict[str, Any]:
        """Ready for JSON, with the names of the command."""
        told = asdict(self)
        del told["covariance"], told["centre"]
        return told


def place(
    kinds: Sequence[Observed],
    check: Points | None = None,
    extent: Array | None = None,
) -> Placed:
    """The registration by everything that is known.

    check : points that judge it and take no part
    extent : (n, 3) points of the model that show how far it reaches; None to take those given
    Raises GeometryError where nothing is given, and for too few points, or points on a line, with
    nothing else.
    """
    kinds = [kind for kind in kinds if len(kind.labels)]
    points = next((kind for kind in kinds if isinstance(kind, Points)), None)
    if points is not None and len(kinds) == 1:
        _require_enough(points)
    centre, size = _extent(kinds, extent)
    found = adjust(kinds, centre, size)
    known = _known(found)
    blunders = find_blunders(kinds, found, centre, size)
    control = _residuals(points, found.fit)
    checked = _residuals(check, found.fit)
    rotation, rotation95 = _rotation_errors(found, known)
    scale95 = _Z95 * float(np.sqrt(found.covariance[3, 3])) if known.scale else None
    warnings = [
        *_said_of_fit(found, kinds),
        *_said_of_points(control, checked, points),
        *_said_of_errors(rotation, scale95, known),
        *_said_of_blunders(kinds, blunders, found, centre, size),
        *_mirrored(points, found.fit),
    ]
    matrix = np.eye(4)
    matrix[:3, :3] = found.fit.scale * found.fit.rotation
    matrix[:3, 3] = found.fit.translation
    return Placed(
        matrix=tuple(tuple(row) for row in matrix.tolist()),
        scale=found.fit.scale,
        control=control,
        check=checked,
        rms_control_m=_rms(control),
        rms_check_m=_rms(checked),
        rotation_error_deg=rotation,
        rotation_error_95_deg=rotation95,
        scale_error_95=scale95,
        worth_adding=_worth_adding(found, points, extent, known),
        known=known,
        blunders=tuple(blunders),
        warnings=tuple(warnings),
        covariance=tuple(tuple(row) for row in found.covariance.tolist()),
        centre=(float(found.centre[0]), float(found.centre[1]), float(found.centre[2])),
    )


def _require_enough(points: Points) -> None:
    if len(points.labels) < 3:
        fit_similarity(points.model, points.world)
    if nearly_on_a_line(points.world) or nearly_on_a_line(points.model):
        raise GeometryError(
            tr(
                "The control points lie on one line, about which the model could turn. Add "
                "one beside it."
            )
        )


def _extent(kinds: Sequence[Observed], extent: Array | None) -> tuple[Array, float]:
    """(1, 3) the middle of the model, and how far it typically reaches from there."""
    places = [extent] if extent is not None and len(extent) else []
    if not places:
        for kind in kinds:
            places += [
                value
                for name in ("model", "first", "second")
                if isinstance(value := getattr(kind, name, None), np.ndarray)
                and value.ndim == 2
                and (isinstance(kind, Points) or name != "model")
            ]
    if not places:
        return np.zeros((1, 3)), 1.0
    every = np.concatenate(places)
    middle = every.mean(axis=0, keepdims=True)
    size = float(np.sqrt(((every - middle) ** 2).sum(axis=1).mean()))
    return middle, size if size > 0 else 1.0


# --- what is known ----------------------------------------------------------------------------
def _known(found: Adjusted) -> Known:
    free = found.free
    sigma = np.sqrt(np.maximum(np.diag(found.covariance), 0.0))

    def held(*rows: int) -> bool:
        return not free.shape[1] or bool(np.linalg.norm(free[list(rows)], axis=1).max() < _INTO)

    # The azimuth of an inclined line gives north to whoever knows the vertical.
    north = held(2) or found.information[2, 2] > 1.0 / _UNKNOWN_RAD**2
    return Known(
        north=bool(north and sigma[2] < _UNKNOWN_RAD),
        vertical=held(0, 1) and float(max(sigma[:2])) < _UNKNOWN_RAD,
        scale=held(3) and float(sigma[3]) < _UNKNOWN_SCALE,
        position=held(4, 5, 6),
    )


def _rotation_errors(found: Adjusted, known: Known) -> tuple[RotationError, RotationError95]:
    sigma = [float(v) for v in np.degrees(np.sqrt(np.maximum(np.diag(found.rotation), 0.0)))]
    free = found.free[:3]
    lost = np.linalg.norm(free, axis=1) > _INTO if free.shape[1] else np.zeros(3, bool)
    if known.north:
        lost[2] = False
    east, north, up = (None if gone else s for s, gone in zip(sigma, lost, strict=True))
    error = RotationError(up, east, north)
    if lost.any() or not (known.north and known.vertical):
        axis, worst = _free_axis(found), None
    else:
        values, axes = np.linalg.eigh(found.rotation)
        axis, worst = axes[:, -1], _Z95 * float(np.degrees(np.sqrt(max(values[-1], 0.0))))
    line = Line.from_vector(axis)

    def at95(value: float | None) -> float | None:
        return None if value is None else _Z95 * value

    return error, RotationError95(
        at95(up), at95(east), at95(north), WeakestAxis(line.trend_deg, line.plunge_deg, worst)
    )


def _free_axis(found: Adjusted) -> Array:
    """(3,) about which the model turns most freely."""
    free = found.free[:3]
    if free.shape[1]:
        u, s, _ = np.linalg.svd(free)
        if s[0] > _INTO:
            return np.asarray(u[:, 0], np.float64)
    return np.asarray(np.linalg.eigh(found.rotation)[1][:, -1], np.float64)


def _worth_adding(
    found: Adjusted, points: Points | None, extent: Array | None, known: Known
) -> WorthAdding | None:
    """One more point at the edge of the model, as good as those that are there."""
    from vomstudio.registration.similarity import jacobian

    if points is None or not known.all:
        return None
    reach = points.model if extent is None or not len(extent) else extent
    low, high = found.fit(reach).min(axis=0), found.fit(reach).max(axis=0)
    middle = (low + high) / 2
    corners = [
        np.where(which, high, low) for which in np.ndindex(2, 2, 2)
    ] + [np.where(np.arange(3) == k, end, middle) for k in range(3) for end in (low, high)]  # fmt: skip
    metres = found.error[: 3 * len(points.labels)].reshape(-1, 3)
    sigma = np.sqrt((metres**2).mean(axis=0))
    covariance = found.covariance
    before = _worst(covariance[:3, :3])
    best: tuple[float, Array] | None = None
    for corner in corners:
        moves = jacobian(corner - found.centre)
        gain = covariance @ moves.T
        spread = moves @ gain + np.diag(sigma**2)
        after = _worst((covariance - gain @ np.linalg.solve(spread, gain.T))[:3, :3])
        if best is None or after < best[0]:
            best = after, corner
    if best is None or not best[0] < _WORTH * before:
        return None
    x, y, z = (float(v) for v in best[1])
    return WorthAdding(x, y, z, before, best[0])


def _worst(rotation: Array) -> float:
    """95 %, degrees."""
    worst = float(np.linalg.eigvalsh(rotation)[-1])
    return _Z95 * float(np.degrees(np.sqrt(max(worst, 0.0))))


# --- residuals --------------------------------------------------------------------------------
def _residuals(points: Points | None, fit: Similarity) -> tuple[PointResidual, ...]:
    if points is None or not len(points.labels):
        return ()
    return tuple(
        PointResidual(label, dx, dy, dz, float(np.linalg.norm([dx, dy, dz])))
        for label, (dx, dy, dz) in zip(
            points.labels, (fit(points.model) - points.world).tolist(), strict=True
        )
    )


def _rms(points: Sequence[PointResidual]) -> float | None:
    return float(np.sqrt(np.mean([p.error_m**2 for p in points]))) if points else None


# --- sentences --------------------------------------------------------------------------------
def _said_of_fit(found: Adjusted, kinds: Sequence[Observed]) -> list[str]:
    said = []
    if found.overdrawn > 1.0:
        said.append(
            tr(
                "The residuals are {times:.1f} times what the stated accuracies allow: a value may "
                "be wrong, or the accuracies are too small. All errors were enlarged by as much.",
                times=found.overdrawn,
            )
        )
    if found.ambiguous:
        said.append(
            tr(
                "A quite different rotation fits as well; the one that tilts and turns the model "
                "least was taken. Add a point, or a direction that differs from the others."
            )
        )
    if found.assumed:
        said.append(
            tr(
                "Nothing is left over to judge the accuracy of the {kinds} by, and none is "
                "stated: a usual one was assumed. State it.",
                kinds=", ".join(tr(name) for name in found.assumed),
            )
        )
    return said


def _said_of_points(
    control: Sequence[PointResidual], check: Sequence[PointResidual], points: Points | None
) -> list[str]:
    if points is None:
        return []
    said = []
    if len(control) < 4:
        said.append(
            tr_n(
                "{count} control point leaves nothing over to find a mistake with. Use 4 or more.",
                "{count} control points leave nothing over to find a mistake with. Use 4 or more.",
                len(control),
            )
        )
    if not check:
        said.append(
            tr(
                "No check points judge the model independently of the points that placed it. Tick "
                "some as check points."
            )
        )
    return said


def _said_of_errors(error: RotationError, scale95: float | None, known: Known) -> list[str]:
    said = []
    lacking = [
        tr(word)
        for word, there in (
            ("north", known.north),
            ("the vertical", known.vertical),
            ("the scale", known.scale),
            ("the position", known.position),
        )
        if not there
    ]
    if lacking:
        said.append(
            tr(
                "Not known after this registration: {what}. What rests on it stays as in the "
                "model's file.",
                what=", ".join(lacking),
            )
        )
    up, east, north = error.about_up, error.about_east, error.about_north
    if up is not None and east is not None and north is not None and max(up, east, north) > (
        _WARN_DEG
    ):  # fmt: skip
        said.append(
            tr(
                "The model can be turned by about {turn:.1f}° and tilted by about {tilt:.1f}° "
                "(1 sigma): dip directions and dips can be wrong by as much. Spread the points "
                "wider.",
                turn=up,
                tilt=float(np.hypot(east, north)),
            )
        )
    if scale95 is not None and scale95 > _Z95 * _WARN_SCALE:
        said.append(
            tr(
                "The scale is known only to {error:.1f} % (95 %): lengths, thicknesses and areas "
                "can be wrong by as much. Place control points farther apart, or measure a scale "
                "bar.",
                error=100 * scale95,
            )
        )
    return said


def _said_of_blunders(
    kinds: Sequence[Observed],
    blunders: Sequence[Blunder],
    found: Adjusted,
    centre: Array,
    size: float,
) -> list[str]:
    from scipy.spatial.transform import Rotation

    if not blunders:
        return []
    named = {b.label for b in blunders}
    rest = [_without(kind, named) for kind in kinds]
    again = adjust([kind for kind in rest if len(kind.labels)], centre, size)
    turned = Rotation.from_matrix(again.fit.rotation @ found.fit.rotation.T).magnitude()
    return [
        tr(
            "{labels}: too far from where the others put it to be chance. Without it the model "
            "turns by {turn:.2g}°. Look the value up, or leave it out.",
            labels=", ".join(
                f"{b.label} ({b.error_m:.3g} m)" if b.error_m is not None
                else f"{b.label} ({b.error_deg:.2g}°)"
                for b in blunders
            ),
            turn=float(np.degrees(turned)),
        )
    ]  # fmt: skip


def _without(kind: Observed, labels: set[str]) -> Observed:
    from vomstudio.registration.blunders import chosen

    return chosen(kind, [label not in labels for label in kind.labels])


def _mirrored(points: Points | None, fit: Similarity) -> list[str]:
    """Whether points that fit badly are a mirror image of the others."""
    if points is None or len(points.labels) < 4:
        return []
    a, b = points.model, points.world
    left = float(((fit(a) - b) ** 2).sum())
    over = float(((b - b.mean(axis=0)) ** 2).sum())
    flipped = a * [1.0, 1.0, -1.0]
    try:
        again = fit_similarity(flipped, b)
    except GeometryError:
        return []
    if left > 1e-6 * over and float(((again(flipped) - b) ** 2).sum()) < 0.01 * left:
        return [
            tr(
                "The points fit as a mirror image: two axes of one of the frames are exchanged. "
                "Exchange the columns of easting and northing."
            )
        ]
    return []


def pairs(
    model: Array, world: Array, sigma_m: Array | None, labels: Sequence[str], which: Array
) -> Points:
    """Those of the pairs that are chosen. sigma_m : (n, 3), None where nothing is stated"""
    sigma = np.full(world.shape, np.nan) if sigma_m is None else sigma_m
    chosen_ = np.flatnonzero(which)
    return Points([labels[i] for i in chosen_], model[chosen_], world[chosen_], sigma[chosen_])


def register_points(
    model: Array,
    world: Array,
    sigma_m: Array | None = None,
    check: npt.NDArray[np.bool_] | None = None,
    labels: Sequence[str] | None = None,
) -> Placed:
    """The registration by pairs of points.

    model, world : (n, 3); sigma_m : (n, 3) one-sigma errors of the World coordinates, None to take
    them as equal and from the residuals; check : (n,) True for points that only judge
    Raises GeometryError for fewer than three control points, or control points on one line.
    """
    is_check = np.zeros(len(model), bool) if check is None else np.asarray(check, bool)
    names = list(labels) if labels is not None else [str(i + 1) for i in range(len(model))]
    control = pairs(model, world, sigma_m, names, ~is_check)
    judges = pairs(model, world, sigma_m, names, is_check)
    _require_enough(control)
    return place([control], judges)


def with_warnings(placed: Placed, warnings: Sequence[str]) -> Placed:
    """The same with what was said before it was found."""
    return replace(placed, warnings=(*warnings, *placed.warnings))
