"""Widget that draws the net, and its rendering with Matplotlib."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PySide6.QtCore import QEvent, QPointF, QRectF, Qt, Signal
from PySide6.QtGui import (
    QBitmap,
    QImage,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPalette,
    QPen,
    QPolygonF,
    QRegion,
    QResizeEvent,
)
from PySide6.QtWidgets import QWidget

from vomstudio.core.arrays import BoolArray
from vomstudio.products.net.contents import NetContents
from vomstudio.products.net.figure import NetArtists, draw_stereonet
from vomstudio.products.net.rose import RoseArtists, draw_roses
from vomstudio.products.net.rose_contents import RoseContents
from vomstudio.products.net.style import NetStyle
from vomstudio.project.fold_planes import FoldPlanes
from vomstudio.ui.panels.net.source import add_fold_axis

DPI = 100.0
_RIM_PX, _PAPER_MARGIN_PX = 11.0, 5.0
"""Margins of paper around the net with its ticks, and around texts, in logical pixels."""


@dataclass(frozen=True, eq=False)
class NetRequest:
    """Request to draw a net.

    Attributes
    ----------
    size : (int, int)
        Width and height in logical pixels.
    ratio : float
        Device pixels per logical pixel.
    fold_planes : FoldPlanes or None
        Planes whose fold axis is computed during drawing; if None, no fold axis is drawn.
    paper : str or None
        Colour of paper that covers only the net and its texts; if None, paper fills the widget.
    """

    contents: NetContents
    style: NetStyle
    size: tuple[int, int]
    ratio: float
    fold_planes: FoldPlanes | None = None
    paper: str | None = None


@dataclass(eq=False)
class DrawnNet:
    """Rendered net in three layers: background, emphasis of the selection and labels.

    Labels are drawn last, so that an emphasised great circle does not cover them.
    """

    artists: NetArtists
    ratio: float
    _canvas: Any
    _paper_color: str | None = None
    _background: Any = field(init=False)
    _labels: QImage = field(init=False)
    _paper: QImage | None = field(init=False, default=None)

    def __post_init__(self) -> None:
        self._exclude_emphasis()
        labels = [text for text in self.artists.axes.texts if not text.get_animated()]
        for text in labels:
            text.set_animated(True)
        self._canvas.draw()
        self._background = self._canvas.copy_from_bbox(self.artists.axes.figure.bbox)
        is_drawn = np.asarray(self._canvas.buffer_rgba())[..., 3] > 0
        # Labels take most of the drawing time and do not change with the selection.
        self._canvas.get_renderer().clear()
        for text in labels:
            self.artists.axes.draw_artist(text)
        self._labels = _canvas_image(self._canvas, self.ratio)
        if self._paper_color is not None:
            is_drawn |= np.asarray(self._canvas.buffer_rgba())[..., 3] > 0
            self._paper = self._paper_image(is_drawn, self._paper_color)

    @classmethod
    def draw(cls, request: NetRequest) -> DrawnNet:
        """Draw a net without emphasising the selection. Runs in any thread."""
        figure, canvas = _empty_figure(request)
        net_contents = add_fold_axis(request.contents, request.fold_planes)
        artists = draw_stereonet(figure, net_contents, request.style)
        if request.paper is not None:
            figure.set_facecolor("none")
        return cls(artists, request.ratio, canvas, request.paper)

    def _paper_image(self, is_drawn: BoolArray, color: str) -> QImage:
        """Return an image of the paper under the net and, with a margin, under other artists."""
        height, width = is_drawn.shape
        x_px, y_px = self.artists.centre_px
        rows, columns = np.ogrid[:height, :width]
        radius_px = self.artists.radius_px + _RIM_PX * self.ratio
        is_net = (columns - x_px) ** 2 + (height - rows - y_px) ** 2 < radius_px**2
        is_on_paper = is_net | (_box_sums(is_drawn, round(_PAPER_MARGIN_PX * self.ratio)) > 0)
        *rgb, alpha = to_rgba(color)
        pixels = np.empty((height, width, 4), np.uint8)
        pixels[..., :3] = np.round(255.0 * np.array(rgb))
        # The mean of nine pixels makes the edge smooth.
        pixels[..., 3] = np.round(255.0 * alpha * _box_sums(is_on_paper, 1) / 9.0)
        return _to_image(pixels, self.ratio)

    @cached_property
    def paper_region(self) -> QRegion:
        """Area of the paper in logical pixels; empty if the paper fills the widget."""
        if self._paper is None:
            return QRegion()
        mask = self._paper.createAlphaMask()
        mask.setDevicePixelRatio(1.0)
        return QRegion(QBitmap.fromImage(mask.scaled(self._paper.deviceIndependentSize().toSize())))

    def _exclude_emphasis(self) -> None:
        for artist in self.artists.emphasis:
            artist.set_animated(True)

    def image(self) -> QImage:
        """Return the image of the net, with the selection emphasised."""
        self._exclude_emphasis()
        self._canvas.restore_region(self._background)
        for artist in self.artists.emphasis:
            self.artists.axes.draw_artist(artist)
        net_image = _canvas_image(self._canvas, self.ratio)
        image = net_image if self._paper is None else self._paper.copy()
        painter = QPainter(image)
        if self._paper is not None:
            painter.drawImage(0, 0, net_image)
        painter.drawImage(0, 0, self._labels)
        painter.end()
        return image


@dataclass(eq=False)
class DrawnRoses:
    """Rendered roses or histograms."""

    artists: RoseArtists
    ratio: float
    _canvas: Any

    @classmethod
    def draw(cls, net_contents: RoseContents, request: NetRequest) -> DrawnRoses:
        """Draw roses or histograms in the style and size given by a request."""
        figure, canvas = _empty_figure(request)
        artists = draw_roses(figure, net_contents, request.style)
        canvas.draw()
        return cls(artists, request.ratio, canvas)

    def image(self) -> QImage:
        return _canvas_image(self._canvas, self.ratio)


def _empty_figure(request: NetRequest) -> tuple[Figure, FigureCanvasAgg]:
    dpi = DPI * request.ratio
    size_inches = tuple(round(side * request.ratio) / dpi for side in request.size)
    figure = Figure(figsize=(size_inches[0], size_inches[1]), dpi=dpi)
    return figure, FigureCanvasAgg(figure)


def _canvas_image(canvas: Any, ratio: float) -> QImage:
    return _to_image(np.asarray(canvas.buffer_rgba()), ratio)


def _box_sums(mask: BoolArray, half_width: int) -> NDArray[np.int64]:
    """Return, for each pixel, the number of set pixels in the square around it."""
    sums, side = mask.astype(np.int64), 2 * half_width + 1
    for axis in (0, 1):
        margins = [(0, 0), (0, 0)]
        margins[axis] = (half_width + 1, half_width)
        totals = np.cumsum(np.pad(sums, margins), axis)
        sums = np.take(totals, range(side, totals.shape[axis]), axis) - np.take(
            totals, range(totals.shape[axis] - side), axis
        )
    return sums


def _to_image(pixels: NDArray[np.uint8], ratio: float) -> QImage:
    height, width = pixels.shape[:2]
    view = QImage(pixels.data, width, height, 4 * width, QImage.Format.Format_RGBA8888)
    # Copied, because the canvas reuses its buffer for the next selection.
    image = view.copy()
    image.setDevicePixelRatio(ratio)
    return image


class NetCanvas(QWidget):
    """Widget that shows the net, the roses or a message, and draws the lasso.

    Mouse signals are emitted with Matplotlib positions: device pixels from the lower-left corner.
    """

    mouse_pressed = Signal(QMouseEvent, float, float)
    mouse_moved = Signal(float, float)
    mouse_released = Signal(QMouseEvent, float, float)
    mouse_left = Signal()
    painted = Signal()
    resized = Signal()

    def __init__(self) -> None:
        super().__init__()
        self.lasso: list[QPointF] = []
        self._image: QImage | None = None
        self._message = ""
        self.setMouseTracking(True)

    def show_net(self, net: DrawnNet | DrawnRoses) -> None:
        """Show a net or roses, and emphasise the current selection."""
        self._image, self._message = net.image(), ""
        self.update()

    def show_message(self, text: str) -> None:
        """Show a message in place of the net."""
        self._image, self._message = None, text
        self.update()

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        painter = QPainter(self)
        if self._image is not None:
            painter.drawImage(self._image_rect(self._image), self._image)
        if self._message:
            area = self.rect().adjusted(12, 12, -12, -12)
            flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
            painter.setPen(self.palette().color(QPalette.ColorRole.PlaceholderText))
            painter.drawText(area, int(flags), self._message)
        if len(self.lasso) > 1:
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            color = self.palette().color(QPalette.ColorRole.Highlight)
            painter.setPen(QPen(color, 1.5))
            color.setAlpha(40)
            painter.setBrush(color)
            painter.drawPolygon(QPolygonF(self.lasso))
        painter.end()
        self.painted.emit()

    def _image_rect(self, image: QImage) -> QRectF:
        """Return the rectangle of the image, which keeps its aspect ratio until the next redraw."""
        width, height = image.deviceIndependentSize().toTuple()
        if abs(width - self.width()) < 1.0 and abs(height - self.height()) < 1.0:
            return QRectF(0.0, 0.0, width, height)
        scale = min(self.width() / width, self.height() / height)
        width, height = scale * width, scale * height
        return QRectF((self.width() - width) / 2.0, (self.height() - height) / 2.0, width, height)

    # --- mouse -------------------------------------------------------------------------------
    def _pixel_position(self, event: QMouseEvent) -> tuple[float, float]:
        ratio, position = self.devicePixelRatioF(), event.position()
        return position.x() * ratio, (self.height() - position.y()) * ratio

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        if event.button() == Qt.MouseButton.LeftButton:
            self.mouse_pressed.emit(event, *self._pixel_position(event))

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        if self.lasso:
            self.lasso.append(event.position())
        self.mouse_moved.emit(*self._pixel_position(event))

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        if event.button() == Qt.MouseButton.LeftButton:
            self.mouse_released.emit(event, *self._pixel_position(event))

    def leaveEvent(self, event: QEvent) -> None:  # noqa: N802
        super().leaveEvent(event)
        self.mouse_left.emit()

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        super().resizeEvent(event)
        self.resized.emit()
