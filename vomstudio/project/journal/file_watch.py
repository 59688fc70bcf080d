"""State of the files of an open journal, which may be changed by other programs."""

from __future__ import annotations

import os
import sqlite3
from contextlib import closing
from pathlib import Path

from vomstudio.core.errors import InputError, TargetError, VomError
from vomstudio.core.files.containment import check_generated_path
from vomstudio.core.files.disk_errors import (
    failure_reason,
    is_forbidden,
    is_full,
    is_read_only,
    write_error,
)
from vomstudio.core.files.untrusted.databases import open_read_only
from vomstudio.core.findings import Finding, to_finding
from vomstudio.project.journal.rows import Head, decode_journal_text, read_head, read_rows

_Stamp = tuple[int, int, int, int]
PAGE_BYTES = 4096


class JournalFiles:
    """File of a journal and its log, as last written by this program.

    The device and inode show whether the file is still the open one; sizes, times and SQLite's
    `data_version` show whether another program has written to it.
    """

    def __init__(self, path: Path, db: sqlite3.Connection) -> None:
        self._path, self._db = path, db
        # Used twice for each row.
        self._file, self._log = str(path), f"{path}-wal"
        self._file_stamp: _Stamp | None = None
        # Stays open as long as the database: closing any descriptor of a file releases all locks of
        # this process on it.
        self._descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_BINARY", 0))
        self.record_state()

    def close(self) -> None:
        """Close the descriptor after the database has been closed."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
        self._descriptor = -1

    def _read_first_page(self) -> bytes:
        """Return the first page of the file, without its log."""
        try:
            return os.pread(self._descriptor, PAGE_BYTES, 0) if hasattr(os, "pread") else b""
        except OSError:
            return b""

    def record_state(self) -> None:
        """Record the current state of the files as the one written by this program."""
        self._note_files()
        self._version = _data_version(self._db)

    def _note_files(self) -> None:
        current_stamp = _stamp(self._file)
        if current_stamp != self._file_stamp:
            self._first_page = self._read_first_page()
        self._file_stamp, self._log_stamp = current_stamp, _stamp(self._log)

    def record_write(self) -> Finding | None:
        """Record the state after a write.

        Returns a finding if the row is not in the file at the journal's path, otherwise None.
        """
        previous_file_stamp, log = self._file_stamp, self._log_stamp
        # Rows written by this connection do not change the version.
        self._note_files()
        if not _is_same_file(previous_file_stamp, self._file_stamp) or (
            log and not _is_same_file(log, self._log_stamp)
        ):
            self._file_stamp, self._log_stamp = previous_file_stamp, log
            return self._loss_finding()
        return None

    def write_failure(self, head: Head) -> Finding | None:
        """Return the reason why nothing may be written, or None.

        `head` is the head that the file is expected to have.
        """
        current_stamp, log = _stamp(self._file), _stamp(self._log)
        version = _data_version(self._db)
        if (current_stamp, log, version) == (self._file_stamp, self._log_stamp, self._version):
            return None
        is_same = _is_same_file(self._file_stamp, current_stamp) and (
            self._log_stamp is None or _is_same_file(self._log_stamp, log)
        )
        # Truncated pages that have not been read yet may be missing.
        is_same = is_same and not _is_shorter(current_stamp, self._file_stamp)
        # The log hides the file: an older copy written into the file does not become visible until
        # the log is merged.
        if (
            is_same
            and self._read_first_page() == self._first_page
            and contains_rows(self._path, head)
        ):
            # The file was touched but not written.
            self.record_state()
            return None
        return self._loss_finding()

    def _loss_finding(self) -> Finding:
        folder = self._path.parent
        if not folder.is_dir():
            return Finding("journal.folder-gone")
        if not self._path.is_file():
            return Finding("journal.gone")
        return Finding("journal.replaced")

    def has_rows_at_path(self, head: Head) -> bool:
        """Return whether the rows up to `head` are at the path, possibly in a different file."""
        is_untouched = not self.is_open_file() or (
            self._read_first_page() == self._first_page
            and not _is_shorter(_stamp(self._file), self._file_stamp)
        )
        return is_untouched and contains_rows(self._path, head)

    def has_known_log(self) -> bool:
        """Return whether the log next to the journal is the one written by this program."""
        return self._log_stamp is not None and _is_same_file(self._log_stamp, _stamp(self._log))

    def is_open_file(self) -> bool:
        """Return whether the file at the journal's path is the file that is open."""
        return self._file_stamp is not None and _is_same_file(self._file_stamp, _stamp(self._file))


