"""The whole way from photos to the model: seconds, processor seconds and memory of each stage.

    python -m tests.benchmarks.bench_whole [PHOTOS] [--count 200] [--quality preview] [--threads N]

Without a folder of photos, a set of `count` photos of 640 x 480 along a made face is rendered (kept
in --into for the next time): three rows, 8 m before it, each place in 20 or more of them, with GPS.
Stages are those of the log, "-" is what lies between two of them.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import cv2
import numpy as np
import psutil

from tests.io.photos import photo_maker
from tests.photogrammetry.dense.dense_truth import look, lying_face
from tests.photogrammetry.surface.wall_maker import gps_fields
from vomstudio.geometry.cameras import Intrinsics, View

ROWS, DISTANCE, SPACING = 3, 8.0, 0.7
SIZE, FOCAL = (640, 480), 560.0
TEXEL = 0.5 * DISTANCE / FOCAL


def stations(count: int) -> tuple[list[View], tuple[float, float]]:
    """Cameras along the face, and its width and height."""
    columns = -(-count // ROWS)
    lens = Intrinsics.pinhole(*SIZE, FOCAL, SIZE[0] / 2, SIZE[1] / 2)
    rng = np.random.default_rng(4)
    views = []
    for k in range(count):
        column, row = divmod(k, ROWS)
        centre = np.array([(column - (columns - 1) / 2) * SPACING, 1.6 * (row - 1), DISTANCE])
        centre += rng.normal(0.0, [0.1, 0.1, 0.2])
        aside = 2.2 * (row - 1) + rng.normal(0.0, 0.2)
        target = np.array([centre[0] + aside, 0.5 * centre[1], 0.0])
        views.append(look(f"m{k:03d}.jpg", lens, centre, target, 2.0 * math.sin(k)))
    return views, (columns * SPACING + 10.0, 11.0)


def render(folder: Path, count: int) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    views, extent = stations(count)
    if all((folder / view.name).exists() for view in views):
        return
    face, paint = lying_face(extent, 0.02), painted(extent)
    for k, view in enumerate(views):
        picture = drawn(face, paint, extent, view, np.random.default_rng(k))
        photo_maker.write_photo(
            folder / view.name,
            pixels=picture,
            main={0x010F: photo_maker.text("Acme"), 0x0110: photo_maker.text("Wall 1")},
            exif={
                0x920A: photo_maker.rational(20.0),
                0xA405: photo_maker.rational(round(FOCAL / SIZE[0] * 36)),
            },
            gps=gps_fields(view.centre, 0.05),
        )


def painted(extent: tuple[float, float]) -> np.ndarray:
    """Grey rock with detail of every size, as seen from before the face."""
    rng = np.random.default_rng(3)
    width, height = (math.ceil(length / TEXEL) for length in extent)
    total = np.zeros((height, width), np.float32)
    for k in range(8):
        size = 2**k
        noise = rng.normal(size=(height // size + 2, width // size + 2)).astype(np.float32)
        total += cv2.resize(noise, (width, height), interpolation=cv2.INTER_CUBIC) * size**0.5
    return (total - total.mean()) / total.std() * 38 + 120


def drawn(face, paint, extent, view, rng):  # type: ignore[no-untyped-def]
    """(h, w, 3) one ray for each pixel: fast, and good enough for figures of time and memory."""
    width, height = SIZE
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    rays = view.rays(np.stack([x, y], axis=-1).reshape(-1, 2))
    far, normal = face.hits(view.centre, rays)
    hit = np.isfinite(far)
    points = view.centre + rays * np.where(hit, far, 0.0)[:, None]
    at = (points[:, :2] + np.array(extent) / 2) / TEXEL
    at = at.astype(np.float32).reshape(height, width, 2)
    grey = cv2.remap(paint, at[..., 0], at[..., 1], cv2.INTER_LINEAR)
    shade = 0.6 + 0.4 * np.clip(normal @ [0.48, 0.58, 0.66], 0, 1)
    grey = np.where(hit, grey.ravel() * shade, 205.0).reshape(height, width)
    colour = grey[..., None] * [1.03, 0.96, 0.88] + rng.normal(0, 1.5, (height, width, 1))
    return np.clip(np.rint(colour), 0, 255).astype(np.uint8)


def watched(command: list[str], log: Path) -> tuple[int, dict[str, list[float]]]:
    """Return code, and of each stage of the log: seconds, processor seconds, most bytes held."""
    stages: dict[str, list[float]] = {}
    running = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    stage, before = "-", 0.0
    then = time.monotonic()
    while running.poll() is None:
        time.sleep(0.2)
        try:
            family = [psutil.Process(running.pid)]
            family += family[0].children(recursive=True)
            held = sum(p.memory_info().rss for p in family)
            used = sum(sum(p.cpu_times()[:2]) for p in family)
        except psutil.Error:
            continue
        now = time.monotonic()
        row = stages.setdefault(stage, [0.0, 0.0, 0.0])
        row[0] += now - then
        row[1] += max(used - before, 0.0)
        row[2] = max(row[2], held)
        then, before = now, used
        stage = current(log)
    return running.returncode, stages


def current(log: Path) -> str:
    try:
        last = log.read_text(encoding="utf-8").splitlines()[-1].partition("  ")[2]
    except (OSError, IndexError):
        return "-"
    return "-" if last.endswith(" s") else last.split(" (")[0]


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("photos", nargs="?", type=Path)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--into", type=Path, default=Path(tempfile.gettempdir(), "vom-many"))
    parser.add_argument("--out", type=Path, help="the reconstruction; kept where it is named")
    parser.add_argument("--quality", default="preview")
    parser.add_argument("--threads", type=int)
    args = parser.parse_args()
    photos = args.photos
    if photos is None:
        photos = args.into / str(args.count)
        render(photos, args.count)
    with tempfile.TemporaryDirectory() as scratch:
        out = args.out or Path(scratch, "out")
        command = [sys.executable, "-m", "vomstudio", "reconstruct", str(photos), "-o", str(out)]
        command += ["--quality", args.quality, "--json"]
        command += ["--threads", str(args.threads)] if args.threads else []
        code, stages = watched(command, out / "log.txt")
        for name, (wall, used, held) in stages.items():
            print(f"{name:60s} {wall:7.1f} s {used:7.1f} s cpu {held / 1e6:7.0f} MB")
        total = np.array(list(stages.values()))
        print(f"{'all':60s} {total[:, 0].sum():7.1f} s {total[:, 1].sum():7.1f} s cpu", end="")
        print(f" {total[:, 2].max() / 1e6:7.0f} MB, return code {code}")
        if code == 0:
            made = json.loads((out / "reconstruction.json").read_text(encoding="utf-8"))
            for key in ("photos", "registered", "dense_points", "faces", "peak_memory_mb"):
                print(f"{key}: {made[key]}")
            for path in sorted(out.iterdir()):
                if path.is_file():
                    print(f"{path.name}: {path.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
