"""The registration that `reconstruction.json` states, the result of a reconstruction made here."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from vomstudio.document.edits import new_id
from vomstudio.document.records import (
    Frame,
    ObservationGroup,
    Registration,
    RegistrationPoint,
)
from vomstudio.document.records.basics import Point
from vomstudio.files.regular import is_regular, read_json
from vomstudio.io.photos.cameras_file import FILE_NAME

RESULT = "reconstruction.json"
MODELS = ("model.obj", "model.glb", "model.ply", "dense.laz", "sparse.ply")
"""Files of a reconstruction that have its registration."""
_METHODS: dict[str, Literal["gps", "control"]] = {
    "camera positions (GPS)": "gps",
    "ground control points": "control",
}


def is_reconstructed(model: Path) -> bool:
    """Whether a file is, by its name and the files beside it, a model that was reconstructed here.

    OpenSfM writes a `reconstruction.json` too, but no `cameras.json` beside a model of these names.
    """
    beside = (model.with_name(FILE_NAME), model.with_name(RESULT))
    return model.name in MODELS and all(map(is_regular, beside))


def read_registration_of_result(model: Path) -> Registration:
    """Read the registration of a reconstructed model from `reconstruction.json` beside it.

    Raises
    ------
    ValueError, OSError
        If the file cannot be read, or is not the result of a reconstruction.
    """
    result = read_json(model.with_name(RESULT))
    if not isinstance(result, dict) or not isinstance(result.get("registration"), dict):
        raise ValueError("it has no object “registration”")
    return registration_of(result, model.parent.name)


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
    turned = [finite_number(errors.get(axis)) for axis in axes] if isinstance(errors, dict) else []
    shape, lens = (
        each if isinstance(each, dict) else {} for each in map(told.get, ("shape", "lens_bowing"))
    )
    control = _judged_by(told)
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
        scale_error=finite_number(told.get("scale_error")),
        rms_control_m=finite_number(told.get("rms_control_m")),
        rms_check_m=finite_number(told.get("rms_check_m")),
        control=control,
        covariance=_covariance(told.get("covariance")),
        centre=_place(told.get("centre")),
        reach_m=finite_number(shape.get("reach_m")),
        normal=_place(shape.get("normal")),
        lens_bowing95_deg=finite_number(lens.get("edge_to_edge95_deg")),
        lens_stretch95=finite_number(lens.get("stretch95")),
        observations=_observations(method, control),
    )


def _observations(
    method: str, control: Sequence[RegistrationPoint]
) -> tuple[ObservationGroup, ...]:
    labels = tuple(point.label for point in control if not point.check)
    kind = "cameras" if method == "gps" else "points"
    return (ObservationGroup(kind, labels),) if labels else ()


def placing_error_m(model: Path) -> float | None:
    """How far a model that a run has left in its folder may be off as a whole, one sigma along any
    direction: of the check points, else of the control points that placed it. None where nothing
    beside it says so."""
    try:
        told = read_json(model.with_name(RESULT))["registration"]
        rms = finite_number(told.get("rms_check_m")) or finite_number(told.get("rms_control_m"))
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
    x, y, z = (finite_number(v) for v in value)
    return None if x is None or y is None or z is None else (x, y, z)


def _covariance(value: object) -> tuple[tuple[float, ...], ...] | None:
    if not isinstance(value, list) or len(value) != 7:
        return None
    rows = [
        [finite_number(v) for v in row] for row in value if isinstance(row, list) and len(row) == 7
    ]
    if len(rows) != 7:
        return None
    known = tuple(tuple(v for v in row if v is not None) for row in rows)
    return known if all(len(row) == 7 for row in known) else None


def finite_number(value: object) -> float | None:
    """Return a number of a JSON file, None if it is not a finite number."""
    if not isinstance(value, int | float) or not math.isfinite(value):
        return None
    return float(value)
