"""Where projects are, who holds them, and what their folder takes along and leaves behind."""

from __future__ import annotations

import gc
import os
import shutil
import sqlite3
import weakref
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from tests.messages import refused
from tests.samples import bed
from vomstudio.core.errors import InputError, TargetError
from vomstudio.core.files.lock import ProjectLock
from vomstudio.core.findings import Finding
from vomstudio.geometry.frames import Frame
from vomstudio.project import edits, reconstructions
from vomstudio.project import folder as folders
from vomstudio.project.folder import (
    ProjectFolder,
    create_untitled,
    is_free,
    project_folder,
    untitled_folder,
    untitled_projects,
)
from vomstudio.project.journal.database import SqliteJournal, read_replay
from vomstudio.project.paths import is_project
from vomstudio.project.reconstructions import RECONSTRUCTIONS
from vomstudio.project.records import Model
from vomstudio.project.session import DISCARD_LABEL

MODEL = Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64, Frame("local"))
OF_ANOTHER_DAY = b"of another day"


@pytest.fixture
def project(tmp_path: Path) -> ProjectFolder:
    made = ProjectFolder.create(tmp_path / "a.vom")
    made.session.apply(edits.add_model(made.session.records, MODEL))
    return made


@pytest.fixture
def is_untitled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(folders, "untitled_folder", lambda: tmp_path / "state" / "untitled")
    return tmp_path / "state" / "untitled"


def add_bed(project: ProjectFolder, name: str = "t1") -> None:
    project.session.apply(edits.add_trace(project.session.records, bed(name)))


# --- making and opening --------------------------------------------------------------------------
def test_closed_project_is_freed_immediately_with_its_records(project: ProjectFolder) -> None:
    add_bed(project)
    project.close()
    opened = ProjectFolder.open(project.folder)
    opened.buffer_unwritten_steps(lambda _: None)
    held = weakref.ref(opened), weakref.ref(opened.session.records["t1"])
    gc.collect()
    gc.disable()
    try:
        opened.close()
        del opened
        assert [each() for each in held] == [None, None]
    finally:
        gc.enable()


def test_project_is_created_with_its_parent_folders_or_in_an_existing_one(
    tmp_path: Path,
) -> None:
    for folder in (tmp_path / "far" / "away" / "a.vom", tmp_path / "far" / "b.vom"):
        folder.parent.mkdir(exist_ok=True, parents=True)
        if folder.name == "b.vom":
            folder.mkdir()
        ProjectFolder.create(folder).close()
        assert is_project(folder)
    ProjectFolder.create(tmp_path / "new" / "er" / "c.vom").close()
    assert is_project(tmp_path / "new" / "er" / "c.vom")


def test_folder_that_cannot_be_created_is_reported(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(OF_ANOTHER_DAY)
    with refused("folder.not-created", TargetError) as caught:
        ProjectFolder.create(tmp_path / "file" / "a.vom")
    assert "a.vom" in str(caught.value)


def test_existing_project_is_neither_replaced_nor_locked(project: ProjectFolder) -> None:
    add_bed(project)
    for _ in range(2):
        # Whether it is open in a window or not: another name is what is needed.
        with refused("project.exists", TargetError):
            ProjectFolder.create(project.folder)
        project.close()
    assert is_free(project.folder)
    assert "t1" in read_replay(project.folder).records


def test_project_can_be_opened_once_and_is_free_after_closing(project: ProjectFolder) -> None:
    assert not is_free(project.folder)
    with refused("project.locked") as caught:
        ProjectFolder.open(project.folder)
    assert str(os.getpid()) in str(caught.value.values["holder"])
    project.close()
    assert is_free(project.folder)
    ProjectFolder.open(project.folder).close()
    assert is_free(project.folder)
    assert not is_free(project.folder.parent)


def test_project_that_failed_to_open_is_not_locked(project: ProjectFolder) -> None:
    """Once it is restored from a copy it opens, without the program being started anew."""
    project.close()
    path = project.folder / "journal.sqlite"
    whole = path.read_bytes()
    path.write_bytes(whole[:2000])
    with pytest.raises(InputError):
        ProjectFolder.open(project.folder)
    assert is_free(project.folder)
    path.write_bytes(whole)
    ProjectFolder.open(project.folder).close()


def test_project_that_failed_to_be_created_is_not_locked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object, **__: object) -> None:
        raise TargetError("the disk is full")

    with monkeypatch.context() as patch:
        patch.setattr(folders, "SqliteJournal", full)
        with pytest.raises(TargetError, match="full") as caught:
            ProjectFolder.create(tmp_path / "a.vom")
        assert caught.value is not None
        ProjectLock(tmp_path / "a.vom" / "lock").release()
    ProjectFolder.create(tmp_path / "a.vom").close()


