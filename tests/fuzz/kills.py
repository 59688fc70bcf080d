"""Kills at any moment of random editing: models, photos, masks, control points, marks,
reconstructions, registrations, clicks of unfinished traces, followed traces, accepted sets,
features of every kind, repeats, cells of grids, undoing, saving, saving elsewhere and compacting.

    python -m tests.fuzz.kills --kills 1000 [--seed N]

Each editor is a process that says, after each step, what a person would see; it is killed while it
goes on. What it has said must be there when the project is opened again, and at most the one step
beyond it. Prints how many kills and steps there were, and each step that was lost; the exit code is
1 if there was one.
"""

from __future__ import annotations

import argparse
import hashlib
import math
import os
import random
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from tests.fuzz.stopping import until_stopped
from tests.samples import GRID, ONE_OF_EACH, bed
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.matrices import IDENTITY
from vomstudio.geometry.registrations import Registration
from vomstudio.project import edits, grid_edits
from vomstudio.project.assets import store_asset
from vomstudio.project.edit import Edit
from vomstudio.project.folder import ProjectFolder
from vomstudio.project.journal.replay import Replay, replay
from vomstudio.project.kinds.contact import Contact
from vomstudio.project.kinds.known_line import KnownLine
from vomstudio.project.kinds.lithology import Lithology
from vomstudio.project.kinds.station import Station
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.photo_edits import (
    PointState,
    add_photo_set,
    add_reconstruction,
    set_masks,
    set_points,
)
from vomstudio.project.records import FaceGrid, Feature, Model, PhotoSet, ReconstructionRecord
from vomstudio.project.verify import verify

MODEL = Model("m1", "cliff", "/nowhere/cliff.obj", "mesh", "0" * 64, Frame("local"))
_LONGEST_S = 0.25
"""Of the editing before a kill."""


