"""SQLite files from unknown sources: accepted schemas and restricted connections.

A schema can contain code: views, triggers, virtual tables and computed columns. This code runs
when a row is read or written, may not terminate, and can change the result. Therefore only
`sqlite_master` is read until the schema has been accepted.
"""

from __future__ import annotations

import itertools
import re
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

from vomstudio.core.errors import InputError
from vomstudio.core.failures import stop_requests
from vomstudio.core.files.regular import require_regular_file
from vomstudio.core.findings import Finding

SQLITE_SIGNATURE = b"SQLite format 3\0"
MAX_ENTRIES = 20_000
"""Maximum number of tables, indexes and triggers of a schema; a GDAL layer has about 15."""

_LIMITS = {
    sqlite3.SQLITE_LIMIT_SQL_LENGTH: 1_000_000,
    sqlite3.SQLITE_LIMIT_COMPOUND_SELECT: 10,
    sqlite3.SQLITE_LIMIT_VDBE_OP: 250_000,
    sqlite3.SQLITE_LIMIT_FUNCTION_ARG: 32,
    sqlite3.SQLITE_LIMIT_ATTACHED: 1,
    sqlite3.SQLITE_LIMIT_LIKE_PATTERN_LENGTH: 1000,
    sqlite3.SQLITE_LIMIT_TRIGGER_DEPTH: 10,
}
"""Settings recommended in SQLite, "Defense Against The Dark Arts" (sqlite.org/security.html), 1.1.
"""
_OPCODES_PER_CHECK = 100_000

_TOKEN = re.compile(
    r"/\*.*?(?:\*/|\Z)|--[^\n]*"
    r"|'(?:[^']|'')*'|\"(?:[^\"]|\"\")*\"|`[^`]*`|\[[^\]]*\]"
    r"|[^\W]+|\S",
    re.DOTALL,
)
_KINDS = (
    ("create", "table"),
    ("create", "index"),
    ("create", "unique", "index"),
    ("create", "view"),
    ("create", "trigger"),
    ("create", "virtual", "table"),
)

# Statements that GDAL writes into a GeoPackage (GPKG driver, versions 1.11 to 3.12).
_TRIGGER_NAMES = re.compile(
    r"rtree_.+_(?:insert|update[1-7]?|delete)"
    r"|trigger_(?:insert|delete)_feature_count_.+"
    r"|gpkg_(?:tile_matrix|metadata|metadata_reference|geometry_columns|data_columns)_\w+_"
    r"(?:insert|update)"
    r"|.+_(?:zoom|tile_column|tile_row)_(?:insert|update)",
    re.DOTALL,
)
_RTREE_COLUMN_COUNT = 5
_STANDARD_VIEWS = {
    "st_spatial_ref_sys",
    "spatial_ref_sys",
    "st_geometry_columns",
    "geometry_columns",
}
"""Informative views of the GeoPackage standard (OGC 12-128, SQL table definitions)."""
_VIEW_WORDS = {
    "select",
    "as",
    "case",
    "when",
    "then",
    "else",
    "end",
    "'st_'",
    "st_",
    "code4name",
    "srs_name",
    "srs_id",
    "organization",
    "organization_coordsys_id",
    "definition",
    "description",
    "srid",
    "auth_name",
    "auth_srid",
    "srtext",
    "table_name",
    "column_name",
    "geometry_type_name",
    "f_table_name",
    "f_geometry_column",
    "geometry_type",
    "coord_dimension",
    "z",
    "m",
    "g",
    "s",
    "0",
    "1",
    "2",
    ",",
    ".",
    "|",
    "+",
    "(",
    ")",
}
_VIEW_SOURCES = {
    "gpkg_spatial_ref_sys",
    "gpkg_geometry_columns",
    "gpkg_geometry_columns as g join gpkg_spatial_ref_sys as s where g . srs_id = s . srs_id",
    "gpkg_geometry_columns as g join gpkg_spatial_ref_sys as s on g . srs_id = s . srs_id",
}


@dataclass(frozen=True)
class SchemaEntry:
    """Entry of `sqlite_master`.

    Parameters
    ----------
    kind : str
        Kind parsed from the statement: ``table``, ``index``, ``view``, ``trigger``, ``virtual
        table``, or ``entry`` for anything else. The column ``type`` is not reliable.
    name : str
        Name of the object, taken from its statement.
    tokens : tuple of str
        Tokens of its CREATE statement, starting with the name, without comments and in lower case.
    """

    kind: str
    name: str
    tokens: tuple[str, ...]

    @property
    def has_computed_column(self) -> bool:
        """Whether a column of the table is computed when it is read or written."""
        return "generated" in self.tokens or ("as", "(") in itertools.pairwise(self.tokens)


def open_read_only(path: Path, timeout_s: float = 5.0) -> sqlite3.Connection:
    """Open a database for reading, restricted by `restrict_connection`.

    Parameters
    ----------
    path : Path
    timeout_s : float
        Time to wait for a program that is writing to the database, in seconds.

    Raises
    ------
    InputError
        If the path is not a regular file, because SQLite blocks on a read-only pipe.
    sqlite3.Error
        If the database cannot be opened.
    """
    require_regular_file(path)
    db = sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True, timeout=timeout_s)
    try:
        restrict_connection(db)
    except BaseException:
        db.close()
        raise
    return db


