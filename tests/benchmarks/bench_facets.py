"""Facets beside CloudCompare's RANSAC and Open3D's planar patches, on planes that are known.

    python -m tests.benchmarks.bench_facets [--points 1000000] [--model FILE]

Twenty-seven squares of three sets, in a cloud with noise, unequal density and clutter; all find
planes in the same points in the same run. Open3D is told its own defaults (normals of 30
neighbours), and a point is of the patch whose box holds it. CloudCompare, where it is installed
(with xvfb-run), is told three times the noise as distance and its own defaults else; its time is
without starting, reading and writing, which a second run without the search takes. Times of the
processor are of all threads together, and other work on the machine does not change them much;
those of the clock are worth something on a quiet machine only. Ours and Open3D's are in two
threads or more where there are so many processors. With --model only coverage and time of a file
of one's own are printed.
"""

from __future__ import annotations

import argparse
import resource
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
import numpy.typing as npt

from tests.extraction.planes_by_construction import angle_deg, normal_of, sheet
from vomstudio.extraction.facets import find_facets
from vomstudio.geometry.cloud import PointCloud

Floats = npt.NDArray[np.float64]
Plane = tuple[Floats, npt.NDArray[np.int64]]
"""Its normal and its rows."""
Seconds = npt.NDArray[np.float64]
"""Of the processor, and of the clock."""
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


def told(name: str, seconds: Seconds, found: list[Plane], of: npt.NDArray[np.int64]) -> None:
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
        f"{np.median(errors or [90.0]):12.4f}{max(errors or [90.0]):9.3f}"
        f"{seconds[0]:9.2f}{seconds[1]:9.2f}",
        flush=True,
    )


def now() -> Seconds:
    return np.array([time.process_time(), time.perf_counter()])


def ours(points: Floats) -> tuple[Seconds, list[Plane]]:
    begun = now()
    found = find_facets(PointCloud(points))
    return now() - begun, [(f.fit.normal, f.rows) for f in found.facets]


def cloudcompare(points: Floats, noise: float) -> tuple[Seconds, list[Plane]]:
    from scipy.spatial import cKDTree

    tree = cKDTree(points)
    with tempfile.TemporaryDirectory() as folder:
        cloud = Path(folder, "cloud.xyz")
        np.savetxt(cloud, points, fmt="%.7f")
        begin = [
            "xvfb-run",
            "-a",
            "CloudCompare",
            "-SILENT",
            "-AUTO_SAVE",
            "OFF",
            "-C_EXPORT_FMT",
            "ASC",
            "-PREC",
            "7",
            "-O",
            str(cloud),
        ]
        search = [
            "-RANSAC",
            "EPSILON_ABSOLUTE",
            f"{3.0 * noise:g}",
            "ENABLE_PRIMITIVE",
            "PLANE",
            "OUT_CLOUD_DIR",
            folder,
            "OUTPUT_INDIVIDUAL_SUBCLOUDS",
        ]
        without, whole = _seconds_of([*begin, "-SAVE_CLOUDS"]), _seconds_of([*begin, *search])
        found = []
        for path in sorted(Path(folder).glob("*PLANE*.asc")):
            own = np.loadtxt(path, usecols=(0, 1, 2), ndmin=2)
            normal = np.linalg.svd(own - own.mean(axis=0), full_matrices=False)[2][2]
            found.append((normal, tree.query(own)[1]))
    return whole - without, found


def _seconds_of(command: list[str]) -> Seconds:
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(command, check=True, capture_output=True)
    passed = time.perf_counter() - begun
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    own = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return np.array([own, passed])


def open3d(points: Floats) -> tuple[Seconds, list[Plane]]:
    import open3d as o3d

    begun = now()
    cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
    cloud.estimate_normals(o3d.geometry.KDTreeSearchParamKNN(30))
    boxes = cloud.detect_planar_patches()
    seconds = now() - begun
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
        from vomstudio.studio.world_models import read_in_world

        data = read_in_world(args.model).data
        begun = time.perf_counter()
        found = find_facets(data)
        print(
            f"{len(found.facets)} facets, coverage {found.exposure.coverage or 0:.1%}, near-planar "
            f"{found.exposure.near_planar_share or 0:.1%}, {time.perf_counter() - begun:.2f} s"
        )
        return
    print(
        f"{'':22}{'planes':>7}{'coverage':>10}{'purity':>9}{'median deg':>12}{'max':>9}{'cpu s':>9}"
        f"{'wall s':>9}"
    )
    ours(squares(20_000, 0.004)[0])
    for noise in (0.004, 0.012):
        points, of = squares(args.points, noise)
        told(f"ours, {1000 * noise:g} mm", *ours(points), of)
        if shutil.which("CloudCompare") and shutil.which("xvfb-run"):
            told(f"CloudCompare, {1000 * noise:g} mm", *cloudcompare(points, noise), of)
        if not args.without_open3d:
            told(f"Open3D, {1000 * noise:g} mm", *open3d(points), of)


if __name__ == "__main__":
    main()
