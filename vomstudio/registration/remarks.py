"""Sentences on a registration: what may be wrong with it, and what to do."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from vomstudio.core.findings import Message
from vomstudio.geology.bowing import Bowing, LensBend, bowing_deg
from vomstudio.geology.notation import format_azimuth
from vomstudio.geology.orientation import Line
from vomstudio.registration.adjustment import Adjusted, adjust
from vomstudio.registration.blunders import Blunder, Without, chosen
from vomstudio.registration.combined import Combined
from vomstudio.registration.compass_checks import FEWEST_PLANES, azimuth_that_fits
from vomstudio.registration.observations import Directions, Lengths, Observed, Points, all_rows
from vomstudio.registration.results import Known, Placed, PointResidual, RotationError
from vomstudio.registration.scatter import drift_findings, scale_warning
from vomstudio.words import tr, tr_n

Array = npt.NDArray[np.float64]

_Z95 = 1.959963984540054
_WARN_DEG = 1.0
# One sigma, above which figures mean nothing: it could be turned to any side.
_ANY_DEG = 90.0
_WORTH_TELLING_DEG = 0.1
# What may be, and has not been seen, from edge to edge.
_WORTH_ASKING_DEG = 1.0
_NO_TURN_RAD = 1e-7
# Of the reach of points: by so much they miss where values are wrong, not by measuring.
_NOWHERE = 0.1
# Of the normal's upward part, below which a mean plane is a wall.
_UPRIGHT = np.sqrt(0.5)
# Residuals that are left, and the chance of misses as small, below which accuracies are doubted.
_FEWEST_LEFT, _HARDLY = 3.0, 1e-6
# A reading agrees with the others if it is nearer than this; the more if these say little.
_FITS_DEG = (10.0, 20.0)


def said_of_fit(found: Adjusted, kinds: Sequence[Observed]) -> list[Message]:
    said: list[Message] = []
    if found.overdrawn > 1.0:
        said.append(
            tr(
                "The residuals are {times:.1f} times what the stated accuracies allow: a value may "
                "be wrong, or the accuracies are too small. All errors were enlarged by as much.",
                times=found.overdrawn,
            )
        )
    if (times := _too_good(found, kinds)) is not None:
        said.append(
            tr(
                "The readings agree {times:,.0f} times better than their stated accuracies allow: "
                "they may have been taken from the model, or the accuracies are too large. All "
                "stated errors rest on them.",
                times=times,
            )
            if not any(isinstance(kind, Points | Lengths | Combined) for kind in kinds)
            else tr(
                "The residuals are {times:,.0f} times smaller than the stated accuracies: these "
                "may be in another unit, such as millimetres. State them in metres: "
                "all stated errors rest on them.",
                times=times,
            )
        )
    said += drift_findings(found.drift)
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


def said_of_points(
    control: Sequence[PointResidual], check: Sequence[PointResidual], points: Points | None
) -> list[str]:
    if points is None:
        return []
    said = []
    if len(control) < 4:
        said.append(
            tr_n(
                "By {count} control point no mistake can be found. Use 4 or more.",
                "By {count} control points no mistake can be found. Use 4 or more.",
                len(control),
            )
        )
    if not check:
        said.append(
            tr(
                "There are no check points that judge the model independently of the points that "
                "placed it. Leave some out as check points."
            )
        )
    return said


def said_of_turn(error_deg: float, trend_deg: float, plunge_deg: float) -> str:
    """error_deg : 95 %, about the axis of that trend and plunge"""
    return tr(
        "The model may be turned by {error:.2g}° (95 %) about the axis "
        "{trend}/{plunge:02.0f}: dips and dip directions by as much.",
        error=error_deg,
        trend=format_azimuth(trend_deg),
        plunge=plunge_deg,
    )


def said_of_worst(placed: Placed) -> list[str]:
    """How far the model may be turned, and where one more point would help most."""
    said = []
    worst, adding = placed.rotation_error_95_deg.weakest, placed.worth_adding
    if worst.error_deg is not None:
        said.append(said_of_turn(worst.error_deg, worst.trend_deg, worst.plunge_deg))
    if adding is not None:
        said.append(
            tr(
                "One more control point near {x:.1f}, {y:.1f}, {z:.1f} would lessen that to "
                "{after:.2g}°.",
                x=adding.x,
                y=adding.y,
                z=adding.z,
                after=adding.error_after_deg,
            )
        )
    return said


def said_of_vertical(placed: Placed) -> list[str]:
    """How well the vertical is known where north may be free."""
    if not placed.known.vertical:
        return []
    tilt = float(np.linalg.eigvalsh(np.array(placed.covariance)[:2, :2])[-1])
    return [
        tr(
            "The vertical is known to ± {error:.2g}° (95 %): dips may be wrong by as much.",
            error=_Z95 * float(np.degrees(np.sqrt(max(tilt, 0.0)))),
        )
    ]


def said_of_fitted(places: int, overlap: float, rms_m: float, blocks: int, block_m: float) -> str:
    """What a fit to a reference rests on; the figures of `FittedToReference`."""
    return tr(
        "Fitted to the reference at {places} places ({share:.0f} % of the model), which it misses "
        "by {rms:.3g} m (robust, 1 sigma); the error is that of {blocks} blocks of {side:.3g} m.",
        places=places,
        share=100.0 * overlap,
        rms=rms_m,
        blocks=blocks,
        side=block_m,
    )


def said_of_errors(
    error: RotationError,
    scale95: float | None,
    known: Known,
    points: Points | None,
    *,
    named: bool = False,
    share: float = 0.0,
) -> list[str]:
    """points : that placed it, of which `name` tells what they are; None without any
    share : of how far these reach, by which they miss (RMS)
    named : something was named that is wrong, which is to be mended before more is measured"""
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
    first = tr("Mend first what is named above.") if named else _said_of_misses(points, share)
    up, east, north = error.about_up, error.about_east, error.about_north
    if up is not None and east is not None and north is not None and max(up, east, north) > (
        _WARN_DEG
    ):  # fmt: skip
        what = first or _what_helps(points)
        said.append(
            tr("How the model is turned is as good as unknown. {what}", what=what)
            if max(up, float(np.hypot(east, north))) > _ANY_DEG
            else tr(
                "The model can be turned by about {turn:.1f}° and tilted by about {tilt:.1f}° "
                "(1 sigma): dip directions and dips can be wrong by as much. {what}",
                turn=up,
                tilt=float(np.hypot(east, north)),
                what=what,
            )
        )
    if scale95 is not None and (scale := scale_warning(scale95 / _Z95, first)):
        said.append(scale)
    return said


def _said_of_misses(points: Points | None, share: float) -> str:
    """What helps where points fit nowhere, "" where they do."""
    if points is None or points.name == "cameras" or share < _NOWHERE:
        return ""
    return tr(
        "The points miss by {share:.0f} % of how far they reach, which no spread of them mends: "
        "several labels, coordinates or heights are wrong, or of two systems. Compare the table "
        "with the model.",
        share=100.0 * share,
    )


def _what_helps(points: Points | None) -> str:
    if points is None:
        return tr("Add readings, or control points that are spread wide.")
    if points.name == "cameras":
        return tr("Add control points, or photos from farther beside the others.")
    return tr("Spread the points wider.")


def said_of_blunders(
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
    rest = [chosen(kind, [label not in named for label in kind.labels]) for kind in kinds]
    again = adjust([kind for kind in rest if len(kind.labels)], centre, size)
    turned = Rotation.from_matrix(again.fit.rotation @ found.fit.rotation.T).magnitude()
    labels = ", ".join(blunder.in_words() for blunder in blunders)
    other = _said_of_other_azimuths(kinds, named, again)
    if not turned > _NO_TURN_RAD:
        return [
            tr(
                "{labels}: too far from where the others put it to be chance. Without it the scale "
                "changes by {share:+.2g} %. Look the value up, or leave it out (--without).",
                labels=labels,
                share=100.0 * (again.fit.scale / found.fit.scale - 1.0),
            ),
            *other,
        ]
    return [
        tr(
            "{labels}: too far from where the others put it to be chance. Without it the model "
            "turns by {turn:.2g}°. Look the value up, or leave it out (--without).",
            labels=labels,
            turn=float(np.degrees(turned)),
        ),
        *other,
    ]


def said_of_without(without: Sequence[Without]) -> list[str]:
    """Of the suspect among a few directions, with what would become of the placement without it."""
    if not without or not without[0].suspect:
        return []
    first = without[0]
    said = [
        tr(
            "{label}: {error:.0f}° from where the others put it, too far to be chance. Without it "
            "these agree to {others:.1f}° (RMS) and the model turns by {turn:.1f}°. Look the value "
            "up, or leave it out (--without).",
            label=first.label,
            error=first.error_deg,
            others=first.others_deg,
            turn=first.turned_deg,
        )
    ]
    if first.azimuth_off_deg is not None:
        said.append(_would_agree(first.label, first.azimuth_off_deg))
    return said


def _would_agree(label: str, turn_deg: float) -> str:
    return tr(
        "{label} would agree if {turn:+.0f}° were added to its azimuth: a strike may have been "
        "read as dip direction, or the opposite direction.",
        label=label,
        turn=turn_deg,
    )


def _said_of_other_azimuths(
    kinds: Sequence[Observed], named: set[str], rest: Adjusted
) -> list[str]:
    """Of the readings that were named among few: whether another azimuth would put them where all
    that is left does. Of more planes the most that agree tell (`said_of_azimuths`)."""
    said = []
    worst = float(np.degrees(np.sqrt(max(np.linalg.eigvalsh(rest.rotation)[-1], 0.0))))
    limit = float(np.clip(2.0 * _Z95 * worst, *_FITS_DEG))
    for kind in kinds:
        if not isinstance(kind, Directions) or len(kind.labels) >= FEWEST_PLANES:
            continue
        for label, model, world in zip(kind.labels, kind.model, kind.world, strict=True):
            if label in named:
                turn = azimuth_that_fits(rest.fit.rotation @ model, world, limit)
                said += [] if turn is None else [_would_agree(label, turn)]
    return said


def said_of_bowing(found: Bowing | None, *, photos: bool = False) -> list[str]:
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
        tr(
            "The model is bowed: by {evidence} its edges are {rise:.2g} m off "
            "the plane through its middle, {where}, so that dips at an edge differ by "
            "{side:.1f}° ± {error:.1f}° (95 %) from those in the middle, and by {across:.1f}° from "
            "those at the opposite edge. A fold whose limbs differ by less may be the bowing. "
            "Calibrate the lens, add oblique photos or control, and reconstruct again.",
            evidence=by,
            rise=found.rise_m,
            where=where_edges_lie(found),
            side=found.side_deg,
            error=found.side_error95_deg,
            across=found.across_deg,
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


def said_of_lenses(bend: LensBend | None, seen: Bowing | None) -> list[str]:
    """How far the errors of the lenses may deform a model, where that is worth telling. seen : the
    bowing by residuals"""
    return [] if bend is None else said_of_lens_bend(bend.across_deg, bend.stretch95, seen)


def said_of_lens_bend(
    across95_deg: float, stretch95: float | None, seen: Bowing | None
) -> list[str]:
    """The same of a registration's record."""
    said = []
    across = bowing_deg(across95_deg, seen)
    bent = seen is not None and seen.significant
    if across is not None and not bent and across > _WORTH_ASKING_DEG:
        said.append(
            tr(
                "The errors of the lenses (95 %) can bow the model so that dips at an edge differ "
                "by {side:.1f}° from those in the middle, and by {across:.1f}° from those at the "
                "opposite edge. A fold whose limbs differ by less may be the bowing. Calibrate the "
                "lens, or add oblique photos or control.",
                side=across / 2.0,
                across=across,
            )
        )
    turn = float(np.degrees((stretch95 or 0.0) / 2.0))
    if turn > _WORTH_ASKING_DEG / 2.0:
        said.append(
            tr(
                "The errors of the lenses (95 %) can stretch depths by {share:.1f} %, which turns "
                "planes that are inclined to the outcrop's face by up to {turn:.1f}°.",
                share=100.0 * (stretch95 or 0.0),
                turn=turn,
            )
        )
    return said
