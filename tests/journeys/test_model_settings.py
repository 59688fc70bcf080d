"""Ground control and the rest of the settings, chosen in the window before a model is made."""

from __future__ import annotations

import csv
import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QFileDialog, QListWidget, QMessageBox, QToolButton

from tests import driver
from tests.journeys.test_photos import looked_at
from tests.messages import figures, shown_codes, shown_values
from vomstudio.core.findings import Finding
from vomstudio.core.paths import resource
from vomstudio.geometry.boxes import ClipBox
from vomstudio.ui.dialogs.reconstruct_dialog import ReconstructDialog

pytestmark = pytest.mark.full

GPS_TAG = 0x8825


@pytest.fixture
def sample(tmp_path) -> Path:
    """Five of the sample's photos, in which every control point is marked twice, with control and
    marks beside them. All twelve take three times as long to be looked at."""
    photos = tmp_path / "photos"
    photos.mkdir()
    for number in (2041, 2042, 2046, 2047, 2048):
        shutil.copy(resource("sample", "photos", f"HL_{number}.jpg"), photos)
    shutil.copy(resource("sample", "control.csv"), tmp_path)
    lines = resource("sample", "marks.csv").read_text().splitlines()
    kept = [x for x in lines if ".jpg" not in x or (photos / x.split(",")[1]).exists()]
    (tmp_path / "marks.csv").write_text("\n".join(kept) + "\n")
    return photos


def settled(window) -> None:
    driver.wait(lambda: not window.survey.is_forecasting, "the forecast", 60.0)


def open_dialog(window) -> ReconstructDialog:
    wanted = window.actions_table.all["make_settings"]
    button = next(
        b for b in window.photos_panel.findChildren(QToolButton) if b.defaultAction() is wanted
    )
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)
    (dialog,) = window.findChildren(ReconstructDialog)
    QTest.qWaitForWindowExposed(dialog)
    settled(window)
    return dialog


