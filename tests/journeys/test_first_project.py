"""From an outcrop to a table, with mouse and keyboard, in the window that people use."""

from __future__ import annotations

import csv
import io
import re
import sqlite3
import subprocess
import sys

import numpy as np
import pytest
from PySide6.QtCore import QItemSelectionModel, QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLineEdit, QMessageBox

from tests import driver
from tests.driver import click, drag, focus, key, look_at, pick, pixel, traces, wait
from vomstudio.core.findings import Finding
from vomstudio.project.kinds.trace import Trace
from vomstudio.studio.tools.trace import TraceTool

pytestmark = pytest.mark.full

BEDS = ("B01", "B04", "B07")


def angle_between(a: tuple[float, float], b: tuple[float, float]) -> float:
    """Degrees between two planes given as dip direction and dip."""
    normals = []
    for dd, dip in (a, b):
        dd_rad, dip_rad = np.radians([dd, dip])
        normals.append(
            np.array(
                [
                    np.sin(dd_rad) * np.sin(dip_rad),
                    np.cos(dd_rad) * np.sin(dip_rad),
                    np.cos(dip_rad),
                ]
            )
        )
    return float(np.degrees(np.arccos(min(1.0, abs(normals[0] @ normals[1])))))


def well_seen(window, points: np.ndarray) -> np.ndarray:
    """The picks that stand clear of the model's edge and of each other on the screen."""
    look_at(window, points, 0.0, 10.0)
    pixels, seen = window.viewport.project(points)
    chosen: list[int] = []
    for i in range(len(points)):
        hit = window.viewport.pick(round(pixels[i, 0]), round(pixels[i, 1]))
        if not seen[i] or hit is None:
            continue
        if np.linalg.norm(window.viewport.world_position(hit) - points[i]) > 0.03:
            continue
        if all(np.hypot(*(pixels[i] - pixels[j])) > 14 for j in chosen):
            chosen.append(i)
    return points[chosen]


def reading(window) -> tuple[str, ...]:
    preview = window.viewport.preview
    return () if preview is None else preview.reading


def test_the_model_is_turned_while_its_frame_is_declared(own_folders, qtbot, outcrop):
    window = driver.make_window()
    window.open_path(outcrop)
    wait(lambda: driver.dialog_of(window), "the frame dialog")
    driver.settled(window)
    dialog = driver.dialog_of(window)
    dialog.move(0, 0)
    before = window.viewport.camera.position
    middle = window.viewport.rect().center()
    drag(window.viewport, middle, middle + QPoint(120, 40))
    assert np.linalg.norm(np.subtract(window.viewport.camera.position, before)) > 0.5
    assert driver.dialog_of(window) is dialog
    driver.declare(window)
    assert driver.model(window).frame.crs == "EPSG:32633"
    # Another project has no use for it.
    window.actions_table.run("declare_frame")
    wait(lambda: driver.dialog_of(window), "the frame dialog")
    window.studio.new_project()
    wait(lambda: driver.dialog_of(window) is None, "the end of the frame dialog")
    driver.dismiss(window)


