"""Centre of the window, which shows the outcrop, a photo or a page below messages."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker, Qt, Signal
from PySide6.QtWidgets import QFrame, QTabBar, QToolButton, QVBoxLayout, QWidget

from vomstudio.core.words import tr
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import Label
from vomstudio.ui.widgets.messages_panel import MessageBar

_OUTCROP, _PHOTO, _PAGE = 0, 1, 2


class CentralArea(QWidget):
    """Area that shows the outcrop, a photo or a page, with tabs if a photo or page is open.

    Attributes
    ----------
    outcrop_requested, photo_requested, photo_close_requested, page_close_requested : Signal
        Emitted when the user selects a tab, or closes the photo or the page.
    """

    outcrop_requested = Signal()
    photo_requested = Signal()
    photo_close_requested = Signal()
    page_close_requested = Signal()

    def __init__(self, first_widget: QWidget) -> None:
        """Show the widget `first_widget` until the outcrop view has been created."""
        super().__init__()
        self.available_area = QWidget()
        """Area below the tabs and the purpose, partly covered by messages and the net."""
        self._column = QVBoxLayout(self.available_area)
        outer_layout = QVBoxLayout(self)
        for column in (self._column, outer_layout):
            column.setContentsMargins(0, 0, 0, 0)
            column.setSpacing(0)
        self._purpose = Label()
        self._purpose.setObjectName("workspace_purpose")
        self._purpose.setWordWrap(True)
        self._purpose.setContentsMargins(8, 4, 8, 4)
        self._purpose.setFrameShape(QFrame.Shape.NoFrame)
        self.tabs = self._make_tabs()
        outer_layout.addWidget(self.tabs)
        outer_layout.addWidget(self._purpose)
        outer_layout.addWidget(self.available_area, 1)
        self._column.addWidget(first_widget, 1)
        self._outcrop = first_widget
        self._photo: QWidget | None = None
        self._photo_header: QWidget | None = None
        self._page: QWidget | None = None
        self._bar: MessageBar | None = None
        self._shows_photo = False
        self._has_purpose = False
        self._show_page_or_tabs()

    def _make_tabs(self) -> QTabBar:
        tabs = QTabBar()
        tabs.setObjectName("middle_tabs")
        tabs.setDocumentMode(True)
        tabs.setExpanding(False)
        tabs.setElideMode(Qt.TextElideMode.ElideRight)
        # Keys act on the widget that is shown below.
        tabs.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        tabs.addTab(theme.icon("image-filter-hdr"), tr("Outcrop"))
        tabs.setTabToolTip(_OUTCROP, tr("Outcrop (F8)"))
        tabs.addTab(theme.icon("image-outline"), "")
        tabs.addTab("")
        tooltip = tr("Close the photo (Ctrl+W). Its masks and marks are saved.")
        close_photo = self._close_button("close_photo_tab", tooltip)
        close_photo.clicked.connect(self.photo_close_requested)
        close_page = self._close_button("close_page_tab", tr("Return the page to its place (F12)"))
        close_page.clicked.connect(self.page_close_requested)
        tabs.setTabButton(_PHOTO, QTabBar.ButtonPosition.RightSide, close_photo)
        tabs.setTabButton(_PAGE, QTabBar.ButtonPosition.RightSide, close_page)
        tabs.currentChanged.connect(self._show_tab)
        return tabs

    @staticmethod
    def _close_button(name: str, tooltip: str) -> QToolButton:
        button = QToolButton()
        button.setObjectName(name)
        button.setIcon(theme.icon("close"))
        button.setAutoRaise(True)
        button.setToolTip(tooltip)
        button.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        return button

    def _show_tab(self, tab: int) -> None:
        if tab == _PHOTO:
            self.photo_requested.emit()
        elif tab == _OUTCROP:
            self.outcrop_requested.emit()

    def set_outcrop(self, outcrop: QWidget) -> None:
        """Insert the outcrop view."""
        self._column.replaceWidget(self._outcrop, outcrop)
        self._outcrop = outcrop
        self._show_page_or_tabs()

    def set_message_bar(self, bar: MessageBar) -> None:
        """Set the message bar, which covers the top of the area."""
        self._bar = bar

    # --- visible page ------------------------------------------------------------------------
    @property
    def shows_outcrop(self) -> bool:
        """Whether the outcrop is visible."""
        return self._page is None and not self._shows_photo

    @property
    def shows_photo(self) -> bool:
        """Whether the open photo is visible."""
        return self._shows_photo and self._page is None

    def set_photo(self, photo: QWidget | None, header: QWidget | None = None) -> None:
        """Add a tab for an open photo, with its tools as `header`; None removes the tab."""
        if self._photo is not None:
            self._column.removeWidget(self._photo)
            self._photo.hide()
        self._photo, self._photo_header, self._shows_photo = photo, header, False
        if photo is not None:
            photo.setParent(self.available_area)
            self._column.addWidget(photo, 1)
        self._show_page_or_tabs()

    def name_photo(self, name: str, description: str) -> None:
        """Set the text and tooltip of the photo tab."""
        self.tabs.setTabText(_PHOTO, name)
        self.tabs.setTabToolTip(_PHOTO, description)

    def show_photo(self, is_visible: bool) -> None:
        """Show the photo if `is_visible` is True and a photo is open, otherwise the outcrop."""
        is_visible = is_visible and self._photo is not None
        if is_visible != self._shows_photo:
            self._shows_photo = is_visible
            self._show_page_or_tabs()

    def show_page(self, name: str, title: str, widget: QWidget) -> None:
        """Show a page of the docks instead of the outcrop or photo."""
        self._page = widget
        self.tabs.setTabText(_PAGE, title)
        self.tabs.setTabData(_PAGE, name)
        widget.setParent(self.available_area)
        self._column.addWidget(widget, 1)
        self._show_page_or_tabs()

    def release_page(self) -> QWidget | None:
        """Remove the page and return its widget, or None if no page is shown.

        The outcrop or photo is shown again.
        """
        page, self._page = self._page, None
        if page is not None:
            self._column.removeWidget(page)
            page.hide()
            page.setParent(None)
        self._show_page_or_tabs()
        return page

    def _show_page_or_tabs(self) -> None:
        has_page = self._page is not None
        with QSignalBlocker(self.tabs):
            self.tabs.setTabVisible(_PHOTO, self._photo is not None)
            self.tabs.setTabVisible(_PAGE, has_page)
            current = _PAGE if has_page else _PHOTO if self._shows_photo else _OUTCROP
            self.tabs.setCurrentIndex(current)
        self.tabs.setVisible(self._photo is not None or has_page)
        self._purpose.setVisible(self._has_purpose and self.shows_outcrop)
        visible_widgets = ((self._outcrop, self.shows_outcrop), (self._photo, self.shows_photo))
        # Hidden first, because otherwise both widgets would request space.
        for widget, is_shown in sorted(
            (*visible_widgets, (self._page, has_page)), key=lambda each: each[1]
        ):
            if widget is not None:
                widget.setVisible(is_shown)
        if self._bar is not None:
            self._bar.set_top_tools(self._photo_header if self.shows_photo else None)

    def show_purpose(self, text: str) -> None:
        """Show a line of text above the outcrop; an empty text removes it."""
        self._purpose.setText(text)
        self._has_purpose = bool(text)
        self._purpose.setVisible(self._has_purpose and self.shows_outcrop)
