"""Migration of project journals from earlier schemas to the current schema."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable
from pathlib import Path

from vomstudio.project.journal.file_watch import copy_database
from vomstudio.project.journal.replay import replay
from vomstudio.project.journal.rows import read_rows

SCHEMA_VERSION = 1
"""Schema version of the journals that this program writes."""

STEPS: dict[int, Callable[[sqlite3.Connection], None]] = {}
"""``STEPS[n]`` migrates a journal from schema n to n + 1 within the caller's transaction.

A step must not call ``executescript``, which commits. If records have only gained a kind or a
field, the step does nothing: the new version prevents earlier programs from opening the journal.
"""


def migrate(db: sqlite3.Connection, path: Path, schema: int) -> None:
    """Migrate a journal to the current schema, with all steps in one transaction.

    All rows are read first, and the journal is copied to ``journal-schema<n>.sqlite`` next to it,
    unless such a copy already exists from an earlier attempt.

    Parameters
    ----------
    db : sqlite3.Connection
        Open journal in autocommit mode.
    path : Path
        Path of the journal.
    schema : int
        Schema version of the journal, lower than ``SCHEMA_VERSION``.

    Raises
    ------
    InputError
        If a row cannot be read from the file. In this case the journal is unchanged.
    TargetError
        If the copy cannot be written. In this case the journal is unchanged.
    """
    # Damaged rows are reported each time the journal is opened and are left as they are.
    replay(read_rows(db, path))
    backup = path.with_name(f"{path.stem}-schema{schema}{path.suffix}")
    if not backup.exists():
        copy_database(db, backup)
    db.execute("BEGIN IMMEDIATE")
    try:
        for version in range(schema, SCHEMA_VERSION):
            STEPS[version](db)
            db.execute(f"PRAGMA user_version = {version + 1}")
        db.execute("COMMIT")
    except BaseException:
        if db.in_transaction:
            db.execute("ROLLBACK")
        raise
