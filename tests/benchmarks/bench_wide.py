"""Semi-global matching and PatchMatch on photos that stand far apart about a face.

    python -m tests.benchmarks.bench_wide [DEGREES ...] [--methods rule,sgbm,patchmatch]

Photos of 600 x 432 pixels in an arc of 120 degrees, 8 m from the middle of a face with joint steps,
so many degrees between neighbours; the cameras are true. Reported: processor seconds a photo, how
much of the maps is filled, distances from the truth in pixels on the rock, and the part of what two
photos see that has a point within 4 of these.
"""

from __future__ import annotations

import argparse
import time

import cv2
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
from vomstudio.photogrammetry.dense.depthmaps import depth_map, make_task
from vomstudio.photogrammetry.dense.fusion import fuse_depth_maps, neighbours_by_name
from vomstudio.photogrammetry.dense.pairs import select_pairs
from vomstudio.photogrammetry.dense.undistortion import UndistortTask, undistort

SIZE, FOCAL, DISTANCE, ARC = (600, 432), 550.0, 8.0, 120.0
GSD = DISTANCE / FOCAL


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("degrees", nargs="*", type=float, default=[18.0, 25.0, 35.0])
    parser.add_argument("--methods", default="rule,sgbm,patchmatch")
    args = parser.parse_args()
    face = lying_face(spacing=0.012)
    lens = Intrinsics.pinhole(*SIZE, FOCAL, SIZE[0] / 2, SIZE[1] / 2)
    for apart in args.degrees:
        count = int(ARC / apart) + 1
        rng = np.random.default_rng(2)
        photos = []
        for k in range(count):
            turn = np.radians(apart * (k - (count - 1) / 2))
            centre = DISTANCE * np.array([np.sin(turn), 0.0, np.cos(turn)])
            centre[1] = rng.normal(0, 0.5)
            target = rng.normal(0, 0.15, 3) * [1.0, 1.0, 0.0]
            view = look(f"{k:02d}.jpg", lens, centre, target, rng.normal(0, 2))
            picture = photograph(face, view, seed=k)[..., ::-1]
            photo = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 95])[1].tobytes()
            photos.append(undistort(UndistortTask(photo, None, view)))
        views = [photo.view for photo in photos]
        scene = tie_points(face, views, count=2500)
        truth = true_points(face, views, count=40_000, least=2)
        names = [view.name for view in views]
        print(f"{count} photos, {apart:g} degrees between neighbours", flush=True)
        for method in args.methods.split(","):
            pairs = select_pairs(scene, method=None if method == "rule" else method)
            begun = time.process_time()
            maps = [depth_map(make_task(plan, photos.__getitem__)) for plan in pairs.plans]
            used = (time.process_time() - begun) / len(maps)
            cloud = fuse_depth_maps(names, maps, photos, neighbours_by_name(scene, pairs))
            chosen = np.random.default_rng(0).permutation(len(cloud.points))[:40_000]
            median, most = accuracy(face, cloud.points[chosen])
            print(
                f"  {method:10s} {used:6.2f} s, {np.mean([m.filled for m in maps]):.2f} filled,"
                f" {len(cloud.points) / 1000:.0f} k points, median {median / GSD:.2f},"
                f" 95 % {most / GSD:.2f}, complete {completeness(cloud.points, truth, GSD):.3f}",
                flush=True,
            )


if __name__ == "__main__":
    main()
