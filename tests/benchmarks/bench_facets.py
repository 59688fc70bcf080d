"""Facets beside Open3D's planar patches: coverage, error and time on planes that are known.

    python -m tests.benchmarks.bench_facets [--points 1000000] [--model FILE]

Twenty-seven squares of three sets, in a cloud with noise, unequal density and clutter; both find
planes in the same points in the same run. Open3D is told its own defaults (normals of 30
neighbours), and a point is of the patch whose box holds it. With --model only coverage and time of
a file of one's own are printed.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
import numpy.typing as npt

from tests.extraction.planes_by_construction import angle_deg, normal_of, sheet
from vomstudio.extraction.facets import find_facets
from vomstudio.geometry.cloud import PointCloud

Floats = npt.NDArray[np.float64]
SETS = [(40.0, 70.0), (130.0, 85.0), (250.0, 15.0)]


def squares(count: int, noise: float, seed: int = 1) -> tuple[Floats, npt.NDArray[np.int64]]:
    """(n, 3) points and the set of each, -1 for clutter; the densest square has nine times the
    points of the thinnest."""
    rng = np.random.default_rng(seed)
    weight = 9.0 ** rng.uniform(0.0, 1.0, 27)
    share = (0.97 * count * weight / weight.sum()).astype(int)
    parts, of = [], []
    for k in range(27):
        i, j, m = k // 9, k // 3 % 3, k % 3
        which = (i + j + m) % 3
        centre = (4.0 * i, 4.0 * j, 4.0 * m)
        parts.append(sheet(rng, SETS[which], centre, count=int(share[k]), noise=noise))
        of.append(np.full(share[k], which))
    clutter = rng.uniform(-2.0, 10.0, (count - int(share.sum()), 3))
    points = np.concatenate([*parts, clutter])
    order = rng.permutation(len(points))
    return points[order], np.concatenate([*of, np.full(len(clutter), -1)])[order]


def told(name: str, seconds: float, found: list[tuple[Floats, npt.NDArray[np.int64]]],
         of: npt.NDArray[np.int64]) -> None:  # fmt: skip
    """found : normal and rows of each plane"""
    own = of >= 0
    hit = np.zeros(len(of), bool)
    errors, pure = [], []
    for normal, rows in found:
        named = of[rows][of[rows] >= 0]
        if not len(named):
            continue
        which = int(np.bincount(named).argmax())
        errors.append(angle_deg(normal, normal_of(*SETS[which])))
        pure.append(float((of[rows] == which).mean()))
        hit[rows] = True
    print(
        f"{name:22}{len(found):7}{hit[own].mean():10.1%}{np.mean(pure or [0]):9.1%}"
        f"{np.median(errors or [90.0]):12.4f}{max(errors or [90.0]):9.3f}{seconds:9.2f}",
        flush=True,
    )


def ours(points: Floats) -> tuple[float, list[tuple[Floats, npt.NDArray[np.int64]]]]:
    begun = time.perf_counter()
    found = find_facets(PointCloud(points))
    return time.perf_counter() - begun, [(f.fit.normal, f.rows) for f in found.facets]


def open3d(points: Floats) -> tuple[float, list[tuple[Floats, npt.NDArray[np.int64]]]]:
    import open3d as o3d

    begun = time.perf_counter()
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    cloud.estimate_normals(o3d.geometry.KDTreeSearchParamKNN(30))
    boxes = cloud.detect_planar_patches()
    seconds = time.perf_counter() - begun
    return seconds, [
        (
            np.asarray(box.R)[:, 2],
            np.asarray(box.get_point_indices_within_bounding_box(cloud.points)),
        )
        for box in boxes
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=1_000_000)
    parser.add_argument("--model")
    parser.add_argument("--without-open3d", action="store_true")
    args = parser.parse_args()
    if args.model:
        from vomstudio.workspace.world_models import read_in_world

        data = read_in_world(args.model).data
        begun = time.perf_counter()
        found = find_facets(data)
        print(
            f"{len(found.facets)} facets, coverage {found.exposure.coverage or 0:.1%}, near-planar "
            f"{found.exposure.near_planar_share or 0:.1%}, {time.perf_counter() - begun:.2f} s"
        )
        return
    print(f"{'':22}{'planes':>7}{'coverage':>10}{'purity':>9}{'median deg':>12}{'max':>9}{'s':>9}")
    ours(squares(20_000, 0.004)[0])
    for noise in (0.004, 0.012):
        points, of = squares(args.points, noise)
        told(f"ours, {1000 * noise:g} mm", *ours(points), of)
        if not args.without_open3d:
            told(f"Open3D, {1000 * noise:g} mm", *open3d(points), of)


if __name__ == "__main__":
    main()
