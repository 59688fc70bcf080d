"""How often the 95 % region of a fold axis holds the true axis, also where the axis is valid.

Run from the project root:  python -m tests.benchmarks.bench_folds [--runs 1000]

Each row simulates beds of cylindrical folds in any attitude. The beds of a fold lie anywhere along
an arc of it, which is drawn evenly from 60 to 180 degrees. Each pole strays by its own error and
by natural waviness, both normal; `scatter` is the standard deviation of their sum. `1 to 8` are
scatters drawn log-uniformly for each fold, `mixed` are beds of one fold with scatters of their own
from 1 to 6 degrees. `yes` is the share of folds whose axis is called valid, `held` the share of
axes whose joint region holds the truth, first of all folds, then of those called valid.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass

import numpy as np

from tests.geology import folded
from tests.geology.folded import Rng, planes
from vomstudio.geology.folding.limbs import find_limbs
from vomstudio.geology.folds import FoldAxis, fold_axis
from vomstudio.geology.statistics import orientation_tensor

BEDS = (3, 5, 6, 8, 10, 12, 15, 20, 30)
ARC_DEG = 60.0, 180.0
SCATTERS_DEG = (1.0, 2.0, 3.0, 5.0)
ANY, MIXED = "1 to 8", "mixed"


@dataclass(frozen=True)
class Count:
    """Of simulated folds: how many, how many regions hold the truth, how many axes are valid, and
    how many of their regions hold it."""

    runs: int
    held: int
    yes: int
    yes_held: int

    def __add__(self, other: Count) -> Count:
        return Count(
            self.runs + other.runs,
            self.held + other.held,
            self.yes + other.yes,
            self.yes_held + other.yes_held,
        )

    @property
    def cells(self) -> str:
        """Of a table: the shares in percent."""
        valid = "-" if self.yes < 20 else f"{100 * self.yes_held / self.yes:.1f}"
        return (
            f"{100 * self.yes / self.runs:.0f} | {100 * self.held / self.runs:.1f} | {valid} | "
            f"{self.yes} "
        )


def beds(rng: Rng, n: int, arc_deg: float, scatter: float | str) -> tuple[np.ndarray, np.ndarray]:
    """Return poles (n, 3) and the true axis (3,)."""
    axis, first, second = folded.axis_frame(rng)
    t = np.radians(rng.uniform(-arc_deg / 2, arc_deg / 2, n))[:, None]
    poles = np.cos(t) * first + np.sin(t) * second
    if scatter == ANY:
        scatter = float(np.exp(rng.uniform(0.0, np.log(8.0))))
    if scatter == MIXED:
        own = np.exp(rng.uniform(0.0, np.log(6.0), (n, 1)))
        return poles + np.radians(own) * rng.normal(size=poles.shape), axis
    return folded.strayed(rng, poles, float(scatter)), axis


def holds(fold: FoldAxis, axis: np.ndarray) -> bool:
    """Whether the joint region of a fold axis contains an axis (3,)."""
    if fold.confidence_axis is None:
        return False
    assert fold.max_confidence95_deg is not None
    assert fold.min_confidence95_deg is not None
    beta, major = fold.beta.vector(), fold.confidence_axis.vector()
    along = abs(float(axis @ beta))
    u = np.degrees(np.arctan2(abs(float(axis @ major)), along))
    w = np.degrees(np.arctan2(abs(float(axis @ np.cross(beta, major))), along))
    u, w = u / fold.max_confidence95_deg, w / fold.min_confidence95_deg
    return bool(u**2 + w**2 <= 1.0)


def simulate(n: int, scatter: float | str, runs: int, seed: int) -> Count:
    """Count over folds of one kind."""
    rng = np.random.default_rng([seed, n])
    held = yes = yes_held = 0
    for _ in range(runs):
        poles, axis = beds(rng, n, rng.uniform(*ARC_DEG), scatter)
        fold = fold_axis(*planes(poles))
        inside = holds(fold, axis)
        held += inside
        yes += fold.valid == "yes"
        yes_held += inside and fold.valid == "yes"
    return Count(runs, held, yes, yes_held)


def limb_row(apart_deg: float, scatter_deg: float, runs: int, seed: int) -> str:
    """Simulate two limbs of five beds each: share with an interlimb angle, and of right ones."""
    rng = np.random.default_rng([seed, int(apart_deg), int(scatter_deg)])
    angles = np.radians(np.repeat([0.0, apart_deg], 5))
    told = held = 0
    for _ in range(runs):
        along = angles + np.radians(rng.normal(0.0, scatter_deg, 10))
        off = np.radians(rng.normal(0.0, scatter_deg, 10))
        poles = np.stack(
            [np.cos(off) * np.cos(along), np.cos(off) * np.sin(along), np.sin(off)], axis=1
        )
        poles = poles @ folded.axis_frame(rng)
        _, axes = orientation_tensor(poles)
        limbs = find_limbs(poles, axes)
        if limbs is None or limbs.doubt:
            continue
        told += 1
        between = np.degrees(np.arccos(min(abs(float(limbs.poles[0] @ limbs.poles[1])), 1.0)))
        truth = min(apart_deg, 180.0 - apart_deg)
        held += abs(between - truth) <= limbs.errors95_deg(axes[2])[0]
    share = "-" if told < 20 else f"{100 * held / told:.1f}"
    return f"| {apart_deg:g} | {scatter_deg:g} | {100 * told / runs:.0f} | {share} |"


def print_limbs(runs: int, seed: int) -> None:
    print("| limbs apart, ° | scatter, ° | told, % | held of them, % |")
    print("|---|---|---|---|")
    for apart in (30.0, 50.0, 70.0, 130.0):
        for scatter in (2.0, 4.0, 6.0, 8.0):
            print(limb_row(apart, scatter, runs, seed), flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=39)
    parser.add_argument("--beds", type=int, nargs="*", default=BEDS)
    parser.add_argument("--limbs", action="store_true", help="two limbs of five beds instead")
    arguments = parser.parse_args()
    if arguments.limbs:
        print_limbs(arguments.runs, arguments.seed)
        return
    print("| beds | scatter, ° | yes, % | held, % | held of yes, % | yes |")
    print("|---|---|---|---|---|---|")
    total = Count(0, 0, 0, 0)
    for n in arguments.beds:
        of_beds = Count(0, 0, 0, 0)
        for scatter in (*SCATTERS_DEG, ANY, MIXED):
            count = simulate(n, scatter, arguments.runs, arguments.seed)
            of_beds += count
            print(f"| {n} | {scatter} | {count.cells}|", flush=True)
        total += of_beds
        print(f"| {n} | all | {of_beds.cells}|", flush=True)
    print(f"| all | all | {total.cells}|")


if __name__ == "__main__":
    main()
