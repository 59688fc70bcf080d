"""GeoPackages with bent schemas, and valid ones: what may run is refused, all else is read.

    python -m tests.fuzz.bent_schemas --files 1000 [--seed N] [--signals 30]

Each file is read as the commands read drawings. Printed is what breaks a promise: a program in a
schema that is not refused with ``file.unsafe-schema``, a valid file that is not read, a refusal
that does not name the file, more than `MAX_S` seconds, more than `MAX_BYTES` of memory in the
process that reads. With `--signals` so many more files are given to the command, which is ended by
SIGINT, SIGTERM or SIGHUP in turn and must end within `campaigns.MAX_END_S`. The exit code is 1 if
any promise is broken.
"""

from __future__ import annotations

import random
import resource
import sqlite3
import struct
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Literal

import numpy as np

from tests.fuzz import campaigns
from tests.fuzz.campaigns import Outcome, Report
from tests.fuzz.stopping import until_stopped

MAX_S = 20.0
MAX_BYTES = 1_500_000_000
"""1 GB and 128 times the file (`vomstudio.core.files.memory_limit`), and the libraries."""
UNSAFE, TOO_MUCH = "file.unsafe-schema", "file.memory-exceeded"

Expected = Literal["refused", "closed", "read", "any"]
"""refused : by its schema; closed : not read, for whatever reason; any : it must only end"""
Bend = Callable[[sqlite3.Connection, random.Random], None]
ENDLESS = "WITH RECURSIVE n(k) AS (SELECT 1 UNION ALL SELECT k + 1 FROM n)"
_SYSTEM_TABLES = (
    "gpkg_contents",
    "gpkg_geometry_columns",
    "gpkg_spatial_ref_sys",
    "gpkg_extensions",
    "gpkg_ogr_contents",
)


# --- bending --------------------------------------------------------------------------------------
def _columns(db: sqlite3.Connection, table: str) -> list[str]:
    return [str(row[1]) for row in db.execute(f"PRAGMA table_info({table})")]


def _register(db: sqlite3.Connection, name: str) -> None:
    """Have a name stand where that of the real layer stands."""
    for table in ("gpkg_contents", "gpkg_geometry_columns"):
        columns = _columns(db, table)
        given = ", ".join(
            f"'{name}'" if column in ("table_name", "identifier") else column for column in columns
        )
        db.execute(f"INSERT INTO {table} SELECT {given} FROM {table} LIMIT 1")


def _endless_layer(db: sqlite3.Connection, chance: random.Random) -> None:
    name = chance.choice(["endless", "a layer", "Ünïcode", "rtree_real_geom_x"])
    _register(db, name)
    db.execute(f'CREATE VIEW "{name}" AS {ENDLESS} SELECT n.k fid, real.geom FROM n, real')


def _endless_system_table(db: sqlite3.Connection, chance: random.Random) -> None:
    table = chance.choice(_SYSTEM_TABLES)
    columns = ", ".join(f"t.{column}" for column in _columns(db, table))
    db.execute("PRAGMA legacy_alter_table = ON")
    db.execute(f"ALTER TABLE {table} RENAME TO other")
    db.execute(f"CREATE VIEW {table} AS {ENDLESS} SELECT {columns} FROM other t, n")


def _harmless_looking_view(db: sqlite3.Connection, chance: random.Random) -> None:
    name = chance.choice(["spatial_ref_sys", "geometry_columns", "st_geometry_columns", "v"])
    select = chance.choice(
        [
            "SELECT srs_id, zeroblob(900000000) AS srid FROM gpkg_spatial_ref_sys",
            "SELECT a.srs_id FROM gpkg_spatial_ref_sys a, gpkg_spatial_ref_sys b, gpkg_contents c",
            f"{ENDLESS} SELECT k FROM n",
            "SELECT srs_id FROM gpkg_spatial_ref_sys UNION ALL SELECT srs_id FROM"
            " gpkg_spatial_ref_sys",
            "SELECT randomblob(100000000) AS definition",
        ]
    )
    db.execute(f"CREATE VIEW {name} AS {select}")


