"""From a folder of photos to a model in the window, with real mouse and key events."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QFileDialog, QListWidget, QToolButton

from tests import driver
from vomstudio.core.findings import Finding
from vomstudio.io.photos.cameras_file import read_cameras
from vomstudio.project.records import Model


def looked_at(window) -> None:
    driver.wait(lambda: window.survey.rows and not window.survey.is_reading, "the check", 120.0)


def press(window, action: str) -> None:
    """Click the panel's button."""
    wanted = window.actions_table.all[action]
    button = next(
        b for b in window.photos_panel.findChildren(QToolButton) if b.defaultAction() is wanted
    )
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)


def test_dropped_photos_are_checked_and_listed(window, photos) -> None:
    (photos / "notes.txt").write_text("weather: fine")
    (photos / "broken.jpg").write_bytes((photos / "IMGP4167.JPG").read_bytes()[:5000])
    assert window.survey.reconstruction_problem() == Finding("action.no-photos")
    driver.drop(window, [photos])
    looked_at(window)
    table = window.photos_panel.table
    assert [table.item(row, 0).text() for row in range(table.rowCount())] == [
        f"IMGP{n}.JPG" for n in (4167, 4168, 4169, 4170)
    ]
    assert not table.item(0, 0).icon().isNull()
    said = [
        window.photos_panel.findChild(QListWidget, "findings").item(i).text()
        for i in range(window.photos_panel.findChild(QListWidget, "findings").count())
    ]
    assert any("4 photos" in text for text in said)
    assert any("broken.jpg" in text for text in said)
    assert window.survey.reconstruction_problem() is None
    driver.keep_picture(window, "photos")


@pytest.mark.full
def test_points_and_masks_delivered_with_photos_are_not_reported_as_foreign(
    window, tmp_path
) -> None:
    """The first thing that is said of them was that another program had changed them."""
    folder = tmp_path / "photos"
    shutil.copytree(Path(__file__).parents[1] / "specimens" / "photos", folder)
    driver.drop(window, [folder])
    looked_at(window)
    driver.wait(lambda: window.survey.document.is_imported, "the points and masks", 60.0)
    driver.pause(500)
    assert len(window.survey.document.marking().control) > 2
    said = [window.messages.item(row).text() for row in range(window.messages.count())]
    assert not any("Another program" in text for text in said), said


@pytest.mark.full
def test_folder_without_photos_is_reported_and_window_stays_open(window, tmp_path) -> None:
    (tmp_path / "empty").mkdir()
    driver.drop(window, [tmp_path / "empty"])
    driver.wait(lambda: window.survey.problem, "the reason")
    assert "empty" in window.survey.problem
    assert window.survey.reconstruction_problem() is not None


@pytest.mark.full
def test_reconstruction_is_paused_and_continued(window, photos, tmp_path, monkeypatch) -> None:
    place = tmp_path / "wall.vom"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(place), ""))
    driver.drop(window, [photos])
    looked_at(window)
    window.photos_panel.quality.setCurrentIndex(window.photos_panel.quality.findData("preview"))
    press(window, "make_model")
    driver.wait(
        lambda: window.survey.reconstruction_job and window.survey.reconstruction_job.stage,
        "the work",
        60.0,
    )
    out = window.survey.output_folder()
    assert out.is_relative_to(place), "where the user has asked for it"
    # Stopped within seconds, once something is finished.
    driver.wait(lambda: list((out / "work").glob("frame-*[!t]")), "the alignment", 180.0)
    press(window, "pause_model")
    driver.wait(lambda: window.survey.reconstruction_job is None, "the pause", 10.0)
    assert window.photos_panel._verdict.text().startswith("Reconstruction paused")
    jobs = window.docks["jobs"].widget()
    (row,) = [i for i in range(jobs.rowCount()) if "Reconstructing" in jobs.item(i, 0).text()]
    assert jobs.item(row, 1).text().startswith("Paused at ")
    work = out / "work"
    finished = {p.name for p in work.iterdir() if p.is_dir() and p.suffix != ".part"}
    assert any(name.startswith("alignment") for name in finished)
    assert window.survey.is_begun
    assert "Continue" in window.actions_table.all["make_model"].text()
    begun = {p.name: p.stat().st_mtime_ns for p in (out / "work").iterdir() if p.name in finished}
    press(window, "make_model")
    driver.wait(lambda: window.survey.reconstruction_job is not None, "the work")
    driver.wait(lambda: window.survey.reconstruction_job is None, "the model", 300.0)
    assert window.survey.result is not None
    for name, time in begun.items():
        assert (out / "work" / name).stat().st_mtime_ns == time, "was finished, and done again"
    driver.wait(lambda: window.studio.models, "the model in the window", 60.0)
    (model,) = window.studio.session.of(Model)
    assert model.name == "the wall"
    assert len(read_cameras(out / "cameras.json").views) == 4
    assert json.loads((out / "reconstruction.json").read_text())["registered"] == 4
    assert "report.html" in {p.name for p in out.iterdir()}
    assert not window.survey.frame.has_north
    driver.pause(1500)
    # The model has the window, and nobody asks for a frame that no one knows.
    assert driver.dialog_of(window) is None
    assert window.workspaces.current_workspace.name == "interpret"
    assert not window.docks.page("drawer")
    assert window.viewport.height() > 0.7 * window.height()
    driver.keep_picture(window, "photos-model")
    shutil.rmtree(out)


@pytest.mark.full
def test_failed_run_reports_its_reason_and_is_not_called_paused(window, tmp_path) -> None:
    """Photos of nothing: they can be read, and no two of them show the same."""
    import numpy as np
    from PIL import Image

    folder = tmp_path / "mist"
    folder.mkdir()
    for number, grey in enumerate((90, 120, 150)):
        picture = np.full((480, 640, 3), grey, np.uint8)
        Image.fromarray(picture).save(folder / f"mist{number}.jpg")
    driver.drop(window, [folder])
    looked_at(window)
    window.photos_panel.quality.setCurrentIndex(window.photos_panel.quality.findData("preview"))
    window.studio.save_as(tmp_path / "mist.vom")
    press(window, "make_model")
    driver.wait(lambda: window.survey.reconstruction_job is not None, "the work")
    driver.wait(lambda: window.survey.reconstruction_job is None, "the failure", 120.0)
    warned = [window.messages.item(row).text() for row in range(window.messages.count())]
    panel = window.photos_panel
    findings = panel.findChild(QListWidget, "findings")
    said = findings.item(0).text().partition("The reconstruction failed: ")[2]
    assert said
    assert panel._verdict.text().startswith("Reconstruction failed, ")
    assert "paused" not in panel._verdict.text()
    assert any(said.rstrip(".") in text for text in warned), (said, warned)
    driver.keep_picture(window, "photos-failed")
    # It is known still when the photos are opened again, and forgotten when it is tried again.
    driver.drop(window, [folder])
    looked_at(window)
    assert findings.item(0).text().endswith(said)
    press(window, "make_model")
    driver.wait(lambda: window.survey.reconstruction_job is not None, "the work")
    assert "failed" not in panel._verdict.text()
    assert not any("failed" in findings.item(i).text() for i in range(findings.count()))
    driver.wait(lambda: window.survey.reconstruction_job is None, "the failure", 120.0)
