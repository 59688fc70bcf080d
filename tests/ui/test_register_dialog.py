"""A model is registered by a table of points, with the mouse; undo takes it back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QDialogButtonBox, QFileDialog

from vomstudio.document import edits
from vomstudio.document.records import Frame, Model
from vomstudio.ui.shell.register_dialog import RegisterDialog

MODEL = np.array(
    [[0, 0, 0], [9, 0, 0], [0, 8, 1], [3, 2, 7], [5, 6, 0.5], [8, 7, 2], [1, 5, 4]], float
)
WORLD = MODEL[:, [1, 0, 2]] * [-2.0, 2.0, 2.0] + [398_000.0, 4_980_000.0, 320.0]


@pytest.fixture
def dialog(studio, window, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> RegisterDialog:
    """P4 is 3 m wrong."""
    there = WORLD.copy()
    there[4, 0] += 3.0
    rows = [
        ",".join(map(str, (f"P{i}", *a, *b)))
        for i, (a, b) in enumerate(zip(MODEL.tolist(), there.tolist(), strict=True))
    ]
    table = tmp_path / "points.csv"
    table.write_text("\n".join(["label,model_x,model_y,model_z,x,y,z", *rows]))
    model = Model("m9", "cliff", "cliff.obj", "mesh", "0" * 64, Frame("undeclared"))
    studio.attempt(edits.add_model, model)
    studio.selection.set(["m9"])
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_: (str(table), ""))
    window.actions_table.run("register_model")
    (made,) = window.findChildren(RegisterDialog)
    return made


def tick(dialog: RegisterDialog, row: int) -> None:
    """With the mouse, on the box."""
    place = dialog.table.visualItemRect(dialog.table.item(row, 0))
    at = QPoint(place.left() + 12, place.center().y())
    QTest.mouseClick(dialog.table.viewport(), Qt.MouseButton.LeftButton, pos=at)
    QApplication.processEvents()


def press(dialog: RegisterDialog, which: QDialogButtonBox.StandardButton) -> None:
    QTest.mouseClick(dialog.buttons.button(which), Qt.MouseButton.LeftButton)
    QApplication.processEvents()


def test_a_wrong_point_is_named_left_to_judge_and_the_model_placed(studio, dialog) -> None:
    assert "P4" in dialog.said.text()
    tick(dialog, 4)
    assert dialog.table.item(4, 0).checkState() == Qt.CheckState.Unchecked
    assert "P4" not in dialog.said.text()
    # Fitted less given.
    assert dialog.table.item(4, 2).text() == "-3.000"
    assert dialog.table.item(0, 5).text() == "0.000"
    dialog.field.setText("EPSG:32633")
    press(dialog, QDialogButtonBox.StandardButton.Ok)
    model = studio.records["m9"]
    registration = model.registration
    assert registration is not None
    assert registration.method == "points"
    assert model.frame.crs == "EPSG:32633"
    assert [p.label for p in registration.control if p.check] == ["P4"]
    turn = np.array(model.to_world)[:3, :3] / 2.0
    assert turn == pytest.approx(np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]]), abs=1e-6)
    studio.undo()
    assert studio.records["m9"].registration is None


def test_too_few_points_disable_the_button_and_say_why(dialog) -> None:
    for row in range(5):
        tick(dialog, row)
    ok = dialog.buttons.button(QDialogButtonBox.StandardButton.Ok)
    assert not ok.isEnabled()
    assert "at least 3" in ok.toolTip()
    tick(dialog, 0)
    assert ok.isEnabled()
    dialog.field.setText("nowhere at all")
    assert not ok.isEnabled()
    press(dialog, QDialogButtonBox.StandardButton.Cancel)
