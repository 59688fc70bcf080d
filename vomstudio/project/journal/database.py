"""Journal of a project in SQLite: append-only rows, written before they take effect.

It uses WAL with synchronous FULL if the file system supports it, and otherwise a rollback journal
(network drives). When the journal is closed, the log is merged so that the single file can be
copied and zipped.
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
from vomstudio.core.files.regular import require_regular_file
from vomstudio.core.files.untrusted.databases import open_read_only, restrict_connection
from vomstudio.core.findings import Finding
from vomstudio.core.version import __version__
from vomstudio.project.journal.connection import JournalConnection
from vomstudio.project.journal.failures import NotWritten, is_lost
from vomstudio.project.journal.file_watch import (
    JournalFiles,
    close_without_checkpoint,
    copy_database,
    has_interrupted_write,
    is_read_only_connection,
    open_error,
    write_failure_finding,
)
from vomstudio.project.journal.json_values import dump_json
from vomstudio.project.journal.migration import SCHEMA_VERSION, migrate
from vomstudio.project.journal.replay import JournalRow, Replay, RowKind, replay
from vomstudio.project.journal.rows import (
    INSERT_ROW,
    SET_HEAD,
    Head,
    NewRow,
    checksum,
    decode_journal_text,
    last_rows,
    read_head,
    read_rows,
)
from vomstudio.project.journal.schema import require_intact, require_plain
from vomstudio.project.paths import JOURNAL_NAME

APPLICATION_ID = 0x564F4D31  # "VOM1"

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
    """Journal of a project in one file, which also stores the view state outside the history."""

    def __init__(self, path: Path, *, is_new: bool = False) -> None:
        """Open or create the journal.

        Raises
        ------
        InputError
            If the file is not a journal of VOM Studio or was written by a newer version.
        TargetError
            If the file cannot be written.
        """
        self.path = path
        self._pending_rows: list[NewRow] = []
        self._is_open = False
        self._failure: Finding | None = None
        self._report_failure: Callable[[Finding | None], object] | None = None
        self._lock_again: Callable[[], object] = lambda: None
        self._write_dependencies: Callable[[], object] = lambda: None
        self._open(is_new)

    def _open(self, create: bool) -> None:
        path = self.path
        _check_side_files(path)
        if create and path.exists():
            raise TargetError(Finding("project.exists"), file=path)
        if not create and not path.is_file():
            raise InputError(Finding("project.not-a-project"), file=path)
        try:
            is_checked = create or _is_checked(path)
            # A window reads the journal in a worker thread; two threads never use it at the same
            # time.
            self._db = sqlite3.connect(
                path,
                isolation_level=None,
                timeout=5.0,
                check_same_thread=False,
                factory=JournalConnection,
            )
            self._db.text_factory = decode_journal_text
            restrict_connection(self._db)
            if create:
                self._db.executescript("BEGIN;" + _SCHEMA + "COMMIT;")
            schema = _read_schema_version(self._db, path)
            if not is_checked:
                require_intact(self._db, path)
            if schema < SCHEMA_VERSION:
                migrate(self._db, path, schema)
            self._make_durable()
            self._head = read_head(self._db)
            self._files = JournalFiles(path, self._db)
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
        """Append a row and return its number.

        Raises NotWritten; after `buffer_unwritten_steps`, only for a save.
        """
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
        head = self._pending_rows[-1].head if self._pending_rows else self._head
        seq = head.seq + 1
        values = (
            seq,
            kind,
            of_seq,
            replace_surrogates(label),  # Records keep invalid UTF-8 as JSON escapes.
            dump_json(before),
            dump_json(after),
            time,
            version,
            dump_json(settings),
        )
        row = NewRow(values, Head(head.rows + 1, seq, checksum(head.checksum, values)))
        try:
            self._commit([*self._pending_rows, row])
        except NotWritten as error:
            if self._report_failure is None or kind == "save":
                raise
            if self._head.seq < seq:
                self._pending_rows.append(row)
            self._update_failure(error.failure)
        else:
            self._update_failure(None)
        return seq

    def _commit(self, rows: list[NewRow]) -> None:
        """Write rows and verify that they are in the project's file. Raises NotWritten."""
        if not self._is_open:
            self._open_again()
        if (
            failure := self._files.write_failure(self._head)
        ) is not None and not self._has_returned():
            raise NotWritten(failure, self.path)
        try:
            self._write_dependencies()
            try:
                self._write(rows)
            except sqlite3.OperationalError as error:
                if not is_read_only_connection(error, self.path):
                    raise
                self.close_file()
                self._open_again()
                self._write(rows)
        except NotWritten:
            raise
        except (sqlite3.Error, VomError, OSError) as error:
            raise NotWritten(write_failure_finding(error, self.path), self.path) from error
        self._head = rows[-1].head
        self._pending_rows = []
        if (failure := self._files.record_write()) is not None:
            raise NotWritten(failure, self.path)

    def _write(self, rows: list[NewRow]) -> None:
        self._db.execute("BEGIN IMMEDIATE")
        try:
            self._db.executemany(INSERT_ROW, [(*row.values, row.head.checksum) for row in rows])
            self._db.execute(SET_HEAD, rows[-1].head)
            self._db.execute("COMMIT")
        except BaseException:
            if self._db.in_transaction:
                self._db.execute("ROLLBACK")
            raise

    def _open_again(self) -> None:
        expected_head = self._head
        try:
            self._open(create=False)
        except VomError as error:
            cause = error.__cause__ if isinstance(error.__cause__, sqlite3.Error) else None
            failure = write_failure_finding(
                cause or sqlite3.OperationalError(error.message), self.path
            )
            raise NotWritten(failure, self.path) from error
        if self._head != expected_head:
            self.close_file()
            self._head = expected_head
            raise NotWritten(Finding("journal.replaced"), self.path)

    # --- unwritable files --------------------------------------------------------------------
    def buffer_unwritten_steps(
        self,
        report: Callable[[Finding | None], object],
        lock_again: Callable[[], object],
        write_dependencies: Callable[[], object],
    ) -> None:
        """Keep unwritable rows in memory and write them as soon as a later row can be written.

        Parameters
        ----------
        report : callable
            Called with the reason when buffering begins and with None when it ends.
        lock_again : callable
            Called before the file is opened again at its path; raises VomError if another program
            has locked it.
        write_dependencies : callable
            Writes the pending files that rows reference; raises VomError.
        """
        self._report_failure, self._lock_again, self._write_dependencies = (
            report,
            lock_again,
            write_dependencies,
        )

    def try_writing(self) -> None:
        """Check that rows can be written, and report a failure without waiting for the next row."""
        try:
            self._write_dependencies()
            self._db.execute("BEGIN IMMEDIATE")
            self._db.execute("ROLLBACK")
        except (sqlite3.Error, VomError, OSError) as error:
            self._update_failure(write_failure_finding(error, self.path))

    def _update_failure(self, failure: Finding | None) -> None:
        if self._report_failure is not None and failure != self._failure:
            self._failure = failure
            self._report_failure(failure)

    def write_failure(self) -> Finding | None:
        """Return the reason why the next row cannot be written, or None if no reason is known."""
        return (self._files.write_failure(self._head) if self._is_open else None) or self._failure

    @property
    def is_in_place(self) -> bool:
        """Whether the file at the path of the journal is the open one. Thread-safe."""
        return self._is_open and self._files.is_open_file()

    @property
    def has_pending_rows(self) -> bool:
        """Whether there are rows that exist only in memory."""
        return bool(self._pending_rows)

    def _has_returned(self) -> bool:
        """Reopen the journal and return True if it is available again and unchanged."""
        if self._report_failure is None or not self._files.has_rows_at_path(self._head):
            return False
        if not self._files.is_open_file():
            try:
                self._lock_again()
            except VomError:
                return False
            close_without_checkpoint(self._db, self.path, is_known_log=False)
            self._files.close()
            self._open(create=False)
        self._files.record_state()
        return True

    @property
    def last_number(self) -> int:
        """Number of the last row."""
        return self._pending_rows[-1].head.seq if self._pending_rows else self._head.seq

    def last_rows(self, count: int) -> list[JournalRow]:
        """Return the last rows in order, without verifying their checksums. Raises InputError."""
        return last_rows(self._db, self.path, count)

    def copy_row(
        self,
        kind: str,
        of_seq: int | None,
        label: str,
        before: Mapping[str, Any] | None,
        after: Mapping[str, Any] | None,
        template: JournalRow | None,
    ) -> int:
        """Append a copy of a row with its time, version and settings, and return the new number."""
        if template is None:
            return self._append(kind, of_seq, label, before, after, _now(), __version__, None)
        return self._append(
            kind, of_seq, label, before, after, template.time, template.version, template.settings
        )

    def copy_views(self, source_journal: SqliteJournal) -> None:
        for key, value in source_journal._db.execute("SELECT key, value FROM view"):
            with contextlib.suppress(ValueError, TypeError, RecursionError):
                self.set_view(key, json.loads(value))

    def rows(self) -> Iterator[JournalRow]:
        """Yield all rows in order, pending rows last. Raises InputError if the file is damaged."""
        yield from read_rows(self._db, self.path)
        yield from (row.to_row() for row in self._pending_rows)

    # --- view state: camera, visibility, panels ----------------------------------------------
    def set_view(self, key: str, value: Any) -> None:
        # A lost camera is not lost work: the view state never prevents an edit.
        if self._files.write_failure(self._head) is not None:
            return
        try:
            self._db.execute("INSERT OR REPLACE INTO view VALUES (?, ?)", (key, json.dumps(value)))
        except sqlite3.Error:
            return
        self._files.record_state()

    def view(self, key: str, default: Any = None) -> Any:
        try:
            row = self._db.execute("SELECT value FROM view WHERE key = ?", (key,)).fetchone()
            value = default if row is None else json.loads(row[0])
        except (sqlite3.Error, ValueError, TypeError, RecursionError):
            return default
        # Callers that pass a list or mapping as default iterate over the result.
        return value if default is None or type(value) is type(default) else default

    # --- copies ------------------------------------------------------------------------------
    def copy_to(self, path: Path) -> None:
        """Write a consistent copy that includes pending rows. Raises TargetError."""
        copy_database(self._db, path)
        last_number = self._pending_rows[-1].head if self._pending_rows else self._head
        try:
            with closing(sqlite3.connect(path, isolation_level=None)) as copy:
                copy.execute("BEGIN")
                for row in self._pending_rows:
                    copy.execute(INSERT_ROW, (*row.values, row.head.checksum))
                if self._pending_rows:
                    copy.execute(SET_HEAD, last_number)
                copy.execute("COMMIT")
                is_complete = read_head(copy) == last_number
        except sqlite3.Error as error:
            raise write_error(path, error) from error
        if not is_complete:
            raise TargetError(Finding("journal.not-copied"), file=path)

    def reopen_after_replacement(self, head: Head) -> None:
        """Continue in the journal that has replaced this one, which is closed.

        If opening fails, the error is raised and the next row tries again.
        """
        self._head = head
        self.reopen()

    def reopen(self) -> None:
        """Open the journal again after closing. If that fails, the next row tries again."""
        self._open(create=False)

    def close(self) -> None:
        self.close_file()
        self._report_failure, self._lock_again, self._write_dependencies = (
            None,
            lambda: None,
            lambda: None,
        )

    def close_file(self) -> None:
        """Close the file so that it can be replaced; callbacks are kept."""
        if not self._is_open:
            return
        self._is_open = False
        failure = self._files.write_failure(self._head)
        if failure is not None and is_lost(failure):
            close_without_checkpoint(self._db, self.path, is_known_log=self._files.has_known_log())
            self._files.close()
            return
        try:
            self._db.execute("PRAGMA wal_checkpoint(TRUNCATE)")
            self._db.execute("PRAGMA journal_mode = DELETE")
        except sqlite3.Error:
            # Another reader has the file open; the log stays and is merged next time.
            pass
        self._db.close()
        self._files.close()


