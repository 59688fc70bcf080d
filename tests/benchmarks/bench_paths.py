"""How long a followed path takes on a surface of a million points, beside scipy's Dijkstra.

    python -m tests.benchmarks.bench_paths [--side 1000] [--repeats 5] [--growth 1 4 16]

A hilly square of 10 x 10 m with a dark bed in noisy grey, as a mesh over a grid with colours or a
texture, and as a cloud. Paths of 1, 3 and 9 m along the bed: `live` is the path to the cursor,
which moves a little from one path to the next (the first of each cost computes what is cached),
`whole_graph` the best path of all, and `scipy` the plain shortest path over the same arcs and
costs, once these are a matrix. Medians of wall and processor seconds, and the mean distance of the
path from the bed's middle. The time of preparing 1/16, 1/4 and all of the points shows the growth.
`--growth` prints the preparation of coloured meshes of so many million vertices instead, the paths
of 9 m over them, and the exponents of both.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
from PIL import Image
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from vomstudio.extraction.following import Follower
from vomstudio.extraction.path_costs import node_costs
from vomstudio.extraction.surface_graph import SurfaceGraph
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Material, Mesh

SIZE = 10.0
LENGTHS_M = (1.0, 3.0, 9.0)
TEXTURE_PX = 4096
WANTED_9_M_S, WANTED_PREPARED_S = 0.1, 1.0
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


def textured(mesh: Mesh, folder: Path) -> Mesh:
    """The same surface with the bed in a texture."""
    y, x = (np.mgrid[0:TEXTURE_PX, 0:TEXTURE_PX] + 0.5) * (SIZE / TEXTURE_PX)
    off = (x - MIDDLE[0]) * NORMAL[0] + (SIZE - y - MIDDLE[1]) * NORMAL[1]
    noise = 20.0 * np.random.default_rng(1).standard_normal(off.shape)
    grey = np.clip(150.0 - 90.0 * np.exp(-((off / 0.03) ** 2)) + noise, 0, 255).astype(np.uint8)
    picture = folder / "texture.png"
    Image.fromarray(np.repeat(grey[..., None], 3, axis=2)).save(picture, compress_level=1)
    uv = (mesh.vertices[:, :2] / SIZE).astype(np.float32)
    offsets = np.array([0, len(mesh.faces)])
    return Mesh(mesh.vertices, mesh.faces, (Material("rock", picture),), offsets, uv)


def seconds(work: Callable[[], object], repeats: int) -> tuple[float, float, float]:
    """Wall seconds of the first time; medians of wall and processor seconds of the others."""
    taken = []
    for _ in range(repeats + 1):
        begun = time.perf_counter(), time.process_time()
        work()
        taken.append((time.perf_counter() - begun[0], time.process_time() - begun[1]))
    wall, processor = np.median(taken[1:], axis=0)
    return taken[0][0], float(wall), float(processor)


def moving_ends(points: np.ndarray, length: float) -> Iterator[np.ndarray]:
    """Ends so far apart along the points (k, 3) of a line; the second moves like a cursor."""
    x, half = points[:, 0], 0.5 * length * np.cos(np.arctan2(NORMAL[0], NORMAL[1]))
    start = np.argmin(np.abs(x - (MIDDLE[0] - half)))
    goals = np.argsort(np.abs(x - (MIDDLE[0] + half)), kind="stable")[:50]
    while True:
        for goal in goals:
            yield points[[start, goal]]


def plain(surface: SurfaceGraph, ends: np.ndarray, repeats: int) -> float:
    """scipy's seconds."""
    graph = surface.whole_graph
    first = np.repeat(np.arange(len(graph.places)), np.diff(graph.starts))
    length = np.linalg.norm(graph.places[first] - graph.places[graph.neighbours], axis=1)
    costs = node_costs(graph, "dark")
    step = length * 0.5 * (costs[first] + costs[graph.neighbours])
    n = len(graph.places)
    arcs = csr_array((step, graph.neighbours, graph.starts), (n, n))
    start = int(surface.tree.query(ends[0] - surface.origin)[1])
    return seconds(lambda: dijkstra(arcs, indices=start, return_predecessors=True), repeats)[1]


