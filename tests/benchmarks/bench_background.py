"""Detail on the rock with a building behind it: shares of faces, texels, completeness, time.

    python -m tests.benchmarks.bench_background [--times 6] [--quality low] [--ground] [--none]
        [--root FOLDER ...] [--keep FOLDER]

The building is at so many times the distance of the rock. --ground adds level ground between both,
--none omits the building. Each FOLDER of --root is a version of the program to be compared, by
default this one. --keep keeps the results.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from tests.photogrammetry import rock_face
from tests.photogrammetry.align.surveys import Survey
from tests.photogrammetry.building_scene import DISTANCE, FOCAL, building_scene, views
from vomstudio.core.arrays import FloatArray
from vomstudio.geometry.cameras import View
from vomstudio.io.models.opening import read_model
from vomstudio.io.photos.cameras_file import read_cameras
from vomstudio.registration.similarity import fit_similarity

ROOT = Path(__file__).resolve().parents[2]


def best_pixels(face: rock_face.Face, views: list[View], points: FloatArray) -> FloatArray:
    """Return the pixel size (n,) of the best photo of each point, infinity if none shows it."""
    pixels = np.full(len(points), np.inf)
    for view in views:
        inside = view.contains(np.nan_to_num(view.project(points), nan=-1.0))
        reach, _ = face.hits(view.centre, points - view.centre)
        is_seen = inside & (reach > 0.99)
        size = np.linalg.norm(points - view.centre, axis=1) / view.intrinsics.focal[0]
        pixels[is_seen] = np.minimum(pixels[is_seen], size[is_seen])
    return pixels


def measure(out: Path, survey: Survey) -> str:
    """Describe a finished reconstruction in one line."""
    cameras = read_cameras(out / "cameras.json")
    truth = {view.name: view.centre for view in survey.views}
    made = np.array([view.centre for view in cameras.views]) + cameras.origin
    known = np.array([truth[view.name] for view in cameras.views])
    similarity = fit_similarity(made, known)
    mesh = read_model(out / "model.obj").data
    vertices = similarity(mesh.vertices)
    corners = vertices[mesh.faces]
    centre = corners.mean(axis=1)
    is_rock = centre[:, 1] < 2.5
    area = (
        np.linalg.norm(
            np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
        )
        / 2
    )
    pages = np.repeat(np.arange(len(mesh.materials)), np.diff(mesh.material_offsets))
    from PIL import Image

    sizes = np.array([Image.open(m.texture).size for m in mesh.materials])
    uv = mesh.uv[mesh.faces].astype(np.float64) * sizes[pages][:, None]
    a, b = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    texels = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2
    ratio = np.sqrt(area / np.maximum(texels, 1e-12)) / best_pixels(
        survey.face, list(survey.views), centre
    )
    use = is_rock & (ratio > 0)
    order = np.argsort(ratio[use])
    sums = np.cumsum(area[use][order])
    texel90 = ratio[use][order][np.searchsorted(sums, 0.9 * sums[-1])]
    points, _ = survey.face.scattered(400_000, np.random.default_rng(1))
    points = points[points[:, 1] < 2.5]
    seen = np.zeros(len(points), int)
    for view in survey.views:
        inside = view.contains(np.nan_to_num(view.project(points), nan=-1.0))
        seen += inside & (survey.face.hits(view.centre, points - view.centre)[0] > 0.999)
    surface = rock_face.Face(vertices, mesh.faces.astype(np.int32), survey.face.paint)
    off = surface.distance(points[seen >= 2])
    pixel = DISTANCE / survey.views[0].intrinsics.focal[0]
    result = json.loads((out / "reconstruction.json").read_text())
    mb = sum(p.stat().st_size for p in out.glob("model*")) / 1e6
    return (
        f"{len(mesh.faces):7,d} faces, {100 * is_rock.mean():5.1f} % on the rock;"
        f" texel {texel90:.2f} px at 90 %;"
        f" complete within 4 px {100 * np.mean(off < 4 * pixel):.2f} %,"
        f" 10 px {100 * np.mean(off < 10 * pixel):.2f} %, median {np.median(off) / pixel:.2f} px;"
        f" {sum(result['seconds'].values()):.0f} s, {result['peak_memory_mb']} MB,"
        f" files {mb:.0f} MB; background {result.get('background_share')}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--times", type=float, default=6.0)
    parser.add_argument("--quality", default="low")
    parser.add_argument("--columns", type=int, default=5, help="photos in each of two rows")
    parser.add_argument("--width", type=int, default=900, help="of the photos, pixels")
    parser.add_argument("--ground", action="store_true")
    parser.add_argument("--none", action="store_true")
    parser.add_argument("--root", nargs="*", type=Path, default=[ROOT])
    parser.add_argument("--keep", type=Path)
    arguments = parser.parse_args()
    times = None if arguments.none else arguments.times
    face = building_scene(times, ground=arguments.ground)
    photos = tuple(views(arguments.columns, arguments.width))
    survey = Survey("background", face, photos, (36 * FOCAL / 1296,) * len(photos))
    with tempfile.TemporaryDirectory(prefix="vom-background-") as temporary:
        folder = arguments.keep or Path(temporary)
        photo_folder = survey.write(folder / "photos")
        for root in arguments.root:
            for words in ([], ["--keep-background"]):
                if words and root.resolve() != ROOT:
                    continue
                out = folder / "-".join(["out", root.resolve().name, arguments.quality, *words])
                command = ["reconstruct", str(photo_folder), "-o", str(out), "--threads", "1"]
                command += ["--quality", arguments.quality, *words]
                start = time.perf_counter()
                done = subprocess.run(
                    [sys.executable, "-m", "vomstudio", *command],
                    cwd=root,
                    env={**os.environ, "PYTHONPATH": str(root)},
                    capture_output=True,
                    text=True,
                    check=False,
                )
                if done.returncode:
                    print(done.stderr[-2000:])
                    continue
                print(
                    f"{out.name}, {time.perf_counter() - start:.0f} s: {measure(out, survey)}",
                    flush=True,
                )


if __name__ == "__main__":
    main()
