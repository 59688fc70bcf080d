"""Metadata of a photo."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from pathlib import Path


@dataclass(frozen=True, kw_only=True)
class PhotoTags:
    """EXIF tags of a photo, with None for missing tags.

    Attributes
    ----------
    focal_mm, focal_35mm : float or None
        Focal length of the lens, and its equivalent on 36 x 24 mm film.
    orientation : int
        EXIF orientation, 1 to 8, by which viewers rotate the pixels.
    digital_zoom : float or None
        Enlargement factor; 1 for no zoom.
    altitude_m : float or None
        Height above `altitude_reference`, negative below sea level.
    altitude_reference : str or None
        "sea level", "below sea level" or "ellipsoid".
    gps_accuracy_m : float or None
        Horizontal accuracy stated by the receiver.
    direction_deg : float or None
        Azimuth of the view from the compass of the phone.
    direction_north : str or None
        North reference of `direction_deg`: "true" or "magnetic".
    """

    serial: str | None = None
    lens: str | None = None
    focal_mm: float | None = None
    focal_35mm: float | None = None
    orientation: int = 1
    taken_at: datetime | None = None
    exposure_s: float | None = None
    f_number: float | None = None
    iso: float | None = None
    digital_zoom: float | None = None
    latitude_deg: float | None = None
    longitude_deg: float | None = None
    altitude_m: float | None = None
    altitude_reference: str | None = None
    gps_accuracy_m: float | None = None
    direction_deg: float | None = None
    direction_north: str | None = None


@dataclass(frozen=True)
class Photo(PhotoTags):
    """Path, size, camera, position and direction of a photo; None if not stated.

    Attributes
    ----------
    name : str
        Path relative to the folder, with forward slashes.
    width, height : int
        Size in pixels as stored; `orientation` affects only the display.
    camera : str or None
        Make and model.
    sensor_width_mm : float or None
        Width of the part of the sensor that the photo shows, along its long side.
    focal_px : float or None
        Focal length in pixels, determined as stated by `focal_source`.
    exif_altitude_m : float or None
        Height from EXIF if its sign contradicts XMP; `altitude_m` is then the height from XMP.
    relative_altitude_m : float or None
        Height of a drone above the take-off position.
    yaw_deg, pitch_deg, roll_deg : float or None
        Azimuth of the optical axis, its angle above the horizon, and the rotation about it.
    has_zero_angles : bool
        Whether yaw, pitch and roll are exactly 0 as written.
    has_comment_angles : bool
        Whether yaw, pitch and roll are from EXIF `UserComment`.
    down : tuple of float or None
        Unit vector of gravity from the phone's accelerometer, in the camera frame (x right, y down,
        z forward, in the photo as stored).
    mask : Path or None
        Mask of the same size; white pixels are used.
    """

    path: Path
    name: str
    width: int
    height: int
    camera: str | None = None
    sensor_width_mm: float | None = None
    focal_px: float | None = None
    focal_source: str | None = None
    exif_altitude_m: float | None = None
    relative_altitude_m: float | None = None
    yaw_deg: float | None = None
    pitch_deg: float | None = None
    roll_deg: float | None = None
    has_zero_angles: bool = False
    has_comment_angles: bool = False
    down: tuple[float, float, float] | None = None
    mask: Path | None = None

    @property
    def long_side(self) -> int:
        return max(self.width, self.height)

    @property
    def camera_key(self) -> tuple[object, ...]:
        """Key of the lens and its setting; photos with the same key may share a calibration."""
        focal = None if self.focal_px is None else round(self.focal_px, 1)
        return (self.camera, self.serial, self.lens, self.focal_mm, focal, self.width, self.height)

    @property
    def exposure_value(self) -> float | None:
        """EV at ISO 100: log2(N^2 / t) - log2(ISO / 100) (ISO 2720); None if a value is missing."""
        from math import log2

        if self.exposure_s is None or self.f_number is None or self.iso is None:
            return None
        return log2(self.f_number**2 / self.exposure_s) - log2(self.iso / 100.0)
