"""Short reasons for a verdict, and the command that acts on each of them.

The full sentence of a reason is in the catalogue of findings; this table is for the inspector,
which shows a reason in one line.
"""

from __future__ import annotations

from dataclasses import dataclass

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate as _
from vomstudio.core.words import tr

CONTINUE_COMMAND, REGISTER_COMMAND = "edit_feature", "register_model"


@dataclass(frozen=True)
class Remedy:
    """Short form of a reason.

    Attributes
    ----------
    text : str
        Reason and remedy in at most ten words, marked for translation.
    command : str
        Name of the command that acts on the reason, or "" if there is no such command.
    """

    text: str
    command: str = ""


REMEDIES: dict[str, Remedy] = {
    "feature.too-few-points": Remedy(_("Too few points: add points"), CONTINUE_COMMAND),
    "line.off-plane": Remedy(_("Off its plane: pick it on the plane"), CONTINUE_COMMAND),
    "line.plane-error-unknown": Remedy(_("Its plane has no error: measure it again")),
    "line.plane-missing": Remedy(_("Its plane is missing: choose another")),
    "line.registration": Remedy(_("Uncertain north: register the model better"), REGISTER_COMMAND),
    "line.scattered-set": Remedy(_("Scattered planes: use one limb or the fold axis")),
    "line.two-points": Remedy(_("Two points give no error: add points"), CONTINUE_COMMAND),
    "line.uncertain": Remedy(_("Uncertain: pick a longer line"), CONTINUE_COMMAND),
    "line.uncertain-plane": Remedy(_("Uncertain planes: measure them better")),
    "plane.bowed": Remedy(_("Curved face: use it only where it is planar")),
    "plane.collinear": Remedy(
        _("Too straight: add a point where the trace bends"), CONTINUE_COMMAND
    ),
    "plane.in-face": Remedy(_("Along the face: pick where it cuts in"), CONTINUE_COMMAND),
    "plane.levels": Remedy(_("Two levels: keep one of them"), CONTINUE_COMMAND),
    "plane.long-roughness": Remedy(
        _("Rough over its length: pick a longer trace"), CONTINUE_COMMAND
    ),
    "plane.not-coplanar": Remedy(
        _("Not one plane: keep points of a single plane"), CONTINUE_COMMAND
    ),
    "plane.registration": Remedy(_("Uncertain north: register the model better"), REGISTER_COMMAND),
    "plane.resolution": Remedy(_("Too small for this model: pick a larger one"), CONTINUE_COMMAND),
    "plane.three-distinct-points": Remedy(
        _("Three points give no error: add points"), CONTINUE_COMMAND
    ),
    "plane.three-points": Remedy(_("Three points give no error: add points"), CONTINUE_COMMAND),
    "plane.three-straight-points": Remedy(
        _("Too straight: add a point where the trace bends"), CONTINUE_COMMAND
    ),
    "plane.too-few-points": Remedy(_("Few points: add more"), CONTINUE_COMMAND),
    "plane.too-small": Remedy(_("Too small for this model: pick a longer one"), CONTINUE_COMMAND),
    "plane.too-straight": Remedy(
        _("Too straight: add a point where the trace bends"), CONTINUE_COMMAND
    ),
    "plane.uncertain": Remedy(_("Uncertain: add points where the trace bends"), CONTINUE_COMMAND),
    "plane.uncertain-patch": Remedy(_("Uncertain: enlarge the patch"), CONTINUE_COMMAND),
    "points.collinear": Remedy(_("All on one line: add a point off it"), CONTINUE_COMMAND),
    "points.coincident": Remedy(_("All points coincide: add points"), CONTINUE_COMMAND),
    "trace.beside": Remedy(_("The path leaves the contact: add a way-point"), CONTINUE_COMMAND),
}
"""Remedies by the code of the reason."""


def short_reason(reason: Finding) -> str:
    """Return the short form of a reason, or its full message if it has none.

    Parameters
    ----------
    reason : Finding

    Returns
    -------
    str
    """
    remedy = REMEDIES.get(reason.code)
    return reason.message if remedy is None else tr(remedy.text)


def remedy_command(reason: Finding) -> str:
    """Return the name of the command that resolves a reason, or "" if no command does.

    Parameters
    ----------
    reason : Finding

    Returns
    -------
    str
    """
    remedy = REMEDIES.get(reason.code)
    return "" if remedy is None else remedy.command
