"""Level and plumb lines on a model as observations of its place, and whether level lines that were
marked in photos show the level: a horizon does, and the axis of a photo that was held level. A
level line on the outcrop that runs away from the camera does not in its photo: perspective tilts
it, as that of a roof seen from below."""

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
    Observed,
    PhotoUpright,
    PlumbLines,
)

# Of the photo's long side: a point of the model this near to the end of a line is at that end.
_NEAR = 0.02
_AWAY_DEG = 2.0
# Of the photo's size: a line may reach so far beyond its edge.
_BEYOND = 0.1
# Lines that are level are at right angles to one direction, and turn with the photos.
_LEVEL_TOGETHER_DEG, _TURNED_DEG = 5.0, 10.0
_LEVEL_DEG = 0.5
"""One sigma of a water line, a spirit-levelled staff or a built edge whose ends are picked."""
_PLUMB_DEG = 0.5
"""One sigma of a plumb bob's string, a hanging rope or a built edge whose ends are picked."""
MIN_APART_DEG = 15.0
"""Level lines nearer to each other count as one."""
UPRIGHT_SIGMA_DEG = 15.0
"""One sigma of the vertical by the upper edges of photos. People hold a camera level to some
degrees, but most look up at a cliff, all of them by as much as it is high."""
# Lines show the vertical, but not which of its ends is up: the one nearer to the model's z axis.
_UNCLEAR_DEG = 60.0


@dataclass(frozen=True)
class KnownDirection:
    """Two places on the model whose line is level, or vertical. sigma_deg : one sigma of that, None
    for what a water line, a spirit level, a plumb bob or a built edge gives; label : "" for its
    number"""

    first: tuple[float, float, float]
    second: tuple[float, float, float]
    sigma_deg: float | None = None
    label: str = ""


def level_lines_of(lines: Sequence[KnownDirection]) -> LevelLines:
    """Raises UsageError for a line whose ends are at one place."""
    sigma = [_LEVEL_DEG if line.sigma_deg is None else line.sigma_deg for line in lines]
    names = [
        line.label or tr("level line {number}", number=number)
        for number, line in enumerate(lines, 1)
    ]
    return LevelLines(
        names, _unit_vectors(lines, "--level"), np.radians(sigma), float(np.radians(MIN_APART_DEG))
    )


def plumb_lines_of(lines: Sequence[KnownDirection]) -> PlumbLines:
    """Raises UsageError for a line whose ends are at one place."""
    sigma = [_PLUMB_DEG if line.sigma_deg is None else line.sigma_deg for line in lines]
    names = [
        line.label or tr("plumb line {number}", number=number)
        for number, line in enumerate(lines, 1)
    ]
    each = np.repeat(np.radians(sigma)[:, None], 2, axis=1)
    return PlumbLines(names, _unit_vectors(lines, "--plumb"), each)


def _unit_vectors(lines: Sequence[KnownDirection], option: str) -> FloatArray:
    """(n, 3) from the first end to the second. Raises UsageError."""
    ends = np.array([(line.first, line.second) for line in lines], np.float64)
    along = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(along, axis=1)
    if not (length > 0).all():
        raise UsageError(
            Finding("line.one-place"),
            field=option,
        )
    return np.asarray(along / length[:, None])


def photo_upright_of(up: FloatArray) -> PhotoUpright:
    """Return the prior of the vertical from how photos were held. up : (3,) model"""
    sigma = np.full((1, 2), np.radians(UPRIGHT_SIGMA_DEG))
    return PhotoUpright([tr("upright of the photos")], up[None] / np.linalg.norm(up), sigma)


def vertical_findings(kinds: Sequence[Observed], rotation: FloatArray) -> list[Finding]:
    """Return what known lines leave open of the vertical. rotation : (3, 3) of the placed model"""
    findings = []
    for kind in kinds:
        if isinstance(kind, LevelLines) and kind.count_as_one:
            findings.append(
                Finding(
                    "registration.parallel-level-lines",
                    labels=list(kind.labels),
                    apart_deg=float(np.degrees(kind.apart)),
                )
            )
        if isinstance(kind, PhotoUpright):
            findings.append(Finding("registration.photo-upright", sigma_deg=UPRIGHT_SIGMA_DEG))
    tip_deg = float(np.degrees(np.arccos(np.clip(rotation[2, 2], -1.0, 1.0))))
    two_ended = LevelLines | PlumbLines
    by_lines = any(isinstance(kind, two_ended) for kind in kinds)
    if (
        by_lines
        and tip_deg > _UNCLEAR_DEG
        and all(isinstance(kind, two_ended | Azimuths | Lengths) for kind in kinds)
    ):
        findings.append(Finding("registration.which-end-up", tip_deg=tip_deg))
    return findings