def tick(button) -> None:
    """On the circle: the rest of a wide button does not listen."""
    driver.click(button, QPoint(9, button.height() // 2))


def retype(field, text: str) -> None:
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, text) if text else QTest.keyClick(field, Qt.Key.Key_Delete)


def findings(window) -> str:
    shown = window.photos_panel.findChild(QListWidget, "findings")
    return "\n".join(shown.item(i).text() for i in range(shown.count()))


def test_control_beside_photos_is_found_and_its_crs_proposed(window, sample) -> None:
    window.open_path(sample)
    looked_at(window)
    settled(window)
    assert shown_values(findings(window), "control.registers")["crs"] == "EPSG:32633"
    driver.keep_picture(window, "control-found")
    dialog = open_dialog(window)
    assert dialog.control_button.isChecked()
    assert dialog.control.text() == str(sample.parent / "control.csv")
    assert dialog.points.rowCount() == 8
    crs, _, reason = dialog._crs_message.text().partition(" ")
    assert crs == "EPSG:32633"
    assert reason == Finding("control.crs-stated", file="control.csv").message
    assert "check point" in dialog.verdict.text()
    assert dialog.start_button.isEnabled()
    assert shown_values(dialog.memory.text(), "reconstruction.memory")["free"].endswith(" GB")
    driver.keep_picture(dialog, "model-settings")
    # The cameras' GPS instead.
    tick(dialog.gps_button)
    settled(window)
    assert window.survey.settings.control is None
    assert "ground control" not in findings(window)
    tick(dialog.control_button)
    settled(window)
    assert window.survey.settings.control == sample.parent / "control.csv"
    dialog.close()


def write_micmac_control(folder: Path) -> None:
    """Replace the control of a folder, two tables, by the files of MicMac."""
    tables = {}
    for name in ("control.csv", "marks.csv"):
        lines = (folder / name).read_text().splitlines()
        tables[name] = list(csv.DictReader(line for line in lines if not line.startswith("#")))
        (folder / name).unlink()
    points, marks = tables["control.csv"], tables["marks.csv"]
    (folder / "Ground-Pts3D.xml").write_text(
        "<DicoAppuisFlottant>"
        + "".join(
            f"<OneAppuisDAF><Pt>{row['x']} {row['y']} {row['z']}</Pt>"
            f"<NamePt>{row['label']}</NamePt><Incertitude>1 1 1</Incertitude></OneAppuisDAF>"
            for row in points
        )
        + "</DicoAppuisFlottant>"
    )
    (folder / "GroundMeasure.xml").write_text(
        "<SetOfMesureAppuisFlottants>"
        + "".join(
            f"<MesureAppuiFlottant1Im><NameIm>{photo}</NameIm>"
            + "".join(
                f"<OneMesureAF1I><NamePt>{row['label']}</NamePt>"
                f"<PtIm>{row['x']} {row['y']}</PtIm></OneMesureAF1I>"
                for row in marks
                if row["photo"] == photo
            )
            + "</MesureAppuiFlottant1Im>"
            for photo in sorted({row["photo"] for row in marks})
        )
        + "</SetOfMesureAppuisFlottants>"
    )


def remove_gps(photo: Path) -> None:
    with Image.open(photo) as image:
        image.load()
        exif = image.getexif()
        del exif[GPS_TAG]
        image.save(photo, quality=95, exif=exif)


def test_control_of_micmac_beside_photos_without_gps_is_proposed(window, sample) -> None:
    write_micmac_control(sample.parent)
    for photo in sample.iterdir():
        remove_gps(photo)
    window.open_path(sample)
    looked_at(window)
    settled(window)
    survey = window.survey
    assert not any(row.has_gps for row in survey.rows)
    assert survey.settings.control == sample.parent / "Ground-Pts3D.xml"
    dialog = open_dialog(window)
    assert dialog.control_button.isChecked()
    assert dialog.control.text() == str(survey.settings.control)
    assert dialog.points.rowCount() == 8
    # Positions that the photos do not have are not offered.
    assert "GPS" not in dialog.gps_button.text()
    dialog.close()


def test_too_few_marks_are_reported_before_reconstruction(window, sample) -> None:
    marks = sample.parent / "marks.csv"
    lines = marks.read_text().splitlines()
    labels = list(dict.fromkeys(line.split(",")[0] for line in lines[1:]))
    kept = [lines[0], *(x for x in lines[1:] if x.split(",")[0] in labels[:2])]
    marks.write_text("\n".join(kept) + "\n")
    window.open_path(sample)
    looked_at(window)
    settled(window)
    # Nobody asked for these files.
    assert window.survey.settings.control is None
    assert shown_values(findings(window), "control.not-used")["table"] == "control.csv"
    assert "control.too-few" in shown_codes(findings(window))
    assert window.survey.reconstruction_problem() is None
    dialog = open_dialog(window)
    tick(dialog.control_button)
    assert "control.no-file" in shown_codes(dialog.verdict.text())
    assert not dialog.start_button.isEnabled()
    retype(dialog.control, str(sample.parent / "control.csv"))
    driver.wait(lambda: not dialog._apply_timer.isActive(), "the pause in typing")
    settled(window)
    assert "control.too-few" in shown_codes(dialog.verdict.text().replace("</b><br>", " "))
    assert not dialog.start_button.isEnabled()
    driver.keep_picture(dialog, "model-settings-missing")
    retype(dialog.control, str(sample.parent / "gone.csv"))
    driver.wait(lambda: not dialog._apply_timer.isActive(), "the pause in typing")
    settled(window)
    assert "gone.csv" in dialog.verdict.text()
    assert not dialog.start_button.isEnabled()
    dialog.close()


def test_invalid_crs_is_reported_and_thread_count_changes_memory_estimate(window, sample) -> None:
    window.open_path(sample)
    looked_at(window)
    dialog = open_dialog(window)
    retype(dialog.crs, "EPSG:4326")
    driver.wait(lambda: not dialog._apply_timer.isActive(), "the pause in typing")
    assert "frame.not-projected" in shown_codes(dialog._crs_message.text())
    assert not dialog.start_button.isEnabled()
    retype(dialog.crs, "32612")
    driver.wait(lambda: not dialog._apply_timer.isActive(), "the pause in typing")
    settled(window)
    said = shown_values(dialog.verdict.text(), "frame.other-crs")
    assert said["stated"] == "EPSG:32633"
    assert not dialog.start_button.isEnabled()
    retype(dialog.crs, "")
    dialog.options.fields["threads"].setFocus()
    dialog.options.fields["threads"].selectAll()
    QTest.keyClicks(dialog.options.fields["threads"], "1")
    driver.wait(lambda: not dialog._apply_timer.isActive(), "the pause in typing")
    settled(window)
    assert "reconstruction.memory" in shown_codes(dialog.memory.text())
    assert window.survey.settings.options.threads == 1
    dialog.close()


def test_model_is_registered_by_micmac_control_and_reopened_from_its_folder(
    window,
    photos,
    tmp_path,
    data_dir,
    monkeypatch,
) -> None:
    folder = data_dir / "saint_martin"
    asked = ["", str(tmp_path / "first.vom")]
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (asked.pop(0), ""))
    scale = 2 / 5
    # The photos are of two fifths of the size in which they were marked.
    text = (folder / "GroundMeasure.xml").read_text()
    import re

    def smaller(found: re.Match[str]) -> str:
        x, y = (float(v) * scale for v in found[1].split())
        return f"<PtIm>{x} {y}</PtIm>"

    (tmp_path / "marks.xml").write_text(re.sub(r"<PtIm>([^<]*)</PtIm>", smaller, text))
    window.open_path(photos)
    looked_at(window)
    dialog = open_dialog(window)
    dialog.options.fields["quality"].setFocus()
    QTest.keyClick(dialog.options.fields["quality"], Qt.Key.Key_Home)
    tick(dialog.control_button)
    retype(dialog.control, str(folder / "Ground-Pts3D.xml"))
    retype(dialog.marks, str(tmp_path / "marks.xml"))
    driver.wait(lambda: not dialog._apply_timer.isActive(), "the pause in typing")
    settled(window)
    assert figures(dialog.verdict.text())[:2] == [6, 0]
    assert dialog.start_button.isEnabled()
    driver.keep_picture(dialog, "model-settings-micmac")
    QTest.mouseClick(dialog.start_button, Qt.MouseButton.LeftButton)
    assert window.survey.reconstruction_job is None, "the user did not want it there after all"
    assert dialog.isVisible()
    QTest.mouseClick(dialog.start_button, Qt.MouseButton.LeftButton)
    driver.wait(lambda: window.survey.reconstruction_job is not None, "the work")
    assert window.survey.output_folder().is_relative_to(tmp_path / "first.vom")
    # The project is saved elsewhere while the work goes on.
    out = window.survey.output_folder()
    driver.wait(lambda: list((out / "work").glob("alignment-*[!t]")), "the alignment", 240.0)
    saved = tmp_path / "wall.vom"
    window.survey.stop_before_move()
    window.studio.save_as(saved)
    driver.wait(
        lambda: window.survey.reconstruction_job is not None, "the work in the new place", 30.0
    )
    assert window.survey.output_folder().is_relative_to(saved)
    driver.wait(lambda: window.survey.reconstruction_job is None, "the model", 300.0)
    result = window.survey.result
    assert result is not None
    assert result.registration["rms_control_m"] < 0.2
    assert result.settings["control"].endswith("Ground-Pts3D.xml")
    driver.wait(lambda: window.studio.models, "the model in the window", 60.0)
    window.studio.save()
    window.studio.new_project()
    assert window.survey.folder is None
    window.studio.open_project(saved)
    looked_at(window)
    driver.wait(lambda: window.studio.models, "the model of the project", 60.0)
    assert window.survey.folder == photos
    assert window.survey.settings.control == folder / "Ground-Pts3D.xml"
    assert window.survey.quality == "preview"
    made = json.loads((window.survey.output_folder() / "reconstruction.json").read_text())
    assert made["registered"] == 4