def test_a_geologists_first_project(own_folders, qtbot, outcrop, picks, truth, tmp_path):
    window = driver.make_window()
    studio, viewport = window.studio, window.viewport
    assert window.start_page.isVisible()
    driver.keep_picture(window, "journey-1-empty")

    # Open, and say where the model stands.
    window.open_path(outcrop)
    wait(lambda: driver.dialog_of(window), "the frame dialog")
    driver.keep_picture(driver.dialog_of(window), "journey-2-frame")
    assert "not registered" in window.status_line._badge.text()
    driver.declare(window)
    driver.settled(window)
    assert driver.model(window).frame.crs == "EPSG:32633"
    assert window.status_line._badge.text() == "EPSG:32633, grid north"
    assert not window.start_page.isVisible()

    # Three traces, each clicked along the bed.
    key(window, Qt.Key.Key_T)
    assert studio.tool_name == "trace"
    for count, name in enumerate(BEDS, 1):
        points = well_seen(window, picks[name])
        assert len(points) >= 8
        pick(window, points[:2])
        assert reading(window)[0].startswith("2 points")
        pick(window, points[2:])
        driver.move(viewport, pixel(window, points[3]) + QPoint(20, 20))
        assert len(studio.get_tool(TraceTool).vertices) == len(points)
        assert " ± " in reading(window)[0]
        assert "EPSG" in window.status_line._badge.text()
        assert window.status_line._position.text().startswith("E 372")
        if count == 1:
            driver.keep_picture(window, "journey-3-picking")
        key(window, Qt.Key.Key_Return)
        assert len(traces(window)) == count
        assert not studio.get_tool(TraceTool).is_open
    assert [t.name for t in traces(window)] == ["B01", "B02", "B03"]
    measured = studio.measured(t.id for t in traces(window))
    for trace, name in zip(traces(window), BEDS, strict=True):
        fit = measured[trace.id].fit
        off = angle_between((fit.dip_direction_deg, fit.dip_deg), truth[name])
        assert off <= fit.max_confidence95_deg, f"{name}: {off} of {fit.max_confidence95_deg}"

    # Correct a trace: move, insert, delete, take back, give up.
    first = traces(window)[0]
    studio.selection.set([first.id])
    points = np.array(measured[first.id].points)
    look_at(window, points, 0.0, 10.0)
    window.actions_table.all["edit_feature"].trigger()
    focus(window)
    tool = studio.get_tool(TraceTool)
    assert tool.is_open
    assert tool.is_continued
    start = pixel(window, points[2])
    before = tool.vertices
    drag(viewport, start, start + QPoint(0, 14))
    assert len(tool.vertices) == len(before)
    moved = [i for i in range(len(before)) if before[i] != tool.vertices[i]]
    assert moved == [2]
    hit = viewport.pick(start.x(), start.y() + 14)
    assert tool.vertices[2] == hit.position
    key(window, Qt.Key.Key_Backspace)
    assert tool.vertices == before
    between = pixel(window, (points[4] + points[5]) / 2) + QPoint(0, 4)
    assert viewport.gestures.handle_at(between.x(), between.y()) is None
    click(viewport, between, driver.CTRL)
    assert len(tool.vertices) == len(before) + 1
    assert tool.vertices[:5] == before[:5]
    assert tool.vertices[6:] == before[5:]
    click(viewport, pixel(window, points[7]))
    assert tool.current_vertex is not None
    marked = tool.vertices[tool.current_vertex]
    key(window, Qt.Key.Key_Delete)
    assert marked not in tool.vertices
    assert len(tool.vertices) == len(before)
    key(window, Qt.Key.Key_Backspace)
    key(window, Qt.Key.Key_Backspace)
    assert tool.vertices == before
    key(window, Qt.Key.Key_Escape)
    assert not tool.is_open
    assert traces(window)[0] == first

    # Undo and redo.
    kept = {t.id: t for t in traces(window)}
    key(window, Qt.Key.Key_Z, driver.CTRL)
    assert len(traces(window)) == 2
    assert window.table.model.rowCount() == 2
    key(window, Qt.Key.Key_Z, driver.CTRL | Qt.KeyboardModifier.ShiftModifier)
    assert {t.id: t for t in traces(window)} == kept
    assert window.windowTitle().startswith("untitled*")

    # Select on the net: the same plane everywhere.
    key(window, Qt.Key.Key_N)
    key(window, Qt.Key.Key_Home)
    wait(lambda: window.net.is_up_to_date, "the net")
    second = traces(window)[1]
    click_pole(window, second.id)
    assert studio.selection.ids == (second.id,)
    assert window.tree._items[second.id].isSelected()
    assert chosen_rows(window) == [second.id]
    assert window.viewport.features.selected == frozenset({second.id})
    assert window.properties.fields["name"].text() == "B02"
    wait(lambda: viewport.scene.picture.is_complete, "the picture")
    driver.keep_picture(window, "journey-4-selected")

    # Rename in the table, by typing.
    view, model = window.table.view, window.table._sorted_rows
    row = next(r for r in range(model.rowCount()) if model.index(r, 0).data() == "B02")
    index = model.index(row, 0)
    view.setFocus()
    view.selectionModel().setCurrentIndex(
        index,
        QItemSelectionModel.SelectionFlag.ClearAndSelect | QItemSelectionModel.SelectionFlag.Rows,
    )
    view.edit(index)
    editor = view.findChild(QLineEdit)
    assert editor is not None
    editor.selectAll()
    name = "top of T bed"
    QTest.keyClicks(editor, name)
    QTest.keyClick(editor, Qt.Key.Key_Return)
    wait(lambda: studio.records[second.id].name == name, "the new name", 5.0)
    assert studio.tool_name == "navigate", "typing a T into a name chose the trace tool"
    assert window.tree._items[second.id].text(0) == name

    # Save, export, close.
    folder = tmp_path / "cliff.vom"
    studio.save_as(folder)
    assert not studio.session.dirty
    assert window.windowTitle() == "cliff – VOM Studio"
    table = shown_table(window)
    records = {t.id: t for t in traces(window)}
    window.files.export_features("csv", tmp_path / "out.csv")
    window.files.export_features("gpkg", tmp_path / "out.gpkg")
    wait(lambda: (folder / "project.gpkg").is_file(), "the project's GIS layers")
    camera = viewport.moves.camera_state()
    driver.close(window)

    # Reopen.
    window = driver.make_window([folder])
    driver.settled(window)
    driver.pause(600)
    seen = window.viewport.moves.camera_state()
    assert seen.keys() == camera.keys()
    for part, value in camera.items():
        assert np.allclose(seen[part], value, rtol=1e-12, atol=1e-12), f"not as it was left: {part}"
    assert {t.id: t for t in traces(window)} == records
    assert shown_table(window) == table
    assert window.windowTitle() == "cliff – VOM Studio"
    assert window.actions_table.all["undo"].isEnabled(), "history reaches past the reopening"
    driver.keep_picture(window, "journey-5-reopened")
    driver.dismiss(window)

    # What came out is what was on the screen, and what the command line says.
    rows = read_csv((tmp_path / "out.csv").read_text(encoding="utf-8"))
    assert [r["name"] for r in rows] == [t.name for t in records.values()]
    assert [r["id"] for r in rows] == list(records)
    for row in rows:
        cells = table[row["name"]]
        shown = re.fullmatch(r"(\d+\.?\d*)/(\d+\.?\d*) ± (\d+\.?\d*)°", cells["Orientation"])
        names = ("dip_direction_deg", "dip_deg", "total95_deg")
        for text, name in zip(shown.groups(), names, strict=True):
            decimals = len(text.partition(".")[2])
            assert text.lstrip("0") == f"{float(row[name]):.{decimals}f}".lstrip("0")
        assert cells["Quality"] == row["quality"]
        assert cells["n"] == row["n_points"]
        assert cells["95 % error"].startswith(f"{float(row['total95_deg']):.1f}"[:2])
    for format_ in ("csv", "gpkg"):
        done = subprocess.run(
            [
                sys.executable,
                "-m",
                "vomstudio",
                "export",
                str(folder),
                "--to",
                format_,
                "--output",
                str(tmp_path / f"again.{format_}"),
            ],
            capture_output=True,
            text=True,
            timeout=120,
        )
        assert done.returncode == 0, done.stderr
    again = read_csv((tmp_path / "again.csv").read_text(encoding="utf-8"))
    assert again == rows
    for name in ("out.gpkg", "again.gpkg"):
        db = sqlite3.connect(tmp_path / name)
        layers = {
            layer: db.execute(f"SELECT id, name FROM {layer}").fetchall()
            for layer in ("planes", "traces")
        }
        db.close()
        expected = [(t.id, t.name) for t in records.values()]
        assert layers == {"planes": expected, "traces": expected}


