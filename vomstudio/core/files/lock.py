"""Lock of a folder, so that only one program uses it at a time.

The lock is a small SQLite file with an open write transaction. Every operating system releases it
when the process dies, and other processes can still read the process ID and host of the holder.
"""

from __future__ import annotations

import contextlib
import os
import platform
import sqlite3
from pathlib import Path

from vomstudio.core.errors import InputError, TargetError
from vomstudio.core.files.containment import check_generated_path
from vomstudio.core.files.disk_errors import failure_reason
from vomstudio.core.files.regular import is_regular_file
from vomstudio.core.files.untrusted.databases import restrict_connection
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr

_HOLDER_SCHEMA = "CREATE TABLE holder (pid INTEGER, host TEXT)"


class FolderLock:
    """Lock of a folder.

    Parameters
    ----------
    path : Path
        SQLite file of the lock.
    busy_code, unwritable_code : str
        Codes of the findings for a lock that another process holds (value ``holder``) and for a
        lock that cannot be written (value ``reason``).
    timeout_s : float
        Time to wait for another process that holds the lock and may be ending, in seconds.
    """

    def __init__(
        self, path: Path, busy_code: str, unwritable_code: str, timeout_s: float = 0.0
    ) -> None:
        """Acquire the lock.

        Raises
        ------
        InputError
            If another process holds the lock.
        TargetError
            If the lock cannot be written.
        """
        for name in (path.name, f"{path.name}-journal", f"{path.name}-wal", f"{path.name}-shm"):
            _remove_special_file(check_generated_path(path.with_name(name)))
        for attempt in (1, 2):
            try:
                self._db = sqlite3.connect(
                    path, isolation_level=None, timeout=timeout_s, check_same_thread=False
                )
                restrict_connection(self._db)
                self._require_plain()
                self._db.execute(_HOLDER_SCHEMA.replace("TABLE", "TABLE IF NOT EXISTS"))
                self._db.execute("DELETE FROM holder")
                owner = (os.getpid(), platform.node())
                self._db.execute("INSERT INTO holder VALUES (?, ?)", owner)
                self._db.execute("BEGIN IMMEDIATE")
                return
            except sqlite3.DatabaseError as error:
                holder = self._read_holder()
                self.release()
                if isinstance(error, sqlite3.OperationalError) and "locked" in str(error):
                    raise InputError(Finding(busy_code, holder=holder), file=path.parent) from error
                # A damaged file is not a lock: a valid one would be reported as locked.
                reason: str | None = failure_reason(path.parent, error)
                if attempt == 1 and _remove(path) is None:
                    reason = None
                if reason is not None:
                    raise TargetError(
                        Finding(unwritable_code, reason=reason), file=path.parent
                    ) from error

    def _require_plain(self) -> None:
        """Raise sqlite3.DatabaseError if the file contains more than the record of its holder.

        A file from an unknown source may contain triggers, which run and may not terminate.
        """
        schema = self._db.execute("SELECT sql FROM sqlite_master").fetchall()
        if schema not in ([], [(_HOLDER_SCHEMA,)]):
            raise sqlite3.DatabaseError("not a lock")

    def _read_holder(self) -> str:
        try:
            pid, host = self._db.execute("SELECT pid, host FROM holder").fetchone()
        except (AttributeError, sqlite3.Error, TypeError):
            return tr("unknown process")
        return tr("process {number} on {host}", number=pid, host=host)

    def release(self) -> None:
        """Release the lock."""
        if hasattr(self, "_db"):
            self._db.close()


def _remove_special_file(path: Path) -> None:
    """Remove a pipe or device: it is not a lock, and SQLite would wait for it."""
    if path.exists() and not path.is_dir() and not is_regular_file(path):
        with contextlib.suppress(OSError):
            path.unlink()


def _remove(path: Path) -> str | None:
    """Remove a lock file; return None, or the reason if the system refuses."""
    try:
        path.unlink(missing_ok=True)
        path.with_name(path.name + "-journal").unlink(missing_ok=True)
    except OSError as error:
        return error.strerror
    return None


class ProjectLock(FolderLock):
    """Lock of a project, so that only one program has it open at a time."""

    def __init__(self, path: Path) -> None:
        """Acquire the lock.

        Raises
        ------
        InputError
            If another process holds the lock.
        TargetError
            If the lock cannot be written.
        """
        super().__init__(path, "project.locked", "project.unwritable")
