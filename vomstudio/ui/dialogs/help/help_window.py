"""Documentation window for the pages that are installed with the program."""

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
from vomstudio.ui.base.controls import add_splitter, set_enabled
from vomstudio.ui.dialogs.help.help_pages import Page, anchor, list_pages

_WINDOW_SIZE = QSize(1060, 780)
_MARGIN_PX = 18


class PageView(QTextBrowser):
    """View of one Markdown page, with pictures scaled to its width.

    Attributes
    ----------
    page_changed : Signal
        Emits the path of the new page.
    history_changed : Signal
        Emits whether the history contains a previous and a next page.
    """

    page_changed = Signal(Path)
    history_changed = Signal(bool, bool)

    def __init__(self) -> None:
        super().__init__()
        self.setObjectName("help_page")
        self.setOpenLinks(False)
        self.anchorClicked.connect(self.follow_link)
        self.page: Path | None = None
        self._back_pages: list[Path] = []
        self._forward_pages: list[Path] = []

    # --- navigation --------------------------------------------------------------------------
    def go_to(self, page: Path) -> None:
        """Show another page.

        Raises
        ------
        OSError
            If the page cannot be read.
        """
        if page == self.page:
            return
        if self.page is not None:
            self._back_pages.append(self.page)
        self._forward_pages.clear()
        self._open(page)

    def go_back(self) -> None:
        if self._back_pages and self.page is not None:
            self._forward_pages.append(self.page)
            self._open(self._back_pages.pop())

    def go_forward(self) -> None:
        if self._forward_pages and self.page is not None:
            self._back_pages.append(self.page)
            self._open(self._forward_pages.pop())

    def follow_link(self, url: QUrl) -> None:
        """Follow a link to a page or heading, or open another address in the browser."""
        if not url.isRelative():
            QDesktopServices.openUrl(url)
            return
        if self.page is not None and url.path():
            self.go_to((self.page.parent / url.path()).resolve())
        if url.hasFragment():
            self._scroll_to(url.fragment())

    def _open(self, page: Path) -> None:
        self.page = page
        self._show_document()
        self.page_changed.emit(page)
        self.history_changed.emit(bool(self._back_pages), bool(self._forward_pages))

    # --- layout ------------------------------------------------------------------------------
    def _show_document(self) -> None:
        assert self.page is not None
        # A document that is refilled keeps an empty line of its previous text.
        document = QTextDocument(self)
        document.setDocumentMargin(_MARGIN_PX)
        document.setMarkdown(read_small_text(self.page))
        for frame in document.rootFrame().childFrames():
            if isinstance(frame, QTextTable):
                table_format = frame.format()
                table_format.setBorderCollapse(True)
                table_format.setCellPadding(4)
                frame.setFormat(table_format)
        # This deletes the previous document, which belongs to the view.
        self.setDocument(document)

    def loadResource(self, resource_type: int, name: QUrl | str) -> object:  # noqa: N802 - Qt's name
        if resource_type != QTextDocument.ResourceType.ImageResource.value or self.page is None:
            return super().loadResource(resource_type, name)
        image = QImage(str(self.page.parent / QUrl(name).path()))
        max_width = self.viewport().width() - 3 * _MARGIN_PX
        if image.width() > max_width > 0:
            image = image.scaledToWidth(max_width, Qt.TransformationMode.SmoothTransformation)
        return image

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802 - Qt's name
        super().resizeEvent(event)
        if event.size().width() != event.oldSize().width() and self.page is not None:
            scroll_bar = self.verticalScrollBar()
            scroll_ratio = scroll_bar.value() / max(1, scroll_bar.maximum())
            self._show_document()
            scroll_bar.setValue(round(scroll_ratio * scroll_bar.maximum()))

    def _scroll_to(self, heading: str) -> None:
        block = self.document().begin()
        while block.isValid():
            if block.blockFormat().headingLevel() and anchor(block.text()) == heading:
                self.setTextCursor(QTextCursor(block))
                offset = self.cursorRect().top() + self.verticalScrollBar().value()
                self.verticalScrollBar().setValue(offset - _MARGIN_PX)
                return
            block = block.next()


class HelpWindow(QDialog):
    """Window with a list of pages, the selected page, and a search field for all pages."""

    def __init__(self, parent: QWidget, folder: Path) -> None:
        """Show the pages of a folder.

        Raises
        ------
        OSError
            If the pages cannot be read.
        """
        super().__init__(parent)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(tr("Documentation"))
        self.resize(_WINDOW_SIZE)
        self._pages = list_pages(folder.resolve())
        self.list = QListWidget()
        self.list.setObjectName("help_pages")
        self.list.setSpacing(2)
        self.list.addItems([page.title for page in self._pages])
        self.list.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        frame_width = 2 * (self.list.frameWidth() + self.list.spacing())
        bar_width = self.list.verticalScrollBar().sizeHint().width()
        list_width = self.list.sizeHintForColumn(0) + frame_width + bar_width
        self.list.setMinimumWidth(list_width)
        self.view = PageView()
        body = QWidget()
        add_splitter(body, self.list, self.view, [list_width, _WINDOW_SIZE.width() - list_width])
        column = QVBoxLayout(self)
        column.addLayout(self._create_navigation_bar())
        column.addWidget(body, 1)
        self.list.currentRowChanged.connect(lambda row: self.view.go_to(self._pages[row].path))
        self.view.page_changed.connect(self._select_in_list)
        self.list.setCurrentRow(0)

    def go_to(self, address: str) -> None:
        """Open a page by its address "PAGE.md" or "PAGE.md#HEADING"."""
        self.view.follow_link(QUrl(address))

    def _create_navigation_bar(self) -> QHBoxLayout:
        back_button, forward_button = QPushButton(tr("Back")), QPushButton(tr("Forward"))
        for button, icon, navigate in (
            (back_button, "arrow-left", self.view.go_back),
            (forward_button, "arrow-right", self.view.go_forward),
        ):
            button.setIcon(theme.icon(icon))
            button.setAutoDefault(False)
            button.clicked.connect(lambda _=False, navigate=navigate: navigate())

        def update_buttons(has_previous: bool, has_next: bool) -> None:
            set_enabled(back_button, None if has_previous else Finding("action.first-page"))
            set_enabled(forward_button, None if has_next else Finding("action.last-page"))

        self.view.history_changed.connect(update_buttons)
        update_buttons(False, False)
        self.search = QLineEdit()
        self.search.setObjectName("help_words")
        self.search.setClearButtonEnabled(True)
        self.search.setPlaceholderText(tr("Search all pages (Enter: next)"))
        self.search.returnPressed.connect(self._find_page)
        row = QHBoxLayout()
        row.addWidget(back_button)
        row.addWidget(forward_button)
        row.addWidget(self.search, 1)
        return row

    def _select_in_list(self, page: Path) -> None:
        paths = [entry.path for entry in self._pages]
        if page in paths:
            self.list.setCurrentRow(paths.index(page))

    def _find_page(self) -> None:
        """Find the next occurrence after the cursor, and continue on the following pages."""
        text = self.search.text().strip()
        if not text or self.view.find(text):
            return
        current_row = self.list.currentRow()
        for row in (*range(current_row + 1, len(self._pages)), *range(current_row + 1)):
            if _has_text(self._pages[row], text):
                self.list.setCurrentRow(row)
                self.view.moveCursor(QTextCursor.MoveOperation.Start)
                if self.view.find(text):
                    return


def _has_text(page: Page, text: str) -> bool:
    return text.casefold() in read_small_text(page.path).casefold()
