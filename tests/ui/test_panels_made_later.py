"""A panel that is made when it is first seen shows what it would have shown had it been there."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from PySide6.QtWidgets import (
    QAbstractButton,
    QComboBox,
    QLabel,
    QLineEdit,
    QTableWidget,
    QTextEdit,
    QWidget,
)

from tests import driver
from tests.geometry.test_brush import grid
from tests.tiers import first_in_default_tier
from tests.ui.conftest import add_bed, add_open_cliff
from vomstudio.project import edits
from vomstudio.ui.shell.work_panels import work_panels

pytestmark = pytest.mark.full

PANELS = {name: make for name, _, make in work_panels()}


def state(panel: QWidget) -> Iterator[tuple[object, ...]]:
    for part in panel.findChildren(QWidget):
        if not part.isVisible():
            continue
        shown = (type(part).__name__, part.objectName(), part.isEnabled())
        match part:
            case QLabel() | QAbstractButton() | QLineEdit():
                yield *shown, part.text(), part.toolTip()
            case QComboBox():
                yield *shown, [part.itemText(i) for i in range(part.count())], part.currentText()
            case QTextEdit():
                yield *shown, part.toPlainText()
            case QTableWidget():
                items = [part.item(i, j) for i in range(part.rowCount()) for j in range(2)]
                yield *shown, [None if item is None else item.text() for item in items]


@pytest.mark.parametrize("name", PANELS)
@pytest.mark.parametrize("notation", first_in_default_tier(["dipdir/dip", "strike/dip"], 1))
def test_lazily_created_panel_shows_the_current_state(
    window, studio, qtbot, name: str, notation: str
) -> None:
    def made() -> QWidget:
        panel = PANELS[name](studio, window.view)
        # It goes with the window, as those in docks do.
        panel.setParent(window)
        return panel

    early = made()
    studio.settings.notation = notation
    studio.settings_changed.emit()
    add_open_cliff(studio, grid(41, 4.0, rough=0.01))
    studio.model_loaded.emit("m1")
    for i in range(4):
        add_bed(studio, f"t{i}", dip=0.3 + 0.2 * i)
    assert studio.attempt(edits.assign_sets, {"t0": "A", "t1": "A"})
    studio.selection.set(["t1"])
    late = made()
    for number, panel in enumerate((early, late)):
        # Side by side: what is covered does not come up to date.
        panel.setGeometry(450 * number, 0, 440, 700)
        panel.show()
        panel.raise_()
    for _ in range(20):
        # Some work things out beside the window.
        driver.pause(200)
        if list(state(late)) == list(state(early)):
            break
    assert list(state(late)) == list(state(early))
