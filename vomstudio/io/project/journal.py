"""The project's journal in SQLite: append-only rows, each on the disk before its effect is seen.

WAL with synchronous FULL where the file system can do it, a rollback journal where it cannot
(network drives). On close the log is folded in, so that the one file can be copied and zipped.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple

from vomstudio.document.journal import Replay, Row, RowKind, replay
from vomstudio.errors import DocumentError, InputError, TargetError
from vomstudio.files.inside import check_beside
from vomstudio.io.project.journal_json import dump_json, load_json
from vomstudio.version import __version__
from vomstudio.words import tr

SCHEMA_VERSION = 7
APPLICATION_ID = 0x564F4D31  # "VOM1"
NAME = "journal.sqlite"
TAKING_IN = "taking in the files of schema 1"
"""A view that is true from the migration on until `folder.Project` has made records of them."""

_SCHEMA = f"""
CREATE TABLE journal (
    seq INTEGER PRIMARY KEY,
    kind TEXT NOT NULL,
    of_seq INTEGER,
    label TEXT NOT NULL,
    before TEXT,
    after TEXT,
    time TEXT NOT NULL,
    version TEXT NOT NULL,
    settings TEXT,
    checksum TEXT NOT NULL
);
CREATE TABLE head (
    id INTEGER PRIMARY KEY CHECK (id = 1),
    rows INTEGER NOT NULL,
    seq INTEGER NOT NULL,
    checksum TEXT NOT NULL
);
INSERT INTO head VALUES (1, 0, 0, '');
CREATE TABLE view (key TEXT PRIMARY KEY, value TEXT NOT NULL);
PRAGMA application_id = {APPLICATION_ID};
PRAGMA user_version = {SCHEMA_VERSION};
"""


class SqliteJournal:
    """A `document.journal.Journal` in one file. Also keeps view state, which is not history."""

    def __init__(self, path: Path, *, create: bool = False) -> None:
        """Raises InputError where the file is not a journal of ours or is newer than this program,
        TargetError where it cannot be written."""
        self.path = path
        self._open(create)

    def _open(self, create: bool) -> None:
        path = self.path
        _refuse_links(path)
        if create and path.exists():
            raise TargetError(tr("There is already a project here."), file=path)
        if not create and not path.is_file():
            raise InputError(
                tr("This is not a VOM Studio project: journal.sqlite is missing."), file=path
            )
        try:
            # A window has it read in a thread of its own; two threads never use it at a time.
            self._db = sqlite3.connect(
                path, isolation_level=None, timeout=5.0, check_same_thread=False
            )
            self._db.text_factory = _text
            if create:
                self._db.executescript("BEGIN;" + _SCHEMA + "COMMIT;")
            self.opened_schema = _schema_of(self._db, path)
            """The schema that the file had when it was opened."""
            if not create:
                _require_sound(self._db, path)
            if self.opened_schema < SCHEMA_VERSION:
                migrate(self._db, path, self.opened_schema)
            self._make_durable()
            self._head = _head(self._db)
        except sqlite3.Error as error:
            raise _open_error(error, path) from error

    def _make_durable(self) -> None:
        try:
            self._db.execute("PRAGMA journal_mode = WAL")
        except sqlite3.OperationalError:
            self._db.execute("PRAGMA journal_mode = DELETE")
        self._db.execute("PRAGMA synchronous = FULL")

    def append(
        self,
        kind: RowKind,
        *,
        of_seq: int | None = None,
        label: str = "",
        before: Mapping[str, Any] | None = None,
        after: Mapping[str, Any] | None = None,
        settings: Mapping[str, Any] | None = None,
    ) -> int:
        return self._append(kind, of_seq, label, before, after, _now(), __version__, settings)

    def _append(
        self,
        kind: str,
        of_seq: int | None,
        label: str,
        before: Mapping[str, Any] | None,
        after: Mapping[str, Any] | None,
        time: str,
        version: str,
        settings: Mapping[str, Any] | None,
    ) -> int:
        head = self._head
        seq = head.seq + 1
        values = (
            seq,
            kind,
            of_seq,
            _writable(label),
            dump_json(before),
            dump_json(after),
            time,
            version,
            dump_json(settings),
        )
        new = Head(head.rows + 1, seq, checksum(head.checksum, values))
        try:
            self._db.execute("BEGIN IMMEDIATE")
            try:
                self._db.execute(INSERT_ROW, (*values, new.checksum))
                self._db.execute(SET_HEAD, new)
                self._db.execute("COMMIT")
            except BaseException:
                if self._db.in_transaction:
                    self._db.execute("ROLLBACK")
                raise
        except sqlite3.Error as error:
            raise DocumentError(
                tr(
                    "The project's journal cannot be written ({error}). Nothing was changed. "
                    "Free some space or check the drive, then try again.",
                    error=error,
                ),
                file=self.path,
            ) from error
        self._head = new
        return seq

    @property
    def last(self) -> int:
        """The number of the last row."""
        return self._head.seq

    def last_rows(self, count: int) -> list[Row]:
        """The newest rows, in order; their checksums are not looked at. Raises InputError."""
        return last_rows(self._db, self.path, count)

    def copy_row(
        self,
        kind: str,
        of_seq: int | None,
        label: str,
        before: Mapping[str, Any] | None,
        after: Mapping[str, Any] | None,
        like: Row | None,
    ) -> int:
        """Append a row with the time, version and settings of another; its number."""
        if like is None:
            return self._append(kind, of_seq, label, before, after, _now(), __version__, None)
        return self._append(
            kind, of_seq, label, before, after, like.time, like.version, like.settings
        )

    def copy_views(self, other: SqliteJournal) -> None:
        for key, value in other._db.execute("SELECT key, value FROM view"):
            with contextlib.suppress(ValueError, TypeError, RecursionError):
                self.set_view(key, json.loads(value))

    def rows(self) -> Iterator[Row]:
        """Rows in order. Raises InputError where the file itself is damaged."""
        return read_rows(self._db, self.path, SCHEMA_VERSION)

    # --- view state: camera, visibility, panels ----------------------------------------------
    def set_view(self, key: str, value: Any) -> None:
        # A lost camera is no loss of work: view state never stands in the way of an edit.
        try:
            self._db.execute("INSERT OR REPLACE INTO view VALUES (?, ?)", (key, json.dumps(value)))
        except sqlite3.Error:
            return

    def view(self, key: str, default: Any = None) -> Any:
        try:
            found = self._db.execute("SELECT value FROM view WHERE key = ?", (key,)).fetchone()
            value = default if found is None else json.loads(found[0])
        except (sqlite3.Error, ValueError, TypeError, RecursionError):
            return default
        # Whoever asks with a list or a map goes through what there is.
        return value if default is None or type(value) is type(default) else default

    # --- copies ------------------------------------------------------------------------------
    def copy_to(self, path: Path) -> None:
        """A sound copy of everything committed so far. Raises TargetError."""
        copy_database(self._db, path)

    def reopen(self) -> None:
        """After it was closed, where nothing took its place. Raises as the opening did."""
        self._open(create=False)

    def close(self) -> None:
        try:
            self._db.execute("PRAGMA wal_checkpoint(TRUNCATE)")
            self._db.execute("PRAGMA journal_mode = DELETE")
        except sqlite3.Error:
            # Another reader holds the file: the log stays beside it and is folded in next time.
            pass
        self._db.close()


def own_files(folder: Path) -> list[Path]:
    """The files that are the project's truth, and which no export may replace."""
    return [folder / f"{NAME}{ending}" for ending in ("", "-wal", "-shm")]


