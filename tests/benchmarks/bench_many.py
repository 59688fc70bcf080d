"""Processor seconds of each step after the alignment, for growing numbers of photos.

    python -m tests.benchmarks.bench_many [COUNT ...]

The made photos of bench_whole with their true cameras, so that nothing but the number changes.
Last, what a step takes for a photo of the largest set over what it takes for one of the smallest:
1 where a step grows with the photos, and the larger the less it scales.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from tests.benchmarks.bench_whole import render, stations
from tests.photogrammetry.dense.dense_truth import lying_face, tie_points
from vomstudio.core.progress import SilentProgress
from vomstudio.photogrammetry.align.scene_check import check_scene
from vomstudio.photogrammetry.base.memory import peak_bytes
from vomstudio.photogrammetry.dense.depthmaps import depth_map, make_task
from vomstudio.photogrammetry.dense.fusion import fuse_depth_maps, neighbours_by_name
from vomstudio.photogrammetry.dense.pairs import select_pairs
from vomstudio.photogrammetry.dense.undistortion import UndistortTask, undistort
from vomstudio.photogrammetry.surface import meshing, texture
from vomstudio.photogrammetry.surface.atlas import AtlasOptions
from vomstudio.studio.jobs.executors import Threads

DENSE_PX, FACES_EACH = 320, 300


class Stages(SilentProgress):
    """Processor seconds of what is reported as a stage."""

    def __init__(self, prefix: str, into: dict[str, float]) -> None:
        super().__init__()
        self._prefix, self._into = prefix, into
        self._name, self._begun = "", time.process_time()

    def stage(self, name: str, total: int | None = None) -> None:
        now = time.process_time()
        if self._name:
            self._into[self._name] = self._into.get(self._name, 0.0) + now - self._begun
        self._name, self._begun = f"{self._prefix}: {name.split(' (')[0]}"[:60], now


def run(count: int) -> dict[str, float]:
    folder = Path(tempfile.gettempdir(), "vom-many", str(count))
    render(folder, count)
    views, extent = stations(count)
    taken: dict[str, float] = {}

    def timed(name: str, work: Callable[[], Any]) -> Any:
        begun = time.process_time()
        result = work()
        taken[name] = time.process_time() - begun
        return result

    scene = tie_points(lying_face(extent, 0.05), views, count=60 * count)
    photos = [(folder / view.name).read_bytes() for view in views]
    timed("check", lambda: check_scene(scene))
    straight = timed(
        "straighten",
        lambda: [
            undistort(UndistortTask(p, None, v, DENSE_PX))
            for p, v in zip(photos, views, strict=True)
        ],
    )
    pairs = timed("pairs", lambda: select_pairs(scene))
    tasks = [make_task(plan, straight.__getitem__) for plan in pairs.plans]
    maps = timed("depths", lambda: [depth_map(task) for task in tasks])
    names = [scene.views[plan.view].name for plan in pairs.plans]
    mine = [straight[plan.view] for plan in pairs.plans]
    around = neighbours_by_name(scene, pairs)
    cloud = timed("fuse", lambda: fuse_depth_maps(names, maps, mine, around))
    options = meshing.MeshingOptions(faces=FACES_EACH * count, threads=2)
    steps = Stages("surface", taken)
    mesh = meshing.build_surface(cloud, options, steps, scene.centres).mesh
    steps.stage("")
    steps = Stages("texture", taken)
    of_texture = texture.TextureOptions(atlas=AtlasOptions(page=2048, max_pages=1))
    sources = [undistort(UndistortTask(p, None, v)) for p, v in zip(photos, views, strict=True)]
    texture.make_texture(mesh, sources, of_texture, Threads(2), steps)
    steps.stage("")
    print(
        f"{count} photos, {len(cloud.points):,} points, {len(mesh.faces):,} faces,"
        f" {peak_bytes() / 1e6:.0f} MB",
        flush=True,
    )
    return taken


def main() -> None:
    counts = sorted(int(word) for word in sys.argv[1:]) or [50, 100, 200]
    run(6)
    found = [run(count) for count in counts]
    print(f"{'':62s}" + "".join(f"{count:9d}" for count in counts))
    for name in found[-1]:
        row = [one.get(name, np.nan) for one in found]
        each = row[-1] / counts[-1] / max(row[0] / counts[0], 1e-3)
        print(f"{name:62s}" + "".join(f"{value:9.2f}" for value in row) + f"   x {each:.1f}")


if __name__ == "__main__":
    main()
