"""The project's journal in SQLite: append-only rows, each on the disk before its effect is seen.

WAL with synchronous FULL where the file system can do it, a rollback journal where it cannot
(network drives). On close the log is folded in, so that the one file can be copied and zipped.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable, Iterator, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from vomstudio import __version__
from vomstudio.document.journal import Replay, Row, RowKind, replay
from vomstudio.document.records import Record
from vomstudio.errors import DocumentError, InputError, TargetError

SCHEMA_VERSION = 1
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
    settings TEXT
);
CREATE TABLE view (key TEXT PRIMARY KEY, value TEXT NOT NULL);
PRAGMA application_id = {APPLICATION_ID};
PRAGMA user_version = {SCHEMA_VERSION};
"""

# One small step per schema version: _MIGRATIONS[n] brings version n to n + 1.
_MIGRATIONS: dict[int, Callable[[sqlite3.Connection], None]] = {}


class SqliteJournal:
    """A `document.journal.Journal` in one file. Also keeps view state, which is not history."""

    def __init__(self, path: Path, *, create: bool = False) -> None:
        """Raises InputError where the file is not a journal of ours or is newer than this program,
        TargetError where it cannot be written."""
        self.path = path
        if create and path.exists():
            raise TargetError("there is a project here already", file=path)
        if not create and not path.is_file():
            raise InputError("is not a VOM Studio project: journal.sqlite is missing", file=path)
        try:
            self._db = sqlite3.connect(path, isolation_level=None, timeout=5.0)
            if create:
                self._db.executescript("BEGIN;" + _SCHEMA + "COMMIT;")
            _check_version(self._db, path, migrate=True)
            self._make_durable()
        except sqlite3.Error as error:
            raise _open_error(error, path) from error

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
        time = datetime.now(UTC).isoformat(timespec="milliseconds")
        try:
            cursor = self._db.execute(
                "INSERT INTO journal (kind, of_seq, label, before, after, time, version, settings)"
                " VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
                (
                    kind,
                    of_seq,
                    label,
                    _dump(before),
                    _dump(after),
                    time,
                    __version__,
                    _dump(settings),
                ),
            )
        except sqlite3.Error as error:
            raise DocumentError(
                f"the project's journal cannot be written ({error}); nothing was changed. "
                "Free some space or check the drive, then do it again",
                file=self.path,
            ) from error
        assert cursor.lastrowid is not None
        return cursor.lastrowid

    def rows(self) -> Iterator[Row]:
        """Rows in order. Raises InputError where the file itself is damaged."""
        return _rows(self._db, self.path)

    def last_rows(self, count: int) -> list[Row]:
        """The newest rows, in order. Raises InputError where the file itself is damaged."""
        return list(_rows(self._db, self.path, count))

    # --- view state: camera, visibility, panels ----------------------------------------------
    def set_view(self, key: str, value: Any) -> None:
        # A lost camera is no loss of work: view state never stands in the way of an edit.
        try:
            self._db.execute("INSERT OR REPLACE INTO view VALUES (?, ?)", (key, json.dumps(value)))
        except sqlite3.Error:
            return

    def view(self, key: str, default: Any = None) -> Any:
        try:
            found = self._db.execute("SELECT value FROM view WHERE key = ?", (key,)).fetchone()
            return default if found is None else json.loads(found[0])
        except (sqlite3.Error, ValueError):
            return default

    # --- copies ------------------------------------------------------------------------------
    def copy_to(self, path: Path) -> None:
        """A sound copy of everything committed so far."""
        try:
            target = sqlite3.connect(path)
            try:
                self._db.backup(target)
            finally:
                target.close()
        except sqlite3.Error as error:
            raise TargetError(f"cannot be written ({error})", file=path) from error

    def close(self) -> None:
        try:
            self._db.execute("PRAGMA wal_checkpoint(TRUNCATE)")
            self._db.execute("PRAGMA journal_mode = DELETE")
        except sqlite3.Error:
            # Another reader holds the file: the log stays beside it and is folded in next time.
            pass
        self._db.close()


