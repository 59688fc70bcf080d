"""Check that the schema of a journal contains its tables only and no code.

A database can contain views, triggers, generated columns, constraints and indices on expressions.
They run when a row is read, written or checked, may never terminate, and can remove other rows. A
project from an untrusted source may contain them.
"""

from __future__ import annotations

import sqlite3
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.files.untrusted.databases import read_schema, refuse
from vomstudio.core.findings import Finding

_TABLES = {"journal", "head", "view"}
_HEAD_CHECK = ("check", "(", "id", "=", "1", ")")


def require_plain(db: sqlite3.Connection, path: Path) -> None:
    """Check that a journal contains only its own tables, with plain columns.

    Raises
    ------
    InputError
        If it contains anything else; the code is ``file.unsafe-schema``.
    sqlite3.Error
        If the schema cannot be read.
    """
    for entry in read_schema(db):
        # SQLite stores statistics in tables with a reserved prefix.
        is_known = entry.name in _TABLES or entry.name.startswith("sqlite_")
        if entry.kind != "table" or not is_known or not _is_plain(entry.tokens):
            refuse(entry.kind, entry.name, path)


def _is_plain(tokens: tuple[str, ...]) -> bool:
    """Return whether a table contains only columns with types.

    Constraints and computed columns contain brackets.
    """
    size = len(_HEAD_CHECK)
    brackets = tokens.count("(")
    for start in range(len(tokens) - size + 1):
        brackets -= tokens[start : start + size] == _HEAD_CHECK
    return brackets == 1


def require_intact(db: sqlite3.Connection, path: Path) -> None:
    """Reject a damaged file, which writing would damage further. Raises InputError."""
    (result,) = db.execute("PRAGMA quick_check(1)").fetchone()
    if result != "ok":
        raise InputError(Finding("journal.damaged", reason=result), file=path)
