"""Our alignment of made surveys beside COLMAP's incremental mapper with its defaults.

    python -m tests.benchmarks.bench_surveys [--pixels] [--keep FOLDER] [SURVEY ...]

Without --pixels, features are made: points of the face that a camera sees, known again within 50
degrees of view, with errors of 0.4 pixels; a survey then takes seconds. With --pixels photos are
rendered and the whole search runs. Both mappers get the same matches. Centres are compared after a
similarity, in pixels on the rock and in per cent of the extent of the true ones.
"""

from __future__ import annotations

import argparse
import shutil
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from tests.photogrammetry.made_photos import Finder, Made, MadePhoto
from tests.photogrammetry.surveys import SURVEYS, Survey
from vomstudio.errors import VomError
from vomstudio.geometry.similarity import fit_similarity
from vomstudio.photogrammetry.alignment import Alignment, Options, align
from vomstudio.photogrammetry.features import Features
from vomstudio.progress import Silent

SECTOR_DEG, NOISE_PX, SEEN = 50.0, 0.4, 0.7
HEAD = (
    f"{'survey':34s} {'photos':>6s} {'placed':>6s} {'peer':>5s} {'px':>7s} {'peer px':>8s} "
    f"{'%':>7s} {'peer %':>7s} {'focal':>14s} {'error':>6s} {'s':>5s}"
)


