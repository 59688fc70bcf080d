"""What the tool that chooses faces and points says."""

from __future__ import annotations

from typing import Literal

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr

Way = Literal["grow", "rectangle", "lasso", "polygon"]

STEPS: dict[Way, str] = {
    "grow": to_translate("Grow from a click"),
    "rectangle": to_translate("Rectangle"),
    "lasso": to_translate("Lasso"),
    "polygon": to_translate("Polygon"),
}
HINTS: dict[Way, str] = {
    "grow": to_translate(
        "Select: a click takes the even surface around it; Ctrl+wheel: angle, Shift+wheel: "
        "distance."
    ),
    "rectangle": to_translate("Select: drag a rectangle over what you want."),
    "lasso": to_translate("Select: hold the left button and draw around what you want."),
    "polygon": to_translate("Select: click the corners of a polygon around what you want."),
}
_CHOSEN_NOTHING = to_translate("The right button orbits.")
_CHOSEN = to_translate("{count:,} chosen; Shift adds, Ctrl takes away; Enter: patch, Esc: let go.")


def chosen_text(count: int) -> str:
    """How many are chosen and what can be done with them, for the status line."""
    return tr(_CHOSEN, count=count) if count else tr(_CHOSEN_NOTHING)


def nothing_inside(*, through: bool) -> Finding:
    """A shape has found nothing. through : it takes what is hidden too"""
    if through:
        return Finding("selection.nothing-inside", through=True)
    return Finding("selection.nothing-inside", through=False)
