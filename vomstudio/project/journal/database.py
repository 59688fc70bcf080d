"""The project's journal in SQLite: append-only rows, each on the disk before its effect is seen.

WAL with synchronous FULL where the file system can do it, a rollback journal where it cannot
(network drives). On close the log is folded in, so that the one file can be copied and zipped.
"""

from __future__ import annotations

import contextlib
import json
import sqlite3
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from vomstudio.core.errors import InputError, TargetError, VomError
from vomstudio.core.files.containment import check_generated_path
from vomstudio.core.files.disk_errors import write_error
from vomstudio.core.files.names import replace_surrogates
from vomstudio.core.files.regular import require_regular
from vomstudio.core.files.untrusted.databases import harden, open_to_read
from vomstudio.core.findings import Finding
from vomstudio.core.version import __version__
from vomstudio.project.journal.connection import JournalConnection
from vomstudio.project.journal.failures import NotWritten, is_lost
from vomstudio.project.journal.file_watch import (
    Ground,
    copy_database,
    leave_alone,
    only_reads,
    open_error,
    write_failure_of,
    writing_was_cut_off,
)
from vomstudio.project.journal.json_values import dump_json
from vomstudio.project.journal.migration import SCHEMA_VERSION, migrate
from vomstudio.project.journal.replay import Replay, Row, RowKind, replay
from vomstudio.project.journal.rows import (
    INSERT_ROW,
    SET_HEAD,
    Head,
    NewRow,
    checksum,
    last_rows,
    read_head,
    read_rows,
    text_of,
)
from vomstudio.project.journal.schema import require_plain, require_sound

