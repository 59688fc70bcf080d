"""How often the 95 % region of a fitted plane holds the true normal: the table of the docs.

Run from the project root:  python -m tests.benchmarks.bench_coverage [--repeats 20000]

Each row simulates traces of one known plane and counts how often its true normal lies inside the
joint region of `max_confidence95_deg` and `min_confidence95_deg`. `width` is the median of the
largest half-angle, `peer` the same for an observer who knows the covariance of the noise: the 95 %
region (chi squared, two degrees of freedom) of the *same* estimator, by the sandwich
(X'X)^-1 X' S X (X'X)^-1, whose axes are not bound to e1 and e2. Generalised least squares would be
narrower still, but it is another estimator than the one reported.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.geometry.planes import PlaneFits, fit_planes

Floats = npt.NDArray[np.float64]

LENGTH = 10.0  # of a trace, m
SIGMA = 0.02  # of the noise, m: small against the curvature of the traces unless said
SMALL, LARGE = 0.002, 0.2  # of the noise on a nearly straight trace: angles small, plane lost


@dataclass(frozen=True)
class Case:
    """One row: the trace's shape, its number of points and the noise on it."""

    shape: str
    n: int
    noise: str = "white"
    length: float = 0.0  # correlation length as a fraction of the trace
    isotropic: bool = False
    spacing: str = "even"
    sigma: float = SIGMA


def trace(shape: str, n: int, spacing: str) -> tuple[Floats, Floats]:
    """Points (n, 2) in the plane, and their positions along the trace (n,), from 0 to LENGTH."""
    t = np.linspace(0.0, 1.0, n)
    if spacing == "uneven":  # dense at one end, as a hand slows down
        t = t**2
    if spacing == "random":
        t = np.concatenate([[0.0], np.sort(np.random.default_rng(n).random(n - 2)), [1.0]])
    # t counts along the trace: a finely drawn curve tells how far along each of its points lies.
    fine = _curve(shape, np.linspace(0.0, 1.0, 12_001))
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(fine, axis=0), axis=1))])
    along /= along[-1]
    points = np.stack([np.interp(t, along, fine[:, i]) for i in range(2)], axis=1)
    return LENGTH * points, LENGTH * t


def _curve(shape: str, t: Floats) -> Floats:
    """Of the shape, for parameters from 0 to 1, in units of LENGTH."""
    x = t - 0.5
    if shape == "arc":
        y = 2.0 * x * x
    elif shape == "straight":  # a sagitta of 2 % of its length
        y = 0.08 * x * x
    elif shape == "hook":  # bent near one end
        y = np.maximum(t - 0.75, 0.0) * 2.0
    elif shape == "wave":
        y = 0.1 * np.sin(2.0 * np.pi * t)
    elif shape == "zigzag":
        y = 0.1 * np.abs((t * 6.0) % 2.0 - 1.0)
    elif shape == "closed":
        x, y = 0.3 * np.cos(2.0 * np.pi * t), 0.2 * np.sin(2.0 * np.pi * t)
    else:
        raise ValueError(shape)
    return np.stack([x, y], axis=1)


def covariance(case: Case, position: Floats) -> Floats:
    """Of the noise normal to the plane, (n, n)."""
    n = len(position)
    if case.noise == "white":
        return case.sigma**2 * np.eye(n)
    h = np.abs(position[:, None] - position[None, :]) / (case.length * LENGTH)
    if case.noise == "exponential":
        r = np.exp(-h)
    elif case.noise == "gaussian":
        r = np.exp(-0.5 * h * h)
    elif case.noise == "gaussian2":  # falls to 1/e at that length, like the exponential
        r = np.exp(-h * h)
    elif case.noise == "mixed":  # half of the variance is white
        r = 0.5 * np.exp(-h) + 0.5 * np.eye(n)
    else:
        raise ValueError(case.noise)
    return case.sigma**2 * r


def inside(fits: PlaneFits, true: Floats) -> npt.NDArray[np.bool_]:
    """Whether the true normal (3,) lies in each elliptical cone."""
    a = fits.axes @ true
    a = a * np.sign(a[:, 2:])
    limit1 = np.tan(np.radians(np.minimum(fits.min_confidence95_deg, 89.999999)))
    limit2 = np.tan(np.radians(np.minimum(fits.max_confidence95_deg, 89.999999)))
    held = (a[:, 0] / limit1) ** 2 + (a[:, 1] / limit2) ** 2 <= a[:, 2] ** 2
    return held & np.isfinite(limit2)


