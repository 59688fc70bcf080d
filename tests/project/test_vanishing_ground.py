"""A project's folder goes away, is replaced or becomes unwritable while the project is open."""

from __future__ import annotations

import contextlib
import os
import shutil
import sqlite3
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.messages import refused
from tests.samples import bed
from tests.small_disk import failing_disk, fill, small_disk
from vomstudio.core.errors import TargetError
from vomstudio.core.findings import Finding
from vomstudio.geometry.frames import Frame
from vomstudio.project import edits
from vomstudio.project.assets import store_asset
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.journal.database import SqliteJournal, read_replay
from vomstudio.project.journal.failures import NotWritten
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.paths import JOURNAL_NAME
from vomstudio.project.photo_edits import add_photo_set, set_masks
from vomstudio.project.records import Mask, Model, PhotoSet
from vomstudio.project.verify import verify

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="open files cannot be taken away")

MODEL = Model("m1", "cliff", "/nowhere/cliff.obj", "mesh", "0" * 64, Frame("local"))
Told = list[Finding | None]


def add(project: ProjectFolder, name: str) -> None:
    project.session.apply(edits.add_trace(project.session.records, bed(name)))


def names(folder: Path) -> list[str]:
    return sorted(r.id for r in read_replay(folder).records.values() if isinstance(r, Trace))


@pytest.fixture
def disk(tmp_path: Path) -> Path:
    """A folder in which the project lies, and nothing else."""
    (tmp_path / "disk").mkdir()
    return tmp_path / "disk"


def begun(disk: Path) -> tuple[ProjectFolder, Told]:
    """A project with beds a (in the older copy too), b and c; open as in a window."""
    project = ProjectFolder.create(disk / "cliff.vom")
    project.session.apply(edits.add_model(project.session.records, MODEL))
    add(project, "a")
    project.session.save()
    project.close()
    shutil.copytree(disk / "cliff.vom", disk.parent / "older.vom")
    project = ProjectFolder.open(disk / "cliff.vom")
    add(project, "b")
    project.close()
    project = ProjectFolder.open(disk / "cliff.vom")
    told: Told = []
    project.buffer_unwritten_steps(told.append)
    add(project, "c")
    assert told == []
    return project, told


def deleted(folder: Path, older: Path) -> None:
    shutil.rmtree(folder)


def renamed(folder: Path, older: Path) -> None:
    folder.rename(folder.with_name("other.vom"))


def journal_removed(folder: Path, older: Path) -> None:
    (folder / JOURNAL_NAME).unlink()


def log_removed(folder: Path, older: Path) -> None:
    (folder / f"{JOURNAL_NAME}-wal").unlink()


def folder_replaced(folder: Path, older: Path) -> None:
    shutil.rmtree(folder)
    shutil.copytree(older, folder)


def file_replaced(folder: Path, older: Path) -> None:
    shutil.copyfile(older / JOURNAL_NAME, folder / "new")
    (folder / "new").replace(folder / JOURNAL_NAME)


def file_overwritten(folder: Path, older: Path) -> None:
    shutil.copyfile(older / JOURNAL_NAME, folder / JOURNAL_NAME)


def another_writer(folder: Path, older: Path) -> None:
    """A program on another machine, whose locks do not reach this one."""
    other = SqliteJournal(folder / JOURNAL_NAME)
    other.append("draft", after=None)
    other._db.close()


GOES: dict[str, tuple[Callable[[Path, Path], None], str]] = {
    "deleted": (deleted, "journal.folder-gone"),
    "renamed": (renamed, "journal.folder-gone"),
    "journal removed": (journal_removed, "journal.gone"),
    "log removed": (log_removed, "journal.replaced"),
    "folder replaced": (folder_replaced, "journal.replaced"),
    "file replaced": (file_replaced, "journal.replaced"),
    "file overwritten": (file_overwritten, "journal.replaced"),
    "another writer": (another_writer, "journal.replaced"),
}


