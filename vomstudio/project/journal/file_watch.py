"""What lies under an open journal: its file, which can be deleted, replaced or become unwritable
while it is open."""

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
from vomstudio.core.files.untrusted.databases import open_to_read
from vomstudio.core.findings import Finding, finding_of
from vomstudio.project.journal.rows import Head, read_head, read_rows, text_of

_Stamp = tuple[int, int, int, int]
_PAGE = 4096


class Ground:
    """The file of a journal and its log as this program has left them last.

    Device and inode tell whether the file is still the one that is open; sizes, times and SQLite's
    `data_version` whether somebody else has written to it.
    """

    def __init__(self, path: Path, db: sqlite3.Connection) -> None:
        self._path, self._db = path, db
        # Asked for twice with each row.
        self._file, self._log = str(path), f"{path}-wal"
        self._file_stamp: _Stamp | None = None
        # Open as long as the database: closing any descriptor of a file gives up the locks that
        # SQLite has on it in this process.
        self._descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_BINARY", 0))
        self.note()

    def close(self) -> None:
        """After the database was closed."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
        self._descriptor = -1

    def _beneath(self) -> bytes:
        """The first page of the file, without its log."""
        try:
            return os.pread(self._descriptor, _PAGE, 0) if hasattr(os, "pread") else b""
        except OSError:
            return b""

    def note(self) -> None:
        """The files as they are now are ours."""
        self._note_files()
        self._version = _data_version(self._db)

    def _note_files(self) -> None:
        now = _stamp(self._file)
        if now != self._file_stamp:
            self._first_page = self._beneath()
        self._file_stamp, self._log_stamp = now, _stamp(self._log)

    def note_written(self) -> Finding | None:
        """After a row of ours: as `note`, or why the row is not where the journal was."""
        was, log = self._file_stamp, self._log_stamp
        # Rows of ours leave the version as it is.
        self._note_files()
        if not _same_file(was, self._file_stamp) or (log and not _same_file(log, self._log_stamp)):
            self._file_stamp, self._log_stamp = was, log
            return self._why_lost()
        return None

    def write_failure(self, head: Head) -> Finding | None:
        """Why nothing may be written, or None. head : of the rows that the file holds."""
        now, log = _stamp(self._file), _stamp(self._log)
        version = _data_version(self._db)
        if (now, log, version) == (self._file_stamp, self._log_stamp, self._version):
            return None
        same = _same_file(self._file_stamp, now) and (
            self._log_stamp is None or _same_file(self._log_stamp, log)
        )
        # Of the pages that were cut off those may be missing which have not been read yet.
        same = same and not _is_shorter(now, self._file_stamp)
        # The log hides what is beneath it: an older copy written into the file is not seen through
        # it until the log is folded in.
        if same and self._beneath() == self._first_page and holds(self._path, head):
            # Touched, but nothing was written.
            self.note()
            return None
        return self._why_lost()

    def _why_lost(self) -> Finding:
        folder = self._path.parent
        if not folder.is_dir():
            return Finding("journal.folder-gone")
        if not self._path.is_file():
            return Finding("journal.gone")
        return Finding("journal.replaced")

    def is_back(self, head: Head) -> bool:
        """Whether the rows up to `head` are at the journal's place, be it in another file."""
        untouched = not self.is_ours() or (
            self._beneath() == self._first_page
            and not _is_shorter(_stamp(self._file), self._file_stamp)
        )
        return untouched and holds(self._path, head)

    def has_log_of_ours(self) -> bool:
        """Whether the log beside the journal is the one that this program wrote."""
        return self._log_stamp is not None and _same_file(self._log_stamp, _stamp(self._log))

    def is_ours(self) -> bool:
        """Whether the file at the journal's place is the one that is open."""
        return self._file_stamp is not None and _same_file(self._file_stamp, _stamp(self._file))


def write_failure_of(error: Exception, path: Path) -> Finding:
    """What an error of SQLite, or of a file beside a journal, means for it."""
    if is_full(path.parent, error):
        return Finding("disk.full")
    if is_read_only(path.parent, error):
        return Finding("disk.read-only")
    if is_forbidden(path.parent, error):
        return Finding("disk.no-permission")
    if isinstance(error, VomError):
        return finding_of(error)
    return Finding("journal.not-written", reason=error)


def holds(path: Path, head: Head) -> bool:
    """Whether the journal at `path` holds the rows up to `head`, each as it was written."""
    try:
        with closing(open_to_read(path, 1.0)) as db:
            db.text_factory = text_of
            if read_head(db) != head:
                return False
            return not any(row.problem or row.notice for row in read_rows(db, path))
    except (sqlite3.Error, VomError, OSError):
        return False


def writing_was_cut_off(path: Path, error: sqlite3.Error) -> bool:
    """Whether a reader was refused because a row was begun when the power went, and was taken back
    just now."""
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
    """A sound copy of everything committed so far. Raises TargetError."""
    check_generated_path(path)
    try:
        target = sqlite3.connect(path)
        try:
            db.backup(target)
        finally:
            target.close()
    except sqlite3.Error as error:
        raise write_error(path, error) from error


def head_of(path: Path) -> Head:
    """Of a journal that is not open. Raises TargetError where it cannot be read."""
    try:
        with closing(sqlite3.connect(path)) as db:
            return read_head(db)
    except sqlite3.Error as error:
        raise write_error(path, error) from error


def leave_alone(db: sqlite3.Connection, path: Path, *, log_is_ours: bool) -> None:
    """Close a journal of which the file was replaced: nothing of the log goes into what is there.

    SQLite folds the log in when the last connection closes. A reader that stays longer keeps it
    from that, and cannot do it itself.
    """
    reader: sqlite3.Connection | None = None
    try:
        reader = open_to_read(path)
        reader.execute("BEGIN")
        reader.execute("SELECT count(*) FROM sqlite_master").fetchone()
    except (InputError, sqlite3.Error):
        pass
    db.close()
    if log_is_ours:
        # Whoever opens the other state next would take it for a part of that.
        for ending in ("-wal", "-shm"):
            path.with_name(path.name + ending).unlink(missing_ok=True)
    if reader is not None:
        reader.close()


def open_error(error: sqlite3.Error, path: Path) -> InputError | TargetError:
    words = str(error)
    if "not a database" in words or "malformed" in words:
        return InputError(Finding("journal.damaged", reason=error), file=path)
    if "locked" in words:
        return InputError(Finding("journal.in-use"), file=path)
    return TargetError(
        Finding("journal.not-opened", reason=failure_reason(path.parent, error)),
        file=path,
    )


def _stamp(path: str) -> _Stamp | None:
    try:
        found = os.stat(path)
    except OSError:
        return None
    return found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns


def _same_file(one: _Stamp | None, other: _Stamp | None) -> bool:
    if one is None or other is None:
        return one is other
    return one[:2] == other[:2]


def _is_shorter(now: _Stamp | None, was: _Stamp | None) -> bool:
    return now is not None and was is not None and now[2] < was[2]


def _data_version(db: sqlite3.Connection) -> int:
    try:
        (version,) = db.execute("PRAGMA data_version").fetchone()
    except sqlite3.Error:
        return -1
    return int(version)


def only_reads(error: sqlite3.Error, path: Path) -> bool:
    """Whether the database was opened while its disk could not be written, and could be now: SQLite
    then goes on reading alone for as long as it is open."""
    code = getattr(error, "sqlite_errorcode", 0) & 0xFF
    return code == sqlite3.SQLITE_READONLY and os.access(path, os.W_OK)