def _trigger(db: sqlite3.Connection, chance: random.Random) -> None:
    when = chance.choice(["INSERT", "UPDATE", "DELETE"])
    db.execute(
        f"CREATE TRIGGER t{chance.randrange(99)} AFTER {when} ON real BEGIN"
        f" INSERT INTO gpkg_ogr_contents SELECT 'a', count(*) FROM ({ENDLESS} SELECT k FROM n); END"
    )


def _virtual_table(db: sqlite3.Connection, chance: random.Random) -> None:
    name = chance.choice(["search", "rtree_real_geom2", "gpkg_search"])
    module = chance.choice(
        [
            "fts5(a)",
            "fts4(a)",
            "rtree(id, x0, x1)",
            "rtree_i32(id, minx, maxx, miny, maxy)",
            "rtree(id, minx, maxx, miny, maxy, minz, maxz)",
        ]
    )
    db.execute(f"CREATE VIRTUAL TABLE {name} USING {module}")


def _computed_column(db: sqlite3.Connection, chance: random.Random) -> None:
    table = chance.choice(["real", "gpkg_contents", "gpkg_geometry_columns"])
    words = chance.choice(["GENERATED ALWAYS AS", "AS", "generated/**/always as"])
    db.execute(f"ALTER TABLE {table} ADD COLUMN c TEXT {words} (hex(zeroblob(400000000))) VIRTUAL")


def _hidden_in_the_schema(db: sqlite3.Connection, chance: random.Random) -> None:
    """A view whose entry states that it is a table, or whose statement is dressed up."""
    name = chance.choice(["gpkg_data_columns", "hidden"])
    create = chance.choice(
        ["CREATE VIEW", "create/**/view", "CREATE\n--x\nVIEW", "CREATE TEMP VIEW"]
    )
    db.execute("PRAGMA writable_schema = ON")
    db.execute(
        "INSERT INTO sqlite_master VALUES (?, ?, ?, 0, ?)",
        (
            chance.choice(["table", "view", "index"]),
            name,
            name,
            f"{create} {name} AS {ENDLESS} SELECT k FROM n",
        ),
    )


def _foreign_module(db: sqlite3.Connection, chance: random.Random) -> None:
    module = chance.choice(
        [
            "VirtualOGR('/etc/passwd')",
            "VirtualShape('/etc/passwd', CP1252, -1)",
            "VirtualGPKG('real', 'geom')",
            "json_each",
            "dbstat",
            "sqlite_dbpage",
        ]
    )
    db.execute("PRAGMA writable_schema = ON")
    db.execute(
        "INSERT INTO sqlite_master VALUES ('table', 'm', 'm', 0, ?)",
        (f"CREATE VIRTUAL TABLE m USING {module}",),
    )


# What is damaged, not prepared: it must end, however.
def _rtree_nodes(db: sqlite3.Connection, chance: random.Random) -> None:
    """An R-tree in which every node is its own child."""
    depth = chance.choice([1, 5, 40])
    cells = b"".join(struct.pack(">qffff", 1, -1e9, 1e9, -1e9, 1e9) for _ in range(24))
    node = struct.pack(">HH", depth, 24) + cells
    db.execute("UPDATE rtree_real_geom_node SET data = ? || zeroblob(?)", (node, 1228 - len(node)))


def _numbers(db: sqlite3.Connection, chance: random.Random) -> None:
    for table, column in (
        ("gpkg_ogr_contents", "feature_count"),
        ("gpkg_contents", "srs_id"),
        ("gpkg_contents", "min_x"),
        ("gpkg_geometry_columns", "srs_id"),
        ("gpkg_geometry_columns", "z"),
        ("real", "fid"),
    ):
        if chance.random() < 0.5:
            value = chance.choice([2**62, -1, 1e300, "x" * 10_000, None, b"\0" * 9])
            try:
                db.execute(f"UPDATE {table} SET {column} = ?", (value,))
            except sqlite3.Error:
                continue


