"""Small widgets that several panels use."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from html import escape

from PySide6.QtCore import QEvent, QObject, QSignalBlocker, QSize, Qt, QTimer
from PySide6.QtGui import QAction, QPainter, QPaintEvent, QWheelEvent
from PySide6.QtWidgets import (
    QComboBox,
    QDoubleSpinBox,
    QFormLayout,
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QScrollArea,
    QSizePolicy,
    QSlider,
    QSpinBox,
    QSplitter,
    QTableWidget,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr

# Of what scrolls: some rows, and the arrows of the bar.
_MIN_HEIGHT = 100


class Label(QLabel):
    """Shows its text as it is. Qt takes text for HTML where it looks like some, and fetches the
    pictures that it names: a feature called `<img src="/dev/zero">` would keep the window busy
    without end."""

    def __init__(self, text: str = "", parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setTextFormat(Qt.TextFormat.PlainText)
        if text:
            self.setText(text)


def rich_lines(lines: Sequence[str], bold: Collection[str] = ()) -> str:
    """HTML that shows lines as they are, some of them bold."""
    shown = ((escape(line), line in bold) for line in lines)
    return "<br>".join(f"<b>{line}</b>" if heavy else line for line, heavy in shown)


def rich_label(text: str = "") -> Label:
    """For HTML; words in it that are not our own are escaped by whoever puts them there."""
    label = Label()
    label.setTextFormat(Qt.TextFormat.RichText)
    label.setText(text)
    return label


def escape_markup(text: str) -> str:
    """For a tooltip or message box, which decide by themselves: text in which Qt sees no HTML. A
    mark without width stands behind each `<`."""
    return text.replace("<", "<\N{WORD JOINER}")


class ComboBox(QComboBox):
    """A list to choose from that ignores the wheel: scrolling a panel must not change a value."""

    def __init__(self) -> None:
        super().__init__()
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)

    def keep_narrow(self) -> None:
        """Long entries are read in the popup: they must not widen the panel."""
        policy = QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
        self.setSizeAdjustPolicy(policy)
        self.setMinimumContentsLength(10)

    def show_text(self, text: str) -> None:
        """Show a text in place of a choice, until something is chosen."""
        self.setPlaceholderText(text)
        with QSignalBlocker(self):
            self.setCurrentIndex(-1)

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802
        event.ignore()


class SpinBox(QSpinBox):
    """A whole number that ignores the wheel, as lists do."""

    def __init__(self) -> None:
        super().__init__()
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802
        event.ignore()


class DoubleSpinBox(QDoubleSpinBox):
    """A number that ignores the wheel, as lists do."""

    def __init__(self) -> None:
        super().__init__()
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802
        event.ignore()


class Slider(QSlider):
    """Lies flat, and ignores the wheel, as lists do."""

    def __init__(self) -> None:
        super().__init__(Qt.Orientation.Horizontal)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802
        event.ignore()


def allow(widget: QWidget, why_not: Finding | None) -> None:
    """Enable a widget, or disable it and have its tooltip say why; then its own one comes back.
    why_not : None where it can be used now, else the reason"""
    now = widget.toolTip()
    own = widget.property("own_tip") if now and now == widget.property("refusal") else now
    refusal = "" if why_not is None else escape_markup(tr("Not now: {reason}", reason=why_not))
    widget.setProperty("own_tip", own)
    widget.setProperty("refusal", refusal)
    widget.setEnabled(why_not is None)
    widget.setToolTip(refusal or own)


def action_buttons(actions: Sequence[QAction]) -> QGridLayout:
    """Two buttons in a row, each with its icon and text."""
    grid = QGridLayout()
    grid.setSpacing(4)
    for i, action in enumerate(actions):
        button = QToolButton()
        button.setDefaultAction(action)
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        grid.addWidget(button, i // 2, i % 2)
    return grid


class ElidedLabel(Label):
    """A label that may be narrower than its lines, which then end in dots; the tooltip has all of
    them."""

    def setText(self, text: str) -> None:  # noqa: N802
        super().setText(text)
        self.setToolTip(escape_markup(text))

    def minimumSizeHint(self) -> QSize:  # noqa: N802
        return QSize(40, super().minimumSizeHint().height())

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        painter = QPainter(self)
        room = self.contentsRect()
        metrics, elide = self.fontMetrics(), Qt.TextElideMode.ElideRight
        lines = (metrics.elidedText(x, elide, room.width()) for x in self.text().split("\n"))
        text = "\n".join(lines)
        self.style().drawItemText(
            painter,
            room,
            int(self.alignment().value),
            self.palette(),
            self.isEnabled(),
            text,
            self.foregroundRole(),
        )


class PanelScrollArea(QScrollArea):
    """Shows a panel that may be higher than its place, and has the width that the panel needs."""

    def __init__(self, panel: QWidget) -> None:
        super().__init__()
        self._panel = panel
        self.setWidget(panel)
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        if event.type() == QEvent.Type.LayoutRequest:
            # Qt leaves the place as narrow as the panel was before.
            self.updateGeometry()
            if watched is self._panel:
                self.update_panel_height()
        return super().eventFilter(watched, event)

    def update_panel_height(self) -> None:
        """Give the panel the height that it needs now. Qt does so only after it has squeezed the
        panel into the height that it had, and a frame of that may be drawn."""
        super().event(QEvent(QEvent.Type.LayoutRequest))

    def minimumSizeHint(self) -> QSize:  # noqa: N802
        bar = self.verticalScrollBar().sizeHint().width()
        return QSize(self._panel.minimumSizeHint().width() + bar, _MIN_HEIGHT)

    def sizeHint(self) -> QSize:  # noqa: N802
        return self._panel.sizeHint().expandedTo(self.minimumSizeHint())


class LazyScrollArea(PanelScrollArea):
    """Makes its panel when its place is first painted, or asked for."""

    def __init__(self, make: Callable[[], QWidget]) -> None:
        self._make: Callable[[], QWidget] | None = make
        super().__init__(_Placeholder(self._seen))

    def widget(self) -> QWidget:
        if self._make is not None:
            make, self._make = self._make, None
            self._panel = make()
            self.setWidget(self._panel)
        return self._panel

    def _seen(self) -> None:
        # What is being painted must not go away meanwhile.
        QTimer.singleShot(0, self, self.widget)


class _Placeholder(QWidget):
    """Stands where a panel will be. It covers what it stands on, which Qt then never paints: only
    this one knows that it is seen, as when its tab is clicked."""

    def __init__(self, seen: Callable[[], None]) -> None:
        super().__init__()
        self._seen = seen

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        self._seen()


def lay_out_now(widget: QWidget) -> None:
    """A widget within a scrolling panel has other words now: no frame is drawn in which they are
    cut."""
    inside, place = [widget], widget.parentWidget()
    while place is not None and not isinstance(place, PanelScrollArea):
        inside.append(place)
        place = place.parentWidget()
    if place is None or not place.isVisible():
        return
    # The last two are the panel, which gets its height first, and what it is seen through.
    for each in inside[:-2]:
        if (layout := each.layout()) is not None:
            layout.activate()
    place.update_panel_height()


class CompactTable(QTableWidget):
    """It asks for its least height and takes what is left: what stands below it in a low dock stays
    in sight."""

    def sizeHint(self) -> QSize:  # noqa: N802
        return QSize(super().sizeHint().width(), self.minimumHeight())


def create_column() -> tuple[QWidget, QVBoxLayout]:
    """A plain widget and its column of widgets, without margins."""
    widget = QWidget()
    column = QVBoxLayout(widget)
    column.setContentsMargins(0, 0, 0, 0)
    return widget, column


def create_row(*widgets: QWidget) -> QWidget:
    """Arrange widgets in a row without margins; text fields take the remaining width."""
    row = QWidget()
    line = QHBoxLayout(row)
    line.setContentsMargins(0, 0, 0, 0)
    line.setSpacing(4)
    for widget in widgets:
        line.addWidget(widget, 1 if isinstance(widget, QLineEdit) else 0)
    return row


def button_row(*buttons: QWidget) -> QHBoxLayout:
    """Arrange buttons in a row, aligned left."""
    row = QHBoxLayout()
    for button in buttons:
        row.addWidget(button)
    row.addStretch()
    return row


def icon_button(icon: str, text: str) -> QToolButton:
    """Create a button with an icon, whose text is its tooltip."""
    from vomstudio.ui.base import theme

    button = QToolButton()
    button.setIcon(theme.icon(icon))
    button.setAccessibleName(text)
    button.setToolTip(text)
    return button


def file_field(name: str, choose: str, browse: Callable[[], object]) -> tuple[QLineEdit, QWidget]:
    """A field for a file's path, and the row that holds it with a button beside it.

    name: object name of the field; choose: text of the button; browse: called by the button
    """
    field = QLineEdit()
    field.setObjectName(name)
    button = QPushButton(choose)
    # Enter in a field is no wish to look for a file.
    button.setAutoDefault(False)
    button.clicked.connect(lambda _=False: browse())
    row = QWidget()
    line = QHBoxLayout(row)
    line.setContentsMargins(0, 0, 0, 0)
    line.addWidget(field, 1)
    line.addWidget(button)
    return field, row


def add_splitter(page: QWidget, left: QWidget, right: QWidget, sizes: list[int]) -> None:
    """Fill a page with two widgets whose border can be dragged; the right one grows with it."""
    split = QSplitter(Qt.Orientation.Horizontal)
    split.addWidget(left)
    split.addWidget(right)
    split.setStretchFactor(1, 1)
    split.setSizes(sizes)
    split.setChildrenCollapsible(False)
    QHBoxLayout(page).addWidget(split)


def narrow_form() -> QFormLayout:
    """A form for a dock, with little space between its rows."""
    form = QFormLayout()
    form.setContentsMargins(0, 0, 0, 0)
    form.setVerticalSpacing(3)
    return form
