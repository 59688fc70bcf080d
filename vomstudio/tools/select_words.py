"""What the tool that chooses faces and points says."""

from __future__ import annotations

from typing import Literal

from vomstudio.words import to_translate, tr

Way = Literal["grow", "rectangle", "lasso", "polygon"]

STEPS: dict[Way, str] = {
    "grow": to_translate("Grow from a click"),
    "rectangle": to_translate("Rectangle"),
    "lasso": to_translate("Lasso"),
    "polygon": to_translate("Polygon"),
}
HINTS: dict[Way, str] = {
    "grow": to_translate(
        "Select: a click takes the surface around it as far as it is even; Ctrl+wheel changes the "
        "angle, Shift+wheel the distance."
    ),
    "rectangle": to_translate("Select: drag a rectangle over what you want."),
    "lasso": to_translate("Select: hold the left button and draw around what you want."),
    "polygon": to_translate("Select: click the corners of a polygon around what you want."),
}
_CHOSEN_NOTHING = to_translate("The right button orbits.")
_CHOSEN = to_translate(
    "{count:,} chosen: Shift adds, Ctrl takes away, both intersect; Enter makes a patch, Esc lets "
    "them go."
)


def chosen_text(count: int) -> str:
    """How many are chosen and what can be done with them, for the status line."""
    return tr(_CHOSEN, count=count) if count else tr(_CHOSEN_NOTHING)
