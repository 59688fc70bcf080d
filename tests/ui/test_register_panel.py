"""A model is registered by control points: typed, ticked and left to judge with the mouse, and
undo takes everything back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QFileDialog

from tests import driver
from tests.messages import shown_codes, with_code
from vomstudio.geometry.frames import Frame
from vomstudio.project import edits
from vomstudio.project.kinds.control_point import ControlPoint
from vomstudio.project.records import Model
from vomstudio.studio.tools.interaction_types import Button, Hit, Pointer, PointerEvent
from vomstudio.ui.panels.tools.control import ControlPanel

MODEL = np.array(
    [[0, 0, 0], [9, 0, 0], [0, 8, 1], [3, 2, 7], [5, 6, 0.5], [8, 7, 2], [1, 5, 4]], float
)
WORLD = MODEL[:, [1, 0, 2]] * [-2.0, 2.0, 2.0] + [398_000.0, 4_980_000.0, 320.0]


@pytest.fixture
def panel(studio, window) -> ControlPanel:
    studio.attempt(
        edits.add_model, Model("m9", "cliff", "cliff.obj", "mesh", "0" * 64, Frame("undeclared"))
    )
    studio.selection.set(["m9"])
    window.actions_table.run("register_model")
    assert studio.tool_name == "control"
    (made,) = window.findChildren(ControlPanel)
    made.resize(520, 700)
    return made


def load(panel: ControlPanel, monkeypatch, table: Path, text: str) -> None:
    table.write_text(text)
    monkeypatch.setattr(QFileDialog, "getOpenFileName", lambda *_: (str(table), ""))
    QTest.mouseClick(panel.load, Qt.MouseButton.LeftButton)
    QApplication.processEvents()


def rows(*columns: np.ndarray) -> list[str]:
    return [
        ",".join([f"P{i}", *(repr(float(v)) for c in columns for v in c[i])])
        for i in range(len(columns[0]))
    ]


@pytest.fixture
def pairs(panel, tmp_path, monkeypatch) -> ControlPanel:
    """P4 is 3 m wrong."""
    there = WORLD.copy()
    there[4, 0] += 3.0
    text = "\n".join(["label,model_x,model_y,model_z,x,y,z", *rows(MODEL, there)])
    load(panel, monkeypatch, tmp_path / "points.csv", text)
    return panel


def tick(panel: ControlPanel, row: int) -> None:
    """With the mouse, on the box."""
    panel.table.scrollToItem(panel.table.item(row, 0))
    place = panel.table.visualItemRect(panel.table.item(row, 0))
    at = QPoint(place.left() + 12, place.center().y())
    QTest.mouseClick(panel.table.viewport(), Qt.MouseButton.LeftButton, pos=at)
    QApplication.processEvents()


def click(studio, place) -> None:
    hit = Hit("m9", "face", 0, tuple(map(float, place)))
    studio.pointer(PointerEvent(Pointer.CLICK, 0.0, 0.0, Button.LEFT, hit=hit))


@pytest.mark.full
def test_wrong_point_is_reported_unticked_and_the_model_registered(studio, pairs) -> None:
    assert "P4" in pairs.summary.text()
    tick(pairs, 4)
    assert pairs.table.item(4, 0).checkState() == Qt.CheckState.Unchecked
    assert "P4" not in pairs.summary.text()
    # Fitted less given.
    assert "dx -3.000" in pairs.table.item(4, 5).toolTip()
    assert pairs.table.item(0, 5).text() == "0.000"
    pairs.crs_field.setText("EPSG:32633")
    QTest.mouseClick(pairs.register, Qt.MouseButton.LeftButton)
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
    studio.undo()
    assert not any(p.check for p in studio.session.of(ControlPoint))
    studio.undo()
    assert not studio.session.of(ControlPoint)
    assert pairs.table.rowCount() == 0


def test_points_are_clicked_in_order_and_the_next_position_is_predicted(
    studio, panel, tmp_path, monkeypatch
) -> None:
    shown = []
    studio.preview.connect(shown.append)
    load(panel, monkeypatch, tmp_path / "gcp.txt", "\n".join(["label,x,y,z", *rows(WORLD)]))
    assert [p.vertices for p in studio.session.of(ControlPoint)] == [()] * len(WORLD)
    assert not panel.register.isEnabled()
    for i in range(4):
        assert f"P{i}" in studio.tool.hint()
        click(studio, MODEL[i])
    assert panel.register.isEnabled()
    # The model stands as its file has it; there is P4, as the first four say.
    assert shown[-1].brush.centre == pytest.approx(MODEL[4], abs=1e-6)
    assert "ring" in studio.tool.hint()
    studio.undo()
    assert [bool(p.vertices) for p in studio.session.of(ControlPoint)] == [True] * 3 + [False] * 4
    # Another point may be found first.
    panel.table.selectRow(6)
    click(studio, MODEL[6])
    assert studio.session.of(ControlPoint)[6].vertices == (tuple(MODEL[6]),)


@pytest.mark.full
def test_reloading_a_table_updates_coordinates_and_keeps_clicked_positions(
    studio, panel, tmp_path, monkeypatch
) -> None:
    load(panel, monkeypatch, tmp_path / "gcp.csv", "\n".join(["label,x,y,z", *rows(WORLD)]))
    click(studio, MODEL[0])
    load(panel, monkeypatch, tmp_path / "gcp.csv", "\n".join(["label,x,y,z", *rows(WORLD + 1.0)]))
    first, *others = studio.session.of(ControlPoint)
    assert len(others) == len(WORLD) - 1
    assert first.vertices == (tuple(MODEL[0]),)
    assert first.position == pytest.approx(tuple(WORLD[0] + 1.0))


def test_click_without_a_table_adds_a_point_for_typed_coordinates(studio, panel) -> None:
    click(studio, MODEL[0])
    (point,) = studio.session.of(ControlPoint)
    assert (point.name, point.position) == ("C01", None)
    assert "control.coordinates-missing" in shown_codes(panel.summary.text())
    # The next click is another point; one that is chosen in the list is moved.
    click(studio, MODEL[1])
    assert [p.name for p in studio.session.of(ControlPoint)] == ["C01", "C02"]
    panel.table.selectRow(1)
    click(studio, MODEL[2])
    assert [p.vertices for p in studio.session.of(ControlPoint)] == [
        (tuple(MODEL[0]),),
        (tuple(MODEL[2]),),
    ]
    for column, text in enumerate(("398000", "4980000", "no", "nan", "1e30"), 2):
        panel.table.item(0, min(column, 4)).setText(text)
        assert studio.session.of(ControlPoint)[0].position is None
    assert panel.table.coordinates(0) == ["398000", "4980000", ""]
    panel.table.item(0, 4).setText("320,5")
    assert studio.session.of(ControlPoint)[0].position == (398000.0, 4980000.0, 320.5)
    for text in ("nan", "1e30", "x"):
        panel.table.item(0, 4).setText(text)
        assert studio.session.of(ControlPoint)[0].position == (398000.0, 4980000.0, 320.5)
        assert panel.table.coordinates(0)[2] != text


@pytest.mark.full
def test_disabled_register_button_states_its_reason(pairs) -> None:
    for row in range(5):
        tick(pairs, row)
    assert not pairs.register.isEnabled()
    assert "at least 3" in pairs.register.toolTip()
    tick(pairs, 0)
    assert pairs.register.isEnabled()
    pairs.crs_field.setText("nowhere at all")
    assert not pairs.register.isEnabled()


@pytest.mark.full
def test_coordinates_outside_their_crs_area_are_reported(pairs) -> None:
    pairs.crs_field.setText("EPSG:32633")
    inside = pairs.summary.text()
    # The British grid ends at 1,300 km north.
    pairs.crs_field.setText("EPSG:27700")
    more = [line for line in pairs.summary.text().splitlines() if line not in inside]
    assert any("27700" in line or "British" in line for line in more)


def test_a_file_without_points_changes_nothing(studio, panel, tmp_path, monkeypatch) -> None:
    told: list[str] = []
    studio.workspace.notices.posted.connect(lambda notice: told.append(notice.text))
    load(panel, monkeypatch, tmp_path / "gcp.csv", "label,x,y,z\nP0,1,2,high\n")
    assert "gcp.csv" in told[-1]
    assert "line 2" in told[-1]
    assert not studio.session.of(ControlPoint)


@pytest.mark.full
def test_many_points_are_registered_in_the_background(studio, panel, tmp_path, monkeypatch) -> None:
    """Two hundred took a quarter of a second at every tick, a thousand four seconds."""
    rng = np.random.default_rng(3)
    model = rng.uniform(0.0, 30.0, (200, 3))
    world = model[:, [1, 0, 2]] * [-2.0, 2.0, 2.0] + [398_000.0, 4_980_000.0, 320.0]
    world[4, 0] += 3.0
    text = "\n".join(["label,model_x,model_y,model_z,x,y,z", *rows(model, world)])
    load(panel, monkeypatch, tmp_path / "points.csv", text)
    driver.wait(lambda: panel.register.isEnabled(), "the placement")
    assert "P4" in panel.summary.text()
    assert panel.table.item(3, 5).text()
    for row in (4, 5):
        tick(panel, row)
    # The placement by other points is not offered meanwhile.
    assert not panel.register.isEnabled()
    assert "registration.pending" in shown_codes(panel.register.toolTip())
    driver.wait(lambda: panel.register.isEnabled(), "the placement")
    assert len(panel.placed.control) == 198
    assert "P4" not in panel.summary.text()
    QTest.mouseClick(panel.register, Qt.MouseButton.LeftButton)
    assert [p.label for p in studio.records["m9"].registration.control if p.check] == ["P4", "P5"]


@pytest.mark.full
def test_keep_scale_option_keeps_the_model_scale(studio, pairs) -> None:
    tick(pairs, 4)
    assert pairs.placed is not None
    assert pairs.placed.scale == pytest.approx(2.0)
    box = pairs.options.fields["keep_scale"]
    QTest.mouseClick(box, Qt.MouseButton.LeftButton, pos=QPoint(8, box.height() // 2))
    assert box.isChecked()
    assert pairs.placed.scale == pytest.approx(1.0, abs=1e-3)
    # The points are twice as far from each other.
    (finding,) = with_code(pairs.placed.warnings, "registration.scale-contradicted")
    assert finding.values["times"] == pytest.approx(2.0)
    assert finding.message in pairs.summary.text()
    QTest.mouseClick(pairs.register, Qt.MouseButton.LeftButton)
    model = studio.records["m9"]
    assert model.registration is not None
    assert model.registration.scale_error == pytest.approx(1e-4, rel=0.5)
    matrix = np.array(model.to_world)[:3, :3]
    assert np.linalg.det(matrix) == pytest.approx(1.0, abs=1e-2)
    studio.undo()
    assert studio.records["m9"].registration is None


@pytest.mark.full
def test_typed_click_error_affects_the_stated_errors_and_is_stored(studio, pairs) -> None:
    tick(pairs, 4)
    errors, field = [], pairs.options.fields["click_sigma_m"]
    for typed in ("0.01", "0,2"):
        field.selectAll()
        QTest.keyClicks(field, typed)
        QTest.keyClick(field, Qt.Key.Key_Return)
        QTest.mouseClick(pairs.register, Qt.MouseButton.LeftButton)
        registration = studio.records["m9"].registration
        assert registration.click_sigma_m == pytest.approx(float(typed.replace(",", ".")))
        errors.append(max(registration.rotation_error_deg))
    assert errors[1] > 2.0 * errors[0]
