"""Resolution of a photo survey: pixel size on the rock and the smallest plane it resolves."""

from __future__ import annotations

from vomstudio.errors import UsageError
from vomstudio.words import tr

# A cloud resolves about 10 pixels (textbook 3.2.1), and a plane should span 100 times the
# resolution (4.1.3).
PIXELS_PER_SMALLEST_PLANE = 1000.0


def ground_sampling_distance(
    sensor_width_mm: float, focal_length_mm: float, distance_m: float, image_width_px: int
) -> float:
    """Metres on the rock per pixel (textbook eq. 18).

    sensor_width_mm : width of the part of the sensor that the image shows, along its long side
    focal_length_mm : of the lens, not its 35 mm equivalent
    distance_m : from the camera to the rock, at right angles to the image
    image_width_px : long side of the image

    Raises UsageError that names what is not positive.
    """
    for name, value in (
        (tr("sensor width"), sensor_width_mm),
        (tr("focal length"), focal_length_mm),
        (tr("distance"), distance_m),
        (tr("image width"), image_width_px),
    ):
        if not value > 0:
            raise UsageError(tr("This must be a positive number."), field=name)
    return sensor_width_mm * distance_m / (focal_length_mm * image_width_px)


def smallest_plane(gsd_m: float) -> float:
    """Extent in metres of the smallest plane worth measuring on a model of this resolution."""
    return PIXELS_PER_SMALLEST_PLANE * gsd_m


def gsd_for_plane(extent_m: float) -> float:
    """Pixel size in metres on the rock with which a plane of this extent can just be measured."""
    return extent_m / PIXELS_PER_SMALLEST_PLANE
