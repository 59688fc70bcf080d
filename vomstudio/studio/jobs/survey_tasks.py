"""Jobs before a reconstruction: extraction of video frames, and a forecast."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vomstudio.core.findings import Finding, to_finding
from vomstudio.core.progress import Progress
from vomstudio.photogrammetry.pipeline.memory_estimate import MemoryRequirement, estimate_memory
from vomstudio.photogrammetry.survey.survey_options import VideoFrameOptions
from vomstudio.photogrammetry.survey.video import FrameReport, take_frames
from vomstudio.studio.jobs import serialisation
from vomstudio.studio.jobs.job import Job, Lane


@dataclass(frozen=True)
class FramesRequest:
    """Request to write frames of `video` to `out`; `force` allows other files in `out`."""

    video: Path
    out: Path
    options: VideoFrameOptions
    force: bool


def _extract_frames(request: FramesRequest, progress: Progress) -> FrameReport:
    return take_frames(
        request.video, request.out, fps=request.options.fps, force=request.force, progress=progress
    )


EXTRACT_FRAMES = Job("take_frames", Lane.PHOTOS, FramesRequest, FrameReport, _extract_frames)
"""Write the usable frames of a video."""


@dataclass(frozen=True)
class ForecastRequest:
    """Request for the forecast of a reconstruction of the folder `photos` with these settings.

    `sizes` contains the width and height of each photo, which the caller has already read.
    """

    photos: Path
    sizes: tuple[tuple[int, int], ...]
    quality: str
    crs: str | None = None
    control: Path | None = None
    marks: Path | None = None
    threads: int | None = None


@dataclass(frozen=True)
class PointSummary:
    """Check of a control point; see `PointCheck`."""

    label: str
    use: str
    photos: int
    quality: str


@dataclass(frozen=True)
class ControlSummary:
    """Check of all control points; see `ControlCheck`. `problem` includes read errors."""

    points: tuple[PointSummary, ...]
    crs: str | None
    crs_reason: Finding | None
    summary: Finding | None
    problem: Finding | None
    warnings: tuple[Finding, ...]


@dataclass(frozen=True)
class ReconstructionForecast:
    """Forecast of a reconstruction: memory (None if there are no photos) and control points."""

    memory: MemoryRequirement | None
    control: ControlSummary | None


def _forecast(request: ForecastRequest, progress: Progress) -> ReconstructionForecast:
    from vomstudio.core.errors import VomError
    from vomstudio.io.photos.reading import read_photos
    from vomstudio.photogrammetry.base.settings import PipelineSettings

    settings = PipelineSettings(quality=request.quality, threads=request.threads)
    memory = None
    if request.sizes:
        memory = estimate_memory(settings, request.sizes)
    control = None
    if request.control is not None:
        photos = read_photos(request.photos, progress).photos
        try:
            control = _summarise_control(request.control, request.marks, request.crs, photos)
        except VomError as error:
            control = ControlSummary((), request.crs, None, None, to_finding(error), ())
    return ReconstructionForecast(memory, control)


def _summarise_control(
    path: Path, marks: Path | None, crs: str | None, photos: Any
) -> ControlSummary:
    from vomstudio.io.control.control_files import (
        agreed_crs,
        marks_path,
        read_control,
        read_marks,
    )
    from vomstudio.photogrammetry.georeferencing.control_check import check_control

    points = read_control(path)
    common_crs = agreed_crs(path, crs)
    reason = Finding("control.crs-chosen")
    if crs is None:
        reason = Finding("control.crs-stated", file=path.name)
    mark_table = read_marks(marks_path(path) if marks is None else marks)
    check = check_control(points, mark_table, photos, common_crs, reason)
    return serialisation.decode(ControlSummary, check.to_dict())


FORECAST = Job("foresee", Lane.INSPECTION, ForecastRequest, ReconstructionForecast, _forecast)
"""Forecast the memory and control points of a reconstruction."""

JOBS = (EXTRACT_FRAMES, FORECAST)
