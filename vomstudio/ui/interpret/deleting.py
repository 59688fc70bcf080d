"""Deleting what is selected while lists are filtered."""

from __future__ import annotations

from PySide6.QtWidgets import QApplication

from vomstudio.ui.common.command_targets import chosen_features
from vomstudio.ui.common.studio import Studio
from vomstudio.words import tr_n


def delete_selected(studio: Studio) -> None:
    """In a list the rows that its filter hides stay, however they came to be selected. Elsewhere
    all that is selected is in sight and goes, and it is said how many of them no list shows."""
    ids = chosen_features(studio)
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
            studio.info(
                tr_n(
                    "{count} selected feature was not deleted: the filter of this list hides it.",
                    "{count} selected features were not deleted: the filter of this list hides "
                    "them.",
                    len(kept),
                )
            )
        return
    unseen = set().union(*(hidden(ids) for _, hidden in studio.filters))
    if studio.delete_selected() and unseen:
        studio.info(
            tr_n(
                "{count} of the deleted features is one that a filter hides in the list. Undo "
                "brings it back.",
                "{count} of the deleted features are hidden by a filter in the list. Undo brings "
                "them back.",
                len(unseen),
            )
        )
