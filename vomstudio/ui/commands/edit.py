"""Commands that undo, redo, edit the selected features and search for commands."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from PySide6.QtWidgets import QInputDialog, QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project import edits
from vomstudio.studio.history import step_title
from vomstudio.ui.base.actions import Actions, Command
from vomstudio.ui.base.command_targets import missing_feature_finding, selected_features
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.window_fitting import fit_to_screen
from vomstudio.ui.commands.deletion import delete_selected, focused_filter

if TYPE_CHECKING:
    from vomstudio.ui.dialogs.command_palette import Destination


def commands(studio: Studio, find: Callable[[], None], parent: QWidget) -> list[Command]:
    """Create the editing commands; `find` opens the search."""

    def missing_selection_finding() -> Finding | None:
        return missing_feature_finding(studio)

    def undo_problem() -> Finding | None:
        return None if studio.undo_label else Finding("edit.nothing-to-undo")

    def redo_problem() -> Finding | None:
        if studio.redo_label:
            return None
        if studio.session.redo_label and studio.open_tool is not None:
            return Finding("feature.open")
        return Finding("edit.nothing-to-redo")

    def undo_text() -> str:
        label = studio.undo_label
        return tr("&Undo {step}", step=_menu_text(label)) if label else tr("&Undo")

    def redo_text() -> str:
        label = studio.redo_label
        return tr("&Redo {step}", step=_menu_text(label)) if label else tr("&Redo")

    def rename() -> None:
        feature_id = selected_features(studio)[-1]
        old_name = studio.records[feature_id].name
        name, is_accepted = QInputDialog.getText(parent, tr("Rename"), tr("Name"), text=old_name)
        if is_accepted and name.strip() != old_name:
            studio.attempt(edits.set_attributes, [feature_id], name=name.strip())

    def select_all() -> None:
        """Select all features, or those that the focused list shows."""
        ids = [feature.id for feature in studio.session.features()]
        find_hidden_ids = focused_filter(studio)
        hidden_ids = set() if find_hidden_ids is None else find_hidden_ids(ids)
        studio.selection.set(id_ for id_ in ids if id_ not in hidden_ids)

    return [
        Command(
            "undo",
            tr("&Undo"),
            studio.undo,
            icon="undo",
            shortcut="Ctrl+Z",
            disabled_reason=undo_problem,
            current_text=undo_text,
        ),
        Command(
            "redo",
            tr("&Redo"),
            studio.redo,
            icon="redo",
            shortcut=("Ctrl+Shift+Z", "Ctrl+Y"),
            disabled_reason=redo_problem,
            current_text=redo_text,
        ),
        Command(
            "delete",
            tr("&Delete features"),
            lambda: delete_selected(studio),
            icon="delete-outline",
            disabled_reason=missing_selection_finding,
        ),
        Command(
            "rename",
            tr("&Rename…"),
            rename,
            shortcut="F2",
            disabled_reason=missing_selection_finding,
        ),
        Command(
            "select_all",
            tr("Select &all features"),
            select_all,
            shortcut="Ctrl+A",
        ),
        Command("find_command", tr("&Search…"), find, icon="magnify", shortcut="Ctrl+K"),
    ]


def _menu_text(label: str) -> str:
    """Return the title of a step with `&` escaped, because `&` marks a shortcut in menus."""
    return step_title(label).replace("&", "&&")


def search(parent: QWidget, actions: Actions, pages: Callable[[], list[Destination]]) -> None:
    """Open the search for commands, pages and documents, and run the selected entry."""
    from vomstudio.ui.dialogs.command_palette import CommandPalette

    dialog = CommandPalette(parent, actions, pages())
    fit_to_screen(dialog)
    if dialog.exec():
        dialog.run_selected()
