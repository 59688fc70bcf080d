"""`NAME.registration.json`: placement of the model NAME in the World frame and its error.

The file is next to a model and applies to those files with the name NAME whose SHA-256 it lists. It
contains the fields of a `geometry.registrations.Registration`: the matrix from file coordinates to
World coordinates and the 7 x 7 covariance of that similarity transformation.

For a model that was written in the World frame, as by ``register -o`` and ``reconstruct``, the
matrix is the identity, and the covariance is that of its placement. The matrix differs from the
identity only if the coordinates of the file are not World coordinates, such as for a piece that was
cut from a model registered in a project.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.errors import DocumentError, InputError, TargetError
from vomstudio.core.files.atomic import write_bytes
from vomstudio.core.files.regular import (
    MAX_SIDECAR_BYTES,
    open_regular_file,
    path_exists,
    read_json,
)
from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.core.plain_data import NestedFields, decode_fields, encode_fields
from vomstudio.core.version import __version__
from vomstudio.core.words import tr
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.registration_frames import is_same_registration
from vomstudio.geometry.registrations import (
    NorthReference,
    ObservationGroup,
    Registration,
    RegistrationPoint,
)
from vomstudio.io.gis.crs import parse_crs
from vomstudio.io.models.reconstruction_file import (
    RESULT,
    is_reconstructed,
    read_result_registration,
)

FORMAT, VERSION = "vomstudio registration", 1
SUFFIX = ".registration.json"
PARAMETERS = (
    "turn_east",
    "turn_north",
    "turn_up",
    "scale",
    "shift_east",
    "shift_north",
    "shift_up",
)
"""Rows and columns of the covariance: rotations about the axes of the World frame, a relative
change of scale, and translations."""
UNITS = ("rad", "rad", "rad", "1", "m", "m", "m")
_DESCRIPTION = (
    "World = matrix @ (x, y, z, 1) with x, y, z as in the model's file; World is x East, y North, "
    "z Up, metres. The covariance is of small turns and a relative change of scale about centre, "
    "and of shifts, one sigma squared. Errors are one sigma; ends with 95: 95 %."
)
MAX_RELATIVE_DEVIATION = 1e-6
"""Relative deviation of a matrix from a similarity, and of a covariance from symmetry."""
_MAX_ERROR = 1e9
"""Maximum standard deviation, in radians, in metres or as a ratio."""
_NESTED_FIELDS = NestedFields(
    parts={"frame": Frame, "read_north": NorthReference},
    lists={"control": RegistrationPoint, "observations": ObservationGroup},
)
_EVIDENCE_FIELDS = ("control", "observations", "rms_control_m", "rms_check_m", "read_north")
_SHAPE_FIELDS = ("reach_m", "normal", "lens_bowing95_deg", "lens_stretch95")


@dataclass(frozen=True)
class StoredRegistration:
    """Content of a registration file.

    Parameters
    ----------
    registration : Registration
    files : mapping of str to str
        SHA-256 of each model to which the registration applies, by file name.
    """

    registration: Registration
    files: Mapping[str, str]


@dataclass(frozen=True)
class SidecarRegistration:
    """Registration next to a model, if there is one, and findings about it."""

    registration: Registration | None = None
    findings: tuple[Finding, ...] = ()


def registration_path(model: str | Path) -> Path:
    """Return the path of the registration file of a model."""
    model = Path(model)
    return model.with_name(model.stem + SUFFIX)


# --- writing --------------------------------------------------------------------------------------
def check_registration_target(
    model: str | Path, registration: Registration | None, *, force: bool = False
) -> None:
    """Check, before a model is written, that its registration can be written next to it.

    Raises
    ------
    TargetError
        If a file with this name contains another registration and `force` is False.
    """
    path = registration_path(model)
    if registration is None or force or not path_exists(path):
        return
    if _listed_files(path, registration) is None:
        raise TargetError(Finding("output.other-registration"), file=path)


def write_registration(
    registration: Registration, models: Iterable[str | Path], *, force: bool = False
) -> Path:
    """Write the registration file of models that have the same name and folder.

    Parameters
    ----------
    registration : Registration
        Registration whose matrix transforms coordinates in these files to the World frame.
    models : iterable of path
        Complete files, such as ``model.obj`` and ``model.ply``.
    force : bool
        Whether to replace the registration of another model with this name.

    Returns
    -------
    Path

    Raises
    ------
    TargetError
        As for `check_registration_target`, or if the file cannot be written.
    """
    paths = [Path(model) for model in models]
    target = registration_path(paths[0])
    check_registration_target(paths[0], registration, force=force)
    files = dict(_listed_files(target, registration) or {})
    files |= {path.name: _sha256(path) for path in paths}
    text = json.dumps(_plain_content(registration, files), indent=1, ensure_ascii=False)
    write_bytes(target, (text + "\n").encode(), force=True)
    return target


def _sha256(path: Path) -> str:
    with open_regular_file(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _listed_files(path: Path, registration: Registration) -> Mapping[str, str] | None:
    """Return the files listed in a registration file, or None.

    None means that the file contains another registration or cannot be read.
    """
    try:
        stored_registration = read_registration(path)
    except InputError:
        return None
    is_same = is_same_registration(stored_registration.registration, registration)
    return stored_registration.files if is_same else None


def _plain_content(registration: Registration, files: Mapping[str, str]) -> dict[str, Any]:
    fields = {
        field.name: getattr(registration, field.name) for field in dataclasses.fields(registration)
    }
    plain_fields = encode_fields(fields, _NESTED_FIELDS)
    frame = registration.frame
    north = "grid" if frame.kind == "crs" else "local" if frame.has_north else None
    covariance = None
    if registration.covariance is not None:
        covariance = {
            "parameters": PARAMETERS,
            "units": UNITS,
            "centre": plain_fields["centre"],
            "matrix": plain_fields["covariance"],
        }
    evidence = {name: plain_fields[name] for name in _EVIDENCE_FIELDS}
    evidence["observations"] = [
        {"kind": group.kind, "count": group.count, "labels": group.labels}
        for group in registration.observations
    ]
    return {
        "format": FORMAT,
        "version": VERSION,
        "made_by": f"VOM Studio {__version__}",
        "about": _DESCRIPTION,
        "files": dict(files),
        "name": registration.name,
        "method": registration.method,
        "frame": frame.kind,
        "crs": frame.crs,
        "north": north,
        "level": frame.has_up,
        "matrix": plain_fields["matrix"],
        "covariance": covariance,
        "rotation_error_deg": plain_fields["rotation_error_deg"],
        "scale_error": plain_fields["scale_error"],
        "evidence": evidence,
        "shape": {name: plain_fields[name] for name in _SHAPE_FIELDS},
    }


# --- reading --------------------------------------------------------------------------------------
def find_registration(model: Path, content_hash: str) -> SidecarRegistration:
    """Find the registration of a model, in the file next to it or from its reconstruction.

    Parameters
    ----------
    model : Path
    content_hash : str
        SHA-256 of the model file.

    Returns
    -------
    SidecarRegistration
        A file that cannot be used is reported as a finding, never as an error:
        ``registration.damaged``, ``registration.unknown-version`` or ``registration.other-model``.
    """
    path = registration_path(model)
    try:
        if path_exists(path):
            stored_registration = read_registration(path)
            if content_hash not in stored_registration.files.values():
                finding = Finding(
                    "registration.other-model",
                    file=path.name,
                    models=sorted(stored_registration.files),
                )
                return SidecarRegistration(None, (finding,))
            return SidecarRegistration(stored_registration.registration)
        if is_reconstructed(model):
            return SidecarRegistration(_read_reconstruction(model))
    except InputError as error:
        values = {"file": path.name, **error.values}
        return SidecarRegistration(None, (Finding(error.code, **values),))
    return SidecarRegistration()


def _read_reconstruction(model: Path) -> Registration:
    try:
        registration = read_result_registration(model)
    except (OSError, ValueError) as error:
        raise _damage_error(model.with_name(RESULT), str(error)) from error
    _require_valid(model.with_name(RESULT), registration)
    return registration


def read_registration(path: Path) -> StoredRegistration:
    """Read a registration file.

    Raises
    ------
    InputError
        With the code ``registration.damaged`` or ``registration.unknown-version``.
    """
    try:
        registration_fields = read_json(path, MAX_SIDECAR_BYTES)
    except (OSError, ValueError) as error:
        raise _damage_error(path, str(error)) from error
    if not isinstance(registration_fields, dict) or registration_fields.get("format") != FORMAT:
        raise _damage_error(path, tr("the format is not “{format}”", format=FORMAT))
    version = registration_fields.get("version")
    if version != VERSION:
        finding = Finding(
            "registration.unknown-version", file=path.name, version=str(version), known=VERSION
        )
        raise InputError(finding, file=path)
    files = registration_fields.get("files")
    if not isinstance(files, dict) or not all(isinstance(file, str) for file in files.values()):
        raise _damage_error(path, tr("“files” does not map file names to SHA-256 hashes"))
    try:
        values = decode_fields(Registration, _field_values(registration_fields), _NESTED_FIELDS)
        registration = Registration(**values)
    except (DocumentError, KeyError, TypeError, AttributeError) as error:
        raise _damage_error(path, str(error)) from error
    _require_valid(path, registration)
    return StoredRegistration(registration, {str(name): hash_ for name, hash_ in files.items()})


def _field_values(registration_fields: Mapping[str, Any]) -> dict[str, Any]:
    """Return the JSON values of the fields of a registration. Raises KeyError, TypeError."""
    covariance = registration_fields["covariance"]
    if covariance is not None and (
        tuple(covariance["parameters"]) != PARAMETERS or tuple(covariance["units"]) != UNITS
    ):
        raise TypeError(tr("the parameters of the covariance are not {names}", names=PARAMETERS))
    evidence = {name: registration_fields["evidence"][name] for name in _EVIDENCE_FIELDS}
    evidence["observations"] = [
        {"kind": group["kind"], "labels": group["labels"]} for group in evidence["observations"]
    ]
    frame = Frame(registration_fields["frame"], registration_fields["crs"])
    return {
        "id": new_id("registration"),
        "name": registration_fields["name"],
        "method": registration_fields["method"],
        "frame": {
            "kind": frame.kind,
            "crs": frame.crs,
            "level": registration_fields["level"] is True and not frame.has_north,
        },
        "matrix": registration_fields["matrix"],
        "covariance": None if covariance is None else covariance["matrix"],
        "centre": None if covariance is None else covariance["centre"],
        "rotation_error_deg": registration_fields["rotation_error_deg"],
        "scale_error": registration_fields["scale_error"],
        **evidence,
        **{name: registration_fields["shape"][name] for name in _SHAPE_FIELDS},
    }


def _require_valid(path: Path, registration: Registration) -> None:
    reason = _invalid_reason(registration)
    if reason is not None:
        raise _damage_error(path, reason)


def _invalid_reason(registration: Registration) -> str | None:
    rows = np.array(registration.matrix, np.float64)
    if rows.shape != (4, 4) or rows[3].tolist() != [0.0, 0.0, 0.0, 1.0]:
        return tr("the matrix is not 4 x 4, or its last row is not 0, 0, 0, 1")
    with np.errstate(all="ignore"):
        scale = float(np.cbrt(np.linalg.det(rows[:3, :3])))
        rotation = rows[:3, :3] / scale if scale > 0 else np.zeros((3, 3))
        is_similarity = np.allclose(rotation @ rotation.T, np.eye(3), atol=MAX_RELATIVE_DEVIATION)
    if not is_similarity:
        return tr("the matrix is not a similarity transformation")
    if registration.covariance is not None:
        if registration.centre is None:
            return tr("the point to which the covariance refers is missing")
        reason = _invalid_covariance_reason(registration.covariance)
        if reason is not None:
            return reason
    errors = (*(registration.rotation_error_deg or ()), registration.scale_error or 0.0)
    if min(errors) < 0:
        return tr("an error is negative")
    frame = registration.frame
    if (frame.kind == "crs") != (frame.crs is not None):
        return tr("the frame and its coordinate reference system contradict each other")
    if frame.crs is not None:
        try:
            _, metres = parse_crs(frame.crs)
        except InputError as error:
            return error.message
        if metres != 1.0:
            return tr("the coordinate reference system is not in metres")
    return None


def _invalid_covariance_reason(rows: Sequence[Sequence[float]]) -> str | None:
    count = len(PARAMETERS)
    if len(rows) != count or any(len(row) != count for row in rows):
        return tr("the covariance matrix is not {count} x {count}", count=count)
    covariance = np.array(rows, np.float64)
    if np.abs(covariance).max() > _MAX_ERROR**2:
        return tr("the covariance is implausibly large")
    # Normalised by the errors because radians and metres differ by orders of magnitude.
    sigma = np.sqrt(np.abs(np.diag(covariance)))
    scales = np.where(sigma > 0, sigma, 1.0)
    with np.errstate(all="ignore"):
        correlation = covariance / np.outer(scales, scales)
    is_bounded = bool((np.abs(correlation) <= 1.0 + MAX_RELATIVE_DEVIATION).all())
    is_symmetric = is_bounded and np.allclose(
        correlation, correlation.T, atol=MAX_RELATIVE_DEVIATION
    )
    if not is_symmetric or np.linalg.eigvalsh(correlation)[0] < -MAX_RELATIVE_DEVIATION:
        return tr("the covariance matrix is not symmetric and positive semi-definite")
    return None


def _damage_error(path: Path, reason: str) -> InputError:
    finding = Finding("registration.damaged", file=path.name, reason=reason)
    return InputError(finding, file=path)
