"""A journal with damaged rows is written anew, and nothing that could be read is lost."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.messages import refused
from tests.samples import bed
from vomstudio.core.errors import DocumentError, TargetError
from vomstudio.geometry.frames import Frame
from vomstudio.project import edits
from vomstudio.project import repair as repair_module
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.journal.database import read_replay
from vomstudio.project.journal.replay import Replay
from vomstudio.project.records import Model
from vomstudio.project.verify import verify


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Three beds B01 to B03, the last of them undone; the row of B02 is damaged."""
    folder = tmp_path / "a.vom"
    project = ProjectFolder.create(folder)
    session = project.session
    model = Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64, Frame("local"))
    session.apply(edits.add_model(session.records, model))
    for number in range(3):
        session.apply(edits.add_trace(session.records, bed(f"t{number}", float(number))))
    session.undo()
    session.save()
    project.close()
    db = sqlite3.connect(folder / "journal.sqlite")
    db.execute("UPDATE journal SET time = 'then' WHERE kind = 'do' AND label LIKE '%B02%'")
    db.commit()
    db.close()
    return folder


@pytest.fixture
def damaged(folder: Path) -> Iterator[ProjectFolder]:
    project = ProjectFolder.open(folder)
    yield project
    project.close()


def test_what_could_be_read_stays_with_its_steps_both_ways(damaged: ProjectFolder) -> None:
    session = damaged.session
    records, label, again = dict(session.records), session.undo_label, session.redo_label
    assert len(damaged.problems) == 1
    made = damaged.repair()
    assert made.loss_findings == tuple(read_replay(made.backup).problems)
    assert damaged.problems == []
    assert verify(damaged.folder).sound
    played = read_replay(damaged.folder)
    assert played.records == dict(session.records) == records
    assert (session.undo_label, session.redo_label) == (label, again)


def test_work_goes_on_in_the_new_journal(damaged: ProjectFolder, folder: Path) -> None:
    damaged.repair()
    session = damaged.session
    session.redo()
    session.apply(edits.add_trace(session.records, bed("t9", 9.0)))
    session.undo()
    session.undo()
    assert verify(folder).sound
    assert read_replay(folder).records == dict(session.records)
    damaged.compact()
    assert read_replay(folder).records == dict(session.records)


def test_a_sound_journal_is_left_alone(damaged: ProjectFolder, folder: Path) -> None:
    damaged.repair()
    before = (folder / "journal.sqlite").stat().st_ino
    with refused("journal.sound", DocumentError):
        damaged.repair()
    assert (folder / "journal.sqlite").stat().st_ino == before
    assert [path.name for path in folder.glob("journal-*")] == ["journal-damaged-1.sqlite"]


def test_no_damaged_journal_takes_the_place_of_an_earlier_one(
    damaged: ProjectFolder, folder: Path
) -> None:
    (folder / "journal-damaged-1.sqlite").write_bytes(b"of another day")
    assert damaged.repair().backup.name == "journal-damaged-2.sqlite"
    assert (folder / "journal-damaged-1.sqlite").read_bytes() == b"of another day"


def test_a_repair_keeps_the_times_the_views_and_the_journal_of_before(
    damaged: ProjectFolder, folder: Path
) -> None:
    damaged.journal.set_view("camera", [1.5])
    before = {row.label: row for row in damaged.journal.rows() if row.kind == "do"}
    made = damaged.repair()
    assert made.backup == folder / "journal-damaged-1.sqlite"
    assert damaged.journal.view("camera") == [1.5]
    for row in damaged.journal.rows():
        if row.kind == "do":
            was = before[row.label]
            assert (row.time, row.version, row.after) == (was.time, was.version, was.after)
    kept = sqlite3.connect(made.backup)
    rows = kept.execute("SELECT count(*) FROM journal WHERE time = 'then'")
    assert rows.fetchone() == (1,)
    kept.close()
    assert not (folder / "journal-compacted.sqlite").exists()


def test_what_was_saved_is_saved_after_a_repair_and_what_was_not_is_not(
    damaged: ProjectFolder, folder: Path
) -> None:
    session = damaged.session
    saved = dict(session.saved)
    session.apply(edits.add_trace(session.records, bed("t9", 9.0)))
    damaged.repair()
    assert session.dirty
    played = read_replay(folder)
    assert played.saved == saved
    assert "t9" in played.records
    session.discard_unsaved()
    assert read_replay(folder).records == saved


@pytest.mark.parametrize("way", ["another tale", "no room"])
def test_a_repair_that_fails_has_changed_nothing(
    damaged: ProjectFolder, folder: Path, monkeypatch: pytest.MonkeyPatch, way: str
) -> None:
    rows, problems = list(damaged.journal.rows()), list(damaged.problems)

    def full(*_: object) -> None:
        raise OSError(28, "No space left")

    with monkeypatch.context() as patch:
        if way == "no room":
            patch.setattr(Path, "replace", full)
            error, code = TargetError, "disk.full"
        else:
            patch.setattr(repair_module, "read_replay", lambda _: Replay())
            error, code = DocumentError, "journal.inconsistent"
        with refused(code, error):
            damaged.repair()
    assert list(damaged.journal.rows()) == rows
    assert damaged.problems == problems
    assert list(damaged.session.problems) == problems
    assert not (folder / "journal-compacted.sqlite").exists()
    session = damaged.session
    session.apply(edits.add_trace(session.records, bed("t9", 9.0)))
    assert "t9" in read_replay(folder).records
    damaged.repair()
    assert verify(folder).sound


@pytest.mark.parametrize("part", ["records", "saved"])
def test_a_new_journal_that_says_less_than_the_window_shows_is_not_taken(
    damaged: ProjectFolder, monkeypatch: pytest.MonkeyPatch, part: str
) -> None:
    def less(path: Path) -> Replay:
        played = read_replay(path)
        del getattr(played, part)["t0"]
        return played

    monkeypatch.setattr(repair_module, "read_replay", less)
    with refused("journal.inconsistent", DocumentError):
        damaged.repair()
