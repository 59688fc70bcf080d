"""The page with a photo and its depth map side by side."""

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
from vomstudio.rendering.view.scalars import Scale, map_table
from vomstudio.studio.jobs.inspection_tasks import DepthFacts
from vomstudio.ui.base.controls import ComboBox, ElidedLabel, Label, add_splitter, create_column
from vomstudio.ui.dialogs.alignment.alignment_data import AlignmentData, Arrays, to_image
from vomstudio.ui.widgets.number_table import Column, NumberTable
from vomstudio.ui.widgets.pane_painters import Painter
from vomstudio.ui.widgets.picture_panes import Picture, PicturePanes

_WIDTH = 260
_BAR = 118.0
"""Room for the colour bar."""


class DepthPage(QWidget):
    """A list of the photos, and one of them beside its depths, confidences or surface normals."""

    def __init__(self, data: AlignmentData) -> None:
        super().__init__()
        self._data = data
        self._wanted = ""
        self._facts = DepthFacts(0.0, 1.0, 0.0)
        self._arrays: Arrays | None = None
        self._images: dict[str, QImage] = {}
        self._has: dict[str, bool] = {}
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
        self.what = ComboBox()
        self.what.setObjectName("depth_what")
        for title, name, tip in (
            (tr("Depth"), "colors", tr("Distance along the viewing direction.")),
            (
                tr("Confidence"),
                "confidence",
                tr("Each further photo that agrees halves the difference from 1."),
            ),
            (
                tr("Surface normal"),
                "normals",
                tr("Hue: azimuth of the normal; pale: nearly horizontal; dark: overhanging."),
            ),
        ):
            self.what.addItem(title, name)
            self.what.setItemData(self.what.count() - 1, tip, Qt.ItemDataRole.ToolTipRole)
        self.what.currentIndexChanged.connect(lambda _: self._draw())
        self._said = ElidedLabel()
        self._under = ElidedLabel()
        self.panes = PicturePanes(2, is_linked=True, reserve=_BAR)
        self.panes.setObjectName("depth_panes")
        self.panes.hovered.connect(self._hovered)
        right, rows = create_column()
        row = QHBoxLayout()
        row.addWidget(self._said, 1)
        row.addWidget(Label(tr("Show")))
        row.addWidget(self.what)
        rows.addLayout(row)
        rows.addWidget(self.panes, 1)
        rows.addWidget(self._under)
        add_splitter(self, self.table, right, [_WIDTH, 1000])

    @property
    def unit(self) -> str:
        return "m" if self._data.overview.scaled else tr("units")

    def fill(self) -> None:
        """Show the photos of the overview, and the first one that has a depth map."""
        rows: list[tuple[tuple[Any, ...], str]] = []
        for photo in self._data.overview.photos:
            self._has[photo.name] = photo.has_depths
            rows.append(((photo.name, None), "" if photo.has_depths else tr("No depth map")))
        self.table.fill(rows)
        if not any(self._has.values()):
            self.panes.show_message(
                tr("There are no depth maps yet. They are made after the alignment.")
            )
            return
        self.table.select_row(lambda values: self._has[values[0]])
        for name, has in self._has.items():
            if has:
                self._data.coverage(name, partial(self._covered, name))

    def _covered(self, name: str, share: float | None) -> None:
        self.table.set_value(lambda values: values[0] == name, 1, share)

    def show_photo(self, name: str) -> None:
        """Show the photo of this name and its depth map."""
        self._wanted, self._arrays = name, None
        self._said.setText("")
        if not self._has[name]:
            self.panes.show_message(
                tr(
                    "{photo} has no depth map: no other photo shows the same rock well enough.",
                    photo=name,
                )
            )
            return
        if all(p is None for p in self.panes._pictures):
            self.panes.show_message(tr("Reading…"))
        self._data.depths(name, partial(self._there, name), self.panes.show_message)

    def _there(self, name: str, facts: DepthFacts, arrays: Arrays) -> None:
        if name != self._wanted:
            return
        self._facts, self._arrays = facts, arrays
        self._images.clear()
        self.panes.show_message("")
        self._draw()
        self._said.setText(
            tr(
                "{coverage:.0f} % of the pixels of {photo} have a depth, from {low:.2f} to "
                "{high:.2f} {unit}.",
                coverage=100 * facts.coverage,
                photo=name,
                low=facts.low,
                high=facts.high,
                unit=self.unit,
            )
        )

    def _draw(self) -> None:
        if self._arrays is None:
            return
        what = str(self.what.currentData())
        high, wide = self._arrays["depth"].shape
        size = (float(wide), float(high))
        self.panes.show_pictures(
            [
                Picture(self._wanted, self._image("photo"), size),
                Picture(self.what.currentText(), self._image(what), size),
            ],
            keep_view=True,
        )
        over: Painter
        if what == "normals":
            over = partial(_compass, letters="NESW" if self._data.overview.crs else "yx")
        else:
            over = partial(_bar, scale=self._scale(what))
        self.panes.set_overlays([None, over])

    def _image(self, what: str) -> QImage:
        """Made when it is first looked at."""
        assert self._arrays is not None
        if what not in self._images:
            self._images[what] = to_image(self._arrays[what])
        return self._images[what]

    def _scale(self, what: str) -> Scale:
        table = map_table("viridis")
        if what == "confidence":
            return Scale(tr("Confidence"), "", "sequential", 0.0, 1.0, table)
        facts = self._facts
        return Scale(
            tr("Depth"),
            self.unit,
            "sequential",
            facts.low,
            facts.high,
            table,
            below=True,
            above=True,
            missing=facts.coverage < 1.0,
        )

    def _hovered(self, place: tuple[int, float, float] | None) -> None:
        words = ""
        if place is not None and self._arrays is not None:
            _, x, y = place
            depth = self._arrays["depth"]
            row, column = math.floor(y), math.floor(x)
            if 0 <= row < depth.shape[0] and 0 <= column < depth.shape[1]:
                value = float(depth[row, column])
                words = (
                    tr("Depth {value:.3f} {unit}", value=value, unit=self.unit)
                    if value > 0
                    else tr("No depth: no other photo agrees.")
                )
        self._under.setText(words or tr("Wheel: zoom. Drag: pan. Both pictures move together."))


