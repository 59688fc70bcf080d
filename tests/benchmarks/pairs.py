"""Two versions of the program at the same work, in turn: what each figure of the later one is over
that of the earlier one.

    python -m tests.benchmarks.pairs --program FOLDER [--pairs 15] [--bound 1.02] COMMAND ...

Opening 10,000 traces and changing one, a COPC of 50 M points, which is made where there is none,
and a mesh of 1 M triangles; the first two behind `xvfb-run -a -s '-screen 0 1600x1000x24
+extension GLX'`:

    tests.benchmarks.bench_thousands --window 10000 --headless --keep FOLDER
    tests.benchmarks.bench_clouds --copc FILE
    tests.benchmarks.bench_load --small --runs 1 --dir FOLDER

COMMAND is what follows `python -m`, such as `tests.benchmarks.bench_fit` or `vomstudio demo`, and
is run in FOLDER (a checkout of the earlier version) and in the checkout of this file, one after the
other and every second pair the other way round, so that a machine that grows slower meets both. One
run of each before the first is not counted. Compared are the seconds and the memory of the whole
process and of its children, and every number of seconds that the command prints. Each ratio is a
geometric mean with its 95 % interval by Student's t over the pairs' logarithms; SLOWER stands where
the whole interval lies above the bound. Nothing else should run meanwhile. `{out}` in an argument
is a new empty folder for each run.
"""

from __future__ import annotations

import argparse
import os
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy import stats

ROOT = Path(__file__).resolve().parents[2]
BOUND = 1.02
NUMBER = r"[-+]?\d[\d,]*\.?\d*(?:e[-+]?\d+)?"
Figures = dict[str, float]


def printed_seconds(text: str) -> Figures:
    """Numbers followed by s or ms, in seconds, named by their line without its numbers. Lines that
    are the same otherwise are told apart by their order."""
    found: Figures = {}
    for line in text.splitlines():
        label = " ".join(re.sub(NUMBER, "#", line).split())
        for place, match in enumerate(re.finditer(rf"({NUMBER}) (ms|s)\b", line)):
            name, again = f"{label} [{place + 1}]", 2
            while name in found:
                name = f"{label} [{place + 1}], {again}"
                again += 1
            value = float(match[1].replace(",", ""))
            found[name] = value / 1e3 if match[2] == "ms" else value
    return found


def run(folder: Path, command: list[str]) -> Figures:
    """Figures of one run in a checkout."""
    environment = os.environ | {"PYTHONPATH": str(folder)}
    with tempfile.TemporaryDirectory() as out:
        asked = [word.replace("{out}", out) for word in command]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        started = time.perf_counter()
        # /usr/bin/time would be one program more to have: a child of its own gives the peak.
        done = subprocess.run(
            [sys.executable, __file__, "--child", *asked],
            cwd=folder,
            env=environment,
            text=True,
            capture_output=True,
            check=False,
        )
        wall = time.perf_counter() - started
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        raise SystemExit(f"{done.stderr[-3000:]}\n{' '.join(asked)} failed in {folder}")
    *lines, peak = done.stdout.splitlines()
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    whole = {"processor seconds": spent, "wall seconds": wall, "peak memory, MB": int(peak) / 1024}
    return whole | printed_seconds("\n".join(lines))


def child(command: list[str]) -> int:
    code = subprocess.run([sys.executable, "-m", *command], check=False).returncode
    print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
    return code


def ratio(old: list[float], new: list[float]) -> tuple[float, float, float]:
    """Geometric mean of new / old over pairs, and its 95 % interval."""
    logs = np.log(np.asarray(new) / np.asarray(old))
    half = float(stats.t.ppf(0.975, len(logs) - 1) * stats.sem(logs))
    low, middle, high = np.exp(logs.mean() + half * np.array([-1.0, 0.0, 1.0]))
    return float(middle), float(low), float(high)


def main() -> int:
    if sys.argv[1:2] == ["--child"]:
        return child(sys.argv[2:])
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("--program", type=Path, required=True, help="the earlier checkout")
    parser.add_argument("--pairs", type=int, default=15)
    parser.add_argument("--bound", type=float, default=BOUND)
    parser.add_argument("command", nargs=argparse.REMAINDER)
    asked = parser.parse_args()
    folders = (asked.program.resolve(), ROOT)
    runs: list[list[Figures]] = [[], []]
    # What has been measured is said, however it ends.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        for number in range(-1, asked.pairs):
            which = (0, 1) if number % 2 else (1, 0)
            pair = {side: run(folders[side], asked.command) for side in which}
            if number >= 0:
                for side in (0, 1):
                    runs[side].append(pair[side])
    except KeyboardInterrupt:
        print("ended early")
    print(f"{' '.join(asked.command)}: {len(runs[0])} pairs")
    return 0 if len(runs[0]) < 2 else min(1, said(runs[0], runs[1], asked.bound))


def said(old: list[Figures], new: list[Figures], bound: float) -> int:
    """Print each figure that all runs have; how many are slower."""
    print(f"{'before':>10s} {'after':>10s}   ratio (95 %)")
    slower = 0
    for name in old[0]:
        if not all(figures.get(name, 0.0) > 0.0 for figures in (*old, *new)):
            continue
        before, after = ([figures[name] for figures in side] for side in (old, new))
        middle, low, high = ratio(before, after)
        word = "  SLOWER" if low > bound else ""
        slower += bool(word)
        print(
            f"{np.median(before):10.4f} {np.median(after):10.4f}   "
            f"{middle:.3f} ({low:.3f}..{high:.3f})  {name}{word}",
            flush=True,
        )
    return slower


if __name__ == "__main__":
    raise SystemExit(main())
