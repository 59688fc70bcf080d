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

import numpy as np

from tests.photogrammetry.align.made_surveys import centre_error, made, pixel_on_rock
from tests.photogrammetry.align.surveys import SURVEYS, Survey
from tests.photogrammetry.made_photos import Finder
from vomstudio.core.errors import VomError
from vomstudio.core.progress import SilentProgress
from vomstudio.photogrammetry.align.alignment import Alignment, AlignmentOptions, align

HEAD = (
    f"{'survey':34s} {'photos':>6s} {'placed':>6s} {'peer':>5s} {'px':>7s} {'peer px':>8s} "
    f"{'%':>7s} {'peer %':>7s} {'focal':>14s} {'error':>6s} {'s':>5s}"
)


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
        from vomstudio.io.photos.reading import read_photos
        from vomstudio.studio.jobs.executors import Threads

        photos = read_photos(survey.write(work / "photos")).photos
        alignment = align(photos, work, AlignmentOptions(), Threads(2), SilentProgress())
        return alignment, [photo.name for photo in photos]
    features = made(survey, work)
    alignment = align(
        features.photos, work, AlignmentOptions(), Finder([features]), SilentProgress()
    )
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