def _geometries(db: sqlite3.Connection, chance: random.Random) -> None:
    head = b"GP\0\1" + struct.pack("<i", 32633)
    kind = chance.choice([2, 3, 5, 6, 7, 1002])
    count = chance.choice([2**31 - 1, 2**32 - 1, 10**6])
    nested = b"".join(struct.pack("<BII", 1, 7, 1) for _ in range(chance.choice([1, 50_000])))
    db.execute("DROP TRIGGER IF EXISTS rtree_real_geom_update1")
    for (name,) in db.execute("SELECT name FROM sqlite_master WHERE type = 'trigger'").fetchall():
        db.execute(f'DROP TRIGGER "{name}"')
    db.execute("UPDATE real SET geom = ?", (head + nested + struct.pack("<BII", 1, kind, count),))


def _reference_system(db: sqlite3.Connection, chance: random.Random) -> None:
    text = chance.choice(['PROJCS["' * 20_000, "[" * 100_000, "x" * 5_000_000, ""])
    db.execute("UPDATE gpkg_spatial_ref_sys SET definition = ?", (text,))


def _many_tables(db: sqlite3.Connection, chance: random.Random) -> None:
    for number in range(chance.choice([500, 3000])):
        db.execute(f"CREATE TABLE t{number} (a, b)")
        if chance.random() < 0.2:
            db.execute(
                "INSERT INTO gpkg_contents (table_name, data_type, identifier)"
                f" VALUES ('t{number}', 'attributes', 't{number}')"
            )


# What honest programs write.
def _plain_extras(db: sqlite3.Connection, chance: random.Random) -> None:
    db.execute(
        "CREATE TABLE layer_styles (id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, styleQML TEXT,"
        " update_time DATETIME DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ','now')))"
    )
    db.execute("CREATE TABLE qgis_projects (name TEXT PRIMARY KEY, metadata BLOB, content BLOB)")
    db.execute("CREATE UNIQUE INDEX by_name ON qgis_projects (name, metadata)")
    db.execute("CREATE TABLE notes (a TEXT CHECK (length(a) < 9), b REAL DEFAULT (1 + 2)) STRICT")
    db.execute("ANALYZE")


def _standard_views(db: sqlite3.Connection, chance: random.Random) -> None:
    db.execute(
        "CREATE VIEW st_spatial_ref_sys AS SELECT srs_name, srs_id, organization,"
        " organization_coordsys_id, definition, description FROM gpkg_spatial_ref_sys"
    )
    db.execute(
        'CREATE VIEW "spatial_ref_sys" AS SELECT srs_id AS srid, organization AS auth_name,'
        " organization_coordsys_id AS auth_srid, definition AS srtext FROM gpkg_spatial_ref_sys;"
    )
    db.execute(
        "CREATE VIEW st_geometry_columns AS SELECT table_name, column_name, 'ST_' ||"
        " geometry_type_name AS geometry_type_name, g.srs_id, srs_name FROM gpkg_geometry_columns"
        " as g JOIN gpkg_spatial_ref_sys AS s WHERE g.srs_id = s.srs_id"
    )
    db.execute(
        "CREATE VIEW geometry_columns AS SELECT table_name AS f_table_name, column_name AS"
        " f_geometry_column, (CASE z WHEN 1 THEN 1 ELSE 0 END) + (CASE m WHEN 1 THEN 1 ELSE 0 END)"
        " AS coord_dimension, srs_id AS srid FROM gpkg_geometry_columns"
    )


def _nothing(db: sqlite3.Connection, chance: random.Random) -> None:
    pass


BENDS: list[tuple[Bend, Expected]] = [
    (_endless_layer, "refused"),
    (_endless_system_table, "refused"),
    (_harmless_looking_view, "refused"),
    (_trigger, "refused"),
    (_virtual_table, "refused"),
    (_computed_column, "refused"),
    (_hidden_in_the_schema, "closed"),
    (_foreign_module, "closed"),
    (_rtree_nodes, "any"),
    (_numbers, "any"),
    (_geometries, "any"),
    (_reference_system, "any"),
    (_many_tables, "any"),
    (_plain_extras, "read"),
    (_standard_views, "read"),
    (_nothing, "read"),
]


