"""What is on the disk after each edit: rows that vouch for each other, and what is said where they
do not."""

from __future__ import annotations

import hashlib
import json
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest

from tests.messages import refused
from tests.samples import bed
from vomstudio.core.errors import DocumentError, TargetError
from vomstudio.core.findings import Finding
from vomstudio.core.version import __version__
from vomstudio.geometry.frames import Frame
from vomstudio.project import edits
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.journal import database as journals
from vomstudio.project.journal.connection import JournalConnection
from vomstudio.project.journal.database import (
    APPLICATION_ID,
    SCHEMA_VERSION,
    SqliteJournal,
    journal_files,
    read_replay,
    read_schema_and_replay,
)
from vomstudio.project.journal.replay import JournalRow
from vomstudio.project.records import Model

COLUMNS = "seq, kind, of_seq, label, before, after, time, version, settings"
MODEL = Model("m1", "cliff", "cliff.obj", "mesh", "0" * 64, Frame("local"))


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "journal.sqlite"


@pytest.fixture
def journal(path: Path) -> Iterator[SqliteJournal]:
    made = SqliteJournal(path, is_new=True)
    yield made
    made.close()


@pytest.fixture
def four_beds(tmp_path: Path) -> Path:
    """The folder of a closed project: rows 1 and 2 are its birth, 3 a model, 4 to 7 beds."""
    project = ProjectFolder.create(tmp_path / "a.vom")
    session = project.session
    session.apply(edits.add_model(session.records, MODEL))
    for number in range(4):
        session.apply(edits.add_trace(session.records, bed(f"t{number}")))
    project.close()
    return project.folder


HEAD = "SELECT rows, seq, checksum FROM head"
EDITS = "SELECT before, after FROM journal"


def asked(path: Path, query: str) -> list[tuple[Any, ...]]:
    """What another program sees in the file."""
    with closing(sqlite3.connect(path)) as db:
        return db.execute(query).fetchall()


def changed(path: Path, *statements: str) -> None:
    with closing(sqlite3.connect(path)) as db:
        for statement in statements:
            db.execute(statement)
        db.commit()


def chained(path: Path) -> tuple[int, int, str]:
    """Count, last number and last sum as they must be, after every row was found to be right."""
    total, count, last = "", 0, 0
    for *values, stored in asked(path, f"SELECT {COLUMNS}, checksum FROM journal ORDER BY seq"):
        text = total
        for value in values:
            text += "-" if value is None else f"{len(str(value).encode())}:{value}"
        total = hashlib.sha256(text.encode()).hexdigest()
        assert stored == total
        count, last = count + 1, values[0]
    return count, last, total


def traces(folder: Path) -> set[str]:
    return {id_ for id_ in read_replay(folder).records if id_.startswith("t")}


# --- writing -------------------------------------------------------------------------------------
def test_checksum_of_every_row_includes_the_previous_one_and_the_head_follows(
    journal: SqliteJournal, path: Path
) -> None:
    """Files outlive the program: the sums are those of a recipe that anybody can follow, and after
    each single row count, last number and last sum are those of the rows that are there."""
    writes: list[Callable[[], int]] = [
        lambda: journal.append("do", label="Ebene α", after={"a": None}, settings={"s": 1.5}),
        lambda: journal.append("undo", of_seq=1),
        lambda: journal.append("do", label="", before={}, after={"a": {"x": [0.1, None]}}),
        lambda: journal.append("save"),
        lambda: journal.copy_row("draft", None, "", None, {"tool": "trace"}, None),
    ]
    for number, write in enumerate(writes, 1):
        assert write() == number == journal.last_number
        count, last, total = chained(path)
        assert (count, last) == (number, number)
        assert asked(path, "SELECT id, rows, seq, checksum FROM head") == [(1, count, last, total)]


