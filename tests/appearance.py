"""What a reader sees of a widget: texts that are cut off, hard to read or too small."""

from __future__ import annotations

import re
import time
from collections import Counter
from collections.abc import Iterator

import numpy as np
from PySide6.QtCore import QPoint, QRect, QSize, Qt
from PySide6.QtGui import QFontInfo, QImage, QTextDocument
from PySide6.QtWidgets import (
    QAbstractButton,
    QAbstractItemView,
    QAbstractScrollArea,
    QAbstractSpinBox,
    QApplication,
    QCheckBox,
    QComboBox,
    QGroupBox,
    QHeaderView,
    QLabel,
    QLineEdit,
    QListView,
    QRadioButton,
    QStyle,
    QStyleOptionComboBox,
    QTabBar,
    QToolButton,
    QTreeView,
    QWidget,
)

MIN_CONTRAST = 4.5
"""Of text against its background (WCAG 2.1, 1.4.3)."""
MIN_POINTS = 9.0
_SLACK_PX = 1
_REST_S = 1.0
_ROWS = 4
"""Rows of a list that are looked at."""


def decode_journal_text(widget: QWidget) -> str:
    """The text that a widget shows at the moment, without its mnemonic."""
    if isinstance(widget, QToolButton):
        style = widget.toolButtonStyle()
        has_icon = not widget.icon().isNull()
        if style == Qt.ToolButtonStyle.ToolButtonIconOnly and has_icon:
            return ""
    if isinstance(widget, QLabel):
        text = widget.text() if widget.pixmap().isNull() else ""
        if _is_rich(widget):
            document = QTextDocument()
            document.setHtml(text)
            return document.toPlainText()
        return text
    if isinstance(widget, QAbstractButton):
        return re.sub(r"&(.)", r"\1", widget.text())
    if isinstance(widget, QComboBox):
        return widget.currentText() or widget.placeholderText()
    if isinstance(widget, QAbstractSpinBox):
        return widget.text()
    if isinstance(widget, QLineEdit):
        return widget.text() or widget.placeholderText()
    if isinstance(widget, QGroupBox):
        return re.sub(r"&(.)", r"\1", widget.title())
    return ""


def _is_rich(label: QLabel) -> bool:
    plain = label.textFormat() == Qt.TextFormat.PlainText
    return not plain and "<" in label.text() and ">" in label.text()


_KINDS = (QLabel, QAbstractButton, QComboBox, QAbstractSpinBox, QLineEdit, QGroupBox)


def texts(root: QWidget) -> Iterator[tuple[QWidget, str]]:
    """The visible widgets with text below a widget."""
    for kind in _KINDS:
        for widget in root.findChildren(kind):
            owner = widget.parentWidget()
            if isinstance(owner, QComboBox | QAbstractSpinBox):
                continue
            text = decode_journal_text(widget)
            if text.strip() and widget.isVisible() and not widget.visibleRegion().isEmpty():
                yield widget, text


def cut_off(root: QWidget) -> list[str]:
    """Texts that are not shown whole: wider or higher than their widget, or clipped by a parent."""
    found = []
    for widget, text in texts(root):
        room, needed = _room(widget), _needed(widget, text)
        if room.width() + _SLACK_PX < needed.width() or room.height() + _SLACK_PX < needed.height():
            found.append(f"{_name(widget)} {text[:50]!r}: {_size(needed)} in {_size(room)}")
        elif _is_clipped(widget, root):
            found.append(f"{_name(widget)} {text[:50]!r}: clipped at the side")
    for bar in root.findChildren(QTabBar):
        for i in range(0 if bar.visibleRegion().isEmpty() else bar.count()):
            wide = bar.fontMetrics().horizontalAdvance(re.sub(r"&(.)", r"\1", bar.tabText(i)))
            if bar.tabRect(i).width() < wide + 6:
                found.append(f"tab {bar.tabText(i)!r}: {wide} in {bar.tabRect(i).width()}")
    for tree in root.findChildren(QTreeView):
        if not tree.isVisible() or not tree.isHeaderHidden():
            continue
        # The first column has the names.
        index = tree.indexAt(QPoint(1, 1))
        while index.isValid() and tree.viewport().rect().intersects(tree.visualRect(index)):
            wide, room = tree.sizeHintForIndex(index).width(), tree.visualRect(index).width()
            if room + _SLACK_PX < wide:
                found.append(f"{_name(tree)} {str(index.data())[:40]!r}: {wide} in {room}")
            index = tree.indexBelow(index)
    for header in root.findChildren(QHeaderView):
        model = header.model()
        if header.orientation() != Qt.Orientation.Horizontal or model is None:
            continue
        for i in range(header.count() if header.isVisible() else 0):
            title = str(model.headerData(i, header.orientation()) or "")
            wide = max(map(header.fontMetrics().horizontalAdvance, title.split("\n")))
            if title and not header.isSectionHidden(i) and header.sectionSize(i) < wide + 4:
                found.append(f"{_name(header)} {title!r}: {wide} in {header.sectionSize(i)}")
    return found


