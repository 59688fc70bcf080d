"""How cameras were held, as tables of apps, gimbals and other programs have it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.geology.view_attitudes import camera_rotations, of_nadir_body
from vomstudio.io.control.geo_file import is_geo, read_geo
from vomstudio.io.text.named_columns import PHOTO, NamedTable
from vomstudio.io.text.rows import shorten

_ANGLES = (
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
_NAMES = ("yaw", "pitch", "roll")
_SWING = 3.0
_NORTHS = {
    **dict.fromkeys(("", "grid", "g"), "grid"),
    **dict.fromkeys(("true", "t", "geographic"), "true"),
    **dict.fromkeys(("magnetic", "m", "mag"), "magnetic"),
}


@dataclass(frozen=True, eq=False)
class AttitudeTable:
    """How n cameras were held.

    angles, sigma : (n, 3) degrees of yaw, pitch and roll; NaN where not given. yaw : azimuth of the
        view, clockwise; pitch : 0 level, -90 straight down; roll : 0 with the image's long side
        level, clockwise as the photographer tilts the camera
    down : (n, 3) the direction in which things fall, in the frame of the camera (x right, y down, z
        forward), unit vectors; NaN where pitch and roll say it, or nothing does
    norths : what each yaw is counted from: "grid", "true" or "magnetic"
    doubted : yaws are of a compass, which may be wrong for all photos alike
    days : when each was read, None where that is not known; places : (n, 2) longitude and latitude,
        NaN where not known
    notes : what was assumed, or why there are no photos
    """

    photos: tuple[str, ...]
    angles: FloatArray
    sigma: FloatArray
    norths: tuple[str, ...]
    doubted: bool
    down: FloatArray
    days: tuple[date | None, ...]
    places: FloatArray
    notes: tuple[Finding, ...] = ()


def read_attitudes(path: str | Path, north: str = "grid") -> AttitudeTable:
    """`photo, yaw, pitch, roll[, sigma_yaw, sigma_pitch, sigma_roll][, north]`, in the words of
    other programs too; yaw, or pitch and roll, may be missing; or the `geo.txt` of OpenDroneMap.

    north : from which yaws are counted where the table does not say: "grid", "true", "magnetic"
    Raises InputError with file, line and column.
    """
    path = Path(path)
    if is_geo(path):
        return _of_geo(path)
    table = NamedTable(path, ("photo", *_NAMES))
    photos = table.words(PHOTO, "photo")
    table.require_unique(photos)
    angles = np.full((len(photos), 3), np.nan)
    there = [table.has(names) for names in _ANGLES]
    if there[1] != there[2] or not any(there):
        missing = _NAMES[there.index(False)]
        table.columns((_ANGLES[there.index(False)],), (missing,))
    for column, names in enumerate(_ANGLES):
        if there[column]:
            angles[:, column] = table.columns((names,), (_NAMES[column],))[:, 0]
    _require_angles(table, angles)
    sigma = np.column_stack(
        [
            table.positive((f"sigma {n}", f"accuracy {n}", f"error {n}"), f"sigma_{n}")
            for n in _NAMES
        ]
    )
    norths = _norths(table, len(photos), north)
    yaws = np.isfinite(angles[:, 0])
    unstated = bool(yaws.any()) and not np.isfinite(sigma[yaws, 0]).any()
    notes: tuple[Finding, ...] = ()
    if unstated and "magnetic" not in norths:
        notes = (Finding("cameras.yaw-accuracy-unknown"),)
    doubted = unstated or "magnetic" in norths
    return attitude_table(photos, angles, sigma, norths, doubted=doubted, notes=notes)


def attitude_table(
    photos: tuple[str, ...],
    angles: FloatArray,
    sigma: FloatArray | None = None,
    norths: tuple[str, ...] | None = None,
    *,
    doubted: bool = False,
    down: FloatArray | None = None,
    days: tuple[date | None, ...] | None = None,
    places: FloatArray | None = None,
    notes: tuple[Finding, ...] = (),
) -> AttitudeTable:
    """With what is not known left empty."""
    n = len(photos)
    return AttitudeTable(
        photos,
        angles,
        np.full((n, 3), np.nan) if sigma is None else sigma,
        ("grid",) * n if norths is None else norths,
        doubted,
        np.full((n, 3), np.nan) if down is None else down,
        (None,) * n if days is None else days,
        np.full((n, 2), np.nan) if places is None else places,
        notes,
    )


def without_attitudes(notes: Sequence[Finding]) -> AttitudeTable:
    """Return a table without photos, with the reasons."""
    return attitude_table((), np.empty((0, 3)), notes=tuple(notes))


def down_of(table: AttitudeTable) -> FloatArray:
    """(n, 3) the direction in which things fall, in the frame of each camera: as it was measured,
    or as pitch and roll say; NaN where neither is known."""
    down = table.down.copy()
    told = np.isnan(down[:, 0]) & np.isfinite(table.angles[:, 1:]).all(axis=1)
    tilts = np.column_stack([np.zeros(int(told.sum())), table.angles[told, 1:]])
    down[told] = -camera_rotations(tilts)[:, 2, :]
    return down


def _require_angles(table: NamedTable, angles: FloatArray) -> None:
    """And bring roll within half a turn. Raises InputError."""
    angles[:, 2] = np.where(angles[:, 2] > 180.0, angles[:, 2] - 360.0, angles[:, 2])
    for column, lowest, highest in ((0, -360.0, 360.0), (1, -90.0, 90.0), (2, -180.0, 180.0)):
        # A gimbal that looks straight down swings a little beyond.
        beyond = _SWING if column == 1 else 0.0
        outside = (angles[:, column] < lowest - beyond) | (angles[:, column] > highest + beyond)
        for row in np.flatnonzero(outside):
            finding = Finding(
                "angle.out-of-range",
                value=angles[row, column],
                minimum=lowest,
                maximum=highest,
            )
            if column == 1 and (angles[:, 1] >= -1e-9).all() and angles[row, 1] <= 180.0:
                finding = Finding("cameras.pitch-from-nadir")
            raise table.at(int(row), finding, _NAMES[column])


def _norths(table: NamedTable, n: int, usual: str) -> tuple[str, ...]:
    if table.has(("north",)):
        found = []
        for row, word in enumerate(table.words(("north",), "north", empty=True)):
            north = _NORTHS.get(word.casefold())
            if north is None:
                finding = Finding(
                    "table.unknown-word", cell=shorten(word), words=("grid", "true", "magnetic")
                )
                raise table.at(row, finding, "north")
            found.append(north if word else usual)
        return tuple(found)
    if table.has(("magnetic heading",)):
        return ("magnetic",) * n
    heads = " ".join(table.table.names or ()).casefold()
    if "(magnetic)" in heads:
        return ("magnetic",) * n
    if "(true)" in heads or table.has(("true heading",)):
        return ("true",) * n
    return (usual,) * n


def _of_geo(path: Path) -> AttitudeTable:
    geo = read_geo(path)
    rows = np.flatnonzero(np.isfinite(geo.angles).all(axis=1))
    if not len(rows):
        raise InputError(Finding("cameras.no-angles"), file=path, line=geo.lines[0], field="yaw")
    photos = tuple(geo.photos[i] for i in rows)
    if not geo.angles[rows].any():
        return without_attitudes(
            [Finding("photo.angles-not-measured", photos=len(photos), photo=photos[0])]
        )
    note = Finding("cameras.opendronemap-angles", file=path.name)
    angles = of_nadir_body(geo.angles[rows])
    norths = ("true",) * len(rows)
    return attitude_table(photos, angles, None, norths, doubted=True, notes=(note,))