def test_damaged_lock_does_not_prevent_opening(project: ProjectFolder) -> None:
    project.close()
    (project.folder / "lock").write_bytes(OF_ANOTHER_DAY * 100)
    assert is_free(project.folder)
    ProjectFolder.open(project.folder).close()


def test_folder_that_cannot_be_locked_is_not_reported_as_free(project: ProjectFolder) -> None:
    project.close()
    (project.folder / "lock").unlink()
    (project.folder / "lock").mkdir()
    assert not is_free(project.folder)
    with refused("project.unwritable", TargetError):
        ProjectFolder.open(project.folder)


def test_project_is_identified_by_its_folder_or_a_file_in_it(tmp_path: Path) -> None:
    ProjectFolder.create(tmp_path / "a.vom").close()
    ProjectFolder.create(tmp_path / "plain").close()
    (tmp_path / "a.vom" / "notes.txt").write_text("x")
    (tmp_path / "plain" / "notes.txt").write_text("x")
    for path in (tmp_path / "a.vom", tmp_path / "a.vom" / "notes.txt"):
        assert project_folder(path) == tmp_path / "a.vom"
        assert is_project(path)
    assert project_folder(tmp_path / "plain") == tmp_path / "plain"
    assert is_project(tmp_path / "plain")
    # A folder of any name may hold a project, but not everything in it names that.
    assert not is_project(tmp_path / "plain" / "notes.txt")
    with refused("project.not-a-project"):
        project_folder(tmp_path / "plain" / "notes.txt")
    assert not is_project(tmp_path)
    assert not is_project(tmp_path / "none.vom")
    with refused("project.missing"):
        project_folder(tmp_path / "none.vom")


def test_project_has_a_name_and_a_cache_folder(project: ProjectFolder, is_untitled: Path) -> None:
    assert (project.name, project.is_untitled) == ("a", False)
    assert project.cache == project.folder / "cache"
    project.close()
    nameless = create_untitled()
    assert nameless.is_untitled
    assert nameless.folder.parent == is_untitled
    nameless.close()


def test_settings_are_stored_with_edits_after_opening_and_saving_as(tmp_path: Path) -> None:
    told: dict[str, Any] = {"n": 1}
    ProjectFolder.create(tmp_path / "a.vom", settings=lambda: told).close()
    assert read_replay(tmp_path / "a.vom").settings == {"n": 1}
    told = {"n": 2}
    project = ProjectFolder.open(tmp_path / "a.vom", settings=lambda: told)
    project.session.apply(edits.add_model(project.session.records, MODEL))
    project.save_as(tmp_path / "b.vom")
    assert read_replay(tmp_path / "b.vom").settings == {"n": 2}
    told = {"n": 3}
    add_bed(project)
    project.close()
    assert read_replay(tmp_path / "b.vom").settings == {"n": 3}


# --- models --------------------------------------------------------------------------------------
def test_model_paths_inside_the_project_are_relative(
    project: ProjectFolder, tmp_path: Path
) -> None:
    inside, outside = project.folder / "models" / "a" / "a.obj", tmp_path / "b.obj"
    assert project.model_path(inside) == "models/a/a.obj"
    assert project.model_path(outside) == str(outside.resolve())
    assert project.model_path(project.folder / ".." / "b.obj") == str(outside.resolve())
    project.close()


