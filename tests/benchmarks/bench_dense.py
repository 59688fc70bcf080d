"""Depth maps and fusion of 12 photos of 1 MP of a synthetic face: time, accuracy, completeness.

Run from the project root:  python -m tests.benchmarks.bench_dense [--colmap] [METHOD ...]

METHOD is sgbm, patchmatch or mixed. --colmap fuses the same maps with COLMAP too.
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from tests.photogrammetry.dense.dense_truth import (
    accuracy,
    completeness,
    look,
    lying_face,
    tie_points,
    true_points,
)
from tests.photogrammetry.rock_face import photograph
from vomstudio.geometry.cameras import Intrinsics
from vomstudio.geometry.cloud import PointCloud
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.dense.colmap_workspace import write_workspace
from vomstudio.photogrammetry.dense.depthmaps import DepthMap, DepthOptions, depth_map, make_task
from vomstudio.photogrammetry.dense.fusion import FusionOptions, fuse_depth_maps, neighbours_by_name
from vomstudio.photogrammetry.dense.pairs import select_pairs
from vomstudio.photogrammetry.dense.undistortion import UndistortedPhoto, UndistortTask, undistort

DISTANCE, FOCAL = 8.0, 1100.0
GSD = DISTANCE / FOCAL


def jpeg(picture: np.ndarray) -> bytes:
    import cv2

    bgr = np.ascontiguousarray(picture[..., ::-1])
    return cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, 95])[1].tobytes()


def survey():
    """The face, 12 undistorted photos in two rows, and the tie points."""
    face = lying_face()
    lens = Intrinsics.pinhole(1200, 864, FOCAL, 600.0, 432.0)
    rng = np.random.default_rng(11)
    photos: list[UndistortedPhoto] = []
    for row in range(2):
        for column in range(6):
            centre = np.array([-3.9 + 1.56 * column, -1.0 + 2.0 * row, DISTANCE])
            centre += rng.normal(0.0, [0.1, 0.1, 0.25])
            target = np.array([0.72 * centre[0], 0.45 * centre[1], 0.0]) + rng.normal(0, 0.1, 3)
            view = look(f"im{len(photos):02d}.jpg", lens, centre, target, rng.normal(0.0, 2.0))
            picture = photograph(face, view, seed=len(photos), gain=1 + 0.03 * rng.normal())
            photos.append(undistort(UndistortTask(jpeg(picture), None, view)))
    return face, photos, tie_points(face, [photo.view for photo in photos])


def report(label: str, face, points: np.ndarray, truth: np.ndarray) -> None:
    rng = np.random.default_rng(0)
    sample = points[rng.choice(len(points), min(len(points), 100_000), replace=False)]
    median, most = accuracy(face, sample)
    complete = completeness(points, truth, GSD)
    print(
        f"{label:34s} {len(points) / 1e3:6.0f} k points  median {1e3 * median:5.2f} mm  "
        f"95 % {1e3 * most:6.2f} mm  complete {complete:.3f}",
        flush=True,
    )


def fuse_with_colmap(
    folder: Path,
    scene: SparseScene,
    maps: Sequence[DepthMap],
    photos: Sequence[UndistortedPhoto],
    *,
    min_views: int = 2,
    max_reprojection_px: float = 1.0,
) -> PointCloud:
    """COLMAP's own fusion of the maps; for comparison."""
    import pycolmap

    # Its fusion takes the corner of a pixel for the centre.
    files = write_workspace(folder, scene, photos, shift=-0.5)
    for file, one in zip(files, maps, strict=True):
        has = one.depth[one.depth > 0]
        low, high = (float(has.min()), float(has.max())) if has.size else (0.1, 1.0)
        name = f"{file}.geometric.bin"
        pycolmap.DepthMap.from_array(np.ascontiguousarray(one.depth), low, high).write(
            folder / "stereo" / "depth_maps" / name
        )
        pycolmap.NormalMap.from_array(np.ascontiguousarray(one.normals)).write(
            folder / "stereo" / "normal_maps" / name
        )
    options = pycolmap.StereoFusionOptions()
    options.min_num_pixels = min_views
    options.max_reproj_error = max_reprojection_px
    options.max_normal_error = 25.0
    made = pycolmap.stereo_fusion(
        folder / "fused.ply", folder, input_type="geometric", options=options, output_type="ply"
    )
    points = [made.points3D[i] for i in made.points3D]
    return PointCloud(
        np.array([p.xyz for p in points]).reshape(-1, 3),
        np.array([p.color for p in points], np.uint8).reshape(-1, 3),
    )


def main() -> None:
    wanted = [word for word in sys.argv[1:] if not word.startswith("-")] or ["sgbm", "patchmatch"]
    face, photos, scene = survey()
    truth = true_points(face, [photo.view for photo in photos])
    names = [photo.view.name for photo in photos]
    for method in wanted:
        pairs = select_pairs(scene, method=None if method == "mixed" else method)
        threads = 2 if method == "patchmatch" else 1
        tasks = [
            make_task(plan, photos.__getitem__, DepthOptions(threads=threads))
            for plan in pairs.plans
        ]
        depth_map(tasks[0])  # kernels are compiled or loaded
        start, cpu = time.perf_counter(), time.process_time()
        with ThreadPoolExecutor(1 if threads > 1 else os.cpu_count()) as pool:
            maps = list(pool.map(depth_map, tasks))
        wall = (time.perf_counter() - start) / len(maps)
        cpu = (time.process_time() - cpu) / len(maps)
        filled = np.mean([one.filled for one in maps])
        print(f"{method}: {wall:.2f} s per photo, {cpu:.2f} s of processor, {filled:.3f} filled")
        around = neighbours_by_name(scene, pairs)
        for fewest in (2, 3):
            start, cpu = time.perf_counter(), time.process_time()
            cloud = fuse_depth_maps(names, maps, photos, around, FusionOptions(min_views=fewest))
            wall, cpu = time.perf_counter() - start, time.process_time() - cpu
            label = f"  {fewest} views, {wall:.1f} s ({cpu:.1f} s cpu)"
            report(label, face, cloud.points, truth)
        if "--colmap" in sys.argv:
            for fewest in (2, 3):
                with tempfile.TemporaryDirectory() as folder:
                    start = time.perf_counter()
                    cloud = fuse_with_colmap(Path(folder), scene, maps, photos, min_views=fewest)
                    wall = time.perf_counter() - start
                report(f"  COLMAP, {fewest} views, {wall:.1f} s", face, cloud.points, truth)


if __name__ == "__main__":
    main()
