"""Colour wheel of dip directions, with north up as on the stereonet."""

from __future__ import annotations

from functools import lru_cache

from PySide6.QtCore import QPointF, QRectF, QSize, Qt
from PySide6.QtGui import QColor, QConicalGradient, QPainter, QPaintEvent, QPalette, QPen
from PySide6.QtWidgets import QSizePolicy, QWidget

from vomstudio.core.words import to_translate, tr

_LETTERS = (to_translate("N"), to_translate("E"), to_translate("S"), to_translate("W"))
_SIZE_PX = 104
_GRADIENT_STOPS = 36


class DirectionWheel(QWidget):
    """Colour wheel of dip directions.

    Attributes
    ----------
    map_name : str
        Name of a cyclic Matplotlib colour map.
    has_letters : bool
        Whether compass letters are drawn instead of angles.
    """

    def __init__(self) -> None:
        super().__init__()
        self.map_name = ""
        self.has_letters = True
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)
        self.setAccessibleName(tr("Colours of dip directions"))

    def sizeHint(self) -> QSize:  # noqa: N802 - Qt's name
        return QSize(_SIZE_PX, _SIZE_PX)

    def show_map(self, name: str, *, is_north_known: bool) -> None:
        """Show a colour map, with compass letters if north is known in the model."""
        self.map_name, self.has_letters = name, is_north_known
        self.update()

    def color_at(self, azimuth_deg: float) -> QColor:
        """Return the colour of a dip direction."""
        table = _table(self.map_name)
        return QColor(*table[int(azimuth_deg % 360.0 / 360.0 * len(table)) % len(table)])

    def paintEvent(self, event: QPaintEvent) -> None:  # noqa: N802
        if not self.map_name:
            return
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        text = self.palette().color(QPalette.ColorRole.WindowText)
        midpoint, radius = QPointF(_SIZE_PX / 2.0, _SIZE_PX / 2.0), _SIZE_PX / 2.0 - 16.0
        # Qt measures angles counterclockwise from the right.
        ring = QConicalGradient(midpoint, 90.0)
        for k in range(_GRADIENT_STOPS + 1):
            ring.setColorAt(k / _GRADIENT_STOPS, self.color_at(-360.0 * k / _GRADIENT_STOPS))
        painter.setPen(QPen(text, 1.0))
        painter.setBrush(ring)
        painter.drawEllipse(midpoint, radius, radius)
        painter.setBrush(self.palette().brush(QPalette.ColorRole.Window))
        painter.drawEllipse(midpoint, 0.5 * radius, 0.5 * radius)
        for k, letter in enumerate(_LETTERS):
            x, y = ((0, -1), (1, 0), (0, 1), (-1, 0))[k]
            centre = midpoint + QPointF(x, y) * (radius + 9.0)
            box = QRectF(centre.x() - 14.0, centre.y() - 8.0, 28.0, 16.0)
            letter_text = tr(letter) if self.has_letters else f"{90 * k}"
            painter.drawText(box, Qt.AlignmentFlag.AlignCenter, letter_text)


@lru_cache(maxsize=4)
def _table(name: str) -> list[tuple[int, int, int]]:
    from vomstudio.rendering.view.scalars import colormap_table

    return [(int(r), int(g), int(b)) for r, g, b in colormap_table(name)]
