"""Rows of a journal as they are stored in its file."""

from __future__ import annotations

import hashlib
import sqlite3
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.project.journal.json_values import load_json
from vomstudio.project.journal.replay import JournalRow


class Head(NamedTuple):
    """Number of rows, and number and checksum of the last row."""

    rows: int
    seq: int
    checksum: str


class NewRow(NamedTuple):
    """Values of a row, and the head of the journal after it."""

    values: tuple[Any, ...]
    head: Head

    def to_row(self) -> JournalRow:
        return _to_row(self.values)


def _to_row(values: Sequence[Any]) -> JournalRow:
    seq, kind, of_seq, label, before, after, time, version, settings = values
    values_before, values_after = load_json(before), load_json(after)
    stored_settings = load_json(settings)
    return JournalRow(
        seq, kind, of_seq, label, values_before, values_after, time, version, stored_settings
    )


def read_head(db: sqlite3.Connection) -> Head:
    """Return the head computed from the existing rows, regardless of the stored head.

    New rows follow the last row. If only the checksum in the stored head is damaged, the next row
    must not be affected.
    """
    (rows,) = db.execute("SELECT count(*) FROM journal").fetchone()
    last_row = db.execute("SELECT seq, checksum FROM journal ORDER BY seq DESC LIMIT 1").fetchone()
    seq, checksum = last_row or (0, "")
    row = db.execute("SELECT seq FROM head").fetchone()
    # Row numbers are never reused.
    return Head(rows, max(seq, row[0] if row else 0), checksum)


def checksum(previous_text: str, values: Sequence[object]) -> str:
    """Return the SHA-256 of a row's values (without its checksum) and the previous checksum.

    Therefore rows cannot be changed, removed or inserted without being detected.
    """
    digest = hashlib.sha256(previous_text.encode())
    for value in values:
        text = b"" if value is None else str(value).encode("utf-8", "surrogatepass")
        # The lengths prevent characters from moving between adjacent values.
        digest.update(b"-" if value is None else b"%d:" % len(text))
        digest.update(text)
    return digest.hexdigest()


COLUMNS = "seq, kind, of_seq, label, before, after, time, version, settings"
INSERT_ROW = f"INSERT INTO journal ({COLUMNS}, checksum) VALUES ({', '.join('?' * 10)})"
SET_HEAD = "INSERT OR REPLACE INTO head VALUES (1, ?, ?, ?)"


def read_rows(db: sqlite3.Connection, path: Path) -> Iterator[JournalRow]:
    """Yield the rows in order, with findings for damaged and missing rows.

    Raises InputError if the file itself is damaged.
    """
    try:
        query = f"SELECT {COLUMNS}, checksum FROM journal ORDER BY seq"
        seq, total = 0, ""
        settings_cache: tuple[Any, Any] = (None, None)
        for *values, stored_checksum in db.execute(query):
            number, kind, of_seq, label, before, after, time, version, settings = values
            notice: Finding | None = None
            problem: Finding | None = None
            if number != seq + 1:
                notice = _missing_rows_finding(seq + 1, number - 1)
            elif stored_checksum != checksum(total, values):
                problem = Finding("row.checksum")
            elif not all(type(word) is str for word in (kind, label, time, version)):
                problem = Finding("row.not-text")
                kind, label, time, version = map(str, (kind, label, time, version))
            seq, total = number, str(stored_checksum)
            # Settings rarely change from one row to the next.
            if settings != settings_cache[0]:
                settings_cache = (settings, load_json(settings))
            yield JournalRow(
                number,
                kind,
                of_seq,
                label,
                load_json(before),
                load_json(after),
                time,
                version,
                settings_cache[1],
                problem,
                notice,
            )
        head = db.execute("SELECT seq FROM head").fetchone()
        if head is not None and head[0] > seq:
            missing_rows = _missing_rows_finding(seq + 1, head[0])
            yield JournalRow(
                head[0], "gap", None, "", None, None, "", "", None, notice=missing_rows
            )
    except sqlite3.Error as error:
        raise InputError(Finding("journal.damaged", reason=error), file=path) from error


def last_rows(db: sqlite3.Connection, path: Path, count: int) -> list[JournalRow]:
    """Return the last rows in order, without verifying their checksums. Raises InputError."""
    query = f"SELECT {COLUMNS} FROM journal ORDER BY seq DESC LIMIT ?"
    try:
        rows = db.execute(query, (count,)).fetchall()
    except sqlite3.Error as error:
        raise InputError(Finding("journal.damaged", reason=error), file=path) from error
    return [_to_row(values) for values in reversed(rows)]


def _missing_rows_finding(first_seq: int, last_seq: int) -> Finding:
    return Finding(
        "journal.rows-missing", count=last_seq - first_seq + 1, first=first_seq, last=last_seq
    )


def decode_journal_text(raw_bytes: bytes) -> str:
    """Decode text; damaged bytes invalidate the checksum of their row, not the whole file."""
    return raw_bytes.decode("utf-8", "replace")
