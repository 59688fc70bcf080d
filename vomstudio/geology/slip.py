"""Which way a fault has slipped: the sense seen on its plane and the line along which it moved."""

from __future__ import annotations

from typing import Literal

from vomstudio.core.words import to_translate as _
from vomstudio.geology.orientation import ANGLE_TOLERANCE_DEG, Plane

SlipSense = Literal["", "normal", "reverse", "sinistral", "dextral"]
SENSES: tuple[tuple[SlipSense, str], ...] = (
    ("", _("none")),
    ("normal", _("normal")),
    ("reverse", _("reverse")),
    ("sinistral", _("sinistral (left-lateral)")),
    ("dextral", _("dextral (right-lateral)")),
)
"""Code and words. An oblique slip is told by one of its two parts; the rake gives the other."""

SlipConfidence = Literal["", "certain", "probable", "supposed"]
CONFIDENCES: tuple[tuple[SlipConfidence, str], ...] = (
    ("", _("not said")),
    ("certain", _("certain")),
    ("probable", _("probable")),
    ("supposed", _("supposed")),
)
"""How sure the sense is, in the grades that programs for the analysis of fault slips know."""


def slip_rake(plane: Plane, rake_deg: float, sense: str) -> float | None:
    """The directed rake (-180, 180] of a slip along the axial rake [0, 180) with its sense of
    movement; None without one, or where the sense does not tell the direction: a normal or reverse
    movement along the strike, or on a vertical plane, which has no hanging wall; a strike slip
    down the dip; any sense on a horizontal plane."""
    if not sense or plane.undefined:
        return None
    if sense in ("normal", "reverse"):
        if min(rake_deg, 180.0 - rake_deg) < ANGLE_TOLERANCE_DEG or plane.vertical:
            return None
        # The axial rake points down the dip; a reverse hanging wall moves the other way.
        return 180.0 - rake_deg if sense == "reverse" else -rake_deg
    if abs(rake_deg - 90.0) < ANGLE_TOLERANCE_DEG:
        return None
    # Rake 0 is left-lateral, and the axial rake's line has it where it is under 90.
    downward_is_sinistral = rake_deg < 90.0
    same = downward_is_sinistral == (sense == "sinistral")
    return (0.0 if same else 180.0) - rake_deg
