"""Deletion of the selected features in filtered lists."""

from __future__ import annotations

from PySide6.QtWidgets import QApplication

from vomstudio.core.findings import Finding
from vomstudio.ui.base.command_targets import selected_features
from vomstudio.ui.base.studio import Studio


def delete_selected(studio: Studio) -> None:
    """Delete the selected features, except rows hidden in the focused list.

    If no filtered list has the focus, all selected features are deleted, and the number of those
    that no list shows is reported.
    """
    ids = selected_features(studio)
    focus = QApplication.focusWidget()
    focused_filters = [
        find_hidden
        for widget, find_hidden in studio.filters
        if focus is not None and (widget is focus or widget.isAncestorOf(focus))
    ]
    if focused_filters:
        hidden_ids = focused_filters[0](ids)
        studio.delete_selected(but=hidden_ids)
        if hidden_ids:
            studio.info(Finding("delete.hidden-left", count=len(hidden_ids)))
        return
    unlisted_ids = set().union(*(find_hidden(ids) for _, find_hidden in studio.filters))
    if studio.delete_selected() and unlisted_ids:
        studio.info(Finding("delete.hidden-deleted", count=len(unlisted_ids)))
