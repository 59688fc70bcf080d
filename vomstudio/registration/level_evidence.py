"""Level lines on a model as observations of its place, and whether level lines that were marked in
photos show the level: a horizon does, and the axis of a photo that was held level. A level line on
the outcrop that runs away from the camera does not in its photo: perspective tilts it, as that of a
roof seen from below."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.errors import InputError, UsageError
from vomstudio.geometry.cameras import View
from vomstudio.registration.listed_names import listed
from vomstudio.registration.observations import LevelLines
from vomstudio.words import tr

Array = npt.NDArray[np.float64]

# Of the photo's long side: a point of the model this near to the end of a line is at that end.
_NEAR = 0.02
_AWAY_DEG = 2.0
# Of the photo's size: a line may reach so far beyond its edge.
_BEYOND = 0.1
# Lines that are level are at right angles to one direction, and turn with the photos.
_LEVEL_TOGETHER_DEG, _TURNED_DEG = 5.0, 10.0
_LEVEL_DEG = 0.5
"""One sigma of a water line, a spirit-levelled staff or a built edge whose ends are picked."""


@dataclass(frozen=True)
class LevelLine:
    """Two places on the model that are at one height. sigma_deg : how level that is known to be,
    one sigma; None for what a water line, a spirit level or a built edge gives; label : "" for its
    number"""

    first: tuple[float, float, float]
    second: tuple[float, float, float]
    sigma_deg: float | None = None
    label: str = ""


def level_lines_of(lines: Sequence[LevelLine]) -> LevelLines:
    """Raises UsageError for a line whose ends are at one place."""
    ends = np.array([(line.first, line.second) for line in lines], np.float64)
    along = ends[:, 1] - ends[:, 0]
    length = np.linalg.norm(along, axis=1)
    if not (length > 0).all():
        raise UsageError(
            tr("Both ends of a level line are at one place of the model. Choose two places."),
            field="--level",
        )
    sigma = [_LEVEL_DEG if line.sigma_deg is None else line.sigma_deg for line in lines]
    names = [
        line.label or tr("level line {number}", number=number)
        for number, line in enumerate(lines, 1)
    ]
    return LevelLines(names, along / length[:, None], np.radians(sigma))


def away_deg(view: View, ends: Array, extent: Array) -> float | None:
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


def said_of_level_lines(
    photos: Sequence[str], views: Sequence[View], ends: Array, extent: Array | None
) -> list[str]:
    """Of lines (n, 2, 2), pixels, that run up and down their photos, and of those that lie on the
    model and run away from their cameras. Lines along a row or a column of pixels are axes of
    photos. Raises InputError for a line that ends outside of its photo."""
    _require_inside(photos, views, ends)
    said = _said_of_upright(photos, views, ends)
    if extent is None or not len(extent):
        return said
    named, most = [], 0.0
    for photo, view, line in zip(photos, views, ends, strict=True):
        if (line[0] == line[1]).any():
            continue
        away = away_deg(view, line, extent)
        if away is not None and away > _AWAY_DEG:
            named.append(photo)
            most = max(most, away)
    if not named:
        return said
    return [
        *said,
        tr(
            "The level lines in {photos} lie on the model and run away from the camera, by up to "
            "{away:.0f}°. Only a horizon, or the axis of a photo held level, shows the level so: "
            "if these are lines on the outcrop, perspective tilts them and the model with them, by "
            "more than is stated. Mark a horizon or the axes of photos that were held level "
            "instead.",
            photos=listed(named),
            away=most,
        ),
    ]


def _require_inside(photos: Sequence[str], views: Sequence[View], ends: Array) -> None:
    for photo, view, line in zip(photos, views, ends, strict=True):
        lens = view.intrinsics
        size = np.array([lens.width, lens.height], np.float64)
        if ((line < -_BEYOND * size) | (line > (1.0 + _BEYOND) * size)).any():
            (x1, y1), (x2, y2) = line.tolist()
            raise InputError(
                tr(
                    "The level line from x {x1:.0f}, y {y1:.0f} to x {x2:.0f}, y {y2:.0f} ends "
                    "outside of {photo}, which has {width} x {height} pixels. Correct it.",
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


def _said_of_upright(photos: Sequence[str], views: Sequence[View], ends: Array) -> list[str]:
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
    told = listed(names)
    ahead = np.array([view.direction for view in views])
    turned = _range_deg(np.arctan2(ahead @ axes[2], ahead @ axes[1]), 360.0)
    if upright.all() and turned > _TURNED_DEG and apart < turned / 2.0:
        return [
            tr(
                "The lines in {photos} run up and down their photos, and are parallel although the "
                "photos look different ways: they are upright, not level. Mark level lines.",
                photos=told,
            )
        ]
    return [
        tr(
            "The level lines in {photos} run up and down their photos, as upright lines do. If "
            "these photos were not held in portrait, mark lines that are level.",
            photos=told,
        )
    ]


def _range_deg(angles_rad: Array, whole: float) -> float:
    """The least arc that holds all angles, of lines that are the same after `whole` degrees."""
    turns = np.sort(np.degrees(angles_rad) % whole)
    gaps = np.diff(np.append(turns, turns[0] + whole))
    return float(whole - gaps.max())