def test_row_stores_its_time_program_version_and_settings(
    journal: SqliteJournal,
) -> None:
    begin = datetime.now(UTC) - timedelta(seconds=1)
    journal.append(
        "do", of_seq=7, label="x", before={"a": None}, after={"a": {"n": 0.1}}, settings={"t": 5}
    )
    (row,) = journal.rows()
    assert (row.seq, row.kind, row.of_seq, row.label) == (1, "do", 7, "x")
    assert (row.before, row.after, row.settings) == ({"a": None}, {"a": {"n": 0.1}}, {"t": 5})
    assert begin <= datetime.fromisoformat(row.time) <= datetime.now(UTC)
    assert datetime.fromisoformat(row.time).utcoffset() == timedelta(0)
    assert row.version == __version__
    assert (row.problem, row.notice) == (None, None)


def test_a_copied_row_keeps_its_time_program_and_settings(journal: SqliteJournal) -> None:
    journal.append("do", label="x", after={"a": None}, settings={"t": 5})
    like = replace(next(iter(journal.rows())), time="then", version="0.1")
    journal.copy_row("do", 1, "y", {"b": None}, {"b": {"n": 1}}, like)
    journal.copy_row("do", None, "z", {"c": None}, {"c": {"n": 2}}, None)
    _, second, third = journal.rows()
    assert (second.time, second.version, second.settings) == ("then", "0.1", {"t": 5})
    assert (second.of_seq, second.label) == (1, "y")
    assert (second.before, second.after) == ({"b": None}, {"b": {"n": 1}})
    assert (third.version, third.settings) == (__version__, None)
    assert (third.of_seq, third.before, third.after) == (None, {"c": None}, {"c": {"n": 2}})
    assert abs(datetime.fromisoformat(third.time) - datetime.now(UTC)) < timedelta(minutes=1)


@pytest.mark.parametrize("statement", ["INSERT ON journal", "INSERT ON head"])
def test_row_and_head_are_written_together_or_not_at_all(tmp_path: Path, statement: str) -> None:
    """An edit that cannot be written leaves disk and window as they were, and the next one is
    written as if it had never been tried."""
    project = ProjectFolder.create(tmp_path / "a.vom")
    path = project.folder / "journal.sqlite"
    session = project.session
    session.apply(edits.add_model(session.records, MODEL))
    before, records = chained(path), dict(session.records)
    changed(path, f"CREATE TRIGGER full BEFORE {statement} BEGIN SELECT RAISE(ABORT, 'full'); END")
    with refused("journal.not-written", DocumentError, reason="full") as caught:
        session.apply(edits.add_trace(session.records, bed("t0")))
    assert str(path) in str(caught.value)
    assert chained(path) == before
    assert asked(path, HEAD) == [before]
    assert dict(session.records) == records
    assert project.journal.last_number == before[1]
    changed(path, "DROP TRIGGER full")
    session.apply(edits.add_trace(session.records, bed("t1")))
    assert asked(path, HEAD) == [chained(path)]
    assert "t1" in traces(project.folder)
    project.close()


def test_number_without_a_json_form_is_not_written(journal: SqliteJournal) -> None:
    """No other program could read it, and nothing could be told from it."""
    with pytest.raises(ValueError, match="JSON"):
        journal.append("do", after={"a": {"x": float("nan")}})
    assert list(journal.rows()) == []
    assert journal.append("do", after={"a": {"x": 1.0}}) == 1


def test_rows_are_written_as_compact_json(journal: SqliteJournal, path: Path) -> None:
    journal.append("do", after={"a": [1, 2], "b": None})
    assert asked(path, EDITS) == [(None, '{"a":[1,2],"b":null}')]


def test_model_with_a_non_utf8_name_is_stored_and_read(tmp_path: Path) -> None:
    """Drives written on other systems have such names; the path must come back to the byte."""
    project = ProjectFolder.create(tmp_path / "a.vom")
    named = replace(MODEL, name="caf\udce9", path="/x/caf\udce9.obj")
    project.session.apply(edits.add_model(project.session.records, named))
    project.session.undo()
    project.session.redo()
    project.close()
    played = read_replay(project.folder)
    assert played.records["m1"] == named
    assert played.problems == []


