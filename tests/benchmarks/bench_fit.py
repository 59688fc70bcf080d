"""Time to fit 10,000 traces with every figure, beside a plain loop of numpy's SVD.

Run from the project root:  python -m tests.benchmarks.bench_fit
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from vomstudio.geometry.planes import fit_plane, fit_planes


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
    unordered = best_of(3, lambda: fit_planes(points, offsets, ordered=False))
    print(f"fit_planes, unordered            {unordered:8.3f} s")
    print(f"numpy SVD in a loop, normal only {best_of(3, loop):8.3f} s")
    for n in (10, 50, 200):
        one = points[offsets[-2] :][:n] if n < counts[-1] else points[:n]
        each = best_of(5, lambda one=one: [fit_plane(one) for _ in range(50)]) / 50
        print(f"fit_plane, {n:3d} points            {1e3 * each:8.3f} ms")


if __name__ == "__main__":
    main()
