"""What can be opened is told whole, however little room there is."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QPoint
from PySide6.QtWidgets import QLabel, QScrollArea, QToolButton, QWidget

from tests.tiers import first_in_default_tier


@pytest.mark.parametrize("points", first_in_default_tier([9.0, 16.0]))
@pytest.mark.parametrize("wide", first_in_default_tier([330, 440, 900]))
def test_start_page_texts_are_not_truncated(window, qtbot, wide, points):
    page = window.start_page
    place = QWidget(window)
    place.resize(1000, 700)
    page.setParent(place)
    page.setVisible(True)
    page.place_over(place)
    font = page.font()
    font.setPointSizeF(points)
    page.setFont(font)
    place.show()
    place.resize(wide, 600)
    qtbot.wait(50)
    assert page.width() <= wide
    area = page.findChild(QScrollArea)
    shown = [w for w in page.findChildren(QWidget) if isinstance(w, QLabel | QToolButton)]
    shown = [w for w in shown if w.isVisible()]
    assert len(shown) > 5
    for widget in shown:
        left = widget.mapTo(area.viewport(), QPoint(0, 0)).x()
        assert left >= 0
        assert left + widget.width() <= area.viewport().width(), widget.text()
        if isinstance(widget, QToolButton) or not widget.wordWrap():
            assert widget.sizeHint().width() <= widget.width(), widget.text()
        else:
            assert widget.heightForWidth(widget.width()) <= widget.height(), widget.text()
