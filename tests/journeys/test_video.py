"""Frames of a video become photos of a model, in the window."""

from __future__ import annotations

from html import unescape

import cv2
import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QMessageBox

from tests import driver
from tests.messages import shown_codes, shown_values
from tests.photogrammetry.survey.test_video import film
from vomstudio.ui.dialogs.video_dialog import VideoDialog


@pytest.fixture
def dialog(window):
    window.actions_table.all["video_frames"].trigger()
    (made,) = window.findChildren(VideoDialog)
    QTest.qWaitForWindowExposed(made)
    return made


def press(button) -> None:
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)


@pytest.mark.full
def test_video_frames_are_extracted_and_opened_as_photos(window, dialog, tmp_path) -> None:
    blurs = [0.0] * 100 + [6.0] * 20
    offsets = [*np.arange(100) * 12.0, *[1188.0] * 20]
    video = film(tmp_path / "pan.avi", offsets, blurs, size=(1200, 560))
    assert not dialog.start_button.isEnabled()
    dialog.choose_video(video)
    assert dialog.folder.text() == str(tmp_path / "pan frames")
    dialog.options.fields["fps"].setFocus()
    dialog.options.fields["fps"].selectAll()
    QTest.keyClicks(dialog.options.fields["fps"], "4")
    press(dialog.start_button)
    assert [job.title for job in window.studio.jobs.visible()] == ["Frames of pan.avi"]
    driver.wait(lambda: dialog._job is None, "the frames", 120.0)
    said = dialog.result_label.text()
    kept = len(list((tmp_path / "pan frames").glob("*.jpg")))
    assert kept >= 15
    assert shown_values(said, "video.frames-kept")["count"] == str(kept)
    left_out = [line for line in said.split("<br>") if "video.frames-left-out" in shown_codes(line)]
    reasons = {shown_values(line, "video.frames-left-out")["reason"] for line in left_out}
    assert "blurred" in reasons
    assert shown_values(said, "video.usable")["count"] == str(kept)
    driver.keep_picture(dialog, "video")
    driver.wait(lambda: len(window.survey.rows) == kept, "the frames as photos", 60.0)
    assert window.survey.folder == tmp_path / "pan frames"
    driver.keep_picture(window, "video-photos")


@pytest.mark.full
def test_unusable_video_is_reported(window, dialog, tmp_path) -> None:
    dialog.choose_video(film(tmp_path / "bad.avi", np.arange(80) * 10.0, [0.0] * 20 + [7.0] * 60))
    press(dialog.start_button)
    driver.wait(lambda: dialog._job is None, "the verdict", 120.0)
    assert "video.blurred" in shown_codes(unescape(dialog.result_label.text()))


@pytest.mark.full
def test_invalid_video_file_is_reported_in_the_dialog(window, dialog, tmp_path) -> None:
    (tmp_path / "notes.mp4").write_text("rain")
    dialog.choose_video(tmp_path / "notes.mp4")
    press(dialog.start_button)
    driver.wait(lambda: dialog._job is None, "the reason", 60.0)
    assert "video.not-a-video" in shown_codes(dialog.result_label.text())
    assert not (tmp_path / "notes frames").exists()


@pytest.mark.full
def test_extraction_can_be_stopped_and_leaves_no_files(window, dialog, tmp_path) -> None:
    path = tmp_path / "long.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 20, (1920, 1080))
    noise = np.random.default_rng(3).integers(0, 255, (1080, 1920, 3), np.uint8)
    for i in range(300):
        writer.write(np.roll(noise, 40 * i, axis=1))
    writer.release()
    dialog.choose_video(path)
    press(dialog.start_button)
    driver.wait(lambda: dialog._job is not None and dialog._job.done > 10, "some work", 60.0)
    driver.keep_picture(dialog, "video-working")
    press(dialog.stop_button)
    driver.wait(lambda: dialog._job is None, "the stop", 15.0)
    assert "Stopped" in dialog.result_label.text()
    assert not (tmp_path / "long frames").exists()
    assert window.survey.folder is None


@pytest.mark.full
def test_folder_with_other_files_asks_for_confirmation(window, dialog, tmp_path) -> None:
    (tmp_path / "own").mkdir()
    (tmp_path / "own" / "thesis.txt").write_text("years")
    dialog.choose_video(film(tmp_path / "pan.avi", np.arange(40) * 12.0))
    dialog.folder.setText(str(tmp_path / "own"))
    seen: list[str] = []
    driver.answer(QMessageBox.StandardButton.No, seen)
    press(dialog.start_button)
    assert shown_values(seen[0], "video.folder-not-empty") == {"folder": "own"}
    assert dialog._job is None
    assert [p.name for p in (tmp_path / "own").iterdir()] == ["thesis.txt"]


@pytest.mark.full
def test_video_dialog_can_be_closed_while_extraction_continues(window, dialog, tmp_path) -> None:
    dialog.choose_video(film(tmp_path / "pan.avi", np.arange(60) * 12.0))
    press(dialog.start_button)
    dialog.close()
    driver.wait(lambda: not window.findChildren(VideoDialog), "its end")
    driver.wait(lambda: window.survey.rows, "the photos", 120.0)
