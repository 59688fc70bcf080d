"""How often the attitude of a region lies within the error of a face whose roughness is long.

    python -m tests.benchmarks.bench_bends [--faces 1000] [--seed 0]

Square faces of 22 x 22 points on a level surface with Gaussian roughness, exp(-h²/L²), of 0.3 to
5 % of the face's size, and a quarter of white noise; of each row another L, in sizes of the face.
Printed: how often the level lies within the total error of the face's plane in all; the share that
is called local, how often the level lies within the error of the others; of those that are called
local, within the error of their plane and within that and the bend together.
"""

from __future__ import annotations

import argparse

import numpy as np
import numpy.typing as npt
from scipy.spatial.distance import cdist

from vomstudio.geology.quality import is_local, total_error_deg
from vomstudio.geometry.heights.bends import measure_bend
from vomstudio.geometry.moment_planes import fit_moments
from vomstudio.geometry.patches import moments

Floats = npt.NDArray[np.float64]
SIDE = 22
LENGTHS = (0.0, 0.1, 0.25, 0.4, 0.7, 1.0, 1.5, 2.5)


def rates(count: int, seed: int, length: float) -> tuple[float, float, float, float, float]:
    """The figures of a row, see above; NaN where there is none."""
    rng = np.random.default_rng(seed)
    places = np.stack(np.meshgrid(*2 * [np.linspace(0.0, 1.0, SIDE)]), axis=-1).reshape(-1, 2)
    far = cdist(places, places)
    smooth = np.exp(-((far / length) ** 2)) if length else np.eye(len(places))
    root = np.linalg.cholesky(smooth + 1e-6 * np.eye(len(places)))
    rows = np.zeros((count, 3), bool)
    for row in rows:
        size = np.exp(rng.uniform(np.log(0.003), np.log(0.05)))
        heights = root @ rng.normal(size=len(places))
        if length:
            heights = heights + 0.25 * rng.normal(size=len(places))
        points = np.column_stack([places, size * heights])
        known = moments(points)
        fit = fit_moments(known.n, known.mean, known.scatter, known.n_effective)
        total = total_error_deg(fit, 1.0 / SIDE, "patch") or 90.0
        bend = measure_bend(points, fit.normal)
        off = np.degrees(np.arccos(min(1.0, abs(float(fit.normal[2])))))
        row[:] = (
            off <= total,
            is_local(fit, bend, total),
            off <= np.hypot(total, bend or 0.0),
        )
    within, local, with_bend = rows[:, 0], rows[:, 1], rows[:, 2]

    def share(kept: npt.NDArray[np.bool_]) -> float:
        return float(kept.mean()) if len(kept) else float("nan")

    return (
        share(within),
        share(local),
        share(within[~local]),
        share(within[local]),
        share(with_bend[local]),
    )


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--faces", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    print("| L / face | within | local | regional: within | local: within | local: with the bend |")
    print("|---|---|---|---|---|---|")
    for length in LENGTHS:
        told = rates(args.faces, args.seed, length)
        cells = ("–" if np.isnan(x) else f"{x:.0%}" for x in told)
        print(f"| {length:g} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