def _bar(
    painter: QPainter,
    box: QRectF,
    on_screen: Callable[[np.ndarray], np.ndarray],
    zoom: float,
    *,
    scale: Scale,
) -> None:
    ColorBar(scale, (scale.title,), box.right() - 8, box.top() + 40, box.bottom() - 8).paint(
        painter
    )


def _compass(
    painter: QPainter,
    box: QRectF,
    on_screen: Callable[[np.ndarray], np.ndarray],
    zoom: float,
    *,
    letters: str,
) -> None:
    """The legend of the hues: the azimuth of the surface normal."""
    font = system_font(bold=True)
    metrics = QFontMetricsF(font)
    radius, pad = 30.0, metrics.height() + 4.0
    side = 2 * (radius + pad)
    ground = QRectF(box.right() - side - 8, box.top() + 40, side, side)
    painter.setPen(Qt.PenStyle.NoPen)
    painter.setBrush(PANEL)
    painter.drawRoundedRect(ground, 5, 5)
    centre = ground.center()
    # Qt's angles run counter-clockwise from the east, azimuths clockwise from the north.
    wheel = QConicalGradient(centre, 90.0)
    for step in range(37):
        wheel.setColorAt(step / 36, QColor.fromHsvF(((360 - 10 * step) % 360) / 360.0, 1.0, 1.0))
    painter.setBrush(wheel)
    painter.setPen(QPen(DARK, 1.0))
    painter.drawEllipse(centre, radius, radius)
    painter.setFont(font)
    painter.setPen(TEXT)
    names = (letters + "    ")[:4]
    for name, (dx, dy) in zip(names, ((0, -1), (1, 0), (0, 1), (-1, 0)), strict=True):
        reach = radius + pad / 2
        at = centre + QPointF(dx * reach, dy * reach)
        wide = metrics.horizontalAdvance(name)
        painter.drawText(at + QPointF(-wide / 2, metrics.capHeight() / 2), name)
