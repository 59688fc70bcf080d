"""One window at a time on one project.

The lock is a small SQLite file on which a write transaction is held: every system gives it up by
itself when the process dies, and pid and host can be read by others while it is held.
"""

from __future__ import annotations

import os
import platform
import sqlite3
from pathlib import Path

from vomstudio.errors import InputError, TargetError


class ProjectLock:
    def __init__(self, path: Path) -> None:
        """Raises InputError that says who holds it."""
        try:
            self._db = sqlite3.connect(path, isolation_level=None, timeout=0.0)
            self._db.execute("CREATE TABLE IF NOT EXISTS holder (pid INTEGER, host TEXT)")
            self._db.execute("DELETE FROM holder")
            self._db.execute("INSERT INTO holder VALUES (?, ?)", (os.getpid(), platform.node()))
            self._db.execute("BEGIN IMMEDIATE")
        except sqlite3.OperationalError as error:
            if "locked" not in str(error):
                raise TargetError(
                    f"the project's folder cannot be written ({error}); copy it to where you may "
                    "write and open the copy",
                    file=path.parent,
                ) from error
            holder = self._holder()
            self._db.close()
            raise InputError(
                f"the project is open in another window ({holder}); close it there first",
                file=path.parent,
            ) from error
        except sqlite3.DatabaseError:
            # A damaged lock protects nobody.
            self._db.close()
            path.unlink(missing_ok=True)
            ProjectLock.__init__(self, path)

    def _holder(self) -> str:
        try:
            pid, host = self._db.execute("SELECT pid, host FROM holder").fetchone()
        except (sqlite3.Error, TypeError):
            return "unknown process"
        return f"process {pid} on {host}"

    def release(self) -> None:
        self._db.close()
