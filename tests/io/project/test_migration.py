"""A journal of schema 1 becomes one of schema 2: every row stays, and nothing is done by halves."""

from __future__ import annotations

import hashlib
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from tests.samples import bed
from vomstudio.document import edits
from vomstudio.document.records import Frame, Model
from vomstudio.errors import InputError, TargetError
from vomstudio.io.project import journal_migration as migrations
from vomstudio.io.project.folder import Project
from vomstudio.io.project.journal import (
    SqliteJournal,
    read_replay,
    read_schema_and_replay,
)
from vomstudio.io.project.journal_migration import SCHEMA_VERSION, TAKING_IN
from vomstudio.io.project.verify import verify

ROWS = "SELECT seq, kind, of_seq, label, before, after, time, version, settings FROM journal"
KEPT = "journal-schema1.sqlite"


def asked(path: Path, query: str) -> list[tuple[Any, ...]]:
    with closing(sqlite3.connect(path)) as db:
        return db.execute(query).fetchall()


@pytest.fixture
def old(tmp_path: Path) -> Path:
    """The folder of a project as schema 1 kept it: a model, three beds, the last one undone."""
    project = Project.create(tmp_path / "a.vom")
    session = project.session
    model = Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64, Frame("local"))
    session.apply(edits.add_model(session.records, model))
    for number in range(3):
        session.apply(edits.add_trace(session.records, bed(f"t{number}")))
    session.undo()
    session.save()
    project.journal.set_view("camera", [1.5])
    project.close()
    with closing(sqlite3.connect(project.folder / "journal.sqlite")) as db:
        db.executescript(
            "ALTER TABLE journal DROP COLUMN checksum; DROP TABLE head; PRAGMA user_version = 1;"
        )
        db.execute("UPDATE journal SET version = '0.1.0', settings = NULL WHERE seq = 4")
        db.commit()
    return project.folder


def test_every_row_stays_to_the_letter_and_is_vouched_for(old: Path) -> None:
    path = old / "journal.sqlite"
    rows = asked(path, ROWS)
    assert len(rows) == 8
    records = read_replay(old).records
    project = Project.open(old)
    assert project.problems == []
    assert project.journal.opened_schema == 1
    assert dict(project.session.records) == records
    project.session.redo()
    assert "t2" in project.session.records
    assert project.journal.view("camera") == [1.5]
    project.close()
    assert asked(path, ROWS)[:8] == rows
    assert asked(path, "PRAGMA user_version") == [(SCHEMA_VERSION,)]
    total = ""
    for *values, stored in asked(path, ROWS.replace(" FROM", ", checksum FROM")):
        text = total + "".join(
            "-" if value is None else f"{len(str(value).encode())}:{value}" for value in values
        )
        total = hashlib.sha256(text.encode()).hexdigest()
        assert stored == total
    assert asked(path, "SELECT id, rows, seq, checksum FROM head") == [(1, 9, 9, total)]
    found = verify(old)
    assert (found.schema, found.sound) == (SCHEMA_VERSION, True)


def test_the_journal_of_before_is_kept_beside_it(old: Path) -> None:
    rows = asked(old / "journal.sqlite", ROWS)
    Project.open(old).close()
    assert asked(old / KEPT, ROWS) == rows
    assert asked(old / KEPT, "PRAGMA user_version") == [(1,)]
    assert "checksum" not in asked(old / KEPT, "SELECT sql FROM sqlite_master")[0][0]
    # A second opening has nothing left to do.
    kept = (old / KEPT).read_bytes()
    project = Project.open(old)
    assert project.journal.opened_schema == SCHEMA_VERSION
    project.close()
    assert (old / KEPT).read_bytes() == kept


def test_a_copy_that_is_kept_already_is_the_better_one(old: Path) -> None:
    """It was made by an earlier try, before anything went wrong."""
    (old / KEPT).write_bytes(b"of an earlier try")
    project = Project.open(old)
    project.close()
    assert (old / KEPT).read_bytes() == b"of an earlier try"
    assert read_schema_and_replay(old)[0] == SCHEMA_VERSION


