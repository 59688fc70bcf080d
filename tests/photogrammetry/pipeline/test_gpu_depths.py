"""The GPU is used where it can be, and its failure costs nobody the model."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from tests.messages import refused
from tests.photogrammetry.dense.dense_truth import look, lying_face, tie_points
from tests.photogrammetry.rock_face import photograph
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import SilentProgress
from vomstudio.geometry.cameras import Intrinsics
from vomstudio.photogrammetry.base.settings import PipelineSettings
from vomstudio.photogrammetry.dense.colmap_workspace import has_cuda
from vomstudio.photogrammetry.dense.pairs import select_pairs
from vomstudio.photogrammetry.dense.undistortion import UndistortedPhoto, UndistortTask, undistort
from vomstudio.photogrammetry.pipeline.gpu_depths import choose_device, compute_gpu_depths
from vomstudio.photogrammetry.pipeline.stage_log import StageLog

without_gpu = pytest.mark.skipif(has_cuda(), reason="This COLMAP can use a GPU.")


def test_unknown_device_is_rejected() -> None:
    with refused("option.not-a-choice", UsageError):
        PipelineSettings(device="gpu")


@without_gpu
def test_auto_selects_the_cpu_without_cuda_and_cuda_is_rejected_early() -> None:
    assert choose_device(PipelineSettings()) == "cpu"
    assert choose_device(PipelineSettings(device="cpu")) == "cpu"
    with refused("gpu.unavailable", GeometryError):
        choose_device(PipelineSettings(device="cuda"))


@without_gpu
def test_gpu_failure_is_reported_and_the_cpu_takes_over(tmp_path: Path) -> None:
    face = lying_face(size=(6.0, 5.0), spacing=0.05)
    lens = Intrinsics.pinhole(160, 120, 150.0, 80.0, 60.0)
    centres = np.array([[x, 0.0, 4.0] for x in (-0.5, 0.0, 0.5)])
    views = [look(f"{i}.png", lens, c, [*c[:2], 0.0]) for i, c in enumerate(centres)]
    scene = tie_points(face, views, count=400)
    photos = [_photo(face, view) for view in views]
    pairs = select_pairs(scene)
    put: list[Any] = []

    def log() -> StageLog:
        return StageLog(tmp_path / "log.txt", SilentProgress())

    first = log()
    assert not compute_gpu_depths(scene, pairs, photos, put.append, PipelineSettings(), first)  # type: ignore[arg-type]
    assert not put
    (finding,) = first.notes
    assert isinstance(finding, Finding)
    assert (finding.code, finding.severity) == ("gpu.failed", "warning")
    with refused("gpu.failed", GeometryError):
        compute_gpu_depths(scene, pairs, photos, put.append, PipelineSettings(device="cuda"), log())  # type: ignore[arg-type]


def _photo(face: Any, view: Any) -> UndistortedPhoto:

    pixels = photograph(face, view, samples=1, seed=1)
    png = cv2.imencode(".png", np.ascontiguousarray(pixels[..., ::-1]))[1].tobytes()
    return undistort(UndistortTask(png, None, view, None, True))
