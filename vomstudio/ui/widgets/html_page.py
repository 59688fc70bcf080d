"""Display of an HTML page in the user's browser, or in a window if there is no browser."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import Qt, QUrl
from PySide6.QtGui import QDesktopServices
from PySide6.QtWidgets import QDialog, QTextBrowser, QVBoxLayout, QWidget

from vomstudio.core.words import tr
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import Label
from vomstudio.ui.base.window_fitting import fit_to_screen


def open_page(parent: QWidget, path: Path) -> None:
    """Open a page in the browser, or in a dialog if no browser is found.

    Parameters
    ----------
    parent : QWidget
        Parent of the dialog.
    """
    if QDesktopServices.openUrl(QUrl.fromLocalFile(str(path))):
        return
    page = HtmlPage(parent, path)
    page.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
    fit_to_screen(page)
    page.show()


class HtmlPage(QDialog):
    """Dialog that shows a page in Qt's limited text browser, with the path of its file."""

    def __init__(self, parent: QWidget, path: Path) -> None:
        super().__init__(parent)
        self.setWindowTitle(path.name)
        self.resize(900, 700)
        location = Label(tr("No browser was found, so the page is shown here: {file}", file=path))
        location.setWordWrap(True)
        location.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self.text = QTextBrowser()
        self.text.setObjectName("html_page")
        # Reports state dark colours for white paper.
        self.text.setPalette(theme.paper_palette())
        self.text.setSource(QUrl.fromLocalFile(str(path)))
        column = QVBoxLayout(self)
        column.addWidget(location)
        column.addWidget(self.text, 1)
