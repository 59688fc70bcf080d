"""Start page of an empty window."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QEvent, QObject, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QFrame,
    QSizePolicy,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.files.regular import path_exists
from vomstudio.core.words import tr
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import Label, PanelScrollArea, escape_markup
from vomstudio.ui.base.studio import Studio

_BUTTON_WIDTH_PX = 280


class StartPage(QFrame):
    """Start page with buttons to open data, and the recent files."""

    def __init__(
        self, studio: Studio, actions: dict[str, QAction], open_path: Callable[[Path], None]
    ) -> None:
        """Create the page. `open_path` opens a model, a project or a folder of photos."""
        super().__init__()
        self._studio, self._open_path = studio, open_path
        self.setObjectName("start_page")
        self.setAutoFillBackground(True)
        self.setFrameShape(QFrame.Shape.StyledPanel)
        title = Label(tr("VOM Studio"))
        font = title.font()
        font.setPointSizeF(font.pointSizeF() * 1.8)
        title.setFont(font)
        page = QWidget()
        layout = QVBoxLayout(page)
        layout.setSpacing(8)
        layout.addWidget(title)
        subtitle = Label(tr("From photos of an outcrop to orientations with their errors"))
        layout.addWidget(subtitle)
        layout.addSpacing(6)
        self._buttons: list[QToolButton] = []
        for name in ("open", "choose_photos", "open_sample", "open_project"):
            button = QToolButton()
            self._buttons.append(button)
            button.setDefaultAction(actions[name])
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
            layout.addWidget(button)
        self._tour_button = QToolButton()
        self._tour_button.setDefaultAction(actions["first_tour"])
        self._tour_button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        layout.addWidget(self._tour_button)
        studio.settings_changed.connect(self._offer_tour)
        self._offer_tour()
        self._recent_layout = QVBoxLayout()
        layout.addSpacing(6)
        layout.addLayout(self._recent_layout)
        drop = Label(tr("or drop a file or a folder of photos onto the window"))
        layout.addWidget(drop)
        self._column, self._wrapped_labels = layout, (subtitle, drop)
        self._buttons.append(self._tour_button)
        outer_layout = QVBoxLayout(self)
        outer_layout.setContentsMargins(0, 0, 0, 0)
        self._area = PanelScrollArea(page)
        outer_layout.addWidget(self._area)
        studio.recent_changed.connect(self._fill)
        self._fill()

    def _offer_tour(self) -> None:
        """Offer the tour once; later it is available in the Help menu."""
        self._tour_button.setVisible(self._studio.settings.offer_tour)

    def _fill(self) -> None:
        while (item := self._recent_layout.takeAt(0)) is not None:
            if (old_widget := item.widget()) is not None:
                old_widget.deleteLater()
        existing = [Path(p) for p in self._studio.settings.recent if path_exists(p)][:5]
        if existing:
            self._recent_layout.addWidget(Label(tr("Recent")))
        for path in existing:
            # With an icon the text is left-aligned without a style sheet, which would keep the
            # colours of the previous theme.
            button = QToolButton()
            button.setText(path.name.replace("&", "&&"))
            button.setIcon(theme.icon("history"))
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
            button.setToolTip(escape_markup(str(path)))
            button.setAutoRaise(True)
            button.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
            button.clicked.connect(lambda _=False, p=path: self._open_path(p))
            self._recent_layout.addWidget(button)

    def place_over(self, viewport: QWidget) -> None:
        """Keep the page in the centre of the viewport."""
        viewport.installEventFilter(self)
        self._centre(viewport)
        self.raise_()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        if event.type() == QEvent.Type.Resize and isinstance(watched, QWidget):
            self._centre(watched)
        return False

    def _centre(self, viewport: QWidget) -> None:
        self._adapt_width(is_narrow=False)
        if self.width() > viewport.width():
            self._adapt_width(is_narrow=True)
        # The page scrolls in a small window.
        self.resize(self.size().boundedTo(viewport.size()))
        self.move(
            max(0, (viewport.width() - self.width()) // 2),
            max(0, (viewport.height() - self.height()) // 2),
        )

    def _adapt_width(self, *, is_narrow: bool) -> None:
        """Set the width of the buttons; if `is_narrow`, long texts take several lines."""
        for label in self._wrapped_labels:
            label.setWordWrap(is_narrow)
        for button in self._buttons:
            button.setMinimumWidth(0 if is_narrow else _BUTTON_WIDTH_PX)
            # All buttons have the same width, even in a narrow page.
            width = QSizePolicy.Policy.Expanding if is_narrow else QSizePolicy.Policy.Fixed
            button.setSizePolicy(width, QSizePolicy.Policy.Fixed)
        margin = 10 if is_narrow else 28
        self._column.setContentsMargins(margin, 22, margin, 22)
        # Otherwise the size would remain the previous one until Qt updates the layout.
        self._column.invalidate()
        self._area.updateGeometry()
        self.adjustSize()
