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
        Recommended number of photos of each place (3.2.1: four or five).
    overlap : float
        Of a photo with its best neighbour; the book's 60 % minus the error of the estimate.
    doming_deg : float
        Spread of view directions below which they are one direction; the book recommends obliques
        up to 30 degrees from the perpendicular (3.2.1).
    same_place : float
        Baseline over distance of one position; turn_deg and zoom distinguish photos there.
    blur_px, blur_times : float
        Sigma, and its ratio to the median of the set.
    darkest, burnt : float
        Mean linear light, and share of saturated pixels.
    stops, light_stops : float
        Differences in brightness of the pictures, and of the metered exposure.
    gsd_ratio : float
        An order of magnitude (3.2.1).
    rotation_deg : float
        95 % error of an orientation by GPS that is reported.
    registration_deg : float
        95 % error of a model's rotation that is not small relative to the 5 degrees of a good
        plane.
    straight : float
        Ratio of width to length of collinear camera positions.
    resampled, enlarged_px : float
        See photo_quality.interpolation_period, and the blur that confirms it.
    """

    views: float = 4.0
    fewest_photos: int = 5
    overlap: float = 0.50
    doming_deg: float = 10.0
    same_place: float = 0.01
    turn_deg: float = 5.0
    zoom: float = 1.25
    near_identical: float = 0.97
    blur_px: float = 1.8
    blur_times: float = 1.8
    soft_px: float = 2.5
    stops: float = 1.0
    light_stops: float = 2.0
    darkest: float = 0.005
    burnt: float = 0.6
    gsd_ratio: float = 10.0
    rotation_deg: float = 5.0
    registration_deg: float = 2.0
    straight: float = 0.05
    resampled: float = 25.0
    enlarged_px: float = 1.25
    hours: float = 3.0


@dataclass(frozen=True, eq=False)
class SurveyMeasurements:
    """Measurements of a folder: of each photo, and between photos."""

    photos: tuple[Photo, ...]
    quality: tuple[PhotoQuality, ...]
    features: tuple[NormalizedFeatures | None, ...]
    pairs: SetOverlap
