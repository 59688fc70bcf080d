"""The open database of a journal, which does not end the process when its ground shrinks.

SQLite maps one file, the index beside the log (`-shm`), and a map of which the file has become
shorter cannot be touched: the system ends the process. What the index says can always be worked out
again from the log (https://www.sqlite.org/walformat.html, 2.2), so before each use a file that has
become shorter is filled up again, with zeros, which SQLite takes for an index to be made anew.
"""

from __future__ import annotations

import os
import sqlite3
from typing import Any

_FLAGS = os.O_RDWR | getattr(os, "O_NOFOLLOW", 0)
_PAGE = 4096


class JournalConnection(sqlite3.Connection):
    """To be given to `sqlite3.connect` as its factory; `path` is then the journal's."""

    # Also where the database cannot be opened, which ends `__init__`.
    _index = -1

    def __init__(self, path: Any, *args: Any, **options: Any) -> None:
        super().__init__(path, *args, **options)
        self._index_path = f"{os.fspath(path)}-shm"
        # Open as long as the database: closing any descriptor of a file gives up the locks that
        # SQLite has on it in this process.
        self._size = 0

    def _mend_index(self) -> None:
        """Raises sqlite3.OperationalError where the index is too short and cannot be filled up."""
        if self._index < 0:
            # Windows lets no file be cut that is mapped.
            if not hasattr(os, "pwrite"):
                return
            try:
                self._index = os.open(self._index_path, _FLAGS)
            except OSError:
                return
        try:
            size = os.fstat(self._index).st_size
            while size < self._size:
                # Written, not only made longer: a page without a place on a full disk is as deadly.
                missing = min(_PAGE, self._size - size)
                size += os.pwrite(self._index, bytes(missing), size)
        except OSError as error:
            raise sqlite3.OperationalError(
                f"disk I/O error: {error.strerror}"  # as SQLite words it
            ) from error
        self._size = size

    def execute(self, *args: Any) -> sqlite3.Cursor:
        self._mend_index()
        return super().execute(*args)

    def executemany(self, *args: Any) -> sqlite3.Cursor:
        self._mend_index()
        return super().executemany(*args)

    def executescript(self, *args: Any) -> sqlite3.Cursor:
        self._mend_index()
        return super().executescript(*args)

    def backup(self, *args: Any, **options: Any) -> None:
        self._mend_index()
        super().backup(*args, **options)

    def close(self) -> None:
        self._mend_index()
        super().close()
        if self._index >= 0:
            os.close(self._index)
        self._index = -1

    def __del__(self) -> None:
        if self._index >= 0:
            self.close()
