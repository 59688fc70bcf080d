"""Introductory tour of nine steps, which advances when the user completes a step.

The steps point at widgets of the real window. The tour does not block anything, and all actions
remain available in any order. Esc ends the tour, unless a feature is being picked or a text is
being edited.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from PySide6.QtCore import QEvent, QObject, QPoint, QRect, Qt, QTimer
from PySide6.QtGui import QAction, QKeyEvent
from PySide6.QtWidgets import (
    QAbstractSpinBox,
    QApplication,
    QLineEdit,
    QPlainTextEdit,
    QTextEdit,
    QWidget,
)
from shiboken6 import isValid

from vomstudio.core.words import to_translate, tr
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.window_protocols import Docks
from vomstudio.ui.outcrop.outcrop_view import OutcropView
from vomstudio.ui.shell.tour_card import TourCard, TourFrame, frame_box, place_card
from vomstudio.ui.shell.tour_steps import TourStep, steps

_CHECK_INTERVAL_MS = 150
_END = to_translate(
    "That was the tour. Continue with Help > Documentation. F1 explains the control under the"
    " cursor, and Ctrl+K finds every command."
)


class Tour(QObject):
    """Introductory tour; `step` is the index of the current step, or None if it is closed."""

    def __init__(
        self,
        window: QWidget,
        studio: Studio,
        all_steps: list[TourStep],
        net: Callable[[], QWidget | None],
    ) -> None:
        super().__init__(window)
        self._net = net
        self._window, self._studio, self._steps = window, studio, all_steps
        self.step: int | None = None
        self._initial_state: Any = None
        self._card: TourCard | None = None
        self._frame: TourFrame | None = None
        self._timer = QTimer(self)
        self._timer.setInterval(_CHECK_INTERVAL_MS)
        self._timer.timeout.connect(self._check_step)

    # --- coming and going --------------------------------------------------------------------
    def start(self) -> None:
        """Start the tour, or restart it from the first step."""
        self.end()
        self._card, self._frame = TourCard(self._window), TourFrame(self._window)
        self._card.next_requested.connect(self._show_next_step)
        self._card.ended.connect(self.end)
        application = QApplication.instance()
        assert application is not None
        application.installEventFilter(self)
        settings = self._studio.settings
        if settings.offer_tour:
            settings.offer_tour = False
            self._studio.keep_settings()
        self._show_step(0)
        self._timer.start()

    def end(self) -> None:
        """End the tour at any step."""
        if self._card is None or self._frame is None:
            return
        self._timer.stop()
        application = QApplication.instance()
        assert application is not None
        application.removeEventFilter(self)
        for widget in (self._card, self._frame):
            widget.hide()
            widget.deleteLater()
        self._card = self._frame = self.step = None

    # --- step after step ---------------------------------------------------------------------
    def _show_step(self, number: int, result: str = "") -> None:
        """Show a step, and the result of the step before it."""
        assert self._card is not None
        self.step = number
        if number == len(self._steps):
            self._card.show_text(tr("Finished"), _join(result, tr(_END)), tr("Close"))
        else:
            step = self._steps[number]
            self._initial_state = step.now()
            self._card.show_text(
                tr("Step {number} of {count}", number=number + 1, count=len(self._steps)),
                _join(result, tr(step.text)),
                tr("Next") if step.has_next_button else tr("Skip"),
            )
        self._place_card()
        self._card.show()

    def _show_next_step(self) -> None:
        if self.step is None or self.step == len(self._steps):
            self.end()
        else:
            self._show_step(self.step + 1)

    def _check_step(self) -> None:
        """Check whether the current step is done, and update the frame around its target."""
        if self.step is None or not isValid(self._window):
            return
        if self.step < len(self._steps) and self._steps[self.step].done(self._initial_state):
            self._show_step(self.step + 1, self._steps[self.step].result())
        else:
            self._place_card()

    def _place_card(self) -> None:
        assert self._card is not None
        assert self._frame is not None
        target = None
        if self.step is not None and self.step < len(self._steps):
            target = self._steps[self.step].target()
        box = None if target is None else self._widget_box(target)
        if box is None:
            self._frame.hide()
        else:
            self._frame.setGeometry(frame_box(box, self._window.size()))
            self._frame.show()
            self._frame.raise_()
        # The net is read while planes are picked.
        net = self._net()
        covered_box = None if net is None else self._widget_box(net)
        position = place_card(box, self._card.size(), self._window.size(), covered_box)
        if self._card.pos() != position:
            self._card.move(position)
        self._card.raise_()

    def _widget_box(self, target: QWidget) -> QRect | None:
        """Return the rectangle of a target in this window, or None if it is not visible there."""
        if target.window() is not self._window or not target.isVisible():
            return None
        return QRect(target.mapTo(self._window, QPoint(0, 0)), target.size())

    # --- Esc ---------------------------------------------------------------------------------
    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802 - Qt's name
        if not isinstance(event, QKeyEvent) or event.key() != Qt.Key.Key_Escape:
            return False
        if event.modifiers() or not self._is_escape_available():
            return False
        if event.type() == QEvent.Type.ShortcutOverride:
            # Otherwise the command of Esc in the outcrop would receive the key.
            event.accept()
            return True
        if event.type() == QEvent.Type.KeyPress:
            self.end()
            return True
        return False

    def _is_escape_available(self) -> bool:
        if QApplication.activePopupWidget() is not None or self._studio.open_tool is not None:
            return False
        if QApplication.activeWindow() is not self._window:
            return False
        editor_types = QLineEdit | QAbstractSpinBox | QPlainTextEdit | QTextEdit
        return not isinstance(QApplication.focusWidget(), editor_types)


def _join(result: str, text: str) -> str:
    return f"✓ {result}\n\n{text}" if result else text


def commands(
    studio: Studio,
    actions: Mapping[str, QAction],
    view: OutcropView,
    docks: Docks,
    window: QWidget,
) -> list[Command]:
    """Return the commands of the tour. Entries may be added to `actions` later."""
    tours: list[Tour] = []

    def start() -> None:
        if not tours:
            all_steps = steps(studio, actions, view, docks)
            tours.append(
                Tour(window, studio, all_steps, partial(docks.find_page_widget, "stereonet"))
            )
        tours[0].start()

    return [
        Command(
            "first_tour",
            tr("&First tour"),
            start,
            "map-marker-path",
            (),
            tr("Learn the window in nine steps, from sample to saved project."),
        ),
    ]
