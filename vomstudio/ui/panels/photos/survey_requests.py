"""What workers are asked about a set of photos. Imported when somebody first asks."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from vomstudio.photogrammetry.survey.check_results import SurveyReport
from vomstudio.studio.jobs.job import Job
from vomstudio.studio.jobs.photo_tasks import CHECK_PHOTOS, LIST_PHOTOS, PhotoListing, PhotosRequest
from vomstudio.studio.jobs.survey_tasks import FORESEE, ForecastRequest, ReconstructionForecast
from vomstudio.ui.panels.photos.photo_row import PhotoRow
from vomstudio.ui.panels.photos.reconstruction_settings import ReconstructionSettings

Masks = dict[str, Path]


def listing(folder: Path, cache: Path) -> tuple[Job[PhotosRequest, PhotoListing], PhotosRequest]:
    """It looks at the masks that lie beside the photos."""
    return LIST_PHOTOS, PhotosRequest(folder, cache, None)


def check(
    folder: Path, cache: Path, masks: Masks | None
) -> tuple[Job[PhotosRequest, SurveyReport], PhotosRequest]:
    return CHECK_PHOTOS, PhotosRequest(folder, cache, masks)


def forecast(
    folder: Path, rows: Sequence[PhotoRow], settings: ReconstructionSettings
) -> tuple[Job[ForecastRequest, ReconstructionForecast], ForecastRequest]:
    """What the settings mean for these photos."""
    return FORESEE, ForecastRequest(
        folder,
        tuple((row.width, row.height) for row in rows),
        settings.quality,
        settings.crs,
        settings.control,
        settings.marks,
        settings.threads,
    )
