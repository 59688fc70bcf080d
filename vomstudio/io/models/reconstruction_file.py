"""Registration of a reconstructed model, from the `reconstruction.json` file next to it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from vomstudio.core.files.regular import is_regular_file, read_json
from vomstudio.core.identifiers import new_id
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.matrices import Point
from vomstudio.geometry.registrations import ObservationGroup, Registration, RegistrationPoint
from vomstudio.io.photos.cameras_file import FILE_NAME

RESULT = "reconstruction.json"
WORK = "work"
"""Folder of the stages of a reconstruction."""
CURRENT_FILE = "current.json"
"""File in it with the names of the folders that the newest result uses."""
MODELS = ("model.obj", "model.glb", "model.ply", "dense.laz", "sparse.ply")
"""Model files that a reconstruction writes in its registered frame."""
_METHODS: dict[str, Literal["gps", "control"]] = {
    "camera positions (GPS)": "gps",
    "ground control points": "control",
}


def is_reconstructed(model: Path) -> bool:
    """Return whether a file is a model from a reconstruction by this program.

    This is decided by the name and the neighbouring files: OpenSfM also writes a
    `reconstruction.json`, but not together with `cameras.json` and a model with one of these names.
    """
    sidecars = (model.with_name(FILE_NAME), model.with_name(RESULT))
    return model.name in MODELS and all(map(is_regular_file, sidecars))


def read_result_registration(model: Path) -> Registration:
    """Read the registration of a reconstructed model from its `reconstruction.json` file.

    Raises
    ------
    ValueError, OSError
        If the file cannot be read or is not the result of a reconstruction.
    """
    result = read_json(model.with_name(RESULT))
    if not isinstance(result, dict) or not isinstance(result.get("registration"), dict):
        raise ValueError("it has no object “registration”")
    return result_registration(result, model.parent.name)


def result_registration(
    result: Mapping[str, Any], name: str, reconstruction_id: str = ""
) -> Registration:
    """Return the registration contained in the result of a reconstruction.

    Parameters
    ----------
    result : mapping
        Content of `reconstruction.json`.
    name : str
        Name of the reconstruction, from which the name of the registration is derived.
    reconstruction_id : str, optional
        ID of the reconstruction in its project.
    """
    registration = result.get("registration")
    registration = registration if isinstance(registration, dict) else {}
    method: Literal["gps", "control", "local"]
    method = _METHODS.get(str(registration.get("method")), "local")
    method_names = {
        "gps": "GPS of the cameras",
        "control": "control points",
        "local": "photos only",
    }
    crs = result.get("frame")
    if isinstance(crs, str) and crs != "local":
        frame = Frame("crs", crs)
    else:
        frame = Frame("local") if result.get("scaled") else Frame()
    errors = registration.get("rotation_error_deg")
    axes = ("about_up", "about_east", "about_north")
    rotation_errors = (
        [finite_number(errors.get(axis)) for axis in axes] if isinstance(errors, dict) else []
    )
    shape, lens = (
        value if isinstance(value, dict) else {}
        for value in map(registration.get, ("shape", "lens_bowing"))
    )
    control = _control_points(registration)
    return Registration(
        new_id("registration"),
        f"{method_names[method]}, {name}",
        method,
        frame,
        reconstruction_id=reconstruction_id,
        rotation_error_deg=(
            (rotation_errors[0], rotation_errors[1], rotation_errors[2])
            if len(rotation_errors) == 3
            and rotation_errors[0] is not None
            and rotation_errors[1] is not None
            and rotation_errors[2] is not None
            else None
        ),
        scale_error=finite_number(registration.get("scale_error")),
        rms_control_m=finite_number(registration.get("rms_control_m")),
        rms_check_m=finite_number(registration.get("rms_check_m")),
        control=control,
        covariance=_covariance(registration.get("covariance")),
        centre=_point(registration.get("centre")),
        reach_m=finite_number(shape.get("reach_m")),
        normal=_point(shape.get("normal")),
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
    """Return the position error of a reconstructed model as a whole.

    Returns
    -------
    float or None
        Standard deviation along any direction in metres, from the check points or else the control
        points. None if the `reconstruction.json` next to the model does not state it.
    """
    try:
        registration = read_json(model.with_name(RESULT))["registration"]
        rms = finite_number(registration.get("rms_check_m")) or finite_number(
            registration.get("rms_control_m")
        )
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None
    return None if rms is None else rms / math.sqrt(3.0)


def _control_points(registration: Mapping[str, Any]) -> tuple[RegistrationPoint, ...]:
    """Return the control and check points, or the camera positions that were used.

    The model is already in the World frame, so its coordinates of a point are the surveyed
    coordinates plus the residual.
    """
    rows = []
    for row in _rows(registration.get("points")):
        if row.get("role") in ("control", "check"):
            rows.append((row.get("label"), row.get("residual_m"), row, row["role"] == "check"))
    for row in _rows(registration.get("residuals")):
        if row.get("used") is True:
            rows.append(
                (row.get("name"), [row.get(axis) for axis in ("dx", "dy", "dz")], row, False)
            )
    points = []
    for label, residual_numbers, row, check in rows:
        residual, world = _point(residual_numbers), _point(row.get("surveyed"))
        if residual is not None and world is not None:
            x, y, z = (a + b for a, b in zip(world, residual, strict=True))
            points.append(RegistrationPoint(str(label), (x, y, z), world, residual, None, check))
    return tuple(points)


def _rows(value: object) -> list[dict[str, Any]]:
    return [row for row in value if isinstance(row, dict)] if isinstance(value, list) else []


def _point(value: object) -> Point | None:
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
    matrix = tuple(tuple(v for v in row if v is not None) for row in rows)
    return matrix if all(len(row) == 7 for row in matrix) else None


def finite_number(value: object) -> float | None:
    """Return a number from a JSON file, or None if it is not a finite number."""
    if not isinstance(value, int | float) or not math.isfinite(value):
        return None
    return float(value)