def own_files(folder: Path) -> list[Path]:
    """The files that are the project's truth, and which no export may replace."""
    return [folder / f"journal.sqlite{ending}" for ending in ("", "-wal", "-shm")]


def read_records(folder: Path) -> dict[str, Record]:
    """The records of the project in `folder` as they are now. Raises as `read_replay`."""
    return read_replay(folder).records


def read_replay(folder: Path) -> Replay:
    """What the journal of the project in `folder` says, without taking hold of it: it may be open
    in a window. Raises InputError."""
    path = Path(folder)
    path = path / "journal.sqlite" if path.is_dir() else path
    if not path.is_file():
        raise InputError(
            "is not a VOM Studio project (a folder with journal.sqlite); check the name.",
            file=folder,
        )
    try:
        db = sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True, timeout=5.0)
        try:
            _check_version(db, path, migrate=False)
            return replay(_rows(db, path))
        finally:
            db.close()
    except sqlite3.Error as error:
        raise _open_error(error, path) from error


def _check_version(db: sqlite3.Connection, path: Path, *, migrate: bool) -> None:
    (application,) = db.execute("PRAGMA application_id").fetchone()
    (version,) = db.execute("PRAGMA user_version").fetchone()
    if application != APPLICATION_ID:
        raise InputError("is not the journal of a VOM Studio project", file=path)
    if version > SCHEMA_VERSION:
        raise InputError(
            f"was written by a newer VOM Studio (journal version {version}, this program "
            f"reads up to {SCHEMA_VERSION}): update the program",
            file=path,
        )
    if version < SCHEMA_VERSION and not migrate:
        raise InputError(
            "was written by an older VOM Studio: open it once in the window, which brings it up "
            "to date",
            file=path,
        )
    for step in range(version, SCHEMA_VERSION):
        db.execute("BEGIN IMMEDIATE")
        _MIGRATIONS[step](db)
        db.execute(f"PRAGMA user_version = {step + 1}")
        db.execute("COMMIT")


def _rows(db: sqlite3.Connection, path: Path, last: int = -1) -> Iterator[Row]:
    """last : how many of the newest rows, -1 for all"""
    try:
        cursor = db.execute(
            "SELECT * FROM (SELECT seq, kind, of_seq, label, before, after, time, version, settings"
            " FROM journal ORDER BY seq DESC LIMIT ?) ORDER BY seq"
            if last >= 0
            else "SELECT seq, kind, of_seq, label, before, after, time, version, settings"
            " FROM journal ORDER BY seq",
            (last,) if last >= 0 else (),
        )
        for seq, kind, of_seq, label, before, after, time, version, settings in cursor:
            yield Row(
                seq,
                kind,
                of_seq,
                label,
                _load(before),
                _load(after),
                time,
                version,
                _load(settings),
            )
    except sqlite3.Error as error:
        raise InputError(
            f"the journal is damaged ({error}); restore it from a copy", file=path
        ) from error


def _dump(value: Mapping[str, Any] | None) -> str | None:
    return None if value is None else json.dumps(value, allow_nan=False, separators=(",", ":"))


class _Damaged(dict[str, Any]):
    """Stands for JSON that cannot be read: the replay names the row and goes on."""


def _load(text: str | None) -> Any:
    if text is None:
        return None
    try:
        return json.loads(text)
    except ValueError:
        return _Damaged({"?": {"record": "damaged"}})


def _open_error(error: sqlite3.Error, path: Path) -> InputError | TargetError:
    words = str(error)
    if "not a database" in words or "malformed" in words:
        return InputError("is damaged or not a journal; restore it from a copy", file=path)
    if "locked" in words:
        return InputError("is in use by another program; close it there first", file=path)
    return TargetError(f"cannot be opened for writing ({words})", file=path)