@cache
def _honest(folder: Path) -> bytes:
    """A GeoPackage as GDAL writes it: lines, an R-tree with its triggers, attributes."""
    import pyogrio
    import shapely

    at = np.arange(40.0)
    ends = np.stack([np.stack([at, at * 0], 1), np.stack([at + 1, at + 5.25], 1)], 1)
    path = folder / "honest.gpkg"
    pyogrio.raw.write(
        path,
        shapely.to_wkb(shapely.linestrings(ends + 500_000.0)),
        [at],
        ["value"],
        layer="real",
        geometry_type="LineString",
        driver="GPKG",
        crs="EPSG:32633",
    )
    return path.read_bytes()


def make(folder: Path, number: int, seed: int) -> tuple[Path, str, Expected]:
    """Write a bent GeoPackage; returns it, how it was bent, and what must become of it."""
    chance = random.Random(f"{seed} {number}")
    bend, expected = BENDS[number % len(BENDS)]
    path = folder / f"layers_{number}.gpkg"
    path.write_bytes(_honest(folder))
    with closing(sqlite3.connect(path, isolation_level=None)) as db:
        db.execute("PRAGMA synchronous = OFF")
        db.execute("PRAGMA journal_mode = MEMORY")
        bend(db, chance)
    if expected == "any" and chance.random() < 0.3:
        data = bytearray(path.read_bytes())
        for _ in range(chance.choice([1, 20, 400])):
            data[chance.randrange(100, len(data))] ^= 1 << chance.randrange(8)
        path.write_bytes(data)
    return path, bend.__name__.strip("_"), expected


# --- reading --------------------------------------------------------------------------------------
@dataclass(frozen=True)
class Reading:
    """code : of the refusal, "read" if there was none"""

    code: str
    message: str
    seconds: float


def read(path: Path) -> Reading:
    """Read a file as the commands read drawings."""
    from vomstudio.core.errors import VomError
    from vomstudio.io.gis.line_reading import read_gis_lines

    begun, code, message = time.monotonic(), "read", ""
    try:
        read_gis_lines(path)
    except VomError as error:
        code, message = error.code, str(error)
    return Reading(code, message, time.monotonic() - begun)


def broken_promise(path: Path, expected: Expected, outcome: Reading) -> str:
    """What is wrong with an outcome; "" if nothing."""
    if outcome.seconds > MAX_S:
        return f"took {outcome.seconds:.0f} s"
    if outcome.code != "read" and path.name not in outcome.message:
        return f"refused without its name: {outcome.message}"
    if expected == "refused" and outcome.code != UNSAFE:
        return f"not refused by its schema: {outcome.code} {outcome.message}"
    if expected == "closed" and outcome.code == "read":
        return "read"
    if expected == "read" and outcome.code != "read":
        return f"not read: {outcome.message}"
    return ""


def campaign(count: int, seed: int, report: Report = str) -> Outcome:
    """Read so many files, and return the codes of the answers and the broken promises."""
    counts: Counter[str] = Counter()
    wrong: list[str] = []
    slowest = 0.0
    # Of all children so far, such as those of other tests.
    before = _peak_of_children()
    with tempfile.TemporaryDirectory() as made:
        for number in until_stopped(range(count)):
            path, how, expected = make(Path(made), number, seed)
            outcome = read(path)
            slowest = max(slowest, outcome.seconds)
            counts[outcome.code] += 1
            if said := broken_promise(path, expected, outcome):
                wrong.append(f"{number} ({how}): {said}")
                report(wrong[-1])
            path.unlink()
    peak = _peak_of_children()
    if peak > max(MAX_BYTES, before):
        wrong.append(f"a process that reads took {peak / 1e6:.0f} MB")
    report(f"slowest {slowest:.1f} s, most memory of a process that reads {peak / 1e6:.0f} MB")
    return counts, wrong


def _peak_of_children() -> int:
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024


# --- signals --------------------------------------------------------------------------------------
def signals(count: int, seed: int, report: Report = str) -> list[str]:
    """End the command while it reads, and return the broken promises."""
    with tempfile.TemporaryDirectory() as made:

        def prepare(number: int) -> tuple[list[str], str]:
            path, how, _ = make(Path(made), number, seed)
            return ["fractures", str(path), "--json"], how

        return campaigns.end_by_signals(count, seed, 1.5, prepare, report)


if __name__ == "__main__":
    sys.exit(campaigns.run(campaigns.parser(__doc__).parse_args(), campaign, signals))
