"""How often a model that is fitted to another one lies where it says that it does.

A rough wall is sampled twice, at random and with noise; one sample is turned by 2 degrees, shifted
by 0.3 m and fitted back. Printed is the share of the repetitions in which the true rotation lies
within the stated 95 %, each axis by itself, how large that is, and the time of one fit.

Run from the project root:  python -m tests.benchmarks.bench_by_model [REPETITIONS [ROW]]
"""

from __future__ import annotations

import sys
import time

import numpy as np

from tests.registration.rock_faces import Case, once

ROWS = {
    "wall of 20 m, 12,000 and 18,000 points, 1 cm": Case(n=(12_000, 18_000)),
    "the same, 5,000 and 7,500 points": Case(n=(5_000, 7_500)),
    "the same, 12,000 points of 3 cm and 8,000 of 1 cm": Case(
        n=(12_000, 8_000), noise=(0.03, 0.01)
    ),
    "as the first, scale unknown (off by 2 %)": Case(n=(12_000, 18_000), scale=True),
}


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 200
    rows = list(ROWS.items())
    if len(sys.argv) > 2:
        rows = [rows[int(sys.argv[2]) - 1]]
    print("| fitted to a reference | east | north | up | scale | median 95 % | off, rms | s |")
    print("|---|---|---|---|---|---|---|---|")
    for name, case in rows:
        began = time.perf_counter()
        found = [once(case, seed) for seed in range(count)]
        took = (time.perf_counter() - began) / count
        off = np.array([np.abs(one.off_deg) for one in found])
        stated = np.array([one.stated_deg for one in found])
        shares = " | ".join(f"{100 * s:.1f}" for s in (off <= stated).mean(axis=0))
        scale = ""
        if case.scale:
            held = [abs(one.off_scale) <= one.stated_scale for one in found]
            scale = f"{100 * np.mean(held):.1f}"
        print(
            f"| {name} | {shares} | {scale} | {np.median(stated.max(axis=1)):.3f}° | "
            f"{np.sqrt((off.max(axis=1) ** 2).mean()):.3f}° | {took:.1f} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
