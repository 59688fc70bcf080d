"""What is said of a fold beside its verdict: its numbers, and what they do not tell."""

from __future__ import annotations

import math

from vomstudio.geology.folding.limbs import Limbs
from vomstudio.geology.folding.shapes import Shape
from vomstudio.geology.folding.verdicts import WEAK_AXIS_DEG, Verdict
from vomstudio.words import tr


def bowed_in_words(bowed_deg: float | None, arc_deg: float) -> list[str]:
    """A dome looks like an open fold: limbs that differ by no more prove none."""
    if bowed_deg is None or arc_deg >= bowed_deg:
        return []
    return [
        tr(
            "the model may be bowed so that dips differ by {bowed:.1f} degrees from edge to edge, "
            "and these poles differ by {arc:.1f} degrees only: the fold may be the bowing",
            bowed=bowed_deg,
            arc=arc_deg,
        )
    ]


def shape_in_words(shape: Shape) -> list[str]:
    said = [
        tr(
            "n = {n}, poles {rms_deg:.1f} degrees RMS from the great circle, along "
            "{arc_deg:.0f} degrees of it",
            n=shape.n,
            rms_deg=shape.rms_deg,
            arc_deg=shape.arc_deg,
        )
    ]
    if shape.limbs is not None and shape.limbs.doubt:
        said.append(_untold_limbs(shape.limbs))
    if shape.n == 2:
        said.append(tr("two planes always meet in a line: its error is unknown"))
    return said


def lone_plane_in_words(
    name: str, turn_deg: float | None, error95_deg: float, other: Verdict | None
) -> str:
    """Why a verdict rests on one plane: without it beta turns so far, or the others have another
    verdict, or (neither) one dip."""
    if turn_deg is not None:
        return tr(
            "the verdict rests on one plane: without plane {name} beta turns by {turn:.0f} "
            "degrees, more than its stated error of {error:.1f} degrees (95 %); measure more "
            "planes that lie as that one does",
            name=name,
            turn=turn_deg,
            error=error95_deg,
        )
    if other is None or other.name == "homoclinal":
        return tr(
            "the verdict rests on one plane: without plane {name} the others have one dip, and no "
            "axis; measure more planes that lie as that one does",
            name=name,
        )
    return tr(
        "the verdict rests on one plane: without plane {name} the others are {other} "
        "({why}); measure more planes that lie as that one does",
        name=name,
        other=other.name,
        why=other.reasons[0],
    )


def hardly_told_in_words(name: str, other: Verdict) -> str:
    """That but for one plane a cone would not be told from a cylinder."""
    return tr(
        "only plane {name} tells a cone from a cylinder: without it {why}",
        name=name,
        why=other.reasons[0],
    )


def _untold_limbs(limbs: Limbs) -> str:
    """Why there is no interlimb angle, and the remedy."""
    first, second = limbs.counts
    if limbs.doubt == "hinge":
        return tr(
            "no interlimb angle: the poles are in two groups ({first} and {second} planes) "
            "{apart:.0f} degrees apart: they may be two limbs, or the hinge and both limbs of a "
            "tight fold, whose poles fall together; put each limb in a set of its own, without the "
            "hinge",
            first=first, second=second, apart=limbs.apart_deg,
        )  # fmt: skip
    if limbs.doubt == "mixed":
        return tr(
            "no interlimb angle: of the two groups of poles ({first} and {second} planes) one has "
            "overturned beds and others; put each limb in a set of its own",
            first=first, second=second,
        )  # fmt: skip
    return tr(
        "no interlimb angle: of the two groups of poles ({first} and {second} planes) one is an "
        "arc rather than a limb; put each limb in a set of its own, without the hinge",
        first=first, second=second,
    )  # fmt: skip


def error_in_words(semi_axes: tuple[float, float]) -> list[str]:
    major, minor = semi_axes
    text = tr(
        "beta is known to {major:.1f} by {minor:.1f} degrees (joint 95 %)", major=major, minor=minor
    )
    if major > WEAK_AXIS_DEG:
        return [tr("{text}: over {limit:.0f}, too weak to rely on", text=text, limit=WEAK_AXIS_DEG)]
    cost = 100.0 * (1.0 - math.cos(math.radians(major)))
    shift = 100.0 * math.sin(math.radians(major))
    return [
        tr(
            "{text}: a direction wrong by {major:.1f} shortens lengths by {cost:.1f} % "
            "and displaces by {shift:.0f} % of the depth of the view",
            text=text,
            major=major,
            cost=cost,
            shift=shift,
        )
    ]
