"""What the survey check measures of a folder, and the numbers beyond which it says so."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from vomstudio.photogrammetry.survey.overlap import Features, SetOverlap
from vomstudio.photogrammetry.survey.photo_quality import PhotoQuality

if TYPE_CHECKING:
    from vomstudio.io.photos.photo import Photo


@dataclass(frozen=True)
class Limits:
    """views : photos that should see each place (3.2.1: four or five)
    overlap : of a photo with its best neighbour; the book's 60 % less what the estimate errs by
    doming_deg : spread of view directions that counts as one direction; the book wants obliques up
        to 30 degrees from the perpendicular (3.2.1)
    same_place : baseline over distance; turn_deg and zoom : what makes it another photo
    blur_px : sigma; and blur_times the median of the set
    darkest : mean linear light, and burnt : share of pixels, beyond which nothing is seen
    stops : of brightness in the pictures; light_stops : of the exposure that the light asked for
    gsd_ratio : an order of magnitude (3.2.1)
    rotation_deg : 95 % error of an orientation by GPS that the user should hear of
    registration_deg : 95 % error of a model's rotation that is no longer small beside the 5 degrees
        up to which a plane is good
    straight : width over length of camera positions that counts as one line
    resampled : see photo_quality.interpolation_period; enlarged_px : blur that confirms it
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
    """What was measured of a folder: per photo, and between them."""

    photos: tuple[Photo, ...]
    quality: tuple[PhotoQuality, ...]
    features: tuple[Features | None, ...]
    pairs: SetOverlap
