"""What the file of a journal may hold: its tables, whole, and no programs.

A database can hold views, triggers, generated columns, conditions and indices over expressions.
They run when a row is read, written or checked: they need not come to an end, and can take other
rows away. Whoever packed a project may have put them in.
"""

from __future__ import annotations

import re
import sqlite3
from pathlib import Path

from vomstudio.errors import InputError
from vomstudio.words import tr

_TABLES = {"journal", "head", "view"}
_KNOWN = re.compile(r"check\s*\(\s*id\s*=\s*1\s*\)")


def require_plain(db: sqlite3.Connection, path: Path) -> None:
    """Raises InputError where the file holds anything but tables of columns, sqlite3.Error where
    that cannot be read."""
    for kind, name, words in db.execute("SELECT type, name, sql FROM sqlite_master"):
        # What SQLite makes by itself, for keys and statistics, has no words or a name of its own.
        if words is None or (kind == "table" and str(name).startswith("sqlite_")):
            continue
        if kind != "table" or name not in _TABLES or not _is_plain(str(words)):
            raise InputError(
                tr(
                    "The journal holds something that no journal has ({kind} '{name}') and that "
                    "could change or hide its rows. Ask for another copy of the project.",
                    kind=str(kind)[:20],
                    name=str(name)[:100],
                ),
                file=path,
            )


def _is_plain(words: str) -> bool:
    """A table of columns with types: whatever is worked out stands in brackets of its own."""
    bare = _KNOWN.sub("", words.lower())
    return bare.startswith("create table") and bare.count("(") == 1


def require_sound(db: sqlite3.Connection, path: Path) -> None:
    """Raises InputError for a file that was torn: writing to it would make it worse."""
    (said,) = db.execute("PRAGMA quick_check(1)").fetchone()
    if said != "ok":
        raise InputError(tr("The journal is damaged. Restore it from a copy."), file=path)