def goes_on_and_can_be_saved(project: ProjectFolder, told: Told, code: str, target: Path) -> None:
    """The next edit is done, and told of; a save is not; saved elsewhere it is all there."""
    add(project, "d")
    assert [t.code for t in told if t] == [code]
    add(project, "e")
    project.session.undo()
    assert len(told) == 1, "said once"
    with refused(code, NotWritten):
        project.session.save()
    assert project.session.dirty
    project.save_as(target)
    assert told[-1] is None
    assert not project.session.dirty
    assert names(target) == ["a", "b", "c", "d"]
    project.session.redo()
    add(project, "f")
    assert names(target) == ["a", "b", "c", "d", "e", "f"]
    for _ in range(6):
        project.session.undo()
    assert project.session.features() == []
    assert project.session.records[MODEL.id] == MODEL
    project.close()
    assert verify(target).sound


@pytest.mark.parametrize("how", GOES)
def test_edits_continue_in_memory_and_can_be_saved_elsewhere(disk: Path, how: str) -> None:
    go, code = GOES[how]
    project, told = begun(disk)
    go(disk / "cliff.vom", disk.parent / "older.vom")
    goes_on_and_can_be_saved(project, told, code, disk.parent / "rescued.vom")


@pytest.mark.parametrize("how", ["folder replaced", "file replaced", "file overwritten"])
@pytest.mark.parametrize("saved", [True, False], ids=["saved elsewhere", "closed"])
def test_replacement_project_folder_is_not_modified(disk: Path, how: str, saved: bool) -> None:
    project, _ = begun(disk)
    folder, older = disk / "cliff.vom", disk.parent / "older.vom"
    GOES[how][0](folder, older)
    add(project, "d")
    project.journal.set_view("camera", [1, 2, 3])
    if saved:
        project.save_as(disk.parent / "rescued.vom")
    project.close()
    assert (folder / JOURNAL_NAME).read_bytes() == (older / JOURNAL_NAME).read_bytes()
    assert names(folder) == ["a"]
    ProjectFolder.open(folder).close()


def test_deleted_project_folder_is_not_recreated(disk: Path) -> None:
    project, _ = begun(disk)
    shutil.rmtree(project.folder)
    add(project, "d")
    with contextlib.suppress(Exception):
        store_asset(project.folder, b"x", ".png")
    project.close()
    assert not project.folder.exists()


def test_edit_without_failure_callback_raises_and_changes_nothing(disk: Path) -> None:
    """A command or a script: the edit is refused."""
    project, _ = begun(disk)
    project.close()
    project = ProjectFolder.open(disk / "cliff.vom")
    project.folder.rename(disk / "other.vom")
    with refused("journal.folder-gone", NotWritten):
        add(project, "d")
    assert "d" not in project.session.records
    project.close()
    assert names(disk / "other.vom") == ["a", "b", "c"]


def test_pending_steps_are_written_when_the_folder_returns(disk: Path) -> None:
    project, told = begun(disk)
    project.folder.rename(disk / "away.vom")
    add(project, "d")
    add(project, "e")
    (disk / "away.vom").rename(project.folder)
    add(project, "f")
    assert [t and t.code for t in told] == ["journal.folder-gone", None]
    project.session.save()
    assert names(project.folder) == ["a", "b", "c", "d", "e", "f"]
    project.close()
    assert verify(project.folder).sound


def test_identical_copy_of_the_journal_is_used_in_its_place(disk: Path) -> None:
    """A program that keeps folders in step replaces files by equal ones; a drive that was plugged
    in again has other numbers."""
    project, told = begun(disk)
    project.journal._db.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    shutil.copytree(
        project.folder, disk / "copy.vom", ignore=lambda *_: ["lock", f"{JOURNAL_NAME}-shm"]
    )
    project.folder.rename(disk / "away.vom")
    (disk / "copy.vom").rename(project.folder)
    add(project, "d")
    assert told == []
    assert names(project.folder) == ["a", "b", "c", "d"]
    assert names(disk / "away.vom") == ["a", "b", "c"]
    project.close()
    assert verify(project.folder).sound


def test_touched_journal_file_is_not_reported(disk: Path) -> None:
    project, told = begun(disk)
    os.utime(project.folder / JOURNAL_NAME)
    os.utime(project.folder / f"{JOURNAL_NAME}-wal")
    with contextlib.closing(sqlite3.connect(project.folder / JOURNAL_NAME)) as other:
        other.execute("SELECT count(*) FROM journal").fetchone()
    add(project, "d")
    assert told == []
    assert names(project.folder) == ["a", "b", "c", "d"]
    project.close()


