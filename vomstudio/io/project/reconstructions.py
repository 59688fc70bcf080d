"""What a finished reconstruction is to the document: its record, and the registration it found;
and how its files go along when a project is saved elsewhere."""

from __future__ import annotations

import hashlib
import json
import math
import os
import shutil
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal

from vomstudio.document.edits import new_id
from vomstudio.document.records import (
    Frame,
    Reconstruction,
    Registration,
    RegistrationPoint,
)
from vomstudio.document.records.basics import Point
from vomstudio.errors import InputError, TargetError
from vomstudio.files.disk_troubles import reason_of
from vomstudio.files.inside import links_of
from vomstudio.files.regular import JSON_BYTES, read_json, read_small
from vomstudio.words import tr

RECONSTRUCTIONS = "reconstruction"
"""The folder of what is made of photos, one folder in it for each set and quality."""
RESULT, REQUEST = "reconstruction.json", "request.json"
# What a reconstruction adds lines to; all else is written once, under another name.
_LARGEST_COPIED = 1 << 20
_METHODS: dict[str, Literal["gps", "control"]] = {
    "camera positions (GPS)": "gps",
    "ground control points": "control",
}


def read_reconstruction(
    folder: Path, photo_set_id: str, name: str
) -> tuple[Reconstruction, Registration]:
    """The records of what a run has left in `folder`. Raises InputError."""
    path = folder / RESULT
    try:
        data = read_small(path, JSON_BYTES)
        found = json.loads(data)
        finished = datetime.fromtimestamp(path.stat().st_mtime, UTC).isoformat(timespec="seconds")
    except (InputError, OSError, ValueError, RecursionError) as error:
        raise InputError(
            tr("The file cannot be read: the results of the reconstruction are lost."), file=path
        ) from (error)
    if not isinstance(found, dict):
        raise InputError(tr("This is not the result of a reconstruction."), file=path)
    settings = found.get("settings")
    versions = found.get("versions")
    reconstruction = Reconstruction(
        new_id("reconstruction"),
        photo_set_id,
        name,
        folder.name,
        str(settings.get("quality", "")) if isinstance(settings, dict) else "",
        hashlib.sha256(data).hexdigest(),
        _pairs(settings),
        _count(found.get("photos")),
        _count(found.get("registered")),
        _number(found.get("reprojection_error_px")),
        str(versions.get("vomstudio", "")) if isinstance(versions, dict) else "",
        finished,
    )
    return reconstruction, registration_of(found, reconstruction.name, reconstruction.id)


def registration_of(
    found: Mapping[str, Any], name: str, reconstruction_id: str = ""
) -> Registration:
    """The registration that the result of a reconstruction with this name states."""
    told = found.get("registration")
    told = told if isinstance(told, dict) else {}
    method: Literal["gps", "control", "local"]
    method = _METHODS.get(str(told.get("method")), "local")
    words = {"gps": "GPS of the cameras", "control": "control points", "local": "photos only"}
    crs = found.get("frame")
    if isinstance(crs, str) and crs != "local":
        frame = Frame("crs", crs)
    else:
        frame = Frame("local") if found.get("scaled") else Frame()
    errors = told.get("rotation_error_deg")
    axes = ("about_up", "about_east", "about_north")
    turned = [_number(errors.get(axis)) for axis in axes] if isinstance(errors, dict) else []
    shape, lens = (
        each if isinstance(each, dict) else {} for each in map(told.get, ("shape", "lens_bowing"))
    )
    return Registration(
        new_id("registration"),
        f"{words[method]}, {name}",
        method,
        frame,
        reconstruction_id=reconstruction_id,
        rotation_error_deg=(
            (turned[0], turned[1], turned[2])
            if len(turned) == 3
            and turned[0] is not None
            and turned[1] is not None
            and turned[2] is not None
            else None
        ),
        scale_error=_number(told.get("scale_error")),
        rms_control_m=_number(told.get("rms_control_m")),
        rms_check_m=_number(told.get("rms_check_m")),
        control=_judged_by(told),
        covariance=_covariance(told.get("covariance")),
        centre=_place(told.get("centre")),
        reach_m=_number(shape.get("reach_m")),
        normal=_place(shape.get("normal")),
        lens_bowing95_deg=_number(lens.get("edge_to_edge95_deg")),
        lens_stretch95=_number(lens.get("stretch95")),
    )


