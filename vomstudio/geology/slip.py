"""Sense of slip on a fault and direction of the movement."""

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
"""Codes and labels. Oblique slip has the sense of one component; the rake determines the other."""

SlipConfidence = Literal["", "certain", "probable", "supposed"]
CONFIDENCES: tuple[tuple[SlipConfidence, str], ...] = (
    ("", _("not stated")),
    ("certain", _("certain")),
    ("probable", _("probable")),
    ("supposed", _("supposed")),
)
"""Confidence grades of the sense, as used by fault-slip programs."""


def slip_rake(plane: Plane, rake_deg: float, sense: str) -> float | None:
    """Return the directed rake of a slip from its axial rake and sense.

    Parameters
    ----------
    plane : Plane
    rake_deg : float
        Axial rake in degrees, in [0, 180).
    sense : str
        Sense of movement, one of `SENSES`.

    Returns
    -------
    float or None
        Rake in (-180, 180] degrees. None if `sense` is empty or does not determine the direction: a
        normal or reverse movement along the strike or on a vertical plane, a strike slip along the
        dip, and any sense on a horizontal plane.
    """
    if not sense or plane.undefined:
        return None
    if sense in ("normal", "reverse"):
        if min(rake_deg, 180.0 - rake_deg) < ANGLE_TOLERANCE_DEG or plane.vertical:
            return None
        # The axial rake points down dip; a reverse movement of the hanging wall points up.
        return 180.0 - rake_deg if sense == "reverse" else -rake_deg
    if abs(rake_deg - 90.0) < ANGLE_TOLERANCE_DEG:
        return None
    # A rake of 0 is left-lateral; any axial rake below 90 has a left-lateral component.
    is_downward_sinistral = rake_deg < 90.0
    is_same = is_downward_sinistral == (sense == "sinistral")
    return (0.0 if is_same else 180.0) - rake_deg
