"""Settings of the mask tools, and buttons for whole masks."""

from __future__ import annotations

from collections.abc import Mapping
from math import log

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QButtonGroup,
    QGridLayout,
    QGroupBox,
    QHBoxLayout,
    QToolButton,
    QVBoxLayout,
)

from vomstudio.core.words import tr
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import Label, Slider
from vomstudio.ui.panels.photos.mark_canvas import MarkCanvas

_SLIDER_STEPS = 100
_MIN_RADIUS_PX, _MAX_RADIUS_PX = 2.0, 600.0


class MaskBox(QGroupBox):
    """Box with the masked fraction, the drawing mode and the brush radius."""

    def __init__(self, canvas: MarkCanvas) -> None:
        super().__init__(tr("Mask"))
        self._canvas = canvas
        self.status_label = Label()
        self.status_label.setObjectName("mask_words")
        self.status_label.setWordWrap(True)
        self.hide_button, self.keep_button = QToolButton(), QToolButton()
        group = QButtonGroup(self)
        row = QHBoxLayout()
        for button, text, icon, tooltip in (
            (
                self.hide_button,
                tr("Mask"),
                "eye-off-outline",
                tr("Draw masks over sky, vegetation, people or shadows (X)."),
            ),
            (self.keep_button, tr("Unmask"), "eraser", tr("Draw to erase the mask (X).")),
        ):
            button.setText(text)
            button.setIcon(theme.icon(icon))
            button.setToolTip(tooltip)
            button.setCheckable(True)
            theme.highlight_toggles(button)
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
            group.addButton(button)
            row.addWidget(button)
        row.addStretch(1)
        self.hide_button.setChecked(True)
        self.hide_button.toggled.connect(self._set_masking)
        self.brush_size = Slider()
        self.brush_size.setObjectName("brush_size")
        self.brush_size.setRange(0, _SLIDER_STEPS)
        self.brush_size.setToolTip(tr("Brush radius in photo pixels ([ and ], or Ctrl+wheel)."))
        self.brush_size.valueChanged.connect(self._change_brush_size)
        self._size_label = Label()
        self._size_label.setMinimumWidth(self.fontMetrics().horizontalAdvance("0000 px"))
        self._size_label.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        brush = QHBoxLayout()
        brush.addWidget(Label(tr("Brush")))
        brush.addWidget(self.brush_size, 1)
        brush.addWidget(self._size_label)
        grid = QGridLayout()
        grid.setSpacing(4)
        self._buttons: dict[str, QToolButton] = {}
        for number, name in enumerate(("repeat_mask", "invert_mask", "clear_mask")):
            button = self._buttons[name] = QToolButton()
            button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
            grid.addWidget(
                button, 0 if number == 0 else 1, max(number - 1, 0), 1, 2 if number == 0 else 1
            )
        grid.setColumnStretch(2, 1)
        layout = QVBoxLayout(self)
        layout.setSpacing(6)
        layout.addWidget(self.status_label)
        layout.addLayout(row)
        layout.addLayout(brush)
        layout.addLayout(grid)
        canvas.brush_scaled.connect(lambda factor: self.set_radius(canvas.radius * factor))
        self.set_radius(canvas.radius)

    def set_actions(self, actions: Mapping[str, QAction]) -> None:
        """Assign actions to the buttons by name."""
        for name, button in self._buttons.items():
            button.setDefaultAction(actions[name])

    def set_radius(self, radius: float) -> None:
        """Set the brush radius in pixels of the photo."""
        self._canvas.radius = min(max(radius, _MIN_RADIUS_PX), _MAX_RADIUS_PX)
        with QSignalBlocker(self.brush_size):
            # The scale of the slider is logarithmic.
            slider_position = log(self._canvas.radius / _MIN_RADIUS_PX) / log(
                _MAX_RADIUS_PX / _MIN_RADIUS_PX
            )
            self.brush_size.setValue(round(_SLIDER_STEPS * slider_position))
        self._size_label.setText(tr("{radius:.0f} px", radius=self._canvas.radius))
        self._canvas.update()

    def _change_brush_size(self, step: int) -> None:
        self._canvas.radius = _MIN_RADIUS_PX * (_MAX_RADIUS_PX / _MIN_RADIUS_PX) ** (
            step / _SLIDER_STEPS
        )
        self._size_label.setText(tr("{radius:.0f} px", radius=self._canvas.radius))
        self._canvas.update()

    def toggle_masking(self) -> None:
        """Switch between masking and unmasking."""
        (self.keep_button if self._canvas.is_masking else self.hide_button).setChecked(True)

    def _set_masking(self, is_masking: bool) -> None:
        self._canvas.is_masking = is_masking
        self._canvas.update()
