"""Depth maps on a GPU, if the installed COLMAP supports it."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.photogrammetry.base.settings import PipelineSettings
from vomstudio.photogrammetry.dense.colmap_workspace import compute_cuda_depth_maps, has_cuda

if TYPE_CHECKING:
    from vomstudio.photogrammetry.base.scene import SparseScene
    from vomstudio.photogrammetry.dense.depthmaps import DepthMap
    from vomstudio.photogrammetry.dense.pairs import DepthMapPlans
    from vomstudio.photogrammetry.dense.undistortion import UndistortedPhoto
    from vomstudio.photogrammetry.pipeline.stage_log import StageLog


def choose_device(settings: PipelineSettings) -> str:
    """Return the device of depth maps, "cpu" or "cuda".

    Raises GeometryError if "cuda" is requested and not supported.
    """
    if settings.device == "cpu":
        return "cpu"
    if has_cuda():
        return "cuda"
    if settings.device == "cuda":
        raise GeometryError(
            Finding("gpu.unavailable"),
            field="device",
        )
    return "cpu"


def compute_gpu_depths(
    scene: SparseScene,
    pairs: DepthMapPlans,
    photos: Sequence[UndistortedPhoto],
    put: Callable[[int, DepthMap], None],
    settings: PipelineSettings,
    log: StageLog,
) -> bool:
    """Compute the map of each plan on the GPU and pass it to `put`.

    Returns True if successful. If the GPU fails, logs a note and returns False, or raises
    GeometryError if the device "cuda" was requested. Raises Cancelled.
    """
    log.stage(tr("Computing depth maps on the GPU"), len(pairs.plans))
    try:
        with tempfile.TemporaryDirectory(prefix="vomstudio-") as folder:
            for number, depth_map in enumerate(
                compute_cuda_depth_maps(scene, pairs, photos, Path(folder), log)
            ):
                put(number, depth_map)
    # COLMAP raises these for a GPU without driver or memory.
    except (RuntimeError, ValueError) as error:
        reason = (str(error).strip() or type(error).__name__).splitlines()[-1]
        if settings.device == "cuda":
            raise GeometryError(Finding("gpu.failed", "error", reason=reason)) from error
        log.note(Finding("gpu.failed", reason=reason))
        return False
    return True
