"""Dialog for the style of printed nets and roses, with a preview."""

from __future__ import annotations

import io
from dataclasses import replace
from functools import partial

from PySide6.QtCore import QSignalBlocker, QSize, Qt, QTimer
from PySide6.QtGui import QColor, QIcon, QPixmap
from PySide6.QtWidgets import (
    QColorDialog,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QHBoxLayout,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.errors import UsageError, VomError
from vomstudio.core.findings import Finding
from vomstudio.core.options import find_declaration
from vomstudio.core.words import tr
from vomstudio.products.net.contents import NetContents
from vomstudio.products.net.figure_options import StereonetFigure
from vomstudio.products.net.figure_style import FigureStyle, fonts
from vomstudio.products.net.style import PRINT
from vomstudio.ui.base.controls import ComboBox, Label
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.net.figure_export import NetDock, load_figure_style, write_net_figure
from vomstudio.ui.widgets.options_form import OptionFields, fill_choices

_DEFAULT_SIZES_PT = {
    "font_size_pt": PRINT.font_pt,
    "symbol_size_pt": PRINT.marker_pt,
    "line_width_pt": PRINT.line_pt,
}
_PREVIEW_SIZE = QSize(420, 300)
_MAX_PREVIEW_ORIENTATIONS = 2_000
"""Maximum number of orientations in the preview, which is redrawn at every change."""
_MAX_COLORS = 8


class FigureStyleDialog(QDialog):
    """Editor of the figure style. Changes apply immediately to all future figures."""

    def __init__(self, parent: QWidget, studio: Studio, panel: NetDock) -> None:
        super().__init__(parent)
        set_help_topic(self, "numbers.md#the-net")
        self._studio, self._panel = studio, panel
        self.setWindowTitle(tr("Figure style"))
        self.options = OptionFields(StereonetFigure, "figure")
        font_box = self.options.fields["font"]
        assert isinstance(font_box, ComboBox)
        other_fonts = [(name, name) for name in fonts() if font_box.findData(name) < 0]
        fill_choices(font_box, find_declaration(StereonetFigure, "font"), other_fonts)
        for name, size_pt in _DEFAULT_SIZES_PT.items():
            self.options.show_automatic(name, size_pt)
        self.options.changed.connect(self._apply)
        form = QFormLayout()
        self.options.add_rows(form)
        self.colors: dict[str, QPushButton] = {}
        form.addRow(tr("Colours"), self._create_color_buttons())
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

    def _create_color_buttons(self) -> QWidget:
        """Create a button for each colour on the net, but at most `_MAX_COLORS` buttons."""
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
        current_color = QColor(style.colors.get(color, color))
        selection = QColorDialog.getColor(current_color, self, tr("Colour in figures"))
        if selection.isValid():
            self.recolor(color, selection.name())

    def recolor(self, color: str, new_color: str) -> None:
        """Replace one colour of the net by another in all figures."""
        style = load_figure_style(self._studio)
        colors = {k: v for k, v in style.colors.items() if k != color}
        if new_color.casefold() != color.casefold():
            colors[color] = new_color
        self._save(replace(style, colors=colors))

    def _apply(self) -> None:
        try:
            style = FigureStyle.from_options(self.options.options())
        except UsageError as error:
            # The size of the figure is still being typed.
            self._timer.stop()
            self.preview.setText(error.message)
            return
        self._save(replace(style, colors=load_figure_style(self._studio).colors))

    def _reset(self) -> None:
        self._save(FigureStyle())
        self._show_style(FigureStyle())

    def _save(self, style: FigureStyle) -> None:
        self._studio.settings.figure_style = style.to_settings()
        self._studio.keep_settings()
        self._show_colors(style)
        self._timer.start()

    def _show_style(self, style: FigureStyle) -> None:
        with QSignalBlocker(self.options):
            for name in self.options.fields:
                self.options.show_value(name, getattr(style.figure, name))
        self._show_colors(style)

    def _show_colors(self, style: FigureStyle) -> None:
        for color, button in self.colors.items():
            swatch = QPixmap(16, 16)
            swatch.fill(QColor(style.colors.get(color, color)))
            button.setIcon(QIcon(swatch))

    def _draw_preview(self) -> None:
        net_contents = self._panel.printable_contents()
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
