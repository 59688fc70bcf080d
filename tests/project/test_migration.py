"""The migration of journals, tried with an artificial schema 2 that adds a column and a table."""

from __future__ import annotations

import sqlite3
import sys
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from tests.messages import refused
from tests.specimens import figures
from vomstudio.core.errors import TargetError
from vomstudio.core.findings import Finding
from vomstudio.project import edits
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.journal import database, migration, schema
from vomstudio.project.journal.database import SqliteJournal, read_replay, read_schema_and_replay
from vomstudio.project.journal.rows import COLUMNS
from vomstudio.project.verify import verify

ROWS = f"SELECT {COLUMNS}, checksum FROM journal"
BACKUP = "journal-schema1.sqlite"


def query(path: Path, sql: str) -> list[tuple[Any, ...]]:
    with closing(sqlite3.connect(path)) as db:
        return db.execute(sql).fetchall()


def execute(path: Path, sql: str) -> None:
    with closing(sqlite3.connect(path)) as db:
        db.execute(sql)
        db.commit()


@pytest.fixture
def specimen(tmp_path: Path) -> Path:
    """The specimen of schema 1, with all kinds of rows and records."""
    return figures.copy_of("schema1", tmp_path)


def add_column(db: sqlite3.Connection) -> None:
    """The step from schema 1 to 2."""
    db.execute("ALTER TABLE journal ADD COLUMN place TEXT NOT NULL DEFAULT 'here'")
    db.execute("CREATE TABLE note (text TEXT)")
    db.execute("INSERT INTO note SELECT label FROM journal WHERE seq = 1")


Step = Callable[[sqlite3.Connection], None]


def use_schema(
    monkeypatch: pytest.MonkeyPatch, version: int, steps: dict[int, Step] | None = None
) -> None:
    monkeypatch.setattr(database, "SCHEMA_VERSION", version)
    monkeypatch.setattr(migration, "SCHEMA_VERSION", version)
    monkeypatch.setattr(migration, "STEPS", steps or {})
    tables = {"journal", "head", "view", *(["note"] if version > 1 else [])}
    monkeypatch.setattr(schema, "_TABLES", tables)


@pytest.fixture
def schema_2(monkeypatch: pytest.MonkeyPatch) -> None:
    """The program of schema 2."""
    use_schema(monkeypatch, 2, {1: add_column})


@pytest.mark.usefixtures("schema_2")
def test_a_migrated_journal_has_its_rows_records_and_history(specimen: Path) -> None:
    path = specimen / "journal.sqlite"
    rows, before = query(path, ROWS), read_replay(specimen)
    project = ProjectFolder.open(specimen)
    assert project.problems == []
    assert dict(project.session.records) == before.records
    assert project.session.redo_label == before.undone[-1][1].label
    project.session.undo()
    project.close()
    assert query(path, ROWS)[: len(rows)] == rows
    assert query(path, "PRAGMA user_version") == [(2,)]
    assert query(path, "SELECT DISTINCT place FROM journal") == [("here",)]
    assert query(path, "SELECT text FROM note") == [(rows[0][3],)]
    report = verify(specimen)
    assert (report.schema, report.sound) == (2, True)


@pytest.mark.usefixtures("schema_2")
def test_the_old_journal_is_copied_once_before_it_is_migrated(specimen: Path) -> None:
    rows = query(specimen / "journal.sqlite", ROWS)
    ProjectFolder.open(specimen).close()
    backup = specimen / BACKUP
    assert query(backup, ROWS) == rows
    assert query(backup, "PRAGMA user_version") == [(1,)]
    notes = "SELECT name FROM sqlite_master WHERE name = 'note'"
    assert query(backup, notes) == []
    # The second opening finds nothing to migrate.
    content = backup.read_bytes()
    ProjectFolder.open(specimen).close()
    assert backup.read_bytes() == content
    assert query(specimen / "journal.sqlite", "SELECT count(*) FROM note") == [(1,)]


@pytest.mark.usefixtures("schema_2")
def test_backup_of_an_earlier_attempt_is_not_replaced(specimen: Path) -> None:
    (specimen / BACKUP).write_bytes(b"of an earlier attempt")
    ProjectFolder.open(specimen).close()
    assert (specimen / BACKUP).read_bytes() == b"of an earlier attempt"
    assert read_schema_and_replay(specimen)[0] == 2


@pytest.mark.usefixtures("schema_2")
def test_reading_without_opening_does_not_migrate(specimen: Path) -> None:
    before = {path: path.read_bytes() for path in specimen.iterdir() if path.is_file()}
    schema, played = read_schema_and_replay(specimen)
    assert (schema, played.problems) == (1, [])
    assert verify(specimen).schema == 1
    assert {path: path.read_bytes() for path in specimen.iterdir() if path.is_file()} == before


