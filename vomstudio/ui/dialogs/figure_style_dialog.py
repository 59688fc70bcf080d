"""The dialog in which the style of printed nets and roses is chosen, with what comes of it."""

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

_USUAL = {
    "width_mm": SIZE_MM[0],
    "height_mm": SIZE_MM[1],
    "font_pt": PRINT.font_pt,
    "symbol_pt": PRINT.marker_pt,
    "line_pt": PRINT.line_pt,
}
_NUMBERS = (
    ("width_mm", to_translate("Width"), " mm", 1.0),
    ("height_mm", to_translate("Height of a net"), " mm", 1.0),
    ("font_pt", to_translate("Letters"), " pt", 0.5),
    ("symbol_pt", to_translate("Symbols"), " pt", 0.5),
    ("line_pt", to_translate("Lines"), " pt", 0.1),
)
_PREVIEW = QSize(420, 300)
_MOST_SHOWN = 2_000
"""More orientations take too long to be drawn at every change."""
_MOST_COLORS = 8


class FigureStyleDialog(QDialog):
    """What is chosen holds at once, and for all figures from now on."""

    def __init__(self, parent: QWidget, studio: Studio, panel: NetDock) -> None:
        super().__init__(parent)
        explain(self, "numbers.md#the-net")
        self._studio, self._panel = studio, panel
        self.setWindowTitle(tr("Style of figures"))
        self.numbers: dict[str, QDoubleSpinBox] = {}
        form = QFormLayout()
        for name, title, unit, step in _NUMBERS:
            box = DoubleSpinBox()
            box.setObjectName(f"figure_{name}")
            box.setDecimals(1)
            box.setRange(*LIMITS[name])
            box.setSingleStep(step)
            box.setSuffix(unit)
            box.setKeyboardTracking(False)
            box.valueChanged.connect(lambda _: self._changed())
            form.addRow(tr(title), box)
            self.numbers[name] = box
        self.font_box = ComboBox()
        self.font_box.setObjectName("figure_font")
        self.font_box.addItem(tr("usual"), "")
        for name in fonts():
            self.font_box.addItem(name, name)
        self.font_box.keep_narrow()
        self.font_box.activated.connect(lambda _: self._changed())
        form.addRow(tr("Font"), self.font_box)
        self.grey = QCheckBox(tr("Without colours"))
        self.grey.toggled.connect(lambda _: self._changed())
        form.addRow("", self.grey)
        self.colors: dict[str, QPushButton] = {}
        form.addRow(tr("Colours"), self._color_buttons())
        self.preview = Label()
        self.preview.setMinimumSize(_PREVIEW)
        self.preview.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.preview.setAccessibleName(tr("Preview"))
        buttons = QDialogButtonBox()
        close = buttons.addButton(QDialogButtonBox.StandardButton.Close)
        self.usual = buttons.addButton(tr("As usual"), QDialogButtonBox.ButtonRole.ResetRole)
        self.usual.clicked.connect(self._reset)
        buttons.rejected.connect(self.reject)
        sides = QHBoxLayout()
        sides.addLayout(form)
        sides.addWidget(self.preview, 1)
        column = QVBoxLayout(self)
        column.addLayout(sides)
        column.addWidget(buttons)
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(150)
        self._timer.timeout.connect(self._draw)
        # Enter ends the typing of a number, and nothing else.
        for button in (self.usual, close, *self.colors.values()):
            button.setAutoDefault(False)
        self._show(load_figure_style(studio))
        self._timer.start()

    def _color_buttons(self) -> QWidget:
        """One for each colour that the net has now."""
        row = QWidget()
        line = QHBoxLayout(row)
        line.setContentsMargins(0, 0, 0, 0)
        line.setSpacing(2)
        shown = self._panel.contents()
        for s in shown.sets:
            if s.color in self.colors or len(self.colors) >= _MOST_COLORS:
                continue
            button = QPushButton()
            button.setFixedWidth(28)
            button.setToolTip(tr("Colour of {set} in figures", set=s.name))
            button.setAccessibleName(button.toolTip())
            button.clicked.connect(partial(self._choose_color, s.color))
            line.addWidget(button)
            self.colors[s.color] = button
        if not self.colors:
            line.addWidget(Label(tr("There is nothing on the net.")))
        line.addStretch(1)
        return row

    def _choose_color(self, color: str) -> None:
        style = load_figure_style(self._studio)
        now = QColor(style.colors.get(color, color))
        chosen = QColorDialog.getColor(now, self, tr("Colour in figures"))
        if chosen.isValid():
            self.recolor(color, chosen.name())

    def recolor(self, color: str, other: str) -> None:
        """Draw what has this colour in another one."""
        style = load_figure_style(self._studio)
        kept = {k: v for k, v in style.colors.items() if k != color}
        if other.casefold() != color.casefold():
            kept[color] = other
        self._keep(replace(style, colors=kept))

    def _changed(self) -> None:
        values = {
            name: None if abs(box.value() - _USUAL[name]) < 0.05 else round(box.value(), 1)
            for name, box in self.numbers.items()
        }
        self._keep(
            replace(
                load_figure_style(self._studio),
                **values,  # type: ignore[arg-type]
                font=str(self.font_box.currentData()),
                grey=self.grey.isChecked(),
            )
        )

    def _reset(self) -> None:
        self._keep(FigureStyle())

    def _keep(self, style: FigureStyle) -> None:
        self._studio.settings.figure_style = style.to_keep()
        self._studio.keep_settings()
        self._show(style)
        self._timer.start()

    def _show(self, style: FigureStyle) -> None:
        for name, box in self.numbers.items():
            value = getattr(style, name)
            with QSignalBlocker(box):
                box.setValue(_USUAL[name] if value is None else value)
        with QSignalBlocker(self.grey):
            self.grey.setChecked(style.grey)
        self.font_box.setCurrentIndex(max(self.font_box.findData(style.font), 0))
        for color, button in self.colors.items():
            swatch = QPixmap(16, 16)
            swatch.fill(QColor(style.colors.get(color, color)))
            button.setIcon(QIcon(swatch))

    def _draw(self) -> None:
        """The figure as it is now."""
        shown = self._panel.print_contents()
        if isinstance(shown, NetContents) and sum(map(len, shown.sets)) > _MOST_SHOWN:
            self.preview.setText(Finding("net.no-preview", maximum=_MOST_SHOWN).message)
            return
        data = io.BytesIO()
        try:
            write_net_figure(data, shown, load_figure_style(self._studio), "png", dpi=100.0)
        except VomError as error:
            self.preview.setText(error.message)
            return
        picture = QPixmap()
        picture.loadFromData(data.getvalue())
        self.preview.setPixmap(
            picture.scaled(
                self.preview.size().expandedTo(_PREVIEW),
                Qt.AspectRatioMode.KeepAspectRatio,
                Qt.TransformationMode.SmoothTransformation,
            )
        )