def read_replay(folder: Path) -> Replay:
    """What the journal of the project in `folder` says, without taking hold of it: it may be open
    in a window. Raises InputError."""
    return read_schema_and_replay(folder)[1]


def _refuse_links(path: Path) -> None:
    """SQLite writes beside a journal, even while it reads. Raises TargetError."""
    for ending in ("", "-journal", "-wal", "-shm"):
        check_beside(path.with_name(path.name + ending))


def read_schema_and_replay(folder: Path) -> tuple[int, Replay]:
    """As `read_replay`, with the schema of the journal."""
    path = Path(folder)
    path = path / NAME if path.is_dir() else path
    if not path.is_file():
        raise InputError(
            tr("This is not a VOM Studio project (a folder with journal.sqlite). Check the name."),
            file=folder,
        )
    _refuse_links(path)
    try:
        db = sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True, timeout=5.0)
        db.text_factory = _text
        try:
            schema = _schema_of(db, path)
            return schema, replay(read_rows(db, path, schema))
        finally:
            db.close()
    except sqlite3.Error as error:
        raise _open_error(error, path) from error


def migrate(db: sqlite3.Connection, path: Path, schema: int) -> None:
    """Bring a journal of an earlier schema to that of today, by one small step per schema, after
    all of it was read and a copy was made. Raises InputError, TargetError, with the file as it was.
    """
    # Damaged rows are named at each opening, and stay what they are.
    replay(read_rows(db, path, schema))
    keep = path.with_name(f"{path.stem}-schema{schema}{path.suffix}")
    if not keep.exists():
        copy_database(db, keep)
    db.execute("BEGIN IMMEDIATE")
    try:
        for step in range(schema, SCHEMA_VERSION):
            _STEPS[step](db)
            db.execute(f"PRAGMA user_version = {step + 1}")
        db.execute("COMMIT")
    except BaseException:
        if db.in_transaction:
            db.execute("ROLLBACK")
        raise


