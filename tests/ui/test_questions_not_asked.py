"""Questions that the project can answer are not asked, and results go where results belong."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QFileDialog, QMessageBox, QPushButton, QToolButton

from tests import driver
from tests.messages import figures, shown_codes
from tests.ui.conftest import add_bed, add_cliff
from vomstudio.core.findings import Finding
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.registrations import Registration
from vomstudio.geometry.streaming.surfaces import create_surface
from vomstudio.io.photos.cameras_file import FILE_NAME, read_cameras
from vomstudio.project import edits
from vomstudio.project.records import Model
from vomstudio.project.sample import sample_model
from vomstudio.studio.model_loading import OpenModel
from vomstudio.ui.base import file_filters
from vomstudio.ui.base.command_targets import remember_target, results_folder
from vomstudio.ui.dialogs.frame_dialog import FrameDialog
from vomstudio.ui.panels.photos.photo_row import PhotoRow
from vomstudio.ui.panels.photos.reconstruction_folders import fill_camera_positions
from vomstudio.ui.widgets.search_field import SearchField

UTM, OTHER_UTM = "EPSG:32615", "EPSG:32633"
PLACE = (520_000.0, 4_400_000.0, 300.0)


def mesh_at(place: tuple[float, float, float]) -> Mesh:
    corners = np.array([[0.0, 0, 0], [5, 0, 0], [0, 5, 1]]) + place
    return Mesh(corners, np.array([[0, 1, 2]], np.int32))


def add_file(studio: Any, path: Path, place: tuple[float, float, float], hash_: str) -> Model:
    """Add a model as if its file, which states no frame, had just been read."""
    mesh = mesh_at(place)
    opened = OpenModel(mesh, create_surface(mesh), (), None, None, hash_ * 64)
    studio.workspace.models._add(path, opened, path.stem, None, lambda _: None, "")
    return studio.session.of(Model)[-1]


@pytest.fixture
def asked(studio: Any) -> list[str]:
    """The models whose frame is asked for."""
    ids: list[str] = []
    studio.frame_requested.disconnect()
    studio.frame_requested.connect(ids.append)
    return ids


# --- frames ----------------------------------------------------------------------------------
def test_model_near_those_of_the_project_gets_their_frame(
    studio: Any, asked: list[str], tmp_path: Path
) -> None:
    first = add_file(studio, tmp_path / "first.obj", PLACE, "1")
    assert asked == [first.id]
    assert studio.attempt(edits.declare_frame, first.id, Frame("crs", UTM))
    notices: list[Any] = []
    studio.notice.connect(notices.append)
    near = add_file(studio, tmp_path / "near.obj", (PLACE[0] + 800.0, *PLACE[1:]), "2")
    assert near.frame == Frame("crs", UTM)
    assert "frame.of-project" in [notice.code for notice in notices]
    far = add_file(studio, tmp_path / "far.obj", (0.0, 0.0, 0.0), "3")
    assert far.frame == Frame()
    assert asked == [first.id, far.id]


def test_model_made_by_the_program_needs_no_frame_dialog(
    studio: Any, asked: list[str], tmp_path: Path
) -> None:
    cameras = sample_model().with_name(FILE_NAME).read_text()
    unscaled = cameras.replace('"scaled": true', '"scaled": false').replace('"EPSG:32633"', "null")
    (tmp_path / FILE_NAME).write_text(unscaled)
    made = add_file(studio, tmp_path / "model.obj", (0.0, 0.0, 0.0), "4")
    assert made.frame == Frame()
    assert asked == []


def test_the_frame_dialog_proposes_the_crs_of_the_project(window: Any, studio: Any) -> None:
    add_cliff(studio, Frame("crs", UTM))
    other = Model("m2", "other", "other.obj", "mesh", "1" * 64, Frame())
    assert studio.attempt(edits.add_model, other)
    window.files.declare_frame("m2")
    dialog = driver.dialog_of(window)
    assert isinstance(dialog, FrameDialog)
    assert not dialog.isModal()
    assert dialog._crs.text() == UTM
    dialog._crs_button.click()
    dialog._crs.clear()
    QTest.keyClicks(dialog._crs, "utm 15n")
    QTest.keyClick(dialog._crs.popup, Qt.Key.Key_Down)
    QTest.keyClick(dialog._crs.popup, Qt.Key.Key_Return)
    assert dialog._crs.text() == UTM
    dialog.reject()


def test_declaring_the_same_frame_keeps_the_registration(window: Any, studio: Any) -> None:
    add_cliff(studio)
    placed = Registration("r1", "points", "points", Frame("crs", OTHER_UTM), scale_error=1e-3)
    assert studio.attempt(edits.set_registration, placed, ["m1"])
    before = studio.session.top
    window.files._apply_frame("m1", studio.records["m1"].frame)
    assert QApplication.activeModalWidget() is None
    assert studio.session.top == before


def test_search_matches_are_selected_with_the_keyboard(qtbot: Any) -> None:
    field = SearchField(lambda text: [(f"line of {n}", n) for n in ("aa", "ab") if text in n])
    qtbot.addWidget(field)
    field.show()
    qtbot.waitExposed(field)
    field.setFocus()
    QTest.keyClick(field, Qt.Key.Key_Down)
    assert field.popup.isVisible()
    QTest.keyClick(field.popup, Qt.Key.Key_Return)
    assert field.text() == "aa"
    QTest.keyClicks(field, "x")
    assert not field.popup.isVisible()


# --- results ---------------------------------------------------------------------------------
def test_results_folder_is_that_of_the_project_or_the_last_target(
    studio: Any, tmp_path: Path
) -> None:
    source, work, paper = (tmp_path / name for name in ("source", "work", "paper"))
    for folder in (source, work, paper):
        folder.mkdir()
    studio.settings.recent = [str(source / "cliff.obj")]
    assert not results_folder(studio).is_relative_to(source)
    studio.save_as(work / "cliff.vom")
    assert results_folder(studio) == work
    remember_target(studio, paper / "net.svg")
    assert results_folder(studio) == paper
    studio.open_project(make_project(studio, work / "other.vom"))
    assert results_folder(studio) == work, "of the project, not of the last one"
    studio.new_project()
    assert results_folder(studio) == paper, "without a place of its own, the last folder"


def make_project(studio: Any, folder: Path) -> Path:
    studio.new_project()
    studio.save_as(folder)
    studio.new_project()
    return folder


def test_proposed_elevation_model_path_is_not_in_the_model_folder(
    window: Any, studio: Any, tmp_path: Path
) -> None:
    add_cliff(studio)
    studio.models["m1"] = SimpleNamespace(data=mesh_at(PLACE), resolution=None)
    studio.settings.recent = [str(tmp_path / "cliff.obj")]
    window.docks.bring_forward("elevation")
    target = Path(window.docks["elevation"].widget().widget().target.text())
    assert target.name == "cliff_dem.tif"
    assert target.parent != tmp_path


def test_declining_to_overwrite_returns_to_the_dialog(
    window: Any, studio: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    add_cliff(studio)
    add_bed(studio, "b1")
    (tmp_path / "cliff_faultkin.txt").write_text("mine")
    answers = [(str(tmp_path / "cliff"), "FaultKin: fault slips (*.txt)"), ("", "")]
    times: list[str] = []

    def ask(*arguments: Any) -> tuple[str, str]:
        times.append(Path(arguments[2]).name)
        return answers.pop(0)

    monkeypatch.setattr(QFileDialog, "getSaveFileName", ask)
    seen: list[str] = []
    driver.answer(QMessageBox.StandardButton.No, seen)
    window.files.export_for_program()
    assert len(seen) == 1
    assert times == ["orientations", "cliff"]
    assert (tmp_path / "cliff_faultkin.txt").read_text() == "mine"


def test_exports_for_different_programs_get_distinct_names(
    window: Any, studio: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    add_cliff(studio)
    add_bed(studio, "b1")
    for pattern in ("Stereonet: planes and lines (*.txt)", "GemPy: orientations and surface"):
        chosen = (str(tmp_path / "cliff"), pattern)
        monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_, c=chosen: c)
        window.files.export_for_program()
    names = {path.name for path in tmp_path.iterdir()}
    assert "cliff_stereonet.txt" in names
    assert "cliff.txt" not in names


def test_finished_export_offers_to_open_the_file(
    window: Any, studio: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from PySide6.QtGui import QDesktopServices

    add_cliff(studio)
    add_bed(studio, "b1")
    opened: list[str] = []
    monkeypatch.setattr(QDesktopServices, "openUrl", lambda url: opened.append(url.toLocalFile()))
    bar = window.message_bar
    for number in range(2):
        window.files.export_features("csv", tmp_path / "planes.csv")
        assert bar.isVisible()
        assert bar.notice.code == "export.written"
        buttons = bar.findChildren(QPushButton)[-2:]
        buttons[number].click()
        assert not bar.isVisible()
        QApplication.sendPostedEvents()
    assert opened == [str(tmp_path / "planes.csv"), str(tmp_path)]
    window.files.export_features("csv", tmp_path / "planes.csv")
    assert bar.isVisible()
    studio.tool_changed()
    assert not bar.isVisible(), "it goes when the work goes on"
    studio.warn(Finding("action.no-model"))
    window.files.export_features("csv", tmp_path / "planes.csv")
    studio.tool_changed()
    assert bar.isVisible(), "with an unread message before it, it stays"


def test_report_is_written_in_the_background_with_an_offer_to_open_it(
    window: Any, studio: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    report = window.actions_table.all["project_report"]
    assert window.actions_table.disabled_reason("project_report").code == "export.no-features"
    add_cliff(studio)
    add_bed(studio, "b1")
    path = tmp_path / "cliff.html"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(path), ""))
    report.trigger()
    driver.wait(path.exists, "the report")
    bar = window.message_bar
    # The file of the model does not exist, which is reported first.
    driver.wait(
        lambda: bar.isVisible() and bar.notice.code == "export.written", "the notice of the report"
    )
    assert "B01" in path.read_text("utf-8")


def test_the_export_of_distances_needs_a_model(window: Any) -> None:
    window.docks.bring_forward("compare")
    export = window.docks["compare"].widget().widget().export
    assert not export.isEnabled()
    assert shown_codes(export.toolTip()) == {"action.no-model"}


def test_control_points_are_read_from_every_format(
    window: Any, studio: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    from vomstudio.ui.panels.tools.control import ControlPanel

    add_cliff(studio)
    given: list[str] = []

    def ask(*arguments: Any) -> tuple[str, str]:
        given.append(arguments[3])
        return "", ""

    monkeypatch.setattr(QFileDialog, "getOpenFileName", ask)
    driver.tool_panel(window, ControlPanel).choose_points_file()
    assert given == [file_filters.ground_control()]
    assert "*.xml" in given[0]


# --- photos ----------------------------------------------------------------------------------
def test_camera_positions_follow_the_model_registration(tmp_path: Path) -> None:
    text = sample_model().with_name(FILE_NAME).read_text()
    (tmp_path / FILE_NAME).write_text(text)
    cameras = read_cameras(tmp_path / FILE_NAME)
    names = [view.name for view in cameras.views]
    rows = [PhotoRow(name, name, 10, 10, "", "", "", False, None) for name in names]
    assert fill_camera_positions(tmp_path, rows, None) == Frame("crs", "EPSG:32633")
    before = np.array([row.place for row in rows])
    quarter = ((0.0, -2.0, 0.0, 10.0), (2.0, 0.0, 0.0, 20.0), (0.0, 0.0, 2.0, 0.0), (0.0, 0, 0, 1))
    placed = Registration("r", "r", "points", Frame("local"), quarter, scale_error=1e-3)
    model = Model("m", "m", "model.obj", "mesh", "0" * 64, placed)
    looked = [row.look_direction for row in rows]
    assert fill_camera_positions(tmp_path, rows, model) == Frame("local")
    after = np.array([row.place for row in rows])
    np.testing.assert_allclose(after, before[:, ::-1] * [-2.0, 2.0] + [10.0, 20.0])
    for row, look in zip(rows, looked, strict=True):
        assert row.look_direction == pytest.approx((-look[1], look[0]))


def photo_rows(*names: str) -> list[PhotoRow]:
    return [PhotoRow(name, name, 10, 10, "", "", "", False, None) for name in names]


@pytest.mark.full
def test_reconstruction_needs_the_list_of_photos_but_not_their_check(window: Any) -> None:
    survey = window.survey
    survey.folder, survey.rows = Path("photos"), photo_rows("a.jpg", "b.jpg")
    survey.rows_changed.emit()
    make = window.actions_table.all["make_model"]
    job: Any = SimpleNamespace()
    try:
        survey._check_job = job
        survey.changed.emit()
        assert survey.is_reading
        assert survey.reconstruction_problem() is None
        assert make.isEnabled()
        survey._list_job, survey._check_job = job, None
        survey.changed.emit()
        assert survey.reconstruction_problem() == Finding("photos.pending")
        assert not make.isEnabled()
    finally:
        survey._list_job = survey._check_job = None


def test_pause_button_is_visible_while_nothing_runs(window: Any) -> None:
    window.docks.bring_forward("photos")
    panel, survey = window.photos_panel, window.survey
    survey.folder = Path("photos")
    survey.rows_changed.emit()
    places = {
        button.defaultAction(): button.isVisibleTo(panel)
        for button in panel.findChildren(type(panel.results))
        if button.defaultAction() is not None
    }
    pause = window.actions_table.all["pause_model"]
    assert places[pause]
    assert window.actions_table.disabled_reason("pause_model") == Finding(
        "action.no-reconstruction"
    )


@pytest.mark.full
def test_photo_buttons_stay_in_place_and_progress_is_shown_once(
    window: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    window.resize(1600, 1000)
    window.docks.bring_forward("photos")
    panel, survey = window.photos_panel, window.survey
    survey.folder, survey.rows = Path("photos"), photo_rows("a.jpg", "b.jpg")
    survey.rows_changed.emit()
    make = window.actions_table.all["make_model"]
    buttons = [button for button in panel.findChildren(QToolButton) if button.isVisibleTo(panel)]
    assert {make, window.actions_table.all["pause_model"]} <= {b.defaultAction() for b in buttons}
    job: Any = SimpleNamespace(stage="Matching", done=357, total=468, start=0.0)

    def places(is_begun: bool, job: Any) -> list[Any]:
        monkeypatch.setattr(type(survey), "is_begun", property(lambda _: is_begun))
        survey._reconstruction_job = job
        survey.changed.emit()
        driver.pause(30)
        return [button.geometry() for button in buttons]

    try:
        first, texts = places(False, None), {make.text()}
        for is_begun, running in ((True, None), (True, job), (False, job), (False, None)):
            assert places(is_begun, running) == first, (is_begun, running)
            texts.add(make.text())
            # The progress of the job is shown in the status bar.
            text = panel._verdict.text()
            assert figures(text)[0] == 2
            assert "357" not in text
            assert "468" not in text
    finally:
        survey._reconstruction_job = None
    assert len(texts) == 2
