"""What was made of photos belongs to its project, and goes where the project goes."""

from __future__ import annotations

from pathlib import Path

import pytest

from vomstudio.io import project as projects
from vomstudio.io.project import RECONSTRUCTIONS, Project, create_untitled


@pytest.fixture
def untitled(tmp_path, monkeypatch) -> Project:
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


def test_an_untitled_project_that_is_saved_takes_its_reconstruction_along(untitled, tmp_path):
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


def test_on_another_disk_it_is_copied(untitled, tmp_path, monkeypatch):
    monkeypatch.setattr(projects, "_same_disk", lambda *_: False)
    reconstruct(untitled.folder)
    untitled.save_as(tmp_path / "a.vom")
    out = tmp_path / "a.vom" / RECONSTRUCTIONS / "cliff-medium"
    assert (out / "work" / "alignment-1a2b" / "database.db").stat().st_size == 3_000_000
    assert (out / "model.obj").exists()
    # A move would have taken along what belongs to a run in progress.
    assert not (out / "work" / "depths-3c4d.part").exists()
    untitled.close()


def test_a_project_saved_under_another_name_leaves_its_own_behind(tmp_path):
    project = Project.create(tmp_path / "a.vom")
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


def test_hours_of_work_are_not_thrown_away_with_an_untitled_project(untitled):
    folder = untitled.folder
    reconstruct(folder)
    assert untitled.has_reconstructions
    untitled.close()
    assert (folder / RECONSTRUCTIONS / "cliff-medium" / "model.obj").exists()


def test_a_run_that_finished_nothing_is_not_worth_keeping(untitled):
    folder = untitled.folder
    (folder / RECONSTRUCTIONS / "cliff-medium" / "work" / "alignment-1.part").mkdir(parents=True)
    assert not untitled.has_reconstructions
    untitled.close()
    assert not folder.exists()