def _to_schema_2(db: sqlite3.Connection) -> None:
    """Checksums, each over the row before it. Rows stay as they were written: whole records, and
    models with a frame beside its matrix, are read as ever (`document.codec`)."""
    db.execute("ALTER TABLE journal ADD COLUMN checksum TEXT NOT NULL DEFAULT ''")
    db.execute(
        "CREATE TABLE head (id INTEGER PRIMARY KEY CHECK (id = 1), rows INTEGER NOT NULL, "
        "seq INTEGER NOT NULL, checksum TEXT NOT NULL)"
    )
    head = Head(0, 0, "")
    for values in db.execute(f"SELECT {COLUMNS} FROM journal ORDER BY seq").fetchall():
        head = Head(head.rows + 1, values[0], checksum(head.checksum, values))
        db.execute("UPDATE journal SET checksum = ? WHERE seq = ?", (head.checksum, head.seq))
    db.execute(SET_HEAD, head)
    db.execute("INSERT OR REPLACE INTO view VALUES (?, 'true')", (TAKING_IN,))


def _read_as_they_are(db: sqlite3.Connection) -> None:
    """Rows of before lack what is new and are read as they are; programs of before cannot read rows
    that have it."""


# _STEPS[n] brings schema n to n + 1. 3: lines say how sure their sense of slip is. 4: profiles of
# verdicts, and the rule by which surroundings were measured. 5: a registration's points and
# covariance. 6: control points among the features. 7: how far a model reaches, and its lenses.
_STEPS = {1: _to_schema_2, **dict.fromkeys(range(2, SCHEMA_VERSION), _read_as_they_are)}


def copy_database(db: sqlite3.Connection, path: Path) -> None:
    """A sound copy of everything committed so far. Raises TargetError."""
    check_beside(path)
    try:
        target = sqlite3.connect(path)
        try:
            db.backup(target)
        finally:
            target.close()
    except sqlite3.Error as error:
        raise TargetError(
            tr("The file cannot be written ({error}).", error=error), file=path
        ) from error


def _schema_of(db: sqlite3.Connection, path: Path) -> int:
    """Raises InputError where it is no journal of ours, or a newer one."""
    (application,) = db.execute("PRAGMA application_id").fetchone()
    (version,) = db.execute("PRAGMA user_version").fetchone()
    if application != APPLICATION_ID:
        raise InputError(tr("This is not the journal of a VOM Studio project."), file=path)
    if version > SCHEMA_VERSION:
        raise InputError(
            tr(
                "The project was written by a newer VOM Studio (journal version {version}; "
                "this program reads up to {known}). Update the program.",
                version=version,
                known=SCHEMA_VERSION,
            ),
            file=path,
        )
    return int(version)


def _require_sound(db: sqlite3.Connection, path: Path) -> None:
    """Raises InputError for a file that was torn: writing to it would make it worse."""
    (said,) = db.execute("PRAGMA quick_check(1)").fetchone()
    if said != "ok":
        raise InputError(tr("The journal is damaged. Restore it from a copy."), file=path)


class Head(NamedTuple):
    """How many rows there are, the number of the last one, and its checksum."""

    rows: int
    seq: int
    checksum: str


def _head(db: sqlite3.Connection) -> Head:
    """Of the rows that are there, whatever the head says: new rows follow the last one. A sum that
    was damaged in the head alone must not go into the next row, which would then be blamed."""
    (rows,) = db.execute("SELECT count(*) FROM journal").fetchone()
    last = db.execute("SELECT seq, checksum FROM journal ORDER BY seq DESC LIMIT 1").fetchone()
    seq, total = last or (0, "")
    told = db.execute("SELECT seq FROM head").fetchone()
    # A number that was taken once is not taken again.
    return Head(rows, max(seq, told[0] if told else 0), total)


