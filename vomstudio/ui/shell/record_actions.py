"""What the tree offers for a record."""

from __future__ import annotations

from PySide6.QtGui import QAction

from vomstudio.document.records import (
    FEATURES,
    Dimension,
    Lineation,
    Model,
    Patch,
    Record,
    Trace,
)
from vomstudio.ui.common.actions import Actions

_COMMON = ("show_chosen", "hide_chosen", "show_only", "rename", "delete")


def record_actions(table: Actions, record: Record) -> list[QAction]:
    table.refresh()
    names: tuple[str, ...] = ()
    if isinstance(record, Model):
        names = ("declare_frame", "locate", "copy_model", "remove_model")
    elif isinstance(record, Trace | Lineation | Dimension):
        names = ("frame_selection", "continue_trace", "face_plane", *_COMMON)
    elif isinstance(record, Patch):
        names = ("frame_selection", "continue_patch", "face_plane", *_COMMON)
    elif isinstance(record, FEATURES):
        names = ("frame_selection", "along_line", "face_plane", *_COMMON)
    return [table.all[name] for name in names]
