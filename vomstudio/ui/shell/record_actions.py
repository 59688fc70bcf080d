"""Commands that the context menu of the tree offers for a record."""

from __future__ import annotations

from PySide6.QtGui import QAction

from vomstudio.project.records import Feature, Model, Painted, Picked, Record
from vomstudio.ui.base.actions import Actions

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
    elif isinstance(record, Picked):
        names = ("frame_selection", "continue_trace", "face_plane", *_COMMON)
    elif isinstance(record, Painted):
        names = ("frame_selection", "continue_patch", "face_plane", *_COMMON)
    elif isinstance(record, Feature):
        names = ("frame_selection", "along_line", "face_plane", *_COMMON)
    return [table.all[name] for name in names]
