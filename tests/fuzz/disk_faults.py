"""Faults of the disk between any two calls that write: in saving, saving elsewhere, compacting, and
in everything that commands write.

    python -m tests.fuzz.disk_faults [--faults 200] [--seed N] [KIND...]

prints for each kind how many faults there were, how many were said in a sentence and how many were
got over, and each that left half a file, a temporary one, or said "saved" of what is not. The exit
code is 1 if there was one.
"""

from __future__ import annotations

import argparse
import contextlib
import errno
import hashlib
import io
import json
import os
import random
import re
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from pathlib import Path
from typing import Any

from tests.fuzz import faulty_disk
from tests.fuzz.stopping import until_stopped

ERRORS = (errno.ENOSPC, errno.EROFS, errno.EIO)
CAUSES = {errno.ENOSPC: "full", errno.EROFS: "read-only"}
Files = dict[str, bytes]


def files_in(folder: Path) -> Files:
    """The content of every file by its name below the folder; of folders the names."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes() if path.is_file() else b""
        for path in sorted(folder.rglob("*"))
    }


# --- commands ---------------------------------------------------------------------------------
FACE = "{specimens}/schema1.vom/models/face/face.obj"
FORMATS = (
    "csv",
    "gpkg",
    "shp",
    "geojson",
    "dxf",
    "stereonet",
    "orient",
    "faultkin",
    "gempy",
    "loopstructural",
    "gems",
)
COMMANDS: dict[str, tuple[str, ...]] = {
    "ortho": (
        f"ortho {FACE} --trend 31 --plunge 11 --gsd 0.1 --draw {{specimens}}/schema1.vom"
        " --sheet {out}/sheet.pdf -o {out}/ortho.tif",
        f"ortho {FACE} --plane 200/85 --gsd 0.1 --sheet {{out}}/sheet.png -o {{out}}/plane.tif",
    ),
    "dem": (f"dem {FACE} --plane 200/85 --gsd 0.1 --slope -o {{out}}/dem.tif",),
    "export": tuple(
        f"export {{specimens}}/schema1.vom --to {name} -o {{out}}/project.{name}"
        for name in FORMATS
    ),
    "texture": (
        f"convert {FACE} {{out}}/face.glb",
        f"convert {FACE} {{out}}/face.obj",
        f"convert {FACE} {{out}}/face.ply",
    ),
    "models": (
        "convert {specimens}/boulder.ply {out}/boulder.laz",
        "convert {specimens}/boulder.ply {out}/boulder.las",
        "convert {specimens}/boulder.ply {out}/boulder.xyz",
        "convert {specimens}/boulder.ply {out}/boulder.shp",
        f"convert {FACE} {{out}}/face.dxf",
        "compare {specimens}/boulder.ply {specimens}/boulder.ply -o {out}/same.ply",
        "register {specimens}/boulder.ply --pairs {work}/pairs.csv -o {out}/placed.ply",
        "register - --pairs {work}/pairs.csv -o {out}/placed.json",
    ),
    "tables": (
        "fit {resources}/sample/picks.csv --by pick -o {out}/planes.csv --plot {out}/fit.svg",
        "sets {work}/three.csv -o {out}/sets.csv",
        "trace {work}/slope.csv --through {work}/clicks.csv -o {out}/bed.csv --cost grey",
        "facets {resources}/sample/sample.obj -o {out}/facets.csv --labels {out}/facets.ply"
        " --max-distance 0.05 --min-area 0.5",
        f"section {FACE} --plane 110/90 --through 364534,4721858,852 -o {{out}}/section.csv",
        f"section {FACE} --plane 110/90 --through 364534,4721858,852 -o {{out}}/section.dxf",
    ),
    "figures": (
        "stereonet {work}/three.csv --by set -o {out}/net.svg",
        "stereonet {work}/three.csv --contour kamb -o {out}/net.png",
        "stereonet {work}/three.csv --by set -o {out}/net.pdf",
        "rose {work}/three.csv --by set -o {out}/rose.svg",
        "slope {work}/three.csv --face 310/75 --friction 35 --plot {out}/slope.pdf",
        "slip {work}/faults.txt --plot {out}/slip.svg",
        "fractures {work}/traces.geojson --area {work}/area.geojson --plot {out}/fractures.pdf",
        f"section {FACE} --plane 110/90 --through 364534,4721858,852 -o {{out}}/section.svg",
        "plan --camera 23.5x15.6,35,6000x4000 --distance 20 --width 30 --height 10"
        " -o {out}/plan.pdf",
    ),
    "folders": ("frames {work}/pan.avi -o {out}/frames --fps 2",),
}
"""By kind: what writes into {out}, a folder that is there, and nowhere else."""


def run_command(words: list[str]) -> tuple[int, dict[str, Any], str]:
    """Exit code, the object of the command, and what it said to people."""
    from vomstudio.cli import main

    said, shown = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(shown):
        code = main([*words, "--json"])
    return code, json.loads(said.getvalue()), shown.getvalue()


def run_apart(
    words: list[str], below: Path, at: int, number: int, *, goes_on: bool
) -> tuple[int, dict[str, Any], str, int]:
    """As `run_command`, in a process of its own, the children of which meet the fault as well; and
    how many calls there were that write, of all of them together."""
    with tempfile.NamedTemporaryFile(prefix="faulty-disk-calls-") as counter:
        counter.write(bytes(8))
        counter.flush()
        fault = {
            "FAULTY_DISK": str(below),
            "FAULTY_DISK_AT": str(at),
            "FAULTY_DISK_ERROR": str(number),
            "FAULTY_DISK_COUNTER": counter.name,
            **({} if goes_on else {"FAULTY_DISK_ONCE": "1"}),
        }
        done = subprocess.run(
            [sys.executable, "-m", "vomstudio", *words, "--json"],
            env={**os.environ, **fault},
            capture_output=True,
            text=True,
            check=False,
        )
        calls = int.from_bytes(Path(counter.name).read_bytes(), sys.byteorder)
    return done.returncode, json.loads(done.stdout or "{}"), done.stderr, calls


class Command:
    """A command, tried on a disk that fails; into an empty folder, or over what is there."""

    def __init__(
        self, template: str, places: dict[str, str], out: Path, *, quick: bool = False
    ) -> None:
        """quick : for failures only, without knowing what a sound disk gets"""
        self.out = out
        self.words = template.format(**places, out=out).split()
        self.label = template
        self._fresh: Files = {}
        self._replacing: Files = {}
        self.steady: set[str] = set()
        if not quick:
            self._learn()

    def _learn(self) -> None:
        """What it writes, and by how many calls."""
        out = self.out
        self._clear()
        with faulty_disk.fail(out, 0, 0, goes_on=False):
            code, _, shown = run_command(self.words)
            self.calls = faulty_disk.calls()
        assert code == 0, shown
        self.made = self._fresh = files_in(out)
        self._clear()
        run_command(self.words)
        again = files_in(out)
        self.steady = {name for name in again if again[name] == self.made.get(name)}
        # Pictures of a model get other names beside pictures that are there.
        self._put_older()
        run_command([*self.words, "--force"])
        self._replacing = files_in(out)

    def _clear(self) -> None:
        shutil.rmtree(self.out, ignore_errors=True)
        self.out.mkdir(parents=True)

    def _put_older(self) -> None:
        self._clear()
        for name, data in self._fresh.items():
            (self.out / name).parent.mkdir(exist_ok=True)
            if data:
                (self.out / name).write_bytes(b"older " + data[:100])

    def trial(self, at: int, number: int, *, goes_on: bool, over: bool) -> str:
        self._clear()
        words = list(self.words)
        over = over and words[0] != "frames"
        self.made = self._replacing if over else self._fresh
        if over:
            self._put_older()
            words.append("--force")
        before = files_in(self.out)
        with faulty_disk.fail(self.out, at, number, goes_on=goes_on):
            code, result, shown = run_command(words)
            met = faulty_disk.calls() >= at
        after = files_in(self.out)
        if "Traceback" in shown or "*** Aborted" in shown:
            return f"TRACEBACK: {shown[-300:]}"
        if code == 0:
            return self._judged_whole(after, met)
        if code != 2:
            return f"EXIT CODE {code}: {shown[-300:]}"
        sentence = str(result.get("error", {}).get("message", ""))
        place = str(result.get("error", {}).get("file", ""))
        if f"{self.out}/" not in f"{place} {sentence}" or ".vom-" in f"{place} {sentence}":
            return f"TARGET NOT NAMED: {place}: {sentence}"
        changed = {n for n in {*after, *before} if after.get(n) != before.get(n)}
        # Of several outputs those before the failure may be there; whole, that is.
        if not all(self._is_whole(name, after.get(name)) for name in changed):
            if goes_on and len(self.made) > 1 and self._is_apart(changed, before, after):
                return "apart"
            return f"LEFT {sorted(changed)}: {shown[-200:]}"
        # A fault that has gone again can be told by its number only, which libraries hide.
        if number in CAUSES and CAUSES[number] not in sentence and goes_on:
            return f"CAUSE NOT NAMED: {sentence}"
        return "said"

    def _judged_whole(self, after: Files, met: bool) -> str:
        if after.keys() != self.made.keys():
            return f"OTHER FILES {sorted(after.keys() ^ self.made.keys())}"
        for name, data in after.items():
            if not self._is_whole(name, data):
                return f"HALF A FILE {name}: {len(data)} bytes of {len(self.made[name])}"
        return "got over" if met else "not met"

    def _is_apart(self, changed: set[str], before: Files, after: Files) -> bool:
        """Whether a disk that failed for good between two renames has left whole files only, of
        before or of now; what was replaced has its second name still."""
        known = [*before.values(), *self.made.values()]
        return all(name not in after or after[name] in known for name in changed)

    def _is_whole(self, name: str, data: bytes | None) -> bool:
        """Whether it says what the command writes on a sound disk."""
        whole = self.made.get(name)
        if whole is None or data is None:
            return False
        if data == whole:
            return True
        if name.endswith((".tif", ".gpkg")):
            return content(self.out / name) == content_of(whole, Path(name).suffix)
        return name not in self.steady and abs(len(data) - len(whole)) <= 0.02 * len(data) + 64


def content_of(data: bytes, suffix: str) -> Any:
    with tempfile.NamedTemporaryFile(suffix=suffix) as file:
        file.write(data)
        file.flush()
        return content(Path(file.name))


def content(path: Path) -> Any:
    """Pixels, or layers with their rows: libraries lay the same out in other ways after a failure
    that has gone again."""
    if path.suffix == ".gpkg":
        with contextlib.closing(sqlite3.connect(path)) as db:
            if db.execute("PRAGMA integrity_check").fetchall() != [("ok",)]:
                return None
            found = "SELECT table_name FROM gpkg_contents ORDER BY 1"
            tables = [name for (name,) in db.execute(found)]
            # The last columns of styles say when they were written.
            return {
                name: [
                    row[:9] if name == "layer_styles" else row
                    for row in db.execute(f'SELECT * FROM "{name}"')
                ]
                for name in tables
            }
    import rasterio

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        with rasterio.open(path) as dataset:
            return dataset.tags(), str(dataset.crs), dataset.transform, dataset.read().tobytes()


# --- folders full of results ------------------------------------------------------------------
FOLDERS = {
    "demo": "demo --without-photos -o {out}/made",
    "reconstruct": "reconstruct {specimens}/photos -o {out}/made --quality preview --threads 1",
}
"""What fills a folder of its own, where finished parts may stay for the next try."""


_RESUMABLE = re.compile(r"made/work/[a-z]+-[0-9a-f]{16}\.part")
"""The folder of a stage that is not finished: the next run goes on in it. A half *file* in it is as
bad as anywhere."""


class Filling:
    """A command that fills a folder, on a disk that fails; and again once the disk is well."""

    def __init__(self, kind: str, places: dict[str, str], out: Path) -> None:
        self.label, self.out = kind, out
        self.words = FOLDERS[kind].format(**places, out=out).split()
        # What is computed in a worker process meets the faults there.
        self.apart = kind == "reconstruct"
        self._clear()
        code, _, shown, self.calls = self._run(0, 0, goes_on=False)
        assert code == 0, shown
        self.made, self.figures = self._names(), self._figures()

    def _run(self, at: int, number: int, *, goes_on: bool) -> tuple[int, dict[str, Any], str, int]:
        """As `run_command`, and how many calls there were that write."""
        if self.apart:
            return run_apart(self.words, self.out, at, number, goes_on=goes_on)
        with faulty_disk.fail(self.out, at, number, goes_on=goes_on):
            code, result, shown = run_command(self.words)
            return code, result, shown, faulty_disk.calls()

    def _clear(self) -> None:
        shutil.rmtree(self.out, ignore_errors=True)
        self.out.mkdir(parents=True)

    def _names(self) -> set[str]:
        """Of what is for people; intermediate results are named by what they were made of."""
        names = {str(p.relative_to(self.out)) for p in self.out.rglob("*") if p.is_file()}
        return {n for n in names if "/work/" not in n and "/cache/" not in n}

    def _figures(self) -> dict[str, Any]:
        """What a reconstruction says of itself and of its model; of others nothing."""
        path = self.out / "made" / "reconstruction.json"
        if not self.apart or not path.is_file():
            return {}
        said = json.loads(path.read_text())
        kept = ("registered", "unregistered", "tie_points", "faces", "dense_points", "frame")
        return {name: said[name] for name in kept} | {
            "error": round(said["reprojection_error_px"], 3),
            "model": hashlib.sha256((self.out / "made/model.ply").read_bytes()).hexdigest(),
        }

    def _half(self) -> list[str]:
        """Files, and folders of no stage, that are not whole."""
        found = [p for p in self.out.rglob("*") if p.name.endswith(".part") or ".vom-" in p.name]
        names = [(p.relative_to(self.out).as_posix(), p.is_dir()) for p in found]
        return sorted(n for n, is_folder in names if not (is_folder and _RESUMABLE.fullmatch(n)))

    def trial(self, at: int, number: int, *, goes_on: bool, over: bool) -> str:
        """over : it is tried again after the fault, in the same folder; reconstructions always"""
        self._clear()
        code, result, shown, calls = self._run(at, number, goes_on=goes_on)
        if "Traceback" in shown or "*** Aborted" in shown:
            return f"TRACEBACK: {shown[-300:]}"
        if half := self._half():
            return f"LEFT {half}: {shown[-200:]}"
        if code == 0:
            if wrong := self._not_as_made():
                return wrong
            return "got over" if calls >= at else "not met"
        if code != 2:
            return f"EXIT CODE {code}: {shown[-300:]}"
        error = result.get("error", {})
        said = f"{error.get('file', '')} {error.get('message', '')}"
        if str(self.out) not in said or ".vom-" in said:
            return f"TARGET NOT NAMED: {said}"
        if number in CAUSES and CAUSES[number] not in said and goes_on:
            return f"CAUSE NOT NAMED: {said}"
        if over or self.apart:
            code, _, shown, _ = self._run(0, 0, goes_on=False)
            if code != 0 and not self.apart:
                code, _, shown = run_command([*self.words, "--force"])
            if code != 0 or (wrong := self._not_as_made()):
                return f"NOT MADE AGAIN ({code}): {shown[-300:] if code else wrong}"
        return "said"

    def _not_as_made(self) -> str:
        """What differs from what a sound disk gets; nothing where nothing does."""
        if self._names() != self.made:
            return f"OTHER FILES {sorted(self._names() ^ self.made)}"
        found = self._figures()
        differing = {
            n: (found.get(n), was) for n, was in self.figures.items() if found.get(n) != was
        }
        return f"OTHER FIGURES {differing}" if differing else ""


# --- projects ---------------------------------------------------------------------------------
def state_of(folder: Path) -> tuple[Any, ...]:
    from vomstudio.project.journal.database import read_replay

    played = read_replay(folder)
    return dict(played.records), played.top == played.saved_top, tuple(played.problems)


class Work:
    """One thing that is done with a project, on a disk that fails."""

    def __init__(self, kind: str, places: dict[str, str], out: Path) -> None:
        from vomstudio.project.assets import store_asset
        from vomstudio.project.folder import ProjectFolder
        from vomstudio.project.photo_edits import add_photo_set, set_masks
        from vomstudio.project.records import PhotoSet

        self.label, self.out = kind, out
        self.sound = out.with_name(f"{kind}-sound") / "a.vom"
        self.sound.parent.mkdir()
        shutil.copytree(f"{places['specimens']}/schema1.vom", self.sound)
        with contextlib.closing(ProjectFolder.open(self.sound)) as project:
            session = project.session
            session.apply(add_photo_set(session.records, PhotoSet("p", "photos", "/nowhere")))
            mask = store_asset(project.folder, b"a mask", ".png")
            session.apply(set_masks(session.records, "p", {"1.jpg": mask}, "Mask"))
            session.undo()
            self._edit(project, 0)
            session.save()
        self.calls = 0
        self.trial(0, 0, goes_on=False, over=False)

    @staticmethod
    def _edit(project: Any, number: int) -> None:
        from vomstudio.project import edits
        from vomstudio.project.records import Feature

        session = project.session
        feature = next(f for f in session.of(Feature))
        session.apply(edits.set_attributes(session.records, [feature.id], notes=f"other {number}"))

    def trial(self, at: int, number: int, *, goes_on: bool, over: bool) -> str:
        """over : as in a window, where steps wait in memory"""
        from vomstudio.core.errors import VomError
        from vomstudio.project.folder import ProjectFolder

        shutil.rmtree(self.out, ignore_errors=True)
        self.out.mkdir(parents=True)
        folder, target = self.out / "a.vom", self.out / "target" / "b.vom"
        shutil.copytree(self.sound, folder)
        before = state_of(folder)
        project = ProjectFolder.open(folder)
        told: list[Any] = []
        if over:
            project.buffer_unwritten_steps(told.append)
        present, failed, done = before[0], "", False
        below = target.parent if self.label == "save-as" else self.out
        try:
            with faulty_disk.fail(below, at, number, goes_on=goes_on):
                try:
                    if self.label != "compact":
                        self._edit(project, 1)
                        present = dict(project.session.records)
                    if self.label == "save":
                        project.session.save()
                    elif self.label == "save-as":
                        project.save_as(target)
                    else:
                        project.compact()
                    done = True
                except VomError as error:
                    failed = str(error)
                self.calls = self.calls or faulty_disk.calls()
                met = faulty_disk.calls() >= at
            where = project.folder
            known = dict(project.session.records) == present
            kept = state_of(where)
            waits = project.journal.has_pending_rows
            # It goes on where it was, once the disk is well.
            self._edit(project, 2)
            project.session.save()
            last = dict(project.session.records)
        finally:
            project.close()
        return self._judged(
            where,
            before,
            present,
            failed,
            done,
            known,
            kept,
            waits,
            last,
            met,
            target,
            number,
            goes_on,
            bool(told),
        )

    def _judged(
        self,
        where: Path,
        before: Any,
        present: Any,
        failed: str,
        done: bool,
        known: bool,
        kept: Any,
        waits: bool,
        last: Any,
        met: bool,
        target: Path,
        number: int,
        goes_on: bool,
        told: bool,
    ) -> str:
        from vomstudio.project.verify import verify

        if not known:
            return "MEMORY DIFFERS FROM WHAT WAS SAID"
        if done and (kept[0] != present or (self.label != "compact" and not kept[1])):
            return "SAVED, SAID FALSELY"
        if not done and kept[0] not in (before[0], present):
            return "THE JOURNAL IS NEITHER AS BEFORE NOR AS AFTER"
        if not done and not waits and kept[0] != present and self.label != "save-as":
            return "A STEP THAT WAS DONE IS NOT KEPT"
        if kept[2] or not (found := verify(where)).sound:
            return f"DAMAGED {kept[2] or found.problems}"
        if state_of(where)[0] != last:
            return "THE STEP AFTER IT IS LOST"
        left = os.listdir(target.parent) if target.parent.is_dir() else []
        if not done and left:
            return f"LEFT {left}"
        names = {path.name for path in where.iterdir()}
        if odd := {n for n in names if "compact" in n or n.endswith((".part", ".old"))}:
            return f"LEFT {odd}"
        if done:
            return "got over" if met else "not met"
        if number in CAUSES and CAUSES[number] not in failed and goes_on:
            return f"CAUSE NOT NAMED: {failed}"
        return "said"


def each_fails(folder: Path) -> dict[str, list[str]]:
    """Each command on a disk that is full, and on one that is read-only: what came of it."""
    from tests.cli.golden_cases import prepare

    places, found = prepare(folder / "in"), {}
    for template in (template for kind in COMMANDS.values() for template in kind):
        command = Command(template, places, folder / "out", quick=True)
        found[template] = [
            command.trial(at, number, goes_on=True, over=False)
            for at, number in ((3, errno.ENOSPC), (1, errno.EROFS))
        ]
    return found


KINDS = ("save", "save-as", "compact", *COMMANDS, *FOLDERS)


def campaign(kind: str, faults: int, seed: int) -> tuple[Counter[str], list[str]]:
    """For processes with the faulty disk."""
    from tests.cli.golden_cases import prepare

    counts: Counter[str] = Counter()
    wrong: list[str] = []
    chance = random.Random(f"{kind} {seed}")
    fast = "/dev/shm" if Path("/dev/shm").is_dir() else None
    with tempfile.TemporaryDirectory(dir=fast) as made:
        folder = Path(made).resolve()
        places = prepare(folder / "in")
        out = folder / "out"
        works: list[Command] | list[Work] | list[Filling]
        if kind in COMMANDS:
            works = [Command(template, places, out) for template in COMMANDS[kind]]
        elif kind in FOLDERS:
            works = [Filling(kind, places, out)]
        else:
            works = [Work(kind, places, out)]
        for fault in until_stopped(range(faults)):
            work = works[fault % len(works)]
            at = chance.randint(1, max(work.calls, 1))
            number, goes_on = chance.choice(ERRORS), chance.random() < 0.7
            over = chance.random() < 0.5
            try:
                found = work.trial(at, number, goes_on=goes_on, over=over)
            except Exception as error:  # noqa: BLE001 - that is what is looked for
                place = traceback.extract_tb(error.__traceback__)[-1]
                found = (
                    f"ERROR {type(error).__name__}: {str(error)[:200]} "
                    f"({Path(place.filename).name}:{place.lineno})"
                )
            counts[found if found.islower() else "wrong"] += 1
            if not found.islower():
                how = f"{errno.errorcode[number]} at {at} of {work.calls}"
                wrong.append(
                    f"{work.label} ({how}{', goes on' if goes_on else ''}"
                    f"{', over' if over else ''}): {found}"
                )
    return counts, wrong


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--faults", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--each", type=Path, help="a folder: each command once, as JSON")
    parser.add_argument("kinds", nargs="*", metavar="KIND", choices=[*KINDS, []])
    asked = parser.parse_args()
    if (reason := faulty_disk.unavailable_reason()) is not None:
        parser.error(reason)
    if not faulty_disk.is_loaded():
        words = [sys.executable, "-m", "tests.fuzz.disk_faults", *sys.argv[1:]]
        os.execve(sys.executable, words, faulty_disk.environment())
    if asked.each:
        print(json.dumps(each_fails(asked.each.resolve())))
        return 0
    bad = 0
    # "apart": the disk failed for good between the renames of files that belong together.
    for kind in asked.kinds or KINDS:
        counts, wrong = campaign(kind, asked.faults, asked.seed)
        print(f"{kind}: {counts.total()} faults, {dict(counts)}", flush=True)
        for line in wrong:
            print("  ", line, flush=True)
        bad += len(wrong)
    return min(bad, 1)


if __name__ == "__main__":
    sys.exit(main())
