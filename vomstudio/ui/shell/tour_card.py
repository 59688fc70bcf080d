"""Card of the introductory tour, and the frame around its target."""

from __future__ import annotations

from PySide6.QtCore import QPoint, QRect, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QPainter, QPaintEvent, QPalette, QPen
from PySide6.QtWidgets import QFrame, QHBoxLayout, QPushButton, QVBoxLayout, QWidget

from vomstudio.core.words import tr
from vomstudio.ui.base.controls import Label

WIDTH = 264
_GAP_PX = 12
_FRAME_MARGIN_PX = 4


class TourFrame(QWidget):
    """Frame around a widget; mouse events pass through the frame."""

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.setObjectName("tour_frame")
        self.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        box = QRectF(self.rect()).adjusted(2.0, 2.0, -2.0, -2.0)
        # A dark line below makes the frame visible on a bright outcrop.
        for color, width in (
            (self.palette().color(QPalette.ColorRole.Shadow), 4.0),
            (self.palette().color(QPalette.ColorRole.Highlight), 2.4),
        ):
            painter.setPen(QPen(color, width))
            painter.drawRoundedRect(box, 5.0, 5.0)


class TourCard(QFrame):
    """Card with the instructions of the current step. It never takes the focus by itself.

    `next_requested` is emitted when the user skips or confirms the step, and `ended` when the user
    ends the tour.
    """

    next_requested = Signal()
    ended = Signal()

    def __init__(self, window: QWidget) -> None:
        super().__init__(window)
        self.setObjectName("tour_card")
        self.setFrameShape(QFrame.Shape.StyledPanel)
        self.setAutoFillBackground(True)
        self.setBackgroundRole(QPalette.ColorRole.ToolTipBase)
        self.setForegroundRole(QPalette.ColorRole.ToolTipText)
        self.setFixedWidth(WIDTH)
        self._count, self._text = Label(), Label()
        font = self._count.font()
        font.setBold(True)
        self._count.setFont(font)
        self._text.setWordWrap(True)
        for label in (self._count, self._text):
            label.setForegroundRole(QPalette.ColorRole.ToolTipText)
        self.next_button, self.end = QPushButton(tr("Skip")), QPushButton(tr("End tour"))
        self.next_button.clicked.connect(self.next_requested)
        self.end.clicked.connect(self.ended)
        row = QHBoxLayout()
        for button in (self.next_button, self.end):
            # A click on the card must not take the focus from the outcrop.
            button.setFocusPolicy(Qt.FocusPolicy.TabFocus)
            button.setAutoDefault(False)
        row.addWidget(self.end)
        row.addStretch(1)
        row.addWidget(self.next_button)
        self._layout = QVBoxLayout(self)
        self._layout.addWidget(self._count)
        self._layout.addWidget(self._text)
        self._layout.addLayout(row)

    def show_text(self, count: str, text: str, button_text: str) -> None:
        """Show a step: its number (`count`, as in "Step 2 of 9"), text and button text."""
        self._count.setText(count)
        self._text.setText(text)
        self.next_button.setText(button_text)
        self.end.setVisible(button_text != tr("Close"))
        self.setFixedHeight(self._layout.totalHeightForWidth(WIDTH))

    @property
    def text(self) -> str:
        """Text of the card."""
        return self._text.text()


def frame_box(target: QRect, window: QSize) -> QRect:
    """Return the frame around a target, limited to the window."""
    width = target.adjusted(
        -_FRAME_MARGIN_PX, -_FRAME_MARGIN_PX, _FRAME_MARGIN_PX, _FRAME_MARGIN_PX
    )
    return width.intersected(QRect(QPoint(0, 0), window))


def place_card(
    target: QRect | None, card_size: QSize, window_size: QSize, avoided_box: QRect | None = None
) -> QPoint:
    """Return the position of the card in the window.

    The card is completely visible beside the target, and covers it only if it does not fit
    elsewhere. Without a target, it is centred.

    Parameters
    ----------
    target : QRect or None
    card_size, window_size : QSize
    avoided_box : QRect, optional
        Rectangle that the card covers only if it does not fit elsewhere.
    """
    max_x, max_y = (
        window_size.width() - card_size.width() - _GAP_PX,
        window_size.height() - card_size.height() - _GAP_PX,
    )
    if target is None or (avoided_box is not None and target.contains(avoided_box)):
        # A target that is nearly the whole window, such as the outcrop, may be covered.
        centre = [QPoint(max_x // 2, max_y // 2)] if target is None else []
        corners = [QPoint(x, y) for y in (max_y, _GAP_PX) for x in (max_x // 2, _GAP_PX, max_x)]
        free_positions = [
            location
            for location in (*centre, *corners)
            if avoided_box is None or not QRect(location, card_size).intersects(avoided_box)
        ]
        if free_positions or target is None:
            location = (free_positions or centre)[0]
            return QPoint(max(0, location.x()), max(0, location.y()))
    columns = target.right() + _GAP_PX, target.left() - card_size.width() - _GAP_PX
    rows = target.bottom() + _GAP_PX, target.top() - card_size.height() - _GAP_PX
    positions = [
        *(QPoint(x, target.top()) for x in columns),
        *(QPoint(target.left(), y) for y in rows),
        *(QPoint(x, target.bottom() - card_size.height()) for x in columns),
    ]
    candidates: list[tuple[bool, int, QPoint]] = []
    for location in positions:
        position = QPoint(max(0, min(location.x(), max_x)), max(0, min(location.y(), max_y)))
        if not QRect(position, card_size).intersects(target):
            covers = avoided_box is not None and QRect(position, card_size).intersects(avoided_box)
            candidates.append((covers, (position - location).manhattanLength(), position))
    if candidates:
        return min(candidates, key=lambda one: one[:2])[2]
    return QPoint(max(0, max_x), max(0, max_y))
