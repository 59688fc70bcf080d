"""Dialog for the style of printed nets and roses, with a preview."""

from __future__ import annotations

import io
from dataclasses import replace
from functools import partial

from PySide6.QtCore import QSignalBlocker, QSize, Qt, QTimer
from PySide6.QtGui import QColor, QIcon, QPixmap
from PySide6.QtWidgets import (
    QCheckBox,
    QColorDialog,
    QDialog,
    QDialogButtonBox,
    QDoubleSpinBox,
    QFormLayout,
    QHBoxLayout,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.products.net.contents import NetContents
from vomstudio.products.net.figure_options import LIMITS, SIZE_MM
from vomstudio.products.net.figure_style import FigureStyle, fonts
from vomstudio.products.net.style import PRINT
from vomstudio.ui.base.controls import ComboBox, DoubleSpinBox, Label
from vomstudio.ui.base.help_links import explain
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.net.figure_export import NetDock, load_figure_style, write_net_figure

_DEFAULT_SIZES = {
    "width_mm": SIZE_MM[0],
    "height_mm": SIZE_MM[1],
    "font_pt": PRINT.font_pt,
    "symbol_pt": PRINT.marker_pt,
    "line_pt": PRINT.line_pt,
}
_SIZES = (
    ("width_mm", to_translate("Width"), " mm", 1.0),
    ("height_mm", to_translate("Net height"), " mm", 1.0),
    ("font_pt", to_translate("Font size"), " pt", 0.5),
    ("symbol_pt", to_translate("Symbols"), " pt", 0.5),
    ("line_pt", to_translate("Lines"), " pt", 0.1),
)
_PREVIEW_SIZE = QSize(420, 300)
_MAX_PREVIEW_ORIENTATIONS = 2_000
"""Maximum number of orientations in the preview, which is redrawn at every change."""
_MAX_COLORS = 8


class FigureStyleDialog(QDialog):
    """Editor of the figure style. Changes apply immediately to all future figures."""

    def __init__(self, parent: QWidget, studio: Studio, panel: NetDock) -> None:
        super().__init__(parent)
        explain(self, "numbers.md#the-net")
        self._studio, self._panel = studio, panel
        self.setWindowTitle(tr("Figure style"))
        self.numbers: dict[str, QDoubleSpinBox] = {}
        form = QFormLayout()
        for name, title, unit, step in _SIZES:
            box = DoubleSpinBox()
            box.setObjectName(f"figure_{name}")
            box.setDecimals(1)
            box.setRange(*LIMITS[name])
            box.setSingleStep(step)
            box.setSuffix(unit)
            box.setKeyboardTracking(False)
            box.valueChanged.connect(lambda _: self._apply())
            form.addRow(tr(title), box)
            self.numbers[name] = box
        self.font_box = ComboBox()
        self.font_box.setObjectName("figure_font")
        self.font_box.addItem(tr("default"), "")
        for name in fonts():
            self.font_box.addItem(name, name)
        self.font_box.keep_narrow()
        self.font_box.activated.connect(lambda _: self._apply())
        form.addRow(tr("Font"), self.font_box)
        self.grey_box = QCheckBox(tr("Without colours"))
        self.grey_box.toggled.connect(lambda _: self._apply())
        form.addRow("", self.grey_box)
        self.colors: dict[str, QPushButton] = {}
        form.addRow(tr("Colours"), self._color_buttons())
        self.preview = Label()
        self.preview.setMinimumSize(_PREVIEW_SIZE)
        self.preview.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.preview.setAccessibleName(tr("Preview"))
        buttons = QDialogButtonBox()
        close_button = buttons.addButton(QDialogButtonBox.StandardButton.Close)
        self.reset_button = buttons.addButton(tr("Defaults"), QDialogButtonBox.ButtonRole.ResetRole)
        self.reset_button.clicked.connect(self._reset)
        buttons.rejected.connect(self.reject)
        columns = QHBoxLayout()
        columns.addLayout(form)
        columns.addWidget(self.preview, 1)
        layout = QVBoxLayout(self)
        layout.addLayout(columns)
        layout.addWidget(buttons)
        self._timer = QTimer(self, singleShot=True, interval=150)
        self._timer.timeout.connect(self._draw_preview)
        # Enter in a number field must not press a button.
        for button in (self.reset_button, close_button, *self.colors.values()):
            button.setAutoDefault(False)
        self._show_style(load_figure_style(studio))
        self._timer.start()

    def _color_buttons(self) -> QWidget:
        """Create a button for each colour on the net."""
        row = QWidget()
        layout = QHBoxLayout(row)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(2)
        net_contents = self._panel.contents()
        for orientation_set in net_contents.sets:
            if orientation_set.color in self.colors or len(self.colors) >= _MAX_COLORS:
                continue
            button = QPushButton()
            button.setFixedWidth(28)
            button.setToolTip(tr("Colour of {set} in figures", set=orientation_set.name))
            button.setAccessibleName(button.toolTip())
            button.clicked.connect(partial(self._choose_color, orientation_set.color))
            layout.addWidget(button)
            self.colors[orientation_set.color] = button
        if not self.colors:
            layout.addWidget(Label(tr("The net is empty.")))
        layout.addStretch(1)
        return row

    def _choose_color(self, color: str) -> None:
        style = load_figure_style(self._studio)
        current = QColor(style.colors.get(color, color))
        selection = QColorDialog.getColor(current, self, tr("Colour in figures"))
        if selection.isValid():
            self.recolor(color, selection.name())

    def recolor(self, color: str, new_color: str) -> None:
        """Replace one colour by another for all elements of the net."""
        style = load_figure_style(self._studio)
        colors = {k: v for k, v in style.colors.items() if k != color}
        if new_color.casefold() != color.casefold():
            colors[color] = new_color
        self._save(replace(style, colors=colors))

    def _apply(self) -> None:
        values = {
            name: None if abs(box.value() - _DEFAULT_SIZES[name]) < 0.05 else round(box.value(), 1)
            for name, box in self.numbers.items()
        }
        self._save(
            replace(
                load_figure_style(self._studio),
                **values,  # type: ignore[arg-type]
                font=str(self.font_box.currentData()),
                grey=self.grey_box.isChecked(),
            )
        )

    def _reset(self) -> None:
        self._save(FigureStyle())

    def _save(self, style: FigureStyle) -> None:
        self._studio.settings.figure_style = style.to_keep()
        self._studio.keep_settings()
        self._show_style(style)
        self._timer.start()

    def _show_style(self, style: FigureStyle) -> None:
        for name, box in self.numbers.items():
            value = getattr(style, name)
            with QSignalBlocker(box):
                box.setValue(_DEFAULT_SIZES[name] if value is None else value)
        with QSignalBlocker(self.grey_box):
            self.grey_box.setChecked(style.grey)
        self.font_box.setCurrentIndex(max(self.font_box.findData(style.font), 0))
        for color, button in self.colors.items():
            swatch = QPixmap(16, 16)
            swatch.fill(QColor(style.colors.get(color, color)))
            button.setIcon(QIcon(swatch))

    def _draw_preview(self) -> None:
        net_contents = self._panel.print_contents()
        if (
            isinstance(net_contents, NetContents)
            and sum(map(len, net_contents.sets)) > _MAX_PREVIEW_ORIENTATIONS
        ):
            self.preview.setText(
                Finding("net.no-preview", maximum=_MAX_PREVIEW_ORIENTATIONS).message
            )
            return
        data = io.BytesIO()
        try:
            write_net_figure(data, net_contents, load_figure_style(self._studio), "png", dpi=100.0)
        except VomError as error:
            self.preview.setText(error.message)
            return
        pixmap = QPixmap()
        pixmap.loadFromData(data.getvalue())
        self.preview.setPixmap(
            pixmap.scaled(
                self.preview.size().expandedTo(_PREVIEW_SIZE),
                Qt.AspectRatioMode.KeepAspectRatio,
                Qt.TransformationMode.SmoothTransformation,
            )
        )