# --- how safely ----------------------------------------------------------------------------------
def test_row_is_on_disk_before_its_effect_is_visible(journal: SqliteJournal, path: Path) -> None:
    """A power cut may come at any moment: every commit waits for the disk."""
    journal.append("save")
    assert journal._db.execute("PRAGMA journal_mode").fetchone() == ("wal",)
    assert journal._db.execute("PRAGMA synchronous").fetchone() == (2,)
    assert path.with_name("journal.sqlite-wal").stat().st_size > 0
    journal.close()
    assert [p.name for p in path.parent.iterdir()] == ["journal.sqlite"]
    assert asked(path, "PRAGMA journal_mode") == [("delete",)]


class _NetworkDrive(JournalConnection):
    """A connection to a file where no log can be kept beside it."""

    def execute(self, statement: str, *values: Any) -> sqlite3.Cursor:
        if "WAL" in statement:
            raise sqlite3.OperationalError("locking protocol")
        return super().execute(statement, *values)


def test_journal_without_wal_keeps_full_synchronous_writes(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    SqliteJournal(path, is_new=True).close()
    # As a kill on another drive leaves it.
    changed(path, "PRAGMA journal_mode = WAL")
    monkeypatch.setattr(journals, "JournalConnection", _NetworkDrive)
    journal = SqliteJournal(path)
    journal.append("save")
    assert journal._db.execute("PRAGMA journal_mode").fetchone() == ("delete",)
    assert journal._db.execute("PRAGMA synchronous").fetchone() == (2,)
    journal.close()
    assert chained(path)[0] == 1


def test_closing_during_a_read_loses_nothing(path: Path) -> None:
    journal = SqliteJournal(path, is_new=True)
    journal.append("do", label="x", after={})
    with closing(sqlite3.connect(path)) as reader:
        reader.execute("BEGIN")
        reader.execute("SELECT count(*) FROM journal").fetchone()
        # Nobody has to wait seconds for the reader.
        journal._db.execute("PRAGMA busy_timeout = 0")
        journal.close()
        # Whoever copies or zips the one file now has everything.
        path.with_name("copy.sqlite").write_bytes(path.read_bytes())
    assert asked(path.with_name("copy.sqlite"), "SELECT label FROM journal") == [("x",)]
    again = SqliteJournal(path)
    assert [row.label for row in again.rows()] == ["x"]
    again.close()


# --- reading -------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("gone", "span"),
    [
        ("seq = 1", (1, 1)),
        ("seq < 3", (1, 2)),
        ("seq = 5", (5, 5)),
        ("seq IN (4, 5, 6)", (4, 6)),
        ("seq = 7", (7, 7)),
        ("seq > 4", (5, 7)),
    ],
)
def test_missing_rows_are_reported_without_blaming_others(
    four_beds: Path, gone: str, span: tuple[int, int]
) -> None:
    changed(four_beds / "journal.sqlite", f"DELETE FROM journal WHERE {gone}")
    kept = [seq for (seq,) in asked(four_beds / "journal.sqlite", "SELECT seq FROM journal")]
    played = read_replay(four_beds)
    first, last = span
    assert [p for p in played.problems if p.code == "journal.rows-missing"] == [
        Finding("journal.rows-missing", count=last - first + 1, first=first, last=last)
    ]
    assert traces(four_beds) == {f"t{seq - 4}" for seq in kept if seq >= 4}


def test_placeholder_of_lost_rows_contains_only_the_notice(four_beds: Path) -> None:
    path = four_beds / "journal.sqlite"
    changed(path, "DELETE FROM journal WHERE seq > 5")
    journal = SqliteJournal(path)
    last = list(journal.rows())[-1]
    journal.close()
    missing = Finding("journal.rows-missing", count=2, first=6, last=7)
    assert last == JournalRow(7, "gap", None, "", None, None, "", "", None, notice=missing)


