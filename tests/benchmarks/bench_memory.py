"""What the work on one photo takes at its peak, beside what is reckoned with beforehand.

    python -m tests.benchmarks.bench_memory [STEP ...]

STEP is features, straight, depths or look. Each figure is of a process of its own: the most it held
less what it held before the photo, of which the encoded photos are a part.
"""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import numpy as np

from vomstudio.geometry.cameras import Intrinsics
from vomstudio.photogrammetry.base.memory import peak_bytes

SIZES = ((1600, 1200), (4000, 3000), (12000, 9000))
DENSE = (1000, 3200, 12000)


def encoded(width: int, height: int) -> bytes:
    import cv2

    rng = np.random.default_rng(1)
    small = rng.integers(0, 255, (height // 4, width // 4, 3), np.uint8)
    picture = cv2.resize(small, (width, height), interpolation=cv2.INTER_CUBIC)
    return cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 90])[1].tobytes()


def viewed(name: str, width: int, height: int, k: float = 0.0, x: float = 0.0):  # type: ignore[no-untyped-def]
    from vomstudio.geometry.cameras import View

    focal = 0.9 * width
    params = (focal, width / 2, height / 2, k)
    lens = Intrinsics("SIMPLE_RADIAL", width, height, params)
    if not k:
        lens = Intrinsics.pinhole(width, height, focal, width / 2, height / 2)
    return View(name, lens, np.eye(3), np.array([-x, 0.0, 0.0]))


def of_features(width: int, height: int, size: int) -> tuple[Any, int]:
    from vomstudio.photogrammetry.align.features import (
        ExtractionTask,
        FeatureOptions,
        extract_features,
        extraction_memory,
    )

    options = FeatureOptions(max_size=size)
    extract_features(ExtractionTask(encoded(200, 160), None, options))
    task = ExtractionTask(encoded(width, height), None, options)
    return lambda: extract_features(task), extraction_memory(width, height, options)


def of_straight(width: int, height: int, size: int) -> tuple[Any, int]:
    from vomstudio.photogrammetry.dense import undistortion as u

    def task(w: int, h: int) -> u.UndistortTask:
        import cv2

        mask = cv2.imencode(".png", np.tri(h, w, dtype=np.uint8) * np.uint8(255))[1].tobytes()
        return u.UndistortTask(encoded(w, h), mask, viewed("a", w, h, -0.05), size)

    u.undistort(task(400, 300))
    whole = task(width, height)
    return lambda: u.undistort(whole), u.peak_memory_bytes(width, height, size)


def of_depths(width: int, height: int, size: int) -> tuple[Any, int]:
    from vomstudio.photogrammetry.dense import depthmaps
    from vomstudio.photogrammetry.dense.undistortion import UndistortedPhoto

    method = "patchmatch" if size == 1000 else "sgbm"
    w, h = size, round(size * height / width)

    def task(w: int, h: int) -> depthmaps.DepthTask:
        photo = encoded(w, h)
        photos = [UndistortedPhoto(photo, None, viewed(str(x), w, h, x=0.3 * x)) for x in range(5)]
        points = np.random.default_rng(0).uniform([-3, -2, 4.8], [3, 2, 5.2], (500, 3))
        return depthmaps.DepthTask(photos[0], tuple(photos[1:]), (method,) * 4, 4.0, 6.0, points)

    depthmaps.depth_map(task(320, 240))
    whole = task(w, h)
    return lambda: depthmaps.depth_map(whole), depthmaps.peak_memory_bytes(w, h)


def of_look(width: int, height: int, size: int) -> tuple[Any, int]:
    from vomstudio.photogrammetry.surface import visibility

    n = size // 4
    x, y = np.meshgrid(np.linspace(-2.0, 2.0, n), np.linspace(-1.5, 1.5, n))
    vertices = np.stack([x, y, 4.0 + 0 * x], -1).reshape(-1, 3)
    i = np.arange(n * n).reshape(n, n)
    a, b, c, d = (k.ravel() for k in (i[:-1, :-1], i[:-1, 1:], i[1:, :-1], i[1:, 1:]))
    faces = np.concatenate([np.stack([a, c, b], 1), np.stack([b, c, d], 1)]).astype(np.int32)

    def task(w: int, h: int, faces: np.ndarray) -> visibility.VisibilityTask:
        return visibility.VisibilityTask(encoded(w, h), None, viewed("a", w, h), vertices, faces)

    visibility.compute_visibility(task(400, 300, faces[:100]))
    whole = task(width, height, faces)
    return lambda: visibility.compute_visibility(whole), visibility.peak_memory_bytes(
        width, height, len(faces)
    )


STEPS = {"features": of_features, "straight": of_straight, "depths": of_depths, "look": of_look}


def one(step: str, width: int, height: int, size: int) -> None:
    import psutil

    work, reckoned = STEPS[step](width, height, size)
    before = psutil.Process().memory_info().rss
    highest = peak_bytes()
    kept = work()
    held = peak_bytes() - before
    del kept
    sign = "" if peak_bytes() > highest else " (at most)"
    print(
        f"{step:9s} {width} x {height}, {size} px: {held / 1e6:6.0f} MB{sign},"
        f" reckoned {reckoned / 1e6:6.0f} MB",
        flush=True,
    )


def main() -> None:
    words = sys.argv[1:]
    if len(words) == 4:
        return one(words[0], *map(int, words[1:]))
    for step in words or STEPS:
        for width, height in SIZES:
            for size in DENSE:
                if size > width or (step in ("depths", "features") and size > 3200):
                    continue
                if step == "depths" and width != 4000:
                    continue
                name = "tests.benchmarks.bench_memory"
                command = [sys.executable, "-m", name, step, str(width), str(height), str(size)]
                subprocess.run(command, check=False)


if __name__ == "__main__":
    main()
