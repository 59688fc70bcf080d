"""Commands for the view of the outcrop, the notation of orientations and the theme."""

from __future__ import annotations

from collections.abc import Callable

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.ui.base import theme
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.command_targets import missing_feature_finding
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.outcrop.outcrop_view import STANDARD_VIEWS, OutcropView

_NOTATIONS = (
    ("notation_dipdir", to_translate("Dip direction/dip (132/41)"), "dipdir/dip"),
    ("notation_strike", to_translate("Strike/dip, right-hand rule (042/41)"), "strike/dip"),
    ("notation_quadrant", to_translate("Quadrant (N42E 41SE)"), "quadrant"),
)
_LABEL_MODES = (
    ("auto", to_translate("automatic")),
    ("all", to_translate("all")),
    ("selected", to_translate("selected")),
    ("none", to_translate("none")),
)
_THEMES = (
    ("system", to_translate("&System")),
    ("light", to_translate("&Light")),
    ("dark", to_translate("&Dark")),
)


def commands(studio: Studio, view: OutcropView, toggle_panels: Callable[[], None]) -> list[Command]:
    """Create the view commands; `toggle_panels` hides or shows all panels."""

    def missing_selection_finding() -> Finding | None:
        return missing_feature_finding(studio) or view.disabled_reason()

    def show_view(name: str) -> Callable[[], None]:
        return lambda: view.set_standard_view(name)

    def set_notation(name: str) -> Callable[[], None]:
        def choose() -> None:
            studio.settings.notation = name
            studio.keep_settings()

        return choose

    def is_notation(name: str) -> Callable[[], bool]:
        return lambda: studio.settings.notation == name

    def toggle_trackball() -> None:
        studio.settings.turntable = not studio.settings.turntable
        view.set_turntable(studio.settings.turntable)
        studio.keep_settings()

    def next_label_mode() -> str:
        modes = [mode for mode, _ in _LABEL_MODES]
        return modes[(modes.index(studio.settings.labels) + 1) % len(modes)]

    def cycle_labels() -> None:
        studio.settings.labels = next_label_mode()
        view.set_label_mode(studio.settings.labels)
        studio.keep_settings()

    def label_mode_text() -> str:
        return tr("La&bels: {mode}", mode=tr(dict(_LABEL_MODES)[studio.settings.labels]))

    table = [
        Command(
            "labels",
            tr("La&bels"),
            cycle_labels,
            icon="label-outline",
            shortcut="Shift+L",
            tip=tr("Label all features, selected features, or none."),
            disabled_reason=view.disabled_reason,
            is_viewport_key=True,
            current_text=label_mode_text,
        ),
        Command(
            "home",
            tr("&Whole model"),
            view.frame_all,
            icon="home-outline",
            shortcut="Home",
            disabled_reason=view.disabled_reason,
            is_viewport_key=True,
        ),
        Command(
            "frame_selection",
            tr("&Zoom to selection"),
            view.frame_selection,
            icon="image-filter-center-focus",
            shortcut="F",
            tip=tr("Show the selected features."),
            disabled_reason=missing_selection_finding,
            is_viewport_key=True,
        ),
        Command(
            "view_back",
            tr("&Earlier view"),
            view.history.go_back,
            icon="chevron-left",
            shortcut="Shift+Z",
            tip=tr("Return to the previous camera and clipping box."),
            disabled_reason=view.history.back_problem,
            is_viewport_key=True,
            depends_on_camera=True,
        ),
        Command(
            "view_forward",
            tr("&Later view"),
            view.history.go_forward,
            icon="chevron-right",
            shortcut="Shift+Y",
            tip=tr("Go forward to the next view."),
            disabled_reason=view.history.forward_problem,
            is_viewport_key=True,
            depends_on_camera=True,
        ),
        Command(
            "orthographic",
            tr("&Orthographic"),
            view.toggle_orthographic,
            icon="cube-outline",
            shortcut="O",
            tip=tr("Parallel projection: lengths perpendicular to the view are true."),
            disabled_reason=view.disabled_reason,
            is_viewport_key=True,
            is_checked=lambda: view.is_orthographic,
            depends_on_camera=True,
        ),
        Command(
            "trackball",
            tr("Free rotation (&trackball)"),
            toggle_trackball,
            tip=tr("Rotate about any axis. If off, Z stays up (turntable)."),
            disabled_reason=view.disabled_reason,
            is_checked=lambda: not studio.settings.turntable,
        ),
        Command(
            "only_outcrop",
            tr("Hide all panels"),
            toggle_panels,
            shortcut="F9",
            tip=tr("Hide or show all panels."),
        ),
    ]
    table += [
        Command(
            f"view_{name}",
            tr(text),
            show_view(name),
            shortcut=key,
            disabled_reason=view.disabled_reason,
            is_viewport_key=True,
        )
        for name, text, key in STANDARD_VIEWS
    ]
    table += [
        Command(name, tr(text), set_notation(value), is_checked=is_notation(value))
        for name, text, value in _NOTATIONS
    ]
    return table + _theme_commands(studio)


def _theme_commands(studio: Studio) -> list[Command]:
    def set_theme(name: str) -> Callable[[], None]:
        def choose() -> None:
            studio.settings.theme = name
            theme.use(name)
            studio.keep_settings()

        return choose

    def is_theme(name: str) -> Callable[[], bool]:
        return lambda: studio.settings.theme == name

    return [
        Command(f"theme_{name}", tr(text), set_theme(name), is_checked=is_theme(name))
        for name, text in _THEMES
    ]
