"""Commands on feature types, on how planes are drawn and on what is shown."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from PySide6.QtWidgets import QWidget

from vomstudio.ui.common.actions import Command
from vomstudio.ui.common.command_targets import chosen_features, why_none_chosen
from vomstudio.ui.common.open_dialogs import OpenDialogs
from vomstudio.ui.common.studio import Studio

if TYPE_CHECKING:
    from vomstudio.ui.interpret.types_dialog import TypesDialog

PLANES_AS = (
    ("planes_discs", "&Discs", "discs", "Each plane as a translucent disc of its feature's extent"),
    ("planes_symbols", "&Strike and dip symbols", "symbols",
     "Strike line, tick down the dip and dip; arrows down the plunge for lines"),
    ("planes_neither", "&Neither", "neither", "Traces and outlines only"),
)  # fmt: skip


def commands(studio: Studio, open_types: Callable[[], object]) -> list[Command]:
    def chosen() -> list[str]:
        return chosen_features(studio)

    def none_chosen() -> str | None:
        return why_none_chosen(studio)

    def nothing_hidden() -> str | None:
        return None if studio.hidden else "nothing is hidden"

    def planes(value: str) -> Callable[[], None]:
        def choose() -> None:
            studio.settings.planes_as = value
            studio.keep_settings()

        return choose

    def is_planes(value: str) -> Callable[[], bool]:
        return lambda: studio.settings.planes_as == value

    table = [
        Command("feature_types", "Feature &types…", open_types, "shape-outline", (),
                "Add, rename, colour and remove what is measured: bedding, fault, joint …"),
        Command("show_chosen", "&Show", lambda: studio.set_visible(chosen(), True),
                "eye-outline", (), "The selected features, in the outcrop and on the net",
                none_chosen),
        Command("hide_chosen", "&Hide", lambda: studio.set_visible(chosen(), False),
                "eye-off-outline", "Ctrl+H", "The selected features, in the outcrop and on the net",
                none_chosen),
        Command("show_only", "Show &only these", lambda: studio.show_only(chosen()), None, (),
                "Hide all features but the selected ones", none_chosen),
        Command("show_all", "Show &everything", studio.show_all, None, "Ctrl+Shift+H",
                "All features, types and models", nothing_hidden),
    ]  # fmt: skip
    for name, text, value, tip in PLANES_AS:
        table.append(Command(name, text, planes(value), None, (), tip, checked=is_planes(value)))
    return table


def open_types(
    parent: QWidget, studio: Studio, dialogs: OpenDialogs, type_id: str = ""
) -> TypesDialog:
    """The dialog, beside the window, so that the outcrop shows what is changed."""
    from vomstudio.ui.interpret.types_dialog import TypesDialog

    there = dialogs.shown(TypesDialog)
    if there is not None and type_id:
        there.select(type_id)
    return dialogs.show(TypesDialog, lambda: TypesDialog(parent, studio, type_id))