def read_csv(text: str) -> list[dict[str, str]]:
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    return list(csv.DictReader(io.StringIO("\n".join(lines))))


def shown_table(window) -> dict[str, dict[str, str]]:
    """The cells of the orientation table by name and column title."""
    model = window.table._sorted_rows
    titles = [model.headerData(c, Qt.Orientation.Horizontal) for c in range(model.columnCount())]
    rows = [
        {title: str(model.index(r, c).data()) for c, title in enumerate(titles)}
        for r in range(model.rowCount())
    ]
    return {row["Name"]: row for row in rows}


def chosen_rows(window) -> list[str]:
    panel = window.table
    return [
        panel.model.id_at(panel._sorted_rows.mapToSource(i).row())
        for i in panel.view.selectionModel().selectedRows()
    ]


def click_pole(window, id_: str) -> None:
    """Click where the net has drawn the pole of a plane."""
    net = window.net
    x, y = pole_at(net, id_)
    ratio = net.canvas.devicePixelRatioF()
    click(net.canvas, QPoint(round(x / ratio), round(net.canvas.height() - y / ratio)))


def pole_at(net, id_: str) -> tuple[float, float]:
    from vomstudio.geology import stereonet

    for each in net.contents().sets:
        if id_ in each.ids:
            i = each.ids.index(id_)
            dd, dip = np.radians([each.azimuth_deg[i], each.angle_deg[i]])
            pole = np.array([[-np.sin(dd) * np.sin(dip), -np.cos(dd) * np.sin(dip), -np.cos(dip)]])
            at = stereonet.project(pole, net.contents().projection)[0]
            return tuple(net.artists.axes.transData.transform(at))
    raise AssertionError("the plane is not on the net")


