"""The middle of the window: the outcrop, a photo beside it as a second tab, what a workspace is
for, and what the program says."""

from __future__ import annotations

from PySide6.QtCore import QEvent, QObject, QSignalBlocker, Qt, QTimer, Signal
from PySide6.QtWidgets import QFrame, QTabBar, QToolButton, QVBoxLayout, QWidget

from vomstudio.core.words import tr
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import Label
from vomstudio.ui.widgets.messages_panel import MessageBar

# Of Qt, which does not export it.
_NO_LIMIT = 16777215
_OUTCROP, _PHOTO = 0, 1


class OutcropPlace(QWidget):
    """Its height goes to the docks while it shows neither outcrop nor photo; a message still finds
    room.

    outcrop_wanted, photo_wanted, end_wanted : the user has chosen a tab, or wants that of the photo
    closed
    """

    outcrop_wanted = Signal()
    photo_wanted = Signal()
    end_wanted = Signal()

    def __init__(self, first: QWidget) -> None:
        """first : stands in the place of the outcrop until that is there"""
        super().__init__()
        self.room = QWidget()
        """Below the tabs: a message lies over the top of it."""
        self._column = QVBoxLayout(self.room)
        whole = QVBoxLayout(self)
        for column in (self._column, whole):
            column.setContentsMargins(0, 0, 0, 0)
            column.setSpacing(0)
        self._purpose = Label()
        self._purpose.setObjectName("workspace_purpose")
        self._purpose.setWordWrap(True)
        self._purpose.setContentsMargins(8, 4, 8, 4)
        self._purpose.setFrameShape(QFrame.Shape.NoFrame)
        self.tabs = self._make_tabs()
        whole.addWidget(self.tabs)
        whole.addWidget(self.room, 1)
        self._column.addWidget(self._purpose)
        self._column.addWidget(first, 1)
        self._outcrop = first
        self._photo: QWidget | None = None
        self._head: QWidget | None = None
        self._bar: MessageBar | None = None
        self._has_outcrop = True
        self._photo_in_front = False
        self._says_purpose = False
        self._show()

    def _make_tabs(self) -> QTabBar:
        tabs = QTabBar()
        tabs.setObjectName("middle_tabs")
        tabs.setDocumentMode(True)
        tabs.setExpanding(False)
        tabs.setElideMode(Qt.TextElideMode.ElideRight)
        # The keys are those of what is seen.
        tabs.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        tabs.addTab(tr("Outcrop"))
        tabs.addTab(theme.icon("image-outline"), "")
        close = QToolButton()
        close.setObjectName("close_photo_tab")
        close.setIcon(theme.icon("close"))
        close.setAutoRaise(True)
        close.setToolTip(tr("Close the photo (Ctrl+W). Its masks and marks are kept."))
        close.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        close.clicked.connect(self.end_wanted)
        tabs.setTabButton(_PHOTO, QTabBar.ButtonPosition.RightSide, close)
        tabs.currentChanged.connect(
            lambda tab: (self.photo_wanted if tab == _PHOTO else self.outcrop_wanted).emit()
        )
        return tabs

    def set_outcrop(self, outcrop: QWidget) -> None:
        self._column.replaceWidget(self._outcrop, outcrop)
        self._outcrop = outcrop
        self._show()

    def set_bar(self, bar: MessageBar) -> None:
        """bar : lies over the top of the room, or below the tools of a photo"""
        self._bar = bar
        bar.installEventFilter(self)

    # --- outcrop and photo -------------------------------------------------------------------
    @property
    def shows_outcrop(self) -> bool:
        """Whether the outcrop is seen."""
        return self._has_outcrop and not self._photo_in_front

    @property
    def photo_in_front(self) -> bool:
        return self._photo_in_front

    def set_photo(self, photo: QWidget | None, head: QWidget | None = None) -> None:
        """A photo that has a tab from now on, behind the outcrop at first, with the tools at its
        head; None for none."""
        if self._photo is not None:
            self._column.removeWidget(self._photo)
            self._photo.hide()
        self._photo, self._head, self._photo_in_front = photo, head, False
        if photo is not None:
            photo.setParent(self.room)
            self._column.addWidget(photo, 1)
        self._show()

    def name_photo(self, name: str, about: str) -> None:
        """The texts of the tab and of its tooltip."""
        self.tabs.setTabText(_PHOTO, name)
        self.tabs.setTabToolTip(_PHOTO, about)

    def name_outcrop(self, name: str, icon: str) -> None:
        """What is seen instead of the photo: photos have the place of an outcrop that is not there
        yet."""
        self.tabs.setTabText(_OUTCROP, name)
        self.tabs.setTabIcon(_OUTCROP, theme.icon(icon))
        self.tabs.setTabToolTip(_OUTCROP, tr("{name} (F8)", name=name))

    def show_photo(self, in_front: bool) -> None:
        """Bring the photo to the front, or what is beside it."""
        in_front = in_front and self._photo is not None
        if in_front != self._photo_in_front:
            self._photo_in_front = in_front
            self._show()

    def show_outcrop(self, shows: bool) -> None:
        """Give the outcrop its place, or the place to the docks."""
        if shows != self._has_outcrop:
            self._has_outcrop = shows
            self._show()

    def _show(self) -> None:
        with QSignalBlocker(self.tabs):
            self.tabs.setCurrentIndex(_PHOTO if self._photo_in_front else _OUTCROP)
        self.tabs.setVisible(self._photo is not None)
        self._purpose.setVisible(self._says_purpose and not self._photo_in_front)
        # First what goes, or both would ask for room.
        for widget, seen in sorted(
            ((self._outcrop, self.shows_outcrop), (self._photo, self._photo_in_front)),
            key=lambda each: each[1],
        ):
            if widget is not None:
                widget.setVisible(seen)
        if self._bar is not None:
            self._bar.set_top_tools(self._head if self._photo_in_front else None)
        self._fit()
        # The window keeps the room of a dock that has just gone until it lays out anew.
        QTimer.singleShot(0, self, self._lay_out_window)

    def _lay_out_window(self) -> None:
        above = self.parentWidget()
        layout = None if above is None else above.layout()
        if layout is not None:
            layout.invalidate()
            layout.activate()

    def say_purpose(self, text: str) -> None:
        """One line above the outcrop; none where the text is empty."""
        self._purpose.setText(text)
        self._says_purpose = bool(text)
        self._purpose.setVisible(self._says_purpose and not self._photo_in_front)
        self._fit()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        if event.type() in (QEvent.Type.Show, QEvent.Type.Hide, QEvent.Type.Resize):
            self._fit()
        return False

    def _fit(self) -> None:
        if self._has_outcrop or self._photo_in_front:
            self.setMinimumHeight(0)
            self.setMaximumHeight(_NO_LIMIT)
        else:
            # A message lies over the line.
            shown = [w for w in (self._purpose, self._bar) if w is not None and not w.isHidden()]
            heights = [self._purpose.heightForWidth(self.width())] if self._purpose in shown else []
            heights += [self._bar.height()] if self._bar in shown and self._bar else []
            tabs = 0 if self.tabs.isHidden() else self.tabs.sizeHint().height()
            self.setFixedHeight(max(heights, default=0) + tabs)
