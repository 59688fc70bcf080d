"""Undo, redo, what is done to the selected features, and finding a command."""

from __future__ import annotations

from collections.abc import Callable

from PySide6.QtWidgets import QInputDialog, QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project import edits
from vomstudio.studio.history import step_title
from vomstudio.ui.base.actions import Actions, Command
from vomstudio.ui.base.command_targets import selected_features, why_no_feature
from vomstudio.ui.base.long_boxes import fit_to_screen
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.commands.deletion import delete_selected


def commands(studio: Studio, find: Callable[[], None], parent: QWidget) -> list[Command]:
    """find : asks for a command by its words. parent : of the dialogs"""

    def none_chosen() -> Finding | None:
        return why_no_feature(studio)

    def nothing_to_undo() -> Finding | None:
        return None if studio.undo_label else Finding("edit.nothing-to-undo")

    def nothing_to_redo() -> Finding | None:
        if studio.redo_label:
            return None
        if studio.session.redo_label and studio.open_tool is not None:
            return Finding("feature.open")
        return Finding("edit.nothing-to-redo")

    def undo_text() -> str:
        label = studio.undo_label
        return tr("&Undo {step}", step=_in_menu(label)) if label else tr("&Undo")

    def redo_text() -> str:
        label = studio.redo_label
        return tr("&Redo {step}", step=_in_menu(label)) if label else tr("&Redo")

    def rename() -> None:
        current = selected_features(studio)[-1]
        before = studio.records[current].name
        name, accepted = QInputDialog.getText(parent, tr("Rename"), tr("Name"), text=before)
        if accepted and name.strip() != before:
            studio.attempt(edits.set_attributes, [current], name=name.strip())

    return [
        Command(
            "undo",
            tr("&Undo"),
            studio.undo,
            "undo",
            "Ctrl+Z",
            "",
            nothing_to_undo,
            current_text=undo_text,
        ),
        Command(
            "redo",
            tr("&Redo"),
            studio.redo,
            "redo",
            ("Ctrl+Shift+Z", "Ctrl+Y"),
            "",
            nothing_to_redo,
            current_text=redo_text,
        ),
        Command(
            "delete",
            tr("&Delete features"),
            lambda: delete_selected(studio),
            "delete-outline",
            (),
            "",
            none_chosen,
        ),
        Command("rename", tr("&Rename…"), rename, None, "F2", "", none_chosen),
        Command(
            "select_all",
            tr("Select &all features"),
            lambda: studio.selection.set(f.id for f in studio.session.features()),
            None,
            "Ctrl+A",
        ),
        Command("find_command", tr("&Find command…"), find, "magnify", "Ctrl+K"),
    ]


def _in_menu(label: str) -> str:
    """A step in the words of the menu, in which `&` would stand for a key."""
    return step_title(label).replace("&", "&&")


def find_command(parent: QWidget, actions: Actions) -> None:
    """Let the user search for a command by its words, and run it."""
    from vomstudio.ui.dialogs.command_palette import CommandPalette

    dialog = CommandPalette(parent, actions)
    fit_to_screen(dialog)
    if dialog.exec() and dialog.chosen:
        actions.run(dialog.chosen)