def test_model_is_searched_at_its_path_then_in_and_beside_the_project(
    project: ProjectFolder, tmp_path: Path
) -> None:
    """Whoever moves a project together with its models finds them, and never another's first."""
    elsewhere = tmp_path / "far" / "cliff.obj"
    inside, beside = project.folder, project.folder.parent
    places = [
        elsewhere,
        inside / "cliff.obj",
        inside / "models" / "cliff.obj",
        beside / "cliff.obj",
    ]
    for place in places:
        place.parent.mkdir(exist_ok=True)
        place.write_text("v 0 0 0")
    away = replace(MODEL, path=str(elsewhere))
    for number, place in enumerate(places):
        assert project.find_model(away) == place
        place.unlink()
        assert project.find_model(away) == next(iter(places[number + 1 :]), None)
    own = project.folder / "models" / "deep" / "cliff.obj"
    own.parent.mkdir()
    own.write_text("v 0 0 0")
    assert project.find_model(replace(MODEL, path="models/deep/cliff.obj")) == own
    assert project.find_model(replace(MODEL, path="models/deep")) is None
    project.close()


# --- saving under another name -------------------------------------------------------------------
def test_saving_as_copies_project_files_but_not_the_cache(
    project: ProjectFolder, tmp_path: Path
) -> None:
    along = ["models/a/a.obj", "photos/cliff-1/marks.csv", "assets/0.png"]
    for name in (*along, "cache/tiles.bin"):
        (project.folder / name).parent.mkdir(parents=True)
        (project.folder / name).write_text(name)
    held = project._lock
    project.save_as(tmp_path / "far" / "b.vom")
    assert held is not project._lock
    assert not list((tmp_path / "a.vom").glob("journal.sqlite-*"))
    new = tmp_path / "far" / "b.vom"
    assert project.folder == new
    assert [(new / name).read_text() for name in along] == along
    assert not (new / "cache").exists()
    assert (tmp_path / "a.vom" / "cache" / "tiles.bin").exists()
    assert not project.session.dirty
    assert is_free(tmp_path / "a.vom")
    assert not is_free(new)
    assert sorted(p.name for p in new.parent.iterdir()) == ["b.vom"]
    project.close()
    assert is_free(new)


def test_saving_as_accepts_an_empty_folder_and_a_failed_earlier_attempt(
    project: ProjectFolder, tmp_path: Path
) -> None:
    (tmp_path / "b.vom").mkdir()
    (tmp_path / "b.vom.part").mkdir()
    (tmp_path / "b.vom.part" / "journal.sqlite").write_bytes(OF_ANOTHER_DAY)
    project.save_as(tmp_path / "b.vom")
    assert "m1" in read_replay(tmp_path / "b.vom").records
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.vom", "b.vom"]
    project.close()


def test_saving_as_does_not_replace_a_file(project: ProjectFolder, tmp_path: Path) -> None:
    (tmp_path / "b.vom").write_bytes(OF_ANOTHER_DAY)
    with refused("output.exists", TargetError):
        project.save_as(tmp_path / "b.vom")
    assert (tmp_path / "b.vom").read_bytes() == OF_ANOTHER_DAY
    project.close()


def test_save_target_that_cannot_be_created_is_reported(
    project: ProjectFolder, tmp_path: Path
) -> None:
    (tmp_path / "file").write_bytes(OF_ANOTHER_DAY)
    with refused("output.unwritable", TargetError) as caught:
        project.save_as(tmp_path / "file" / "b.vom")
    assert "b.vom" in str(caught.value)
    assert project.folder == tmp_path / "a.vom"
    project.close()


@pytest.mark.parametrize(
    "failure", [OSError(28, "No space left"), TargetError(Finding("disk.full"))]
)
def test_failed_saving_leaves_no_files_and_work_continues_in_the_old_project(
    project: ProjectFolder, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, failure: Exception
) -> None:
    def full(*_: object, **__: object) -> None:
        raise failure

    (project.folder / "models").mkdir()
    with monkeypatch.context() as patch:
        if isinstance(failure, OSError):
            patch.setattr(shutil, "copytree", full)
        else:
            patch.setattr(SqliteJournal, "copy_to", full)
        with refused("disk.full", TargetError) as caught:
            project.save_as(tmp_path / "b.vom")
    assert isinstance(failure, TargetError) or "b.vom" in str(caught.value)
    assert [p.name for p in tmp_path.iterdir()] == ["a.vom"]
    assert project.folder == tmp_path / "a.vom"
    assert project.session.dirty
    add_bed(project)
    project.close()
    assert "t1" in read_replay(tmp_path / "a.vom").records


