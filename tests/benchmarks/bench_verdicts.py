"""What the verdicts on planes are worth: simulated traces whose true plane is known.

    python -m tests.benchmarks.bench_verdicts [--traces 3000] [--seed 0]

Traces of 1 to 10 m with a bend of 0.5 to 50 % of that, arched, waved or broken, points with noise
of 1 to 50 mm, half of them with roughness correlated over 2 to 30 % of the trace, on models whose
points are 5 to 100 mm apart. Printed for each population: the share called good; of these the share
that is more than 5 degrees off the truth (wanted: at most 5 %); and of the traces whose 95 % error,
by the covariance they were made with, is at most 3 degrees the share called good (wanted: at least
80 %).
"""

from __future__ import annotations

import argparse

import numpy as np
import numpy.typing as npt
from scipy import stats

from vomstudio.geology.quality import judge
from vomstudio.geometry.planes import fit_planes

Floats = npt.NDArray[np.float64]
POPULATIONS = {"8 to 60": (8, 60), "5 to 12": (5, 12)}
JOINT_95 = float(np.sqrt(stats.chi2.ppf(0.95, 2)))


def trace(rng: np.random.Generator, n: int) -> tuple[Floats, float]:
    """Points (n, 3) about the plane z = 0, and the half-angle of the 95 % region, degrees, of the
    plane that least squares give under the true covariance."""
    length = rng.uniform(1, 10)
    bend = length * 10 ** rng.uniform(-2.3, -0.3)
    noise = 10 ** rng.uniform(-3, -1.3)
    at = np.sort(rng.uniform(0, 1, n))
    shapes = (
        4 * at * (1 - at),
        np.sin(2 * np.pi * at) / 2,
        np.interp(at, np.linspace(0, 1, 6), rng.uniform(0, 1, 6)),
    )
    across = bend * shapes[rng.integers(3)]
    if rng.random() < 0.5:
        far = np.abs(at[:, None] - at) / rng.uniform(0.02, 0.3)
        covariance = noise**2 * (np.exp(-far) + 0.25 * np.eye(n))
    else:
        covariance = noise**2 * np.eye(n)
    off = np.linalg.cholesky(covariance) @ rng.normal(size=n)
    inverse = np.linalg.pinv(np.column_stack([np.ones(n), at * length, across]))
    tilts = (inverse @ covariance @ inverse.T)[1:, 1:]
    largest = JOINT_95 * np.sqrt(max(float(np.linalg.eigvalsh(tilts)[-1]), 0.0))
    return np.column_stack([at * length, across, off]), float(np.degrees(np.arctan(largest)))


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--traces", type=int, default=3000)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    for name, (fewest, most) in POPULATIONS.items():
        rng = np.random.default_rng(args.seed)
        sizes = rng.integers(fewest, most + 1, args.traces)
        points, normals, known, spacing = [], [], [], []
        for n in sizes.tolist():
            flat, angle = trace(rng, n)
            turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
            points.append(flat @ turn.T)
            normals.append(turn[:, 2])
            known.append(angle)
            spacing.append(10 ** rng.uniform(-2.3, -1))
        fits = fit_planes(np.concatenate(points), np.concatenate([[0], np.cumsum(sizes)]))
        good, off = np.zeros(args.traces, bool), np.zeros(args.traces)
        for k in range(args.traces):
            fit = fits[k]
            verdict = judge(fit, resolution_m=spacing[k], outcrop_normal=None)
            good[k] = verdict.quality == "good"
            off[k] = np.degrees(np.arccos(min(1.0, abs(float(fit.normal @ normals[k])))))
        sure = np.array(known) <= 3.0
        print(
            f"{name} vertices: {good.mean():.1%} good, of them {(off[good] > 5).mean():.1%} more"
            f" than 5 degrees off; of {sure.sum()} known to 3 degrees {good[sure].mean():.1%} good"
        )


if __name__ == "__main__":
    main()
