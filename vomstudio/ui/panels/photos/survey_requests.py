"""Requests to worker processes about a photo set; imported only when needed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from vomstudio.photogrammetry.survey.check_results import SurveyReport
from vomstudio.studio.jobs.job import Job
from vomstudio.studio.jobs.photo_tasks import CHECK_PHOTOS, LIST_PHOTOS, PhotoListing, PhotosRequest
from vomstudio.studio.jobs.survey_tasks import FORECAST, ForecastRequest, ReconstructionForecast
from vomstudio.ui.panels.photos.photo_row import PhotoRow
from vomstudio.ui.panels.photos.reconstruction_settings import ReconstructionSettings

MaskPaths = dict[str, Path]


def list_request(
    folder: Path, cache: Path
) -> tuple[Job[PhotosRequest, PhotoListing], PhotosRequest]:
    """Return the job and request that list the photos and the masks beside them."""
    return LIST_PHOTOS, PhotosRequest(folder, cache, None)


def check_request(
    folder: Path, cache: Path, masks: MaskPaths | None
) -> tuple[Job[PhotosRequest, SurveyReport], PhotosRequest]:
    return CHECK_PHOTOS, PhotosRequest(folder, cache, masks)


def forecast_request(
    folder: Path, rows: Sequence[PhotoRow], settings: ReconstructionSettings
) -> tuple[Job[ForecastRequest, ReconstructionForecast], ForecastRequest]:
    """Return the job and request that forecast a reconstruction with these settings."""
    return FORECAST, ForecastRequest(
        photos=folder,
        sizes=tuple((row.width, row.height) for row in rows),
        quality=settings.options.quality,
        crs=settings.options.crs,
        control=settings.control,
        marks=settings.marks,
        threads=settings.options.threads,
    )
