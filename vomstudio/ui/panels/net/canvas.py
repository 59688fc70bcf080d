"""The widget that shows the net of the dock."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PySide6.QtCore import QEvent, QPointF, QRectF, Qt, Signal
from PySide6.QtGui import (
    QImage,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPalette,
    QPen,
    QPolygonF,
    QResizeEvent,
)
from PySide6.QtWidgets import QWidget

from vomstudio.products.net.contents import NetContents
from vomstudio.products.net.figure import NetArtists, draw_stereonet
from vomstudio.products.net.rose import RoseArtists, draw_roses
from vomstudio.products.net.rose_contents import RoseContents
from vomstudio.products.net.style import NetStyle
from vomstudio.project.fold_planes import FoldPlanes
from vomstudio.ui.panels.net.source import with_fold

DPI = 100.0


@dataclass(frozen=True, eq=False)
class Wanted:
    """A net to be drawn. size : width and height in logical pixels; ratio : device pixels in one;
    beds : whose fold axis is still to be found, None for none"""

    contents: NetContents
    style: NetStyle
    size: tuple[int, int]
    ratio: float
    beds: FoldPlanes | None = None


@dataclass(eq=False)
class DrawnNet:
    """A net with its pixels, over which the emphasis is drawn, and over that the words: a great
    circle that stands out would cross out the name of the fold axis."""

    artists: NetArtists
    ratio: float
    _canvas: Any
    _clean: Any = field(init=False)
    _words: QImage = field(init=False)

    def __post_init__(self) -> None:
        self._keep_emphasis_out()
        words = [text for text in self.artists.axes.texts if not text.get_animated()]
        for text in words:
            text.set_animated(True)
        self._canvas.draw()
        self._clean = self._canvas.copy_from_bbox(self.artists.axes.figure.bbox)
        # Words take most of the time of a net, and stay the same.
        self._canvas.get_renderer().clear()
        for text in words:
            self.artists.axes.draw_artist(text)
        self._words = _image_of(self._canvas, self.ratio)

    @classmethod
    def of(cls, wanted: Wanted) -> DrawnNet:
        """Draw it, without its emphasis: in any thread."""
        figure, canvas = _empty_figure(wanted)
        contents = with_fold(wanted.contents, wanted.beds)
        return cls(draw_stereonet(figure, contents, wanted.style), wanted.ratio, canvas)

    def _keep_emphasis_out(self) -> None:
        for artist in self.artists.emphasis:
            artist.set_animated(True)

    def image(self) -> QImage:
        """The net with its emphasis."""
        self._keep_emphasis_out()
        self._canvas.restore_region(self._clean)
        for artist in self.artists.emphasis:
            self.artists.axes.draw_artist(artist)
        image = _image_of(self._canvas, self.ratio)
        painter = QPainter(image)
        painter.drawImage(0, 0, self._words)
        painter.end()
        return image


@dataclass(eq=False)
class DrawnRoses:
    """Roses or histograms with their pixels."""

    artists: RoseArtists
    ratio: float
    _canvas: Any

    @classmethod
    def of(cls, contents: RoseContents, wanted: Wanted) -> DrawnRoses:
        """wanted : its style and size"""
        figure, canvas = _empty_figure(wanted)
        artists = draw_roses(figure, contents, wanted.style)
        canvas.draw()
        return cls(artists, wanted.ratio, canvas)

    def image(self) -> QImage:
        return _image_of(self._canvas, self.ratio)


def _empty_figure(wanted: Wanted) -> tuple[Figure, FigureCanvasAgg]:
    dpi = DPI * wanted.ratio
    inches = tuple(round(side * wanted.ratio) / dpi for side in wanted.size)
    figure = Figure(figsize=(inches[0], inches[1]), dpi=dpi)
    return figure, FigureCanvasAgg(figure)


def _image_of(canvas: Any, ratio: float) -> QImage:
    pixels = np.asarray(canvas.buffer_rgba())
    height, width = pixels.shape[:2]
    shown = QImage(pixels.data, width, height, 4 * width, QImage.Format.Format_RGBA8888)
    # A copy: the pixels are drawn over with the next selection.
    image = shown.copy()
    image.setDevicePixelRatio(ratio)
    return image


class NetCanvas(QWidget):
    """Shows the net, and the lasso over it.

    Places are those of Matplotlib: device pixels from the bottom left corner.
    """

    pressed = Signal(QMouseEvent, float, float)
    moved = Signal(float, float)
    released = Signal(QMouseEvent, float, float)
    left = Signal()
    painted = Signal()
    resized = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.lasso: list[QPointF] = []
        self._image: QImage | None = None
        self._says = ""
        self.setMouseTracking(True)

    def show_net(self, net: DrawnNet | DrawnRoses) -> None:
        """This net from now on, or this one with another emphasis."""
        self._image, self._says = net.image(), ""
        self.update()

    def say(self, text: str) -> None:
        """Why there is nothing to be seen."""
        self._image, self._says = None, text
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        painter = QPainter(self)
        if self._image is not None:
            painter.drawImage(self._place(self._image), self._image)
        if self._says:
            room = self.rect().adjusted(12, 12, -12, -12)
            flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
            painter.setPen(self.palette().color(QPalette.ColorRole.PlaceholderText))
            painter.drawText(room, int(flags), self._says)
        if len(self.lasso) > 1:
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            color = self.palette().color(QPalette.ColorRole.Highlight)
            painter.setPen(QPen(color, 1.5))
            color.setAlpha(40)
            painter.setBrush(color)
            painter.drawPolygon(QPolygonF(self.lasso))
        painter.end()
        self.painted.emit()

    def _place(self, image: QImage) -> QRectF:
        """Of the picture in the widget: until a net of the new size is drawn it keeps its shape."""
        wide, tall = image.deviceIndependentSize().toTuple()
        if abs(wide - self.width()) < 1.0 and abs(tall - self.height()) < 1.0:
            return QRectF(0.0, 0.0, wide, tall)
        scale = min(self.width() / wide, self.height() / tall)
        wide, tall = scale * wide, scale * tall
        return QRectF((self.width() - wide) / 2.0, (self.height() - tall) / 2.0, wide, tall)

    # --- Qt's names --------------------------------------------------------------------------
    def _at(self, event: QMouseEvent) -> tuple[float, float]:
        ratio, at = self.devicePixelRatioF(), event.position()
        return at.x() * ratio, (self.height() - at.y()) * ratio

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        if event.button() == Qt.MouseButton.LeftButton:
            self.pressed.emit(event, *self._at(event))

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        if self.lasso:
            self.lasso.append(event.position())
        self.moved.emit(*self._at(event))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        if event.button() == Qt.MouseButton.LeftButton:
            self.released.emit(event, *self._at(event))

    def leaveEvent(self, event: QEvent) -> None:  # noqa: N802
        super().leaveEvent(event)
        self.left.emit()

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        super().resizeEvent(event)
        self.resized.emit()