def placing_error_m(model: Path) -> float | None:
    """How far a model that a run has left in its folder may be off as a whole, one sigma along any
    direction: of the check points, else of the control points that placed it. None where nothing
    beside it says so."""
    try:
        told = read_json(model.with_name(RESULT))["registration"]
        rms = _number(told.get("rms_check_m")) or _number(told.get("rms_control_m"))
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None
    return None if rms is None else rms / math.sqrt(3.0)


def _judged_by(told: Mapping[str, Any]) -> tuple[RegistrationPoint, ...]:
    """The control points, or positions of cameras, that count. The model is in World already, so
    that a place in it is the surveyed one and what is left over."""
    found = []
    for row in _rows(told.get("points")):
        if row.get("role") in ("control", "check"):
            found.append((row.get("label"), row.get("residual_m"), row, row["role"] == "check"))
    for row in _rows(told.get("residuals")):
        if row.get("used") is True:
            found.append(
                (row.get("name"), [row.get(axis) for axis in ("dx", "dy", "dz")], row, False)
            )
    points = []
    for label, left, row, check in found:
        residual, world = _place(left), _place(row.get("surveyed"))
        if residual is not None and world is not None:
            x, y, z = (a + b for a, b in zip(world, residual, strict=True))
            points.append(RegistrationPoint(str(label), (x, y, z), world, residual, None, check))
    return tuple(points)


def _rows(value: object) -> list[dict[str, Any]]:
    return [row for row in value if isinstance(row, dict)] if isinstance(value, list) else []


def _place(value: object) -> Point | None:
    if not isinstance(value, list | tuple) or len(value) != 3:
        return None
    x, y, z = (_number(v) for v in value)
    return None if x is None or y is None or z is None else (x, y, z)


def _covariance(value: object) -> tuple[tuple[float, ...], ...] | None:
    if not isinstance(value, list) or len(value) != 7:
        return None
    rows = [[_number(v) for v in row] for row in value if isinstance(row, list) and len(row) == 7]
    if len(rows) != 7:
        return None
    known = tuple(tuple(v for v in row if v is not None) for row in rows)
    return known if all(len(row) == 7 for row in known) else None


def _pairs(settings: object) -> tuple[tuple[str, str], ...]:
    if not isinstance(settings, dict):
        return ()
    return tuple((str(k), "" if v is None else str(v)) for k, v in settings.items())


def _count(value: object) -> int:
    return value if isinstance(value, int) else 0


def _number(value: object) -> float | None:
    if not isinstance(value, int | float) or not math.isfinite(value):
        return None
    return float(value)


# --- their files -------------------------------------------------------------------------
def copy_reconstructions(source: Path, target: Path) -> None:
    """What is finished. Large files are shared where the disk can do it: none is ever changed, a
    new one takes its place."""

    def take(one: str, other: str) -> object:
        if Path(one).stat().st_size > _LARGEST_COPIED:
            try:
                os.link(one, other)
                return other
            except OSError:
                pass
        return shutil.copy2(one, other)

    def unfinished(folder: str, names: list[str]) -> set[str]:
        links = links_of(folder, names)
        below = Path(folder).relative_to(source / RECONSTRUCTIONS).parts
        if below[1:2] != ("work",):
            return links
        locks = {n for n in names if n.startswith("lock")} if len(below) == 2 else set()
        return links | locks | {n for n in names if n.endswith(".part")}

    if (source / RECONSTRUCTIONS).is_dir():
        shutil.copytree(
            source / RECONSTRUCTIONS,
            target / RECONSTRUCTIONS,
            copy_function=take,
            ignore=unfinished,
        )


def move_reconstructions(source: Path, target: Path) -> None:
    """Raises TargetError; then they are where they were."""
    if not (source / RECONSTRUCTIONS).is_dir():
        return
    try:
        (source / RECONSTRUCTIONS).rename(target / RECONSTRUCTIONS)
        return
    except OSError:
        # A folder of the same disk that is mounted elsewhere, or a file that somebody has open.
        pass
    try:
        copy_reconstructions(source, target)
    except OSError as error:
        shutil.rmtree(target / RECONSTRUCTIONS, ignore_errors=True)
        raise TargetError(
            tr(
                "The project is saved, but its reconstructions cannot be moved to it "
                "({reason}). They stay in {source}.",
                reason=reason_of(target, error),
                source=source / RECONSTRUCTIONS,
            ),
            file=target,
        ) from error
