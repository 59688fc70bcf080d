"""What the studio has to say, shown where it belongs: list, status line, bar above the outcrop."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from PySide6.QtCore import QObject
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QStatusBar

from vomstudio.io.project.folder import untitled_folder
from vomstudio.ui.common.messages_panel import MessageBar, MessagesPanel
from vomstudio.ui.common.studio import Notice
from vomstudio.words import tr

_INFO_MS = 6000


class Notices(QObject):
    def __init__(
        self,
        messages: MessagesPanel,
        bar: MessageBar,
        status: QStatusBar,
        actions: Mapping[str, QAction],
    ) -> None:
        super().__init__()
        self._messages, self._bar, self._status = messages, bar, status
        self._actions = actions

    def show(self, notice: Notice) -> None:
        self._messages.add(notice)
        if notice.level == "info":
            self._status.showMessage(notice.text, _INFO_MS)
        elif notice.action:
            action = self._actions[notice.action]
            self._bar.say(notice, (action.text().replace("&", ""), action.trigger))
        else:
            self._bar.say(notice)

    def offer_recovery(self, folders: list[Path], bring_back: Callable[[Path], None]) -> None:
        """folders : projects that were not closed, the newest first"""
        newest = folders[0]
        whose = "" if newest.parent == untitled_folder() else f" of {newest.stem}"
        more = f", and {len(folders) - 1} older" if len(folders) > 1 else ""
        self._bar.say(
            Notice(
                f"Work{whose} that was open when the program ended last time was found{more}.",
                "warning",
            ),
            (tr("Bring it back"), lambda: bring_back(newest)),
        )