def test_saved_old_project_is_not_written_to_by_saving_as(
    project: ProjectFolder, tmp_path: Path
) -> None:
    add_bed(project)
    project.session.save()
    rows = list(project.journal.rows())
    project.save_as(tmp_path / "b.vom")
    project.close()
    left = SqliteJournal(tmp_path / "a.vom" / "journal.sqlite")
    assert list(left.rows()) == rows
    left.close()


def test_saving_as_moves_unsaved_work_and_keeps_it_undoable_in_the_old_project(
    project: ProjectFolder, tmp_path: Path
) -> None:
    project.session.save()
    add_bed(project)
    project.save_as(tmp_path / "b.vom")
    project.close()
    assert "t1" in read_replay(tmp_path / "b.vom").records
    left = read_replay(tmp_path / "a.vom")
    assert "t1" not in left.records
    assert left.done[-1][1].label == DISCARD_LABEL
    assert left.top == left.saved_top


def test_untitled_project_keeps_its_unsaved_work_when_named(
    is_untitled: Path, tmp_path: Path
) -> None:
    project = create_untitled()
    project.session.apply(edits.add_model(project.session.records, MODEL))
    add_bed(project)
    left = project.folder
    project.save_as(tmp_path / "b.vom")
    assert not left.exists()
    assert not project.is_untitled
    kept = read_replay(tmp_path / "b.vom")
    assert {"m1", "t1"} <= set(kept.records)
    assert kept.top == kept.saved_top
    project.close()


def test_small_reconstruction_files_are_never_hard_linked_but_large_ones_may_be(
    project: ProjectFolder, tmp_path: Path
) -> None:
    """A line that a later run adds to its log must not appear in the project left behind."""
    work = project.folder / RECONSTRUCTIONS / "cliff" / "work" / "depths-1"
    work.mkdir(parents=True)
    sizes = {"small": 1 << 20, "large": (1 << 20) + 1}
    for name, size in sizes.items():
        (work / name).write_bytes(bytes(size))
    project.save_as(tmp_path / "b.vom")
    new = tmp_path / "b.vom" / RECONSTRUCTIONS / "cliff" / "work" / "depths-1"
    assert {name: (new / name).stat().st_size for name in sizes} == sizes
    shared = {name: os.path.samefile(new / name, work / name) for name in sizes}
    assert shared == {"small": False, "large": True}
    project.close()


