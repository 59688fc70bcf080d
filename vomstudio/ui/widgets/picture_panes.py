"""Photos side by side with pan, zoom, overlays, and lines between them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
from PySide6.QtCore import QEvent, QLineF, QPointF, QRectF, QSize, Qt, Signal
from PySide6.QtGui import (
    QColor,
    QFontMetricsF,
    QImage,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QPixmap,
    QResizeEvent,
    QWheelEvent,
)
from PySide6.QtWidgets import QSizePolicy, QWidget

from vomstudio.core.arrays import ByteArray, FloatArray, IndexArray, IntArray
from vomstudio.rendering.qt.painting import DARK, PANEL, TEXT, system_font
from vomstudio.ui.widgets.pane_painters import Painter, inside_mask, paint_nothing

BACKGROUND = QColor(46, 48, 52)
GAP_PIXELS = 6.0
ZOOM_PER_NOTCH = 0.8
MAX_ZOOM = 24.0
"""Maximum number of screen pixels per photo pixel."""
PICK_RADIUS_PIXELS = 10.0
_MAX_SMOOTH_LINES = 300
"""Maximum number of antialiased lines."""


@dataclass(eq=False)
class Picture:
    """Picture of a pane.

    Attributes
    ----------
    image : QImage or None
        Upright image, possibly reduced.
    size : tuple of float
        Size of the full-resolution picture in pixels, the unit of all marks.
    problem : str
        Reason why the image is missing.
    """

    title: str
    image: QImage | None
    size: tuple[float, float]
    problem: str = ""


@dataclass(eq=False)
class _PaneView:
    """Zoom of a pane, and centre in picture pixels (None for the whole picture)."""

    centre: FloatArray | None = None
    zoom: float = 1.0


@dataclass(eq=False)
class Links:
    """Lines from pane 0 to pane 1.

    Attributes
    ----------
    left, right : (m, 2) array
        End points in the left and right pictures.
    colors : (m, 3) uint8 array
    visible_rows : int array
        Rows of the lines that are drawn.
    faint_lines : tuple of arrays, optional
        Ends of lines that are drawn in red, below the others.
    """

    left: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    right: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    colors: ByteArray = field(default_factory=lambda: np.zeros((0, 3), np.uint8))
    visible_rows: IntArray = field(default_factory=lambda: np.zeros(0, np.int64))
    faint_lines: tuple[FloatArray, FloatArray] | None = None


class PicturePanes(QWidget):
    """Panes with pictures; the wheel or the keys + - 0 zoom, and a drag pans.

    A double click on a link zooms to both of its ends. Elsewhere, it shows the whole pictures.

    Parameters
    ----------
    is_linked : bool
        Whether all panes show the same part.
    reserve : float
        Initial free width on the right of each pane, in pixels.

    Attributes
    ----------
    hovered : Signal
        Emitted with pane, x and y in the picture under the cursor, or None.
    """

    hovered = Signal(object)

    def __init__(self, count: int, *, is_linked: bool = False, reserve: float = 0.0) -> None:
        super().__init__()
        self._pictures: list[Picture | None] = [None] * count
        self._views = [_PaneView() for _ in range(count)]
        if is_linked:
            self._views = [self._views[0]] * count
        self._is_linked, self._reserved_width = is_linked, reserve
        self._overlays: list[Painter] = []
        self._links = Links()
        self._hovered_link: int | None = None
        self._drag: tuple[int, QPointF] | None = None
        self._message = ""
        self._base: QPixmap | None = None
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMinimumSize(320, 220)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)

    def sizeHint(self) -> QSize:  # noqa: N802
        return QSize(900, 500)

    # --- content -----------------------------------------------------------------------------
    def show_pictures(
        self, pictures: Sequence[Picture | None], *, store_view: bool = False
    ) -> None:
        """Show one picture per pane; `store_view` keeps the zoom if the sizes are the same."""
        previous = [None if p is None else p.size for p in self._pictures]
        self._pictures = list(pictures)
        if not store_view or previous != [None if p is None else p.size for p in pictures]:
            for view in self._views:
                view.centre = None
        self._repaint_base()

    def show_message(self, text: str) -> None:
        """Show a text instead of the pictures; an empty text shows the pictures."""
        self._message = text
        self._repaint_base()

    def show_links(self, links: Links) -> None:
        self._links, self._hovered_link = links, None
        self._repaint_base()

    def set_overlays(self, painters: Sequence[Painter | None]) -> None:
        """Set the painters of the panes."""
        self._overlays = [item or paint_nothing for item in painters]
        self._repaint_base()

    # --- geometry ----------------------------------------------------------------------------
    def box(self, pane: int) -> QRectF:
        count = len(self._pictures)
        width = (self.width() - GAP_PIXELS * (count - 1)) / count
        return QRectF(pane * (width + GAP_PIXELS), 0.0, width, float(self.height()))

    def middle(self, pane: int) -> QPointF:
        """Return the position in the widget at which the centre of a pane's view is drawn."""
        return self.box(pane).center() - QPointF(self._reserved_width / 2, 0.0)

    def _fit(self, pane: int) -> tuple[FloatArray, float]:
        picture, box = self._pictures[pane], self.box(pane)
        width, height = (1.0, 1.0) if picture is None else picture.size
        title = QFontMetricsF(system_font()).height() + 14.0
        available_width = max(box.width() - self._reserved_width, 20.0)
        zoom = min(
            available_width / max(width, 1.0), max(box.height() - 2 * title, 20) / max(height, 1.0)
        )
        return np.array([width / 2, height / 2]), zoom

    def _view(self, pane: int) -> tuple[FloatArray, float]:
        view = self._views[pane]
        return self._fit(pane) if view.centre is None else (view.centre, view.zoom)

    def to_screen(self, pane: int, positions: npt.ArrayLike) -> FloatArray:
        """Convert positions (n, 2) in a picture to widget pixels (n, 2)."""
        centre, zoom = self._view(pane)
        midpoint = self.middle(pane)
        points = np.asarray(positions, np.float64).reshape(-1, 2)
        return (points - centre) * zoom + [midpoint.x(), midpoint.y()]

    def to_picture(self, pane: int, position: QPointF) -> FloatArray:
        centre, zoom = self._view(pane)
        midpoint = self.middle(pane)
        return centre + np.array([position.x() - midpoint.x(), position.y() - midpoint.y()]) / zoom

    def pane_at(self, position: QPointF) -> int | None:
        """Return the index of the pane at a point, or None if no pane with a picture is there."""
        for pane, picture in enumerate(self._pictures):
            if picture is not None and self.box(pane).contains(position):
                return pane
        return None

    def zoom(self, factor: float, position: QPointF) -> None:
        """Zoom by a factor about a point of the widget."""
        pane = self.pane_at(position)
        if pane is None:
            return
        zoom_centre = self.to_picture(pane, position)
        centre, zoom = self._view(pane)
        min_zoom = 0.5 * self._fit(pane)[1]
        new_zoom = min(max(zoom * factor, min_zoom), MAX_ZOOM)
        view = self._views[pane]
        view.centre, view.zoom = zoom_centre + (centre - zoom_centre) * (zoom / new_zoom), new_zoom
        self._repaint_base()

    def look_at(self, pane: int, position: npt.ArrayLike, zoom: float) -> None:
        view = self._views[pane]
        view.centre, view.zoom = np.array(position, np.float64).reshape(2), zoom
        self._repaint_base()

    def show_all(self) -> None:
        for view in self._views:
            view.centre = None
        self._repaint_base()

    # --- painting ----------------------------------------------------------------------------
    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        ratio = self.devicePixelRatioF()
        size = self.size() * ratio
        if self._base is None or self._base.size() != size:
            # Cached, so that thousands of marks are not redrawn at every move of the cursor.
            self._base = QPixmap(size)
            self._base.setDevicePixelRatio(ratio)
            base = QPainter(self._base)
            self._paint_all(base)
            base.end()
        painter = QPainter(self)
        painter.drawPixmap(0, 0, self._base)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if not self._message:
            self._paint_hovered_link(painter)

    def _repaint_base(self) -> None:
        self._base = None
        self.update()

    def _paint_all(self, painter: QPainter) -> None:
        painter.fillRect(self.rect(), self.palette().window())
        if self._message or all(p is None for p in self._pictures):
            painter.fillRect(self.rect(), BACKGROUND)
            painter.setPen(TEXT)
            painter.setFont(system_font())
            box = QRectF(self.rect()).adjusted(24, 12, -24, -12)
            flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
            painter.drawText(box, int(flags), self._message)
            return
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
        for pane, picture in enumerate(self._pictures):
            if picture is not None:
                self._paint_pane(painter, pane, picture)
        self._paint_links(painter)
        for pane, picture in enumerate(self._pictures):
            if picture is not None:
                self._paint_title(painter, pane, picture)

    def _paint_pane(self, painter: QPainter, pane: int, picture: Picture) -> None:
        box = self.box(pane)
        painter.save()
        painter.setClipRect(box)
        painter.fillRect(box, BACKGROUND)
        corners = self.to_screen(pane, [[0, 0], picture.size])
        target = QRectF(QPointF(*corners[0]), QPointF(*corners[1]))
        if picture.image is not None:
            magnification = target.width() / max(picture.image.width(), 1)
            smooth_hint = QPainter.RenderHint.SmoothPixmapTransform
            painter.setRenderHint(smooth_hint, magnification < 3.0)
            painter.drawImage(target, picture.image)
            painter.setRenderHint(smooth_hint)
        else:
            painter.setPen(TEXT)
            painter.setFont(system_font())
            flags = Qt.AlignmentFlag.AlignCenter | Qt.TextFlag.TextWordWrap
            painter.drawText(box.adjusted(20, 0, -20, 0), int(flags), picture.problem)
        if pane < len(self._overlays):
            self._overlays[pane](
                painter, box, lambda places: self.to_screen(pane, places), self._view(pane)[1]
            )
        painter.restore()

    def _paint_title(self, painter: QPainter, pane: int, picture: Picture) -> None:
        font = system_font(bold=True)
        metrics = QFontMetricsF(font)
        box = self.box(pane)
        max_width = box.width() - 28.0
        text = metrics.elidedText(picture.title, Qt.TextElideMode.ElideMiddle, max_width)
        background = QRectF(
            box.left() + 6, 6, metrics.horizontalAdvance(text) + 14, metrics.height() + 6
        )
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(PANEL)
        painter.drawRoundedRect(background, 4, 4)
        painter.setFont(font)
        painter.setPen(TEXT)
        painter.drawText(
            QPointF(background.left() + 7, background.top() + 3 + metrics.ascent()), text
        )

    def _paint_links(self, painter: QPainter) -> None:
        links = self._links
        if len(self._pictures) < 2 or any(p is None for p in self._pictures[:2]):
            return
        if links.faint_lines is not None:
            painter.setPen(QPen(QColor(224, 64, 42, 110), 1.0))
            painter.drawLines(self._lines(*links.faint_lines))
        is_smooth = len(links.visible_rows) <= _MAX_SMOOTH_LINES
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, is_smooth)
        lines = self._lines(links.left[links.visible_rows], links.right[links.visible_rows])
        if is_smooth:
            painter.setPen(QPen(QColor(0, 0, 0, 70), 2.8))
            painter.drawLines(lines)
        # Uses one call for all lines of the same colour.
        for color, rows in _group_by_color(links.colors[links.visible_rows]):
            painter.setPen(QPen(color, 1.4 if is_smooth else 1.0))
            painter.drawLines([lines[row] for row in rows if not lines[row].isNull()])
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)

    def _paint_hovered_link(self, painter: QPainter) -> None:
        links = self._links
        if self._hovered_link is not None and self._hovered_link < len(links.left):
            ends = (links.left[self._hovered_link], links.right[self._hovered_link])
            for color, width in ((DARK, 4.5), (QColor("#ffffff"), 2.2)):
                painter.setPen(QPen(color, width))
                painter.drawLines(self._lines(*ends))
                for pane, place in enumerate(ends):
                    (centre,) = self.to_screen(pane, place)
                    if self.box(pane).contains(QPointF(*centre)):
                        painter.drawEllipse(QPointF(*centre), 7.0, 7.0)

    def _lines(self, left: FloatArray, right: FloatArray) -> list[QLineF]:
        """Return lines between positions (n, 2); a line is null if an end is invisible."""
        ends = np.hstack([self.to_screen(0, left), self.to_screen(1, right)])
        for pane, points in ((0, ends[:, :2]), (1, ends[:, 2:])):
            ends[~inside_mask(self.box(pane), points)] = 0.0
        return [QLineF(*row) for row in ends.tolist()]

    # --- mouse and keys ----------------------------------------------------------------------
    def _link_at(self, position: QPointF) -> int | None:
        pane = self.pane_at(position)
        positions = {0: self._links.left, 1: self._links.right}.get(-1 if pane is None else pane)
        if pane is None or positions is None or not len(positions):
            return None
        distances = np.hypot(*(self.to_screen(pane, positions) - [position.x(), position.y()]).T)
        best_row = int(distances.argmin())
        return best_row if distances[best_row] <= PICK_RADIUS_PIXELS else None

    def mousePressEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        pane = self.pane_at(event.position())
        if pane is not None and event.button() in (
            Qt.MouseButton.LeftButton,
            Qt.MouseButton.MiddleButton,
        ):
            self._drag = (pane, event.position())
            self.setCursor(Qt.CursorShape.ClosedHandCursor)

    def mouseMoveEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        cursor = event.position()
        if self._drag is not None:
            pane, previous = self._drag
            centre, zoom = self._view(pane)
            motion = np.array([cursor.x() - previous.x(), cursor.y() - previous.y()]) / zoom
            view = self._views[pane]
            view.centre, view.zoom = centre - motion, zoom
            self._drag = (pane, cursor)
            self._repaint_base()
            return
        link = self._link_at(cursor)
        if link != self._hovered_link:
            self._hovered_link = link
            self.update()
        hovered_pane = self.pane_at(cursor)
        place = None if hovered_pane is None else self.to_picture(hovered_pane, cursor)
        self.hovered.emit(
            None if place is None else (hovered_pane, float(place[0]), float(place[1]))
        )

    def mouseReleaseEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        self._drag = None
        self.unsetCursor()

    def mouseDoubleClickEvent(self, event: QMouseEvent) -> None:  # noqa: N802
        row = self._link_at(event.position())
        if row is None:
            self.show_all()
            return
        for pane, place in enumerate((self._links.left[row], self._links.right[row])):
            self.look_at(pane, place, max(2.0, self._fit(pane)[1]))

    def wheelEvent(self, event: QWheelEvent) -> None:  # noqa: N802
        notches = event.angleDelta().y() / 120.0
        if notches:
            self.zoom(ZOOM_PER_NOTCH**-notches, event.position())
        event.accept()

    def keyPressEvent(self, event: QKeyEvent) -> None:  # noqa: N802
        factor = {
            Qt.Key.Key_Plus: 1 / ZOOM_PER_NOTCH,
            Qt.Key.Key_Equal: 1 / ZOOM_PER_NOTCH,
            Qt.Key.Key_Minus: ZOOM_PER_NOTCH,
        }.get(Qt.Key(event.key()))
        if event.key() == Qt.Key.Key_0:
            self.show_all()
        elif factor is not None:
            for pane in range(1 if self._is_linked else len(self._pictures)):
                self.zoom(factor, self.box(pane).center())
        else:
            super().keyPressEvent(event)

    def leaveEvent(self, event: QEvent) -> None:  # noqa: N802
        if self._hovered_link is not None:
            self._hovered_link = None
            self.update()
        self.hovered.emit(None)
        super().leaveEvent(event)

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        super().resizeEvent(event)
        self._repaint_base()


def _group_by_color(
    colors: ByteArray,
) -> Iterator[tuple[QColor, IndexArray]]:
    """Yield each distinct colour in (n, 3) with its rows, ordered by colour."""
    if len(colors):
        unique_colors, indices = np.unique(colors, axis=0, return_inverse=True)
        for number, rgb in enumerate(unique_colors.tolist()):
            red, green, blue = (int(v) for v in rgb)
            yield QColor(red, green, blue, 220), np.flatnonzero(indices.reshape(-1) == number)
