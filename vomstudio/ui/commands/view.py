"""Commands that change the view of the outcrop, and the notation of orientations."""

from __future__ import annotations

from collections.abc import Callable

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.ui.base import theme
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.outcrop.outcrop_view import OutcropView

# (name, text, key, what the viewer looks toward)
_VIEWS = (
    ("top", to_translate("From above"), "7"),
    ("north", to_translate("Looking north"), "1"),
    ("east", to_translate("Looking east"), "2"),
    ("south", to_translate("Looking south"), "3"),
    ("west", to_translate("Looking west"), "4"),
    ("bottom", to_translate("From below"), "8"),
)
_NOTATIONS = (
    ("notation_dipdir", to_translate("Dip direction/dip (132/41)"), "dipdir/dip"),
    ("notation_strike", to_translate("Strike/dip, right-hand rule (042/41)"), "strike/dip"),
    ("notation_quadrant", to_translate("Quadrant (N42E 41SE)"), "quadrant"),
)
_THEMES = (
    ("system", to_translate("As the &system has it")),
    ("light", to_translate("&Light")),
    ("dark", to_translate("&Dark")),
)


def commands(studio: Studio, view: OutcropView, only_outcrop: Callable[[], None]) -> list[Command]:
    """only_outcrop : hides the panels, or shows them again"""

    def none_chosen() -> Finding | None:
        if studio.measured(studio.selection.ids):
            return view.why_not()
        return Finding("action.no-feature")

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
        Command(
            "home",
            tr("&Whole model"),
            view.frame_all,
            "home-outline",
            "Home",
            "",
            view.why_not,
            is_viewport_key=True,
        ),
        Command(
            "frame_selection",
            tr("&Zoom to selection"),
            view.frame_selection,
            "image-filter-center-focus",
            "F",
            tr("Show the selected features."),
            none_chosen,
            is_viewport_key=True,
        ),
        Command(
            "view_back",
            tr("&Earlier view"),
            view.history.back,
            None,
            "Shift+Z",
            tr("Back to the camera and the clipping box before their last change."),
            view.history.why_not_back,
            is_viewport_key=True,
        ),
        Command(
            "view_forward",
            tr("&Later view"),
            view.history.forward,
            None,
            "Shift+Y",
            tr("Forward again, after going back."),
            view.history.why_not_forward,
            is_viewport_key=True,
        ),
        Command(
            "orthographic",
            tr("&Orthographic"),
            view.toggle_orthographic,
            "cube-outline",
            "O",
            tr("Without perspective: lengths perpendicular to the view are true."),
            view.why_not,
            is_viewport_key=True,
            is_checked=lambda: view.is_orthographic,
        ),
        Command(
            "trackball",
            tr("Free rotation (&trackball)"),
            trackball,
            None,
            (),
            tr("Rotate about any axis. Otherwise Z stays up (turntable)."),
            view.why_not,
            is_checked=lambda: not studio.settings.turntable,
        ),
        Command(
            "only_outcrop",
            tr("Hide all panels"),
            only_outcrop,
            None,
            "F9",
            tr("Hide the panels, or show them again."),
        ),
    ]
    table += [
        Command(
            f"view_{name}", tr(text), look(name), None, key, "", view.why_not, is_viewport_key=True
        )
        for name, text, key in _VIEWS
    ]
    table += [
        Command(name, tr(text), notation(value), is_checked=is_notation(value))
        for name, text, value in _NOTATIONS
    ]
    return table + _theme_commands(studio)


def _theme_commands(studio: Studio) -> list[Command]:
    def use(name: str) -> Callable[[], None]:
        def choose() -> None:
            studio.settings.theme = name
            theme.use(name)
            studio.keep_settings()

        return choose

    def is_used(name: str) -> Callable[[], bool]:
        return lambda: studio.settings.theme == name

    return [
        Command(f"theme_{name}", tr(text), use(name), is_checked=is_used(name))
        for name, text in _THEMES
    ]
