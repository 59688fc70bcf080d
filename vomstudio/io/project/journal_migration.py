"""Journals of earlier schemas, brought to that of today."""

from __future__ import annotations

import sqlite3
from pathlib import Path

from vomstudio.document.journal import replay
from vomstudio.io.project.journal_ground import copy_database
from vomstudio.io.project.journal_rows import COLUMNS, SET_HEAD, Head, checksum, read_rows

SCHEMA_VERSION = 9
TAKING_IN = "taking in the files of schema 1"
"""A view that is true from the migration on until `folder.Project` has made records of them."""


def migrate(db: sqlite3.Connection, path: Path, schema: int) -> None:
    """Bring a journal of an earlier schema to that of today, by one small step per schema, after
    all of it was read and a copy was made. Raises InputError, TargetError, with the file as it was.
    """
    # Damaged rows are named at each opening, and stay what they are.
    replay(read_rows(db, path, schema))
    keep = path.with_name(f"{path.stem}-schema{schema}{path.suffix}")
    if not keep.exists():
        copy_database(db, keep)
    db.execute("BEGIN IMMEDIATE")
    try:
        for step in range(schema, SCHEMA_VERSION):
            _STEPS[step](db)
            db.execute(f"PRAGMA user_version = {step + 1}")
        db.execute("COMMIT")
    except BaseException:
        if db.in_transaction:
            db.execute("ROLLBACK")
        raise


def _to_schema_2(db: sqlite3.Connection) -> None:
    """Checksums, each over the row before it. Rows stay as they were written: whole records, and
    models with a frame beside its matrix, are read as ever (`document.codec`)."""
    db.execute("ALTER TABLE journal ADD COLUMN checksum TEXT NOT NULL DEFAULT ''")
    db.execute(
        "CREATE TABLE head (id INTEGER PRIMARY KEY CHECK (id = 1), rows INTEGER NOT NULL, "
        "seq INTEGER NOT NULL, checksum TEXT NOT NULL)"
    )
    head = Head(0, 0, "")
    for values in db.execute(f"SELECT {COLUMNS} FROM journal ORDER BY seq").fetchall():
        head = Head(head.rows + 1, values[0], checksum(head.checksum, values))
        db.execute("UPDATE journal SET checksum = ? WHERE seq = ?", (head.checksum, head.seq))
    db.execute(SET_HEAD, head)
    db.execute("INSERT OR REPLACE INTO view VALUES (?, 'true')", (TAKING_IN,))


def _read_as_they_are(db: sqlite3.Connection) -> None:
    """Rows of before lack what is new and are read as they are; programs of before cannot read rows
    that have it."""


# _STEPS[n] brings schema n to n + 1. 3: lines say how sure their sense of slip is. 4: profiles of
# verdicts, and the rule by which surroundings were measured. 5: a registration's points and
# covariance. 6: control points among the features. 7: how far a model reaches, and its lenses. 8:
# stations, contacts, lithologies and known lines among the features; repeats of a feature, and by
# whom; grids of what was looked at; frames of which a part is known. 9: planes read by compass,
# from which north; what is said of the beds along a line.
_STEPS = {1: _to_schema_2, **dict.fromkeys(range(2, SCHEMA_VERSION), _read_as_they_are)}
