"""Checks for contradictory metadata of photos and for values that are not measurements."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace

from vomstudio.core.findings import Finding
from vomstudio.io.photos.photo import Photo

MAX_ROUNDING_M = 0.5
"""Maximum difference due to rounding between heights of one receiver in EXIF and XMP."""
MIN_CONTRADICTION_M = 1.0


def signed_altitude(exif_m: float | None, xmp_m: float | None) -> float | None:
    """Return the height from EXIF, or that from XMP if their signs contradict each other.

    Some drones mark heights above sea level as "below sea level" in EXIF. The XMP height is a
    signed number. Heights of different magnitude may refer to different surfaces and are not
    compared.

    Parameters
    ----------
    exif_m, xmp_m : float or None
        Height from EXIF, which is negative below sea level, and absolute height from XMP.

    Returns
    -------
    float or None
        Height from XMP if both have the same magnitude and opposite signs, otherwise that from
        EXIF, which may be None.
    """
    if exif_m is None or xmp_m is None:
        return exif_m
    has_same_magnitude = abs(abs(exif_m) - abs(xmp_m)) <= MAX_ROUNDING_M
    return xmp_m if has_same_magnitude and abs(exif_m - xmp_m) > MIN_CONTRADICTION_M else exif_m


def altitude_findings(photos: Sequence[Photo]) -> list[Finding]:
    """Return ``photo.altitude-sign`` if heights in EXIF and XMP have contradictory signs."""
    wrong_photos = [photo for photo in photos if photo.exif_altitude_m is not None]
    if not wrong_photos:
        return []
    first_photo = wrong_photos[0]
    return [
        Finding(
            "photo.altitude-sign",
            photos=len(wrong_photos),
            photo=first_photo.name,
            exif_m=first_photo.exif_altitude_m,
            xmp_m=first_photo.altitude_m,
        )
    ]


def drop_unmeasured_angles(photos: Sequence[Photo]) -> tuple[list[Photo], list[Finding]]:
    """Drop yaw, pitch and roll of exactly 0, as written by cameras without a sensor.

    They are not measurements if all photos of a camera that have angles have these values. A single
    such photo among others may be a measurement.

    Returns
    -------
    photos : list of Photo
        Photos in the same order, without such angles.
    findings : list of Finding
        ``photo.angles-not-measured`` for each camera whose angles were dropped, and
        ``photo.angles-in-comment`` if angles of `UserComment` remain.
    """
    photos_by_camera: dict[str | None, list[Photo]] = defaultdict(list)
    for photo in photos:
        if photo.yaw_deg is not None:
            photos_by_camera[photo.camera].append(photo)
    unmeasured_groups = {
        camera: group
        for camera, group in photos_by_camera.items()
        if all(photo.has_zero_angles for photo in group)
    }
    findings = [
        Finding("photo.angles-not-measured", photos=len(group), photo=group[0].name)
        for group in unmeasured_groups.values()
    ]
    result = [
        replace(photo, yaw_deg=None, pitch_deg=None, roll_deg=None, has_zero_angles=False)
        if photo.yaw_deg is not None and photo.camera in unmeasured_groups
        else photo
        for photo in photos
    ]
    commented_photos = [
        photo for photo in result if photo.yaw_deg is not None and photo.has_comment_angles
    ]
    if commented_photos:
        findings.append(
            Finding(
                "photo.angles-in-comment",
                photos=len(commented_photos),
                photo=commented_photos[0].name,
            )
        )
    return result, findings