def test_damaged_row_does_not_affect_others(four_beds: Path) -> None:
    changed(four_beds / "journal.sqlite", "UPDATE journal SET time = 'x' WHERE seq IN (4, 6)")
    problems = read_replay(four_beds).problems
    assert [p.values["row"] for p in problems] == [4, 6]
    assert {p.values["reason_code"] for p in problems} == {"row.checksum"}
    assert traces(four_beds) == {"t1", "t3"}


def test_valid_journal_has_no_problems(four_beds: Path) -> None:
    schema, played = read_schema_and_replay(four_beds)
    assert (schema, played.problems) == (SCHEMA_VERSION, [])
    assert traces(four_beds) == {"t0", "t1", "t2", "t3"}
    journal = SqliteJournal(four_beds / "journal.sqlite")
    assert all(not row.problem and not row.notice for row in journal.rows())
    journal.close()


@pytest.mark.parametrize(
    "damage",
    [
        "UPDATE journal SET label = CAST(x'ff41fe' AS TEXT) WHERE seq = 5",
        "UPDATE journal SET after = CAST(x'ff41fe' AS TEXT) WHERE seq = 5",
        "UPDATE journal SET after = substr(after, 1, 40) WHERE seq = 5",
        "UPDATE journal SET checksum = '' WHERE seq = 5",
    ],
)
def test_invalid_text_or_json_damages_only_its_row(four_beds: Path, damage: str) -> None:
    changed(four_beds / "journal.sqlite", damage)
    assert any(problem.values["row"] == 5 for problem in read_replay(four_beds).problems)
    project = ProjectFolder.open(four_beds)
    assert any(problem.values["row"] == 5 for problem in project.problems)
    held = {f.id for f in project.session.features()}
    assert {"t0", "t3"} <= held
    assert "t1" not in held
    project.close()


def test_invalid_json_is_reported_even_with_a_correct_checksum(journal: SqliteJournal) -> None:
    """Damage of schema 1 was summed when it was brought to schema 2."""
    values = (1, "do", None, "x", '{"a":', "{", "then", "0.1", None)
    total = journals.checksum("", values)
    journal._db.execute(journals.INSERT_ROW, (*values, total))
    journal._db.execute(journals.SET_HEAD, (1, 1, total))
    (row,) = journal.rows()
    assert row.problem is None
    played = journals.replay([row])
    assert len(played.problems) == 1
    assert played.problems[0].values["reason_code"] == "record.unknown-kind"
    assert played.records == {}


@pytest.mark.parametrize(
    "lost",
    [
        "DELETE FROM head",
        "UPDATE head SET seq = 5, rows = 5",
        "UPDATE head SET checksum = 'x'",
        "UPDATE head SET rows = 70",
    ],
)
def test_new_rows_follow_the_last_one_if_the_head_is_lost_or_damaged(
    four_beds: Path, lost: str
) -> None:
    path = four_beds / "journal.sqlite"
    changed(path, lost)
    project = ProjectFolder.open(four_beds)
    assert project.problems == []
    project.session.apply(edits.add_trace(project.session.records, bed("new")))
    project.close()
    assert chained(path)[:2] == (8, 8)
    assert asked(path, HEAD) == [chained(path)]


def test_next_row_after_lost_rows_follows_the_last_remaining_one(four_beds: Path) -> None:
    """Its number is new, its sum goes on from the last row that is left."""
    path = four_beds / "journal.sqlite"
    changed(path, "DELETE FROM journal WHERE seq > 5")
    project = ProjectFolder.open(four_beds)
    assert project.session.apply(edits.add_trace(project.session.records, bed("new"))) == 8
    project.close()
    count, last, total = chained(path)
    assert (count, last) == (6, 8)
    assert asked(path, HEAD) == [(6, 8, total)]


def test_loss_of_all_rows_is_reported_and_work_can_continue(four_beds: Path) -> None:
    path = four_beds / "journal.sqlite"
    changed(path, "DELETE FROM journal")
    project = ProjectFolder.open(four_beds)
    assert project.problems == [Finding("journal.rows-missing", count=7, first=1, last=7)]
    project.session.apply(edits.add_model(project.session.records, MODEL))
    project.close()
    assert min(asked(path, "SELECT seq FROM journal"))[0] == 8
    assert "m1" in read_replay(four_beds).records


