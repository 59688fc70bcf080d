"""Measurements of the survey check, and their limits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from vomstudio.photogrammetry.survey.overlap import NormalizedFeatures, SetOverlap
from vomstudio.photogrammetry.survey.photo_quality import PhotoQuality

if TYPE_CHECKING:
    from vomstudio.io.photos.photo import Photo


@dataclass(frozen=True)
class Limits:
    """Limits of the survey check.

    Attributes
    ----------
    views : float
        Recommended number of photos that show each part of the rock (3.2.1: four or five).
    overlap : float
        Minimum overlap of a photo with its best neighbour: the textbook's 60 % minus the error of
        the estimate.
    doming_deg : float
        If the spread of the view directions is smaller, they count as one direction. The textbook
        recommends oblique photos up to 30 degrees from the perpendicular (3.2.1).
    max_baseline_ratio : float
        Maximum ratio of baseline to distance for a single position; turn_deg and zoom distinguish
        the photos taken there.
    blur_px, max_blur_ratio, soft_blur_px : float
        Blur sigma up to which photos are sharp, in pixels; maximum ratio to the sharpest quarter of
        the set; and blur above which no photo is sharp.
    min_brightness, saturated_share : float
        Minimum mean linear light, and maximum share of saturated pixels.
    stops, max_exposure_stops : float
        Maximum differences in the brightness of the pictures and in the metered exposure.
    gsd_ratio : float
        Maximum ratio of pixel sizes, an order of magnitude (3.2.1).
    rotation_deg : float
        95 % error of an orientation by GPS above which it is reported.
    registration_deg : float
        95 % error of the rotation of a model that is no longer small relative to the 5 degrees of a
        good plane.
    min_width_ratio : float
        Ratio of width to length below which camera positions count as collinear.
    resampling_strength, enlarged_blur_px : float
        Limit of `photo_quality.measure_resampling`, and the blur that confirms it.
    """

    views: float = 4.0
    min_photos: int = 5
    overlap: float = 0.50
    doming_deg: float = 10.0
    max_baseline_ratio: float = 0.01
    turn_deg: float = 5.0
    zoom: float = 1.25
    near_identical_overlap: float = 0.97
    blur_px: float = 1.8
    max_blur_ratio: float = 1.8
    soft_blur_px: float = 2.5
    stops: float = 1.0
    max_exposure_stops: float = 2.0
    min_brightness: float = 0.005
    saturated_share: float = 0.6
    gsd_ratio: float = 10.0
    rotation_deg: float = 5.0
    registration_deg: float = 2.0
    min_width_ratio: float = 0.05
    resampling_strength: float = 25.0
    enlarged_blur_px: float = 1.25
    hours: float = 3.0


@dataclass(frozen=True, eq=False)
class SurveyMeasurements:
    """Measurements of each photo of a folder, and between photos."""

    photos: tuple[Photo, ...]
    quality: tuple[PhotoQuality, ...]
    features: tuple[NormalizedFeatures | None, ...]
    pairs: SetOverlap
