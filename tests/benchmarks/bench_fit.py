"""Time to fit 10,000 traces with every figure, beside a plain loop of numpy's SVD; and of
`vomstudio fit` on a table of 1 M rows, in one plane and in 10,000, beside a plain script of csv and
SVD that prints dip direction and dip alone.

Run from the project root:  python -m tests.benchmarks.bench_fit
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from vomstudio.geometry.planes import fit_plane, fit_planes

WANTED_OVER_SVD = 2.0
WANTED_OVER_SCRIPT = 0.6
SCRIPT = """
import csv, sys
import numpy as np
groups = {}
with open(sys.argv[1], newline="") as stream:
    rows = csv.reader(stream)
    next(rows)
    for name, *place in rows:
        groups.setdefault(name, []).append([float(v) for v in place])
with open(sys.argv[2], "w") as out:
    for name, points in groups.items():
        a = np.array(points)
        n = np.linalg.svd(a - a.mean(0), full_matrices=False)[2][2]
        n = n * np.sign(n[2])
        azimuth, dip = np.degrees([np.arctan2(n[0], n[1]), np.arccos(n[2])])
        out.write(f"{name},{azimuth % 360:.2f},{dip:.2f}\\n")
"""


def commands() -> None:
    """`vomstudio fit` and the script in turn, three rounds; processor seconds of each process."""
    rng = np.random.default_rng(1)
    for planes in (1, 10_000):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            count = 1_000_000 // planes
            t = np.tile(np.linspace(-1.0, 1.0, count), planes)
            points = np.stack([10.0 * t, 2.0 * t * t, np.zeros_like(t)], axis=1)
            points += rng.normal(0.0, 0.02, points.shape) + [576_700.0, 5_188_200.0, 200.0]
            rows = (f"p{i // count},{x:.4f},{y:.4f},{z:.4f}" for i, (x, y, z) in enumerate(points))
            table = folder / "points.csv"
            table.write_text("\n".join(["id,x,y,z", *rows]) + "\n")
            runs = {
                "ours": [
                    "-m",
                    "vomstudio",
                    "fit",
                    str(table),
                    "--by",
                    "id",
                    "-o",
                    str(folder / "a.csv"),
                    "--force",
                ],
                "script": ["-c", SCRIPT, str(table), str(folder / "b.csv")],
            }
            used: dict[str, list[float]] = {who: [] for who in runs}
            for number in range(4):
                for who in list(runs) if number % 2 else list(runs)[::-1]:
                    before = os.times()
                    subprocess.run(
                        [sys.executable, *runs[who]], check=True, stdout=subprocess.DEVNULL
                    )
                    after = os.times()
                    used[who].append(
                        after.children_user
                        + after.children_system
                        - before.children_user
                        - before.children_system
                    )
            ours, script = (float(np.median(each[1:])) for each in used.values())
            print(
                f"vomstudio fit, 1 M rows in {planes:,} planes: {ours:.2f} s, script {script:.2f}"
                f" s: {ours / script:.2f} of it; wanted {WANTED_OVER_SCRIPT}",
                flush=True,
            )


def best_of(repeats: int, work: Callable[[], object]) -> float:
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return min(times)


def main() -> None:
    rng = np.random.default_rng(1)
    counts = rng.integers(10, 201, 10_000)
    offsets = np.concatenate([[0], np.cumsum(counts)])
    t = np.concatenate([np.linspace(-1.0, 1.0, n) for n in counts])
    points = np.stack([10.0 * t, 2.0 * t * t, np.zeros_like(t)], axis=1)
    points += rng.normal(0.0, 0.02, points.shape)
    points += np.array([576_700.0, 5_188_200.0, 200.0])

    def loop() -> None:
        for i in range(len(counts)):
            part = points[offsets[i] : offsets[i + 1]]
            np.linalg.svd(part - part.mean(axis=0), full_matrices=False)

    start = time.perf_counter()
    fit_planes(points, offsets)
    first = time.perf_counter() - start
    print(f"{len(counts)} traces, {len(points)} points")
    print(f"fit_planes, first call           {first:8.3f} s")
    print(
        f"fit_planes, every figure         {best_of(3, lambda: fit_planes(points, offsets)):8.3f} s"
    )
    unordered = best_of(3, lambda: fit_planes(points, offsets, is_ordered=False))
    print(f"fit_planes, unordered            {unordered:8.3f} s")
    every: list[float] = []
    plain: list[float] = []
    for _ in range(3):
        # The peer first as often as second.
        every.append(best_of(1, lambda: fit_planes(points, offsets)))
        plain += [best_of(1, loop), best_of(1, loop)]
        every.append(best_of(1, lambda: fit_planes(points, offsets)))
    ratio = min(every) / min(plain)
    print(f"numpy SVD in a loop, normal only {min(plain):8.3f} s")
    print(f"every figure over that loop      {ratio:8.2f}; wanted {WANTED_OVER_SVD}")
    for n in (10, 50, 200):
        one = points[offsets[-2] :][:n] if n < counts[-1] else points[:n]
        each = best_of(5, lambda one=one: [fit_plane(one) for _ in range(50)]) / 50
        print(f"fit_plane, {n:3d} points            {1e3 * each:8.3f} ms")
    commands()


if __name__ == "__main__":
    main()