def test_steps_run_in_order_in_one_transaction(
    specimen: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = specimen / "journal.sqlite"
    seen: list[tuple[int, int, bool, int]] = []

    def step(number: int, then: Step = lambda db: None) -> Step:
        def run(db: sqlite3.Connection) -> None:
            (version,) = db.execute("PRAGMA user_version").fetchone()
            # What the steps before wrote is seen by nobody else yet.
            (outside,) = query(path, "PRAGMA user_version")[0]
            seen.append((number, version, db.in_transaction, outside))
            then(db)

        return run

    use_schema(monkeypatch, 4, {1: step(1, add_column), 2: step(2), 3: step(3)})
    ProjectFolder.open(specimen).close()
    assert seen == [(1, 1, True, 1), (2, 2, True, 1), (3, 3, True, 1)]
    assert query(path, "PRAGMA user_version") == [(4,)]
    assert sorted(each.name for each in specimen.glob("journal*")) == [BACKUP, "journal.sqlite"]


@pytest.mark.parametrize("failure", ["copy", "step", "next step"])
def test_failed_migration_leaves_the_old_journal(
    specimen: Path, monkeypatch: pytest.MonkeyPatch, failure: str
) -> None:
    path = specimen / "journal.sqlite"
    rows, tables = query(path, ROWS), query(path, "SELECT sql FROM sqlite_master")
    records = read_replay(specimen).records

    def fail(*_: object) -> None:
        raise TargetError(Finding("disk.full"))

    def fail_late(db: sqlite3.Connection) -> None:
        add_column(db)
        db.execute("DELETE FROM journal")
        fail()

    with monkeypatch.context() as patch:
        use_schema(patch, 3, {1: fail_late if failure == "step" else add_column, 2: fail})
        if failure == "copy":
            patch.setattr(migration, "copy_database", fail)
        # The error is kept, as a window keeps the one that it shows: nothing is closed by chance.
        with refused("disk.full", TargetError) as caught:
            ProjectFolder.open(specimen)
        assert query(path, ROWS) == rows
        assert query(path, "SELECT sql FROM sqlite_master") == tables
        assert query(path, "PRAGMA user_version") == [(1,)]
        assert (specimen / BACKUP).exists() == (failure != "copy")
    # The program of schema 1 still opens it, and that of schema 2 migrates it then.
    for version, steps in ((1, {}), (2, {1: add_column})):
        use_schema(monkeypatch, version, steps)
        project = ProjectFolder.open(specimen)
        assert project.problems == []
        assert dict(project.session.records) == records
        project.close()
        assert query(path, "PRAGMA user_version") == [(version,)]
    assert caught.value is not None


@pytest.mark.usefixtures("schema_2")
def test_unreadable_journal_is_rejected_before_it_is_copied(specimen: Path) -> None:
    path = specimen / "journal.sqlite"
    execute(path, "ALTER TABLE journal RENAME COLUMN settings TO elsewhere")
    content = path.read_bytes()
    with refused("journal.damaged"):
        ProjectFolder.open(specimen)
    assert path.read_bytes() == content
    assert not (specimen / BACKUP).exists()


@pytest.mark.usefixtures("schema_2")
def test_a_damaged_row_is_reported_before_and_after_the_migration(specimen: Path) -> None:
    path = specimen / "journal.sqlite"
    label = "Set the compass"
    execute(path, f"UPDATE journal SET after = substr(after, 1, 40) WHERE label = '{label}'")
    rows = query(path, ROWS)
    for _ in range(2):
        project = ProjectFolder.open(specimen)
        assert len(project.problems) == 1
        assert project.problems[0].values["label"] == label
        assert "reading-overturned" in project.session.records
        project.close()
    assert query(path, ROWS) == rows


def test_a_journal_without_rows_is_migrated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "empty.sqlite"
    SqliteJournal(path, is_new=True).close()
    use_schema(monkeypatch, 2, {1: add_column})
    opened = SqliteJournal(path)
    assert (opened.last_number, list(opened.rows())) == (0, [])
    assert opened.append("save") == 1
    opened.close()
    assert query(path, "PRAGMA user_version") == [(2,)]


def test_a_journal_of_a_newer_schema_is_refused_and_unchanged(
    specimen: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the program of schema 2 has migrated, the program of schema 1 refuses."""
    path = specimen / "journal.sqlite"
    with monkeypatch.context() as patch:
        use_schema(patch, 2, {1: add_column})
        project = ProjectFolder.open(specimen)
        project.session.apply(
            edits.set_attributes(project.session.records, ["reading-overturned"], notes="later")
        )
        project.close()
    content = path.read_bytes()
    for read in (ProjectFolder.open, read_replay, verify):
        with refused("project.newer") as caught:
            read(specimen)
        assert caught.value.file == str(path)
        assert "journal version 2" in caught.value.message
        assert path.read_bytes() == content


@pytest.mark.parametrize("version", [0, -1])
def test_journal_without_a_valid_schema_is_rejected(specimen: Path, version: int) -> None:
    path = specimen / "journal.sqlite"
    execute(path, f"PRAGMA user_version = {version}")
    content = path.read_bytes()
    with refused("journal.foreign"):
        ProjectFolder.open(specimen)
    assert path.read_bytes() == content


@pytest.mark.skipif(sys.platform == "win32", reason="links need rights there")
@pytest.mark.usefixtures("schema_2")
def test_backup_is_not_written_through_a_symbolic_link(specimen: Path, tmp_path: Path) -> None:
    elsewhere = tmp_path / "elsewhere"
    (specimen / BACKUP).symlink_to(elsewhere)
    with pytest.raises(TargetError):
        ProjectFolder.open(specimen)
    assert not elsewhere.exists()
    assert query(specimen / "journal.sqlite", "PRAGMA user_version") == [(1,)]