def test_newest_rows_are_returned_in_order(four_beds: Path) -> None:
    journal = SqliteJournal(four_beds / "journal.sqlite")
    every = list(journal.rows())
    assert journal.last_rows(3) == every[-3:]
    assert journal.last_rows(100) == every
    assert [row.seq for row in every] == [1, 2, 3, 4, 5, 6, 7]
    assert journal.last_number == 7
    journal._db.execute("ALTER TABLE journal RENAME TO elsewhere")
    with refused("journal.damaged") as caught:
        journal.last_rows(3)
    assert "journal.sqlite" in str(caught.value)
    with refused("journal.damaged"):
        list(journal.rows())
    journal.close()


def test_reading_changes_no_files(four_beds: Path) -> None:
    path = four_beds / "journal.sqlite"
    before = sorted(four_beds.iterdir()), path.read_bytes(), path.stat().st_mtime_ns
    by_folder, by_file = read_replay(four_beds), read_replay(path)
    assert by_folder.records == by_file.records
    assert (sorted(four_beds.iterdir()), path.read_bytes(), path.stat().st_mtime_ns) == before


@pytest.mark.parametrize("what", ["nothing", "folder", "text", "other database", "newer"])
def test_unreadable_journal_is_rejected_with_its_name(tmp_path: Path, what: str) -> None:
    folder = tmp_path / "x.vom"
    if what != "nothing":
        folder.mkdir()
    path = folder / "journal.sqlite"
    codes = {
        "nothing": "project.not-a-project",
        "folder": "project.not-a-project",
        "text": "journal.damaged",
        "other database": "journal.foreign",
        "newer": "project.newer",
    }
    if what == "text":
        path.write_text("notes of the 3rd of May\n" * 40)
    elif what == "other database":
        changed(path, "CREATE TABLE journal (seq INTEGER)")
    elif what == "newer":
        SqliteJournal(path, is_new=True).close()
        changed(path, f"PRAGMA user_version = {SCHEMA_VERSION + 1}")
    before = path.read_bytes() if path.is_file() else None
    for read in (read_replay, SqliteJournal if path.is_file() else read_replay):
        with refused(codes[what]) as caught:
            read(folder if read is read_replay else path)
        assert "x.vom" in str(caught.value)
    assert (path.read_bytes() if path.is_file() else None) == before


# --- opening -------------------------------------------------------------------------------------
def test_torn_file_is_rejected_before_anything_is_written(four_beds: Path) -> None:
    """Its head and first page are sound, so that SQLite would write to it without a word."""
    path = four_beds / "journal.sqlite"
    project = ProjectFolder.open(four_beds)
    for number in range(4, 60):
        project.session.apply(edits.add_trace(project.session.records, bed(f"t{number}")))
    project.close()
    whole = bytearray(path.read_bytes())
    middle = len(whole) // 2 // 4096 * 4096
    whole[middle : middle + 4096] = b"\xa5" * 4096
    path.write_bytes(whole)
    for _ in range(2):
        with refused("journal.damaged"):
            ProjectFolder.open(four_beds)
        assert path.read_bytes() == bytes(whole)
    assert sorted(p.name for p in four_beds.iterdir()) == ["journal.sqlite", "lock"]


def test_journal_is_created_only_if_new_and_opened_if_it_exists(path: Path) -> None:
    with refused("project.not-a-project"):
        SqliteJournal(path)
    assert not path.exists()
    made = SqliteJournal(path, is_new=True)
    assert (made.last_number, list(made.rows())) == (0, [])
    made.close()
    assert asked(path, "PRAGMA application_id") == [(APPLICATION_ID,)] == [(0x564F4D31,)]
    assert asked(path, "PRAGMA user_version") == [(SCHEMA_VERSION,)]
    whole = path.read_bytes()
    with refused("project.exists", TargetError):
        SqliteJournal(path, is_new=True)
    assert path.read_bytes() == whole