def _room(widget: QWidget) -> QSize:
    if isinstance(widget, QComboBox):
        option = QStyleOptionComboBox()
        widget.initStyleOption(option)
        part = QStyle.SubControl.SC_ComboBoxEditField
        kind = QStyle.ComplexControl.CC_ComboBox
        rect = widget.style().subControlRect(kind, option, part, widget)
        return QSize(rect.width(), widget.height())
    if isinstance(widget, QAbstractSpinBox):
        return widget.lineEdit().size()
    return widget.contentsRect().size() if isinstance(widget, QLabel) else widget.size()


def _needed(widget: QWidget, text: str) -> QSize:
    """The smallest size at which the text is shown whole."""
    metrics = widget.fontMetrics()
    if isinstance(widget, QLabel):
        if widget.wordWrap():
            # A single word may be wider than the label.
            words = max(map(metrics.horizontalAdvance, text.split()))
            tall = widget.heightForWidth(widget.width()) - (
                widget.height() - widget.contentsRect().height()
            )
            return QSize(words, tall)
        if not _is_rich(widget):
            lines = text.split("\n")
            return QSize(max(map(metrics.horizontalAdvance, lines)), metrics.height())
        return QSize(widget.sizeHint().width() - 2 * widget.margin(), metrics.height())
    wide = max(map(metrics.horizontalAdvance, text.split("\n")))
    if isinstance(widget, QCheckBox | QRadioButton):
        style = widget.style()
        metric = QStyle.PixelMetric.PM_IndicatorWidth
        wide += style.pixelMetric(metric) + 4
    elif isinstance(widget, QToolButton):
        beside = widget.toolButtonStyle() == Qt.ToolButtonStyle.ToolButtonTextBesideIcon
        if not widget.icon().isNull() and beside:
            wide += widget.iconSize().width() + 4
        wide += 4
    elif isinstance(widget, QAbstractButton) and not widget.icon().isNull():
        wide += widget.iconSize().width() + 4
    elif isinstance(widget, QLineEdit | QAbstractSpinBox):
        # Text of a user is scrolled; a hint is not.
        own = isinstance(widget, QLineEdit) and widget.text()
        wide = 0 if own else wide + 4
    return QSize(wide, metrics.height())


def _is_clipped(widget: QWidget, root: QWidget) -> bool:
    """Whether a parent cuts a widget off at the left or right and cannot be scrolled there."""
    above = widget.parentWidget()
    while above is not None and above is not root.parentWidget():
        left = widget.mapTo(above, QPoint(0, 0)).x()
        if left < -_SLACK_PX or left + widget.width() > above.width() + _SLACK_PX:
            scrolled = above.parentWidget()
            is_scrolled = isinstance(scrolled, QAbstractScrollArea)
            if is_scrolled and scrolled.horizontalScrollBar().maximum() > 0:
                return scrolled.horizontalScrollBarPolicy() == Qt.ScrollBarPolicy.ScrollBarAlwaysOff
            return True
        if above.isWindow():
            break
        above = above.parentWidget()
    return False