def made(survey: Survey, folder: Path, per_photo: int = 3000) -> Made:
    """What would be found in the photos."""
    rng = np.random.default_rng(1)
    face, folder = survey.face, folder / "photos"
    folder.mkdir(parents=True, exist_ok=True)
    points, normals = _shown(survey, per_photo, rng)
    start = rng.random(len(points)) * SECTOR_DEG
    looks = rng.integers(0, 90, (len(points), 128))
    photos, features = [], []
    for row, view in enumerate(survey.views):
        rays = points - view.centre
        reach = np.linalg.norm(rays, axis=1)
        rays /= reach[:, None]
        pixels = view.project(points) + rng.normal(0, NOISE_PX, (len(points), 2))
        seen = view.contains(np.nan_to_num(pixels, nan=-1.0)) & (view.depths(points) > 0)
        seen &= (rays * normals).sum(1) < -0.3
        seen &= face.hits(view.centre, rays)[0] > 0.98 * reach
        seen &= rng.random(len(points)) < SEEN
        rows = np.flatnonzero(seen)
        # A point looks another from elsewhere; straight down there is no such direction.
        azimuth = np.degrees(np.arctan2(rays[rows, 0], rays[rows, 1])) % 360
        azimuth[np.abs(normals[rows, 2]) > 0.7] = 0
        sector = ((azimuth + start[rows]) // SECTOR_DEG).astype(int)
        found = np.empty((len(rows), 128), np.int64)
        for number in np.unique(sector):
            mine = sector == number
            order = np.random.default_rng(number).permutation(128)
            found[mine] = looks[rows[mine]][:, order]
        found += rng.integers(-2, 3, found.shape)
        keypoints = np.zeros((len(rows), 6), np.float32)
        keypoints[:, :2] = pixels[rows]
        keypoints[:, [2, 5]] = 2.0
        path = folder / view.name
        path.write_bytes(view.name.encode())
        lens, said = view.intrinsics, survey.said[row]
        focal = None if said is None else round(said) / 36 * max(lens.width, lens.height)
        photos.append(MadePhoto(path, view.name, lens.width, lens.height, ("camera", focal), focal))
        grey = np.full((len(rows), 3), 150, np.uint8)
        descriptors = np.clip(found, 0, 255).astype(np.uint8)
        features.append(Features(keypoints, descriptors, grey, lens.width, lens.height))
    return Made(photos, features, list(survey.views), points)


def _shown(survey: Survey, per_photo: int, rng: np.random.Generator) -> tuple[Any, Any]:
    """Points of the face, so many that a photo shows about `per_photo`."""
    points, _ = survey.face.scattered(20_000, rng)
    shown = [
        view.contains(np.nan_to_num(view.project(points), nan=-1.0)).mean() for view in survey.views
    ]
    return survey.face.scattered(int(per_photo / max(np.median(shown), 0.01)), rng)


def pixel_on_rock(survey: Survey) -> float:
    points, _ = survey.face.scattered(3000, np.random.default_rng(0))
    sizes = []
    for view in survey.views:
        inside = view.contains(np.nan_to_num(view.project(points), nan=-1.0))
        sizes.append(np.median(view.depths(points)[inside]) / view.intrinsics.focal[0])
    return float(np.median(sizes))


def centre_error(names: list[str], centres: np.ndarray, survey: Survey) -> tuple[float, float]:
    """(median error, extent of the true centres), metres; NaN where they are too few."""
    true = {view.name: view.centre for view in survey.views}
    wanted = np.array([true[name] for name in names])
    try:
        fit = fit_similarity(centres, wanted)
    except VomError:
        return float("nan"), 1.0
    error = float(np.median(np.linalg.norm(fit(centres) - wanted, axis=1)))
    return error, 2 * float(np.linalg.norm(wanted - wanted.mean(0), axis=1).max())


def peer(work: Path, names: list[str], survey: Survey) -> tuple[int, float]:
    """(photos placed, median error of their centres) by COLMAP's defaults on our matches."""
    import pycolmap

    out = work / "peer"
    out.mkdir()
    options = pycolmap.IncrementalPipelineOptions()
    options.extract_colors = False
    found = pycolmap.incremental_mapping(work / "database.db", work, out, options)
    if not found:
        return 0, float("nan")
    best = max(found.values(), key=lambda r: r.num_reg_images())
    ids = sorted(best.reg_image_ids())
    centres = np.array([best.image(i).projection_center() for i in ids])
    return len(ids), centre_error([names[i - 1] for i in ids], centres, survey)[0]


def placed(survey: Survey, work: Path, pixels: bool) -> tuple[Alignment, list[str]]:
    if pixels:
        from vomstudio.io.photos import read_photos
        from vomstudio.jobs.executors import Threads

        photos = read_photos(survey.write(work / "photos")).photos
        alignment = align(photos, work, Options(), Threads(2), Silent())
        return alignment, [photo.name for photo in photos]
    features = made(survey, work)
    alignment = align(features.photos, work, Options(), Finder([features]), Silent())
    return alignment, [photo.name for photo in features.photos]


def row(survey: Survey, work: Path, pixels: bool) -> str:
    start = time.perf_counter()
    try:
        alignment, names = placed(survey, work, pixels)
    except VomError as error:
        return f"{survey.name:34s} {len(survey.views):6d} {'none':>6s}  {error.message}"
    seconds = time.perf_counter() - start
    part, size = alignment.parts[0], pixel_on_rock(survey)
    error, extent = centre_error([view.name for view in part.views], part.centres, survey)
    others, theirs = peer(work, names, survey)
    true = {view.name: view.intrinsics.focal[0] for view in survey.views}
    off = [c.values[0] / true[c.photos[0]] - 1 for c in alignment.cameras]
    worst = max(off, key=abs)
    how = "/".join(sorted({c.focal for c in alignment.cameras}))
    return (
        f"{survey.name:34s} {len(names):6d} {len(part.views):6d} {others:5d} {error / size:7.2f} "
        f"{theirs / size:8.2f} {100 * error / extent:7.3f} {100 * theirs / extent:7.3f} "
        f"{how:>7s} {100 * worst:+5.1f}% {alignment.reprojection_error_px:6.2f} {seconds:5.0f}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("surveys", nargs="*", metavar="SURVEY", help=", ".join(SURVEYS))
    parser.add_argument("--pixels", action="store_true", help="render the photos")
    parser.add_argument("--keep", type=Path, help="folder for photos and alignments")
    arguments = parser.parse_args()
    folder = arguments.keep or Path(tempfile.mkdtemp(prefix="vom-surveys-"))
    print(HEAD)
    try:
        for name in arguments.surveys or SURVEYS:
            work = folder / name
            shutil.rmtree(work / "peer", ignore_errors=True)
            work.mkdir(parents=True, exist_ok=True)
            print(row(SURVEYS[name](), work, arguments.pixels), flush=True)
    finally:
        if arguments.keep is None:
            shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main()
