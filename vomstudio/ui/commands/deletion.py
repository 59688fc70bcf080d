"""Deleting what is selected while lists are filtered."""

from __future__ import annotations

from PySide6.QtWidgets import QApplication

from vomstudio.core.findings import Finding
from vomstudio.ui.base.command_targets import selected_features
from vomstudio.ui.base.studio import Studio


def delete_selected(studio: Studio) -> None:
    """In a list the rows that its filter hides stay, however they came to be selected. Elsewhere
    all that is selected is in sight and goes, and it is said how many of them no list shows."""
    ids = selected_features(studio)
    focus = QApplication.focusWidget()
    own = [
        hidden
        for widget, hidden in studio.filters
        if focus is not None and (widget is focus or widget.isAncestorOf(focus))
    ]
    if own:
        kept = own[0](ids)
        studio.delete_selected(but=kept)
        if kept:
            studio.info(Finding("delete.hidden-left", count=len(kept)))
        return
    unseen = set().union(*(hidden(ids) for _, hidden in studio.filters))
    if studio.delete_selected() and unseen:
        studio.info(Finding("delete.hidden-deleted", count=len(unseen)))
