"""Projects with damage: single bits of the journal's file, and rows that are sound as rows but say
something that no program of ours writes.

    python -m tests.fuzz.projects --bits 500 --rows 500 [--seed N]

counts what opening made of each: sound and as it was, named, refused; and prints each that changed
a record without a word or ended in an error that is none of ours. The exit code is 1 if there was
one.
"""

from __future__ import annotations

import argparse
import copy
import json
import random
import shutil
import sqlite3
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tests.fuzz.stopping import until_stopped
from tests.samples import GRID, HASH, ONE_OF_EACH
from tests.specimens.figures import copy_of
from vomstudio.core.errors import VomError
from vomstudio.geometry.frames import Frame
from vomstudio.project import edits, grid_edits
from vomstudio.project.exports.export import export_project
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.journal.database import read_replay
from vomstudio.project.journal.replay import Replay
from vomstudio.project.journal.rows import COLUMNS, checksum
from vomstudio.project.paths import JOURNAL_NAME
from vomstudio.project.records import Model
from vomstudio.project.verify import verify

LONGEST_S = 20.0
ODD: list[Any] = [
    None,
    True,
    -1,
    0,
    7,
    1e308,
    -1e-320,
    10**400,
    2**63,
    "",
    "x",
    "7",
    "1e999",
    "../../x",
    "\ud800",
    "\0",
    "a" * 100_000,
    [],
    [[]],
    [1, 2],
    [None] * 3,
    ["x"] * 3,
    {},
    {"record": "trace"},
    {"record": 7},
    {"a": {"b": {}}},
    "NaN",
]


def specimen(folder: Path) -> Path:
    """A project with features of every kind and a grid, made at earlier schemas and at that of
    today."""
    made = copy_of("schema1", folder)
    project = ProjectFolder.open(made)
    session = project.session
    model = Model("m1", "cliff", "/nowhere/cliff.obj", "mesh", HASH, Frame("local"))
    session.apply(edits.add_model(session.records, model))
    session.apply(edits.add_features(session.records, list(ONE_OF_EACH.values())))
    session.apply(grid_edits.add_grid(session.records, GRID))
    session.apply(grid_edits.mark_cells(session.records, GRID.id, [0, 5], "d"))
    session.save()
    for id_ in ("s1", "k1", "a1", "w1"):
        session.apply(edits.set_attributes(session.records, [id_], notes=f"seen again: {id_}"))
    project.close()
    return made


def said_by(played: Replay) -> tuple[Any, ...]:
    return dict(played.records), dict(played.saved_records), dict(played.settings), played.draft


def flip_bit(folder: Path, chance: random.Random) -> str:
    path = folder / JOURNAL_NAME
    data = bytearray(path.read_bytes())
    at, bit = chance.randrange(len(data)), chance.randrange(8)
    data[at] ^= 1 << bit
    path.write_bytes(data)
    return f"byte {at}, bit {bit}"


def odd_row(folder: Path, chance: random.Random) -> str:
    """One value of one row is something else; every checksum is right."""
    db = sqlite3.connect(folder / JOURNAL_NAME)
    rows = [list(row) for row in db.execute(f"SELECT {COLUMNS} FROM journal ORDER BY seq")]
    row = chance.choice(rows)
    column = chance.choice([4, 5, 5, 5, 3, 1, 2, 8])
    what = f"row {row[0]}, column {column}"
    if column in (4, 5, 8) and row[column]:
        value = json.loads(row[column])
        if chance.random() < 0.1:
            row[column] = "[" * 100_000 if chance.random() < 0.5 else row[column][:-1]
        else:
            what += f": {_change(value, chance)}"
            row[column] = json.dumps(value)
    else:
        row[column] = chance.choice(["", "x", 10**15, -1, None, "undo", "do", 1])
        row[column] = row[column] if column in (2,) or row[column] is not None else "x"
    db.execute("DELETE FROM journal")
    total = ""
    for values in rows:
        total = checksum(total, values)
        marks = ", ".join("?" * 10)
        db.execute(f"INSERT INTO journal ({COLUMNS}, checksum) VALUES ({marks})", (*values, total))
    db.execute("UPDATE head SET checksum = ?", (total,))
    db.commit()
    db.close()
    return what