def away_deg(view: View, ends: FloatArray, extent: FloatArray) -> float | None:
    """By how much a line on the model runs away from the camera, degrees out of the plane of the
    photo; None where the model is not at both ends (2, 2), pixels.

    extent : (n, 3) points all over the model
    """
    pixels = view.project(extent)
    depth = (extent - view.centre) @ view.rotation[2]
    there = np.isfinite(pixels).all(axis=1) & (depth > 0)
    limit = _NEAR * max(view.intrinsics.width, view.intrinsics.height)
    found = []
    for end in ends:
        near = there & (np.linalg.norm(np.nan_to_num(pixels, nan=np.inf) - end, axis=1) < limit)
        if not near.any():
            return None
        # What is seen is in front of what is hidden.
        ray = view.rays(end)[0]
        along = float(np.quantile(depth[near], 0.25)) / float(ray @ view.rotation[2])
        found.append(view.centre + along * ray)
    line = found[1] - found[0]
    length = float(np.linalg.norm(line))
    if not length > 0:
        return None
    return float(np.degrees(np.arcsin(min(1.0, abs(line @ view.rotation[2]) / length))))


def level_line_findings(
    photos: Sequence[str], views: Sequence[View], ends: FloatArray, extent: FloatArray | None
) -> list[Finding]:
    """Of lines (n, 2, 2), pixels, that run up and down their photos, and of those that lie on the
    model and run away from their cameras. Lines along a row or a column of pixels are axes of
    photos. Raises InputError for a line that ends outside of its photo."""
    _require_inside(photos, views, ends)
    findings = _upright_line_findings(photos, views, ends)
    if extent is None or not len(extent):
        return findings
    named, most = [], 0.0
    for photo, view, line in zip(photos, views, ends, strict=True):
        if (line[0] == line[1]).any():
            continue
        away = away_deg(view, line, extent)
        if away is not None and away > _AWAY_DEG:
            named.append(photo)
            most = max(most, away)
    if not named:
        return findings
    return [
        *findings,
        Finding("level.away", photos=named, away_deg=most),
    ]


def _require_inside(photos: Sequence[str], views: Sequence[View], ends: FloatArray) -> None:
    for photo, view, line in zip(photos, views, ends, strict=True):
        lens = view.intrinsics
        size = np.array([lens.width, lens.height], np.float64)
        if ((line < -_BEYOND * size) | (line > (1.0 + _BEYOND) * size)).any():
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
    """Of lines that run up and down their photos: level ones do so in photos held in portrait that
    were not turned. Those turn on the model as the photos do, while upright ones are parallel."""
    steps = np.asarray(ends[:, 1] - ends[:, 0])
    upright = np.abs(steps[:, 1]) > np.abs(steps[:, 0])
    if not upright.any():
        return []
    flat = [view.rays(line) for view, line in zip(views, ends, strict=True)]
    lines = np.array([rays[1] - rays[0] for rays in flat])
    lines /= np.linalg.norm(lines, axis=1, keepdims=True)
    _, _, axes = np.linalg.svd(lines)
    apart = _range_deg(np.arctan2(lines @ axes[1], lines @ axes[0]), 180.0)
    off = np.degrees(np.arcsin(np.minimum(np.abs(lines @ axes[2]), 1.0)))
    if apart > _TURNED_DEG and off.max() <= _LEVEL_TOGETHER_DEG:
        return []
    names = [photo for photo, up in zip(photos, upright, strict=True) if up]
    ahead = np.array([view.direction for view in views])
    turned = _range_deg(np.arctan2(ahead @ axes[2], ahead @ axes[1]), 360.0)
    if upright.all() and turned > _TURNED_DEG and apart < turned / 2.0:
        return [Finding("level.upright", photos=names)]
    return [Finding("level.portrait", photos=names)]


def _range_deg(angles_rad: FloatArray, whole: float) -> float:
    """The least arc that holds all angles, of lines that are the same after `whole` degrees."""
    turns = np.sort(np.degrees(angles_rad) % whole)
    gaps = np.diff(np.append(turns, turns[0] + whole))
    return float(whole - gaps.max())
