"""A model placed by all that is known of its place, and what a geologist must know of that."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geology.bowing import FEWEST, Bowing, bowing_of, model_shape
from vomstudio.geology.orientation import Line
from vomstudio.geometry.coordinate_limits import why_no_error
from vomstudio.geometry.registrations import ObservationGroup
from vomstudio.registration.adjustment import Adjusted, adjust
from vomstudio.registration.blunders import (
    Blunder,
    Without,
    find_blunders,
    leave_one_out,
    left_out,
)
from vomstudio.registration.checks.mirrors import mirror_findings, tipping_findings
from vomstudio.registration.combined import Combined
from vomstudio.registration.consistency import (
    contradicted_scale,
    disagreement_findings,
    turned_norths,
)
from vomstudio.registration.length_evidence import kept_scale
from vomstudio.registration.likelihood import widened
from vomstudio.registration.observations import (
    KeptScale,
    Observed,
    PhotoUpright,
    Points,
    kind_name,
)
from vomstudio.registration.precision import add_rounding
from vomstudio.registration.results import (
    Known,
    Placed,
    PointResidual,
    RotationError,
    RotationError95,
    WeakestAxis,
    WorthAdding,
)
from vomstudio.registration.similarity import (
    Similarity,
    fit_similarity,
    jacobian,
    nearly_on_a_line,
)
from vomstudio.registration.turn_checks import turn_findings
from vomstudio.registration.warnings import (
    blunder_findings,
    bowing_findings,
    error_findings,
    fit_findings,
    redundancy_findings,
    suspect_findings,
)

_Z95 = 1.959963984540054
# One sigma of a turn or of the relative scale above which it is as good as not known.
_UNKNOWN_RAD = np.radians(30.0)
_UNKNOWN_SCALE = 0.5
# An unknown turn that is the same all around reaches this far into each axis.
_INTO = 0.05
_WORTH = 0.8
# One sigma, metres or rad; those that people state are held within narrower limits.
_ERRORS = 1e-9, 1e9
# Times the error of points, as it is stated or as residuals show it, that they must be off their
# line. What is noise alone is off by 1.4 times that, which by four points looks like a tenth in one
# set of thousands.
_OFF_STATED, _OFF_SEEN, _FEWEST_OFF = 6.0, 10.0, 4


def place(
    kinds: Sequence[Observed],
    check: Points | None = None,
    extent: FloatArray | None = None,
    *,
    up: FloatArray | None = None,
    doubted: bool = False,
) -> Placed:
    """The registration by everything that is known.

    check : points that judge it and take no part
    extent : (n, 3) points of the model that show how far it reaches; None to take those given
    up : (3,) in the model's frame, where that is known beforehand
    doubted : something was finding of the values that is to be mended before more is measured
    Raises GeometryError where nothing is given, and for too few points, or points on a line, with
    nothing else.
    """
    kinds = [kind for kind in kinds if len(kind.labels)]
    if not kinds and check is not None and len(check.labels):
        raise GeometryError(Finding("control.all-check", count=len(check.labels)))
    points = next((kind for kind in kinds if isinstance(kind, Points)), None)
    _require_values(kinds)
    if points is not None and len(kinds) == 1:
        _require_enough(points)
    centre, size = _extent(kinds, extent)
    # Readings that are all off alike are none of them wrong beside the others.
    contradiction, consistent = contradicted_scale(kinds, centre, size)
    norths, judged = turned_norths(consistent, centre, size)
    found = widened(judged, adjust(judged, centre, size), centre)
    found = add_rounding(judged, found, centre, size)
    known = _known(found, judged)
    mirrors = mirror_findings(points)
    blunders, without = _wrong(judged, found, centre, size, mirrored=bool(mirrors))
    control = _residuals(points, found.fit)
    share = _share(points, control)
    checked = _residuals(check, found.fit)
    rotation, rotation95 = _rotation_errors(found, known)
    scale95 = _Z95 * float(np.sqrt(found.covariance[3, 3])) if known.scale else None
    named = [
        *(suspect_findings(without) or blunder_findings(judged, blunders, found, centre, size)),
        *mirrors,
        *tipping_findings(found.fit.rotation, up, None if mirrors else points),
    ]
    doubted = doubted or bool(named)
    warnings = [
        *named,
        *fit_findings(found, kinds),
        *([] if contradiction is None else [contradiction.finding]),
        *disagreement_findings(judged, centre, size),
        *(north.finding for north in norths),
        *redundancy_findings(control, checked, points),
        *error_findings(rotation, scale95, known, points, named=doubted, share=share),
        *turn_findings(found.rotation),
        *bowing_findings(_bowing(points, check, {b.label for b in blunders}, found.fit, extent)),
    ]
    shape = _shape(extent, found.fit)
    return Placed(
        matrix=_matrix(found.fit),
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
        without=tuple(without),
        warnings=tuple(warnings),
        covariance=tuple(tuple(row) for row in found.covariance.tolist()),
        centre=(float(found.centre[0]), float(found.centre[1]), float(found.centre[2])),
        reach_m=shape[0],
        normal=shape[1],
        observations=tuple(
            ObservationGroup(kind_name(kind), tuple(map(str, kind.labels))) for kind in kinds
        ),
    )


def place_robustly(
    kinds: Sequence[Observed],
    check: Points | None = None,
    extent: FloatArray | None = None,
    *,
    up: FloatArray | None = None,
    doubted: bool = False,
) -> Placed:
    """The registration without what cannot be right beside the others, which is named all the same.
    Raises GeometryError as `place` does."""
    first = place(kinds, check, extent, up=up, doubted=doubted)
    if not first.blunders:
        return first
    labels = [blunder.label for blunder in first.blunders]
    rest, judges = left_out(kinds, check, labels)
    placed = place(rest, judges, extent, up=up, doubted=doubted)
    finding = Finding(
        "registration.left-out", labels=[blunder.text() for blunder in first.blunders]
    )
    return replace(
        placed,
        blunders=(*first.blunders, *placed.blunders),
        warnings=(finding, *placed.warnings),
    )


def _wrong(
    kinds: Sequence[Observed], found: Adjusted, centre: FloatArray, size: float, *, mirrored: bool
) -> tuple[list[Blunder], list[Without]]:
    """What cannot be right beside the others, and what a few directions are worth one by one."""
    # What is mirrored fits nowhere, and no single one is wrong.
    blunders = [] if mirrored else find_blunders(kinds, found, centre, size)
    without = leave_one_out(kinds, found, centre, size)
    if without and without[0].suspect:
        blunders = [Blunder(without[0].label, None, None, without[0].error_deg)]
    return blunders, without


def _matrix(fit: Similarity) -> FloatArray:
    matrix = np.eye(4)
    matrix[:3, :3] = fit.scale * fit.rotation
    matrix[:3, 3] = fit.translation
    return matrix


def _shape(
    extent: FloatArray | None, fit: Similarity
) -> tuple[float | None, tuple[float, float, float] | None]:
    """How far the model reaches, and the normal of its mean plane."""
    if extent is None or len(extent) < FEWEST:
        return None, None
    _, axes, reach = model_shape(fit(extent))
    x, y, z = (float(v) for v in axes[2])
    return reach, (x, y, z)


def _require_enough(points: Points) -> None:
    if len(points.labels) < 3:
        fit_similarity(points.model, points.world)
    on_a_line = nearly_on_a_line(points.world) or nearly_on_a_line(points.model)
    if on_a_line and not _off_their_line(points):
        raise GeometryError(Finding("control.collinear"))


def _require_values(kinds: Sequence[Observed]) -> None:
    """Raises GeometryError for points that are all one, and for errors that nothing has."""
    for kind in kinds:
        if isinstance(kind, Points) and len(kind.labels) > 1:
            for places in (kind.world, kind.model):
                if float(np.ptp(places, axis=0).max()) <= 1e-12 * float(np.abs(places).max()):
                    raise GeometryError(Finding("control.one-place"))
        sigma = np.asarray(getattr(kind, "sigma", ()), np.float64)
        wrong = np.isfinite(sigma) & ~((sigma >= _ERRORS[0]) & (sigma <= _ERRORS[1]))
        if wrong.any() and not isinstance(kind, Combined | KeptScale):
            finding = why_no_error(float(sigma[wrong][0]))
            assert finding is not None
            raise GeometryError(finding, field=kind.labels[int(np.argwhere(wrong)[0, 0])])


def _off_their_line(points: Points) -> bool:
    """Whether points that lie nearly on a line are off it by so much more than they err that they
    tell the turn about it, to some degrees."""
    n = len(points.labels)
    try:
        fit = fit_similarity(points.model, points.world)
    except GeometryError:
        return False
    sigma = points.total_sigma(fit)
    if np.isfinite(sigma).all():
        wanted = _OFF_STATED * float(np.sqrt((sigma**2).mean()))
    elif n >= _FEWEST_OFF:
        squares = float(((fit(points.model) - points.world) ** 2).sum())
        wanted = _OFF_SEEN * float(np.sqrt(squares / (3 * n - 7)))
    else:
        return False
    off = [
        float(np.linalg.svd(p - p.mean(axis=0), compute_uv=False)[1]) / np.sqrt(n)
        for p in (points.world, fit(points.model))
    ]
    return bool(min(off) > wanted)


def _extent(kinds: Sequence[Observed], extent: FloatArray | None) -> tuple[FloatArray, float]:
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
    fitted = [kind for kind in kinds if isinstance(kind, Combined)]
    if not places and fitted:
        start = fitted[0].start
        return start.inverse(fitted[0].about[None]), fitted[0].size / start.scale
    if not places:
        return np.zeros((1, 3)), 1.0
    every = np.concatenate(places)
    middle = every.mean(axis=0, keepdims=True)
    size = float(np.sqrt(((every - middle) ** 2).sum(axis=1).mean()))
    return middle, size if size > 0 else 1.0


# --- what is known ----------------------------------------------------------------------------
def _known(found: Adjusted, kinds: Sequence[Observed]) -> Known:
    free = found.free
    sigma = np.sqrt(np.maximum(np.diag(found.covariance), 0.0))
    tilt = float(np.sqrt(max(np.linalg.eigvalsh(found.covariance[:2, :2])[-1], 0.0)))
    # How photos were held does not make the vertical known: the other observations must.
    priors = [float(kind.sigma[0, 0]) for kind in kinds if isinstance(kind, PhotoUpright)]
    unknown_tilt = sum(sigma_rad**-2 for sigma_rad in (_UNKNOWN_RAD, *priors)) ** -0.5

    def held(*rows: int) -> bool:
        return not free.shape[1] or bool(np.linalg.norm(free[list(rows)], axis=1).max() < _INTO)

    # The azimuth of an inclined line gives north to whoever knows the vertical.
    north = held(2) or found.information[2, 2] > 1.0 / _UNKNOWN_RAD**2
    return Known(
        north=bool(north and sigma[2] < _UNKNOWN_RAD),
        vertical=held(0, 1) and bool(tilt < unknown_tilt),
        scale=held(3) and bool(sigma[3] < _UNKNOWN_SCALE),
        position=held(4, 5, 6),
    )


def _rotation_errors(found: Adjusted, known: Known) -> tuple[RotationError, RotationError95]:
    free = found.free[:3]
    lost = np.linalg.norm(free, axis=1) > _INTO if free.shape[1] else np.zeros(3, bool)
    if known.north:
        lost[2] = False

    def told(covariance: FloatArray, times: float) -> list[float | None]:
        sigma = np.degrees(np.sqrt(np.maximum(np.diag(covariance)[:3], 0.0)))
        return [None if gone else times * float(s) for s, gone in zip(sigma, lost, strict=True)]

    if lost.any() or not (known.north and known.vertical):
        axis, worst = _free_axis(found), None
    else:
        values, axes = np.linalg.eigh(found.rotation)
        axis, worst = axes[:, -1], _Z95 * float(np.degrees(np.sqrt(max(values[-1], 0.0))))
    line = Line.from_vector(axis)
    east, north, up = told(found.plain, 1.0)
    east95, north95, up95 = told(found.covariance, _Z95)
    weakest = WeakestAxis(line.trend_deg, line.plunge_deg, worst)
    return RotationError(up, east, north), RotationError95(up95, east95, north95, weakest)


def _free_axis(found: Adjusted) -> FloatArray:
    """(3,) about which the model turns most freely."""
    free = found.free[:3]
    if free.shape[1]:
        u, s, _ = np.linalg.svd(free)
        if s[0] > _INTO:
            return np.asarray(u[:, 0], np.float64)
    return np.asarray(np.linalg.eigh(found.rotation)[1][:, -1], np.float64)


def _worth_adding(
    found: Adjusted, points: Points | None, extent: FloatArray | None, known: Known
) -> WorthAdding | None:
    """One more point at the edge of the model, as good as those that are there."""
    if points is None or not known.all:
        return None
    reach = points.model if extent is None or not len(extent) else extent
    low, high = found.fit(reach).min(axis=0), found.fit(reach).max(axis=0)
    middle = (low + high) / 2
    corners = [np.where(which, high, low) for which in np.ndindex(2, 2, 2)]
    for axis in range(3):
        corners += [np.where(np.arange(3) == axis, end, middle) for end in (low, high)]
    own = slice(3 * len(points.labels))
    squares = found.error[own].reshape(-1, 3) ** 2
    if found.rows.axes is not None:
        squares = np.einsum("nji,nj->ni", found.rows.axes[own].reshape(-1, 3, 3) ** 2, squares)
    sigma = np.sqrt(squares.mean(axis=0))
    covariance = found.covariance
    before = _worst(covariance[:3, :3])
    best: tuple[float, FloatArray] | None = None
    for corner in corners:
        moves = jacobian(corner - found.centre)
        gain = covariance @ moves.T
        spread = moves @ gain + np.diag(sigma**2)
        # Points that fit exactly have no spread, which has no inverse.
        inverse = np.linalg.pinv(spread, hermitian=True)
        after = _worst((covariance - gain @ inverse @ gain.T)[:3, :3])
        if best is None or after < best[0]:
            best = after, corner
    if best is None or not best[0] < _WORTH * before:
        return None
    x, y, z = (float(v) for v in best[1])
    return WorthAdding(x, y, z, before, best[0])


def _worst(rotation: FloatArray) -> float:
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


def _bowing(
    control: Points | None,
    check: Points | None,
    wrong: set[str],
    fit: Similarity,
    extent: FloatArray | None,
) -> Bowing | None:
    """By control and check points together; those that are wrong are left out."""
    given = [points for points in (control, check) if points is not None and len(points.labels)]
    if not given:
        return None
    right = np.array([label not in wrong for points in given for label in points.labels])
    model, world, sigma = (
        np.concatenate(arrays)[right]
        for arrays in zip(
            *((each.model, each.world, each.total_sigma(fit)) for each in given), strict=True
        )
    )
    reach = None if extent is None or not len(extent) else fit(extent)
    return bowing_of(world, fit(model) - world, sigma, reach)


def _rms(points: Sequence[PointResidual]) -> float | None:
    return float(np.sqrt(np.mean([p.error_m**2 for p in points]))) if points else None


def _share(points: Points | None, residuals: Sequence[PointResidual]) -> float:
    """By how much of their reach points miss (RMS)."""
    rms = _rms(residuals)
    if points is None or rms is None:
        return 0.0
    reach = float(np.sqrt(((points.world - points.world.mean(axis=0)) ** 2).sum(axis=1).mean()))
    return rms / reach if reach > 0.0 else 0.0


def pairs(
    model: FloatArray,
    world: FloatArray,
    sigma_m: FloatArray | None,
    labels: Sequence[str],
    which: FloatArray,
    *,
    click_sigma_m: float | None = None,
) -> Points:
    """Those of the pairs that are chosen. sigma_m : (n, 3), None where nothing is stated"""
    sigma = np.full(world.shape, np.nan) if sigma_m is None else sigma_m
    rows = np.flatnonzero(which)
    click_m = np.full(len(rows), click_sigma_m) if click_sigma_m else None
    return Points(
        [labels[int(i)] for i in rows], model[rows], world[rows], sigma[rows], click_m=click_m
    )


def register_points(
    model: FloatArray,
    world: FloatArray,
    sigma_m: FloatArray | None = None,
    check: BoolArray | None = None,
    labels: Sequence[str] | None = None,
    *,
    click_sigma_m: float | None = None,
    scale: float | None = None,
    robust: bool = False,
) -> Placed:
    """The registration by pairs of points.

    model, world : (n, 3); sigma_m : (n, 3) one-sigma errors of the World coordinates, None to take
    them as equal and from the residuals; check : (n,) True for points that only judge
    click_sigma_m : one-sigma error of each coordinate of the points of the model, metres, which
    counts beside `sigma_m`; None if not known: it is then taken as 0, which a finding reports
    scale : metres per unit of the model, where that is known and kept; robust : points that cannot
    be right beside the others are left out
    Raises GeometryError for fewer than three control points, or control points on one line.
    """
    is_check = np.zeros(len(model), bool) if check is None else np.asarray(check, bool)
    names = list(labels) if labels is not None else [str(i + 1) for i in range(len(model))]
    control, judges = (
        pairs(model, world, sigma_m, names, which, click_sigma_m=click_sigma_m)
        for which in (~is_check, is_check)
    )
    _require_enough(control)
    kinds: list[Observed] = [control]
    if scale is not None:
        kinds += kept_scale(scale, kinds, None)
    placed = (place_robustly if robust else place)(kinds, judges)
    placed = replace(placed, click_sigma_m=click_sigma_m or 0.0)
    if click_sigma_m is not None or sigma_m is None:
        return placed
    return with_warnings(placed, [Finding("control.click-error-unknown")])


def with_warnings(placed: Placed, warnings: Sequence[Finding]) -> Placed:
    """Return the placement with warnings that were reported before it was computed."""
    return replace(placed, warnings=(*warnings, *placed.warnings))
