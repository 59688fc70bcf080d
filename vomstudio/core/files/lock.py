"""One program at a time in one folder.

The lock is a small SQLite file on which a write transaction is held: every system gives it up by
itself when the process dies, and pid and host can be read by others while it is held.
"""

from __future__ import annotations

import contextlib
import os
import platform
import sqlite3
from pathlib import Path

from vomstudio.core.errors import InputError, TargetError
from vomstudio.core.files.containment import check_beside
from vomstudio.core.files.disk_errors import reason_of
from vomstudio.core.files.regular import is_regular
from vomstudio.core.files.untrusted.databases import harden
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr

_HOLDER = "CREATE TABLE holder (pid INTEGER, host TEXT)"


class FolderLock:
    """Lock of one folder.

    Parameters
    ----------
    path : Path
        The SQLite file of the lock.
    busy, unwritable : str
        Codes of the findings that another process has the lock (value ``holder``), and that it
        cannot be written (value ``reason``).
    patience_s : float
        How long to wait for a process that has the lock and may be ending.
    """

    def __init__(self, path: Path, busy: str, unwritable: str, patience_s: float = 0.0) -> None:
        """Raises InputError that says who holds it, TargetError where it cannot be written."""
        for name in (path.name, f"{path.name}-journal", f"{path.name}-wal", f"{path.name}-shm"):
            _remove_odd(check_beside(path.with_name(name)))
        for attempt in (1, 2):
            try:
                self._db = sqlite3.connect(
                    path, isolation_level=None, timeout=patience_s, check_same_thread=False
                )
                harden(self._db)
                self._require_plain()
                self._db.execute(_HOLDER.replace("TABLE", "TABLE IF NOT EXISTS"))
                self._db.execute("DELETE FROM holder")
                mine = (os.getpid(), platform.node())
                self._db.execute("INSERT INTO holder VALUES (?, ?)", mine)
                self._db.execute("BEGIN IMMEDIATE")
                return
            except sqlite3.DatabaseError as error:
                holder = self._holder()
                self.release()
                if isinstance(error, sqlite3.OperationalError) and "locked" in str(error):
                    raise InputError(Finding(busy, holder=holder), file=path.parent) from error
                # A damaged lock protects nobody: whoever holds a sound one has it locked.
                reason: str | None = reason_of(path.parent, error)
                if attempt == 1 and _remove(path) is None:
                    reason = None
                if reason is not None:
                    raise TargetError(
                        Finding(unwritable, reason=reason), file=path.parent
                    ) from error

    def _require_plain(self) -> None:
        """Raises sqlite3.DatabaseError where whoever packed the folder has put more into the file
        than who holds it: triggers run, and need not come to an end."""
        found = self._db.execute("SELECT sql FROM sqlite_master").fetchall()
        if found not in ([], [(_HOLDER,)]):
            raise sqlite3.DatabaseError("not a lock")

    def _holder(self) -> str:
        try:
            pid, host = self._db.execute("SELECT pid, host FROM holder").fetchone()
        except (AttributeError, sqlite3.Error, TypeError):
            return tr("unknown process")
        return tr("process {number} on {host}", number=pid, host=host)

    def release(self) -> None:
        if hasattr(self, "_db"):
            self._db.close()


def _remove_odd(path: Path) -> None:
    """A pipe or device, for which SQLite would wait, is no lock, and protects nobody."""
    if path.exists() and not path.is_dir() and not is_regular(path):
        with contextlib.suppress(OSError):
            path.unlink()


def _remove(path: Path) -> str | None:
    """Why it cannot be removed; None where it is gone."""
    try:
        path.unlink(missing_ok=True)
        path.with_name(path.name + "-journal").unlink(missing_ok=True)
    except OSError as error:
        return error.strerror
    return None


class ProjectLock(FolderLock):
    """One window at a time on one project."""

    def __init__(self, path: Path) -> None:
        """Raises InputError that says who holds it."""
        super().__init__(path, "project.locked", "project.unwritable")
