"""Our alignment beside the COLMAP that Debian ships (3.8, CPU), on the same photos.

    python -m tests.benchmarks.bench_alignment FOLDER [--size 1600] [--threads 2] [--rounds 2]

Both run in processes of their own, one after the other, every second round the other way round;
wall and processor seconds are of those. Both look for the same number of features.
Tie points of track 3 or more and the mean reprojection error are counted the same way for both,
from COLMAP's binary models.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any


def timed(commands: list[list[str]], folder: Path) -> tuple[float, float]:
    """(wall, processor) seconds of commands run one after the other."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    start = time.perf_counter()
    for command in commands:
        environment = {**os.environ, "QT_QPA_PLATFORM": "offscreen"}
        with (folder / "log.txt").open("a") as log:
            subprocess.run(command, check=True, stdout=log, stderr=log, env=environment)
    wall = time.perf_counter() - start
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return wall, used


def counted(model: Path) -> dict[str, Any]:
    import pycolmap

    reconstruction = pycolmap.Reconstruction(model)
    reconstruction.update_point_3d_errors()
    lengths = [p.track.length() for p in reconstruction.points3D.values()]
    return {
        "photos": reconstruction.num_reg_images(),
        "points": len(lengths),
        "track 3 or more": sum(n >= 3 for n in lengths),
        "error px": round(reconstruction.compute_mean_reprojection_error(), 3),
        "focal px": [round(c.params[0], 1) for c in reconstruction.cameras.values()][:3],
    }


def debian(images: Path, names: list[str], work: Path, size: int, threads: int) -> dict[str, Any]:
    from vomstudio.photogrammetry.align.features import MAX_FEATURES

    database, sparse, listed = work / "colmap.db", work / "sparse", work / "images.txt"
    sparse.mkdir()
    listed.write_text("\n".join(names) + "\n")
    count = str(threads)
    common = ["--database_path", str(database)]
    wall, used = timed(
        [
            ["colmap", "feature_extractor", *common, "--image_path", str(images)]
            + ["--image_list_path", str(listed), "--SiftExtraction.use_gpu", "0"]
            + ["--SiftExtraction.max_image_size", str(size)]
            + ["--SiftExtraction.max_num_features", str(MAX_FEATURES)]
            + ["--SiftExtraction.num_threads", count],
            ["colmap", "exhaustive_matcher", *common, "--SiftMatching.use_gpu", "0"]
            + ["--SiftMatching.num_threads", count],
            ["colmap", "mapper", *common, "--image_path", str(images)]
            + ["--output_path", str(sparse), "--Mapper.num_threads", count],
        ],
        work,
    )
    models = [counted(folder) for folder in sorted(sparse.iterdir()) if folder.is_dir()]
    best = max(models, key=lambda m: m["photos"], default={})
    return {"wall s": round(wall, 1), "cpu s": round(used, 1), **best}


def ours(images: Path, work: Path, size: int, threads: int) -> dict[str, Any]:
    code = (
        "import sys; from pathlib import Path\n"
        "from vomstudio.io.photos.reading import read_photos\n"
        "from vomstudio.studio.jobs.executors import Threads\n"
        "from vomstudio.photogrammetry.align.alignment import AlignmentOptions, align\n"
        "from vomstudio.core.progress import SilentProgress\n"
        "photos = read_photos(Path(sys.argv[1])).photos\n"
        "size, threads = int(sys.argv[3]), int(sys.argv[4])\n"
        "align(photos, Path(sys.argv[2]),\n"
        "      AlignmentOptions(max_size=size, threads=threads),\n"
        "      Threads(threads), Silent())\n"
    )
    command = [sys.executable, "-c", code, str(images), str(work / "ours"), str(size)]
    wall, used = timed([[*command, str(threads)]], work)
    found = counted(work / "ours" / "part0" / "colmap")
    return {"wall s": round(wall, 1), "cpu s": round(used, 1), **found}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--size", type=int, default=1600)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--rounds", type=int, default=2)
    arguments = parser.parse_args()
    from vomstudio.io.photos.reading import read_photos

    names = [photo.name for photo in read_photos(arguments.folder).photos]
    if not shutil.which("colmap"):
        print("Debian's COLMAP is not installed: no peer")
    for number in range(arguments.rounds):
        with tempfile.TemporaryDirectory(prefix="vom-bench-") as folder:
            work = Path(folder)
            sizes = (work, arguments.size, arguments.threads)
            runs = {"ours": lambda s=sizes: ours(arguments.folder, *s)}
            if shutil.which("colmap"):
                runs["Debian's COLMAP"] = lambda s=sizes: debian(arguments.folder, names, *s)
            order = list(runs) if number % 2 == 0 else list(runs)[::-1]
            print(json.dumps({name: runs[name]() for name in order}, indent=1), flush=True)


if __name__ == "__main__":
    main()
