"""Commands that the context menus offer for a record."""

from __future__ import annotations

from PySide6.QtGui import QAction

from vomstudio.project.records import Feature, Model, Painted, Picked, Record
from vomstudio.ui.base.actions import Actions

_LOOK = ("frame_selection", "face_plane", "show_in_photos")
_COMMON = ("show_chosen", "hide_chosen", "show_only", "rename", "delete")


def record_actions(table: Actions, record: Record) -> list[QAction]:
    """Return the commands for a model or feature, with their present state."""
    table.refresh()
    names: tuple[str, ...] = ()
    if isinstance(record, Model):
        names = (
            "declare_frame",
            "register_model",
            "fit_model",
            "locate",
            "copy_model",
            "remove_model",
        )
    elif isinstance(record, Picked | Painted):
        names = ("edit_feature", *_LOOK, *_COMMON)
    elif isinstance(record, Feature):
        names = ("along_line", *_LOOK, *_COMMON)
    return [table.all[name] for name in names]
