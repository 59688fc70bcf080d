"""How long a followed way takes on a surface of a million points, beside scipy's Dijkstra.

    python -m tests.benchmarks.bench_paths [--side 1000] [--repeats 5]

A hilly square of 20 x 20 m with a dark bed in noisy grey, as a mesh over a grid and as a cloud.
Ways along the bed between ends so far apart: `live` is the way under the cursor, in its corridor
(the first of each cost reckons what it keeps), `whole` the best of all, and `scipy` the plain
shortest path over the same arcs and costs, once these are a matrix. Medians, and the mean distance
of the way from the bed's middle.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from vomstudio.extraction.following import Follower
from vomstudio.extraction.path_costs import node_costs
from vomstudio.extraction.surface_graph import SurfaceGraph
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh

SIZE = 20.0
SHARES = (0.05, 0.2, 0.5, 0.95)
NORMAL = np.array([0.3, 0.9, 0.3]) / np.linalg.norm([0.3, 0.9, 0.3])
MIDDLE = np.array([SIZE / 2, SIZE / 2, 0.0])


def hill(side: int) -> tuple[Mesh, PointCloud, np.ndarray]:
    """The square, and the distance of its points (n,) from the bed's middle."""
    rng = np.random.default_rng(0)
    step = SIZE / side
    y, x = np.mgrid[0:side, 0:side] * step
    xy = np.stack([x.ravel(), y.ravel()], axis=1)
    z = np.zeros(len(xy))
    for length, angle in zip((0.3, 0.7, 1.5, 3.0, 7.0), (1.0, 2.2, 3.1, 4.4, 5.5), strict=True):
        along = xy @ [np.cos(angle), np.sin(angle)]
        z += 0.03 * length * np.sin(2.0 * np.pi / length * along + angle)
    points = np.column_stack([xy, z])
    off = (points - MIDDLE) @ NORMAL
    grey = 150.0 - 90.0 * np.exp(-((off / 0.03) ** 2)) + 20.0 * rng.standard_normal(len(off))
    colours = np.repeat(np.clip(grey, 0, 255).astype(np.uint8)[:, None], 3, axis=1)
    a = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    one = np.stack([a, a + 1, a + side], axis=1)
    other = np.stack([a + 1, a + side + 1, a + side], axis=1)
    mesh = Mesh(points, np.concatenate([one, other]).astype(np.int32), colors=colours)
    scattered = points + 0.25 * step * rng.standard_normal(points.shape)
    return mesh, PointCloud(scattered, colors=colours), off


def seconds(work: Callable[[], object], repeats: int) -> tuple[float, float]:
    """Of the first time, and the median of the others."""
    taken = []
    for _ in range(repeats + 1):
        begun = time.perf_counter()
        work()
        taken.append(time.perf_counter() - begun)
    return taken[0], float(np.median(taken[1:]))


def plain(surface: SurfaceGraph, ends: np.ndarray, repeats: int) -> float:
    """scipy's seconds."""
    graph = surface.whole
    first = np.repeat(np.arange(len(graph.places)), np.diff(graph.starts))
    length = np.linalg.norm(graph.places[first] - graph.places[graph.near], axis=1)
    costs = node_costs(graph, "dark")
    step = length * 0.5 * (costs[first] + costs[graph.near])
    n = len(graph.places)
    arcs = csr_array((step, graph.near, graph.starts), (n, n))
    start = int(surface.tree.query(ends[0] - surface.origin)[1])
    return seconds(lambda: dijkstra(arcs, indices=start, return_predecessors=True), repeats)[1]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--side", type=int, default=1000)
    parser.add_argument("--repeats", type=int, default=5)
    args = parser.parse_args()
    mesh, cloud, off = hill(args.side)
    on = np.flatnonzero(np.abs(off) < 0.02)
    on = on[np.argsort(mesh.vertices[on, 0])]
    for name, data in (("mesh", mesh), ("cloud", cloud)):
        begun = time.perf_counter()
        surface = SurfaceGraph(data)
        surface.prepare()
        prepared = time.perf_counter() - begun
        print(f"== {name} of {len(surface.places):,} points, made ready in {prepared:.2f} s")
        for cost in ("dark", "colour"):
            for share in SHARES:
                rows = [on[int(len(on) * (0.5 + s * share / 2 * 0.999))] for s in (-1, 1)]
                ends = mesh.vertices[rows]
                follower = Follower(surface, cost)
                follower.follow(ends[:1].repeat(2, axis=0) + [[0, 0, 0], [0.3, 0, 0]])
                live = seconds(lambda f=follower, e=ends: f.follow(e), args.repeats)
                whole = seconds(lambda f=follower, e=ends: f.follow(e, whole=True), args.repeats)
                beside = np.abs((follower.follow(ends).points - MIDDLE) @ NORMAL).mean()
                print(
                    f"  {cost:7s}{np.linalg.norm(ends[1] - ends[0]):6.1f} m"
                    f"  live {live[0]:.3f} s, then {live[1]:.3f} s"
                    f"  whole {whole[0]:.3f} s, then {whole[1]:.3f} s"
                    f"  from the middle {1e3 * beside:.0f} mm",
                    flush=True,
                )
        print(f"  scipy, all of it {plain(surface, ends, args.repeats):.3f} s")


if __name__ == "__main__":
    main()