# --- the editor -------------------------------------------------------------------------------
class Editor:
    """Goes on with a project at random, and says after each step what there is."""

    def __init__(self, folder: Path, chance: random.Random, say: Callable[[str], None]) -> None:
        self.folder, self.chance, self.say = folder, chance, say
        new = not folder.exists()
        self.project = ProjectFolder.create(folder) if new else ProjectFolder.open(folder)
        self.number = 0

    def work(self) -> None:
        """Until it is killed."""
        self.tell("begin")
        steps = self.steps()
        while True:
            kind, step = self.chance.choice(steps)
            # Whether it can be done now is for the edits to say.
            edit = step()
            if edit is None:
                continue
            if isinstance(edit, Edit):
                if not edit.after:
                    continue
                self.project.session.apply(edit, finishes_draft=kind == "finish")
            self.tell(kind)

    def tell(self, kind: str) -> None:
        project = self.project
        told = shown(project.session.records, project.session.draft, project.session.dirty)
        self.say(f"{kind}\t{project.folder}\t{project.journal.last_number}\t{told}\n")

    def steps(self) -> list[tuple[str, Callable[[], Any]]]:
        often = [
            ("trace", self.trace),
            ("trace", self.trace),
            ("click", self.click),
            ("click", self.click),
            ("finish", self.followed),
            ("set", self.accepted_sets),
            ("notes", self.notes),
            ("delete", self.delete),
            ("point", self.point),
            ("mark", self.mark),
            ("mask", self.mask),
            ("feature", self.feature),
            ("feature", self.feature),
            ("change", self.change),
            ("repeat", self.repeat),
            ("cells", self.cells),
            ("undo", self.undo),
            ("undo", self.undo),
            ("redo", self.redo),
            ("save", self.save),
        ]
        return often * 3 + [
            ("model", self.model),
            ("photos", self.photos),
            ("register", self.register),
            ("reconstruction", self.reconstruction),
            ("discard", self.discard),
            ("save as", self.save_as),
            ("compact", self.compact),
        ]

    @property
    def records(self) -> Any:
        return self.project.session.records

    def new_id(self, what: str) -> str:
        self.number += 1
        return f"{what}-{os.getpid()}-{self.number}"

    def _any(self, kind: type[Any]) -> Any:
        found = self.project.session.of(kind)
        return self.chance.choice(found) if found else None

    def model(self) -> Edit | None:
        return None if "m1" in self.records else edits.add_model(self.records, MODEL)

    def trace(self) -> Edit | None:
        if "m1" not in self.records:
            return None
        return edits.add_trace(self.records, bed(self.new_id("t"), self.chance.uniform(0, 9)))

    def click(self) -> str | None:
        """A click of a trace that is not finished yet."""
        if "m1" not in self.records:
            return None
        draft = self.project.session.draft
        clicks = [] if draft is None else list(draft.state["vertices"])
        self.project.session.set_draft(
            {
                "tool": "trace",
                "model_id": "m1",
                "cost": "dark",
                "vertices": [*clicks, [self.chance.random() for _ in range(3)]],
            }
        )
        return "clicked"

    def followed(self) -> Edit | None:
        """The unfinished trace becomes one of many vertices."""
        if self.project.session.draft is None or "m1" not in self.records:
            return None
        x = self.chance.random()
        path = tuple((x + k / 50, math.sin(k / 20), x * k / 50) for k in range(200))
        trace = replace(bed(self.new_id("f"), vertices=path), notes="Followed by dark.")
        return edits.add_trace(self.records, trace)

    def accepted_sets(self) -> Edit | None:
        """A proposal of sets is accepted."""
        traces = self.project.session.of(Trace)
        names = {t.id: self.chance.choice("ABC") for t in traces}
        changed = {i: n for i, n in names.items() if self.records[i].set_name != n}
        return edits.assign_sets(self.records, changed) if changed else None

    def notes(self) -> Edit | None:
        trace = self._any(Trace)
        if trace is None:
            return None
        words = f"slickensides {self.chance.random()}"
        return edits.set_attributes(self.records, [trace.id], notes=words)

    def delete(self) -> Edit | None:
        trace = self._any(Trace)
        return None if trace is None else edits.delete(self.records, [trace.id])

    def feature(self) -> Edit | None:
        """One of any kind, or a grid."""
        if "m1" not in self.records:
            return None
        if self.chance.random() < 0.2:
            grid = replace(GRID, id=self.new_id("grid"), name="")
            return grid_edits.add_grid(self.records, grid)
        like = self.chance.choice([f for f in ONE_OF_EACH.values() if f.id not in ("t1", "i1")])
        rests_on = {} if not hasattr(like, "plane_id") else {"plane_id": ""}
        return edits.add_features(
            self.records, [like.replace_fields(id=self.new_id("k"), name="", **rests_on)]
        )

    def change(self) -> Edit | None:
        """Its words, or its place."""
        found = self._any(Feature)
        if found is None or isinstance(found, Trace):
            return None
        if isinstance(found, Contact | Lithology | Station | KnownLine):
            x = self.chance.random()
            moved = tuple((a + x, b, c) for a, b, c in found.vertices)
            return edits.change_feature(self.records, replace(found, vertices=moved))
        name = f"{found.name[:4]} {self.chance.random()}"
        return edits.set_attributes(self.records, [found.id], name=name)

    def repeat(self) -> Edit | None:
        """A line or an area is drawn a second time by somebody else."""
        found = [f for f in self.project.session.of(Feature) if isinstance(f, Contact | Lithology)]
        if not found:
            return None
        first = self.chance.choice(found)
        who = self.chance.choice(["A", "B"])
        again = replace(
            first, id=self.new_id("again"), name="", repeat_of=first.id, interpreter=who
        )
        return edits.add_features(self.records, [again])

    def cells(self) -> Edit | None:
        grid = self._any(FaceGrid)
        if grid is None:
            return None
        cell = self.chance.randrange(6)
        others = [m for m in grid_edits.MARKS if m != grid_edits.grid_marks(grid)[cell]]
        return grid_edits.mark_cells(self.records, grid.id, [cell], self.chance.choice(others))

    def photos(self) -> Edit:
        id_ = self.new_id("p")
        return add_photo_set(self.records, PhotoSet(id_, id_, f"/geologist/{id_}", "EPSG:32633"))

    def point(self) -> Edit | None:
        found = self._any(PhotoSet)
        if found is None:
            return None
        points = [PointState(f"P{k}", (4e5, 5e6, self.chance.random()), 0.02) for k in range(3)]
        return set_points(self.records, found.id, points, {}, "Control points")

    def mark(self) -> Edit | None:
        found = self._any(PhotoSet)
        if found is None:
            return None
        points = [PointState(f"P{k}", (4e5, 5e6, float(k)), 0.02) for k in range(3)]
        marks = {(f"P{k}", "a.jpg"): (self.chance.random(), 7.0) for k in range(3)}
        return set_points(self.records, found.id, points, marks, "Mark")

    def mask(self) -> Edit | None:
        found = self._any(PhotoSet)
        if found is None:
            return None
        file = store_asset(self.project.folder, self.chance.randbytes(5000), ".png")
        photos = self.chance.sample(["a.jpg", "b.jpg", "c.jpg"], 2)
        return set_masks(self.records, found.id, dict.fromkeys(photos, file), "Leave out")

    def reconstruction(self) -> Edit | None:
        found = self._any(PhotoSet)
        if found is None:
            return None
        id_ = self.new_id("r")
        made = ReconstructionRecord(id_, found.id, id_, id_, "low", "0" * 64, (), 9, 8, 0.4)
        return add_reconstruction(self.records, made, self._registration())

    def _registration(self) -> Registration:
        east = ((1.0, 0.0, 0.0, self.chance.uniform(0, 500)), *IDENTITY[1:])
        frame = Frame("crs", "EPSG:32633")
        return Registration(self.new_id("g"), "control points", "control", frame, matrix=east)

    def register(self) -> Edit | None:
        if "m1" not in self.records:
            return None
        return edits.set_registration(self.records, self._registration(), ["m1"])

    def undo(self) -> str | None:
        if self.project.session.undo_label is None:
            return None
        self.project.session.undo()
        return "undone"

    def redo(self) -> str | None:
        if self.project.session.redo_label is None:
            return None
        self.project.session.redo()
        return "redone"

    def save(self) -> str:
        self.project.session.save()
        return "saved"

    def discard(self) -> str | None:
        if not self.project.session.dirty:
            return None
        self.project.session.discard_unsaved()
        return "discarded"

    def save_as(self) -> str | None:
        if self.project.session.dirty:
            # What stays behind is as it was last saved: no step of what goes on.
            self.project.session.save()
        self.project.save_as(self.folder.with_name(f"{self.new_id('s')}.vom"))
        return "saved as"

    def compact(self) -> str | None:
        if self.project.session.dirty:
            return None
        self.project.compact()
        return "compacted"


