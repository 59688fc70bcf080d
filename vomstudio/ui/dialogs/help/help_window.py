"""The documentation in a window of its own, from the files that came with the program."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import QSize, Qt, QUrl, Signal
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

from vomstudio.core.files.regular import read_small_text
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import add_splitter, allow
from vomstudio.ui.dialogs.help.help_pages import Page, anchor, pages_in

_SIZE = QSize(1060, 780)
_MARGIN = 18


class PageView(QTextBrowser):
    """Pages of Markdown with their pictures, which are never wider than the page.

    shown : another page is; moved : whether there is a page before and one after this one
    """

    shown = Signal(Path)
    moved = Signal(bool, bool)

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("help_page")
        self.setOpenLinks(False)
        self.anchorClicked.connect(self.follow)
        self.page: Path | None = None
        self._past: list[Path] = []
        self._future: list[Path] = []

    # --- from page to page -------------------------------------------------------------------
    def go_to(self, page: Path) -> None:
        """Read another page. Raises OSError."""
        if page == self.page:
            return
        if self.page is not None:
            self._past.append(self.page)
        self._future.clear()
        self._open(page)

    def go_back(self) -> None:
        if self._past and self.page is not None:
            self._future.append(self.page)
            self._open(self._past.pop())

    def go_on(self) -> None:
        if self._future and self.page is not None:
            self._past.append(self.page)
            self._open(self._future.pop())

    def follow(self, url: QUrl) -> None:
        """A link: a page or heading here; any other address in the user's browser."""
        if not url.isRelative():
            QDesktopServices.openUrl(url)
            return
        if self.page is not None and url.path():
            self.go_to((self.page.parent / url.path()).resolve())
        if url.hasFragment():
            self._scroll_to(url.fragment())

    def _open(self, page: Path) -> None:
        self.page = page
        self._lay_out()
        self.shown.emit(page)
        self.moved.emit(bool(self._past), bool(self._future))

    # --- how it looks ------------------------------------------------------------------------
    def _lay_out(self) -> None:
        assert self.page is not None
        # A document that is filled again keeps an empty line of what was in it.
        document = QTextDocument(self)
        document.setDocumentMargin(_MARGIN)
        document.setMarkdown(read_small_text(self.page))
        for frame in document.rootFrame().childFrames():
            if isinstance(frame, QTextTable):
                form = frame.format()
                form.setBorderCollapse(True)
                form.setCellPadding(4)
                frame.setFormat(form)
        # The one that was shown, being the view's own, goes with this.
        self.setDocument(document)

    def loadResource(self, kind: int, name: QUrl | str) -> object:  # noqa: N802 - Qt's name
        if kind != QTextDocument.ResourceType.ImageResource.value or self.page is None:
            return super().loadResource(kind, name)
        image = QImage(str(self.page.parent / QUrl(name).path()))
        room = self.viewport().width() - 3 * _MARGIN
        if image.width() > room > 0:
            image = image.scaledToWidth(room, Qt.TransformationMode.SmoothTransformation)
        return image

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802 - Qt's name
        super().resizeEvent(event)
        if event.size().width() != event.oldSize().width() and self.page is not None:
            bar = self.verticalScrollBar()
            share = bar.value() / max(1, bar.maximum())
            self._lay_out()
            bar.setValue(round(share * bar.maximum()))

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
        self.setWindowTitle(tr("Documentation"))
        self.resize(_SIZE)
        self._pages = pages_in(folder.resolve())
        self.list = QListWidget()
        self.list.setObjectName("help_pages")
        self.list.setSpacing(2)
        self.list.addItems([page.title for page in self._pages])
        self.view = PageView()
        body = QWidget()
        add_splitter(body, self.list, self.view, [230, 830])
        column = QVBoxLayout(self)
        column.addLayout(self._bar())
        column.addWidget(body, 1)
        self.list.currentRowChanged.connect(lambda row: self.view.go_to(self._pages[row].path))
        self.view.shown.connect(self._show_which)
        self.list.setCurrentRow(0)

    def go_to(self, address: str) -> None:
        """Open a page; address : "PAGE.md", or "PAGE.md#HEADING" for a place in it"""
        self.view.follow(QUrl(address))

    def _bar(self) -> QHBoxLayout:
        back, forward = QPushButton(tr("Back")), QPushButton(tr("Forward"))
        for button, icon, step in (
            (back, "arrow-left", self.view.go_back),
            (forward, "arrow-right", self.view.go_on),
        ):
            button.setIcon(theme.icon(icon))
            button.setAutoDefault(False)
            button.clicked.connect(lambda _=False, step=step: step())

        def moved(past: bool, future: bool) -> None:
            allow(back, None if past else Finding("action.first-page"))
            allow(forward, None if future else Finding("action.last-page"))

        self.view.moved.connect(moved)
        moved(False, False)
        self.words = QLineEdit()
        self.words.setObjectName("help_words")
        self.words.setClearButtonEnabled(True)
        self.words.setPlaceholderText(tr("Find in all pages: Enter goes on"))
        self.words.returnPressed.connect(self._find)
        row = QHBoxLayout()
        row.addWidget(back)
        row.addWidget(forward)
        row.addWidget(self.words, 1)
        return row

    def _show_which(self, page: Path) -> None:
        paths = [each.path for each in self._pages]
        if page in paths:
            self.list.setCurrentRow(paths.index(page))

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
    return words.casefold() in read_small_text(page.path).casefold()
