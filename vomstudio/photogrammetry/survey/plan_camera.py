"""Camera of a planned survey, taken from the table or a photo, or given by numbers."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.results import HIDDEN_IN_JSON
from vomstudio.core.words import tr
from vomstudio.io.text.rows import shorten


@dataclass(frozen=True)
class PlanCamera:
    """Camera with sensor and picture in landscape format.

    focal_mm : focal length of the lens, not its 35 mm equivalent
    f_number : f-number of a fixed aperture; None if it is adjustable
    """

    name: str
    sensor_width_mm: float
    sensor_height_mm: float
    focal_mm: float
    width_px: int
    height_px: int
    f_number: float | None = field(default=None, metadata=HIDDEN_IN_JSON)

    @property
    def pixel_pitch_mm(self) -> float:
        """Distance between the centres of two pixels on the sensor."""
        return self.sensor_width_mm / self.width_px


def parse_camera(text: str, focal_mm: float | None = None) -> PlanCamera:
    """Return the camera given by its name in the table, by a photo or by numbers.

    Numbers are sensor size in mm, focal length in mm and size in pixels, such as
    `23.5x15.6,35,6000x4000` or `sensor=23.5 focal=35 pixels=6000`.

    Raises UsageError if the camera is unknown or incomplete, and InputError if a photo cannot be
    read.

    focal_mm : focal length that replaces any other value
    """
    text = text.strip()
    if _is_file(text):
        return _camera_from_photo(text, focal_mm)
    if re.match(r"^[\d.=,;xX×\s]*$|.*=", text):
        return _camera_from_numbers(text, focal_mm)
    from vomstudio.io.photos.camera_table import find_camera, similar_cameras

    model = find_camera(text)
    if model is None:
        similar_names = similar_cameras(text)
        finding = Finding(
            "plan.unknown-camera", camera=shorten(text), similar=similar_names or None
        )
        raise UsageError(finding, field="--camera")
    focal = focal_mm or model.focal_mm
    if focal is None:
        raise UsageError(
            Finding("plan.no-focal-length", camera=model.label),
            field="--focal",
        )
    return PlanCamera(
        model.label,
        model.width_mm,
        model.height_mm,
        focal,
        model.width_px,
        model.height_px,
        model.f_number,
    )


def _is_file(text: str) -> bool:
    try:
        return Path(text).is_file()
    except (OSError, ValueError):
        # The text is too long for a file name, or has characters that are not allowed.
        return False


def _camera_from_photo(path: str, focal_mm: float | None) -> PlanCamera:
    from vomstudio.io.photos.camera_table import find_camera
    from vomstudio.io.photos.reading import read_photo

    photo = read_photo(path)
    long_side, short_side = photo.long_side, min(photo.width, photo.height)
    sensor, focal = photo.sensor_width_mm, focal_mm or photo.focal_mm
    if (sensor is None or focal is None) and photo.focal_px is not None and focal_mm is None:
        # Assume 35 mm film, since only the ratio of both values matters.
        sensor, focal = 36.0, 36.0 * photo.focal_px / long_side
    if sensor is None or focal is None:
        raise UsageError(
            Finding("plan.photo-without-camera"),
            file=path,
            field="--camera",
        )
    known_camera = find_camera(photo.camera)
    return PlanCamera(
        photo.camera or Path(path).name,
        sensor,
        sensor * short_side / long_side,
        focal,
        long_side,
        short_side,
        None if known_camera is None else known_camera.f_number,
    )


def _camera_from_numbers(text: str, focal_mm: float | None) -> PlanCamera:
    sensor: tuple[float, ...] = ()
    pixels: tuple[float, ...] = ()
    unnamed_numbers: list[float] = []
    focal = focal_mm
    for token in re.split(r"[,;\s]+", text.strip(" ,;")):
        key, _, value = token.rpartition("=")
        try:
            numbers = tuple(float(part) for part in re.split(r"[xX×]", value))
        except ValueError:
            raise _invalid_camera_error(token) from None
        if not numbers or len(numbers) > 2 or not all(0 < n < 1e6 for n in numbers):
            raise _invalid_camera_error(token)
        key = key.strip().casefold()
        if key in ("sensor", "width", "sensor_width", "sensor_width_mm", "sw"):
            sensor = numbers
        elif key in ("focal", "f", "focal_mm", "focal_length"):
            focal = focal_mm or numbers[0]
        elif key in ("pixels", "px", "image", "image_width", "width_px", "iw"):
            pixels = numbers
        elif key:
            raise _invalid_camera_error(token)
        elif len(numbers) == 2 and min(numbers) > 100:
            pixels = numbers
        elif len(numbers) == 2:
            sensor = numbers
        else:
            unnamed_numbers.append(numbers[0])
    # Numbers without a name are in the order sensor, focal length, pixels.
    if not sensor and unnamed_numbers:
        sensor = (unnamed_numbers.pop(0),)
    if focal is None and unnamed_numbers:
        focal = unnamed_numbers.pop(0)
    if not pixels and unnamed_numbers:
        pixels = tuple(unnamed_numbers[:2])
        unnamed_numbers = unnamed_numbers[2:]
    if not sensor or focal is None or not pixels or unnamed_numbers:
        raise _invalid_camera_error(text)
    pixels = tuple(sorted(pixels, reverse=True))
    sensor = tuple(sorted(sensor, reverse=True))
    height = pixels[1] if len(pixels) > 1 else None
    if height is None:
        height = pixels[0] * sensor[1] / sensor[0] if len(sensor) > 1 else pixels[0] * 2.0 / 3.0
    if pixels[0] < 16 or height < 16:
        raise _invalid_camera_error(text)
    return PlanCamera(
        tr("custom camera"),
        sensor[0],
        sensor[0] * height / pixels[0],
        focal,
        round(pixels[0]),
        round(height),
    )


def _invalid_camera_error(text: str) -> UsageError:
    return UsageError(
        Finding("plan.not-a-camera", camera=shorten(text)),
        field="--camera",
    )
