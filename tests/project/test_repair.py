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


def test_repair_keeps_readable_records_and_undo_and_redo_steps(damaged: ProjectFolder) -> None:
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


def test_edits_continue_in_the_repaired_journal(damaged: ProjectFolder, folder: Path) -> None:
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


def test_valid_journal_is_not_repaired(damaged: ProjectFolder, folder: Path) -> None:
    damaged.repair()
    before = (folder / "journal.sqlite").stat().st_ino
    with refused("journal.sound", DocumentError):
        damaged.repair()
    assert (folder / "journal.sqlite").stat().st_ino == before
    assert [path.name for path in folder.glob("journal-*")] == ["journal-damaged-1.sqlite"]


def test_backup_does_not_overwrite_an_earlier_damaged_journal(
    damaged: ProjectFolder, folder: Path
) -> None:
    (folder / "journal-damaged-1.sqlite").write_bytes(b"of another day")
    assert damaged.repair().backup.name == "journal-damaged-2.sqlite"
    assert (folder / "journal-damaged-1.sqlite").read_bytes() == b"of another day"


def test_repair_keeps_row_times_views_and_a_backup(damaged: ProjectFolder, folder: Path) -> None:
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


def test_repair_keeps_the_saved_state_and_unsaved_edits(
    damaged: ProjectFolder, folder: Path
) -> None:
    session = damaged.session
    saved_records = dict(session.saved_records)
    session.apply(edits.add_trace(session.records, bed("t9", 9.0)))
    damaged.repair()
    assert session.dirty
    played = read_replay(folder)
    assert played.saved_records == saved_records
    assert "t9" in played.records
    session.discard_unsaved()
    assert read_replay(folder).records == saved_records


@pytest.mark.parametrize("way", ["another tale", "no room"])
def test_failed_repair_changes_nothing(
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


@pytest.mark.parametrize("part", ["records", "saved_records"])
def test_repaired_journal_with_missing_records_is_rejected(
    damaged: ProjectFolder, monkeypatch: pytest.MonkeyPatch, part: str
) -> None:
    def less(path: Path) -> Replay:
        played = read_replay(path)
        del getattr(played, part)["t0"]
        return played

    monkeypatch.setattr(repair_module, "read_replay", less)
    with refused("journal.inconsistent", DocumentError):
        damaged.repair()