def restrict_connection(db: sqlite3.Connection) -> None:
    """Restrict code in the schema of a database.

    Functions with side effects are disabled, statements are limited, and a request to end the
    process interrupts a running statement.
    """
    for limit, value in _LIMITS.items():
        db.setlimit(limit, value)
    db.set_progress_handler(_is_interrupted, _OPCODES_PER_CHECK)
    db.execute("PRAGMA trusted_schema = OFF").close()
    db.execute("PRAGMA cell_size_check = ON").close()


def _is_interrupted() -> bool:
    # Signal handlers run only while Python code runs.
    return stop_requests.is_requested()


def read_schema(db: sqlite3.Connection) -> Iterator[SchemaEntry]:
    """Yield the entries of a schema, except those that SQLite itself creates for keys.

    Raises
    ------
    sqlite3.Error
        If the schema is damaged or has more than `MAX_ENTRIES` entries.
    """
    rows = db.execute("SELECT name, sql FROM sqlite_master LIMIT ?", (MAX_ENTRIES + 1,))
    for row, (name, sql) in enumerate(rows):
        if row == MAX_ENTRIES:
            raise sqlite3.DatabaseError("the schema has too many entries")
        if sql is not None:
            yield _schema_entry(str(name), str(sql))


def _schema_entry(name: str, sql: str) -> SchemaEntry:
    statements = [
        token
        for token in _TOKEN.findall(sql)
        if not token.startswith(("/*", "--")) and token != ";"
    ]
    tokens = tuple(token.lower() for token in statements)
    for words in _KINDS:
        if tokens[: len(words)] == words and len(tokens) > len(words):
            definition = tokens[len(words) :]
            if definition[:3] == ("if", "not", "exists"):
                definition = definition[3:]
            kind = " ".join(word for word in words[1:] if word != "unique")
            return SchemaEntry(kind, _unquote(statements[-len(definition)]), definition)
    return SchemaEntry("entry", name, tokens)


def _unquote(token: str) -> str:
    return token[1:-1] if token[:1] in "\"'`[" and len(token) > 1 else token


def require_geopackage(path: Path) -> None:
    """Check that a GeoPackage contains no code except that written by GDAL.

    Tables, indexes, R-trees and triggers written by GDAL (triggers do not run while a file is
    read) and the informative views of the standard are accepted.

    Parameters
    ----------
    path : Path

    Raises
    ------
    InputError
        With the code ``file.unsafe-schema`` for a view, trigger, virtual table or computed column
        that GDAL does not write.
    ValueError
        If the file is damaged or not a database.
    """
    try:
        with closing(open_read_only(path)) as db:
            for entry in read_schema(db):
                if not _is_written_by_gdal(entry):
                    refuse(entry.kind, entry.name, path)
                if entry.kind == "table" and entry.has_computed_column:
                    refuse("table with a computed column", entry.name, path)
    except sqlite3.Error as error:
        raise ValueError(str(error)) from error


def refuse(kind: str, name: str, path: Path) -> NoReturn:
    """Raise InputError with the code ``file.unsafe-schema``."""
    finding = Finding("file.unsafe-schema", kind=kind, name=name[:100])
    raise InputError(finding, file=path)


def _is_written_by_gdal(entry: SchemaEntry) -> bool:
    if entry.kind == "trigger":
        return _TRIGGER_NAMES.fullmatch(entry.name.lower()) is not None
    if entry.kind == "virtual table":
        return entry.name.lower().startswith("rtree_") and _is_rtree(entry.tokens)
    if entry.kind == "view":
        return entry.name.lower() in _STANDARD_VIEWS and _is_standard_view(entry.tokens)
    return entry.kind in ("table", "index")


def _is_rtree(tokens: tuple[str, ...]) -> bool:
    """Return whether a virtual table has the arguments of a two-dimensional R-tree."""
    columns = tokens[4:-1:2]
    commas = tokens[5:-1:2]
    return (
        tokens[1:4] == ("using", "rtree", "(")
        and tokens[-1] == ")"
        and len(columns) == _RTREE_COLUMN_COUNT
        and all(_unquote(column).replace("_", "").isalnum() for column in columns)
        and set(commas) == {","}
    )


def _is_standard_view(tokens: tuple[str, ...]) -> bool:
    """Return whether a view only selects columns of standard tables, in a single statement."""
    unquoted_tokens = [token if token.startswith("'") else _unquote(token) for token in tokens]
    if (
        unquoted_tokens[1:3] != ["as", "select"]
        or unquoted_tokens.count("from") != 1
        or unquoted_tokens.count("select") != 1
    ):
        return False
    index = unquoted_tokens.index("from")
    return (
        set(unquoted_tokens[2:index]) <= _VIEW_WORDS
        and " ".join(unquoted_tokens[index + 1 :]) in _VIEW_SOURCES
    )
