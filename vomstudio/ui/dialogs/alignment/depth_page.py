"""Page with a photo and its depth map side by side."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from PySide6.QtCore import QPointF, QRectF, Qt
from PySide6.QtGui import QColor, QConicalGradient, QFontMetricsF, QImage, QPainter, QPen
from PySide6.QtWidgets import QHBoxLayout, QWidget

from vomstudio.core.words import tr
from vomstudio.rendering.qt.bar_painting import ColorBar
from vomstudio.rendering.qt.painting import DARK, PANEL, TEXT, system_font
from vomstudio.rendering.view.scalars import Scale, colormap_table
from vomstudio.studio.jobs.inspection_tasks import DepthSummary
from vomstudio.ui.base.controls import ComboBox, ElidedLabel, Label, add_splitter, create_column
from vomstudio.ui.dialogs.alignment.alignment_data import AlignmentData, Arrays, to_image
from vomstudio.ui.widgets.number_table import Column, NumberTable
from vomstudio.ui.widgets.pane_painters import Painter
from vomstudio.ui.widgets.picture_panes import Picture, PicturePanes

_TABLE_WIDTH_PX = 260
_BAR_WIDTH_PX = 118.0
"""Width reserved for the colour bar."""


class DepthPage(QWidget):
    """Page with a list of photos, and one photo beside its depths, confidences or normals."""

    def __init__(self, data: AlignmentData) -> None:
        super().__init__()
        self._data = data
        self._photo_name = ""
        self._facts = DepthSummary(0.0, 1.0, 0.0)
        self._arrays: Arrays | None = None
        self._images: dict[str, QImage] = {}
        self._has_depths: dict[str, bool] = {}
        self.table = NumberTable(
            (
                Column(tr("Photo"), number=False),
                Column(
                    tr("Coverage"),
                    lambda share: f"{100 * share:.0f} %",
                    tr("Share of the unmasked pixels that have a depth."),
                ),
            ),
            sort_by=0,
        )
        self.table.setObjectName("depth_table")
        self.table.row_selected.connect(lambda values: self.show_photo(values[0]))
        self.layer = ComboBox()
        self.layer.setObjectName("depth_what")
        for title, name, tooltip in (
            (tr("Depth"), "colors", tr("Distance along the viewing direction.")),
            (
                tr("Confidence"),
                "confidence",
                tr("Each additional photo that agrees halves the difference from 1."),
            ),
            (
                tr("Surface normal"),
                "normals",
                tr("Hue: azimuth of the normal; pale: nearly horizontal; dark: overhanging."),
            ),
        ):
            self.layer.addItem(title, name)
            self.layer.setItemData(self.layer.count() - 1, tooltip, Qt.ItemDataRole.ToolTipRole)
        self.layer.currentIndexChanged.connect(lambda _: self._draw())
        self._summary = ElidedLabel()
        self._readout = ElidedLabel()
        self.panes = PicturePanes(2, is_linked=True, reserve=_BAR_WIDTH_PX)
        self.panes.setObjectName("depth_panes")
        self.panes.hovered.connect(self._show_readout)
        photo_area, rows = create_column()
        row = QHBoxLayout()
        row.addWidget(self._summary, 1)
        row.addWidget(Label(tr("Show")))
        row.addWidget(self.layer)
        rows.addLayout(row)
        rows.addWidget(self.panes, 1)
        rows.addWidget(self._readout)
        add_splitter(self, self.table, photo_area, [_TABLE_WIDTH_PX, 1000])

    @property
    def unit(self) -> str:
        return "m" if self._data.overview.scaled else tr("units")

    def fill(self) -> None:
        """List the photos, and show the first one with a depth map."""
        rows: list[tuple[tuple[Any, ...], str]] = []
        for photo in self._data.overview.photos:
            self._has_depths[photo.name] = photo.has_depths
            rows.append(((photo.name, None), "" if photo.has_depths else tr("No depth map")))
        self.table.fill(rows)
        if not any(self._has_depths.values()):
            self.panes.show_message(tr("Depth maps are computed after the alignment."))
            return
        self.table.select_row(lambda values: self._has_depths[values[0]])
        for name, has_depths in self._has_depths.items():
            if has_depths:
                self._data.read_coverage(name, partial(self._show_coverage, name))

    def _show_coverage(self, name: str, coverage: float | None) -> None:
        self.table.set_value(lambda values: values[0] == name, 1, coverage)

    def show_photo(self, name: str) -> None:
        """Show a photo and its depth map."""
        self._photo_name, self._arrays = name, None
        self._summary.setText("")
        if not self._has_depths[name]:
            self.panes.show_message(
                tr(
                    "{photo} has no depth map: no other photo shows the same rock well enough.",
                    photo=name,
                )
            )
            return
        if all(p is None for p in self.panes._pictures):
            self.panes.show_message(tr("Reading…"))
        self._data.read_depths(name, partial(self._show_depths, name), self.panes.show_message)

    def _show_depths(self, name: str, depth_facts: DepthSummary, arrays: Arrays) -> None:
        if name != self._photo_name:
            return
        self._facts, self._arrays = depth_facts, arrays
        self._images.clear()
        self.panes.show_message("")
        self._draw()
        self._summary.setText(
            tr(
                "{coverage:.0f} % of the pixels of {photo} have a depth, from {low:.2f} to "
                "{high:.2f} {unit}.",
                coverage=100 * depth_facts.coverage,
                photo=name,
                low=depth_facts.low,
                high=depth_facts.high,
                unit=self.unit,
            )
        )

    def _draw(self) -> None:
        if self._arrays is None:
            return
        layer = str(self.layer.currentData())
        height, width = self._arrays["depth"].shape
        size = (float(width), float(height))
        self.panes.show_pictures(
            [
                Picture(self._photo_name, self._image("photo"), size),
                Picture(self.layer.currentText(), self._image(layer), size),
            ],
            store_view=True,
        )
        legend: Painter
        if layer == "normals":
            legend = partial(_paint_compass, letters="NESW" if self._data.overview.crs else "yx")
        else:
            legend = partial(_paint_color_bar, scale=self._scale(layer))
        self.panes.set_overlays([None, legend])

    def _image(self, layer: str) -> QImage:
        assert self._arrays is not None
        if layer not in self._images:
            self._images[layer] = to_image(self._arrays[layer])
        return self._images[layer]

    def _scale(self, layer: str) -> Scale:
        table = colormap_table("viridis")
        if layer == "confidence":
            return Scale(
                title=tr("Confidence"), unit="", kind="sequential", low=0.0, high=1.0, table=table
            )
        depth_facts = self._facts
        return Scale(
            title=tr("Depth"),
            unit=self.unit,
            kind="sequential",
            low=depth_facts.low,
            high=depth_facts.high,
            table=table,
            has_lower_values=True,
            has_higher_values=True,
            missing=depth_facts.coverage < 1.0,
        )

    def _show_readout(self, position: tuple[int, float, float] | None) -> None:
        text = ""
        if position is not None and self._arrays is not None:
            _, x, y = position
            depth = self._arrays["depth"]
            row, column = math.floor(y), math.floor(x)
            if 0 <= row < depth.shape[0] and 0 <= column < depth.shape[1]:
                value = float(depth[row, column])
                text = (
                    tr("Depth {value:.3f} {unit}", value=value, unit=self.unit)
                    if value > 0
                    else tr("No depth: no other photo agrees.")
                )
        self._readout.setText(text or tr("Wheel: zoom. Drag: pan. Both pictures move together."))


def _paint_color_bar(
    painter: QPainter,
    box: QRectF,
    project: Callable[[np.ndarray], np.ndarray],
    zoom: float,
    *,
    scale: Scale,
) -> None:
    ColorBar(scale, (scale.title,), box.right() - 8, box.top() + 40, box.bottom() - 8).paint(
        painter
    )


def _paint_compass(
    painter: QPainter,
    box: QRectF,
    project: Callable[[np.ndarray], np.ndarray],
    zoom: float,
    *,
    letters: str,
) -> None:
    """Paint the legend of the hues, which represent the azimuth of the surface normal."""
    font = system_font(bold=True)
    metrics = QFontMetricsF(font)
    radius, padding = 30.0, metrics.height() + 4.0
    size = 2 * (radius + padding)
    background = QRectF(box.right() - size - 8, box.top() + 40, size, size)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(PANEL)
    painter.drawRoundedRect(background, 5, 5)
    centre = background.center()
    # Qt's angles run counter-clockwise from the east, azimuths clockwise from the north.
    gradient = QConicalGradient(centre, 90.0)
    for step in range(37):
        gradient.setColorAt(step / 36, QColor.fromHsvF(((360 - 10 * step) % 360) / 360.0, 1.0, 1.0))
    painter.setBrush(gradient)
    painter.setPen(QPen(DARK, 1.0))
    painter.drawEllipse(centre, radius, radius)
    painter.setFont(font)
    painter.setPen(TEXT)
    names = (letters + "    ")[:4]
    for name, (dx, dy) in zip(names, ((0, -1), (1, 0), (0, 1), (-1, 0)), strict=True):
        offset = radius + padding / 2
        position = centre + QPointF(dx * offset, dy * offset)
        width = metrics.horizontalAdvance(name)
        painter.drawText(position + QPointF(-width / 2, metrics.capHeight() / 2), name)
