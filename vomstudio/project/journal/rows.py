"""The rows of a journal as they stand in its file."""

from __future__ import annotations

import hashlib
import sqlite3
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.project.journal.json_values import load_json
from vomstudio.project.journal.replay import Row


class Head(NamedTuple):
    """How many rows there are, the number of the last one, and its checksum."""

    rows: int
    seq: int
    checksum: str


class NewRow(NamedTuple):
    """The values of a row, and the head of the journal that ends with it."""

    values: tuple[Any, ...]
    head: Head

    def as_read(self) -> Row:
        return _as_read(self.values)


def _as_read(values: Sequence[Any]) -> Row:
    seq, kind, of_seq, label, before, after, time, version, settings = values
    read_before, read_after = load_json(before), load_json(after)
    told = load_json(settings)
    return Row(seq, kind, of_seq, label, read_before, read_after, time, version, told)


def read_head(db: sqlite3.Connection) -> Head:
    """Of the rows that are there, whatever the head says: new rows follow the last one. A sum that
    was damaged in the head alone must not go into the next row, which would then be blamed."""
    (rows,) = db.execute("SELECT count(*) FROM journal").fetchone()
    last = db.execute("SELECT seq, checksum FROM journal ORDER BY seq DESC LIMIT 1").fetchone()
    seq, total = last or (0, "")
    told = db.execute("SELECT seq FROM head").fetchone()
    # A number that was taken once is not taken again.
    return Head(rows, max(seq, told[0] if told else 0), total)


def checksum(previous: str, values: Sequence[object]) -> str:
    """SHA-256 of a row's values (all but its checksum) and of the checksum of the row before it, so
    that no row can be changed, taken out or put in unseen."""
    made = hashlib.sha256(previous.encode())
    for value in values:
        text = b"" if value is None else str(value).encode("utf-8", "surrogatepass")
        # Lengths, so that two neighbours cannot trade characters.
        made.update(b"-" if value is None else b"%d:" % len(text))
        made.update(text)
    return made.hexdigest()


COLUMNS = "seq, kind, of_seq, label, before, after, time, version, settings"
INSERT_ROW = f"INSERT INTO journal ({COLUMNS}, checksum) VALUES ({', '.join('?' * 10)})"
SET_HEAD = "INSERT OR REPLACE INTO head VALUES (1, ?, ?, ?)"


def read_rows(db: sqlite3.Connection, path: Path) -> Iterator[Row]:
    """The rows in order; damaged and missing ones say so. Raises InputError where the file itself
    is damaged."""
    try:
        query = f"SELECT {COLUMNS}, checksum FROM journal ORDER BY seq"
        seq, total = 0, ""
        told_settings: tuple[Any, Any] = (None, None)
        for *values, stored in db.execute(query):
            number, kind, of_seq, label, before, after, time, version, settings = values
            notice: Finding | None = None
            problem: Finding | None = None
            if number != seq + 1:
                notice = _missing(seq + 1, number - 1)
            elif stored != checksum(total, values):
                problem = Finding("row.checksum")
            elif not all(type(word) is str for word in (kind, label, time, version)):
                problem = Finding("row.not-text")
                kind, label, time, version = map(str, (kind, label, time, version))
            seq, total = number, str(stored)
            # They hardly ever change from row to row.
            if settings != told_settings[0]:
                told_settings = (settings, load_json(settings))
            yield Row(
                number,
                kind,
                of_seq,
                label,
                load_json(before),
                load_json(after),
                time,
                version,
                told_settings[1],
                problem,
                notice,
            )
        told = db.execute("SELECT seq FROM head").fetchone()
        if told is not None and told[0] > seq:
            lost = _missing(seq + 1, told[0])
            yield Row(told[0], "gap", None, "", None, None, "", "", None, notice=lost)
    except sqlite3.Error as error:
        raise InputError(Finding("journal.damaged", reason=error), file=path) from error


def last_rows(db: sqlite3.Connection, path: Path, count: int) -> list[Row]:
    """The newest rows, in order; their checksums are not looked at. Raises InputError."""
    query = f"SELECT {COLUMNS} FROM journal ORDER BY seq DESC LIMIT ?"
    try:
        found = db.execute(query, (count,)).fetchall()
    except sqlite3.Error as error:
        raise InputError(Finding("journal.damaged", reason=error), file=path) from error
    return [_as_read(values) for values in reversed(found)]


def _missing(first: int, last: int) -> Finding:
    return Finding("journal.rows-missing", count=last - first + 1, first=first, last=last)


def text_of(raw: bytes) -> str:
    """Damaged bytes become a row that its checksum tells apart, not an error of the whole file."""
    return raw.decode("utf-8", "replace")
