"""Resolution of a photo survey: pixel size on the rock, and errors of planes."""

from __future__ import annotations

from typing import Literal

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.plane_sizes import (
    PIXELS_PER_RESOLUTION,
    TARGET_ERROR_DEG,
    TEXTBOOK_RESOLUTIONS,
    PlaneSizes,
)
from vomstudio.geometry.units import length_text


def ground_sampling_distance(
    sensor_width_mm: float, focal_length_mm: float, distance_m: float, image_width_px: int
) -> float:
    """Compute the size of a pixel on the rock, m (textbook eq. 18).

    Parameters
    ----------
    sensor_width_mm : float
        Width of the part of the sensor that the image shows, along its long side.
    focal_length_mm : float
        Focal length of the lens, not its 35 mm equivalent.
    distance_m : float
        Distance from the camera to the rock, perpendicular to the image.
    image_width_px : int
        Long side of the image.

    Raises
    ------
    UsageError
        If a value is not positive.
    """
    for name, value in (
        (tr("sensor width"), sensor_width_mm),
        (tr("focal length"), focal_length_mm),
        (tr("distance"), distance_m),
        (tr("image width"), image_width_px),
    ):
        if not value > 0:
            raise UsageError(Finding("number.not-positive", value=value), field=name)
    return sensor_width_mm * distance_m / (focal_length_mm * image_width_px)


def gsd_for_plane(extent_m: float) -> float:
    """Return the pixel size on the rock, m, at which a plane has the textbook's 1000 pixels."""
    return extent_m / (PIXELS_PER_RESOLUTION * TEXTBOOK_RESOLUTIONS)


def expected_planes(
    planes: PlaneSizes, *, is_metric: bool = True, source: Literal["photos", "model"] = "photos"
) -> Finding:
    """Report the expected errors of planes of two sizes.

    They are the smallest size with a good verdict, and the textbook's limit.

    Parameters
    ----------
    planes : PlaneSizes
    is_metric : bool
        Whether sizes are in metres instead of units of the model.
    source : {"photos", "model"}
        Source of the resolution.
    """
    smallest_size = planes.size_for_error(TARGET_ERROR_DEG)
    if smallest_size is None:
        return Finding(
            "survey.no-planes",
            wanted_deg=TARGET_ERROR_DEG,
            registration_deg=planes.registration_deg,
        )
    return Finding(
        "survey.planes-by-photos" if source == "photos" else "survey.planes-by-model",
        size=length_text(smallest_size, 2, is_metric=is_metric),
        error_deg=planes.error_deg(smallest_size),
        textbook_size=length_text(planes.textbook, 2, is_metric=is_metric),
        textbook_error_deg=planes.error_deg(planes.textbook),
    )


def planes_summary(planes: PlaneSizes) -> str:
    """Return the expected errors as text for a table, for the resolution of photos."""
    large_text = tr(
        "{large} (1000 px) ± {better:.1f}°",
        large=length_text(planes.textbook, 2),
        better=planes.error_deg(planes.textbook),
    )
    smallest_size = planes.size_for_error(TARGET_ERROR_DEG)
    if smallest_size is None:
        return large_text
    small_text = tr(
        "{small} ± {within:.1f}°",
        small=length_text(smallest_size, 2),
        within=planes.error_deg(smallest_size),
    )
    return f"{small_text}, {large_text}"