def test_unsaved_work_prompts_and_each_answer_is_followed(
    own_folders, qtbot, outcrop, picks, tmp_path
):
    window = driver.make_window()
    driver.open_outcrop(window, outcrop)
    key(window, Qt.Key.Key_T)
    pick(window, well_seen(window, picks["B04"]))
    key(window, Qt.Key.Key_Return)
    seen: list[str] = []
    driver.answer(QMessageBox.StandardButton.Cancel, seen)
    assert not window.close()
    assert window.isVisible()
    window.studio.save_as(tmp_path / "kept.vom")
    (trace,) = traces(window)
    window.studio.selection.set([trace.id])
    focus(window)
    key(window, Qt.Key.Key_Delete)
    assert not traces(window)
    driver.answer(QMessageBox.StandardButton.Discard, seen)
    driver.close(window)
    assert seen == [
        Finding("project.save-changes", project=name).message for name in ("untitled", "kept")
    ]
    # What was not saved is gone from the project, and Undo brings even that back.
    window = driver.make_window([tmp_path / "kept.vom"])
    assert traces(window) == [trace]
    window.studio.undo()
    assert not traces(window)
    driver.answer(QMessageBox.StandardButton.Save, seen)
    driver.close(window)
    window = driver.make_window([tmp_path / "kept.vom"])
    assert not traces(window)
    driver.dismiss(window)


@pytest.mark.parametrize("ending", ["double click", pytest.param("Enter", marks=pytest.mark.slow)])
def test_a_trace_is_finished_by_enter_or_double_click(window, outcrop, picks, ending):
    driver.open_outcrop(window, outcrop)
    key(window, Qt.Key.Key_T)
    points = well_seen(window, picks["B04"])
    pick(window, points[:-1])
    last = pixel(window, points[-1])
    if ending == "Enter":
        click(window.viewport, last)
        key(window, Qt.Key.Key_Enter)
    else:
        QTest.mouseClick(window.viewport, driver.LEFT, driver.NONE, last)
        QTest.mouseDClick(window.viewport, driver.LEFT, driver.NONE, last)
    (trace,) = traces(window)
    assert len(trace.vertices) == len(points)
    assert QApplication.focusWidget() is window.viewport
    assert isinstance(trace, Trace)