def test_the_proposed_region_is_a_box_in_the_outcrop(window, sample, outcrop) -> None:
    driver.open_outcrop(window, outcrop)
    window.open_path(sample)
    looked_at(window)
    dialog = open_dialog(window)
    assert not dialog.propose_button.isEnabled()
    assert not dialog.clip_button.isEnabled()
    out = window.survey.output_folder()
    out.mkdir(parents=True)
    (out / "cameras.json").write_text("{}")
    box = window.studio.models[next(iter(window.studio.models))].data.bounds
    low, high = np.floor(box[0]), np.floor(box.mean(axis=0)) + 0.5
    proposal = [*low.tolist(), *high.tolist()]
    (out / "reconstruction.json").write_text(json.dumps({"proposed_region": proposal}))
    window.survey.changed.emit()
    tick(dialog.options.fields["keep_background"])
    driver.wait(lambda: window.survey.settings.options.keep_background, "the tick")
    QTest.mouseClick(dialog.propose_button, Qt.MouseButton.LeftButton)
    assert window.survey.settings.options.box == tuple(proposal)
    assert window.studio.display.effective_clip == ClipBox(tuple(low), tuple(high))
    # The region alone decides now.
    assert not dialog.options.fields["keep_background"].isEnabled()
    driver.keep_picture(window, "region-proposed")
    driver.keep_picture(dialog, "region-settings")
    moved = window.studio.display.effective_clip.move_face(0, 1, float(high[0]) - 1.0)
    window.studio.display.set_clip(moved)
    driver.wait(lambda: window.survey.settings.options.box[3] == high[0] - 1.0, "the drag")
    # Text that was typed is not replaced by the box.
    retype(dialog.options.fields["region"], "0,0,0,1,1,1")
    driver.wait(lambda: not dialog._apply_timer.isActive(), "the pause in typing")
    window.studio.display.set_clip(moved.move_face(0, 1, float(high[0]) - 2.0))
    assert window.survey.settings.options.box == (0.0, 0.0, 0.0, 1.0, 1.0, 1.0)
    dialog.close()


