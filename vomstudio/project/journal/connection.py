"""Database connection of a journal that survives a truncation of its files.

SQLite maps one file, the index beside the log (`-shm`), into memory. Access to a map whose file was
truncated ends the process. The index can always be rebuilt from the log
(https://www.sqlite.org/walformat.html, 2.2), so a truncated file is filled with zeros before each
use, which SQLite takes for an index to be rebuilt.
"""

from __future__ import annotations

import os
import sqlite3
from typing import Any

_FLAGS = os.O_RDWR | getattr(os, "O_NOFOLLOW", 0)
PAGE_BYTES = 4096


class JournalConnection(sqlite3.Connection):
    """Factory for `sqlite3.connect`; `path` is that of the journal."""

    # Set before `__init__`, which fails if the database cannot be opened.
    _index = -1

    def __init__(self, path: Any, *args: Any, **options: Any) -> None:
        super().__init__(path, *args, **options)
        self._index_path = f"{os.fspath(path)}-shm"
        # Kept open as long as the database: closing any descriptor of a file releases the locks of
        # this process on it.
        self._size = 0

    def _restore_index(self) -> None:
        """Fill a truncated index. Raises sqlite3.OperationalError if that fails."""
        if self._index < 0:
            # Windows does not allow a mapped file to be truncated.
            if not hasattr(os, "pwrite"):
                return
            try:
                self._index = os.open(self._index_path, _FLAGS)
            except OSError:
                return
        try:
            size = os.fstat(self._index).st_size
            while size < self._size:
                # Written, not only extended: a page without space on a full disk is as fatal.
                missing = min(PAGE_BYTES, self._size - size)
                size += os.pwrite(self._index, bytes(missing), size)
        except OSError as error:
            raise sqlite3.OperationalError(
                f"disk I/O error: {error.strerror}"  # as SQLite words it
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
        if self._index >= 0:
            os.close(self._index)
        self._index = -1

    def __del__(self) -> None:
        if self._index >= 0:
            self.close()
