"""Commands that the context menus offer for a record."""

from __future__ import annotations

from PySide6.QtGui import QAction

from vomstudio.project.records import Feature, Model, PaintedFeature, PickedFeature, Record
from vomstudio.ui.base.actions import Actions

Groups = tuple[tuple[str, ...], ...]


def record_actions(table: Actions, record: Record, *, is_visible: bool) -> list[list[QAction]]:
    """Return the commands for a model or feature in groups, with their present state."""
    table.refresh()
    groups: Groups = ()
    visibility_commands = ("hide_chosen" if is_visible else "show_chosen", "show_only")
    if isinstance(record, Model):
        groups = (
            ("declare_frame", "register_model", "fit_model"),
            ("locate", "copy_model", "remove_model"),
        )
    elif isinstance(record, Feature):
        first_command = (
            "edit_feature" if isinstance(record, PickedFeature | PaintedFeature) else "along_line"
        )
        groups = (
            (first_command, "rename"),
            ("frame_selection", "face_plane", "show_in_photos"),
            visibility_commands,
            ("delete",),
        )
    return [[table.all[name] for name in names] for names in groups]
