"""What was made of photos belongs to its project, and goes where the project goes."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from tests.messages import refused
from vomstudio.core.errors import TargetError
from vomstudio.core.files.lock import FolderLock
from vomstudio.project import folder as projects
from vomstudio.project import reconstructions
from vomstudio.project.folder import ProjectFolder, create_untitled
from vomstudio.project.imports.sidecar_import import PHOTO_TABLES
from vomstudio.project.reconstructions import RECONSTRUCTIONS


@pytest.fixture
def untitled(tmp_path, monkeypatch) -> ProjectFolder:
    monkeypatch.setattr(projects, "untitled_folder", lambda: tmp_path / "state" / "untitled")
    return create_untitled()


def reconstruct(folder: Path, size: int = 3_000_000) -> Path:
    """As far as a project sees it: one finished stage, one begun, and the model."""
    out = folder / RECONSTRUCTIONS / "cliff-medium"
    (out / "work" / "alignment-1a2b").mkdir(parents=True)
    (out / "work" / "alignment-1a2b" / "database.db").write_bytes(b"7" * size)
    (out / "work" / "depths-3c4d.part").mkdir()
    (out / "work" / "depths-3c4d.part" / "half").write_bytes(b"x")
    (out / "work" / "lock").write_bytes(b"held")
    (out / "model.obj").write_text("v 0 0 0")
    (out / "log.txt").write_text("begun")
    return out


def test_saving_untitled_project_moves_its_reconstruction(untitled, tmp_path):
    old = reconstruct(untitled.folder)
    left = untitled.folder
    untitled.save_as(tmp_path / "a.vom")
    out = tmp_path / "a.vom" / RECONSTRUCTIONS / "cliff-medium"
    assert (out / "model.obj").read_text() == "v 0 0 0"
    assert (out / "work" / "alignment-1a2b" / "database.db").stat().st_size == 3_000_000
    # It is moved, unfinished stages too: the work goes on there.
    assert (out / "work" / "depths-3c4d.part" / "half").exists()
    assert not old.exists()
    assert not left.exists()
    untitled.close()
    assert out.is_dir()


def test_reconstruction_is_copied_to_another_disk(untitled, tmp_path, monkeypatch):
    monkeypatch.setattr(projects, "_is_same_disk", lambda *_: False)
    reconstruct(untitled.folder)
    untitled.save_as(tmp_path / "a.vom")
    out = tmp_path / "a.vom" / RECONSTRUCTIONS / "cliff-medium"
    assert (out / "work" / "alignment-1a2b" / "database.db").stat().st_size == 3_000_000
    assert (out / "model.obj").exists()
    # A move would have taken along what belongs to a run in progress.
    assert not (out / "work" / "depths-3c4d.part").exists()
    untitled.close()


def test_saving_under_another_name_keeps_the_original_reconstruction(tmp_path):
    project = ProjectFolder.create(tmp_path / "a.vom")
    old = reconstruct(tmp_path / "a.vom")
    project.save_as(tmp_path / "b.vom")
    new = tmp_path / "b.vom" / RECONSTRUCTIONS / "cliff-medium"
    for out in (old, new):
        assert (out / "work" / "alignment-1a2b" / "database.db").read_bytes() == b"7" * 3_000_000
    # What is begun is of no use without its lock and its worker.
    assert not (new / "work" / "depths-3c4d.part").exists()
    assert not (new / "work" / "lock").exists()
    # The log is written on: it must not be shared.
    (new / "log.txt").write_text("went on")
    assert (old / "log.txt").read_text() == "begun"
    project.close()


def test_closing_untitled_project_keeps_a_finished_reconstruction(untitled):
    folder = untitled.folder
    reconstruct(folder)
    assert untitled.has_reconstructions
    untitled.close()
    assert (folder / RECONSTRUCTIONS / "cliff-medium" / "model.obj").exists()


def test_unfinished_run_is_deleted_with_untitled_project(untitled):
    folder = untitled.folder
    (folder / RECONSTRUCTIONS / "cliff-medium" / "work" / "alignment-1.part").mkdir(parents=True)
    assert not untitled.has_reconstructions
    untitled.close()
    assert not folder.exists()


def test_files_with_lock_in_their_name_are_copied(untitled, tmp_path, monkeypatch):
    monkeypatch.setattr(projects, "_is_same_disk", lambda *_: False)
    old = reconstruct(untitled.folder)
    (old / "work" / "straight-5e6f").mkdir()
    (old / "work" / "straight-5e6f" / "lock_wall.npz").write_bytes(b"7")
    old.rename(old.with_name("lockerbie-medium"))
    untitled.save_as(tmp_path / "a.vom")
    out = tmp_path / "a.vom" / RECONSTRUCTIONS / "lockerbie-medium"
    assert (out / "model.obj").exists()
    assert (out / "work" / "straight-5e6f" / "lock_wall.npz").exists()
    assert not (out / "work" / "lock").exists()
    untitled.close()


def test_reconstruction_is_copied_if_the_move_fails(untitled, tmp_path, monkeypatch):
    left = reconstruct(untitled.folder)
    rename = Path.rename

    def refuse(self: Path, target: Path) -> Path:
        if self.name == RECONSTRUCTIONS:
            raise OSError(18, "Invalid cross-device link")
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", refuse)
    untitled.save_as(tmp_path / "a.vom")
    assert untitled.folder == tmp_path / "a.vom"
    assert (tmp_path / "a.vom" / RECONSTRUCTIONS / "cliff-medium" / "model.obj").exists()
    assert not left.exists()
    untitled.close()


def test_reconstruction_stays_in_place_if_move_and_copy_fail(untitled, tmp_path, monkeypatch):
    left = reconstruct(untitled.folder)

    def refuse(*_, **__):
        raise OSError(28, "No space left on device")

    rename = Path.rename
    monkeypatch.setattr(
        Path, "rename", lambda s, t: refuse() if s.name == RECONSTRUCTIONS else rename(s, t)
    )
    monkeypatch.setattr(reconstructions, "copy_reconstructions", refuse)
    with refused("reconstruction.not-moved", TargetError, reason="the disk is full"):
        untitled.save_as(tmp_path / "a.vom")
    assert (left / "model.obj").exists()
    assert untitled.folder == tmp_path / "a.vom"
    untitled.close()


def test_finished_model_is_kept_without_its_work_folder(untitled):
    out = reconstruct(untitled.folder)
    shutil.rmtree(out / "work")
    (out / "cameras.json").write_text("{}")
    untitled.close()
    assert (out / "model.obj").exists()


def marked(folder: Path) -> Path:
    table = folder / PHOTO_TABLES / "cliff-1a2b3c4d" / "marks.csv"
    table.parent.mkdir(parents=True)
    table.write_text("label,photo,x,y\nA,a.jpg,1,2\n")
    return table


def test_closing_untitled_project_keeps_marks_of_read_only_photos(untitled):
    table = marked(untitled.folder)
    untitled.close()
    assert table.is_file()


def test_marks_in_the_project_folder_follow_save_as(untitled, tmp_path):
    table = marked(untitled.folder)
    untitled.save_as(tmp_path / "a.vom")
    moved = tmp_path / "a.vom" / PHOTO_TABLES / table.parent.name / table.name
    assert moved.read_text().startswith("label")
    untitled.save_as(tmp_path / "b.vom")
    assert (tmp_path / "b.vom" / PHOTO_TABLES / table.parent.name / table.name).is_file()
    assert moved.is_file()
    untitled.close()


def used_and_unused(folder: Path) -> Path:
    """A finished reconstruction with a stage in use, two of earlier photos, and one begun."""
    out = reconstruct(folder, 1000)
    work = out / "work"
    for name in ("alignment-0000", "depths-1111.part"):
        (work / name).mkdir()
        (work / name / "file").write_bytes(b"x" * 500)
        os.utime(work / name, (100, 100))
    (work / "current.json").write_text('{"folders": ["alignment-1a2b", "features"]}')
    os.utime(work / "current.json", (200, 200))
    return out


def test_compaction_deletes_stages_of_earlier_photos_and_settings(untitled):
    out = used_and_unused(untitled.folder)
    (out / "work" / "lock").unlink()
    plan = untitled.compaction()
    assert [Path(name).name for name in plan.stages] == ["alignment-0000", "depths-1111.part"]
    assert plan.stage_bytes == 1000
    untitled.compact()
    assert (out / "work" / "alignment-1a2b" / "database.db").exists()
    assert (out / "work" / "depths-3c4d.part").exists(), "begun after the results"
    assert untitled.compaction().stages == ()


def test_compaction_keeps_stages_while_a_reconstruction_runs(untitled):
    out = used_and_unused(untitled.folder)
    (out / "work" / "lock").unlink()
    lock = FolderLock(out / "work" / "lock", "output.folder-in-use", "output.unwritable")
    try:
        reconstructions.delete_unused_stages(untitled.folder)
    finally:
        lock.release()
    assert (out / "work" / "alignment-0000").exists()


@pytest.mark.parametrize("content", ["", "[]", '{"folders": 3}'])
def test_compaction_keeps_all_stages_if_those_in_use_are_unknown(untitled, content):
    out = used_and_unused(untitled.folder)
    (out / "work" / "current.json").write_text(content)
    assert reconstructions.unused_stages(untitled.folder) == []