def known_width_deg(points: Floats, s: Floats) -> float:
    """Largest half-angle of the region with known covariance s, for the undisturbed trace."""
    x = np.concatenate([points - points.mean(axis=0), np.ones((len(points), 1))], axis=1)
    inverse = np.linalg.inv(x.T @ x)
    slopes = (inverse @ x.T @ s @ x @ inverse)[:2, :2]
    return float(
        np.degrees(np.arctan(np.sqrt(-2.0 * np.log(0.05) * np.linalg.eigvalsh(slopes)[1])))
    )


def simulate(case: Case, repeats: int, seed: int) -> tuple[float, float, float, float]:
    """Coverage, median largest half-angle, its ratio to the peer, share flagged long_roughness."""
    rng = np.random.default_rng(seed)
    flat, position = trace(case.shape, case.n, case.spacing)
    s = covariance(case, position)
    values, vectors = np.linalg.eigh(s)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    points = np.zeros((repeats, case.n, 3))
    points[:, :, :2] = flat
    points[:, :, 2] = rng.standard_normal((repeats, case.n)) @ root.T
    if case.isotropic:
        points[:, :, :2] += case.sigma * rng.standard_normal((repeats, case.n, 2))
    fits = fit_planes(points.reshape(-1, 3), np.arange(repeats + 1) * case.n)
    held = inside(fits, np.array([0.0, 0.0, 1.0]))
    width = float(np.median(fits.max_confidence95_deg))
    return (
        float(held.mean()),
        width,
        width / known_width_deg(flat, s),
        float(fits.long_roughness.mean()),
    )


def cases() -> Iterator[Case]:
    for isotropic in (False, True):
        for n in (4, 5, 6, 7, 8, 10, 30, 100):
            yield Case("arc", n, isotropic=isotropic)
        for n in (4, 5, 6, 10, 30, 100):
            yield Case("straight", n, isotropic=isotropic)
    for shape in ("hook", "wave", "zigzag", "closed"):
        yield Case(shape, 30)
    yield Case("straight", 30, sigma=LARGE)
    for length in (1 / 80, 1 / 40, 1 / 20, 1 / 14, 1 / 10):
        for noise in ("exponential", "gaussian2", "gaussian", "mixed"):
            for n in (30, 45, 100, 200):
                yield Case("arc", n, noise, length)
    for noise in ("exponential", "gaussian2", "gaussian", "mixed"):
        for shape in ("straight", "hook", "wave", "zigzag", "closed"):
            sigma = SMALL if shape == "straight" else SIGMA
            for n in (30, 100):
                for length in (1 / 20, 1 / 10):
                    yield Case(shape, n, noise, length, sigma=sigma)
    for noise in ("white", "exponential", "gaussian2", "gaussian"):
        for spacing in ("uneven", "random"):
            for n in (30, 60):
                length = 0.0 if noise == "white" else 0.1
                yield Case("arc", n, noise, length, spacing=spacing)
    for length in (0.15, 0.25, 0.5, 1.0):
        for noise in ("exponential", "gaussian"):
            yield Case("arc", 100, noise, length)
    yield Case("arc", 1000)
    for noise in ("exponential", "gaussian2", "gaussian", "mixed"):
        for length in (1 / 20, 1 / 10):
            yield Case("arc", 1000, noise, length)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=6000)
    parser.add_argument("--from-row", type=int, default=0)
    arguments = parser.parse_args()
    start = time.perf_counter()
    print("| trace | points | noise | length / trace | coverage | width | width / peer | flagged |")
    print("|---|---|---|---|---|---|---|---|")
    for i, case in enumerate(cases()):
        if i < arguments.from_row:
            continue
        repeats = max(1000, min(arguments.repeats, 3_000_000 // case.n))
        cover, width, ratio, flagged = simulate(case, repeats, 1000 + i)
        shape = case.shape + ("" if case.spacing == "even" else f", {case.spacing}")
        shape += "" if case.sigma == SIGMA else f", {case.sigma:g} m"
        noise = case.noise + (", 3-D" if case.isotropic else "")
        print(
            f"| {shape} | {case.n} | {noise} | {case.length:.3g} | {100 * cover:.1f} % | "
            f"{width:.3g}° | {ratio:.2f} | {100 * flagged:.0f} % |",
            flush=True,
        )
    print(f"\n{time.perf_counter() - start:.0f} s")


if __name__ == "__main__":
    main()