APPLICATION_ID = 0x564F4D31  # "VOM1"
NAME = "journal.sqlite"

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
    """Journal of a project in one file. Also stores the view state, which is not history."""

    def __init__(self, path: Path, *, create: bool = False) -> None:
        """Raises InputError where the file is not a journal of ours or is newer than this program,
        TargetError where it cannot be written."""
        self.path = path
        self._waiting: list[NewRow] = []
        self._is_open = False
        self._failure: Finding | None = None
        self._tell: Callable[[Finding | None], object] | None = None
        self._come_back: Callable[[], object] = lambda: None
        self._write_first: Callable[[], object] = lambda: None
        self._open(create)

    def _open(self, create: bool) -> None:
        path = self.path
        _check_side_files(path)
        if create and path.exists():
            raise TargetError(Finding("project.exists"), file=path)
        if not create and not path.is_file():
            raise InputError(Finding("project.not-a-project"), file=path)
        try:
            checked = create or _checked(path)
            # A window has it read in a thread of its own; two threads never use it at a time.
            self._db = sqlite3.connect(
                path,
                isolation_level=None,
                timeout=5.0,
                check_same_thread=False,
                factory=JournalConnection,
            )
            self._db.text_factory = text_of
            harden(self._db)
            if create:
                self._db.executescript("BEGIN;" + _SCHEMA + "COMMIT;")
            schema = _schema_of(self._db, path)
            if not checked:
                require_sound(self._db, path)
            if schema < SCHEMA_VERSION:
                migrate(self._db, path, schema)
            self._make_durable()
            self._head = read_head(self._db)
            self._ground = Ground(path, self._db)
            self._is_open = True
        except sqlite3.Error as error:
            raise open_error(error, path) from error

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
        """Raises NotWritten; after `wait_in_memory` for a save only."""
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
        head = self._waiting[-1].head if self._waiting else self._head
        seq = head.seq + 1
        values = (
            seq,
            kind,
            of_seq,
            replace_surrogates(label),  # The records keep what is no UTF-8, as JSON's escapes.
            dump_json(before),
            dump_json(after),
            time,
            version,
            dump_json(settings),
        )
        row = NewRow(values, Head(head.rows + 1, seq, checksum(head.checksum, values)))
        try:
            self._commit([*self._waiting, row])
        except NotWritten as error:
            if self._tell is None or kind == "save":
                raise
            if self._head.seq < seq:
                self._waiting.append(row)
            self._told(error.failure)
        else:
            self._told(None)
        return seq

    def _commit(self, rows: list[NewRow]) -> None:
        """Write these rows, and be sure that they are where the project is. Raises NotWritten."""
        if not self._is_open:
            self._open_again()
        if (failure := self._ground.write_failure(self._head)) is not None and not self._returned():
            raise NotWritten(failure, self.path)
        try:
            self._write_first()
            try:
                self._write(rows)
            except sqlite3.OperationalError as error:
                if not only_reads(error, self.path):
                    raise
                self.let_go()
                self._open_again()
                self._write(rows)
        except NotWritten:
            raise
        except (sqlite3.Error, VomError, OSError) as error:
            raise NotWritten(write_failure_of(error, self.path), self.path) from error
        self._head = rows[-1].head
        self._waiting = []
        if (failure := self._ground.note_written()) is not None:
            raise NotWritten(failure, self.path)

    def _write(self, rows: list[NewRow]) -> None:
        self._db.execute("BEGIN IMMEDIATE")
        try:
            self._db.executemany(INSERT_ROW, [(*r.values, r.head.checksum) for r in rows])
            self._db.execute(SET_HEAD, rows[-1].head)
            self._db.execute("COMMIT")
        except BaseException:
            if self._db.in_transaction:
                self._db.execute("ROLLBACK")
            raise

    def _open_again(self) -> None:
        """Raises NotWritten."""
        expected = self._head
        try:
            self._open(create=False)
        except VomError as error:
            cause = error.__cause__ if isinstance(error.__cause__, sqlite3.Error) else None
            failure = write_failure_of(cause or sqlite3.OperationalError(error.message), self.path)
            raise NotWritten(failure, self.path) from error
        if self._head != expected:
            self.let_go()
            self._head = expected
            raise NotWritten(Finding("journal.replaced"), self.path)

    # --- where the file cannot be written ----------------------------------------------------
    def wait_in_memory(
        self,
        tell: Callable[[Finding | None], object],
        come_back: Callable[[], object],
        write_first: Callable[[], object],
    ) -> None:
        """From now on rows that cannot be written wait in memory, and are written with the next one
        that can be.

        tell : is called when that begins, and with None when it is over
        come_back : is called before the file is opened again at its place; raises VomError where
            another program holds it
        write_first : writes the files that rows name and that wait too; raises VomError
        """
        self._tell, self._come_back, self._write_first = tell, come_back, write_first

    def try_writing(self) -> None:
        """Tell now, rather than with the next row, where no row can be written."""
        try:
            self._write_first()
            self._db.execute("BEGIN IMMEDIATE")
            self._db.execute("ROLLBACK")
        except (sqlite3.Error, VomError, OSError) as error:
            self._told(write_failure_of(error, self.path))

    def _told(self, failure: Finding | None) -> None:
        if self._tell is not None and failure != self._failure:
            self._failure = failure
            self._tell(failure)

    def write_failure(self) -> Finding | None:
        """Why the next row cannot be written, as far as that is known."""
        return (self._ground.write_failure(self._head) if self._is_open else None) or self._failure

    @property
    def is_in_place(self) -> bool:
        """Whether the file at the journal's place is the one that is open; from any thread."""
        return self._is_open and self._ground.is_ours()

    @property
    def waits(self) -> bool:
        """Whether there are rows that are in memory only."""
        return bool(self._waiting)

    def _returned(self) -> bool:
        """Whether the journal is back as it was left: a drive was plugged in again. Then it is
        open again."""
        if self._tell is None or not self._ground.is_back(self._head):
            return False
        if not self._ground.is_ours():
            try:
                self._come_back()
            except VomError:
                return False
            leave_alone(self._db, self.path, log_is_ours=False)
            self._ground.close()
            self._open(create=False)
        self._ground.note()
        return True

    @property
    def last(self) -> int:
        """The number of the last row."""
        return self._waiting[-1].head.seq if self._waiting else self._head.seq

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
        """Rows in order, those that wait last. Raises InputError where the file itself is
        damaged."""
        yield from read_rows(self._db, self.path)
        yield from (row.as_read() for row in self._waiting)

    # --- view state: camera, visibility, panels ----------------------------------------------
    def set_view(self, key: str, value: Any) -> None:
        # A lost camera is no loss of work: view state never stands in the way of an edit.
        if self._ground.write_failure(self._head) is not None:
            return
        try:
            self._db.execute("INSERT OR REPLACE INTO view VALUES (?, ?)", (key, json.dumps(value)))
        except sqlite3.Error:
            return
        self._ground.note()

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
        """A sound copy of everything so far, rows that wait among them. Raises TargetError."""
        copy_database(self._db, path)
        last = self._waiting[-1].head if self._waiting else self._head
        try:
            with closing(sqlite3.connect(path, isolation_level=None)) as copy:
                copy.execute("BEGIN")
                for row in self._waiting:
                    copy.execute(INSERT_ROW, (*row.values, row.head.checksum))
                if self._waiting:
                    copy.execute(SET_HEAD, last)
                copy.execute("COMMIT")
                whole = read_head(copy) == last
        except sqlite3.Error as error:
            raise write_error(path, error) from error
        if not whole:
            raise TargetError(Finding("journal.not-copied"), file=path)

    def change_over(self, head: Head) -> None:
        """Go on in the journal that has taken the place of this one, which is closed. Raises as the
        opening did; then the next row tries it again."""
        self._head = head
        self.reopen()

    def reopen(self) -> None:
        """After it was closed. Raises as the opening did; then the next row tries it again."""
        self._open(create=False)

    def close(self) -> None:
        self.let_go()
        self._tell, self._come_back, self._write_first = None, lambda: None, lambda: None

    def let_go(self) -> None:
        """Close the file, to open one in its place: who is told of troubles stays as it was."""
        if not self._is_open:
            return
        self._is_open = False
        failure = self._ground.write_failure(self._head)
        if failure is not None and is_lost(failure):
            leave_alone(self._db, self.path, log_is_ours=self._ground.has_log_of_ours())
            self._ground.close()
            return
        try:
            self._db.execute("PRAGMA wal_checkpoint(TRUNCATE)")
            self._db.execute("PRAGMA journal_mode = DELETE")
        except sqlite3.Error:
            # Another reader holds the file: the log stays beside it and is folded in next time.
            pass
        self._db.close()
        self._ground.close()


