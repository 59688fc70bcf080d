"""Panels that refresh only while they are visible, and panels that analyse the project."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, Generic, TypeVar

from PySide6.QtCore import QTimer
from PySide6.QtGui import QPaintEvent
from PySide6.QtWidgets import QWidget

from vomstudio.core.errors import VomError
from vomstudio.project.edit import Edit
from vomstudio.project.records import Model
from vomstudio.ui.base.command_targets import ask_for_target
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.qt_background import LatestRequestRunner, QtBackground
from vomstudio.ui.base.qt_owner import connect_until_deleted
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools.common import hint_label

Request = TypeVar("Request")
Result = TypeVar("Result")

_REFRESH_DELAY_MS = 120
"""Changes within this delay are combined into one refresh."""


class LazyPanel(QWidget):
    """Panel that refreshes only while it is visible.

    Subclasses implement `update_widgets`.

    Parameters
    ----------
    studio : Studio
    """

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self._is_stale = True
        self._timer = QTimer(self, singleShot=True, interval=_REFRESH_DELAY_MS)
        self._timer.timeout.connect(self.refresh)

    def update_widgets(self) -> None:
        """Update all widgets of the panel; `refresh` calls it only if the panel is visible."""
        raise NotImplementedError

    def refresh(self) -> None:
        """Update the panel if it is visible, otherwise the next time it is painted."""
        self._is_stale = self.visibleRegion().isEmpty()
        if not self._is_stale:
            self.update_widgets()

    def _schedule_refresh(self, *_: object) -> None:
        """Schedule a refresh; a hidden panel is refreshed the next time it is painted."""
        if self.visibleRegion().isEmpty():
            self._is_stale = True
        elif not self._timer.isActive():
            self._timer.start()

    def _follow_edit(self, edit: Edit) -> None:
        # A model may be the source of the panel although no feature depends on it.
        records = (*edit.before.values(), *edit.after.values())
        if self._studio.affected_ids(edit) or any(isinstance(record, Model) for record in records):
            self._schedule_refresh()

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        super().paintEvent(event)
        if self._is_stale:
            self._schedule_refresh()


class AnalysisPanel(LazyPanel, Generic[Request, Result]):
    """Panel that computes a result from the project in a worker thread and displays it.

    Parameters
    ----------
    studio : Studio
    prefix : str
        Prefix of the object names.
    topic : str
        Help page of the panel.
    busy_text : str
        Text displayed while a result is being computed.

    Attributes
    ----------
    result : Result or None
        The displayed result, or None if it could not be computed.
    message : Label
        Summary of the result, or the reason why it could not be computed.
    """

    def __init__(self, studio: Studio, prefix: str, topic: str, busy_text: str) -> None:
        super().__init__(studio)
        set_help_topic(self, topic)
        self.result: Result | None = None
        self.message = hint_label()
        self.message.setObjectName(f"{prefix}_message")
        self._background = QtBackground(self)
        self._requests = LatestRequestRunner(
            self, self._show_result, self._show_error, lambda: self.message.setText(busy_text)
        )
        connect_until_deleted(self, studio.jobs.closed, self._close)

    def update_widgets(self) -> None:
        """Request the result for the current form, or show why it cannot be computed."""
        if not self._studio.has_project:
            return
        self._list_choices()
        try:
            request = self._create_request()
        except VomError as error:
            self._requests.cancel()
            self._show_error(error)
        else:
            self._requests.request(partial(self._compute_result, request))
            self._refresh()

    def _list_choices(self) -> None:
        """Update the lists of the form with the records of the project."""

    def _create_request(self) -> Request:
        """Return the input defined by the form.

        Raises VomError if an input is missing or invalid.
        """
        raise NotImplementedError

    def _compute_result(self, request: Request) -> Result:
        """Compute the result. Runs in a worker thread. Raises VomError."""
        raise NotImplementedError

    def _result_text(self, result: Result) -> str:
        """Summarise a result for the user."""
        raise NotImplementedError

    def _show_result(self, result: Result) -> None:
        self._set_result(result, self._result_text(result))

    def _show_error(self, error: VomError) -> None:
        self._set_result(None, error.message)

    def _set_result(self, result: Result | None, message: str) -> None:
        self.result = result
        self.message.setText(message)
        self._draw()
        self._refresh()

    def _draw(self) -> None:
        """Draw the current result."""

    def _refresh(self) -> None:
        """Enable or disable the buttons of the panel."""

    # --- files -------------------------------------------------------------------------------
    def _ask_for_file(self, title: str, name: str, formats: Mapping[str, str]) -> None:
        path = ask_for_target(self, self._studio, title, name, formats)
        if path is not None:
            self.write_result(path)

    def write_result(self, path: Path) -> None:
        """Write the current result to a file in a worker thread."""
        raise NotImplementedError

    def _write(self, write: Callable[[Any, Path], object], result: Any, path: Path) -> None:
        studio = self._studio
        self._background.run(
            partial(write, result, path), lambda _: studio.written(path), studio.fail
        )

    def _close(self) -> None:
        self._timer.stop()
        self._requests.close()
        self._background.stop()
