"""How often the 95 % intervals of fracture densities hold the truth: the table of the docs.

Run from the project root:  python -m tests.benchmarks.bench_fractures [--runs 1000]

Maps: a window of 20 by 20 m in a larger process of straight traces with two sets of strikes and
exponential lengths (mean 3 m). `random` traces lie independently of each other. In `clusters`
their midpoints scatter about parents (Thomas process), with so many traces in a cluster on average
and this standard deviation. The true density is known from the process, not from the map.

Scanlines: a line of 20 m with random places, with gaps of a gamma law (coefficient of variation
0.3), or with clusters of places.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator

import numpy as np
import numpy.typing as npt
import shapely

from vomstudio.geology.fractures.network import trace_densities
from vomstudio.geology.fractures.pieces import clip_traces
from vomstudio.geology.fractures.scanlines import find_crossings, measure_spacing

Floats = npt.NDArray[np.float64]
Rng = np.random.Generator

SIDE_M, MARGIN_M, MEAN_LENGTH_M = 20.0, 25.0, 3.0
NUMBERS = (13, 30, 100)
CLUSTERS = ((5.0, 0.5), (5.0, 1.0), (5.0, 2.0), (15.0, 1.0), (15.0, 2.0))
"""Traces in a cluster and their scatter about it, m."""


def middles(rng: Rng, density: float, cluster: tuple[float, float] | None) -> Floats:
    """Return midpoints (n, 2) of traces with this density, in the window and around it."""
    low, high = -MARGIN_M, SIDE_M + MARGIN_M
    area = (high - low) ** 2
    if cluster is None:
        return rng.uniform(low, high, (rng.poisson(density * area), 2))
    size, scatter = cluster
    parents = rng.uniform(low, high, (rng.poisson(density * area / size), 2))
    children = np.repeat(parents, rng.poisson(size, len(parents)), axis=0)
    return children + rng.normal(0.0, scatter, children.shape)


def traces(rng: Rng, places: Floats) -> npt.NDArray[np.object_]:
    """Return shapely lines of two sets about midpoints (n, 2)."""
    n = len(places)
    strike = np.where(rng.random(n) < 0.6, 0.4, 2.0) + rng.normal(0.0, 0.15, n)
    half = 0.5 * rng.exponential(MEAN_LENGTH_M, n)[:, None]
    half = half * np.stack([np.sin(strike), np.cos(strike)], axis=-1)
    return np.asarray(shapely.linestrings(np.stack([places - half, places + half], axis=1)))


def map_row(number: int, cluster: tuple[float, float] | None, runs: int, seed: int) -> str:
    """Simulate maps with this mean number of midpoints in the window."""
    rng = np.random.default_rng([seed, number, 0 if cluster is None else int(10 * cluster[0])])
    window = shapely.box(0.0, 0.0, SIDE_M, SIDE_M)
    density = number / SIDE_M**2
    held = np.zeros(2)
    widths, dispersions = [], []
    for _ in range(runs):
        pieces = clip_traces(traces(rng, middles(rng, density, cluster)), window)
        found = trace_densities(pieces, np.ones(len(pieces), np.bool_), window)
        intervals = (
            (found.P20_nodes_95_1_per_m2, density),
            (
                found.P21_95_1_per_m,
                density * MEAN_LENGTH_M,
            ),
        )
        held += [_holds(interval, truth) for interval, truth in intervals]
        dispersions.append(found.dispersion or 1.0)
        if found.P21_95_1_per_m[1] is not None and found.P21_1_per_m:
            widths.append((found.P21_95_1_per_m[1] - found.P21_95_1_per_m[0]) / found.P21_1_per_m)
    kind = "random" if cluster is None else f"clusters of {cluster[0]:.0f}, {cluster[1]:g} m"
    nodes, intensity = 100.0 * held / runs
    return (
        f"| {kind} | {number} | {nodes:.1f} | {intensity:.1f} | {np.median(widths):.2f} | "
        f"{np.median(dispersions):.1f} |"
    )


def random_places(rng: Rng, density: float) -> Floats:
    return np.sort(rng.uniform(0.0, SIDE_M, rng.poisson(density * SIDE_M)))


def regular_places(rng: Rng, density: float) -> Floats:
    gaps = rng.gamma(1.0 / 0.09, 0.09 / density, int(3 * density * (SIDE_M + MARGIN_M)) + 10)
    along = np.cumsum(gaps) - MARGIN_M
    return along[(along > 0.0) & (along < SIDE_M)]


def clustered_places(rng: Rng, density: float) -> Floats:
    low, high = -MARGIN_M, SIDE_M + MARGIN_M
    parents = rng.uniform(low, high, rng.poisson(density * (high - low) / 4.0))
    children = np.repeat(parents, rng.poisson(4.0, len(parents)))
    along = np.sort(children + rng.normal(0.0, 0.5, len(children)))
    return along[(along > 0.0) & (along < SIDE_M)]


def line_row(
    kind: str, places: Callable[[Rng, float], Floats], number: int, runs: int, seed: int
) -> str:
    """Simulate scanlines with this mean number of crossings."""
    rng = np.random.default_rng([seed, number, len(kind)])
    line = np.array([shapely.LineString([(0.0, 0.0), (SIDE_M, 0.0)])])
    density = number / SIDE_M
    held = np.zeros(2)
    told, widths = 0, []
    for _ in range(runs):
        along = places(rng, density)
        across = np.stack([along, np.full(len(along), -1.0)], -1)
        lines = np.asarray(shapely.linestrings(np.stack([across, across + [0.0, 2.0]], axis=1)))
        crossings = find_crossings(lines, line)
        found = measure_spacing(crossings, np.ones(len(crossings.trace), np.bool_))
        held[0] += _holds(found.P10_95_1_per_m, density)
        if found.mean_95_m[0] is not None:
            told += 1
            held[1] += _holds(found.mean_95_m, 1.0 / density)
            widths.append((found.mean_95_m[1] - found.mean_95_m[0]) * density)
    return (
        f"| {kind} | {number} | {100 * held[0] / runs:.1f} | {100 * held[1] / told:.1f} | "
        f"{np.median(widths):.2f} |"
    )


def _holds(interval: tuple[float | None, float | None], truth: float) -> bool:
    low, high = interval
    return (low is None or low <= truth) and (high is None or truth <= high)


def tables(runs: int, seed: int) -> Iterator[str]:
    yield "| traces | number | P20 by nodes, % | P21, % | width of P21 / P21 | dispersion |"
    yield "|---|---|---|---|---|---|"
    for cluster in (None, *CLUSTERS):
        for number in NUMBERS:
            yield map_row(number, cluster, runs, seed)
    yield ""
    yield "| positions | number | P10, % | spacing, % | width of spacing / spacing |"
    yield "|---|---|---|---|---|"
    kinds = {
        "random": random_places,
        "regular": regular_places,
        "clusters of 4, 0.5 m": clustered_places,
    }
    for kind, places in kinds.items():
        for number in (5, 13, 30, 100):
            yield line_row(kind, places, number, runs, seed)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=39)
    arguments = parser.parse_args()
    for row in tables(arguments.runs, arguments.seed):
        print(row, flush=True)


if __name__ == "__main__":
    main()