def test_masks_of_a_missing_project_folder_can_be_saved_elsewhere(disk: Path) -> None:
    project, _ = begun(disk)
    session = project.session
    session.apply(add_photo_set(session.records, PhotoSet("p", "photos", "/nowhere/photos")))
    mask = store_asset(project.folder, b"a mask", ".png")
    session.apply(set_masks(session.records, "p", {"1.jpg": mask}, "Mask"))
    shutil.rmtree(project.folder)
    project.save_as(disk.parent / "rescued.vom")
    (kept,) = session.of(Mask)
    assert (disk.parent / "rescued.vom" / kept.file.path).read_bytes() == b"a mask"
    project.close()
    assert verify(disk.parent / "rescued.vom").sound


def masked(project: ProjectFolder, name: str, content: bytes) -> Mask:
    """A mask is drawn, as the window has it done."""
    session = project.session
    file = project.assets.store(content, ".png")
    session.apply(set_masks(session.records, "p", {name: file}, "Mask"))
    assert project.assets.path(file).read_bytes() == content
    return next(m for m in session.of(Mask) if m.file == file)


@pytest.mark.parametrize("how", GOES)
def test_masks_drawn_while_the_folder_is_missing_can_be_saved_elsewhere(
    disk: Path, how: str
) -> None:
    project, told = begun(disk)
    session, folder = project.session, project.folder
    session.apply(add_photo_set(session.records, PhotoSet("p", "photos", "/nowhere/photos")))
    first = masked(project, "1.jpg", b"before")
    go, code = GOES[how]
    go(folder, disk.parent / "older.vom")
    there = sorted(p.name for p in disk.rglob("*.png"))
    second = masked(project, "2.jpg", b"while it is gone")
    third = masked(project, "3.jpg", b"undone and done again")
    session.undo()
    session.redo()
    assert [t and t.code for t in told] == [code]
    if how in ("deleted", "renamed", "folder replaced"):
        assert sorted(p.name for p in disk.rglob("*.png")) == there
    rescued = disk.parent / "rescued.vom"
    project.save_as(rescued)
    for mask, content in (
        (first, b"before"),
        (second, b"while it is gone"),
        (third, b"undone and done again"),
    ):
        assert (rescued / mask.file.path).read_bytes() == content
        assert session.records[mask.id] == mask
    project.close()
    assert verify(rescued).sound
    assert len([r for r in read_replay(rescued).records.values() if isinstance(r, Mask)]) == 3


def test_pending_masks_are_written_before_the_rows_that_reference_them(disk: Path) -> None:
    project, told = begun(disk)
    session, folder = project.session, project.folder
    session.apply(add_photo_set(session.records, PhotoSet("p", "photos", "/nowhere/photos")))
    folder.rename(disk / "away.vom")
    mask = masked(project, "1.jpg", b"while it is away")
    (disk / "away.vom").rename(folder)
    add(project, "d")
    assert [t and t.code for t in told] == ["journal.folder-gone", None]
    assert (folder / mask.file.path).read_bytes() == b"while it is away"
    project.close()
    assert verify(folder).sound


def test_row_of_a_mask_stays_in_memory_if_the_disk_is_full(tmp_path: Path) -> None:
    with small_disk(tmp_path / "disk", 1024) as disk:
        project, told = begun(disk)
        session = project.session
        session.apply(add_photo_set(session.records, PhotoSet("p", "photos", "/nowhere/photos")))
        filler = fill(disk)
        with filler.open("r+b") as file:
            # Enough for a row.
            file.truncate(filler.stat().st_size - 100_000)
        content = os.urandom(300_000)
        mask = masked(project, "1.jpg", content)
        assert project.journal.has_pending_rows
        assert [t and t.code for t in told] == ["disk.full"]
        with refused("disk.full", NotWritten):
            session.save()
        assert mask.id not in read_replay(project.folder).records
        filler.unlink()
        session.save()
        assert (project.folder / mask.file.path).read_bytes() == content
        project.close()
        assert verify(disk / "cliff.vom").sound


