"""Camera centres of surveyed photos: RMS distance from the truth after the best similarity.

    python -m tests.benchmarks.bench_camera_centres FOLDER... [--size 2000] [--threads 2]

Each FOLDER is a set of Strecha et al. (2008) as in the repository
openMVG/SfM_quality_evaluation, with `images` and `gt_dense_cameras`.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.progress import SilentProgress
from vomstudio.io.photos.reading import read_photos
from vomstudio.photogrammetry.align.alignment import AlignmentOptions, align
from vomstudio.registration.similarity import fit_similarity
from vomstudio.studio.jobs.executors import Threads


def surveyed_centres(folder: Path) -> dict[str, FloatArray]:
    """Read the centres from the camera files: K, distortion, R, C and size, one row a line."""
    centres = {}
    for path in sorted(folder.glob("*.camera")):
        rows = path.read_text(encoding="ascii").split("\n")
        centres[path.name.removesuffix(".camera")] = np.array(rows[7].split(), np.float64)
    return centres


def measure(folder: Path, max_size: int, threads: int) -> str:
    """Align the photos of a set and describe the errors of its camera centres, in one line."""
    surveyed = surveyed_centres(folder / "gt_dense_cameras")
    photos = read_photos(folder / "images").photos
    options = AlignmentOptions(max_size=max_size, threads=threads)
    start = time.perf_counter()
    with tempfile.TemporaryDirectory(prefix="vom-centres-") as work:
        alignment = align(photos, Path(work), options, Threads(threads), SilentProgress())
    seconds = time.perf_counter() - start
    part = alignment.parts[0]
    truth = np.array([surveyed[view.name] for view in part.views])
    error = np.linalg.norm(fit_similarity(part.centres, truth)(part.centres) - truth, axis=1)
    rms_mm = 1000.0 * float(np.sqrt(np.mean(error**2)))
    return (
        f"{folder.name:18s} {len(part.views):4d} of {len(photos):3d} {rms_mm:9.2f} "
        f"{1000.0 * float(error.max()):9.2f} {seconds:7.1f} s"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folders", nargs="+", type=Path, metavar="FOLDER")
    parser.add_argument("--size", type=int, default=2000, help="long side of the photos, pixels")
    parser.add_argument("--threads", type=int, default=2)
    arguments = parser.parse_args()
    print(f"{'set':18s} {'photos':>11s} {'RMS, mm':>9s} {'max, mm':>9s} {'time':>9s}")
    for folder in arguments.folders:
        print(measure(folder, arguments.size, arguments.threads), flush=True)


if __name__ == "__main__":
    main()
