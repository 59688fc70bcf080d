"""Alignment window: matches, cameras, residuals and depth maps of a reconstruction."""

from __future__ import annotations

from pathlib import Path

from PySide6.QtCore import Qt
from PySide6.QtWidgets import QDialog, QStackedLayout, QTabWidget, QVBoxLayout, QWidget

from vomstudio.core.words import tr
from vomstudio.ui.base.controls import Label
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.dialogs.alignment.alignment_data import AlignmentData
from vomstudio.ui.dialogs.alignment.calibration_page import CalibrationPage
from vomstudio.ui.dialogs.alignment.depth_page import DepthPage
from vomstudio.ui.dialogs.alignment.match_page import MatchPage
from vomstudio.ui.dialogs.alignment.residual_page import ResidualPage


class AlignmentDialog(QDialog):
    """Window with the alignment of the reconstruction in `folder`."""

    def __init__(self, parent: QWidget, studio: Studio, folder: Path) -> None:
        super().__init__(parent)
        set_help_topic(self, "photos.md#inspect-an-alignment")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowFlag(Qt.WindowType.WindowMaximizeButtonHint)
        self.setWindowTitle(tr("Alignment of {folder}", folder=folder.name))
        self.resize(1280, 800)
        self.folder = folder
        self._data = AlignmentData(studio, folder)
        self.matches = MatchPage(self._data)
        self.cameras = CalibrationPage(self._data)
        self.residuals = ResidualPage(self._data)
        self.depths = DepthPage(self._data)
        self._pages = (self.matches, self.cameras, self.residuals, self.depths)
        self.tabs = QTabWidget()
        self.tabs.setDocumentMode(True)
        for page, title in zip(
            self._pages,
            (tr("&Matches"), tr("&Cameras"), tr("&Residuals"), tr("&Depth maps")),
            strict=True,
        ):
            self.tabs.addTab(page, title)
        self._filled_pages: set[int] = set()
        self._is_ready = False
        self._status = Label(tr("Reading the alignment…"))
        self._status.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._status.setWordWrap(True)
        self._stack = QStackedLayout()
        self._stack.addWidget(self._status)
        self._stack.addWidget(self.tabs)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(6, 6, 6, 6)
        layout.addLayout(self._stack)
        self.tabs.currentChanged.connect(lambda _: self._fill_page())
        self._data.read(self._show_pages, self._status.setText)

    @property
    def is_ready(self) -> bool:
        return self._is_ready

    def _show_pages(self) -> None:
        self._is_ready = True
        self._stack.setCurrentWidget(self.tabs)
        self._fill_page()

    def _fill_page(self) -> None:
        # Each page reads its data when it is first shown.
        index = self.tabs.currentIndex()
        if self._is_ready and index not in self._filled_pages:
            self._filled_pages.add(index)
            self._pages[index].fill()

    def done(self, result: int) -> None:
        """Close the window and cancel its requests."""
        try:
            self._data.close()
        finally:
            super().done(result)
