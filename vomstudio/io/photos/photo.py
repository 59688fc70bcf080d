"""Metadata of a photo."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from pathlib import Path


@dataclass(frozen=True, kw_only=True)
class PhotoTags:
    """EXIF tags of a photo, with None for missing tags.

    focal_mm : focal length of the lens; focal_35mm : its equivalent on 36 x 24 mm film
    orientation : 1 to 8, turns the pixels for viewers
    digital_zoom : factor, 1 for none
    altitude_m : in `altitude_reference` "sea level", "below sea level" (then negative) or
        "ellipsoid"
    gps_accuracy_m : horizontal accuracy stated by the receiver
    direction_deg : azimuth of the view by the phone's compass, from direction_north: "true",
        "magnetic", or None if the photo does not state it
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

    name : relative to the folder, with forward slashes
    width, height : pixels as stored; `orientation` (EXIF, 1 to 8) turns them for viewers only
    camera : make and model
    sensor_width_mm : width of the part of the sensor that the photo shows, along its long side
    focal_px : focal length by the rule that `focal_source` names
    relative_altitude_m : height of a drone above the place of take-off
    exif_altitude_m : height in EXIF if its sign contradicts that of XMP, which altitude_m then is
    yaw_deg, pitch_deg, roll_deg : angle of the optical axis from north and above the horizon, and
        rotation about it
    has_zero_angles : these three are exactly 0 as written; has_comment_angles : they are from
        EXIF `UserComment`
    down : the direction in which things fall, by the phone's accelerometer, in the frame of the
        camera (x right, y down, z forward, in the photo as stored), a unit vector
    mask : picture of the same size; white is used
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
