"""Deletion of the selected features in filtered lists."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from PySide6.QtWidgets import QApplication

from vomstudio.core.findings import Finding
from vomstudio.ui.base.command_targets import selected_features
from vomstudio.ui.base.studio import Studio


def focused_filter(studio: Studio) -> Callable[[Iterable[str]], set[str]] | None:
    """Return the function that finds the features hidden in the focused list.

    Parameters
    ----------
    studio : Studio

    Returns
    -------
    callable or None
        None if no filtered list has the focus.
    """
    focus_widget = QApplication.focusWidget()
    return next(
        (
            find_hidden_ids
            for widget, find_hidden_ids in studio.filters
            if focus_widget is not None
            and (widget is focus_widget or widget.isAncestorOf(focus_widget))
        ),
        None,
    )


def delete_selected(studio: Studio) -> None:
    """Delete the selected features, except rows hidden in the focused list.

    If no filtered list has the focus, all selected features are deleted, and the number of those
    that a filter hides is reported.
    """
    ids = selected_features(studio)
    find_hidden_ids = focused_filter(studio)
    if find_hidden_ids is not None:
        hidden_ids = find_hidden_ids(ids)
        studio.delete_selected(excluded_ids=hidden_ids)
        if hidden_ids:
            studio.info(Finding("delete.hidden-left", count=len(hidden_ids)))
        return
    unlisted_ids = set().union(*(find_hidden_ids(ids) for _, find_hidden_ids in studio.filters))
    if studio.delete_selected() and unlisted_ids:
        studio.info(Finding("delete.hidden-deleted", count=len(unlisted_ids)))
