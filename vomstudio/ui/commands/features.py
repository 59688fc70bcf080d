"""Commands on feature types, on how planes are drawn and on which features are shown."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from PySide6.QtWidgets import QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.command_targets import selected_features, why_no_feature
from vomstudio.ui.base.open_dialogs import OpenDialogs
from vomstudio.ui.base.studio import Studio

if TYPE_CHECKING:
    from vomstudio.ui.dialogs.feature_types_dialog import TypesDialog

PLANES_AS = (
    (
        "planes_discs",
        to_translate("&Discs"),
        "discs",
        to_translate("Each plane as a translucent disc of its feature's extent."),
    ),
    (
        "planes_symbols",
        to_translate("&Strike and dip symbols"),
        "symbols",
        to_translate("Strike line with a tick and the dip; arrows down the plunge for lines."),
    ),
    ("planes_neither", to_translate("&None"), "neither", to_translate("Traces and outlines only.")),
)


def commands(studio: Studio, open_types: Callable[[], object]) -> list[Command]:
    """open_types : opens the dialog of feature types"""

    surroundings = studio.workspace.surroundings

    def chosen() -> list[str]:
        return selected_features(studio)

    def none_chosen() -> Finding | None:
        return why_no_feature(studio)

    def nothing_hidden() -> Finding | None:
        return None if studio.hidden else Finding("action.nothing-hidden")

    def planes(value: str) -> Callable[[], None]:
        def choose() -> None:
            studio.settings.planes_as = value
            studio.keep_settings()

        return choose

    def is_planes(value: str) -> Callable[[], bool]:
        return lambda: studio.settings.planes_as == value

    table = [
        Command(
            "feature_types",
            tr("Feature &types…"),
            open_types,
            "shape-outline",
            (),
            tr("Add, rename, colour and remove feature types: bedding, fault, joint …"),
        ),
        Command(
            "update_surroundings",
            tr("&Update earlier features"),
            surroundings.update,
            None,
            (),
            tr(
                "Measure the resolution and the outcrop face anew around features "
                "that were measured by an earlier rule."
            ),
            surroundings.why_not,
        ),
        Command(
            "show_chosen",
            tr("&Show"),
            lambda: studio.set_visible(chosen(), True),
            "eye-outline",
            (),
            tr("Show the selected features, in the outcrop and on the stereonet."),
            none_chosen,
        ),
        Command(
            "hide_chosen",
            tr("&Hide"),
            lambda: studio.set_visible(chosen(), False),
            "eye-off-outline",
            "Ctrl+H",
            tr("Hide the selected features, in the outcrop and on the stereonet."),
            none_chosen,
        ),
        Command(
            "show_only",
            tr("Show &only these"),
            lambda: studio.show_only(chosen()),
            None,
            (),
            tr("Hide all features except the selected ones."),
            none_chosen,
        ),
        Command(
            "show_all",
            tr("Show &all"),
            studio.show_all,
            None,
            "Ctrl+Shift+H",
            tr("Show all features, feature types and models."),
            nothing_hidden,
        ),
    ]
    for name, text, value, tip in PLANES_AS:
        table.append(
            Command(name, tr(text), planes(value), None, (), tr(tip), is_checked=is_planes(value))
        )
    return table


def open_types(
    parent: QWidget, studio: Studio, dialogs: OpenDialogs, type_id: str = ""
) -> TypesDialog:
    """The dialog, beside the window, so that the outcrop shows what is changed."""
    from vomstudio.ui.dialogs.feature_types_dialog import TypesDialog

    there = dialogs.find_visible(TypesDialog)
    if there is not None and type_id:
        there.select(type_id)
    return dialogs.show(TypesDialog, lambda: TypesDialog(parent, studio, type_id))
