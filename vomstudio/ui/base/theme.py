"""Theme, icons, badges and sizes that are shared by all panels."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from weakref import WeakSet

from PySide6.QtCore import QObject, QPoint, QPointF, QRect, QRectF, QSize, Qt, QTimer
from PySide6.QtGui import (
    QColor,
    QFont,
    QFontDatabase,
    QIcon,
    QIconEngine,
    QPainter,
    QPalette,
    QPen,
    QPixmap,
    QPixmapCache,
    QPolygonF,
)
from PySide6.QtWidgets import QApplication, QWidget
from shiboken6 import isValid

from vomstudio.core.files.regular import read_small_text
from vomstudio.core.words import to_translate
from vomstudio.ui.base.flat_style import FlatStyle

_FRAMED_WIDGETS = (
    "QCheckBox",
    "QRadioButton",
    "QLineEdit",
    "QAbstractSpinBox",
    "QTreeView",
    "QTableView",
    "QListView",
)
_INNER_WIDGETS = ("QHeaderView", "QScrollBar")
"""Child widgets of lists, which would inherit the colours of the list."""
_FRAME_COLOR = "#8f8f8f"
_SCHEMES = {"light": Qt.ColorScheme.Light, "dark": Qt.ColorScheme.Dark}


def use(name: str) -> None:
    """Apply a colour scheme, and the style of the program on the first call.

    Parameters
    ----------
    name : str
        "light", "dark" or "system".
    """
    application = QApplication.instance()
    assert isinstance(application, QApplication)
    if not application.property("styled"):
        application.setProperty("styled", True)
        application.setStyle(FlatStyle())
        # Qt changes its palette after this signal.
        application.styleHints().colorSchemeChanged.connect(
            lambda _: QTimer.singleShot(0, _apply_palette)
        )
    application.setProperty("theme", name)
    application.styleHints().setColorScheme(_SCHEMES.get(name, Qt.ColorScheme.Unknown))
    _apply_palette()


def _apply_palette() -> None:
    """Apply the palette of the chosen theme, which is the same on every desktop."""
    application = QApplication.instance()
    if not isinstance(application, QApplication):
        return
    name = application.property("theme")
    application.setPalette(QPalette())
    # Not every desktop reports a colour scheme or supports one per program.
    application.setPalette(_palette(is_dark() if name not in _SCHEMES else name == "dark"))
    _outline_boxes()
    for styler in list(_TOGGLE_STYLERS):
        if isValid(styler):
            styler.update_style_sheet()


def _outline_boxes() -> None:
    """Make the frames of boxes and fields visible in a dark scheme.

    Fusion derives the frame from a darker shade of the window colour, so these widgets get a
    lighter window colour.
    """
    role = QPalette.ColorRole.Window
    window = QApplication.palette().color(role)
    for widget_classes, color in (
        (_INNER_WIDGETS, window),
        (_FRAMED_WIDGETS, QColor(_FRAME_COLOR) if is_dark() else window),
    ):
        palette = QPalette(QApplication.palette())
        palette.setColor(role, color)
        for widget_class in widget_classes:
            # The method accepts a name, although its type stub does not.
            QApplication.setPalette(palette, widget_class)  # type: ignore[arg-type]


def is_dark() -> bool:
    """Return whether the scheme is dark, with texts lighter than their background."""
    palette = QApplication.palette()
    text, background = QPalette.ColorRole.WindowText, QPalette.ColorRole.Window
    return palette.color(text).lightness() > palette.color(background).lightness()


def _palette(is_dark: bool) -> QPalette:
    """Return the palette of a scheme; Qt derives the other colours."""
    button, window = ("#454545", "#323232") if is_dark else ("#fafafa", "#efefef")
    palette = QPalette(QColor(button), QColor(window))
    role, group = QPalette.ColorRole, QPalette.ColorGroup
    for item, color in (
        (role.Base, "#242424" if is_dark else "#ffffff"),
        (role.AlternateBase, "#2b2b2b" if is_dark else "#f7f7f7"),
        (role.Highlight, "#2f6ea8" if is_dark else "#0072b2"),
        (role.Accent, "#56b4e9" if is_dark else "#0072b2"),
        (role.HighlightedText, "#ffffff"),
        (role.Link, "#7db8ef" if is_dark else "#0057ae"),
        (role.ToolTipBase, "#4a4a4a" if is_dark else "#ffffdc"),
        (role.ToolTipText, "#ffffff" if is_dark else "#000000"),
        (role.PlaceholderText, "#b4b4b4" if is_dark else "#5c5c5c"),
    ):
        palette.setColor(item, QColor(color))
    for item in (role.Text, role.WindowText, role.ButtonText):
        palette.setColor(group.Disabled, item, QColor("#8c8c8c"))
    return palette


def error_color() -> QColor:
    """Return the colour of texts that report an error, readable in both schemes."""
    return QColor("#ff9a57" if is_dark() else "#b04a00")


def paper_palette() -> QPalette:
    """Return the palette of pages that look like paper in every theme, such as reports."""
    return _palette(False)


def toggle_style_sheet() -> str:
    """Return a style sheet that highlights checked buttons in the current colour scheme.

    Checked buttons have a blue fill and frame (Okabe-Ito); texts and icons keep their contrast.
    """
    fill, frame, hover = (
        ("#1d5078", "#56b4e9", "#4a4a4a") if is_dark() else ("#bfdcf2", "#0072b2", "#dedede")
    )
    return (
        "QToolBar QToolButton { border: 1px solid transparent; border-radius: 3px; padding: 3px; }"
        f"QToolBar QToolButton:hover {{ background: {hover}; }}"
        "QToolBar QToolButton[popupMode='2'] { padding-right: 16px; }"
        "QToolBar QToolButton::menu-indicator"
        " { subcontrol-origin: padding; subcontrol-position: right center; right: 3px; }"
        "QToolButton:checked, QPushButton:checked, QToolBar QToolButton:checked {"
        f" background: {fill}; border: 1px solid {frame}; border-radius: 3px; padding: 3px; }}"
        # A widget with a style sheet draws no focus frame of its own.
        "QToolButton:focus, QPushButton:focus, QToolBar QToolButton:focus {"
        f" border: 2px solid {frame}; border-radius: 3px; padding: 2px; }}"
    )


_TOGGLE_STYLERS: WeakSet[_ToggleStyler] = WeakSet()


class _ToggleStyler(QObject):
    """Object that keeps the style sheet of a widget consistent with the theme."""

    def __init__(self, widget: QWidget) -> None:
        super().__init__(widget)
        self._widget, self._style_sheet = widget, ""
        # A widget with its own style sheet does not receive palette changes.
        QApplication.styleHints().colorSchemeChanged.connect(self.update_style_sheet)
        _TOGGLE_STYLERS.add(self)
        self.update_style_sheet()

    def update_style_sheet(self, *_: object) -> None:
        sheet = toggle_style_sheet()
        if sheet != self._style_sheet:
            self._style_sheet = sheet
            self._widget.setStyleSheet(sheet)


def highlight_toggles(widget: QWidget) -> None:
    """Highlight a button, or the buttons of a bar, while checked, in every theme.

    A style sheet of the whole window would slow down every panel.
    """
    _ToggleStyler(widget)


class _PaletteIcon(QIconEngine):
    """Material Design icon in a colour of the palette, which follows the theme."""

    def __init__(self, name: str) -> None:
        super().__init__()
        self._name = name

    def paint(self, painter: QPainter, rect: QRect, mode: QIcon.Mode, state: QIcon.State) -> None:
        palette = QApplication.palette()
        if mode == QIcon.Mode.Disabled:
            color = palette.color(QPalette.ColorGroup.Disabled, QPalette.ColorRole.ButtonText)
        elif mode == QIcon.Mode.Selected:
            color = palette.color(QPalette.ColorRole.HighlightedText)
        else:
            color = palette.color(QPalette.ColorRole.ButtonText)
        _draw_glyph(painter, rect, self._name, color)

    def pixmap(self, size: QSize, mode: QIcon.Mode, state: QIcon.State) -> QPixmap:
        pixmap = QPixmap(size)
        pixmap.fill(Qt.GlobalColor.transparent)
        painter = QPainter(pixmap)
        self.paint(painter, QRect(QPoint(0, 0), size), mode, state)
        painter.end()
        return pixmap


@lru_cache(maxsize=1)
def _glyphs() -> tuple[str, dict[str, str]]:
    """Return the font family of the Material Design icons, and their code points by name.

    The files are those of QtAwesome, which would load eight such fonts and take 0.25 s at each
    start.
    """
    package = find_spec("qtawesome")
    assert package is not None
    assert package.origin is not None
    folder = Path(package.origin).parent / "fonts"
    font_file = next(folder.glob("materialdesignicons6-webfont-[0-9]*.ttf"))
    charmap_file = next(folder.glob("materialdesignicons6-webfont-charmap-*.json"))
    font_id = QFontDatabase.addApplicationFont(str(font_file))
    codes: dict[str, str] = json.loads(read_small_text(charmap_file))
    return QFontDatabase.applicationFontFamilies(font_id)[0], codes


def _draw_glyph(painter: QPainter, rect: QRect, name: str, color: QColor) -> None:
    family, codes = _glyphs()
    font = QFont(family)
    # Size of a glyph in its box as in QtAwesome, which leaves a margin.
    font.setPixelSize(max(1, round(0.875 * rect.height())))
    painter.save()
    painter.setFont(font)
    painter.setPen(color)
    painter.drawText(rect, Qt.AlignmentFlag.AlignCenter, chr(int(codes[name], 16)))
    painter.restore()


def icon(name: str) -> QIcon:
    """Return a Material Design icon in the text colour of the palette."""
    return QIcon(_PaletteIcon(name))


def verdict_icon(verdict: str | None) -> QIcon:
    """Return a green circle, amber triangle or red square; the icon of None is empty."""

    def draw(painter: QPainter) -> None:
        if verdict is not None:
            from vomstudio.rendering.qt.painting import draw_verdict_shape

            draw_verdict_shape(painter, QRectF(4, 4, 24, 24), verdict)

    return _create_icon(f"verdict {verdict}", draw)


def picture_icon(path: str | None, size: QSize) -> QIcon:
    """Return an image file as an icon, centred in a box so that adjacent texts are aligned.

    Qt stretches an icon that is created from the name of a JPEG file.
    """
    box = QPixmap(size)
    box.fill(Qt.GlobalColor.transparent)
    picture = QPixmap(path or "")
    if not picture.isNull():
        mode = Qt.TransformationMode.SmoothTransformation
        picture = picture.scaled(size, Qt.AspectRatioMode.KeepAspectRatio, mode)
        painter = QPainter(box)
        offset = (size - picture.size()) / 2
        painter.drawPixmap(offset.width(), offset.height(), picture)
        painter.end()
    icon = QIcon(box)
    # A selected row must not tint it.
    icon.addPixmap(box, QIcon.Mode.Selected)
    return icon


def swatch(color: str) -> QIcon:
    """Return a small disc in the colour of a feature type."""

    def draw(painter: QPainter) -> None:
        painter.setBrush(QColor(color))
        painter.setPen(QPen(QColor(0, 0, 0, 140), 1.5))
        painter.drawEllipse(QPointF(16, 16), 11, 11)

    return _create_icon(f"swatch {color}", draw)


def type_icon(color: str, symbol: str) -> QIcon:
    """Return the symbol of a feature type in its colour, as in the net and the legend."""

    def draw(painter: QPainter) -> None:
        painter.setBrush(QColor(color))
        painter.setPen(QPen(QColor(0, 0, 0, 140), 1.5))
        corners = _CORNERS.get(symbol)
        if corners is None:
            painter.drawEllipse(QPointF(16, 16), 11, 11)
            return
        count, start_deg, inner_ratio = corners
        radii = (13.5, 13.5 * inner_ratio) if inner_ratio else (13.5,)
        steps = count * len(radii)
        painter.drawPolygon(
            QPolygonF(
                [
                    QPointF(
                        16 + radii[k % len(radii)] * math.cos(angle),
                        16 - radii[k % len(radii)] * math.sin(angle),
                    )
                    for k in range(steps)
                    for angle in (math.radians(start_deg + 360.0 * k / steps),)
                ]
            )
        )

    return _create_icon(f"type {color} {symbol}", draw)


# Number of corners, angle of the first corner, and radius ratio of the inner corners.
_CORNERS: dict[str, tuple[int, float, float]] = {
    "square": (4, 45.0, 0.0),
    "triangle": (3, 90.0, 0.0),
    "diamond": (4, 90.0, 0.0),
    "pentagon": (5, 90.0, 0.0),
    "star": (5, 90.0, 0.42),
}
SYMBOLS: tuple[str, ...] = ("circle", *_CORNERS)

# Palette of Okabe and Ito (2008) with its grey, which colour-blind readers can distinguish.
COLORS: tuple[tuple[str, str], ...] = (
    (to_translate("Blue"), "#0072b2"),
    (to_translate("Vermilion"), "#d55e00"),
    (to_translate("Green"), "#009e73"),
    (to_translate("Purple"), "#cc79a7"),
    (to_translate("Sky blue"), "#56b4e9"),
    (to_translate("Orange"), "#e69f00"),
    (to_translate("Yellow"), "#f0e442"),
    (to_translate("Grey"), "#999999"),
)


def _create_icon(key: str, draw: Callable[[QPainter], None]) -> QIcon:
    """Draw an icon once and cache it, because tables request their icons at every repaint."""
    pixmap = QPixmap()
    if not QPixmapCache.find(f"vomstudio {key}", pixmap):
        pixmap = QPixmap(QSize(32, 32))
        pixmap.fill(Qt.GlobalColor.transparent)
        painter = QPainter(pixmap)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        draw(painter)
        painter.end()
        QPixmapCache.insert(f"vomstudio {key}", pixmap)
    icon = QIcon(pixmap)
    # A selected row must not tint it, because the colour is the information.
    icon.addPixmap(pixmap, QIcon.Mode.Selected)
    return icon


def enlarge_small_font(application: QApplication) -> None:
    """Set the font size of the program to at least 9 points."""
    font: QFont = application.font()
    if font.pointSizeF() < 9.0:
        font.setPointSizeF(9.0)
        application.setFont(font)
