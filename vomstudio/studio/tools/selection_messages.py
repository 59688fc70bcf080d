"""Messages of the tools that select faces and points."""

from __future__ import annotations

from typing import Literal

from vomstudio.core.words import to_translate, tr

ElementMode = Literal["pick", "rectangle", "lasso", "polygon"]
ShapeMode = Literal["rectangle", "lasso", "polygon"]

MODES: dict[ElementMode, str] = {
    "pick": to_translate("Grow and paint"),
    "rectangle": to_translate("Rectangle"),
    "lasso": to_translate("Lasso"),
    "polygon": to_translate("Polygon"),
}
UNDO_LABELS = {
    "discard": to_translate("Discard the selection"),
    "hide": to_translate("Hide the selection"),
    "show": to_translate("Show hidden elements"),
}
"""Labels of the steps that can be undone, other than changes of the selection."""
GROW_LABEL, PAINT_LABEL, ERASE_LABEL = (
    to_translate("Grow"),
    to_translate("Paint"),
    to_translate("Erase"),
)
"""Labels of the steps of the mode "pick"."""
SHAPE_HINTS: dict[ShapeMode, str] = {
    "rectangle": to_translate("drag a rectangle."),
    "lasso": to_translate("hold the left button and draw around an area."),
    "polygon": to_translate("click the corners of a polygon."),
}
_EMPTY_HINT = to_translate("The right button orbits.")
_SELECTION_HINT = to_translate("{count:,} selected: Shift adds, Alt removes.")


def count_text(count: int) -> str:
    """Describe the number of selected elements and the keys that change them.

    Parameters
    ----------
    count : int

    Returns
    -------
    str
    """
    return tr(_SELECTION_HINT, count=count) if count else tr(_EMPTY_HINT)