def prepared(data: Mesh | PointCloud) -> tuple[SurfaceGraph, float]:
    """The graph, and its processor seconds."""
    begun = time.process_time()
    surface = SurfaceGraph(data)
    surface.prepare()
    return surface, time.process_time() - begun


def measure(name: str, data: Mesh | PointCloud, bed: np.ndarray, repeats: int) -> None:
    """Print the times of one model; bed (k, 3) are points along it."""
    surface, taken = prepared(data)
    print(
        f"== {name} of {len(surface.places):,} points, made ready in {taken:.2f} s (CPU);"
        f" wanted {WANTED_PREPARED_S}"
    )
    for cost in ("dark", "colour"):
        for length in LENGTHS_M:
            ends = moving_ends(bed, length)
            follower = Follower(surface, cost)
            live = seconds(lambda f=follower, e=ends: f.follow(next(e)), repeats)
            line = f"  {cost:7s}{length:4.0f} m  live {live[0]:.3f} s, then {live[1]:.3f} s"
            line += f" (CPU {live[2]:.3f} s)"
            if not surface.can_refine:
                whole_s = seconds(
                    lambda f=follower, e=ends: f.follow(next(e), uses_whole_surface=True), repeats
                )
                line += f"  whole {whole_s[0]:.3f} s, then {whole_s[1]:.3f} s"
            beside = np.abs((follower.follow(next(ends)).points - MIDDLE) @ NORMAL).mean()
            wanted = f"; wanted {WANTED_9_M_S}" if length == LENGTHS_M[-1] else ""
            print(f"{line}  from the middle {1e3 * beside:.0f} mm{wanted}", flush=True)
    if not surface.can_refine:
        print(f"  scipy, all of it {plain(surface, next(ends), repeats):.3f} s")


def growth(millions: list[float], repeats: int) -> None:
    """Print the processor seconds of preparing and following meshes, and their exponents."""
    results = []
    for count in millions:
        mesh, _, off = hill(round(1000 * count**0.5))
        on = np.flatnonzero(np.abs(off) < 0.02)
        bed = mesh.vertices[on[np.argsort(mesh.vertices[on, 0])]]
        surface, taken = prepared(mesh)
        ends, follower = moving_ends(bed, LENGTHS_M[-1]), Follower(surface, "dark")
        first, _, live = seconds(lambda f=follower, e=ends: f.follow(next(e)), repeats)
        results.append((len(mesh.vertices), taken, live))
        print(
            f"{len(mesh.vertices):>11,} vertices prepared in {taken:.2f} s (CPU), 9 m in"
            f" {live:.3f} s (CPU), the first in {first:.2f} s",
            flush=True,
        )
    for (fewer, *one), (more, *other) in pairwise(results):
        exponents = np.log(np.divide(other, one)) / np.log(more / fewer)
        print(f"exponent from {fewer:,}: {exponents[0]:.2f} prepared, {exponents[1]:.2f} followed")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--side", type=int, default=1000)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--growth", type=float, nargs="+", metavar="MILLIONS")
    args = parser.parse_args()
    if args.growth:
        growth(args.growth, args.repeats)
        return
    for divisor in (4, 2):
        part = hill(args.side // divisor)[0]
        print(f"{len(part.vertices):,} points, made ready in {prepared(part)[1]:.3f} s (CPU)")
    mesh, cloud, off = hill(args.side)
    on = np.flatnonzero(np.abs(off) < 0.02)
    bed = mesh.vertices[on[np.argsort(mesh.vertices[on, 0])]]
    measure("coloured mesh", mesh, bed, args.repeats)
    with tempfile.TemporaryDirectory() as folder:
        measure("textured mesh", textured(mesh, Path(folder)), bed, args.repeats)
    measure("cloud", cloud, bed, args.repeats)


if __name__ == "__main__":
    main()
