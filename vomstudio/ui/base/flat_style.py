"""Style of the window: Fusion with flat buttons, thin splitters and a visible focus frame."""

from __future__ import annotations

from PySide6.QtCore import QRectF, Qt
from PySide6.QtGui import QColor, QIcon, QPainter, QPalette, QPen
from PySide6.QtWidgets import (
    QAbstractSpinBox,
    QComboBox,
    QProxyStyle,
    QPushButton,
    QStyle,
    QStyleOption,
    QStyleOptionComplex,
    QWidget,
)

FOCUS_WIDTH_PX = 2.0
_RADIUS_PX = 4.0
_LINE_SHARE = 0.15
"""Fraction of the text colour that is mixed into the line of a splitter."""
_FRAME_SHARE, _HOVER_SHARE, _PRESSED_SHARE = 0.28, 0.08, 0.18
"""Fractions of the text colour in the frame, hovered fill and pressed fill of a button."""

_Control, _Primitive, _State = QStyle.ControlElement, QStyle.PrimitiveElement, QStyle.StateFlag
_ComplexControl = QStyle.ComplexControl
_FRAMED_CONTROLS = (
    _ComplexControl.CC_ComboBox,
    _ComplexControl.CC_Slider,
    _ComplexControl.CC_GroupBox,
)


class FlatStyle(QProxyStyle):
    """Fusion without gradients or dotted handles, the same on every platform."""

    def __init__(self) -> None:
        super().__init__("Fusion")

    def standardIcon(  # noqa: N802 - Qt's name
        self,
        icon: QStyle.StandardPixmap,
        option: QStyleOption | None = None,
        widget: QWidget | None = None,
    ) -> QIcon:
        """Return an empty icon for dialog buttons, because Qt's are dark in both themes."""
        if icon.name.startswith("SP_Dialog"):
            return QIcon()
        return super().standardIcon(icon, option, widget)

    def drawPrimitive(  # noqa: N802 - Qt's name
        self,
        element: QStyle.PrimitiveElement,
        option: QStyleOption,
        painter: QPainter,
        widget: QWidget | None = None,
    ) -> None:
        """Draw flat buttons, the focus frame, and the handles of docks as thin lines."""
        if element == _Primitive.PE_PanelButtonCommand:
            _draw_button(option, painter, isinstance(widget, QPushButton) and widget.isDefault())
        elif element == _Primitive.PE_FrameFocusRect:
            draw_focus(painter, QRectF(option.rect), option.palette)
        elif element == _Primitive.PE_IndicatorDockWidgetResizeHandle:
            _draw_handle(option, painter)
        else:
            super().drawPrimitive(element, option, painter, widget)
            if (
                element == _Primitive.PE_PanelLineEdit
                and option.state & _State.State_HasFocus
                # The field of a box is inside the frame of the box.
                and not (widget and isinstance(widget.parent(), QAbstractSpinBox | QComboBox))
            ):
                draw_focus(painter, QRectF(option.rect), option.palette)

    def drawControl(  # noqa: N802 - Qt's name
        self,
        element: QStyle.ControlElement,
        option: QStyleOption,
        painter: QPainter,
        widget: QWidget | None = None,
    ) -> None:
        """Draw a splitter as a thin line, and a header's empty area in the button colour."""
        if element == _Control.CE_Splitter:
            _draw_handle(option, painter)
        elif element == _Control.CE_HeaderEmptyArea:
            # The window colour of a list is that of its frame, see `theme`.
            painter.fillRect(option.rect, option.palette.color(QPalette.ColorRole.Button))
        else:
            super().drawControl(element, option, painter, widget)
            if element == _Control.CE_TabBarTabLabel and _has_keyboard_focus(option):
                draw_focus(painter, QRectF(option.rect).adjusted(3, 3, -3, -3), option.palette)

    def drawComplexControl(  # noqa: N802 - Qt's name
        self,
        control: QStyle.ComplexControl,
        option: QStyleOptionComplex,
        painter: QPainter,
        widget: QWidget | None = None,
    ) -> None:
        """Draw the focus frame around boxes and sliders."""
        super().drawComplexControl(control, option, painter, widget)
        is_focused_field = (
            control == _ComplexControl.CC_SpinBox and option.state & _State.State_HasFocus
        )
        if is_focused_field or (control in _FRAMED_CONTROLS and _has_keyboard_focus(option)):
            draw_focus(painter, QRectF(option.rect), option.palette)


def _has_keyboard_focus(option: QStyleOption) -> bool:
    """Return whether a widget has the focus and the last focus change was made by a key."""
    needed_state = _State.State_HasFocus | _State.State_KeyboardFocusChange
    return option.state & needed_state == needed_state


def _draw_handle(option: QStyleOption, painter: QPainter) -> None:
    """Draw a line through the centre of a handle, parallel to its longer side."""
    rect = QRectF(option.rect)
    centre = rect.center()
    line = (
        QRectF(round(centre.x()), rect.top(), 1.0, rect.height())
        if rect.height() > rect.width()
        else QRectF(rect.left(), round(centre.y()), rect.width(), 1.0)
    )
    painter.fillRect(line, _mix(option.palette, QPalette.ColorRole.Window, _LINE_SHARE))


def _draw_button(option: QStyleOption, painter: QPainter, is_default: bool) -> None:
    """Draw a button; the frame of the default button has the highlight colour."""
    state = option.state
    highlight_share = 0.0
    if state & (_State.State_Sunken | _State.State_On):
        highlight_share = _PRESSED_SHARE
    elif state & _State.State_MouseOver and state & _State.State_Enabled:
        highlight_share = _HOVER_SHARE
    painter.save()
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setBrush(_mix(option.palette, QPalette.ColorRole.Button, highlight_share))
    frame_color = _mix(option.palette, QPalette.ColorRole.Button, _FRAME_SHARE)
    if is_default and state & _State.State_Enabled:
        frame_color = option.palette.color(QPalette.ColorRole.Highlight)
    painter.setPen(QPen(frame_color, 1.0))
    frame = QRectF(option.rect).adjusted(0.5, 0.5, -0.5, -0.5)
    painter.drawRoundedRect(frame, _RADIUS_PX, _RADIUS_PX)
    painter.restore()
    # Fusion shows the focus of a button in its panel.
    if _has_keyboard_focus(option):
        draw_focus(painter, QRectF(option.rect), option.palette)


def draw_focus(painter: QPainter, rect: QRectF, palette: QPalette) -> None:
    """Draw the frame of the widget that has the keyboard focus.

    Parameters
    ----------
    painter : QPainter
    rect : QRectF
    palette : QPalette
    """
    painter.save()
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setBrush(Qt.BrushStyle.NoBrush)
    painter.setPen(QPen(palette.color(QPalette.ColorRole.Accent), FOCUS_WIDTH_PX))
    half_width = 0.5 * FOCUS_WIDTH_PX
    painter.drawRoundedRect(
        rect.adjusted(half_width, half_width, -half_width, -half_width), _RADIUS_PX, _RADIUS_PX
    )
    painter.restore()


def _mix(palette: QPalette, role: QPalette.ColorRole, share: float) -> QColor:
    """Mix a colour of the palette with a share of the text colour."""
    background, text = palette.color(role), palette.color(QPalette.ColorRole.ButtonText)
    channels = [
        round((1.0 - share) * a + share * b)
        for a, b in zip(background.getRgb()[:3], text.getRgb()[:3], strict=True)  # type: ignore[index]
    ]
    return QColor(*channels)