def too_small(root: QWidget) -> list[str]:
    """Texts below nine points."""
    return [
        f"{_name(widget)} {text[:40]!r}: {QFontInfo(widget.font()).pointSizeF():.1f} pt"
        for widget, text in texts(root)
        if QFontInfo(widget.font()).pointSizeF() < MIN_POINTS - 0.1
    ]


def pale(root: QWidget) -> list[str]:
    """Texts with less contrast to their background than is required; disabled ones are exempt."""
    image = root.grab().toImage().convertToFormat(QImage.Format.Format_RGB32)
    ratio = image.width() / max(root.width(), 1)
    pixels = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1, 4)
    pixels = pixels[:, : image.width(), 2::-1]
    found = []
    for name, place in _places(root):
        left, top, wide, tall = (round(v * ratio) for v in place.getRect())
        part = pixels[max(top, 0) : top + tall, max(left, 0) : left + wide].reshape(-1, 3)
        if len(part) and (contrast := strongest_contrast(part)) < MIN_CONTRAST:
            found.append(f"{name}: {contrast:.1f}")
    return found


def _places(root: QWidget) -> Iterator[tuple[str, QRect]]:
    """The visible texts with their rectangles on a widget."""
    for widget, text in texts(root):
        if not widget.isEnabled() or isinstance(widget, QGroupBox):
            continue
        seen = widget.visibleRegion().boundingRect()
        if seen.height() < widget.fontMetrics().height():
            continue
        yield (
            f"{_name(widget)} {text[:40]!r}",
            QRect(widget.mapTo(root, seen.topLeft()), seen.size()),
        )
    for view in root.findChildren(QAbstractItemView):
        model = view.model()
        if model is None or not view.isVisible() or not view.isEnabled():
            continue
        for row in range(min(_ROWS, model.rowCount())):
            # The method of list models is private.
            for column in range(model.columnCount() if not isinstance(view, QListView) else 1):
                index = model.index(row, column)
                place = view.visualRect(index)
                if not view.viewport().rect().contains(place):
                    continue
                enabled = bool(index.flags() & Qt.ItemFlag.ItemIsEnabled)
                text = index.data()
                if not enabled or not text or place.width() < 8 or place.height() < 8:
                    continue
                at = view.viewport().mapTo(root, place.topLeft())
                yield f"{_name(view)} {str(text)[:40]!r}", QRect(at, place.size())


def strongest_contrast(pixels: np.ndarray) -> float:
    """Of colours (n, 3) with the most frequent one, the largest contrast ratio (1 to 21)."""
    codes = pixels.astype(np.uint32) @ np.array([65536, 256, 1], np.uint32)
    colors = Counter(codes.tolist())
    ground = colors.most_common(1)[0][0]
    rgb = np.array([[c >> 16, c >> 8 & 255, c & 255] for c in (ground, *colors)]) / 255.0
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    light = linear @ np.array([0.2126, 0.7152, 0.0722]) + 0.05
    return float(max(light[0] / light[1:].min(), light[1:].max() / light[0]))


def _name(widget: QWidget) -> str:
    names = [type(widget).__name__, widget.objectName()]
    above = widget.parentWidget()
    while above is not None and len(names) < 4:
        if above.objectName() and not above.objectName().startswith("qt_"):
            names.append(above.objectName())
        above = above.parentWidget()
    return "/".join(filter(None, names))


def _size(size: QSize) -> str:
    return f"{size.width()} x {size.height()}"


def options(root: QWidget) -> list[str]:
    """Texts that name an option of the command line, which a window does not have."""
    return [
        f"{_name(widget)} {text[:60]!r}"
        for widget, text in texts(root)
        if isinstance(widget, QLabel) and re.search(r"(^|\s)--[a-z]", text)
    ]


def violations(root: QWidget) -> list[str]:
    """Everything on a widget that a reader would complain of, once its layout is at rest."""
    end = time.monotonic() + _REST_S
    QApplication.processEvents()
    while (whole := cut_off(root)) and time.monotonic() < end:
        time.sleep(0.02)
        QApplication.processEvents()
    return [
        *(f"cut off: {each}" for each in whole),
        *(f"small: {each}" for each in too_small(root)),
        *(f"pale: {each}" for each in pale(root)),
        *(f"option: {each}" for each in options(root)),
    ]
