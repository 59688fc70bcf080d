"""How cameras were held, as observations: whole attitudes, or the vertical and north apart."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.findings import Finding
from vomstudio.geology.bowing import Bowing, bowing_of_turns
from vomstudio.geology.view_attitudes import (
    camera_rotations,
    error_axes,
    from_down_and_azimuth,
    view_angles,
)
from vomstudio.geometry.cameras import View
from vomstudio.io.control.attitude_tables import AttitudeTable, down_of
from vomstudio.registration.attitude_checks import left_out, verticals_left_out
from vomstudio.registration.observations import Attitudes, Azimuths, Observed, Verticals
from vomstudio.registration.similarity import Similarity

NORTH_DOUBT_DEG = 10.0
"""One sigma of a compass's north until it has been checked: steel, rocks, the phone itself."""
MOUNT_DOUBT_DEG = 1.0
"""One sigma of what a gimbal or an accelerometer is out of line with its camera, about each axis,
where no accuracy is stated. It is the same in all photos, which do not show it unless they look to
several sides. (A drone that writes -89.9 degrees looked 1.5 degrees beside the vertical.)"""
_WRONG = 6.0
"""A photo's vertical is wrong that is so many times further off than half of them are."""
# The azimuth of a view that is steeper says nothing that the phone's compass could have meant.
_STEEPEST_DEG = 60.0


@dataclass(frozen=True, eq=False)
class Held:
    """kinds : observations; angles, model : (n, 3), (n, 3, 3) of the photos whose attitude is
    wholly known, in World and in the model"""

    kinds: tuple[Observed, ...]
    angles: FloatArray
    model: FloatArray


def held(
    table: AttitudeTable,
    rows: Sequence[int],
    views: Sequence[View],
    north_doubt_deg: float,
    messages: list[Finding],
) -> Held:
    """Match the attitudes of a table, with yaws from grid north, to the cameras of the model.

    messages : messages about excluded attitudes are appended
    """
    which = np.asarray(rows, int)
    labels = [table.photos[row] for row in rows]
    model = np.array([np.asarray(view.rotation).T for view in views]).reshape(-1, 3, 3)
    angles, sigma = table.angles[which], np.radians(table.sigma[which])
    down = down_of(table)[which]
    whole = np.isfinite(angles).all(axis=1)
    yaw, tilt = np.isfinite(angles[:, 0]), np.isfinite(down[:, 0])
    phone = yaw & tilt & ~whole
    phone &= _not_steep(labels, phone, down, messages)
    both = whole | phone
    known = np.full_like(angles, np.nan)
    known[whole] = angles[whole]
    if phone.any():
        known[phone] = view_angles(from_down_and_azimuth(down[phone], angles[phone, 0]))
    bad, tilted = np.zeros((2, len(labels)), bool)
    bad[both], tilted[both] = left_out(_chosen(labels, both), known[both], model[both], messages)
    tilted[tilt] |= verticals_left_out(
        _chosen(labels, tilt), down[tilt], model[tilt], ~both[tilt], messages
    )
    shared = float(np.radians(north_doubt_deg)) if table.doubted else 0.0
    unstated = np.isnan(sigma[:, 1:]).any()
    mount = float(np.radians(MOUNT_DOUBT_DEG)) if unstated else 0.0
    kinds: list[Observed] = [
        _attitudes(labels, whole & ~bad, angles, model, sigma, shared, mount),
        # Of a photo whose compass was wrong the vertical is still right.
        _verticals(labels, tilt & (~whole | bad) & ~tilted, down, model, sigma, mount),
        _norths(labels, yaw & ~whole & ~bad & (phone | ~tilt), angles, model, sigma, shared),
    ]
    good = both & ~bad
    return Held(tuple(k for k in kinds if len(k.labels)), known[good], model[good])


@dataclass(frozen=True)
class AttitudeMiss:
    """How far a photo's attitude is from that in the placed model: placed less given, degrees about
    the axes of `error_axes`; None for what the photo does not say."""

    photo: str
    yaw_deg: float | None
    pitch_deg: float | None
    roll_deg: float | None


