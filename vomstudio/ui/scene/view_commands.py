"""Turning the view of the outcrop, and how orientations are written."""

from __future__ import annotations

from collections.abc import Callable

from vomstudio.ui.common.actions import Command
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.scene.outcrop_view import OutcropView

# (name, text, key, what the viewer looks toward)
_VIEWS = (
    ("top", "From above", "7"),
    ("north", "Looking North", "1"),
    ("east", "Looking East", "2"),
    ("south", "Looking South", "3"),
    ("west", "Looking West", "4"),
    ("bottom", "From below", "8"),
)
_NOTATIONS = (
    ("notation_dipdir", "Dip direction/dip (132/41)", "dipdir/dip"),
    ("notation_strike", "Strike/dip, right-hand rule (042/41)", "strike/dip"),
    ("notation_quadrant", "Quadrant (N42E 41SE)", "quadrant"),
)


def commands(studio: Studio, view: OutcropView, only_outcrop: Callable[[], None]) -> list[Command]:
    """only_outcrop : hides the panels, or brings them back"""

    def none_chosen() -> str | None:
        if studio.measured(studio.selection.ids):
            return view.why_not()
        return "select a feature first"

    def look(name: str) -> Callable[[], None]:
        return lambda: view.standard_view(name)

    def notation(name: str) -> Callable[[], None]:
        def choose() -> None:
            studio.settings.notation = name
            studio.keep_settings()

        return choose

    def is_notation(name: str) -> Callable[[], bool]:
        return lambda: studio.settings.notation == name

    def trackball() -> None:
        studio.settings.turntable = not studio.settings.turntable
        view.set_turntable(studio.settings.turntable)
        studio.keep_settings()

    table = [
        Command("home", "&Whole model", view.see_all, "home-outline", "Home", "",
                view.why_not, in_viewport=True),
        Command("frame_selection", "&Frame selection", view.frame_selection,
                "image-filter-center-focus", "F", "Bring the selected features into view",
                none_chosen, in_viewport=True),
        Command("orthographic", "&Orthographic", view.toggle_orthographic, "cube-outline", "O",
                "Without perspective: lengths across the view are true", view.why_not,
                in_viewport=True, checked=lambda: view.orthographic),
        Command("trackball", "Turn about any &axis", trackball, None, (),
                "Off: the turntable keeps Z up", view.why_not,
                checked=lambda: not studio.settings.turntable),
        Command("only_outcrop", "Only the outcrop", only_outcrop, None, "F9",
                "Hide the panels, or bring them back"),
    ]  # fmt: skip
    table += [
        Command(f"view_{name}", text, look(name), None, key, "", view.why_not, in_viewport=True)
        for name, text, key in _VIEWS
    ]
    table += [
        Command(name, text, notation(value), checked=is_notation(value))
        for name, text, value in _NOTATIONS
    ]
    return table
