"""Job that reconstructs a model from photos."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.words import to_translate
from vomstudio.photogrammetry.survey.check_results import SurveyReport
from vomstudio.studio.jobs import serialisation
from vomstudio.studio.jobs.job import Job, Lane
from vomstudio.studio.jobs.reconstruct_options import ReconstructOptions


@dataclass(frozen=True)
class ReconstructionRequest:
    """Request for the reconstruction of a model; other fields as in `PipelineSettings`.

    Parameters
    ----------
    photos, out : Path
        Folder of the photos, and output folder of the reconstruction.
    scheduler : str, optional
        Address of a Dask cluster. By default, the processors of this computer are used.
    masks : mapping of str to Path, optional
        Mask file of each photo, keyed by photo name. By default, masks beside the photos are
        used.
    device : {"auto", "cpu", "cuda"}
        Device that computes the depth maps.
    region : tuple of float, optional
        Minimum and maximum corners of the reconstructed part, in the frame of the model.
    keep_background : bool
        Whether to reconstruct objects far behind the rock.
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
    keep_background: bool = False

    @classmethod
    def of(
        cls,
        photos: Path,
        out: Path,
        options: ReconstructOptions,
        control: Path | None,
        marks: Path | None,
    ) -> ReconstructionRequest:
        """Return the request for these options, with the control files to use.

        Raises
        ------
        UsageError
            If the region is not a box.
        """
        values = {item.name: getattr(options, item.name) for item in fields(options)}
        del values["gcp"]
        return cls(
            photos=photos,
            out=out,
            **values | {"control": control, "marks": marks, "region": options.box},
        )


@dataclass(frozen=True, repr=False)
class Reconstruction(PrintableResult):
    """Summary of a reconstruction, as printed by `vomstudio reconstruct`.

    Values without a precise type are intended for the report, and are passed on from the stages.

    Parameters
    ----------
    frame : str
        "EPSG:n" or "local".
    unit : {"m", "unknown"}
        Unit of the model's coordinates.
    unseen_share : float
        Share of the surface that is not visible in any photo.
    texel, photo_pixel : float
        Median sizes of a texel and of a photo pixel on the rock, in `unit`.
    device : {"cpu", "cuda"}
        Device that computed the depth maps.
    seconds : mapping of str to float
        Run time of each stage, seconds.
    dense_gsd_m, dense_gsd : float or None
        Pixel size of the depth maps on the rock, in metres, or in `unit` if the scale is unknown.
    texel_ratio : float or None
        Size of a texel relative to a pixel of the best photo, 90th percentile over the surface.
    background_share : float or None
        Share of the tie points that are far behind the rock; None if a region was given.
    proposed_region : tuple of float or None
        Box around the tie points of the rock, as in `ReconstructionRequest`.
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
    texel_ratio: float | None = None
    background_share: float | None = None
    proposed_region: tuple[float, ...] | None = None

    def to_dict(self) -> dict[str, Any]:
        encoded: dict[str, Any] = serialisation.encode(self)
        return encoded


def _reconstruct(request: ReconstructionRequest, progress: Progress) -> Reconstruction:
    from vomstudio.photogrammetry.base.settings import PipelineSettings
    from vomstudio.photogrammetry.pipeline import outputs, reconstruction
    from vomstudio.products.report.reconstruction import write_report
    from vomstudio.studio.jobs.executors import make_executor

    settings = PipelineSettings(
        quality=request.quality,
        crs=request.crs,
        control=request.control,
        marks=request.marks,
        threads=request.threads,
        seed=request.seed,
        device=request.device,
        region=request.region,
        keep_background=request.keep_background,
    )
    executor = make_executor(settings.threads, request.scheduler)
    try:
        result = reconstruction.reconstruct(
            request.photos, request.out, settings, executor, progress, request.masks
        )
    finally:
        executor.close()
    with outputs.report_disk_errors(request.out):
        write_report(outputs.Outputs(request.out).report, result)
    return serialisation.decode(Reconstruction, result)


RECONSTRUCT = Job(
    "reconstruct",
    Lane.RECONSTRUCTION,
    ReconstructionRequest,
    Reconstruction,
    _reconstruct,
    to_translate(
        "Choose a lower quality, fewer photos or a smaller part of the outcrop, or close other "
        "programs, and start again."
    ),
)

JOBS = (RECONSTRUCT,)
