"""Looking into a reconstruction: cameras in the outcrop, tie points, matches, residuals, depths."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from PySide6.QtCore import QPoint, QPointF, Qt, QTimer
from PySide6.QtGui import QWheelEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tests import driver
from tests.driver import wait
from tests.messages import figures, shown_codes
from tests.photogrammetry import made_reconstruction
from tests.photogrammetry.made_reconstruction import NAMES, WEAK
from vomstudio.core.findings import Finding
from vomstudio.geometry.frames import Frame
from vomstudio.project import edits
from vomstudio.project.records import Model
from vomstudio.rendering.scene.camera_layer import WEAK_COLOR
from vomstudio.ui.base.command_targets import current_model
from vomstudio.ui.dialogs.alignment.alignment_dialog import AlignmentDialog


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> made_reconstruction.Made:
    return made_reconstruction.make(tmp_path_factory.mktemp("made"))


@pytest.fixture
def opened(window, made):
    window.open_path(made.out / "dense.ply")
    model_id = driver.settled(window)
    wait(lambda: window.cameras.disabled_reason() is None, "the cameras")
    return model_id


def open_dialog(window) -> AlignmentDialog:
    window.actions_table.run("show_alignment")
    (dialog,) = window.findChildren(AlignmentDialog)
    QTest.qWaitForWindowExposed(dialog)
    wait(lambda: dialog.is_ready, "the alignment", 60.0)
    return dialog


def show_tab(dialog: AlignmentDialog, page) -> None:
    """Click on the tab of a page."""
    bar = dialog.tabs.tabBar()
    at = bar.tabRect(dialog.tabs.indexOf(page)).center()
    driver.click(bar, at)
    assert dialog.tabs.currentWidget() is page


def choose(table, row: int) -> None:
    """Click on a row."""
    at = table.visualRect(table.model().index(row, 1)).center()
    driver.click(table.viewport(), at)


def turn_wheel(widget, at: QPoint, notches: int) -> None:
    where = QPointF(at)
    event = QWheelEvent(
        where,
        QPointF(widget.mapToGlobal(at)),
        QPoint(),
        QPoint(0, 120 * notches),
        Qt.MouseButton.NoButton,
        Qt.KeyboardModifier.NoModifier,
        Qt.ScrollPhase.NoScrollPhase,
        False,
    )
    QApplication.sendEvent(widget, event)


def picture(widget) -> np.ndarray:
    from PySide6.QtGui import QImage

    image = widget.grab().toImage().convertToFormat(QImage.Format.Format_RGB888)
    raw = np.frombuffer(image.constBits(), np.uint8).reshape(image.height(), -1)
    return raw[:, : 3 * image.width()].reshape(image.height(), image.width(), 3).astype(int)


@pytest.mark.full
def test_camera_frusta_are_drawn_at_the_photo_positions(window, made, opened) -> None:
    viewport, action = window.viewport, window.actions_table.all["display_cameras"]
    before = picture(viewport)
    action.trigger()
    assert action.isChecked()
    shown = viewport.photos.frusta
    centres = made.scene.centres + made.scene.origin
    assert np.allclose([f.tip for f in shown], centres)
    # Home brings them into view, which stand outside the outcrop.
    driver.key(window, Qt.Key.Key_Home)
    driver.settled(window)
    wait(lambda: viewport.scene.picture.is_complete, "the picture")
    pixels, _ = viewport.project(centres)
    assert ((pixels > 0) & (pixels < [viewport.width(), viewport.height()])).all()
    assert np.abs(picture(viewport) - before).max() > 40
    # A weakly connected one has its own colour.
    assert [f.is_weak for f in shown] == [f.name == WEAK for f in shown]
    column, row = pixels[[f.name for f in shown].index(WEAK)].astype(int)
    near = picture(viewport)[row - 12 : row + 13, column - 12 : column + 13].reshape(-1, 3)
    distance = np.abs(near - 255 * np.array(WEAK_COLOR)).max(axis=1)
    assert distance.min() < 40
    # Under the cursor they say which photo they are.
    driver.move(viewport, QPoint(*(int(v) for v in pixels[1])))
    wait(lambda: viewport.photos.hovered == "b.jpg", "the name")
    driver.keep_picture(window, "alignment-cameras")
    # They follow when the model is placed anew.
    record = window.studio.records[opened]
    assert isinstance(record, Model)
    moved = Frame("local")
    assert window.studio.attempt(edits.declare_frame, opened, moved)
    record = window.studio.records[opened]
    matrix = np.array(record.to_world)
    assert np.allclose(viewport.photos.frusta[2].tip, matrix[:3, :3] @ centres[2] + matrix[:3, 3])
    window.studio.set_visible([opened], False)
    assert not viewport.photos.frusta
    window.studio.set_visible([opened], True)
    action.trigger()
    assert not viewport.photos.frusta


@pytest.mark.full
@pytest.mark.usefixtures("new_window")
def test_camera_display_is_restored_when_the_project_reopens(
    window, made, opened, tmp_path
) -> None:
    window.actions_table.run("display_cameras")
    folder = tmp_path / "kept.vom"
    window.studio.save_as(folder)
    window.close()
    QApplication.processEvents()
    driver.delete(window)
    again = driver.make_window([folder])
    try:
        wait(lambda: again.viewport.photos.frusta, "the cameras")
        assert again.actions_table.all["display_cameras"].isChecked()
    finally:
        driver.dismiss(again)


@pytest.mark.full
def test_alignment_actions_are_disabled_with_reasons_without_photos(window, outcrop) -> None:
    for name, code in (
        ("display_cameras", "action.no-model"),
        ("show_alignment", "action.no-photos"),
        ("show_tie_points", "action.no-photos"),
        ("open_report", "action.no-report"),
    ):
        action = window.actions_table.all[name]
        assert not action.isEnabled()
        assert code in shown_codes(action.toolTip())
    driver.open_outcrop(window, outcrop)
    reason = Finding("cameras.none-beside-models")
    assert window.actions_table.disabled_reason("display_cameras") == reason


@pytest.mark.full
def test_tie_points_open_in_the_frame_of_the_model_with_their_error(window, made, opened) -> None:
    window.actions_table.run("show_tie_points")
    wait(lambda: len(window.studio.models) == 2, "the tie points")
    points = window.studio.session.of(Model)[-1]
    assert points.name.endswith(f" {window.studio.records[opened].name}")
    assert points.frame == window.studio.records[opened].frame
    wait(lambda: window.viewport.display.color_scale(points.id) is not None, "the colours")
    scale = window.viewport.display.color_scale(points.id)
    assert scale.title == "error"
    assert scale.unit == "px"
    assert np.isclose(scale.high, 0.5 / 3, atol=0.01)
    names = [window.display_panel.field.itemData(i) for i in range(3)]
    assert {"error_px", "views"} <= set(names) or current_model(window.studio).id != points.id
    # Asked for again, they are not opened twice.
    window.actions_table.run("show_tie_points")
    driver.pause(100)
    assert len(window.studio.session.of(Model)) == 2
    driver.keep_picture(window, "alignment-tie-points")


@pytest.mark.full
def test_photos_panel_opens_the_alignment(window, made) -> None:
    folder = window.studio.project.folder / "reconstruction" / "photos-medium"
    shutil.copytree(made.out, folder)
    window.open_path(made.photos)
    wait(lambda: window.survey.rows and not window.survey.is_reading, "the check", 120.0)
    window.docks.bring_forward("photos")
    button = window.photos_panel.results
    shown: list[list[bool]] = []

    def look() -> None:
        menu = button.menu()
        shown.append([action.isEnabled() for action in menu.actions()])
        QTest.mouseClick(
            menu, Qt.MouseButton.LeftButton, pos=menu.actionGeometry(menu.actions()[0]).center()
        )

    QTimer.singleShot(200, look)
    driver.click(button, button.rect().center())
    wait(lambda: window.findChildren(AlignmentDialog), "the window")
    assert shown == [[True, True, False]]
    (dialog,) = window.findChildren(AlignmentDialog)
    wait(lambda: dialog.is_ready, "the alignment", 60.0)
    dialog.close()
    # A photo that is chosen in the table is marked in the outcrop, and the other way round.
    window.open_path(folder / "dense.ply")
    driver.settled(window)
    wait(lambda: window.cameras.disabled_reason() is None, "the cameras")
    window.actions_table.run("display_cameras")
    window.actions_table.run("home")
    driver.settled(window)
    choose(window.photos_panel.table, 2)
    assert window.viewport.photos.selection == {"c.jpg"}
    (tip,), _ = window.viewport.project(made.scene.centres[:1] + made.scene.origin)
    driver.click(window.viewport, QPoint(*(round(float(v)) for v in tip)))
    wait(lambda: window.viewport.photos.selection == {"a.jpg"}, "the other photo")
    assert window.photos_panel.table.currentRow() == 0
    driver.keep_picture(window, "alignment-panel")


@pytest.mark.full
def test_pair_matches_can_be_selected_and_inspected(window, made, opened) -> None:
    dialog = open_dialog(window)
    page = dialog.matches
    wait(lambda: page._arrays is not None and len(page._photos) == 2, "the pair")
    assert page._pair == ("a.jpg", "b.jpg")
    assert len(page._arrays["matches"]) == 100
    assert figures(page._summary.text())[:3] == [100, 101, 99.0]
    panes = page.panes
    left = panes._links.left
    assert np.allclose(left, made.scene.views[0].project(made.scene.points[:100]), atol=1e-3)
    driver.keep_picture(dialog, "alignment-matches")
    # The third photo is shown upright, and so are its marks.
    choose(page.table, 1)
    wait(lambda: page._pair == ("b.jpg", "c.jpg") and len(page._photos) == 2, "the next pair")
    wait(lambda: page._arrays is not None, "its matches")
    assert "12 inliers of" in page._summary.text()
    assert "Weak" in page.table.numbers.rows[1][1]
    assert panes._pictures[1].size == (240, 320)
    stored = made.scene.views[2].project(made.scene.points[:12])
    assert np.allclose(
        panes._links.right, np.column_stack([240 - stored[:, 1], stored[:, 0]]), atol=1e-3
    )
    # The cell of the first pair in the matrix brings it back.
    driver.click(page.matrix, page.matrix._cell_rect(1, 0).center().toPoint())
    wait(lambda: page._pair == ("a.jpg", "b.jpg") and page._arrays is not None, "the first")
    wait(lambda: len(page._photos) == 2, "its photos")
    # The wheel keeps what is under the cursor; a drag takes it along.
    at = QPoint(*(int(v) for v in panes.to_screen(0, left[5])[0]))
    under = panes.to_picture(0, QPointF(at))
    turn_wheel(panes, at, 4)
    assert np.allclose(panes.to_picture(0, QPointF(at)), under, atol=1e-6)
    driver.drag(panes, at, at + QPoint(40, 25))
    assert np.allclose(panes.to_picture(0, QPointF(at + QPoint(40, 25))), under, atol=1e-6)
    # A double click on a match brings both its ends into the middle.
    (spot,) = panes.to_screen(0, left[5])
    QTest.mouseDClick(panes, Qt.MouseButton.LeftButton, pos=QPoint(*(round(v) for v in spot)))
    for pane, place in enumerate((left[5], panes._links.right[5])):
        middle = panes.middle(pane)
        assert np.allclose(panes.to_screen(pane, place)[0], [middle.x(), middle.y()], atol=1.0)
    page.outliers.click()
    assert panes._links.faint_lines is not None
    dialog.close()


@pytest.mark.full
def test_alignment_dialog_shows_cameras_residuals_and_depths(window, made, opened) -> None:
    dialog = open_dialog(window)
    show_tab(dialog, dialog.cameras)
    words = dialog.cameras._summary.text()
    assert "300.0 px" in words
    assert "± 1.5 px" in words
    assert "12.0°" in words
    table = dialog.cameras.correlation
    assert [table.verticalHeaderItem(i).text() for i in range(table.rowCount())] == ["f", "k1"] or [
        table.model().headerData(i, Qt.Orientation.Vertical) for i in range(table.rowCount())
    ] == ["f", "k1"]
    assert table.item(0, 1).text() == "-0.95"
    assert "strongly correlated (-0.95)" in dialog.cameras._correlation_note.text()
    driver.keep_picture(dialog, "alignment-calibration")

    show_tab(dialog, dialog.residuals)
    page = dialog.residuals
    wait(lambda: page._arrays is not None and page._photo is not None, "the residuals")
    # The worst comes first.
    assert page._photo_name == "b.jpg"
    assert (
        "exaggerated 20 times" in page._message.text()
        or "exaggerated 10 times" in page._message.text()
    )
    assert "median 0.50 px" in page._message.text()
    page.factor.setCurrentIndex(page.factor.findData(50))
    assert "exaggerated 50 times" in page._message.text()
    driver.keep_picture(dialog, "alignment-residuals")

    show_tab(dialog, dialog.depths)
    depths = dialog.depths
    wait(lambda: depths._arrays is not None, "the depth map")
    assert figures(depths._summary.text())[0] == 50
    assert "a.jpg" in depths._summary.text()
    wait(lambda: depths.table.numbers.rows[0][0] == ("a.jpg", 0.5), "the coverage")
    panes = depths.panes
    spot = panes.to_screen(1, [[20.5, 60.5]])[0]
    driver.move(panes, QPoint(*(round(float(v)) for v in spot)))
    assert depths._readout.text().startswith("Depth 9.5")
    for what in ("confidence", "normals", "colors"):
        depths.layer.setCurrentIndex(depths.layer.findData(what))
        driver.pause()
        driver.keep_picture(dialog, f"alignment-depths-{what}")
    choose(depths.table, 1)
    wait(lambda: "no depth map" in panes._message, "the reason")
    QTest.keyClick(dialog, Qt.Key.Key_Escape)
    wait(lambda: not window.findChildren(AlignmentDialog), "the end")


@pytest.mark.full
def test_missing_photos_are_reported_and_their_matches_remain(window, tmp_path) -> None:
    made = made_reconstruction.make(tmp_path)
    for name in NAMES:
        Path(made.photos, name).unlink()
    window.open_path(made.out / "dense.ply")
    driver.settled(window)
    wait(lambda: window.cameras.disabled_reason() is None, "the cameras")
    dialog = open_dialog(window)
    page = dialog.matches
    wait(lambda: page._arrays is not None and len(page._photos) == 2, "the pair")
    wait(lambda: panes_problem(page), "the reason")
    assert "file.missing" in shown_codes(panes_problem(page))
    assert len(page.panes._links.left) == 100
    driver.keep_picture(dialog, "alignment-gone")
    dialog.close()


def panes_problem(page) -> str:
    shown = page.panes._pictures[0]
    return "" if shown is None else shown.problem