def misses(
    table: AttitudeTable, rows: Sequence[int], views: Sequence[View], rotation: FloatArray
) -> list[AttitudeMiss]:
    """Of the rows of a table, also those that took no part; rotation : (3, 3) of the placed
    model."""
    if not rows:
        return []
    turns, yaw, tilt = _turns(table, rows, views, rotation)
    off = np.degrees(np.einsum("nji,nj->ni", error_axes(np.column_stack([yaw, yaw, yaw])), turns))
    given = table.angles[np.asarray(rows, int)]
    known = np.column_stack([np.isfinite(given[:, 0]), tilt, tilt])
    return [
        AttitudeMiss(
            table.photos[row],
            *(float(v) if k else None for v, k in zip(off[i], known[i], strict=True)),
        )
        for i, row in enumerate(rows)
    ]


def bowing_by_tilts(
    table: AttitudeTable,
    rows: Sequence[int],
    views: Sequence[View],
    placed: Similarity,
    extent: FloatArray | None,
) -> Bowing | None:
    """The bowing that the verticals of photos show in a placed model, wrong ones left out; extent :
    (m, 3) points of the model, in its own frame; None where they tell nothing of it."""
    if not rows:
        return None
    turns, _, tilt = _turns(table, rows, views, placed.rotation)
    aside = turns[:, :2] - np.median(turns[tilt, :2], axis=0) if tilt.any() else turns[:, :2]
    length = np.hypot(*aside.T)
    right = tilt & (length <= _WRONG * float(np.median(length[tilt])) if tilt.any() else tilt)
    places = placed(np.array([view.centre for view in views]))
    reach = None if extent is None or not len(extent) else placed(extent)
    cameras = placed.rotation @ np.array([np.asarray(view.rotation).T for view in views])
    return bowing_of_turns(places[right], turns[right], cameras[right], reach)


def _turns(
    table: AttitudeTable, rows: Sequence[int], views: Sequence[View], rotation: FloatArray
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """By how much each photo is turned in the placed model against what it says, (n, 3) radians,
    World; its yaw, (n,) degrees, and whether it tells the vertical."""
    from scipy.spatial.transform import Rotation

    which = np.asarray(rows, int)
    given, down = table.angles[which], down_of(table)[which]
    placed = rotation @ np.array([np.asarray(view.rotation).T for view in views])
    seen = view_angles(placed)
    tilt = np.isfinite(down[:, 0])
    yaw = np.where(np.isfinite(given[:, 0]), given[:, 0], seen[:, 0])
    there = camera_rotations(np.column_stack([yaw, seen[:, 1:]]))
    there[tilt] = from_down_and_azimuth(down[tilt], yaw[tilt])
    whole = np.isfinite(given).all(axis=1)
    there[whole] = camera_rotations(given[whole])
    turns: FloatArray = Rotation.from_matrix(placed @ np.swapaxes(there, 1, 2)).as_rotvec()
    return turns, yaw, tilt


def _attitudes(
    labels: Sequence[str],
    which: BoolArray,
    angles: FloatArray,
    model: FloatArray,
    sigma: FloatArray,
    shared: float,
    mount: float,
) -> Attitudes:
    world, axes = camera_rotations(angles[which]), error_axes(angles[which])
    return Attitudes(_chosen(labels, which), model[which], world, axes, sigma[which], shared, mount)


def _verticals(
    labels: Sequence[str],
    which: BoolArray,
    down: FloatArray,
    model: FloatArray,
    sigma: FloatArray,
    mount: float,
) -> Verticals:
    there = np.einsum("nij,nj->ni", model[which], down[which])
    names = _chosen(labels, which)
    return Verticals(names, there, sigma[which, 1:], model[which], mount)


def _norths(
    labels: Sequence[str],
    which: BoolArray,
    angles: FloatArray,
    model: FloatArray,
    sigma: FloatArray,
    shared: float,
) -> Azimuths:
    names = _chosen(labels, which)
    azimuths = np.radians(angles[which, 0])
    return Azimuths(names, model[which][:, :, 2], azimuths, sigma[which, 0], shared)


def _not_steep(
    labels: Sequence[str], phone: BoolArray, down: FloatArray, messages: list[Finding]
) -> BoolArray:
    steep = phone & (np.abs(down[:, 2]) > np.sin(np.radians(_STEEPEST_DEG)))
    if steep.any():
        messages.append(Finding("attitude.too-steep", photos=_chosen(labels, steep)))
    return np.asarray(~steep)


def _chosen(labels: Sequence[str], which: BoolArray) -> list[str]:
    return [labels[int(i)] for i in np.flatnonzero(which)]
