"""Sentences on a registration: what may be wrong with it, and what to do."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geology.bowing import Bowing, LensBend, bowing_deg
from vomstudio.geology.notation import format_azimuth
from vomstudio.geology.orientation import Line
from vomstudio.registration.adjustment import Adjusted, adjust
from vomstudio.registration.blunders import Blunder, Without, chosen
from vomstudio.registration.combined import Combined
from vomstudio.registration.compass_checks import FEWEST_PLANES, azimuth_that_fits
from vomstudio.registration.observations import Directions, Lengths, Observed, Points, all_rows
from vomstudio.registration.results import Known, Placed, PointResidual, RotationError
from vomstudio.registration.scatter import drift_findings, scale_findings

_Z95 = 1.959963984540054
_WARN_DEG = 1.0
# One sigma, above which figures mean nothing: it could be turned to any side.
_ANY_DEG = 90.0
_WORTH_TELLING_DEG = 0.1
# What may be, and has not been seen, from edge to edge.
_WORTH_ASKING_DEG = 1.0
# Of the reach of points: by so much they miss where values are wrong, not by measuring.
_NOWHERE = 0.1
# Of the normal's upward part, below which a mean plane is a wall.
_UPRIGHT = np.sqrt(0.5)
# Residuals that are left, and the chance of misses as small, below which accuracies are doubted.
_FEWEST_LEFT, _HARDLY = 3.0, 1e-6
# A reading agrees with the others if it is nearer than this; the more if these say little.
_FITS_DEG = (10.0, 20.0)


def fit_findings(found: Adjusted, kinds: Sequence[Observed]) -> list[Finding]:
    findings: list[Finding] = []
    if found.overdrawn > 1.0:
        findings.append(Finding("registration.residuals-large", times=found.overdrawn))
    if (times := _too_good(found, kinds)) is not None:
        findings.append(
            Finding("registration.readings-copied", times=times)
            if not any(isinstance(kind, Points | Lengths | Combined) for kind in kinds)
            else Finding("registration.residuals-small", times=times)
        )
    findings += drift_findings(found.drift)
    if found.ambiguous:
        findings.append(Finding("registration.ambiguous"))
    if found.assumed:
        findings.append(
            Finding("registration.error-assumed", kinds=[tr(name) for name in found.assumed])
        )
    return findings


def _too_good(found: Adjusted, kinds: Sequence[Observed]) -> float | None:
    """How many times smaller the misses are than what was stated, where chance does not make them
    so; None where they are as they should be. A click may be better than the model's resolution, so
    the errors of clicks are not counted."""
    from scipy.stats import chi2

    exact = [kind.without_click() if isinstance(kind, Points | Lengths) else kind for kind in kinds]
    stated = all_rows(exact, found.fit, found.centre)[0].sigma
    if not len(stated) or not np.isfinite(stated).all() or found.redundancy < _FEWEST_LEFT:
        return None
    squares = float(((found.rows.misses / stated) ** 2).sum())
    if not squares > 0.0 or chi2.cdf(squares, found.redundancy) > _HARDLY:
        return None
    return float(np.sqrt(found.redundancy / squares))


def redundancy_findings(
    control: Sequence[PointResidual], check: Sequence[PointResidual], points: Points | None
) -> list[Finding]:
    if points is None:
        return []
    findings = []
    if len(control) < 4:
        findings.append(Finding("control.no-redundancy", count=len(control), least=4))
    if not check:
        findings.append(Finding("control.no-check-points"))
    return findings


def weakest_axis_finding(error_deg: float, trend_deg: float, plunge_deg: float) -> Finding:
    """error_deg : 95 %, about the axis of that trend and plunge"""
    return Finding(
        "registration.weakest-axis",
        error95_deg=error_deg,
        trend=format_azimuth(trend_deg),
        plunge_deg=plunge_deg,
        trend_deg=trend_deg,
    )


def worst_axis_findings(placed: Placed) -> list[Finding]:
    """How far the model may be turned, and where one more point would help most."""
    findings = []
    worst, adding = placed.rotation_error_95_deg.weakest, placed.worth_adding
    if worst.error_deg is not None:
        findings.append(weakest_axis_finding(worst.error_deg, worst.trend_deg, worst.plunge_deg))
    if adding is not None:
        findings.append(
            Finding(
                "registration.worth-adding",
                x=adding.x,
                y=adding.y,
                z=adding.z,
                after_deg=adding.error_after_deg,
            )
        )
    return findings


def vertical_error_findings(placed: Placed) -> list[Finding]:
    """How well the vertical is known where north may be free."""
    if not placed.known.vertical:
        return []
    tilt = float(np.linalg.eigvalsh(np.array(placed.covariance)[:2, :2])[-1])
    return [
        Finding(
            "registration.vertical", error95_deg=_Z95 * float(np.degrees(np.sqrt(max(tilt, 0.0))))
        )
    ]


def reference_fit_finding(
    places: int, overlap: float, rms_m: float, blocks: int, block_m: float
) -> Finding:
    """What a fit to a reference rests on; the figures of `FittedToReference`."""
    return Finding(
        "reference.fitted",
        places=places,
        overlap_percent=100.0 * overlap,
        rms_m=rms_m,
        blocks=blocks,
        block_m=block_m,
    )


def error_findings(
    error: RotationError,
    scale95: float | None,
    known: Known,
    points: Points | None,
    *,
    named: bool = False,
    share: float = 0.0,
) -> list[Finding]:
    """points : that placed it, of which `name` tells what they are; None without any
    share : of how far these reach, by which they miss (RMS)
    named : something was named that is wrong, which is to be mended before more is measured"""
    findings = []
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
        findings.append(Finding("registration.not-known", parameters=lacking))
    weak = []
    up, east, north = error.about_up, error.about_east, error.about_north
    if up is not None and east is not None and north is not None:
        tilt = float(np.hypot(east, north))
        if max(up, east, north) > _WARN_DEG:
            weak.append(
                Finding("registration.rotation-unknown")
                if max(up, tilt) > _ANY_DEG
                else Finding("registration.weak-rotation", azimuth_deg=up, tilt_deg=tilt)
            )
    if scale95 is not None:
        weak += scale_findings(scale95 / _Z95)
    nowhere = points is not None and points.name != "cameras" and share >= _NOWHERE
    if weak and nowhere and not named:
        findings.append(Finding("registration.points-nowhere", share_percent=100.0 * share))
    findings += weak
    return findings


def blunder_findings(
    kinds: Sequence[Observed],
    blunders: Sequence[Blunder],
    found: Adjusted,
    centre: FloatArray,
    size: float,
) -> list[Finding]:
    from scipy.spatial.transform import Rotation

    if not blunders:
        return []
    named = {b.label for b in blunders}
    rest = [chosen(kind, [label not in named for label in kind.labels]) for kind in kinds]
    again = adjust([kind for kind in rest if len(kind.labels)], centre, size)
    turned = Rotation.from_matrix(again.fit.rotation @ found.fit.rotation.T).magnitude()
    return [
        Finding(
            "registration.blunder",
            labels=[blunder.text() for blunder in blunders],
            turned_deg=float(np.degrees(turned)),
            scale_percent=100.0 * (again.fit.scale / found.fit.scale - 1.0),
        ),
        *_other_azimuth_findings(kinds, named, again),
    ]


def suspect_findings(without: Sequence[Without]) -> list[Finding]:
    """Of the suspect among a few directions, with what would become of the placement without it."""
    if not without or not without[0].suspect:
        return []
    first = without[0]
    findings = [
        Finding(
            "registration.suspect",
            label=first.label,
            error_deg=first.error_deg,
            others_deg=first.others_deg,
            turn_deg=first.turned_deg,
        )
    ]
    if first.azimuth_off_deg is not None:
        findings.append(_would_agree(first.label, first.azimuth_off_deg))
    return findings


def _would_agree(label: str, turn_deg: float) -> Finding:
    return Finding("compass.other-azimuth", turn_deg=turn_deg, labels=[label])


def _other_azimuth_findings(
    kinds: Sequence[Observed], named: set[str], rest: Adjusted
) -> list[Finding]:
    """Of the readings that were named among few: whether another azimuth would put them where all
    that is left does. Of more planes the most that agree tell (`azimuth_findings`)."""
    findings = []
    worst = float(np.degrees(np.sqrt(max(np.linalg.eigvalsh(rest.rotation)[-1], 0.0))))
    limit = float(np.clip(2.0 * _Z95 * worst, *_FITS_DEG))
    for kind in kinds:
        if not isinstance(kind, Directions) or len(kind.labels) >= FEWEST_PLANES:
            continue
        for label, model, world in zip(kind.labels, kind.model, kind.world, strict=True):
            if label in named:
                turn = azimuth_that_fits(rest.fit.rotation @ model, world, limit)
                findings += [] if turn is None else [_would_agree(label, turn)]
    return findings


def bowing_findings(found: Bowing | None, *, photos: bool = False) -> list[Finding]:
    """Whether the model is bent like a dome, in degrees of dip. photos : by the verticals of photos
    and not by points"""
    if found is None or not found.significant or found.across_deg < _WORTH_TELLING_DEG:
        return []
    by = (
        tr("the verticals of {count} photos", count=found.n)
        if photos
        else tr("the residuals of {count} points", count=found.n)
    )
    return [
        Finding(
            "registration.bowed",
            evidence=by,
            source="verticals" if photos else "residuals",
            n=found.n,
            rise_m=found.rise_m,
            where=where_edges_lie(found),
            side_deg=found.side_deg,
            error95_deg=found.side_error95_deg,
            across_deg=found.across_deg,
        )
    ]


def where_edges_lie(found: Bowing) -> str:
    """Beside the plane through the middle of a bowed model: a dome is a false anticline, a dish a
    false syncline, and of a wall neither word says to which side it bends."""
    toward = found.edges_toward
    if abs(float(toward[2])) < _UPRIGHT:
        return tr(
            "on its side towards {azimuth}",
            azimuth=format_azimuth(Line.from_vector(toward, directed=True).trend_deg),
        )
    return tr("above it (a dish)") if toward[2] > 0.0 else tr("below it (a dome)")


def lens_findings(bend: LensBend | None, seen: Bowing | None) -> list[Finding]:
    """How far the errors of the lenses may deform a model, where that is worth telling. seen : the
    bowing by residuals"""
    return [] if bend is None else lens_bend_findings(bend.across_deg, bend.stretch95, seen)


def lens_bend_findings(
    across95_deg: float, stretch95: float | None, seen: Bowing | None
) -> list[Finding]:
    """The same of a registration's record."""
    findings = []
    across = bowing_deg(across95_deg, seen)
    bent = seen is not None and seen.significant
    if across is not None and not bent and across > _WORTH_ASKING_DEG:
        findings.append(Finding("lens.bowing", side_deg=across / 2.0, across_deg=across))
    turn = float(np.degrees((stretch95 or 0.0) / 2.0))
    if turn > _WORTH_ASKING_DEG / 2.0:
        findings.append(
            Finding("lens.stretch", share_percent=100.0 * (stretch95 or 0.0), turn_deg=turn)
        )
    return findings
