"""The project's place goes away under an open window: it is said, nothing is lost, and the work can
be saved elsewhere from where it is said."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest
from PySide6.QtCore import QPoint, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QFileDialog, QMessageBox, QPushButton

from tests import driver
from tests.journeys.test_mishaps import bed_on_model
from tests.journeys.test_photo_window import (  # noqa: F401
    NAMES,
    looked_at,
    on,
    open_by_double_click,
    photos,
    saved,
)
from tests.journeys.test_photo_window import (
    press as press_in,
)
from tests.small_disk import failing_disk, fill, small_disk
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.journal.database import read_replay
from vomstudio.project.journal.failures import is_lost
from vomstudio.project.paths import JOURNAL_NAME
from vomstudio.project.records import Mask
from vomstudio.project.verify import verify
from vomstudio.ui.commands.project_files import TITLES

pytestmark = [pytest.mark.full, pytest.mark.usefixtures("new_window")]


IN_MEMORY = TITLES["in-memory"].format(project="", unsaved="")


def begun(window, outcrop: Path, folder: Path) -> None:
    """A saved project with a bed, and one more bed since."""
    driver.open_outcrop(window, outcrop)
    bed_on_model(window, 0.0, "first")
    window.studio.save_as(folder)
    bed_on_model(window, 1.0, "second")
    driver.wait(lambda: not window.studio.jobs.jobs, "the layers", 120)
    assert not window.message_bar.isVisible()


def beds(folder: Path) -> list[str]:
    return sorted(r.name for r in read_replay(folder).records.values() if hasattr(r, "vertices"))


def press(window, words: str) -> None:
    (button,) = [b for b in window.message_bar.findChildren(QPushButton) if words in b.text()]
    QTest.mouseClick(button, Qt.MouseButton.LeftButton)


def said_and_saved(window, words: str, target: Path, monkeypatch, picture: str) -> None:
    """An edit is said to be in memory only; the button beside that saves all elsewhere."""
    studio = window.studio
    bed_on_model(window, 2.0, "third")
    assert [t.name for t in driver.traces(window)] == ["first", "second", "third"]
    assert window.table.model.rowCount() == 3
    assert words in window.message_bar.text
    assert window.message_bar.notice.code == "project.steps-in-memory"
    assert window.windowTitle().endswith(IN_MEMORY)
    driver.keep_picture(window, f"ground-{picture}")
    # Saving is not said where nothing is saved.
    failure = studio.project.write_failure
    if failure is not None and not is_lost(failure):
        driver.key(window, Qt.Key.Key_S, driver.CTRL)
        assert "elsewhere" in window.message_bar.text
        assert studio.session.dirty
        assert "was saved" not in window.messages.item(window.messages.count() - 1).text()
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(target), ""))
    press(window, "Save as")
    assert studio.project.folder == target
    assert not window.windowTitle().endswith(IN_MEMORY)
    assert not studio.session.dirty
    assert beds(target) == ["first", "second", "third"]
    for _ in range(3):
        driver.key(window, Qt.Key.Key_Z, driver.CTRL)
    assert driver.traces(window) == []
    for _ in range(3):
        driver.key(window, Qt.Key.Key_Z, driver.CTRL | Qt.KeyboardModifier.ShiftModifier)
    bed_on_model(window, 3.0, "fourth")
    assert beds(target) == ["first", "fourth", "second", "third"]
    studio.save()
    driver.keep_picture(window, f"ground-{picture}-saved")
    studio.new_project()
    assert verify(target).sound


@pytest.mark.parametrize("how", ["deleted", "renamed", "replaced", "journal removed"])
def test_missing_or_replaced_folder_is_reported_and_project_saved_elsewhere(
    window, outcrop, tmp_path, monkeypatch, how
):
    folder = tmp_path / "disk" / "cliff.vom"
    begun(window, outcrop, folder)
    older = tmp_path / "older.vom"
    if how == "deleted":
        shutil.rmtree(folder)
    elif how == "renamed":
        folder.rename(folder.with_name("other.vom"))
    elif how == "journal removed":
        (folder / JOURNAL_NAME).unlink()
    else:
        ProjectFolder.create(older).close()
        shutil.rmtree(folder)
        shutil.copytree(older, folder)
    words = "was replaced" if how == "replaced" else "no longer exists"
    said_and_saved(window, words, tmp_path / "rescued.vom", monkeypatch, how.replace(" ", "-"))
    if how == "deleted":
        assert not folder.exists(), "it is not made again"
    elif how == "renamed":
        assert beds(folder.with_name("other.vom")) == ["first", "second"]
    elif how == "replaced":
        assert (folder / JOURNAL_NAME).read_bytes() == (older / JOURNAL_NAME).read_bytes()


def test_full_disk_is_reported_and_project_saved_elsewhere(window, outcrop, tmp_path, monkeypatch):
    with small_disk(tmp_path / "disk", 2048) as disk:
        begun(window, outcrop, disk / "cliff.vom")
        fill(disk)
        # The log has some room left in its last page.
        while not window.message_bar.isVisible():
            window.studio.undo()
            window.studio.redo()
        said_and_saved(window, "is full", tmp_path / "rescued.vom", monkeypatch, "full")


def test_read_only_disk_is_reported_and_project_saved_elsewhere(
    window, outcrop, tmp_path, monkeypatch
):
    with failing_disk(tmp_path / "disk") as (disk, fail):
        begun(window, outcrop, disk / "cliff.vom")
        fail()
        said_and_saved(window, "is read-only", tmp_path / "rescued.vom", monkeypatch, "read-only")


def test_removed_drive_is_reported_and_project_saved_elsewhere(
    window, outcrop, tmp_path, monkeypatch
):
    with small_disk(tmp_path / "disk", 8192) as disk:
        begun(window, outcrop, disk / "cliff.vom")
        subprocess.run(["umount", "-l", str(disk)], check=True)
        try:
            said_and_saved(
                window, "no longer exists", tmp_path / "rescued.vom", monkeypatch, "drive"
            )
        finally:
            subprocess.run(["mount", "-t", "tmpfs", "tmpfs", str(disk)], check=True)


def test_closing_asks_if_the_saved_project_folder_is_gone(own_folders, qtbot, outcrop, tmp_path):
    window = driver.make_window()
    folder = tmp_path / "cliff.vom"
    begun(window, outcrop, folder)
    window.studio.save()
    driver.wait(lambda: not window.studio.jobs.jobs, "the layers", 120)
    shutil.rmtree(folder)
    seen: list[str] = []
    driver.answer(QMessageBox.StandardButton.Cancel, seen)
    assert not window.close()
    assert seen
    driver.answer(QMessageBox.StandardButton.Discard, seen)
    assert window.close()
    driver.delete(window)
    assert not folder.exists()


def test_masks_can_be_drawn_after_the_folder_is_gone(looked_at, tmp_path, monkeypatch):  # noqa: F811
    """They are steps as all others are: in memory, undone and done again, and saved elsewhere."""
    window, studio = looked_at, looked_at.studio
    studio.save_as(tmp_path / "disk" / "cliff.vom")
    photo = open_by_double_click(window, 0)
    press_in(photo, Qt.Key.Key_B)
    driver.drag(photo.canvas, on(photo, 300, 100), on(photo, 700, 100))
    saved(photo)
    shutil.rmtree(studio.project.folder)
    driver.drag(photo.canvas, on(photo, 300, 600), on(photo, 700, 600))
    saved(photo)
    used = photo.masks.used(NAMES[0])
    assert not used[100, 500]
    assert not used[600, 500]
    assert window.message_bar.notice.code == "project.steps-in-memory"
    driver.keep_picture(photo, "ground-mask-photo")
    driver.keep_picture(window, "ground-mask")
    press_in(photo, Qt.Key.Key_Z, driver.CTRL)
    assert photo.masks.used(NAMES[0])[600, 500]
    press_in(photo, Qt.Key.Key_Z, driver.CTRL | Qt.KeyboardModifier.ShiftModifier)
    assert not photo.masks.used(NAMES[0])[600, 500]
    # Another photo, and back: the mask of the first is read again.
    photo.actions_table.run("repeat_mask")
    saved(photo)
    assert not studio.project.folder.exists()
    target = tmp_path / "rescued.vom"
    monkeypatch.setattr(QFileDialog, "getSaveFileName", lambda *_: (str(target), ""))
    press(window, "Save as")
    masks = [r for r in read_replay(target).records.values() if isinstance(r, Mask)]
    assert sorted(m.photo for m in masks) == sorted(NAMES)
    assert all((target / m.file.path).stat().st_size == m.file.size for m in masks)
    studio.new_project()
    assert verify(target).sound


def test_files_truncated_while_open_do_not_crash_the_window(window, outcrop, tmp_path, monkeypatch):
    """As where a stick is pulled while it is read: what was read is there, and no signal comes."""
    folder = tmp_path / "disk" / "cliff.vom"
    begun(window, outcrop, folder)
    for place in (folder, outcrop):
        for path in place.rglob("*"):
            if path.is_file() and path.name != "lock":
                os.truncate(path, path.stat().st_size // 3)
    driver.drag(window.viewport, QPoint(300, 300), QPoint(500, 350))
    said_and_saved(window, "was replaced", tmp_path / "rescued.vom", monkeypatch, "shorter")