def _change(value: Any, chance: random.Random) -> str:
    """Replace, remove or add one thing somewhere inside; where."""
    where = ""
    while True:
        keys = list(value) if isinstance(value, dict) else list(range(len(value)))
        if not keys:
            if isinstance(value, dict):
                value["odd"] = copy.deepcopy(chance.choice(ODD))
            return f"{where} filled"
        key = chance.choice(keys)
        where += f"/{key}"
        inside = value[key]
        if isinstance(inside, dict | list) and inside and chance.random() < 0.8:
            value = inside
            continue
        if chance.random() < 0.2:
            del value[key]
            return f"{where} removed"
        odd = copy.deepcopy(chance.choice(ODD))
        value[key] = odd
        return f"{where} = {str(odd)[:30]!r}"


def outcome(folder: Path, before: tuple[Any, ...] | None) -> str:
    """One word in small letters, or what went wrong. before : what a sound project says, where it
    may say nothing else."""
    begun = time.process_time()
    try:
        played = read_replay(folder)
        if not played.problems and before is not None and said_by(played) != before:
            return "CHANGED SILENTLY"
        verify(folder)
        opened = ProjectFolder.open(folder)
        try:
            named = bool(opened.problems)
            if before is not None and not named and dict(opened.session.records) != before[0]:
                return "CHANGED SILENTLY"
        finally:
            opened.close()
        if before is None:
            for form in ("csv", "gpkg"):
                export_project(folder, form, folder.parent / f"out.{form}", force=True)
    except VomError as error:
        return "refused" if str(error) else "REFUSED WITHOUT A WORD"
    except Exception as error:  # noqa: BLE001 - that is what is looked for
        place = traceback.extract_tb(error.__traceback__)[-1]
        return f"ERROR {type(error).__name__}: {str(error)[:100]} ({place.filename}:{place.lineno})"
    if time.process_time() - begun > LONGEST_S:
        return "TOO SLOW"
    return "named" if named else "sound"


def campaign(
    damage: Callable[[Path, random.Random], str], count: int, seed: int, *, same: bool
) -> tuple[Counter[str], list[str]]:
    """same : whatever is not named must be as it was."""
    counts: Counter[str] = Counter()
    wrong: list[str] = []
    # Memory, where there is such a disk: each trial is flushed many times.
    fast = "/dev/shm" if Path("/dev/shm").is_dir() else None
    with tempfile.TemporaryDirectory(dir=fast) as place:
        (Path(place) / "sound").mkdir()
        sound = specimen(Path(place) / "sound")
        before = said_by(read_replay(sound)) if same else None
        for number in until_stopped(range(count)):
            chance = random.Random(f"{damage.__name__} {seed} {number}")
            trial = Path(place) / "trial" / "a.vom"
            shutil.copytree(sound, trial)
            what = damage(trial, chance)
            found = outcome(trial, before)
            counts[found if found.islower() else "wrong"] += 1
            if not found.islower():
                wrong.append(f"{damage.__name__} {number} ({what}): {found}")
            shutil.rmtree(trial.parent)
    return counts, wrong


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--bits", type=int, default=500)
    parser.add_argument("--rows", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    bad = 0
    for damage, count, same in ((flip_bit, asked.bits, True), (odd_row, asked.rows, False)):
        counts, wrong = campaign(damage, count, asked.seed, same=same)
        print(f"{damage.__name__}: {counts.total()} projects, {dict(counts)}", flush=True)
        for line in wrong:
            print("  ", line)
        bad += len(wrong)
    return min(bad, 1)


if __name__ == "__main__":
    sys.exit(main())
