"""Draws mutants of a package and tells which of them its own tests let live.

    python -m tests.mutants geometry --sample 60 --seed 1

Each mutant (see draw.py) is tried in a copy of the tree against the tests of the folder of the same
name. One that lives is either a test that is missing or no change of any result; the latter are
listed with the reason in equivalent.toml and not counted.

Why not a library: mutmut 3 puts every function behind a trampoline, which numba cannot compile, so
that it leaves out whatever is decorated, and constants of modules; it has no samples. cosmic-ray
starts an interpreter for each mutant (seconds of importing), changes the tree that it works in, and
brings aiohttp and SQLAlchemy. Neither swaps arguments or returned values, the slips that matter
most where the numbers are angles and axes.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections import Counter
from pathlib import Path
from typing import Any

from tests.mutants.draw import Mutant, mutant_of, places_of

ROOT = Path(__file__).resolve().parents[2]
COPIED = ("vomstudio", "tests", "resources", "packaging", "pyproject.toml", "README.md")
EQUIVALENT = Path(__file__).with_name("equivalent.toml")
Key = tuple[str, str, str]


def drawn(package: str, sample: int, seed: int, module: str = "") -> list[Mutant]:
    """Mutants at `sample` places of a package, or of its files whose path ends with `module`; the
    same ones for the same text."""
    places = [
        (file, text, changes)
        for file, text in _texts(package)
        if file.endswith(module)
        for changes in places_of(text)
    ]
    chance = random.Random(seed)
    chance.shuffle(places)
    found: list[Mutant] = []
    for file, text, changes in places:
        mutant = mutant_of(file, text, chance.choice(changes))
        if mutant is not None:
            found.append(mutant)
        if len(found) == sample:
            break
    return found


def drawn_again(package: str, results: Path) -> list[Mutant]:
    """Those that survived according to earlier results, as far as their lines are still there."""
    survived = [row for row in json.loads(results.read_text()) if row["state"] == "survived"]
    wanted = {(row["file"], row["before"], row["after"]) for row in survived}
    files = {row["file"] for row in survived}
    every = (
        mutant_of(file, text, change)
        for file, text in _texts(package)
        if file in files
        for changes in places_of(text)
        for change in changes
    )
    return [m for m in every if m is not None and (m.file, m.before, m.after) in wanted]


def _texts(package: str) -> list[tuple[str, str]]:
    paths = sorted((ROOT / "vomstudio" / package).rglob("*.py"))
    return [(path.relative_to(ROOT).as_posix(), path.read_text()) for path in paths]


def equivalent() -> dict[Key, str]:
    """Reasons of mutants that change no result."""
    known = tomllib.loads(EQUIVALENT.read_text()).get("mutant", [])
    return {(m["file"], m["before"], m["after"]): m["reason"] for m in known}


def copied(folder: Path) -> Path:
    """The tree in another folder, without what was compiled."""
    tree = folder / "tree"
    tree.mkdir()
    for name in COPIED:
        source = ROOT / name
        if source.is_dir():
            ignored = shutil.ignore_patterns("__pycache__", ".hypothesis")
            shutil.copytree(source, tree / name, ignore=ignored)
        elif source.exists():
            shutil.copy2(source, tree / name)
    return tree


class Runner:
    """The other process, which works in the copy (see nursery.py)."""

    def __init__(self, tests: str, tree: Path, scratch: Path, quick_s: float) -> None:
        data = os.environ.get("VOMSTUDIO_DATA", str(ROOT.parent / "shared" / "data"))
        kept = {
            "PYTHONPATH": str(tree),
            "PYTHONDONTWRITEBYTECODE": "1",
            "NUMBA_CACHE_DIR": str(scratch / "numba"),
            "VOMSTUDIO_DATA": data,
        }
        asked = [tests, str(scratch), str(quick_s)]
        command = [sys.executable, "-m", "tests.mutants.nursery", *asked]
        self._process = subprocess.Popen(
            command,
            cwd=tree,
            env=os.environ | kept,
            text=True,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )

    def ask(self, **wanted: Any) -> dict[str, Any]:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(json.dumps(wanted) + "\n")
        self._process.stdin.flush()
        found: dict[str, Any] = json.loads(self._process.stdout.readline())
        return found

    def close(self) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()


def tried(mutants: list[Mutant], tests: str, asked: argparse.Namespace) -> list[dict[str, Any]]:
    """What became of each; printed and written as it comes."""
    rows: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        scratch = Path(folder)
        runner = Runner(tests, copied(scratch), scratch, asked.quick)
        try:
            limit = _limit(runner, scratch, asked)
            for number, mutant in enumerate(mutants, 1):
                rows.append(_row(mutant, runner, limit))
                print(f"{number}/{len(mutants)} {described(rows[-1])}", flush=True)
                if asked.json is not None:
                    asked.json.write_text(json.dumps(rows, indent=1))
        finally:
            runner.close()
    return rows


def _limit(runner: Runner, scratch: Path, asked: argparse.Namespace) -> float:
    """Seconds for one mutant, once the tests are known to pass without any."""
    kept: Path | None = asked.times
    known = json.loads(kept.read_text()) if kept is not None and kept.exists() else None
    whole = runner.ask(times=known)
    if whole["state"] != "survived":
        output = (scratch / "output.txt").read_text()[-3000:]
        raise SystemExit(f"{output}\nThe tests fail without any mutant: {whole['by']}")
    if kept is not None:
        kept.write_text(json.dumps(whole["times"]))
    seconds = sum(whole["times"].values())
    limit: float = asked.limit or 3.0 * seconds + 30.0
    print(f"the tests take {seconds:.0f} s; limit {limit:.0f} s", flush=True)
    return limit


def _row(mutant: Mutant, runner: Runner, limit: float) -> dict[str, Any]:
    row: dict[str, Any] = {
        key: getattr(mutant, key) for key in ("file", "line", "kind", "before", "after")
    }
    reason = equivalent().get((mutant.file, mutant.before, mutant.after))
    if reason is not None:
        return row | {"state": "equivalent", "by": reason, "seconds": 0.0}
    found = runner.ask(file=mutant.file, text=mutant.text, limit_s=limit)
    return row | {key: found[key] for key in ("state", "by", "seconds")}


def described(row: dict[str, Any]) -> str:
    text = f"{row['state']} in {row['seconds']:.0f} s: {row['file']}:{row['line']} ({row['kind']})"
    if row["state"] == "killed":
        return f"{text} by {row['by']}"
    return f"{text}\n    - {row['before']}\n    + {row['after']}"


def summary(rows: list[dict[str, Any]]) -> str:
    count = Counter(row["state"] for row in rows)
    dead = count["killed"] + count["timeout"]
    share = 100.0 * dead / max(dead + count["survived"], 1)
    states = ", ".join(f"{count[s]} {s}" for s in ("killed", "timeout", "survived", "equivalent"))
    return f"{states}: {share:.0f} % of those that matter died"


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m tests.mutants")
    parser.add_argument("package", help="a folder of vomstudio, such as geometry or project")
    parser.add_argument("--sample", type=int, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--limit", type=float, metavar="S", help="seconds for one mutant")
    parser.add_argument("--module", default="", help="only of files whose path ends so")
    parser.add_argument("--again", type=Path, metavar="JSON", help="those that survived there")
    parser.add_argument(
        "--quick",
        type=float,
        default=1e9,
        metavar="S",
        help="leave out tests that take longer, with the compiling of kernels where they are first",
    )
    parser.add_argument(
        "--times", type=Path, metavar="JSON", help="of the tests: kept for a second run"
    )
    parser.add_argument("--json", type=Path, help="where the results are written")
    asked = parser.parse_args()
    if asked.again:
        mutants = drawn_again(asked.package, asked.again)
    else:
        mutants = drawn(asked.package, asked.sample, asked.seed, asked.module)
    rows = tried(mutants, f"tests/{asked.package}", asked)
    print(summary(rows))


if __name__ == "__main__":
    main()
