"""Database connection of a journal that survives the truncation of its files.

SQLite maps one file, the index next to the log (`-shm`), into memory. Accessing the map of a
truncated file ends the process. The index can always be rebuilt from the log
(https://www.sqlite.org/walformat.html, 2.2), so a truncated file is filled with zeros before each
use, which makes SQLite rebuild the index.
"""

from __future__ import annotations

import os
import sqlite3
from typing import Any

_OPEN_FLAGS = os.O_RDWR | getattr(os, "O_NOFOLLOW", 0)
PAGE_BYTES = 4096


class JournalConnection(sqlite3.Connection):
    """Connection factory for `sqlite3.connect`; `path` is the path of the journal."""

    # Set before `__init__` because that fails if the database cannot be opened.
    _index_descriptor = -1

    def __init__(self, path: Any, *args: Any, **options: Any) -> None:
        super().__init__(path, *args, **options)
        self._index_path = f"{os.fspath(path)}-shm"
        # Stays open as long as the database: closing any descriptor of a file releases all locks of
        # this process on it.
        self._size = 0

    def _restore_index(self) -> None:
        """Fill a truncated index with zeros. Raises sqlite3.OperationalError if that fails."""
        if self._index_descriptor < 0:
            # Windows does not allow a mapped file to be truncated.
            if not hasattr(os, "pwrite"):
                return
            try:
                self._index_descriptor = os.open(self._index_path, _OPEN_FLAGS)
            except OSError:
                return
        try:
            size = os.fstat(self._index_descriptor).st_size
            while size < self._size:
                # Write the zeros instead of only extending the file: on a full disk, a page without
                # space is just as fatal.
                missing_bytes = min(PAGE_BYTES, self._size - size)
                size += os.pwrite(self._index_descriptor, bytes(missing_bytes), size)
        except OSError as error:
            raise sqlite3.OperationalError(
                f"disk I/O error: {error.strerror}"  # same wording as SQLite
            ) from error
        self._size = size

    def execute(self, *args: Any) -> sqlite3.Cursor:
        self._restore_index()
        return super().execute(*args)

    def executemany(self, *args: Any) -> sqlite3.Cursor:
        self._restore_index()
        return super().executemany(*args)

    def executescript(self, *args: Any) -> sqlite3.Cursor:
        self._restore_index()
        return super().executescript(*args)

    def backup(self, *args: Any, **options: Any) -> None:
        self._restore_index()
        super().backup(*args, **options)

    def close(self) -> None:
        self._restore_index()
        super().close()
        if self._index_descriptor >= 0:
            os.close(self._index_descriptor)
        self._index_descriptor = -1

    def __del__(self) -> None:
        if self._index_descriptor >= 0:
            self.close()
