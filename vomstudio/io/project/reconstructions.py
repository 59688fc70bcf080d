"""What a finished reconstruction is to the document: its record, and the registration it found."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Literal

from vomstudio.document.edits import new_id
from vomstudio.document.records import Frame, Point, Reconstruction, Registration
from vomstudio.errors import InputError
from vomstudio.words import tr

RESULT, REQUEST = "reconstruction.json", "request.json"
_METHODS: dict[str, Literal["gps", "control"]] = {
    "camera positions (GPS)": "gps",
    "ground control points": "control",
}


def asked(folder: Path) -> Mapping[str, Any] | None:
    """What a run in `folder` was asked for; None where it cannot be read."""
    try:
        found = json.loads((folder / REQUEST).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return found if isinstance(found, dict) and isinstance(found.get("photos"), str) else None


def read_reconstruction(
    folder: Path, photo_set_id: str, name: str
) -> tuple[Reconstruction, Registration]:
    """The records of what a run has left in `folder`. Raises InputError."""
    path = folder / RESULT
    try:
        data = path.read_bytes()
        found = json.loads(data)
        finished = datetime.fromtimestamp(path.stat().st_mtime, UTC).isoformat(timespec="seconds")
    except (OSError, ValueError) as error:
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
    return reconstruction, _registration(found, reconstruction)


def _registration(found: Mapping[str, Any], reconstruction: Reconstruction) -> Registration:
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
    return Registration(
        new_id("registration"),
        f"{words[method]}, {reconstruction.name}",
        method,
        frame,
        reconstruction_id=reconstruction.id,
        rotation_error_deg=(
            (turned[0], turned[1], turned[2])
            if len(turned) == 3
            and turned[0] is not None
            and turned[1] is not None
            and turned[2] is not None
            else None
        ),
        scale_error=_number(told.get("scale_error")),
        covariance=_covariance(told.get("covariance")),
        centre=_centre(told.get("centre")),
        rms_control_m=_number(told.get("rms_control_m")),
        rms_check_m=_number(told.get("rms_check_m")),
    )


def placing_error_m(model: Path) -> float | None:
    """How far a model that a run has left in its folder may be off as a whole, one sigma along any
    direction: of the check points, else of the control points that placed it. None where nothing
    beside it says so."""
    try:
        told = json.loads(model.with_name(RESULT).read_text(encoding="utf-8"))["registration"]
        rms = _number(told.get("rms_check_m")) or _number(told.get("rms_control_m"))
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None
    return None if rms is None else rms / math.sqrt(3.0)


def _pairs(settings: object) -> tuple[tuple[str, str], ...]:
    if not isinstance(settings, dict):
        return ()
    return tuple((str(k), "" if v is None else str(v)) for k, v in settings.items())


def _count(value: object) -> int:
    return value if isinstance(value, int) else 0


def _covariance(value: object) -> tuple[tuple[float, ...], ...] | None:
    """7 rows of 7 numbers; None where a report of before has none."""
    rows = value if isinstance(value, list) else []
    found = [tuple(map(_number, row)) for row in rows if isinstance(row, list)]
    numbers = [tuple(v for v in row if v is not None) for row in found]
    return tuple(numbers) if [len(row) for row in numbers] == [7] * 7 else None


def _centre(value: object) -> Point | None:
    x, y, z = map(_number, value) if isinstance(value, list) and len(value) == 3 else (None,) * 3
    return None if x is None or y is None or z is None else (x, y, z)


def _number(value: object) -> float | None:
    if not isinstance(value, int | float) or not math.isfinite(value):
        return None
    return float(value)
