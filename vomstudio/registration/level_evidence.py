"""Level and plumb lines as observations, and checks of lines marked in photos.

A horizon or the axis of a levelled photo shows the horizontal direction in the photo. A level line
on the outcrop that runs away from the camera does not, because perspective tilts it, as it tilts
the eaves of a roof seen from below.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.cameras import View
from vomstudio.registration.observations import (
    Azimuths,
    Lengths,
    LevelLines,
    ObservationKind,
    PhotoUpright,
    PlumbLines,
)

# Distance of model points from the end of a line, as a share of the long side of the photo.
_END_TOLERANCE = 0.02
_MAX_IMAGE_PLANE_ANGLE_DEG = 2.0
# Tolerance beyond the edge of a photo, as a share of its size.
_EDGE_TOLERANCE = 0.1
# Tolerances for lines that are perpendicular to one direction, and that rotate with the photos.
_LEVEL_TOLERANCE_DEG, _MIN_ANGLE_RANGE_DEG = 5.0, 10.0
_DEFAULT_LEVEL_ERROR_DEG = 0.5
"""Default one-sigma error of a water line, a spirit-levelled staff or a built edge."""
_DEFAULT_PLUMB_ERROR_DEG = 0.5
"""Default one-sigma error of a plumb line, a hanging rope or a built edge."""
MIN_SEPARATION_DEG = 15.0
"""Angle below which level lines count as a single line."""
UPRIGHT_SIGMA_DEG = 15.0
"""One-sigma error of the vertical derived from the upper edges of photos. Cameras are held level to
within some degrees, but most of them look up at a cliff."""
# Lines do not show which end of the vertical is up; above this tilt, the end is uncertain.
_MAX_TILT_DEG = 60.0


@dataclass(frozen=True)
class KnownDirection:
    """Two points on the model that are connected by a level or vertical line.

    Attributes
    ----------
    sigma_deg : float or None
        One-sigma error. If None, the default of level or plumb lines is used.
    label : str
        Label of the line. If "", the line is identified by its number.
    """

    first: tuple[float, float, float]
    second: tuple[float, float, float]
    sigma_deg: float | None = None
    label: str = ""


def level_line_observations(lines: Sequence[KnownDirection]) -> LevelLines:
    """Convert level lines to observations.

    Parameters
    ----------
    lines : sequence of KnownDirection

    Returns
    -------
    LevelLines

    Raises
    ------
    UsageError
        If both ends of a line coincide.
    """
    sigma = [
        _DEFAULT_LEVEL_ERROR_DEG if line.sigma_deg is None else line.sigma_deg for line in lines
    ]
    names = [
        line.label or tr("level line {number}", number=line_number)
        for line_number, line in enumerate(lines, 1)
    ]
    return LevelLines(
        names,
        _unit_vectors(lines, "--level"),
        np.radians(sigma),
        float(np.radians(MIN_SEPARATION_DEG)),
    )


def plumb_line_observations(lines: Sequence[KnownDirection]) -> PlumbLines:
    """Convert plumb lines to observations.

    Parameters
    ----------
    lines : sequence of KnownDirection

    Returns
    -------
    PlumbLines

    Raises
    ------
    UsageError
        If both ends of a line coincide.
    """
    sigma = [
        _DEFAULT_PLUMB_ERROR_DEG if line.sigma_deg is None else line.sigma_deg for line in lines
    ]
    names = [
        line.label or tr("plumb line {number}", number=line_number)
        for line_number, line in enumerate(lines, 1)
    ]
    sigmas_by_axis = np.repeat(np.radians(sigma)[:, None], 2, axis=1)
    return PlumbLines(names, _unit_vectors(lines, "--plumb"), sigmas_by_axis)


def _unit_vectors(lines: Sequence[KnownDirection], option: str) -> FloatArray:
    """Return the directions (n, 3) from first to second ends.

    Raises UsageError if both ends of a line coincide.
    """
    ends = np.array([(line.first, line.second) for line in lines], np.float64)
    segments = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(segments, axis=1)
    if not (length > 0).all():
        raise UsageError(
            Finding("line.one-place"),
            field=option,
        )
    return np.asarray(segments / length[:, None])


def photo_upright_prior(up: FloatArray) -> PhotoUpright:
    """Return the prior on the vertical from the orientation of the camera in the photos.

    Parameters
    ----------
    up : (3,) ndarray
        Mean up direction of the photos in the model frame.

    Returns
    -------
    PhotoUpright
    """
    sigma = np.full((1, 2), np.radians(UPRIGHT_SIGMA_DEG))
    return PhotoUpright(
        [tr("upright direction of the photos")], up[None] / np.linalg.norm(up), sigma
    )


def vertical_findings(kinds: Sequence[ObservationKind], rotation: FloatArray) -> list[Finding]:
    """Return findings if known lines do not fully determine the vertical.

    Parameters
    ----------
    kinds : sequence of ObservationKind
    rotation : (3, 3) ndarray
        Rotation of the placed model.

    Returns
    -------
    list of Finding
    """
    findings = []
    for kind in kinds:
        if isinstance(kind, LevelLines) and kind.are_nearly_parallel:
            findings.append(
                Finding(
                    "registration.parallel-level-lines",
                    labels=list(kind.labels),
                    apart_deg=float(np.degrees(kind.max_angle_rad)),
                )
            )
        if isinstance(kind, PhotoUpright):
            findings.append(Finding("registration.photo-upright", sigma_deg=UPRIGHT_SIGMA_DEG))
    tilt_deg = float(np.degrees(np.arccos(np.clip(rotation[2, 2], -1.0, 1.0))))
    line_kinds = LevelLines | PlumbLines
    has_lines = any(isinstance(kind, line_kinds) for kind in kinds)
    if (
        has_lines
        and tilt_deg > _MAX_TILT_DEG
        and all(isinstance(kind, line_kinds | Azimuths | Lengths) for kind in kinds)
    ):
        findings.append(Finding("registration.which-end-up", tip_deg=tilt_deg))
    return findings


def image_plane_angle_deg(view: View, ends: FloatArray, extent: FloatArray) -> float | None:
    """Return the angle between a line on the model and the image plane of the photo.

    Parameters
    ----------
    view : View
    ends : (2, 2) array
        End points of the line, pixels.
    extent : (n, 3) array
        Points distributed over the model.

    Returns
    -------
    float or None
        Angle, degrees, or None if the model does not cover both ends.
    """
    pixels = view.project(extent)
    depth = (extent - view.centre) @ view.rotation[2]
    is_visible = np.isfinite(pixels).all(axis=1) & (depth > 0)
    limit = _END_TOLERANCE * max(view.intrinsics.width, view.intrinsics.height)
    line_ends = []
    for end in ends:
        is_near = is_visible & (
            np.linalg.norm(np.nan_to_num(pixels, nan=np.inf) - end, axis=1) < limit
        )
        if not is_near.any():
            return None
        # Visible points are in front of hidden ones.
        ray = view.rays(end)[0]
        distance = float(np.quantile(depth[is_near], 0.25)) / float(ray @ view.rotation[2])
        line_ends.append(view.centre + distance * ray)
    line = line_ends[1] - line_ends[0]
    length = float(np.linalg.norm(line))
    if not length > 0:
        return None
    return float(np.degrees(np.arcsin(min(1.0, abs(line @ view.rotation[2]) / length))))


def level_line_findings(
    photos: Sequence[str], views: Sequence[View], ends: FloatArray, extent: FloatArray | None
) -> list[Finding]:
    """Return findings about lines that are not level in their photos.

    Such lines run up and down their photos, or lie on the model and run away from the camera. The
    latter is not checked for lines along a row or a column of pixels, which are axes of the photos.

    Parameters
    ----------
    photos : sequence of str
    views : sequence of View
    ends : (n, 2, 2) array
        End points of the lines, pixels.
    extent : (n, 3) array or None
        Points distributed over the model.

    Raises
    ------
    InputError
        If a line ends outside its photo.
    """
    _require_inside(photos, views, ends)
    findings = _upright_line_findings(photos, views, ends)
    if extent is None or not len(extent):
        return findings
    photo_names, maximum = [], 0.0
    for photo, view, line in zip(photos, views, ends, strict=True):
        if (line[0] == line[1]).any():
            continue
        angle = image_plane_angle_deg(view, line, extent)
        if angle is not None and angle > _MAX_IMAGE_PLANE_ANGLE_DEG:
            photo_names.append(photo)
            maximum = max(maximum, angle)
    if not photo_names:
        return findings
    return [
        *findings,
        Finding("level.away", photos=photo_names, away_deg=maximum),
    ]


def _require_inside(photos: Sequence[str], views: Sequence[View], ends: FloatArray) -> None:
    for photo, view, line in zip(photos, views, ends, strict=True):
        lens = view.intrinsics
        size = np.array([lens.width, lens.height], np.float64)
        if ((line < -_EDGE_TOLERANCE * size) | (line > (1.0 + _EDGE_TOLERANCE) * size)).any():
            (x1, y1), (x2, y2) = line.tolist()
            raise InputError(
                Finding(
                    "level.outside",
                    x1=x1,
                    y1=y1,
                    x2=x2,
                    y2=y2,
                    photo=photo,
                    width=lens.width,
                    height=lens.height,
                ),
                field="--horizon",
            )


def _upright_line_findings(
    photos: Sequence[str], views: Sequence[View], ends: FloatArray
) -> list[Finding]:
    """Return findings about lines that run up and down their photos.

    Level lines do so in portrait photos that were not rotated. On the model, their directions
    rotate with the photos, whereas vertical lines are parallel.
    """
    steps = np.asarray(ends[:, 1] - ends[:, 0])
    is_upright = np.abs(steps[:, 1]) > np.abs(steps[:, 0])
    if not is_upright.any():
        return []
    view_rays = [view.rays(line) for view, line in zip(views, ends, strict=True)]
    lines = np.array([rays[1] - rays[0] for rays in view_rays])
    lines /= np.linalg.norm(lines, axis=1, keepdims=True)
    _, _, axes = np.linalg.svd(lines)
    angle_range = _range_deg(np.arctan2(lines @ axes[1], lines @ axes[0]), 180.0)
    distance = np.degrees(np.arcsin(np.minimum(np.abs(lines @ axes[2]), 1.0)))
    if angle_range > _MIN_ANGLE_RANGE_DEG and distance.max() <= _LEVEL_TOLERANCE_DEG:
        return []
    names = [photo for photo, up in zip(photos, is_upright, strict=True) if up]
    forward = np.array([view.direction for view in views])
    azimuth_range_deg = _range_deg(np.arctan2(forward @ axes[2], forward @ axes[1]), 360.0)
    if (
        is_upright.all()
        and azimuth_range_deg > _MIN_ANGLE_RANGE_DEG
        and angle_range < azimuth_range_deg / 2.0
    ):
        return [Finding("level.upright", photos=names)]
    return [Finding("level.portrait", photos=names)]


def _range_deg(angles_rad: FloatArray, period_deg: float) -> float:
    """Return the smallest arc, in degrees, that contains all angles of a period."""
    sorted_angles = np.sort(np.degrees(angles_rad) % period_deg)
    gaps = np.diff(np.append(sorted_angles, sorted_angles[0] + period_deg))
    return float(period_deg - gaps.max())
