"""How often the truth lies within the total 95 % error of traces, among all and among those good.

    python -m tests.benchmarks.bench_conditional [--traces 2000] [--seed 0]

Traces of 10 m, arched, waved, broken, hooked or zigzag, with a bend of 0.5 to 50 % of that and
points anywhere along them. The noise is scaled so that the 95 % error by its own covariance is
log-uniform from 0.3 to 10 degrees, of each trace anew:

white : independent
correlated : four fifths exponential, over 2 to 10 % of the trace, one fifth white
self-affine : the increments of a surface with a Hurst exponent of 0.7
bow : white, and a bow with a sagitta of 5 cm that the scaling does not know

No model: nothing but the points tells how rough they are. Printed for each row: how often the truth
is within `total_error_deg` in all and among the good, how many are good, and of those whose error
by the covariance is at most 3 degrees how many are doubtful and poor.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from tests.benchmarks.bench_verdicts import known_deg
from vomstudio.geology.quality import judge, total_error_deg
from vomstudio.geometry.planes import fit_planes

Floats = npt.NDArray[np.float64]
LENGTH = 10.0
BOW = 0.05
NOISES = ("white", "correlated", "self-affine", "bow")
COUNTS = (4, 5, 6, 8, 12, 20, 40, 100)


def bend(rng: np.random.Generator, s: Floats) -> Floats:
    """(n,) of a size of 1 at places s from 0 to 1 along the trace."""
    shapes = (
        4.0 * s * (1.0 - s),
        np.sin(2.0 * np.pi * s) / 2.0,
        np.interp(s, np.linspace(0.0, 1.0, 6), rng.uniform(0.0, 1.0, 6)),
        2.5 * np.maximum(s - 0.6, 0.0),
        np.abs((3.0 * s) % 2.0 - 1.0),
    )
    return np.asarray(shapes[rng.integers(len(shapes))])


def covariance(rng: np.random.Generator, noise: str, s: Floats) -> Floats:
    """(n, n) of the noise, in any unit."""
    apart = np.abs(s[:, None] - s)
    if noise == "correlated":
        return np.asarray(0.8 * np.exp(-apart / rng.uniform(0.02, 0.1)) + 0.2 * np.eye(len(s)))
    if noise == "self-affine":
        power = 1.4
        fractal = (s[:, None] ** power + s**power - apart**power) / 2.0
        return np.asarray(fractal + 1e-3 * np.eye(len(s)))
    return np.eye(len(s))


@dataclass(frozen=True)
class Made:
    """points (n, 3); normal (3,) of the true plane; known_deg : its 95 % error by the noise."""

    points: Floats
    normal: Floats
    known_deg: float


def made(rng: np.random.Generator, n: int, noise: str) -> Made:
    s = np.sort(rng.uniform(0.0, 1.0, n))
    s = (s - s[0]) / (s[-1] - s[0])
    size = LENGTH * 10.0 ** rng.uniform(-2.3, -0.3)
    plane = np.column_stack([LENGTH * s, size * bend(rng, s)])
    spread = covariance(rng, noise, s)
    known = float(np.exp(rng.uniform(np.log(0.3), np.log(10.0))))
    sigma = np.tan(np.radians(known)) / np.tan(np.radians(known_deg(plane, 1e-12 * spread)))
    off = 1e-6 * sigma * np.linalg.cholesky(spread + 1e-12 * np.eye(n)) @ rng.normal(size=n)
    if noise == "bow":
        off += rng.choice([-1.0, 1.0]) * BOW * 4.0 * s * (1.0 - s)
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    return Made(np.column_stack([plane, off]) @ turn.T, turn[:, 2], known)


@dataclass(frozen=True)
class Rates:
    """Shares: within, of all and of the good; good; doubtful and poor of those known to 3 deg."""

    within: float
    within_good: float
    good: float
    doubtful: float
    poor: float


def rates(count: int, seed: int, n: int, noise: str) -> Rates:
    rng = np.random.default_rng(seed)
    all_made = [made(rng, n, noise) for _ in range(count)]
    fits = fit_planes(np.concatenate([m.points for m in all_made]), np.arange(count + 1) * n)
    within, quality = np.zeros(count, bool), np.empty(count, object)
    for k, (one, fit) in enumerate(zip(all_made, fits.rows(), strict=True)):
        off = np.degrees(np.arccos(min(1.0, abs(float(fit.normal @ one.normal)))))
        stated = total_error_deg(fit, None)
        within[k] = stated is not None and off <= stated
        quality[k] = judge(fit, resolution_m=None, outcrop_normal=None).quality
    good = quality == "good"
    sure = np.array([m.known_deg for m in all_made]) <= 3.0
    return Rates(
        float(within.mean()),
        float(within[good].mean()) if good.any() else float("nan"),
        float(good.mean()),
        float((quality[sure] == "doubtful").mean()),
        float((quality[sure] == "poor").mean()),
    )


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--traces", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    print("| noise | points | within | good | within, good | doubtful | poor |")
    print("|---|---|---|---|---|---|---|")
    for noise in NOISES:
        for n in COUNTS:
            r = rates(args.traces, args.seed + n, n, noise)
            kept = "–" if np.isnan(r.within_good) else f"{r.within_good:.1%}"
            print(
                f"| {noise} | {n} | {r.within:.1%} | {r.good:.0%} | {kept}"
                f" | {r.doubtful:.1%} | {r.poor:.1%} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