def own_files(folder: Path) -> list[Path]:
    """The files that are the project's truth, and which no export may replace."""
    return [folder / f"{NAME}{ending}" for ending in ("", "-wal", "-shm")]


def read_replay(folder: Path) -> Replay:
    """What the journal of the project in `folder` says, without taking hold of it: it may be open
    in a window. Raises InputError."""
    return read_schema_and_replay(folder)[1]


def _check_side_files(path: Path) -> None:
    """SQLite writes beside a journal, even while it reads, and waits for a pipe. Raises TargetError
    for links, InputError for what is no file."""
    for ending in ("", "-journal", "-wal", "-shm"):
        require_regular(check_generated_path(path.with_name(path.name + ending)))


def read_schema_and_replay(folder: Path) -> tuple[int, Replay]:
    """As `read_replay`, with the schema of the journal."""
    path = Path(folder)
    path = path / NAME if path.is_dir() else path
    if not path.is_file():
        raise InputError(
            Finding("project.not-a-project"),
            file=folder,
        )
    _check_side_files(path)
    try:
        return _read_without_hold(path)
    except sqlite3.Error as error:
        if not writing_was_cut_off(path, error):
            raise open_error(error, path) from error
    try:
        return _read_without_hold(path)
    except sqlite3.Error as error:
        raise open_error(error, path) from error


def _read_without_hold(path: Path) -> tuple[int, Replay]:
    """Raises InputError, sqlite3.Error."""
    with closing(open_to_read(path)) as db:
        db.text_factory = text_of
        schema = _schema_of(db, path)
        return schema, replay(read_rows(db, path))


def _schema_of(db: sqlite3.Connection, path: Path) -> int:
    """Raises InputError where it is no journal of ours, or a newer one."""
    (application,) = db.execute("PRAGMA application_id").fetchone()
    (version,) = db.execute("PRAGMA user_version").fetchone()
    if application != APPLICATION_ID or version < 1:
        raise InputError(Finding("journal.foreign"), file=path)
    # Before the check of the tables: a newer schema may have others.
    if version > SCHEMA_VERSION:
        raise InputError(
            Finding("project.newer", version=version, known=SCHEMA_VERSION),
            file=path,
        )
    require_plain(db, path)
    return int(version)


def _checked(path: Path) -> bool:
    """Whether it could be looked at before it is opened for writing: what may write folds the log
    into the file when it is closed, of a journal that is refused too. Raises InputError."""
    try:
        with closing(open_to_read(path)) as db:
            _schema_of(db, path)
            require_sound(db, path)
    except sqlite3.Error:
        # Such as one that was left in the middle of a change, which is taken back by writing.
        return False
    return True


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")
