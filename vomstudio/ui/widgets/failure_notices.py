"""Display of program errors in a message above the viewport, and error reports."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

from PySide6.QtCore import QObject, Qt, QTimer, Signal
from PySide6.QtWidgets import QMessageBox, QWidget

from vomstudio.core.errors import VomError
from vomstudio.core.failures import crashes, report
from vomstudio.core.failures.error_collector import ERRORS, Failure
from vomstudio.core.files.atomic import write_bytes
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.studio.notices import Notice
from vomstudio.ui.base.controls import escape_markup

# This module is imported before the window is filled: no slow imports.
if TYPE_CHECKING:
    from vomstudio.ui.base.actions import Actions
    from vomstudio.ui.base.studio import Studio
    from vomstudio.ui.widgets.messages_panel import MessageBar, MessagesPanel

_log = logging.getLogger(__name__)
_MAX_REPORT_EDITS = 50
_REPORT_ACTION = "save_report"
_ANSWER_TIMEOUT_MS = 60_000
"""Maximum time for which a message delays closing, for example at the end of the session."""


class Host(Protocol):
    """Protocol of the window that shows program errors; its parts exist once it is filled."""

    studio: Studio
    actions_table: Actions
    messages: MessagesPanel
    message_bar: MessageBar

    @property
    def is_filled(self) -> bool: ...


class FailureNotices(QObject):
    """Receiver of errors from any thread, which shows them in the window's thread."""

    _failure_received = Signal(object)

    def __init__(self, host: Host, parent: QWidget) -> None:
        super().__init__()
        self._host, self._parent = host, parent
        self._pending_failures: list[Failure] = []
        self._failure_received.connect(self._queue_failure, Qt.ConnectionType.QueuedConnection)
        ERRORS.listen(self._forward)

    def begin(self) -> None:
        """Show errors that occurred before the window was filled, and a crash of the last run."""
        if crashes.has_new_crash():
            self._show_crash()
        pending_failures, self._pending_failures = self._pending_failures, []
        for failure in pending_failures:
            self._queue_failure(failure)

    def _show_crash(self) -> None:
        notice = Notice(
            Finding("program.crashed"),
            "error",
            _REPORT_ACTION,
        )
        bar, action = self._host.message_bar, self._host.actions_table.all[_REPORT_ACTION]
        if bar.isVisible():
            # The bar offers unsaved work, which has priority.
            self._host.messages.add(notice)
            bar.add_button(action.text().replace("&", ""), action.trigger)
        else:
            self._host.studio.notice.emit(notice)

    def close(self) -> None:
        """Stop showing errors because the window was closed."""
        ERRORS.listen(None)
        self._failure_received.disconnect(self._queue_failure)

    def show_fatal(self, error: BaseException) -> None:
        """Show an error that prevents filling the window, and offer a report."""
        ERRORS.listen(None)
        ERRORS.report(error, "while the window was filled")
        box = QMessageBox(
            QMessageBox.Icon.Critical,
            "VOM Studio",
            tr(
                "The program cannot start because of an internal error ({kind}: {error}).",
                kind=type(error).__name__,
                error=escape_markup(str(error)),
            ),
            QMessageBox.StandardButton.Close,
            self._parent,
        )
        button = box.addButton(tr("Save report…"), QMessageBox.ButtonRole.ActionRole)
        box.exec()
        if box.clickedButton() is button:
            save_report(self._host, self._parent)

    def _forward(self, failure: Failure) -> None:
        # Qt may have deleted the window and this object.
        with contextlib.suppress(RuntimeError):
            self._failure_received.emit(failure)

    def _queue_failure(self, failure: Failure) -> None:
        if not self._host.is_filled:
            self._pending_failures.append(failure)
        else:
            self._show_failure(failure)

    def _show_failure(self, failure: Failure) -> None:
        notice = Notice(failure.finding, "error", _REPORT_ACTION, failure.repetitions)
        try:
            self._host.studio.notice.emit(notice)
        except Exception:  # noqa: BLE001 - reporting it would lead back here
            _log.exception("an error could not be shown: %s", notice.text)