def shown(records: Any, draft: Any, dirty: bool) -> str:
    """The state in a few characters."""
    words = repr((sorted((i, repr(r)) for i, r in records.items()), draft and draft.state, dirty))
    return hashlib.sha256(words.encode()).hexdigest()[:24]


# --- what is found ----------------------------------------------------------------------------
def judge(told: list[list[str]]) -> str:
    """One word in small letters, or what is lost. told : kind, folder, row and state of steps"""
    from vomstudio.project.journal.database import SqliteJournal

    kind, folder, last, state = told[-1]
    # A kill between the rename and the opening leaves both, whole.
    project = ProjectFolder.open(Path(folder))
    try:
        if project.problems:
            return f"DAMAGED after {kind}: {project.problems}"
        session = project.session
        found = shown(session.records, session.draft, session.dirty)
        rows = list(project.journal.rows())
    finally:
        project.close()
    if not (checked := verify(Path(folder))).sound:
        return f"DAMAGED after {kind}: {checked.problems}"
    assert isinstance(project.journal, SqliteJournal)
    if found == state:
        return "as shown"
    upto: Replay = replay(row for row in rows if row.seq <= int(last))
    was = shown(upto.records, upto.draft, upto.top != upto.saved_top)
    beyond = len([row for row in rows if row.seq > int(last)])
    if was == state and beyond <= 2:
        return "one step beyond"
    return f"LOST after {kind}, {beyond} rows beyond {last}"