def checksum(previous: str, values: Sequence[object]) -> str:
    """SHA-256 of a row's values (all but its checksum) and of the checksum of the row before it, so
    that no row can be changed, taken out or put in unseen."""
    made = hashlib.sha256(previous.encode())
    for value in values:
        text = b"" if value is None else str(value).encode("utf-8", "surrogatepass")
        # Lengths, so that two neighbours cannot trade characters.
        made.update(b"-" if value is None else b"%d:" % len(text))
        made.update(text)
    return made.hexdigest()


COLUMNS = "seq, kind, of_seq, label, before, after, time, version, settings"
INSERT_ROW = f"INSERT INTO journal ({COLUMNS}, checksum) VALUES ({', '.join('?' * 10)})"
SET_HEAD = "INSERT OR REPLACE INTO head VALUES (1, ?, ?, ?)"


def read_rows(db: sqlite3.Connection, path: Path, schema: int) -> Iterator[Row]:
    """The rows in order; damaged and missing ones say so. Raises InputError where the file itself
    is damaged."""
    summed = schema >= 2
    try:
        query = f"SELECT {COLUMNS}, {'checksum' if summed else 'NULL'} FROM journal ORDER BY seq"
        seq, total = 0, ""
        told_settings: tuple[Any, Any] = (None, None)
        for *values, stored in db.execute(query):
            number, kind, of_seq, label, before, after, time, version, settings = values
            notice = problem = ""
            if summed and number != seq + 1:
                notice = _missing(seq + 1, number - 1)
            elif summed and stored != checksum(total, values):
                problem = tr("The checksum differs from what was written.")
            elif not all(type(word) is str for word in (kind, label, time, version)):
                problem = tr("Its words are no text.")
                kind, label, time, version = map(str, (kind, label, time, version))
            seq, total = number, str(stored)
            # They hardly ever change from row to row.
            if settings != told_settings[0]:
                told_settings = (settings, load_json(settings))
            yield Row(
                number,
                kind,
                of_seq,
                label,
                load_json(before),
                load_json(after),
                time,
                version,
                told_settings[1],
                problem,
                notice,
            )
        if summed:
            told = db.execute("SELECT seq FROM head").fetchone()
            if told is not None and told[0] > seq:
                lost = _missing(seq + 1, told[0])
                yield Row(told[0], "gap", None, "", None, None, "", "", None, notice=lost)
    except sqlite3.Error as error:
        raise InputError(
            tr("The journal is damaged ({error}). Restore it from a copy.", error=error), file=path
        ) from error


def last_rows(db: sqlite3.Connection, path: Path, count: int) -> list[Row]:
    """The newest rows, in order; their checksums are not looked at. Raises InputError."""
    query = f"SELECT {COLUMNS} FROM journal ORDER BY seq DESC LIMIT ?"
    try:
        found = db.execute(query, (count,)).fetchall()
    except sqlite3.Error as error:
        raise InputError(tr("The journal is damaged ({error}).", error=error), file=path) from error
    return [
        Row(
            seq,
            kind,
            of_seq,
            label,
            load_json(before),
            load_json(after),
            time,
            version,
            load_json(settings),
        )
        for seq, kind, of_seq, label, before, after, time, version, settings in reversed(found)
    ]


def _missing(first: int, last: int) -> str:
    if first == last:
        return tr("Journal row {row} is missing. What was done there is lost.", row=first)
    return tr(
        "Journal rows {first} to {last} are missing. What was done there is lost.",
        first=first,
        last=last,
    )


def _text(raw: bytes) -> str:
    """Damaged bytes become a row that its checksum tells apart, not an error of the whole file."""
    return raw.decode("utf-8", "replace")


def _writable(label: str) -> str:
    """The name of a file whose bytes are no UTF-8 has characters that SQLite refuses. The records
    keep them, as JSON's escapes; for the words of a step a question mark will do."""
    return label.encode("utf-8", "replace").decode()


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def _open_error(error: sqlite3.Error, path: Path) -> InputError | TargetError:
    words = str(error)
    if "not a database" in words or "malformed" in words:
        return InputError(
            tr("The journal is damaged, or is not a journal. Restore it from a copy."), file=path
        )
    if "locked" in words:
        return InputError(
            tr("The journal is in use by another program. Close it there first."), file=path
        )
    return TargetError(
        tr("The journal cannot be opened for writing ({reason}).", reason=words), file=path
    )
