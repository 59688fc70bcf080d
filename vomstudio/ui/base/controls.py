"""Small widgets that several panels use."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Sequence
from html import escape

from PySide6.QtCore import QEvent, QLocale, QObject, QSignalBlocker, QSize, Qt, QTimer
from PySide6.QtGui import QAction, QPainter, QPaintEvent, QValidator, QWheelEvent
from PySide6.QtWidgets import (
    QAbstractSpinBox,
    QComboBox,
    QDoubleSpinBox,
    QFormLayout,
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QLayout,
    QLineEdit,
    QPushButton,
    QScrollArea,
    QSizePolicy,
    QSlider,
    QSpinBox,
    QSplitter,
    QStyle,
    QStyleOptionToolButton,
    QStylePainter,
    QTableWidget,
    QToolButton,
    QToolTip,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.ui.base.numbers import is_partial_quantity, parse_quantity

# Height of a few rows of a panel and of the arrows of the scroll bar.
_MIN_HEIGHT_PX = 100
MAX_FORM_WIDTH_PX = 560
"""Maximum width of a form on a page as wide as the window, in logical pixels."""


class Label(QLabel):
    """Label that shows text literally, without interpreting markup.

    Qt interprets text as HTML if it looks like HTML, and loads the images in it. A feature
    called `<img src="/dev/zero">` would block the window forever.
    """

    def __init__(self, text: str = "", parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setTextFormat(Qt.TextFormat.PlainText)
        if text:
            self.setText(text)


def rich_lines(lines: Sequence[str], bold: Collection[str] = ()) -> str:
    """Return HTML that shows lines of text literally, some of them in bold."""
    escaped_lines = ((escape(line), line in bold) for line in lines)
    return "<br>".join(f"<b>{line}</b>" if is_bold else line for line, is_bold in escaped_lines)


def rich_label(text: str = "") -> Label:
    """Create a label for HTML. The caller escapes texts from files and users."""
    label = Label()
    label.setTextFormat(Qt.TextFormat.RichText)
    label.setText(text)
    return label


def escape_markup(text: str) -> str:
    """Return text that Qt does not interpret as HTML, for tooltips and message boxes.

    A word joiner, which has no width, is inserted after each `<`.
    """
    return text.replace("<", "<\N{WORD JOINER}")


class ComboBox(QComboBox):
    """Combo box that ignores the wheel, so that scrolling a panel does not change it."""

    def __init__(self) -> None:
        super().__init__()
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)

    def keep_narrow(self) -> None:
        """Limit the width of the box; long entries are readable in the popup."""
        policy = QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
        self.setSizeAdjustPolicy(policy)
        self.setMinimumContentsLength(10)

    def show_text(self, text: str) -> None:
        """Show a text instead of an entry until the user selects one."""
        self.setPlaceholderText(text)
        with QSignalBlocker(self):
            self.setCurrentIndex(-1)

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802
        event.ignore()


class SpinBox(QSpinBox):
    """Integer field that ignores the wheel, like `ComboBox`, and accepts units of length."""

    def __init__(self) -> None:
        super().__init__()
        _configure_spin_box(self)

    def validate(self, text: str, position: int) -> tuple[QValidator.State, str, int]:
        return _validator_state(_parse_box_text(self, text)), text, position

    def valueFromText(self, text: str) -> int:  # noqa: N802
        number = _parse_box_text(self, text)
        return self.value() if number is None else round(number)

    def fixup(self, text: str) -> str:
        _show_limits(self, text)
        return text

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802
        event.ignore()


class DoubleSpinBox(QDoubleSpinBox):
    """Number field that ignores the wheel, like `ComboBox`, and accepts units of length.

    Attributes
    ----------
    automatic_value : float or None
        Number that the program chooses while the field is at its minimum. The arrows start from it.
        None if the program chooses no number.
    """

    def __init__(self) -> None:
        super().__init__()
        self.automatic_value: float | None = None
        _configure_spin_box(self)

    def stepBy(self, steps: int) -> None:  # noqa: N802
        if self.automatic_value is not None and self.value() == self.minimum():
            self.setValue(self.automatic_value)
        super().stepBy(steps)

    def stepEnabled(self) -> QAbstractSpinBox.StepEnabledFlag:  # noqa: N802
        if self.automatic_value is not None and self.value() == self.minimum():
            flags = QAbstractSpinBox.StepEnabledFlag
            return flags.StepUpEnabled | flags.StepDownEnabled
        return super().stepEnabled()

    def validate(self, text: str, position: int) -> tuple[QValidator.State, str, int]:
        return _validator_state(_parse_box_text(self, text)), text, position

    def valueFromText(self, text: str) -> float:  # noqa: N802
        number = _parse_box_text(self, text)
        return self.value() if number is None else number

    def fixup(self, text: str) -> str:
        _show_limits(self, text)
        return text

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802
        event.ignore()


def _configure_spin_box(box: QAbstractSpinBox) -> None:
    box.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
    # All numbers of the window have a decimal point; a comma can be typed, too.
    box.setLocale(QLocale.c())


def _validator_state(number: float | None) -> QValidator.State:
    # Qt would silently drop a rejected character: "1e3" would become 13.
    return QValidator.State.Intermediate if number is None else QValidator.State.Acceptable


def _parse_box_text(box: SpinBox | DoubleSpinBox, text: str) -> float | None:
    """Return the number in the text of a field, or None if it is invalid or out of range.

    The special text of the field results in its minimum.
    """
    special_text, format_number = box.specialValueText(), _number_text(box, text)
    if special_text and special_text in (text, format_number):
        return box.minimum()
    number = parse_quantity(format_number, box.suffix().strip())
    if number is None or (isinstance(box, SpinBox) and not number.is_integer()):
        return None
    if isinstance(box, DoubleSpinBox):
        number = round(number, box.decimals())
    return number if box.minimum() <= number <= box.maximum() else None


def _number_text(box: SpinBox | DoubleSpinBox, text: str) -> str:
    """Return the text without prefix and suffix, which Qt adds to everything that is typed."""
    return text.removeprefix(box.prefix()).removesuffix(box.suffix()).strip()


def continues_unit(box: SpinBox | DoubleSpinBox, letter: str) -> bool:
    """Return whether a letter continues the unit of the length that is being typed.

    Parameters
    ----------
    box : SpinBox or DoubleSpinBox
    letter : str

    Returns
    -------
    bool
    """
    line_edit = box.lineEdit()
    start = (
        line_edit.selectionStart() if line_edit.hasSelectedText() else line_edit.cursorPosition()
    )
    text = line_edit.text()[:start].removeprefix(box.prefix())
    return is_partial_quantity(text + letter, box.suffix().strip())


def _show_limits(box: SpinBox | DoubleSpinBox, text: str) -> None:
    """Show the accepted range below a field, because Qt restores the previous number."""
    if not box.isVisible() or not _number_text(box, text):
        return
    message = tr(
        "Enter a number from {low} to {high}.",
        low=f"{box.minimum():.10g}{box.suffix()}",
        high=f"{box.maximum():.10g}{box.suffix()}",
    )
    QToolTip.showText(box.mapToGlobal(box.rect().bottomLeft()), message, box)


class Slider(QSlider):
    """Horizontal slider that ignores the wheel, like `ComboBox`."""

    def __init__(self) -> None:
        super().__init__(Qt.Orientation.Horizontal)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802
        event.ignore()


def set_enabled(widget: QWidget, disabled_reason: Finding | None) -> None:
    """Enable a widget, or disable it and show the reason in its tooltip.

    Parameters
    ----------
    disabled_reason : Finding or None
        Reason why the widget is disabled. If None, it is enabled and its tooltip is restored.
    """
    tooltip = widget.toolTip()
    original_tooltip = (
        widget.property("own_tip") if tooltip and tooltip == widget.property("refusal") else tooltip
    )
    refusal = (
        ""
        if disabled_reason is None
        else escape_markup(tr("Not now: {reason}", reason=disabled_reason))
    )
    widget.setProperty("own_tip", original_tooltip)
    widget.setProperty("refusal", refusal)
    widget.setEnabled(disabled_reason is None)
    widget.setToolTip(refusal or original_tooltip)


def action_buttons(actions: Sequence[QAction]) -> QGridLayout:
    """Create buttons with icon and text, two per row."""
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
    """Label that elides lines that do not fit; the tooltip contains the full text."""

    def setText(self, text: str) -> None:  # noqa: N802
        super().setText(text)
        self.setToolTip(escape_markup(text))

    def minimumSizeHint(self) -> QSize:  # noqa: N802
        return QSize(40, super().minimumSizeHint().height())

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        painter = QPainter(self)
        area = self.contentsRect()
        lines = (self.shorten(line, area.width()) for line in self.text().split("\n"))
        text = "\n".join(lines)
        self.style().drawItemText(
            painter,
            area,
            int(self.alignment().value),
            self.palette(),
            self.isEnabled(),
            text,
            self.foregroundRole(),
        )

    def shorten(self, line: str, width_px: int) -> str:
        """Return the part of a line that fits in a width."""
        return self.fontMetrics().elidedText(line, Qt.TextElideMode.ElideRight, width_px)


class HintLabel(ElidedLabel):
    """Label that shows the first clauses that fit; the tooltip contains the full text."""

    def shorten(self, line: str, width_px: int) -> str:
        """Return the longest beginning of a line that fits and ends with a complete clause.

        If the first clause does not fit, the line is elided.
        """
        metrics = self.fontMetrics()
        ends = [match.start() for match in re.finditer(r"[.;,] ", line)]
        for candidate in (line, *(f"{line[:end]}." for end in reversed(ends))):
            if metrics.horizontalAdvance(candidate) <= width_px:
                return candidate
        return super().shorten(line, width_px)


class PanelScrollArea(QScrollArea):
    """Scroll area for a panel, at least as wide as the panel."""

    def __init__(self, panel: QWidget) -> None:
        super().__init__()
        self._panel = panel
        self.setWidget(panel)
        self.setWidgetResizable(True)
        self.setFrameShape(QFrame.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802
        if event.type() == QEvent.Type.LayoutRequest:
            # Qt would keep the previous width of the panel.
            self.updateGeometry()
            if watched is self._panel:
                self.update_panel_height()
        return super().eventFilter(watched, event)

    def update_panel_height(self) -> None:
        """Set the height of the panel to the height that it requires now.

        Otherwise Qt would first squeeze the panel into its previous height, and might draw it in
        this state.
        """
        super().event(QEvent(QEvent.Type.LayoutRequest))

    def minimumSizeHint(self) -> QSize:  # noqa: N802
        bar_width = self.verticalScrollBar().sizeHint().width()
        return QSize(self._panel.minimumSizeHint().width() + bar_width, _MIN_HEIGHT_PX)

    def sizeHint(self) -> QSize:  # noqa: N802
        return self._panel.sizeHint().expandedTo(self.minimumSizeHint())


class LazyScrollArea(PanelScrollArea):
    """Scroll area that creates its panel when it is first painted or requested."""

    def __init__(self, create_content: Callable[[], QWidget]) -> None:
        self._create_content, self._is_created = create_content, False
        super().__init__(_Placeholder(self._schedule_creation))

    def widget(self) -> QWidget:
        if not self._is_created:
            self._is_created = True
            self._panel = self._create_content()
            self.setWidget(self._panel)
        return self._panel

    def discard_panel(self) -> None:
        """Delete the panel, which is created again when it is next painted or requested."""
        if self._is_created:
            self._is_created = False
            # A slot of the panel may be running.
            self.takeWidget().deleteLater()
            self._panel = _Placeholder(self._schedule_creation)
            self.setWidget(self._panel)

    def _schedule_creation(self) -> None:
        # The placeholder must not be deleted while it is painted.
        QTimer.singleShot(0, self, self.widget)


class _Placeholder(QWidget):
    """Placeholder of a panel that has not been created yet.

    It covers the scroll area, which Qt therefore never paints. Only the placeholder is notified
    when it becomes visible, for example when its tab is clicked.
    """

    def __init__(self, paint_callback: Callable[[], None]) -> None:
        super().__init__()
        self._paint_callback = paint_callback

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        self._paint_callback()


def lay_out_now(widget: QWidget) -> None:
    """Lay out a widget of a scrolling panel now, so that no frame shows truncated text."""
    chain, ancestor = [widget], widget.parentWidget()
    while ancestor is not None and not isinstance(ancestor, PanelScrollArea):
        chain.append(ancestor)
        ancestor = ancestor.parentWidget()
    if ancestor is None or not ancestor.isVisible():
        return
    # The last two are the viewport of the area and the panel, whose height is set first.
    for item in chain[:-2]:
        if (layout := item.layout()) is not None:
            layout.activate()
    ancestor.update_panel_height()


class CompactTable(QTableWidget):
    """Table that prefers its minimum height, so that widgets below it stay visible."""

    def sizeHint(self) -> QSize:  # noqa: N802
        return QSize(super().sizeHint().width(), self.minimumHeight())


def create_column() -> tuple[QWidget, QVBoxLayout]:
    """Create a plain widget and its vertical layout, without margins."""
    widget = QWidget()
    column = QVBoxLayout(widget)
    column.setContentsMargins(0, 0, 0, 0)
    return widget, column


def create_row(*widgets: QWidget) -> QWidget:
    """Arrange widgets in a row without margins; text fields take the remaining width."""
    row = QWidget()
    layout = QHBoxLayout(row)
    layout.setContentsMargins(0, 0, 0, 0)
    layout.setSpacing(4)
    for widget in widgets:
        layout.addWidget(widget, 1 if isinstance(widget, QLineEdit) else 0)
    return row


def limit_width(layout: QLayout) -> QHBoxLayout:
    """Arrange a form on the left of a drawer page, at most `MAX_FORM_WIDTH_PX` wide.

    Parameters
    ----------
    layout : QLayout
        Layout of the form.

    Returns
    -------
    QHBoxLayout
    """
    form = QWidget()
    form.setLayout(layout)
    form.setMaximumWidth(MAX_FORM_WIDTH_PX)
    row = QHBoxLayout()
    row.addWidget(form, 1)
    row.addStretch()
    return row


def button_row(*buttons: QWidget) -> QHBoxLayout:
    """Arrange buttons in a row, aligned left."""
    row = QHBoxLayout()
    for button in buttons:
        row.addWidget(button)
    row.addStretch()
    return row


def icon_button(icon: str, text: str) -> QToolButton:
    """Create a button with an icon and a tooltip."""
    from vomstudio.ui.base import theme

    button = QToolButton()
    button.setIcon(theme.icon(icon))
    button.setAccessibleName(text)
    button.setToolTip(text)
    return button


class SteadyToolButton(QToolButton):
    """Tool button that keeps its width when its action changes between several texts.

    Parameters
    ----------
    texts : sequence of str
        Texts of the action, before their translation.
    """

    def __init__(self, texts: Sequence[str]) -> None:
        super().__init__()
        self._texts = texts

    def sizeHint(self) -> QSize:  # noqa: N802
        hint = super().sizeHint()
        if self.toolButtonStyle() != Qt.ToolButtonStyle.ToolButtonIconOnly:
            measure = self.fontMetrics().horizontalAdvance
            max_width = max(measure(tr(text).replace("&", "")) for text in self._texts)
            hint.setWidth(hint.width() + max(0, max_width - measure(self.text())))
        return hint

    def minimumSizeHint(self) -> QSize:  # noqa: N802
        return self.sizeHint()


class FoldButton(QToolButton):
    """Button that unfolds a part of a panel, and is never drawn as checked."""

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802 - Qt's name
        option = QStyleOptionToolButton()
        self.initStyleOption(option)
        # The arrow shows the state; a sunken frame would look like a pressed button.
        option.state &= ~QStyle.StateFlag.State_On
        QStylePainter(self).drawComplexControl(QStyle.ComplexControl.CC_ToolButton, option)


def fold_button(name: str, text: str = "") -> QToolButton:
    """Create a button that unfolds a part of a panel while checked; an arrow shows this.

    Parameters
    ----------
    name : str
        Object name.
    text : str, optional

    Returns
    -------
    QToolButton
    """
    button = FoldButton()
    button.setObjectName(name)
    button.setCheckable(True)
    button.setAutoRaise(True)
    button.setText(text)
    button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
    button.setArrowType(Qt.ArrowType.RightArrow)
    button.toggled.connect(
        lambda is_checked: button.setArrowType(
            Qt.ArrowType.DownArrow if is_checked else Qt.ArrowType.RightArrow
        )
    )
    return button


def file_field(
    name: str, button_text: str, browse: Callable[[], object]
) -> tuple[QLineEdit, QWidget]:
    """Create a field for a file path, and a row that contains it and its button.

    Parameters
    ----------
    name : str
        Object name of the field.
    button_text : str
        Text of the button.
    browse : callable
        Called when the button is clicked.
    """
    field = QLineEdit()
    field.setObjectName(name)
    button = QPushButton(button_text)
    # Enter in a field must not open the dialog.
    button.setAutoDefault(False)
    button.clicked.connect(lambda _=False: browse())
    row = QWidget()
    layout = QHBoxLayout(row)
    layout.setContentsMargins(0, 0, 0, 0)
    layout.addWidget(field, 1)
    layout.addWidget(button)
    return field, row


def add_splitter(page: QWidget, left: QWidget, right: QWidget, sizes: list[int]) -> None:
    """Fill a page with two widgets and a splitter; the right widget grows with the page."""
    splitter = QSplitter(Qt.Orientation.Horizontal)
    splitter.addWidget(left)
    splitter.addWidget(right)
    splitter.setStretchFactor(1, 1)
    splitter.setSizes(sizes)
    splitter.setChildrenCollapsible(False)
    QHBoxLayout(page).addWidget(splitter)


def narrow_form() -> QFormLayout:
    """Create a form for a dock, with little space between its rows."""
    form = QFormLayout()
    form.setContentsMargins(0, 0, 0, 0)
    form.setVerticalSpacing(3)
    return form