def test_reading_does_not_bring_an_old_journal_up_to_date(old: Path) -> None:
    before = {path.name: path.read_bytes() for path in old.iterdir()}
    schema, played = read_schema_and_replay(old)
    assert (schema, played.problems) == (1, [])
    assert {"t0", "t1"} <= set(played.records)
    assert verify(old).schema == 1
    assert {path.name: path.read_bytes() for path in old.iterdir()} == before


@pytest.mark.parametrize("way", ["the copy", "the last row", "the end"])
def test_a_migration_that_fails_leaves_the_journal_as_it_was(
    old: Path, monkeypatch: pytest.MonkeyPatch, way: str
) -> None:
    path = old / "journal.sqlite"
    rows, sql = asked(path, ROWS), asked(path, "SELECT sql FROM sqlite_master")
    step: Callable[[sqlite3.Connection], None] = migrations._STEPS[1]
    checksum = migrations.checksum

    def full(*_: object) -> None:
        raise TargetError("the disk is full")

    def until_the_last(previous: str, values: Any) -> str:
        if values[0] == len(rows):
            full()
        return checksum(previous, values)

    def then_full(db: sqlite3.Connection) -> None:
        step(db)
        full()

    with monkeypatch.context() as patch:
        if way == "the copy":
            patch.setattr(migrations, "copy_database", full)
        elif way == "the last row":
            patch.setattr(migrations, "checksum", until_the_last)
        else:
            patch.setitem(migrations._STEPS, 1, then_full)
        # Held, as a window holds what it shows: nothing is cleared away with it by chance.
        with pytest.raises(TargetError, match="disk is full") as held:
            Project.open(old)
    assert asked(path, ROWS) == rows
    assert asked(path, "SELECT sql FROM sqlite_master") == sql
    assert asked(path, "PRAGMA user_version") == [(1,)]
    project = Project.open(old)
    assert project.problems == []
    assert {"t0", "t1"} <= set(project.session.records)
    project.close()
    assert held.value is not None


def test_a_table_that_is_not_one_of_schema_1_is_refused_before_anything_is_made_of_it(
    old: Path,
) -> None:
    path = old / "journal.sqlite"
    with closing(sqlite3.connect(path)) as db:
        db.execute("ALTER TABLE journal RENAME COLUMN settings TO elsewhere")
        db.commit()
    whole = path.read_bytes()
    with pytest.raises(InputError, match="The journal is damaged"):
        Project.open(old)
    assert path.read_bytes() == whole
    assert not (old / KEPT).exists()


def test_damage_of_before_is_named_ever_after_and_takes_nothing_else(old: Path) -> None:
    """A row that schema 1 had lost by halves keeps what is left of it, for whoever can read it."""
    path = old / "journal.sqlite"
    with closing(sqlite3.connect(path)) as db:
        db.execute("UPDATE journal SET after = substr(after, 1, 40) WHERE seq = 5")
        db.commit()
    left = asked(path, ROWS)
    for _ in range(2):
        project = Project.open(old)
        assert len(project.problems) == 1
        assert "row 5" in project.problems[0]
        assert "t0" in project.session.records
        project.close()
    assert asked(path, ROWS) == left


def test_files_beside_an_old_journal_are_looked_for_once(old: Path) -> None:
    journal = SqliteJournal(old / "journal.sqlite")
    assert journal.view(TAKING_IN) is True
    journal.close()
    project = Project.open(old)
    assert project.journal.view(TAKING_IN) is False
    assert not project.session.dirty
    project.close()
    new = SqliteJournal(old.parent / "new.sqlite", create=True)
    assert new.view(TAKING_IN) is None
    new.close()


def test_an_old_project_that_holds_nothing_is_brought_up_to_date_too(old: Path) -> None:
    path = old / "journal.sqlite"
    with closing(sqlite3.connect(path)) as db:
        db.execute("DELETE FROM journal")
        db.commit()
    journal = SqliteJournal(path)
    assert (journal.last, list(journal.rows())) == (0, [])
    assert journal.append("save") == 1
    journal.close()
    assert asked(path, "SELECT rows, seq FROM head") == [(1, 1)]
    assert read_replay(old).problems == []
