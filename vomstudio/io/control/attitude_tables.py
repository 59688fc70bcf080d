"""Camera attitudes from tables of apps, gimbals and other programs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.geology.view_attitudes import camera_rotations, nadir_to_view_angles
from vomstudio.io.control.geo_file import is_geo, read_geo
from vomstudio.io.text.named_columns import PHOTO_NAMES, NamedTable
from vomstudio.io.text.rows import shorten

_ANGLE_COLUMNS = (
    (
        "yaw",
        "heading",
        "azimuth",
        "bearing",
        "compass",
        "direction",
        "true heading",
        "magnetic heading",
        "camera yaw",
        "gimbal yaw",
        "gimbalyawdegree",
        "camerayawdegree",
        "gps img direction",
    ),
    (
        "pitch",
        "elevation angle",
        "inclination",
        "camera pitch",
        "gimbal pitch",
        "gimbalpitchdegree",
        "camerapitchdegree",
    ),
    ("roll", "bank", "camera roll", "gimbal roll", "gimbalrolldegree", "camerarolldegree"),
)
_ANGLE_NAMES = ("yaw", "pitch", "roll")
MAX_OVERSHOOT_DEG = 3.0
_NORTH_WORDS = {
    **dict.fromkeys(("", "grid", "g"), "grid"),
    **dict.fromkeys(("true", "t", "geographic"), "true"),
    **dict.fromkeys(("magnetic", "m", "mag"), "magnetic"),
}


@dataclass(frozen=True, eq=False)
class AttitudeTable:
    """Attitudes of n cameras.

    Attributes
    ----------
    angles, sigma : (n, 3) float64
        Yaw, pitch and roll in degrees; NaN if not stated. Yaw is the azimuth of the view,
        clockwise; pitch is 0 for a level view and -90 straight down; roll is 0 if the long side of
        the image is level, and increases clockwise as the photographer tilts the camera.
    down : (n, 3) float64
        Unit vectors of gravity in the camera frame (x right, y down, z forward); NaN if pitch and
        roll define the direction, or if it is unknown.
    north_references : tuple of str
        North reference of each yaw: "grid", "true" or "magnetic".
    is_doubted : bool
        Whether the yaws may have a common error, like those of a compass.
    days : tuple of date or None
        Dates of the readings, if known.
    coordinates : (n, 2) float64
        Longitude and latitude; NaN if unknown.
    notes : tuple of Finding
        Assumptions, or the reasons why the table contains no photos.
    """

    photos: tuple[str, ...]
    angles: FloatArray
    sigma: FloatArray
    north_references: tuple[str, ...]
    is_doubted: bool
    down: FloatArray
    days: tuple[date | None, ...]
    coordinates: FloatArray
    notes: tuple[Finding, ...] = ()


def read_attitudes(path: str | Path, north: str = "grid") -> AttitudeTable:
    """Read a table of attitudes or a `geo.txt` file of OpenDroneMap.

    The columns are `photo, yaw, pitch, roll[, sigma_yaw, sigma_pitch, sigma_roll][, north]`, or
    their names in other programs; either yaw, or pitch and roll, may be missing.

    Parameters
    ----------
    path : str or Path
    north : str
        North reference if the table does not state one: "grid", "true" or "magnetic". The yaws of a
        `geo.txt` file always refer to true north.

    Raises
    ------
    InputError
        If the table is not valid; states file, line and column.
    """
    path = Path(path)
    if is_geo(path):
        return _read_geo_attitudes(path)
    table = NamedTable(path, ("photo", *_ANGLE_NAMES))
    photos = table.words(PHOTO_NAMES, "photo")
    table.require_unique(photos)
    angles = np.full((len(photos), 3), np.nan)
    has_angle = [table.has(names) for names in _ANGLE_COLUMNS]
    if has_angle[1] != has_angle[2] or not any(has_angle):
        missing_name = _ANGLE_NAMES[has_angle.index(False)]
        table.columns((_ANGLE_COLUMNS[has_angle.index(False)],), (missing_name,))
    for column, names in enumerate(_ANGLE_COLUMNS):
        if has_angle[column]:
            angles[:, column] = table.columns((names,), (_ANGLE_NAMES[column],))[:, 0]
    _require_angles(table, angles)
    sigma = np.column_stack(
        [
            table.positive_numbers((f"sigma {n}", f"accuracy {n}", f"error {n}"), f"sigma_{n}")
            for n in _ANGLE_NAMES
        ]
    )
    north_references = _north_references(table, len(photos), north)
    has_yaw = np.isfinite(angles[:, 0])
    is_accuracy_unknown = bool(has_yaw.any()) and not np.isfinite(sigma[has_yaw, 0]).any()
    notes: tuple[Finding, ...] = ()
    if is_accuracy_unknown and "magnetic" not in north_references:
        notes = (Finding("cameras.yaw-accuracy-unknown"),)
    is_doubted = is_accuracy_unknown or "magnetic" in north_references
    return attitude_table(
        photos, angles, sigma, north_references, is_doubted=is_doubted, notes=notes
    )


def attitude_table(
    photos: tuple[str, ...],
    angles: FloatArray,
    sigma: FloatArray | None = None,
    north_references: tuple[str, ...] | None = None,
    *,
    is_doubted: bool = False,
    down: FloatArray | None = None,
    days: tuple[date | None, ...] | None = None,
    positions: FloatArray | None = None,
    notes: tuple[Finding, ...] = (),
) -> AttitudeTable:
    """Return a table, with defaults for the values that are not given.

    Missing numbers are NaN, missing dates are None, and the default north reference is "grid".
    """
    n = len(photos)
    return AttitudeTable(
        photos,
        angles,
        np.full((n, 3), np.nan) if sigma is None else sigma,
        ("grid",) * n if north_references is None else north_references,
        is_doubted,
        np.full((n, 3), np.nan) if down is None else down,
        (None,) * n if days is None else days,
        np.full((n, 2), np.nan) if positions is None else positions,
        notes,
    )


def empty_attitude_table(notes: Sequence[Finding]) -> AttitudeTable:
    """Return a table without photos whose notes state the reasons."""
    return attitude_table((), np.empty((0, 3)), notes=tuple(notes))


def gravity_directions(table: AttitudeTable) -> FloatArray:
    """Return the direction of gravity (n, 3) in the frame of each camera.

    The direction is measured or computed from pitch and roll; NaN if neither is known.
    """
    down = table.down.copy()
    is_computed = np.isnan(down[:, 0]) & np.isfinite(table.angles[:, 1:]).all(axis=1)
    tilts = np.column_stack([np.zeros(int(is_computed.sum())), table.angles[is_computed, 1:]])
    down[is_computed] = -camera_rotations(tilts)[:, 2, :]
    return down


def _require_angles(table: NamedTable, angles: FloatArray) -> None:
    """Check the angles, and wrap roll to ±180 degrees. Raises InputError."""
    angles[:, 2] = np.where(angles[:, 2] > 180.0, angles[:, 2] - 360.0, angles[:, 2])
    for column, minimum, maximum in ((0, -360.0, 360.0), (1, -90.0, 90.0), (2, -180.0, 180.0)):
        # A gimbal that points straight down may swing slightly beyond the vertical.
        overshoot = MAX_OVERSHOOT_DEG if column == 1 else 0.0
        is_outside = (angles[:, column] < minimum - overshoot) | (
            angles[:, column] > maximum + overshoot
        )
        for row in np.flatnonzero(is_outside):
            finding = Finding(
                "angle.out-of-range",
                value=angles[row, column],
                minimum=minimum,
                maximum=maximum,
            )
            if column == 1 and (angles[:, 1] >= -1e-9).all() and angles[row, 1] <= 180.0:
                finding = Finding("cameras.pitch-from-nadir")
            raise table.cell_error(int(row), finding, _ANGLE_NAMES[column])


def _north_references(table: NamedTable, n: int, default_north: str) -> tuple[str, ...]:
    if table.has(("north",)):
        north_references = []
        for row, word in enumerate(table.words(("north",), "north", allow_empty=True)):
            north = _NORTH_WORDS.get(word.casefold())
            if north is None:
                finding = Finding(
                    "table.unknown-word", cell=shorten(word), words=("grid", "true", "magnetic")
                )
                raise table.cell_error(row, finding, "north")
            north_references.append(north if word else default_north)
        return tuple(north_references)
    if table.has(("magnetic heading",)):
        return ("magnetic",) * n
    header = " ".join(table.table.names or ()).casefold()
    if "(magnetic)" in header:
        return ("magnetic",) * n
    if "(true)" in header or table.has(("true heading",)):
        return ("true",) * n
    return (default_north,) * n


def _read_geo_attitudes(path: Path) -> AttitudeTable:
    geo = read_geo(path)
    rows = np.flatnonzero(np.isfinite(geo.angles).all(axis=1))
    if not len(rows):
        raise InputError(Finding("cameras.no-angles"), file=path, line=geo.lines[0], field="yaw")
    photos = tuple(geo.photos[i] for i in rows)
    if not geo.angles[rows].any():
        return empty_attitude_table(
            [Finding("photo.angles-not-measured", photos=len(photos), photo=photos[0])]
        )
    note = Finding("cameras.opendronemap-angles", file=path.name)
    angles = nadir_to_view_angles(geo.angles[rows])
    north_references = ("true",) * len(rows)
    return attitude_table(photos, angles, None, north_references, is_doubted=True, notes=(note,))
