"""Positions and attitudes from the metadata of photos."""

from __future__ import annotations

from collections.abc import Mapping
from datetime import date
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.geometry.cameras import View
from vomstudio.io.control.attitude_tables import (
    AttitudeTable,
    attitude_table,
    empty_attitude_table,
)
from vomstudio.io.control.observation_tables import Positions
from vomstudio.io.photos.metadata_checks import altitude_findings, drop_unmeasured_angles
from vomstudio.io.photos.photo import Photo
from vomstudio.io.photos.reading import read_photo


def read_photo_positions(photos: Mapping[str, Path]) -> Positions:
    """Read the GPS positions of photos: longitude, latitude, height and height reference.

    The horizontal error stated by receivers is not used; it is estimated from the residuals.

    Parameters
    ----------
    photos : mapping
        Files by the names of their cameras.

    Raises
    ------
    UsageError
        If no photo has a position.
    """
    names, positions, heights = list[str](), list[tuple[float, float, float]](), list[str]()
    metadata = [read_photo(path) for path in photos.values()]
    for name, photo in zip(photos, metadata, strict=True):
        if photo.longitude_deg is None or photo.latitude_deg is None:
            continue
        names.append(name)
        height = float("nan") if photo.altitude_m is None else photo.altitude_m
        positions.append((photo.longitude_deg, photo.latitude_deg, height))
        heights.append(photo.altitude_reference or "")
    if not names:
        raise UsageError(
            Finding("no-gps", "error", photos=(), value=0),
            field="--cameras",
        )
    unknown_sigmas = np.full((len(names), 3), np.nan)
    return Positions(
        tuple(names),
        np.array(positions),
        True,
        unknown_sigmas,
        heights=tuple(heights),
        notes=tuple(altitude_findings(metadata)),
    )


def read_photo_attitudes(photos: Mapping[str, Path], views: Mapping[str, View]) -> AttitudeTable:
    """Read the attitudes of photos measured by a drone gimbal or the sensors of a phone.

    Parameters
    ----------
    photos : mapping
        Files by the names of their cameras.
    views : mapping
        Cameras, whose photos may have been rotated upright by a program before use.

    Returns
    -------
    AttitudeTable
        Attitudes. If the table is empty, its notes contain a finding that explains why.

    Raises
    ------
    UsageError
        If no photo has an attitude.
    """
    names, angles, down, north_references = (
        list[str](),
        list[FloatArray](),
        list[FloatArray](),
        list[str](),
    )
    days, positions = list[date | None](), list[FloatArray]()
    drone_photo_count = unnamed_count = 0
    metadata, findings = drop_unmeasured_angles([read_photo(path) for path in photos.values()])
    for name, photo in zip(photos, metadata, strict=True):
        quarter_turns = _quarter_turns(photo, views.get(name))
        angles_deg = np.full(3, np.nan)
        north, direction_down = "true", np.full(3, np.nan)
        if photo.yaw_deg is not None and photo.pitch_deg is not None:
            angles_deg[:] = (
                photo.yaw_deg,
                photo.pitch_deg,
                (photo.roll_deg or 0.0) - 90.0 * quarter_turns,
            )
            drone_photo_count += 1
        else:
            if photo.down is not None:
                direction_down[:] = _rotate(photo.down, quarter_turns)
            if photo.direction_deg is not None:
                angles_deg[0] = photo.direction_deg
                north = photo.direction_north or "magnetic"
                unnamed_count += photo.direction_north is None
        if not (np.isfinite(angles_deg[0]) or np.isfinite(direction_down[0])):
            continue
        names.append(name)
        angles.append(angles_deg)
        down.append(direction_down)
        north_references.append(north)
        days.append(None if photo.taken_at is None else photo.taken_at.date())
        longitude, latitude = photo.longitude_deg, photo.latitude_deg
        location = (
            (np.nan, np.nan) if longitude is None or latitude is None else (longitude, latitude)
        )
        positions.append(np.array(location))
    if not names and findings:
        return empty_attitude_table(findings)
    if not names:
        raise UsageError(
            Finding("attitude.not-in-photos"),
            field="--attitudes",
        )
    return attitude_table(
        tuple(names),
        np.array(angles),
        None,
        tuple(north_references),
        is_doubted=True,
        down=np.array(down),
        days=tuple(days),
        positions=np.array(positions),
        notes=(*findings, *_notes(drone_photo_count, unnamed_count)),
    )


def _notes(drone_photo_count: int, unnamed_count: int) -> tuple[Finding, ...]:
    notes = []
    if drone_photo_count:
        notes.append(Finding("attitude.from-drone", photos=drone_photo_count))
    if unnamed_count:
        notes.append(Finding("attitude.north-assumed", photos=unnamed_count))
    return tuple(notes)


def _quarter_turns(photo: Photo, view: View | None) -> int:
    """Return the clockwise quarter turns applied to the photo by a program, from its shape."""
    if view is None or photo.width == photo.height:
        return 0
    lens = view.intrinsics
    if (lens.width > lens.height) == (photo.width > photo.height) or lens.width == lens.height:
        return 0
    return {6: 1, 8: 3}.get(photo.orientation, 0)


def _rotate(down: tuple[float, float, float], quarter_turns: int) -> tuple[float, float, float]:
    right, camera_down, forward = down
    for _ in range(quarter_turns):
        right, camera_down = -camera_down, right
    return right, camera_down, forward
