"""Display of notices in the list of messages, the status line or the message bar."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, QUrl
from PySide6.QtGui import QAction, QDesktopServices
from PySide6.QtWidgets import QStatusBar

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project.folder import is_free, untitled_folder
from vomstudio.ui.base.studio import Notice
from vomstudio.ui.base.window_protocols import Docks
from vomstudio.ui.widgets.messages_panel import MessageBar, MessagesPanel

_INFO_DURATION_MS = 6000


class NoticePresenter(QObject):
    """Presenter that lists each notice, and shows it in the status line or message bar."""

    def __init__(
        self,
        messages: MessagesPanel,
        bar: MessageBar,
        status: QStatusBar,
        actions: Mapping[str, QAction],
        docks: Docks,
    ) -> None:
        super().__init__()
        self._messages, self._bar, self._status = messages, bar, status
        self._actions = actions
        self._repeat_offer: Callable[[], None] | None = None
        bar.connect_history(lambda: docks.bring_forward("messages"))

    def end_project(self) -> None:
        """Clear the messages of the previous project, but keep an open offer to restore work."""
        offer = self._repeat_offer if self._bar.isVisible() else None
        self._messages.clear()
        self._bar.clear()
        self._status.clearMessage()
        if offer is not None:
            offer()

    def show(self, notice: Notice) -> None:
        """List a notice and show it according to its level, with a button for its action."""
        self._messages.add(notice)
        if notice.file is not None:
            self._bar.show_notice(
                notice,
                (tr("Open"), partial(_open, notice.file)),
                (tr("Open folder"), partial(_open, notice.file.parent)),
            )
        elif notice.level == "info" and not notice.action:
            self._status.showMessage(notice.text, _INFO_DURATION_MS)
        elif notice.action:
            action = self._actions[notice.action]
            self._bar.show_notice(notice, (action.text().replace("&", ""), action.trigger))
        else:
            self._bar.show_notice(notice)

    def offer_recovery(self, folders: list[Path], restore: Callable[[Path], None]) -> None:
        """Offer to restore the newest project that was not closed, unless it is in use.

        Parameters
        ----------
        folders : list of Path
            Folders of the projects, the newest first.
        restore : callable
            Opens one of the projects.
        """
        newest = folders[0]
        if not is_free(newest):
            return
        if newest.parent == untitled_folder():
            finding = Finding("project.unsaved-found")
        else:
            finding = Finding("project.unclosed", project=newest.stem)
        older_count = len(folders) - 1
        further = (Finding("project.older-unclosed", count=older_count),) if older_count else ()
        notice = Notice(finding, "warning", more=further)
        self._repeat_offer = partial(self.offer_recovery, folders, restore)
        self._messages.add(notice)
        button = (tr("Restore"), lambda: restore(newest))
        shown_notice = self._bar.notice if self._bar.isVisible() else None
        if shown_notice is None or shown_notice.level == "hint":
            self._bar.show_notice(notice, button)
        else:
            # A message about a crash or about a file that the user has opened stays in front.
            self._bar.add_button(tr("Restore unsaved work"), button[1])


def _open(path: Path) -> None:
    """Open a file or folder in the program that the system uses for it."""
    QDesktopServices.openUrl(QUrl.fromLocalFile(str(path.resolve())))
