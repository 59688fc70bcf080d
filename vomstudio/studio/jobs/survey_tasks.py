"""Jobs before a reconstruction: frames of a video, and what the reconstruction will need."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vomstudio.core.findings import Finding, finding_of
from vomstudio.core.progress import Progress
from vomstudio.photogrammetry.pipeline.memory_estimate import MemoryNeed, memory_need
from vomstudio.photogrammetry.survey.survey_options import FrameOptions
from vomstudio.photogrammetry.survey.video import FrameReport, take_frames
from vomstudio.studio.jobs import serialisation
from vomstudio.studio.jobs.job import Job, Lane


@dataclass(frozen=True)
class FramesOrder:
    """Order for writing frames of `video` to `out`; force : even if it contains other files"""

    video: Path
    out: Path
    options: FrameOptions
    force: bool


def _take_frames(order: FramesOrder, progress: Progress) -> FrameReport:
    return take_frames(
        order.video, order.out, fps=order.options.fps, force=order.force, progress=progress
    )


TAKE_FRAMES = Job("take_frames", Lane.PHOTOS, FramesOrder, FrameReport, _take_frames)
"""Write the frames of a video that are worth using."""


@dataclass(frozen=True)
class ForecastOrder:
    """Order for the forecast of a reconstruction of the folder `photos` with these settings.

    sizes : width and height of the photos, which the caller has read already
    """

    photos: Path
    sizes: tuple[tuple[int, int], ...]
    quality: str
    crs: str | None = None
    control: Path | None = None
    marks: Path | None = None
    threads: int | None = None


@dataclass(frozen=True)
class PointFacts:
    """See `PointCheck`."""

    label: str
    use: str
    photos: int
    quality: str


@dataclass(frozen=True)
class ControlFacts:
    """See `ControlCheck`; problem : also the reason if a file cannot be read."""

    points: tuple[PointFacts, ...]
    crs: str | None
    crs_reason: Finding | None
    summary: Finding | None
    problem: Finding | None
    warnings: tuple[Finding, ...]


@dataclass(frozen=True)
class Forecast:
    """memory : None without photos; control : None without control points"""

    memory: MemoryNeed | None
    control: ControlFacts | None


def _foresee(order: ForecastOrder, progress: Progress) -> Forecast:
    from vomstudio.core.errors import VomError
    from vomstudio.io.photos.reading import read_photos
    from vomstudio.photogrammetry.base.settings import Settings

    settings = Settings(quality=order.quality, threads=order.threads)
    memory = None
    if order.sizes:
        memory = memory_need(settings, order.sizes)
    control = None
    if order.control is not None:
        photos = read_photos(order.photos, progress).photos
        try:
            control = _control(order.control, order.marks, order.crs, photos)
        except VomError as error:
            control = ControlFacts((), order.crs, None, None, finding_of(error), ())
    return Forecast(memory, control)


def _control(path: Path, marks: Path | None, crs: str | None, photos: Any) -> ControlFacts:
    from vomstudio.io.control.control_files import (
        agreed_crs,
        marks_beside,
        read_control,
        read_marks,
    )
    from vomstudio.photogrammetry.georeferencing.control_check import check_control

    points = read_control(path)
    placed = agreed_crs(path, crs)
    reason = Finding("control.crs-chosen")
    if crs is None:
        reason = Finding("control.crs-stated", file=path.name)
    seen = read_marks(marks_beside(path) if marks is None else marks)
    found = check_control(points, seen, photos, placed, reason)
    return serialisation.decode(ControlFacts, found.to_dict())


FORESEE = Job("foresee", Lane.INSPECTION, ForecastOrder, Forecast, _foresee)
"""What a reconstruction will need and use."""

JOBS = (TAKE_FRAMES, FORESEE)