def journal_files(folder: Path) -> list[Path]:
    """Return the files of a project's journal, which an export must not replace."""
    return [folder / f"{JOURNAL_NAME}{suffix}" for suffix in ("", "-wal", "-shm")]


def read_replay(folder: Path) -> Replay:
    """Read the journal of a project without locking it. Raises InputError.

    The project may be open in a window.
    """
    return read_schema_and_replay(folder)[1]


def _check_side_files(path: Path) -> None:
    """Check the files that SQLite writes next to a journal, even when it only reads.

    Raises TargetError for links and InputError for anything else that is not a regular file.
    """
    for suffix in ("", "-journal", "-wal", "-shm"):
        require_regular_file(check_generated_path(path.with_name(path.name + suffix)))


def read_schema_and_replay(folder: Path) -> tuple[int, Replay]:
    """Return the schema version of the journal and the result of `read_replay`.

    Raises InputError if the folder is not a project or cannot be read.
    """
    path = Path(folder)
    path = path / JOURNAL_NAME if path.is_dir() else path
    if not path.is_file():
        raise InputError(
            Finding("project.not-a-project"),
            file=folder,
        )
    _check_side_files(path)
    try:
        return _read_unlocked(path)
    except sqlite3.Error as error:
        if not has_interrupted_write(path, error):
            raise open_error(error, path) from error
    try:
        return _read_unlocked(path)
    except sqlite3.Error as error:
        raise open_error(error, path) from error