def write_failure_finding(error: Exception, path: Path) -> Finding:
    """Return the finding for an error of SQLite or of a file next to a journal."""
    if is_full(path.parent, error):
        return Finding("disk.full")
    if is_read_only(path.parent, error):
        return Finding("disk.read-only")
    if is_forbidden(path.parent, error):
        return Finding("disk.no-permission")
    if isinstance(error, VomError):
        return to_finding(error)
    return Finding("journal.not-written", reason=error)


def contains_rows(path: Path, head: Head) -> bool:
    """Return whether the journal at `path` contains the rows up to `head` unchanged."""
    try:
        with closing(open_read_only(path, 1.0)) as db:
            db.text_factory = decode_journal_text
            if read_head(db) != head:
                return False
            return not any(row.problem or row.notice for row in read_rows(db, path))
    except (sqlite3.Error, VomError, OSError):
        return False


def has_interrupted_write(path: Path, error: sqlite3.Error) -> bool:
    """Return whether reading failed because of an interrupted write, and roll it back."""
    log = path.with_name(f"{path.name}-journal")
    if getattr(error, "sqlite_errorcode", 0) & 0xFF != sqlite3.SQLITE_READONLY or not log.exists():
        return False
    try:
        with closing(sqlite3.connect(path, timeout=5.0)) as db:
            db.execute("SELECT count(*) FROM sqlite_master").fetchone()
    except sqlite3.Error:
        return False
    return True


def copy_database(db: sqlite3.Connection, path: Path) -> None:
    """Write a consistent copy of all committed data. Raises TargetError."""
    check_generated_path(path)
    try:
        target = sqlite3.connect(path)
        try:
            db.backup(target)
        finally:
            target.close()
    except sqlite3.Error as error:
        raise write_error(path, error) from error


def read_journal_head(path: Path) -> Head:
    """Return the head of a journal that is not open. Raises TargetError if it is unreadable."""
    try:
        with closing(sqlite3.connect(path)) as db:
            return read_head(db)
    except sqlite3.Error as error:
        raise write_error(path, error) from error


def close_without_checkpoint(db: sqlite3.Connection, path: Path, *, is_known_log: bool) -> None:
    """Close a journal whose file has been replaced, without merging its log into the new file.

    SQLite merges the log when the last connection closes. A reader that stays open longer prevents
    that and cannot merge the log itself.
    """
    reader: sqlite3.Connection | None = None
    try:
        reader = open_read_only(path)
        reader.execute("BEGIN")
        reader.execute("SELECT count(*) FROM sqlite_master").fetchone()
    except (InputError, sqlite3.Error):
        pass
    db.close()
    if is_known_log:
        # Otherwise the next program would treat the log as part of the new file.
        for suffix in ("-wal", "-shm"):
            path.with_name(path.name + suffix).unlink(missing_ok=True)
    if reader is not None:
        reader.close()


def open_error(error: sqlite3.Error, path: Path) -> InputError | TargetError:
    """Return the error for a journal that cannot be opened."""
    message = str(error)
    if "not a database" in message or "malformed" in message:
        return InputError(Finding("journal.damaged", reason=error), file=path)
    if "locked" in message:
        return InputError(Finding("journal.in-use"), file=path)
    return TargetError(
        Finding("journal.not-opened", reason=failure_reason(path.parent, error)),
        file=path,
    )


def _stamp(path: str) -> _Stamp | None:
    try:
        status = os.stat(path)
    except OSError:
        return None
    return status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns


def _is_same_file(first: _Stamp | None, second: _Stamp | None) -> bool:
    if first is None or second is None:
        return first is second
    return first[:2] == second[:2]


def _is_shorter(current_stamp: _Stamp | None, previous_stamp: _Stamp | None) -> bool:
    return (
        current_stamp is not None
        and previous_stamp is not None
        and current_stamp[2] < previous_stamp[2]
    )


def _data_version(db: sqlite3.Connection) -> int:
    try:
        (version,) = db.execute("PRAGMA data_version").fetchone()
    except sqlite3.Error:
        return -1
    return int(version)


def is_read_only_connection(error: sqlite3.Error, path: Path) -> bool:
    """Return whether the disk was read-only when the database was opened but is now writable.

    In this case SQLite stays read-only as long as the database is open.
    """
    code = getattr(error, "sqlite_errorcode", 0) & 0xFF
    return code == sqlite3.SQLITE_READONLY and os.access(path, os.W_OK)
