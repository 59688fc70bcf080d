"""The job that makes a model of photos."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.reprs import Shown
from vomstudio.core.words import to_translate
from vomstudio.photogrammetry.survey.check_results import SurveyReport
from vomstudio.studio.jobs import serialisation
from vomstudio.studio.jobs.job import Job, Lane


@dataclass(frozen=True)
class ReconstructionOrder:
    """Of the photos in the folder `photos`, below `out`; the rest as in `Settings`.

    scheduler : address of a Dask cluster, None for this machine's processors
    masks : by photo, in place of those that lie beside the photos; None for those
    device : "auto", "cpu" or "cuda", for the depth maps
    region : lowest and highest corner of the part of which a model is made, in its frame
    """

    photos: Path
    out: Path
    quality: str
    crs: str | None = None
    control: Path | None = None
    marks: Path | None = None
    threads: int | None = None
    seed: int = 0
    scheduler: str | None = None
    masks: Mapping[str, Path] | None = None
    device: str = "auto"
    region: tuple[float, ...] | None = None


@dataclass(frozen=True, repr=False)
class Reconstruction(Shown):
    """What was made, in figures and file names: the object that `vomstudio reconstruct` prints.

    frame : "EPSG:n" or "local"; unit : of the model's coordinates, "m" or "unknown"; unseen_share :
    of the surface, in no photo; texel, photo_pixel : sizes on the rock, medians, in that unit;
    device : "cpu" or "cuda", on which the depth maps were computed; seconds : by stage;
    dense_gsd_m : a pixel of the depth maps on the rock, None where the model has no metres;
    dense_gsd : in its unit then; what is left open in its type is for the report, as the stages
    have told it
    """

    photos: int
    registered: int
    unregistered: tuple[str, ...]
    survey: SurveyReport
    alignment_notes: tuple[Finding, ...]
    reprojection_error_px: float
    cameras: str
    sparse: str
    dense: str
    mesh: str
    dense_points: int
    faces: int
    frame: str
    scaled: bool
    unit: str
    unseen_share: float
    texel: float
    photo_pixel: float
    device: str
    seconds: Mapping[str, float]
    peak_memory_mb: int
    report: str
    poses: str
    folder: str
    warnings: tuple[Finding, ...]
    tie_points: int
    tie_points_of_3: int
    photo_rows: tuple[Mapping[str, Any], ...]
    dense_gsd_m: float | None
    calibration: tuple[Mapping[str, Any], ...]
    registration: Mapping[str, Any]
    model: Mapping[str, Any]
    settings: Mapping[str, Any]
    versions: Mapping[str, str]
    drawing: Mapping[str, Any]
    work_mb: float
    dense_gsd: float | None = None

    def to_dict(self) -> dict[str, Any]:
        plain: dict[str, Any] = serialisation.encode(self)
        return plain


def _reconstruct(asked: ReconstructionOrder, progress: Progress) -> Reconstruction:
    from vomstudio.photogrammetry.base.settings import Settings
    from vomstudio.photogrammetry.pipeline import outputs, reconstruction
    from vomstudio.products.report.reconstruction import write_report
    from vomstudio.studio.jobs.executors import make_executor

    settings = Settings(
        quality=asked.quality,
        crs=asked.crs,
        control=asked.control,
        marks=asked.marks,
        threads=asked.threads,
        seed=asked.seed,
        device=asked.device,
        region=asked.region,
    )
    executor = make_executor(settings.threads, asked.scheduler)
    try:
        result = reconstruction.reconstruct(
            asked.photos, asked.out, settings, executor, progress, asked.masks
        )
    finally:
        executor.close()
    with outputs.report_disk_errors(asked.out):
        write_report(outputs.Outputs(asked.out).report, result)
    return serialisation.decode(Reconstruction, result)


RECONSTRUCT = Job(
    "reconstruct",
    Lane.RECONSTRUCTION,
    ReconstructionOrder,
    Reconstruction,
    _reconstruct,
    to_translate(
        "Choose a lower quality, fewer photos or a smaller part of the outcrop, or close other "
        "programs, and start again."
    ),
)

JOBS = (RECONSTRUCT,)