# --- disks ------------------------------------------------------------------------------------
def test_edits_continue_in_memory_on_a_full_disk(tmp_path: Path) -> None:
    with small_disk(tmp_path / "disk", 1024) as disk:
        project, told = begun(disk)
        filler = fill(disk)
        for number in range(200):
            add(project, f"x{number:03d}")
            if told:
                break
        assert [t and t.code for t in told] == ["disk.full"]
        add(project, "y")
        with refused("disk.full", NotWritten):
            project.session.save()
        filler.unlink()
        project.session.save()
        assert [t and t.code for t in told] == ["disk.full", None]
        assert names(project.folder) == sorted(
            project.session.records.keys() & set(t.id for t in project.session.of(Trace))
        )
        fill(disk)
        while told[-1] is None:
            number += 1
            add(project, f"x{number:03d}")
        count = len(project.session.of(Trace))
        project.save_as(tmp_path / "rescued.vom")
        assert len(names(tmp_path / "rescued.vom")) == count
        project.close()


def test_edits_continue_in_memory_on_a_read_only_disk(tmp_path: Path) -> None:
    with failing_disk(tmp_path / "disk") as (disk, fail):
        project, told = begun(disk)
        fail()
        goes_on_and_can_be_saved(project, told, "disk.read-only", tmp_path / "rescued.vom")


def test_edits_continue_in_memory_after_the_drive_is_unmounted(tmp_path: Path) -> None:
    with small_disk(tmp_path / "disk", 4096) as disk:
        project, told = begun(disk)
        subprocess.run(["umount", "-l", str(disk)], check=True)
        try:
            goes_on_and_can_be_saved(project, told, "journal.folder-gone", tmp_path / "rescued.vom")
        finally:
            subprocess.run(["mount", "-t", "tmpfs", "tmpfs", str(disk)], check=True)


@pytest.mark.parametrize("how", ["deleted", "renamed"])
@pytest.mark.parametrize("taken_back", [False, True], ids=["compacted", "taken back"])
def test_edits_continue_in_memory_after_a_compaction(
    disk: Path, how: str, taken_back: bool
) -> None:
    project, told = begun(disk)
    project.session.save()
    project.compact()
    if taken_back:
        project.undo_compaction()
    GOES[how][0](disk / "cliff.vom", disk.parent / "older.vom")
    goes_on_and_can_be_saved(project, told, "journal.folder-gone", disk.parent / "rescued.vom")


def test_read_only_journal_connection_is_reopened_for_writing(
    tmp_path: Path,
) -> None:
    project = ProjectFolder.create(tmp_path / "a.vom")
    project.session.apply(edits.add_model(project.session.records, MODEL))
    # As SQLite does by itself where the disk refuses to open the file for writing.
    project.journal._db.execute("PRAGMA query_only = 1")
    add(project, "a")
    project.session.save()
    assert names(tmp_path / "a.vom") == ["a"]
    project.close()
    assert verify(tmp_path / "a.vom").sound


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can become another user")
def test_steps_in_another_users_project_stay_pending() -> None:
    told: Told = []
    with tempfile.TemporaryDirectory() as made:
        Path(made).chmod(0o755)
        folder = Path(made) / "a.vom"
        project = ProjectFolder.create(folder)
        # What is imported when it is needed lies where another user may not look.
        project.session.apply(edits.add_model(project.session.records, MODEL))
        add(project, "first")
        project.close()
        os.seteuid(65534)
        try:
            with refused("project.unwritable", TargetError):
                ProjectFolder.open(folder)
            project = ProjectFolder.open(folder, allow_unlocked=True)
            project.buffer_unwritten_steps(told.append)
            add(project, "second")
            assert project.journal.has_pending_rows
            assert project.cache.is_dir()
            assert not project.cache.is_relative_to(folder)
            project.close()
            assert not project.cache.exists()
        finally:
            os.seteuid(0)
        assert names(folder) == ["first"]
    assert [failure and failure.code for failure in told] == ["disk.no-permission"]


def test_project_locked_by_another_program_cannot_be_opened(
    tmp_path: Path,
) -> None:
    project = ProjectFolder.create(tmp_path / "a.vom")
    with refused("project.locked"):
        ProjectFolder.open(tmp_path / "a.vom", allow_unlocked=True)
    project.close()
