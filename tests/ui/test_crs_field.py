"""The reference system is typed by name and chosen with the keys."""

from __future__ import annotations

from typing import Any

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from vomstudio.ui.widgets.crs_field import CrsField


@pytest.mark.full
def test_crs_is_selected_by_typing_its_name(qtbot: Any) -> None:
    field = CrsField()
    qtbot.addWidget(field)
    field.show()
    qtbot.waitExposed(field)
    field.setFocus()
    told: list[str] = []
    field.textEdited.connect(told.append)
    QTest.keyClicks(field, "wgs 84 utm 33n")
    popup = field.popup
    assert popup.isVisible()
    QTest.keyClick(popup, Qt.Key.Key_Down)
    QTest.keyClick(popup, Qt.Key.Key_Return)
    assert field.text() == "EPSG:32633"
    assert told[-1] == "EPSG:32633"
    assert not popup.isVisible()


def test_complete_crs_code_opens_no_list(qtbot: Any) -> None:
    field = CrsField()
    qtbot.addWidget(field)
    field.show()
    # Other codes begin with this one.
    QTest.keyClicks(field, "EPSG:2154")
    assert field.text() == "EPSG:2154"
    assert not field.popup.isVisible()