def test_marks_written_later_are_picked_up(window, sample) -> None:
    marks = (sample.parent / "marks.csv").rename(sample.parent / "later.csv")
    window.open_path(sample)
    looked_at(window)
    settled(window)
    assert window.survey.settings.control is None
    marks.rename(sample.parent / "marks.csv")
    window.survey.update_control()
    settled(window)
    assert window.survey.settings.control == sample.parent / "control.csv"
    assert "control.registers" in shown_codes(findings(window))


def test_another_folder_of_the_same_name_gets_a_model_of_its_own(window, sample, tmp_path) -> None:
    other = tmp_path / "elsewhere" / "photos"
    other.mkdir(parents=True)
    made = window.studio.project.folder / "reconstruction" / "photos-medium"
    made.mkdir(parents=True)
    (made / "request.json").write_text(json.dumps({"photos": str(other), "quality": "medium"}))
    window.open_path(sample)
    assert window.survey.output_folder() == made.with_name("photos-2-medium")
    # Of photos that are gone nobody can say that they were others.
    other.rmdir()
    assert window.survey.output_folder() == made


@pytest.mark.usefixtures("new_window")
def test_untitled_reconstruction_prompts_on_closing_and_is_kept(window) -> None:
    folder = window.studio.project.folder
    stage = folder / "reconstruction" / "cliff-medium" / "work" / "alignment-1a2b"
    stage.mkdir(parents=True)
    seen: list[str] = []
    driver.answer(QMessageBox.StandardButton.Discard, seen)
    window.close()
    assert shown_values(seen[0], "project.save-changes") == {"project": "untitled"}
    assert stage.is_dir()


def test_settings_follow_the_dialog_controls(window, sample) -> None:
    window.open_path(sample)
    looked_at(window)
    settled(window)
    dialog = open_dialog(window)
    driver.wait(lambda: not dialog._apply_timer.isActive(), "the pause in typing")
    window.survey.set_quality("preview")
    assert dialog.options.options().quality == "preview"
    dialog.options.fields["seed"].setValue(7)
    driver.wait(lambda: not dialog._apply_timer.isActive(), "the pause in typing")
    assert window.survey.settings.options.seed == 7
    assert window.survey.settings.options.quality == "preview"
    assert window.survey.settings.control == sample.parent / "control.csv"
    dialog.close()


def test_the_region_and_the_device_belong_to_the_settings(window, sample) -> None:
    window.open_path(sample)
    looked_at(window)
    settled(window)
    dialog = open_dialog(window)
    region, device = dialog.options.fields["region"], dialog.options.fields["device"]
    retype(region, "0,0,0,10,20")
    driver.wait(lambda: not dialog._apply_timer.isActive(), "the pause in typing")
    assert not dialog.start_button.isEnabled()
    assert "region.not-a-box" in shown_codes(dialog.start_button.toolTip())
    assert window.survey.settings.options.region is None
    QTest.keyClicks(region, ",30")
    device.setFocus()
    QTest.keyClick(device, Qt.Key.Key_Down)
    driver.wait(lambda: not dialog._apply_timer.isActive(), "the pause in typing")
    settled(window)
    assert dialog.start_button.isEnabled()
    request = window.survey.settings.build_request(sample, sample.parent / "out")
    assert request.region == (0.0, 0.0, 0.0, 10.0, 20.0, 30.0)
    assert request.device == "cpu"
    driver.keep_picture(dialog, "model-settings-region")
    dialog.close()