def one_kill(folder: Path, seed: str, delay_s: float, *, early: bool) -> list[list[str]]:
    """What was said, whole lines. The editor is a copy of this process, which is not long at
    starting; early : the time runs from its first moment, else from its first word."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.close(reader)
            Editor(folder, random.Random(seed), lambda line: _write(writer, line)).work()
        except BaseException:  # noqa: BLE001 - said by whoever waits
            said = traceback.format_exc()[-600:].replace("\n", " | ").replace("\t", " ")
            _write(writer, f"ERROR\t{said}\n")
        finally:
            os._exit(1)
    os.close(writer)
    said = b"" if early else os.read(reader, 1 << 16)
    end = time.monotonic() + delay_s
    os.set_blocking(reader, False)
    while (left := end - time.monotonic()) > 0:
        # The pipe must not become full.
        said += _read(reader)
        time.sleep(min(left, 0.01))
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    said += _read(reader)
    os.close(reader)
    lines = said.decode().split("\n")[:-1]
    return [line.split("\t") for line in lines]


def _read(reader: int) -> bytes:
    found = b""
    try:
        while chunk := os.read(reader, 1 << 16):
            found += chunk
    except BlockingIOError:
        pass
    return found


def _write(writer: int, line: str) -> None:
    os.write(writer, line.encode())


def campaign(kills: int, seed: int) -> tuple[Counter[str], Counter[str], list[str]]:
    """How kills ended, which steps were told, and what was lost."""
    chance = random.Random(f"kills {seed}")
    ends: Counter[str] = Counter()
    steps: Counter[str] = Counter()
    wrong: list[str] = []
    with tempfile.TemporaryDirectory() as place:
        # What editors need is imported once.
        warm = Editor(Path(place) / "warm.vom", random.Random(0), lambda _: None)
        warm.tell("begin")
        for _, step in [*warm.steps(), *warm.steps()]:
            if isinstance(edit := step(), Edit) and edit.after:
                warm.project.session.apply(edit)
        warm.project.close()
        folder = Path(place).resolve() / "0.vom"
        for number in until_stopped(range(kills)):
            # Some editors go on with what the one before has left.
            if number % 5 == 0:
                folder = folder.with_name(f"{number}.vom")
            early, delay_s = chance.random() < 0.05, chance.random() * _LONGEST_S
            told = one_kill(folder, f"{seed} {number}", delay_s, early=early)
            if told and told[-1][0] == "ERROR":
                ends["wrong"] += 1
                wrong.append(f"kill {number}: the editor fell: {told[-1][1]}")
                folder = folder.with_name(f"{number}-new.vom")
                continue
            steps.update(line[0] for line in told)
            if not told:
                # Before there was anything to see.
                ends["nothing shown yet"] += 1
                folder = folder.with_name(f"{number}-new.vom")
                continue
            found = judge(told)
            ends[found if found.islower() else "wrong"] += 1
            if not found.islower():
                wrong.append(f"kill {number}: {found}")
            folder = Path(told[-1][1])
    return ends, steps, wrong


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    ends, steps, wrong = campaign(asked.kills, asked.seed)
    print(f"{ends.total()} kills: {dict(ends)}")
    print(f"{steps.total()} steps shown: {dict(sorted(steps.items()))}")
    for line in wrong:
        print("  ", line)
    return min(len(wrong), 1)


if __name__ == "__main__":
    sys.exit(main())
