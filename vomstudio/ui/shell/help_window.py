"""The documentation in a window of its own, from the files that came with the program."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QSize, Qt, QUrl
from PySide6.QtGui import (
    QDesktopServices,
    QImage,
    QResizeEvent,
    QTextCursor,
    QTextDocument,
    QTextTable,
)
from PySide6.QtWidgets import (
    QDialog,
    QHBoxLayout,
    QLineEdit,
    QListWidget,
    QPushButton,
    QTextBrowser,
    QVBoxLayout,
    QWidget,
)

from vomstudio.ui.common import theme
from vomstudio.ui.common.widgets import side_by_side
from vomstudio.ui.shell.help_pages import Page, anchor, pages_in

_SIZE = QSize(1060, 780)
_MARGIN = 18


class PageView(QTextBrowser):
    """Pages of Markdown with their pictures, which are never wider than the page."""

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("help_page")
        self.setOpenLinks(False)
        self.anchorClicked.connect(self.follow)
        # A long page is laid out anew for every width: not for each of a drag.
        self.sourceChanged.connect(lambda _: self._dress())

    def follow(self, url: QUrl) -> None:
        """A page of the documentation here; any other address in the user's browser."""
        there = self.source().resolved(url)
        if not there.isLocalFile():
            QDesktopServices.openUrl(there)
            return
        heading = there.fragment()
        there.setFragment(None)
        if there != self.source():
            self.setSource(there, QTextDocument.ResourceType.MarkdownResource)
        if heading:
            self._scroll_to(heading)

    def loadResource(self, kind: int, name: QUrl) -> object:  # noqa: N802 - Qt's name
        if kind != int(QTextDocument.ResourceType.ImageResource.value):
            return super().loadResource(kind, name)
        image = QImage(self.source().resolved(name).toLocalFile())
        room = self.viewport().width() - 3 * _MARGIN
        if image.width() > room > 0:
            mode = Qt.TransformationMode.SmoothTransformation
            image = image.scaledToWidth(room, mode)
        return image

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802 - Qt's name
        super().resizeEvent(event)
        if event.size().width() != event.oldSize().width() and not self.source().isEmpty():
            at = self.verticalScrollBar().value() / max(1, self.verticalScrollBar().maximum())
            self.reload()
            self._dress()
            self.verticalScrollBar().setValue(round(at * self.verticalScrollBar().maximum()))

    def _dress(self) -> None:
        """What Markdown leaves to the reader: margins, lines of tables, letters of code."""
        document = self.document()
        document.setDocumentMargin(_MARGIN)
        for frame in document.rootFrame().childFrames():
            if isinstance(frame, QTextTable):
                form = frame.format()
                form.setBorderCollapse(True)
                form.setCellPadding(4)
                frame.setFormat(form)

    def _scroll_to(self, heading: str) -> None:
        block = self.document().begin()
        while block.isValid():
            if block.blockFormat().headingLevel() and anchor(block.text()) == heading:
                self.setTextCursor(QTextCursor(block))
                where = self.cursorRect().top() + self.verticalScrollBar().value()
                self.verticalScrollBar().setValue(where - _MARGIN)
                return
            block = block.next()


class HelpWindow(QDialog):
    """Pages on the left, one of them on the right, and a field that looks for words in all."""

    def __init__(self, parent: QWidget, folder: Path) -> None:
        """folder : of the pages. Raises OSError where they cannot be read."""
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(self.tr("Documentation"))
        self.resize(_SIZE)
        self._pages = pages_in(folder)
        self.list = QListWidget()
        self.list.setObjectName("help_pages")
        self.list.addItems([page.title for page in self._pages])
        self.view = PageView()
        body = QWidget()
        side_by_side(body, self.list, self.view, [230, 830])
        column = QVBoxLayout(self)
        column.addLayout(self._bar())
        column.addWidget(body, 1)
        self.list.currentRowChanged.connect(self._choose)
        self.view.sourceChanged.connect(self._show_which)
        self.list.setCurrentRow(0)

    def _bar(self) -> QHBoxLayout:
        back, forward = QPushButton(self.tr("Back")), QPushButton(self.tr("Forward"))
        for button, icon, step, can in (
            (back, "arrow-left", self.view.backward, self.view.backwardAvailable),
            (forward, "arrow-right", self.view.forward, self.view.forwardAvailable),
        ):
            button.setIcon(theme.icon(icon))
            button.setAutoDefault(False)
            button.setEnabled(False)
            button.clicked.connect(step)
            can.connect(button.setEnabled)
        self.words = QLineEdit()
        self.words.setObjectName("help_words")
        self.words.setClearButtonEnabled(True)
        self.words.setPlaceholderText(self.tr("Find in all pages: Enter goes on"))
        self.words.returnPressed.connect(self._find)
        row = QHBoxLayout()
        row.addWidget(back)
        row.addWidget(forward)
        row.addWidget(self.words, 1)
        return row

    def _choose(self, row: int) -> None:
        url = QUrl.fromLocalFile(str(self._pages[row].path))
        if url != self.view.source():
            self.view.setSource(url, QTextDocument.ResourceType.MarkdownResource)

    def _show_which(self, url: QUrl) -> None:
        paths = [page.path for page in self._pages]
        if (path := Path(url.toLocalFile())) in paths:
            self.list.setCurrentRow(paths.index(path))

    def _find(self) -> None:
        """The next place after the cursor, on this page or on one that follows, round to here."""
        wanted = self.words.text().strip()
        if not wanted or self.view.find(wanted):
            return
        here = self.list.currentRow()
        for row in (*range(here + 1, len(self._pages)), *range(here + 1)):
            if _holds(self._pages[row], wanted):
                self.list.setCurrentRow(row)
                self.view.moveCursor(QTextCursor.MoveOperation.Start)
                if self.view.find(wanted):
                    return


def _holds(page: Page, words: str) -> bool:
    return words.casefold() in page.path.read_text("utf-8").casefold()