def test_files_are_copied_if_hard_links_are_not_supported(
    project: ProjectFolder, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr(os, "link", refuse)
    large = project.folder / RECONSTRUCTIONS / "cliff" / "dense.laz"
    large.parent.mkdir(parents=True)
    large.write_bytes(b"7" * 2_000_000)
    project.save_as(tmp_path / "b.vom")
    new = tmp_path / "b.vom" / RECONSTRUCTIONS / "cliff" / "dense.laz"
    assert new.read_bytes() == large.read_bytes()
    project.close()


# --- projects without a name ---------------------------------------------------------------------
def test_untitled_projects_are_in_the_state_folder_of_the_user(own_folders: Path) -> None:
    assert untitled_folder() == own_folders / "xdg_state_home" / "vomstudio" / "untitled"


def test_projects_created_in_the_same_second_have_different_names(
    is_untitled: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(folders.time, "strftime", lambda _: "20260203-101112")
    projects = [create_untitled(settings=lambda: {"n": 1}) for _ in range(3)]
    assert [project.folder.name for project in projects] == [
        "20260203-101112.vom",
        "20260203-101112-2.vom",
        "20260203-101112-3.vom",
    ]
    assert read_replay(projects[2].folder).settings == {"n": 1}
    for project in projects:
        project.close()
    assert list(is_untitled.iterdir()) == []


@pytest.mark.parametrize("held", ["nothing", "a model", "a feature", "an undone feature", "clicks"])
def test_untitled_project_is_kept_if_anything_was_measured_in_it(
    is_untitled: Path, held: str
) -> None:
    project = create_untitled()
    session = project.session
    if held != "nothing":
        session.apply(edits.add_model(session.records, MODEL))
    if held == "clicks":
        session.set_draft({"tool": "trace", "vertices": [[0.0, 0.0, 0.0]]})
    elif "feature" in held:
        add_bed(project)
    if held.startswith("an undone"):
        session.undo()
    project.cache.mkdir()
    project.close()
    assert project.folder.exists() == (held not in ("nothing", "a model"))
    assert not project.cache.exists()


@pytest.mark.parametrize("way", ["closing", "saving as", "a saving that fails", "moving"])
def test_files_that_cannot_be_removed_cause_no_failure(
    is_untitled: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, way: str
) -> None:
    """Another program may have a file open in a folder that is not needed any more."""
    project = create_untitled()
    folder = project.folder

    def held(*_: object, **__: object) -> None:
        raise PermissionError(13, "The file is in use")

    def full(*_: object) -> None:
        raise TargetError(Finding("disk.full"))

    with monkeypatch.context() as patch:
        patch.setattr(os, "rmdir", held)
        if way == "closing":
            project.close()
            assert folder.exists()
        elif way == "saving as":
            project.save_as(tmp_path / "b.vom")
            assert project.folder == tmp_path / "b.vom"
        elif way == "moving":
            (folder / RECONSTRUCTIONS / "cliff").mkdir(parents=True)
            patch.setattr(reconstructions, "copy_reconstructions", held)
            patch.setattr(folders, "_is_same_disk", lambda *_: True)
            rename = Path.rename
            patch.setattr(
                Path, "rename", lambda s, t: held() if s.name == RECONSTRUCTIONS else rename(s, t)
            )
            with refused("reconstruction.not-moved", TargetError):
                project.save_as(tmp_path / "b.vom")
        else:
            patch.setattr(SqliteJournal, "copy_to", full)
            with refused("disk.full", TargetError):
                project.save_as(tmp_path / "b.vom")
    if way != "closing":
        project.close()


def test_project_with_a_removed_folder_can_be_closed(is_untitled: Path) -> None:
    project = create_untitled()
    shutil.rmtree(project.folder)
    project.close()
    assert not project.folder.exists()


def test_cache_of_a_named_project_is_kept(project: ProjectFolder) -> None:
    project.cache.mkdir()
    project.close()
    assert project.cache.exists()


def test_projects_left_by_a_crash_are_offered_newest_first(
    is_untitled: Path,
) -> None:
    """Left behind: open work, an open trace, and what cannot even be read. Finished: discarded."""
    made = {}
    for number, kind in enumerate(("discarded", "work", "clicks", "damaged", "held")):
        project = ProjectFolder.create(is_untitled / f"{kind}.vom")
        project.session.apply(edits.add_model(project.session.records, MODEL))
        add_bed(project)
        if kind == "discarded":
            project.session.discard_unsaved()
        elif kind == "clicks":
            project.session.save()
            project.session.set_draft({"tool": "trace", "vertices": []})
        if kind != "held":
            project.close()
        path = project.folder / "journal.sqlite"
        if kind == "damaged":
            path.write_bytes(OF_ANOTHER_DAY * 1000)
        os.utime(path, (1e9 + number, 1e9 + number))
        made[kind] = project
    (is_untitled / "empty.vom").mkdir()
    left = untitled_projects(finished=False)
    assert [folder.stem for folder in left] == ["damaged", "clicks", "work"]
    assert [folder.stem for folder in untitled_projects(finished=True)] == ["discarded"]
    made["held"].close()


def test_project_that_disappears_while_listing_causes_no_error(
    is_untitled: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("a", "b"):
        project = ProjectFolder.create(is_untitled / f"{name}.vom")
        project.session.apply(edits.add_model(project.session.records, MODEL))
        add_bed(project)
        project.close()
    stat = Path.stat

    def gone(self: Path, **values: Any) -> os.stat_result:
        if self == is_untitled / "a.vom" / "journal.sqlite":
            shutil.rmtree(self.parent, ignore_errors=True)
        return stat(self, **values)

    monkeypatch.setattr(Path, "stat", gone)
    assert [folder.stem for folder in untitled_projects(finished=False)] == ["b"]


# --- the lock ------------------------------------------------------------------------------------
def test_a_lock_is_held_until_it_is_released(tmp_path: Path) -> None:
    lock = ProjectLock(tmp_path / "lock")
    with closing(sqlite3.connect(tmp_path / "lock")) as db:
        assert db.execute("SELECT pid FROM holder").fetchall() == [(os.getpid(),)]
    with refused("project.locked"):
        ProjectLock(tmp_path / "lock")
    lock.release()
    ProjectLock(tmp_path / "lock").release()