def test_journal_locked_by_another_program_is_reported_as_in_use(
    four_beds: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    connect = sqlite3.connect

    def impatient(*words: Any, **values: Any) -> sqlite3.Connection:
        # Who might be closing it is given some time, but nobody waits for ever.
        assert 1.0 <= values["timeout"] <= 30.0
        return connect(*words, **{**values, "timeout": 0.0})

    with closing(connect(four_beds / "journal.sqlite", isolation_level=None)) as holder:
        holder.execute("BEGIN EXCLUSIVE")
        monkeypatch.setattr(journals.sqlite3, "connect", impatient)
        for read in (SqliteJournal, read_replay):
            with refused("journal.in-use"):
                read(four_beds / "journal.sqlite")


def test_unwritable_folder_is_reported(tmp_path: Path) -> None:
    with refused("journal.not-opened", TargetError):
        SqliteJournal(tmp_path / "nowhere" / "journal.sqlite", is_new=True)


# --- views, copies -------------------------------------------------------------------------------
def test_views_are_stored_without_journal_rows(journal: SqliteJournal, path: Path) -> None:
    assert journal.view("camera") is None
    assert journal.view("camera", 7) == 7
    journal.set_view("camera", [1.5, None])
    journal.set_view("camera", {"at": [2.5, "x"]})
    assert list(journal.rows()) == []
    journal.close()
    again = SqliteJournal(path)
    assert again.view("camera") == again.view("camera", {}) == {"at": [2.5, "x"]}
    assert again.view("camera", []) == [], "whoever wants a list gets one"
    again._db.execute("UPDATE view SET value = '{' WHERE key = 'camera'")
    assert again.view("camera", 7) == 7
    again._db.execute("DROP TABLE view")
    again.set_view("camera", 1)
    assert again.view("camera", 7) == 7
    again.close()


def test_views_are_copied_to_another_journal(journal: SqliteJournal, tmp_path: Path) -> None:
    journal.set_view("camera", [1.5])
    journal.set_view("hidden", {"a": True})
    other = SqliteJournal(tmp_path / "other.sqlite", is_new=True)
    other.copy_views(journal)
    assert (other.view("camera"), other.view("hidden")) == ([1.5], {"a": True})
    other.close()


def test_copy_of_an_open_journal_is_complete(journal: SqliteJournal, tmp_path: Path) -> None:
    journal.append("do", label="x", after={"a": None})
    journal.copy_to(tmp_path / "copy.sqlite")
    assert chained(tmp_path / "copy.sqlite") == chained(journal.path)
    copy = SqliteJournal(tmp_path / "copy.sqlite")
    assert list(copy.rows()) == list(journal.rows())
    copy.close()
    with refused("output.unwritable", TargetError) as caught:
        journal.copy_to(tmp_path / "nowhere" / "copy.sqlite")
    assert "nowhere" in str(caught.value)


def test_export_protection_covers_the_journal_and_its_log_files(tmp_path: Path) -> None:
    project = ProjectFolder.create(tmp_path / "a.vom")
    beside = {p for p in project.folder.iterdir() if p.name.startswith("journal")}
    assert len(beside) == 3
    assert set(journal_files(project.folder)) == beside
    project.close()


def test_settings_of_the_newest_edit_apply(tmp_path: Path) -> None:
    told = {"n": 1}
    project = ProjectFolder.create(tmp_path / "a.vom", settings=lambda: told)
    told = {"n": 2}
    project.session.apply(edits.add_model(project.session.records, MODEL))
    project.session.undo()
    project.close()
    assert read_replay(project.folder).settings == {"n": 2}
    stored = asked(project.folder / "journal.sqlite", "SELECT kind, settings FROM journal")
    assert [json.loads(s) for kind, s in stored if kind == "do"] == [{"n": 1}, {"n": 2}]