def can_close(host: Host, parent: QWidget, questions: Sequence[Callable[[], bool]]) -> bool:
    """Ask the questions in turn, and return whether the window may close.

    If a question fails, the error is shown and the user decides.
    """
    try:
        return all(question() for question in questions)
    except Exception as error:  # noqa: BLE001 - or Qt would close the window without a word
        ERRORS.report(error, "before the window was closed")
        box = _create_box(
            host,
            parent,
            tr(
                "Because of an internal error, the program cannot ask about unsaved changes"
                " ({kind}: {error}).",
                kind=type(error).__name__,
                error=escape_markup(str(error)),
            ),
        )
        close_button = box.addButton(tr("Close anyway"), QMessageBox.ButtonRole.DestructiveRole)
        box.setDefaultButton(box.addButton(QMessageBox.StandardButton.Cancel))
        _run_message_box(box, host, parent)
        return box.clickedButton() is close_button


def close_all(host: Host, parent: QWidget, steps: Sequence[Callable[[], object]]) -> None:
    """Run all closing steps even if some fail, and show the errors at the end.

    This function never raises an error.
    """
    failures: list[Exception] = []
    for step in steps:
        try:
            step()
        except Exception as error:  # noqa: BLE001 - the rest must be closed all the same
            ERRORS.report(error, "while the window was closed")
            failures.append(error)
    if not failures:
        return
    box = _create_box(
        host,
        parent,
        tr(
            "The window closes, but an internal error occurred while closing ({kind}: {error}).",
            kind=type(failures[0]).__name__,
            error=escape_markup(str(failures[0])),
        ),
    )
    box.addButton(QMessageBox.StandardButton.Close)
    timeout_timer = QTimer(box)
    timeout_timer.timeout.connect(box.reject)
    timeout_timer.start(_ANSWER_TIMEOUT_MS)
    _run_message_box(box, host, parent)
    timeout_timer.stop()


def _create_box(host: Host, parent: QWidget, sentence: str) -> QMessageBox:
    """Create a message box that also states whether the work is saved."""
    box = QMessageBox(parent)
    box.setIcon(QMessageBox.Icon.Critical)
    box.setText(sentence)
    failure = None
    with contextlib.suppress(Exception):
        failure = host.studio.project.write_failure
    box.setInformativeText(
        tr("All your work is in the journal and will be restored when you open the project.")
        if failure is None
        else escape_markup(failure.message)
    )
    return box


def _run_message_box(box: QMessageBox, host: Host, parent: QWidget) -> None:
    """Show a message box until the user gives an answer other than saving the report."""
    save = box.addButton(tr("Save report…"), QMessageBox.ButtonRole.ActionRole)
    box.exec()
    while box.clickedButton() is save:
        save_report(host, parent)
        box.exec()


def save_report(host: Host, parent: QWidget) -> None:
    """Ask for a file and write the error report to it; nothing is sent."""
    from vomstudio.ui.base.command_targets import ask_for_file

    proposed_path = Path.home() / report.file_name()
    answer = ask_for_file(parent, tr("Save report"), proposed_path, {tr("Text (*.txt)"): ".txt"})
    if answer is None:
        return
    path = answer[0]
    try:
        write_bytes(path, compose_report(host).encode(), force=True)
    except VomError as error:
        if host.is_filled:
            host.studio.fail(error)
        else:
            QMessageBox.critical(parent, "VOM Studio", escape_markup(str(error)))
        return
    if host.is_filled:
        host.studio.info(Finding("program.report-written", file=path))


def compose_report(host: Host) -> str:
    """Return the text of the error report, with the last edits of the open project."""
    if not host.is_filled:
        return report.compose()
    from vomstudio.project.journal.outline import outline

    studio = host.studio
    names: list[str] = []
    with contextlib.suppress(Exception):
        names = [getattr(record, "name", "") for record in studio.records.values()]
        names.append(studio.project.name)
    journal = studio.project.journal
    return report.compose(
        [("Edits", lambda: outline(journal.last_rows(_MAX_REPORT_EDITS)))],
        private_words=names,
    )