def _read_unlocked(path: Path) -> tuple[int, Replay]:
    with closing(open_read_only(path)) as db:
        db.text_factory = decode_journal_text
        schema = _read_schema_version(db, path)
        return schema, replay(read_rows(db, path))


def _read_schema_version(db: sqlite3.Connection, path: Path) -> int:
    """Return the schema version of a journal.

    Raises InputError if the file is not a journal of VOM Studio or was written by a newer version.
    """
    (application,) = db.execute("PRAGMA application_id").fetchone()
    (version,) = db.execute("PRAGMA user_version").fetchone()
    if application != APPLICATION_ID or version < 1:
        raise InputError(Finding("journal.foreign"), file=path)
    # Checked before the tables because a newer schema may have different ones.
    if version > SCHEMA_VERSION:
        raise InputError(
            Finding("project.newer", version=version, known=SCHEMA_VERSION),
            file=path,
        )
    require_plain(db, path)
    return int(version)


def _is_checked(path: Path) -> bool:
    """Check a journal in read-only mode before it is opened for writing.

    Returns whether that was possible. A writing connection merges the log when it is closed, even
    for a journal that is rejected. Raises InputError.
    """
    try:
        with closing(open_read_only(path)) as db:
            _read_schema_version(db, path)
            require_intact(db, path)
    except sqlite3.Error:
        # For example, an interrupted change that a writing connection rolls back.
        return False
    return True


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")
