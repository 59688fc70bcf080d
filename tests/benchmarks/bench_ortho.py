"""How fast orthophotos are made: a textured mesh of 1 M triangles, and a cloud of 5 M points.

    python -m tests.benchmarks.bench_ortho [--gsd 0.01] [--runs 3] [--threads N] [--growth]

Printed are the medians of runs of all cases in turn, and their ranges. `--growth` prints the mesh
with 36, 100 and 400 MP instead, and the exponents of the time between them. Timed is
`write_orthophoto` as a whole: trees for the rays, rays, filtering, GeoTIFF and depth raster on the
disk and read back. Processor seconds stand beside wall seconds, for machines that are busy with
other work too.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np
from PIL import Image

from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Material, Mesh
from vomstudio.products.ortho.orthophoto import write_orthophoto
from vomstudio.products.ortho.planning import plan
from vomstudio.products.ortho.view_directions import view_along_line

GROWTH_MP = (36, 100, 400)
UTM = np.array([576_700.0, 5_188_150.0, 160.0])


def cliff(folder: Path, n: int = 708) -> Mesh:
    """2 (n - 1)^2 triangles over 60 x 60 m with one texture of 8192 x 8192."""
    g = np.linspace(0, 60, n)
    x, y = np.meshgrid(g, g)
    z = 2 * np.sin(0.7 * x) + 1.5 * np.cos(0.9 * y) + 0.05 * np.sin(13 * x + 7 * y)
    i = np.arange(n * n).reshape(n, n)
    a, b, c, d = (k.ravel() for k in (i[:-1, :-1], i[:-1, 1:], i[1:, :-1], i[1:, 1:]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)]).astype(np.int32)
    noise = np.random.default_rng(0).integers(0, 255, (1024, 1024, 3), np.uint8)
    path = folder / "rock.jpg"
    Image.fromarray(noise).resize((8192, 8192), Image.Resampling.BICUBIC).save(path, quality=90)
    vertices = np.stack([x, y, z], -1).reshape(-1, 3)
    uv = (vertices[:, :2] / 60).astype(np.float32)
    offsets = np.array([0, len(faces)], np.int64)
    return Mesh(vertices + UTM, faces, (Material("rock", path),), offsets, uv)


def clock(work: Callable[[], object]) -> tuple[float, float]:
    wall, cpu = time.perf_counter(), time.process_time()
    work()
    return time.perf_counter() - wall, time.process_time() - cpu


def interleaved(
    works: list[Callable[[], object]], runs: int
) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    """Median and half range of the wall and processor seconds of each work, run in turn."""
    times: list[list[tuple[float, float]]] = [[] for _ in works]
    for _ in range(runs):
        for work, seconds in zip(works, times, strict=True):
            seconds.append(clock(work))
    return [
        (tuple(np.median(each, axis=0)), tuple(np.ptp(each, axis=0) / 2.0))  # type: ignore[misc]
        for each in times
    ]


def report(
    name: str, pixels: float, middle: tuple[float, float], half: tuple[float, float]
) -> None:
    (wall, cpu), (wall_range, cpu_range) = middle, half
    print(
        f"{name:<28} {pixels / 1e6:6.1f} MP  {wall:6.2f} +- {wall_range:.2f} s wall  "
        f"{cpu:6.2f} +- {cpu_range:.2f} s cpu  {pixels / 1e6 / cpu:5.1f} MP/s per core",
        flush=True,
    )


def growth(folder: Path, runs: int, threads: int | None) -> None:
    mesh = cliff(folder)
    pixels, works = [], []
    for megapixels in GROWTH_MP:
        gsd = 60.0 / np.sqrt(megapixels * 1e6)
        planned = plan(mesh, view_along_line(0, 90), to_world=np.eye(4), gsd=gsd)
        pixels.append(planned.grid.width * planned.grid.height)
        target = folder / f"{megapixels}.tif"
        works.append(partial(write_orthophoto, mesh, planned, target, force=True, threads=threads))
    results = interleaved(works, runs)
    for count, (middle, half) in zip(pixels, results, strict=True):
        report("mesh 1.0 M", count, middle, half)
    for (low, high), ((one, _), (other, _)) in zip(
        pairwise(pixels), pairwise(results), strict=True
    ):
        exponents = np.log(np.divide(other, one)) / np.log(high / low)
        print(f"exponent from {low / 1e6:.0f} MP: {exponents[0]:.2f} wall, {exponents[1]:.2f} cpu")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gsd", type=float, default=0.01)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--threads", type=int)
    parser.add_argument("--growth", action="store_true")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if args.growth:
            growth(folder, args.runs, args.threads)
            return
        mesh = cliff(folder)
        rng = np.random.default_rng(1)
        points = mesh.vertices[rng.integers(0, len(mesh.vertices), 5_000_000)]
        points = points + rng.normal(0, 0.03, points.shape)
        cloud = PointCloud(points, rng.integers(0, 255, points.shape, np.uint8))
        names, pixels, works = [], [], []
        for data, kind in ((mesh, f"mesh {len(mesh.faces) / 1e6:.1f} M"), (cloud, "cloud 5.0 M")):
            for trend, plunge in ((0, 90), (40, 50)):
                view = view_along_line(trend, plunge)
                planned = plan(data, view, to_world=np.eye(4), gsd=args.gsd)
                names.append(f"{kind}, {trend}/{plunge}")
                pixels.append(planned.grid.width * planned.grid.height)
                target = folder / f"{len(names)}.tif"
                works.append(
                    partial(
                        write_orthophoto, data, planned, target, force=True, threads=args.threads
                    )
                )
        for case, count, result in zip(names, pixels, interleaved(works, args.runs), strict=True):
            report(case, count, *result)


if __name__ == "__main__":
    main()
