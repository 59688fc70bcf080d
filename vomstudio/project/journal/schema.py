"""What the file of a journal may hold: its tables, whole, and no programs.

A database can hold views, triggers, generated columns, conditions and indices over expressions.
They run when a row is read, written or checked: they need not come to an end, and can take other
rows away. Whoever packed a project may have put them in.
"""

from __future__ import annotations

import sqlite3
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.files.untrusted.databases import read_schema, refuse
from vomstudio.core.findings import Finding

_TABLES = {"journal", "head", "view"}
_KNOWN_CHECK = ("check", "(", "id", "=", "1", ")")


def require_plain(db: sqlite3.Connection, path: Path) -> None:
    """Check that a journal contains its tables alone, each of plain columns.

    Raises
    ------
    InputError
        With ``file.unsafe-schema`` for anything else.
    sqlite3.Error
        If the schema cannot be read.
    """
    for entry in read_schema(db):
        # Statistics that SQLite keeps have tables of a name that nobody else can give.
        is_known = entry.name in _TABLES or entry.name.startswith("sqlite_")
        if entry.kind != "table" or not is_known or not _is_plain(entry.tokens):
            refuse(entry.kind, entry.name, path)


def _is_plain(tokens: tuple[str, ...]) -> bool:
    """Return whether a table has columns with types only: conditions and computed columns have
    brackets of their own."""
    size = len(_KNOWN_CHECK)
    brackets = tokens.count("(")
    for at in range(len(tokens) - size + 1):
        brackets -= tokens[at : at + size] == _KNOWN_CHECK
    return brackets == 1


def require_sound(db: sqlite3.Connection, path: Path) -> None:
    """Raises InputError for a file that was torn: writing to it would make it worse."""
    (said,) = db.execute("PRAGMA quick_check(1)").fetchone()
    if said != "ok":
        raise InputError(Finding("journal.damaged", reason=said), file=path)
