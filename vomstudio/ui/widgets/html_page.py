"""A page that the program wrote, in the user's browser or, where none is, in a window."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import Qt, QUrl
from PySide6.QtGui import QDesktopServices
from PySide6.QtWidgets import QDialog, QTextBrowser, QVBoxLayout, QWidget

from vomstudio.core.words import tr
from vomstudio.ui.base.controls import Label
from vomstudio.ui.base.long_boxes import fit_to_screen


def open_page(parent: QWidget, path: Path) -> None:
    """parent : of the window that takes the place of a browser"""
    if QDesktopServices.openUrl(QUrl.fromLocalFile(str(path))):
        return
    page = HtmlPage(parent, path)
    page.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    fit_to_screen(page)
    page.show()


class HtmlPage(QDialog):
    """The page as far as Qt's own text view can show it; the file is named for other programs."""

    def __init__(self, parent: QWidget, path: Path) -> None:
        super().__init__(parent)
        self.setWindowTitle(path.name)
        self.resize(900, 700)
        where = Label(tr("No browser was found, so the page is shown here: {file}", file=path))
        where.setWordWrap(True)
        where.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.text = QTextBrowser()
        self.text.setObjectName("html_page")
        self.text.setSource(QUrl.fromLocalFile(str(path)))
        column = QVBoxLayout(self)
        column.addWidget(where)
        column.addWidget(self.text, 1)
