"""Commands for feature types, plane symbols and the visibility of features."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from PySide6.QtWidgets import QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.command_targets import missing_feature_finding, selected_features
from vomstudio.ui.base.feature_colors import COLOR_MODES
from vomstudio.ui.base.open_dialogs import OpenDialogs
from vomstudio.ui.base.studio import Studio

if TYPE_CHECKING:
    from vomstudio.ui.dialogs.feature_types_dialog import TypesDialog

PLANE_STYLES = (
    (
        "planes_discs",
        to_translate("&Discs"),
        "discs",
        to_translate("Draw each plane as a translucent disc of the same extent."),
    ),
    (
        "planes_symbols",
        to_translate("&Strike and dip symbols"),
        "symbols",
        to_translate("Draw strike and dip symbols, and plunge arrows for lines."),
    ),
    (
        "planes_neither",
        to_translate("&None"),
        "neither",
        to_translate("Draw only traces and outlines."),
    ),
)


def commands(studio: Studio, open_types_dialog: Callable[[], object]) -> list[Command]:
    """Create the feature commands; `open_types_dialog` opens the dialog of feature types."""
    surroundings = studio.workspace.surroundings

    def selected_ids() -> list[str]:
        return selected_features(studio)

    def missing_selection_finding() -> Finding | None:
        return missing_feature_finding(studio)

    def show_all_problem() -> Finding | None:
        return None if studio.hidden else Finding("action.nothing-hidden")

    def set_plane_style(value: str) -> Callable[[], None]:
        def apply() -> None:
            studio.settings.planes_as = value
            studio.keep_settings()

        return apply

    def is_plane_style(value: str) -> Callable[[], bool]:
        return lambda: studio.settings.planes_as == value

    def set_color_mode(value: str) -> Callable[[], None]:
        def apply() -> None:
            studio.settings.color_by = value
            studio.keep_settings()

        return apply

    def is_color_mode(value: str) -> Callable[[], bool]:
        return lambda: studio.settings.color_by == value

    table = [
        Command(
            "feature_types",
            tr("Feature &types…"),
            open_types_dialog,
            icon="shape-outline",
            tip=tr("Add, rename, colour and remove feature types."),
        ),
        Command(
            "update_surroundings",
            tr("&Update earlier features"),
            surroundings.update,
            tip=tr("Measure resolution and outcrop face again with the current method."),
            disabled_reason=surroundings.disabled_reason,
        ),
        Command(
            "show_chosen",
            tr("&Show"),
            lambda: studio.set_visible(selected_ids(), True),
            icon="eye-outline",
            tip=tr("Show the selected features in the outcrop and on the stereonet."),
            disabled_reason=missing_selection_finding,
        ),
        Command(
            "hide_chosen",
            tr("&Hide"),
            lambda: studio.set_visible(selected_ids(), False),
            icon="eye-off-outline",
            shortcut="Ctrl+H",
            tip=tr("Hide the selected features in the outcrop and on the stereonet."),
            disabled_reason=missing_selection_finding,
        ),
        Command(
            "show_only",
            tr("Show &only selected"),
            lambda: studio.show_only(selected_ids()),
            tip=tr("Hide all features except the selected ones."),
            disabled_reason=missing_selection_finding,
        ),
        Command(
            "show_all",
            tr("Show &all"),
            studio.show_all,
            shortcut="Ctrl+Shift+H",
            tip=tr("Show all features, feature types and models."),
            disabled_reason=show_all_problem,
        ),
    ]
    for value, title in COLOR_MODES.items():
        table.append(
            Command(
                f"color_by_{value}",
                tr("Colour by {property}", property=tr(title).lower()),
                set_color_mode(value),
                tip=tr("Colour the features in the outcrop, net and table."),
                is_checked=is_color_mode(value),
            )
        )
    for name, text, value, tooltip in PLANE_STYLES:
        table.append(
            Command(
                name,
                tr(text),
                set_plane_style(value),
                tip=tr(tooltip),
                is_checked=is_plane_style(value),
            )
        )
    return table


def open_types_dialog(
    parent: QWidget, studio: Studio, dialogs: OpenDialogs, type_id: str = ""
) -> TypesDialog:
    """Open the non-modal dialog of feature types, and select the type `type_id`, if given."""
    from vomstudio.ui.dialogs.feature_types_dialog import TypesDialog

    dialog = dialogs.find_visible(TypesDialog)
    if dialog is not None and type_id:
        dialog.select(type_id)
    return dialogs.show(TypesDialog, lambda: TypesDialog(parent, studio, type_id))
