"""What the verdicts on planes are worth: simulated traces and patches whose true plane is known.

    python -m tests.benchmarks.bench_verdicts [--features 3000] [--seed 0]

Traces of 1 to 10 m with a bend of 0.5 to 50 % of that, arched, waved or broken, points with noise
of 1 to 50 mm, half of them with roughness correlated over 2 to 30 % of the trace, on models whose
points are 5 to 100 mm apart. Traces over ledges run along steps of 3 to 60 cm, whose edges the
model rounds by half its spacing, always inward. Patches of 0.3 to 5 m, from square to three times
as long as wide, 100 to 900 points of a model, with noise of 1 to 30 mm, half of them with roughness
correlated over 2 to 20 % of the patch. Printed for each population: the share called good; of these
the share that is more than 5 degrees off the truth (wanted: at most 5 %) and the share within the
total 95 % error (wanted: at least 93 %); and of the features whose 95 % error, by the covariance
they were made with, is at most 3 degrees the shares called good, doubtful and poor (of traces of 8
to 60 vertices with independent errors at most 8 % doubtful and 0.2 % poor are wanted).
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import stats
from scipy.spatial.distance import cdist

from vomstudio.geology.quality import Kind, judge, total_error_deg
from vomstudio.geometry.moment_planes import fit_moments
from vomstudio.geometry.patches import moments
from vomstudio.geometry.planes import FittedPlane, fit_planes

Floats = npt.NDArray[np.float64]
JOINT_95 = float(np.sqrt(stats.chi2.ppf(0.95, 2)))


@dataclass(frozen=True)
class Made:
    """points (n, 3) about the plane z = 0; known_deg : half-angle of the 95 % region of the plane
    that least squares give under the true covariance; spacing : of the model"""

    points: Floats
    known_deg: float
    spacing: float


Maker = Callable[[np.random.Generator], Made]


def known_deg(along: Floats, covariance: Floats) -> float:
    """along : (n, 2) coordinates in the plane"""
    inverse = np.linalg.pinv(np.column_stack([np.ones(len(along)), along]))
    tilts = (inverse @ covariance @ inverse.T)[1:, 1:]
    largest = JOINT_95 * np.sqrt(max(float(np.linalg.eigvalsh(tilts)[-1]), 0.0))
    return float(np.degrees(np.arctan(largest)))


def trace(fewest: int, most: int, *, ledges: bool = False, independent: bool = False) -> Maker:
    def make(rng: np.random.Generator) -> Made:
        n = int(rng.integers(fewest, most + 1))
        length = rng.uniform(1, 10)
        bend = length * 10 ** rng.uniform(-2.3, -0.3)
        noise = 10 ** rng.uniform(-3, -1.3)
        spacing = 10 ** rng.uniform(-2.3, -1)
        at = np.sort(rng.uniform(0, 1, n))
        rounded = np.zeros(n)
        if ledges:
            edges = np.sort(rng.uniform(0, 1, rng.integers(2, 8)))
            step = rng.choice([-1, 1], len(edges)) * 10 ** rng.uniform(-1.5, -0.2, len(edges))
            across = (at[:, None] > edges) @ step
            near = np.abs(at[:, None] - edges).min(axis=1) * length < spacing
            rounded[near] = -0.5 * spacing * rng.uniform(0, 1, int(near.sum()))
        else:
            shapes = (
                4 * at * (1 - at),
                np.sin(2 * np.pi * at) / 2,
                np.interp(at, np.linspace(0, 1, 6), rng.uniform(0, 1, 6)),
            )
            across = bend * shapes[rng.integers(3)]
        covariance = noise**2 * np.eye(n)
        if not independent and rng.random() < 0.5:
            far = np.abs(at[:, None] - at) / rng.uniform(0.02, 0.3)
            covariance = noise**2 * (np.exp(-far) + 0.25 * np.eye(n))
        off = np.linalg.cholesky(covariance) @ rng.normal(size=n) + rounded
        along = np.column_stack([at * length, across])
        return Made(np.column_stack([along, off]), known_deg(along, covariance), spacing)

    return make


def patch(rng: np.random.Generator) -> Made:
    size, ratio = rng.uniform(0.3, 5.0), rng.uniform(1.0, 3.0)
    n = int(rng.integers(100, 901))
    long, wide = size * np.sqrt(ratio), size / np.sqrt(ratio)
    spacing = float(np.sqrt(long * wide / n))
    x, y = np.meshgrid(np.arange(0, long, spacing), np.arange(0, wide, spacing))
    along = np.column_stack([x.ravel(), y.ravel()])
    along += rng.normal(0, 0.1 * spacing, along.shape)
    noise = 10 ** rng.uniform(-3, -1.5)
    covariance = noise**2 * np.eye(len(along))
    if rng.random() < 0.5:
        far = cdist(along, along) / (size * rng.uniform(0.02, 0.2))
        covariance = noise**2 * (np.exp(-(far**2)) + 0.25 * np.eye(len(along)))
    off = np.linalg.cholesky(covariance) @ rng.normal(size=len(along))
    return Made(np.column_stack([along, off]), known_deg(along, covariance), spacing)


def fit_patches(parts: list[Floats]) -> list[FittedPlane]:
    found = []
    for points in parts:
        known = moments(points)
        found.append(fit_moments(known.n, known.mean, known.scatter, known.n_effective))
    return found


def fit_traces(parts: list[Floats]) -> list[FittedPlane]:
    offsets = np.concatenate([[0], np.cumsum([len(points) for points in parts])])
    fits = fit_planes(np.concatenate(parts), offsets)
    return [fits[i] for i in range(len(fits))]


POPULATIONS: dict[str, tuple[Maker, Kind]] = {
    "traces of 8 to 60 vertices": (trace(8, 60), "trace"),
    "the same, independent errors": (trace(8, 60, independent=True), "trace"),
    "traces of 5 to 7 vertices, independent errors": (trace(5, 7, independent=True), "trace"),
    "traces of 5 to 12 vertices": (trace(5, 12), "trace"),
    "traces of 8 to 60 vertices over ledges": (trace(8, 60, ledges=True), "trace"),
    "patches": (patch, "patch"),
}


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--features", type=int, default=3000)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    for name, (make, kind) in POPULATIONS.items():
        rng = np.random.default_rng(args.seed)
        points, normals, known, spacing = [], [], [], []
        for _ in range(args.features):
            made = make(rng)
            turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
            points.append(made.points @ turn.T)
            normals.append(turn[:, 2])
            known.append(made.known_deg)
            spacing.append(made.spacing)
        fits = (fit_traces if kind == "trace" else fit_patches)(points)
        quality, off = np.empty(args.features, object), np.zeros(args.features)
        within = np.zeros(args.features, bool)
        for k, fit in enumerate(fits):
            verdict = judge(fit, resolution_m=spacing[k], outcrop_normal=None, kind=kind)
            quality[k] = verdict.quality
            off[k] = np.degrees(np.arccos(min(1.0, abs(float(fit.normal @ normals[k])))))
            within[k] = off[k] <= (total_error_deg(fit, spacing[k], kind) or 90.0)
        good, sure = quality == "good", quality[np.array(known) <= 3.0]
        print(
            f"{name}: {good.mean():.1%} good, of them {(off[good] > 5).mean():.1%} more"
            f" than 5 degrees off, {within[good].mean():.1%} within; of {len(sure)} known to 3"
            f" degrees {(sure == 'good').mean():.1%} good, {(sure == 'doubtful').mean():.1%}"
            f" doubtful, {(sure == 'poor').mean():.2%} poor",
            flush=True,
        )


if __name__ == "__main__":
    main()
