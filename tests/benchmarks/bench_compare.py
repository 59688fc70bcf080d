"""Time and memory to hold a cloud of 5 million points against a mesh, a cloud, and by M3C2.

Run from the project root:  python -m tests.benchmarks.bench_compare [MILLIONS]
"""

from __future__ import annotations

import resource
import sys
import time

import numpy as np

from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.registration.distances.comparison import compare


def rock(n: int, seed: int, up: float = 0.0) -> np.ndarray:
    """A rough face of 60 by 60 m in UTM coordinates, with 5 mm noise."""
    rng = np.random.default_rng(seed)
    flat = rng.uniform(0, 60, (n, 2))
    return np.column_stack([flat, height(flat) + up + rng.normal(0, 0.005, n)]) + [5e5, 5e6, 300]


def height(flat: np.ndarray) -> np.ndarray:
    x, y = flat.T
    return np.sin(0.3 * x) * 3 + np.abs((0.7 * y) % 2 - 1) + 0.1 * np.sin(5 * x) * np.cos(4 * y)


def mesh(n: int) -> Mesh:
    """Of about n faces."""
    side = int(np.sqrt(n / 2)) + 1
    x, y = np.meshgrid(np.linspace(0, 60, side), np.linspace(0, 60, side))
    flat = np.column_stack([x.ravel(), y.ravel()])
    row = np.arange(side * side).reshape(side, side)
    a, b, c, d = row[:-1, :-1], row[:-1, 1:], row[1:, 1:], row[1:, :-1]
    faces = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    return Mesh(np.column_stack([flat, height(flat)]) + [5e5, 5e6, 300], faces.astype(np.int32))


def main() -> None:
    millions = float(sys.argv[1]) if len(sys.argv) > 1 else 5.0
    n = int(millions * 1e6)
    model = PointCloud(rock(n, 1, 0.02))
    print(f"{'model against':<28}{'s':>8}{'mean m':>10}{'std m':>10}{'n':>12}{'peak MB':>10}")
    for name, benchmark, radius in (
        ("a mesh of 1 M faces", mesh(1_000_000), None),
        ("a cloud as large", PointCloud(rock(n, 2)), None),
        ("the same, M3C2 of 0.1 m", PointCloud(rock(n, 2)), 0.1),
    ):
        began = time.perf_counter()
        found = compare(model, benchmark, radius_m=radius, registration_error_m=0.0)
        took = time.perf_counter() - began
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(
            f"{name:<28}{took:>8.1f}{found.mean_m:>10.4f}{found.std_m:>10.4f}{found.n:>12,}"
            f"{peak:>10.0f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
