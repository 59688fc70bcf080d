"""Messages of the tool that selects faces and points."""

from __future__ import annotations

from typing import Literal

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr

SelectMode = Literal["grow", "rectangle", "lasso", "polygon"]

STEPS: dict[SelectMode, str] = {
    "grow": to_translate("Grow from a click"),
    "rectangle": to_translate("Rectangle"),
    "lasso": to_translate("Lasso"),
    "polygon": to_translate("Polygon"),
}
UNDO_LABELS = {
    "discard": to_translate("Discard the selection"),
    "hide": to_translate("Hide the selection"),
    "show": to_translate("Show hidden elements"),
}
"""Labels of the steps that undo takes back, other than changes of the selection."""
HINTS: dict[SelectMode, str] = {
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


def selection_text(count: int) -> str:
    """Describe the number of selected elements and the possible actions."""
    return tr(_CHOSEN, count=count) if count else tr(_CHOSEN_NOTHING)


def empty_shape_finding(*, through: bool) -> Finding:
    """Return the finding about an empty shape; `through` if it selects hidden elements."""
    if through:
        return Finding("selection.nothing-inside", through=True)
    return Finding("selection.nothing-inside", through=False)
