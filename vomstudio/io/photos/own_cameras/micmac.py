"""Orientations of MicMac: a folder `Ori-...` of one XML file per photo and one per camera.

A point P in the camera (x right, y down, z forward) is at R P + C in the World frame, where the
rows of R are L1, L2, L3 (convention `eConvApero_DistM2C`). Distortion is applied to ideal pixels:
a radial part with even powers of the distance from its centre, a decentring part with P1 and P2,
and an affine part with b1 and b2 (MicMac documentation, "Camera calibration and orientation"). The
files contain points with their pixel coordinates, which are used here to check the cameras.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError, InputError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.io.photos.own_cameras.fitted_lens import MAX_ERROR_PX, fit_lens
from vomstudio.io.photos.own_cameras.frames import Candidate
from vomstudio.io.photos.own_cameras.result import unknown_lens_finding, view_from_centre
from vomstudio.io.text.xml_tree import Element, read_xml

_PREFIX = "Orientation-"
_CONVENTION = "eConvApero_DistM2C"
_MAX_CHECK_PX = 2.0
"""Maximum error, in pixels, of the points with which MicMac's files are checked."""

Distortion = Callable[[FloatArray], FloatArray]
"""Function that converts ideal pixels (n, 2) to distorted ones."""


def find_folder(path: Path) -> Path | None:
    """Return the folder of orientations from its path or one of its files, or None."""
    folder = path if path.is_dir() else path.parent
    if path.is_dir() or path.name.startswith(_PREFIX):
        return folder if next(folder.glob(f"{_PREFIX}*.xml"), None) is not None else None
    return None


def read_micmac(folder: Path) -> list[Candidate]:
    """Read the orientations of a folder.

    Parameters
    ----------
    folder : Path
        Folder with a file for each photo, and the files of the cameras.

    Raises
    ------
    InputError
        If a file is not valid; states file and line.
    """
    lenses: dict[Path, tuple[Intrinsics, str | None]] = {}
    views, unknown_models, invalid_names = list[View](), list[str](), list[str]()
    for path in sorted(folder.glob(f"{_PREFIX}*.xml")):
        root = read_xml(path)
        orientation = root if root.tag == "OrientationConique" else root.find("OrientationConique")
        if orientation is None:
            raise _damage_error(path, root, tr("{name} is missing", name="OrientationConique"))
        _require(path, orientation, "TypeProj", "eProjStenope")
        _require(path, orientation, "ConvOri/KnownConv", _CONVENTION)
        lens, unknown_model = _read_lens(path, orientation, lenses)
        exterior = _child(path, orientation, "Externe")
        rows = [_numbers(path, exterior, f"ParamRotation/CodageMatr/L{n}", 3) for n in (1, 2, 3)]
        centre = _numbers(path, exterior, "Centre", 3)
        name = path.name.removeprefix(_PREFIX).removesuffix(".xml")
        try:
            view = view_from_centre(name, lens, np.array(rows).T, centre)
        except (ValueError, GeometryError) as error:
            raise _damage_error(path, exterior, str(error)) from error
        if unknown_model is not None:
            unknown_models.append(unknown_model)
        elif _check_error_px(path, orientation, view) > _MAX_CHECK_PX:
            invalid_names.append(name)
        views.append(view)
    warnings = [
        unknown_lens_finding(name, unknown_models.count(name)) for name in set(unknown_models)
    ]
    if invalid_names:
        warnings.append(unknown_lens_finding("MicMac", len(invalid_names)))
    return [Candidate(tr("the frame of the file"), views, tuple(warnings))]


def _check_error_px(path: Path, orientation: Element, view: View) -> float:
    """Return the largest error in pixels of the points in the file; 0 if it has no points."""
    rows = orientation.findall("Verif/Appuis")
    if not rows:
        return 0.0
    pixels = np.array([_numbers(path, row, "Im", 2) for row in rows])
    points = np.array([_numbers(path, row, "Ter", 3) for row in rows])
    # The points are at the depths of the scene; some lie beyond the edge of the photo.
    lens = view.intrinsics
    is_inside = ((pixels >= 0.0) & (pixels <= (lens.width, lens.height))).all(axis=1)
    error = np.abs(view.project(points) - pixels)[is_inside]
    return float(np.nan_to_num(error, nan=np.inf).max()) if len(error) else 0.0


# --- lenses -----------------------------------------------------------------------------------
def _read_lens(
    path: Path, orientation: Element, lenses: dict[Path, tuple[Intrinsics, str | None]]
) -> tuple[Intrinsics, str | None]:
    interior = orientation.find("Interne")
    if interior is not None:
        return _lens(path, interior)
    stated_path = _child(path, orientation, "FileInterne").text or ""
    file = path.with_name(stated_path.strip().replace("\\", "/").rpartition("/")[2])
    if file not in lenses:
        if not file.is_file():
            raise InputError(Finding("file.missing"), file=file)
        root = read_xml(file)
        is_lens = root.tag == "CalibrationInternConique"
        lens = root if is_lens else _child(file, root, "CalibrationInternConique")
        lenses[file] = _lens(file, lens)
    return lenses[file]


def _lens(path: Path, element: Element) -> tuple[Intrinsics, str | None]:
    _require(path, element, "KnownConv", _CONVENTION)
    focal = float(_numbers(path, element, "F", 1)[0])
    centre = _numbers(path, element, "PP", 2)
    width, height = (int(value) for value in _numbers(path, element, "SzIm", 2))
    if not (focal > 0 and width > 0 and height > 0):
        raise _damage_error(path, element, tr("the focal length is missing or not positive"))
    distortions = list[Distortion]()
    # The last distortion is applied first.
    for child in reversed(element.findall("CalibDistortion")):
        model = child[0] if len(child) else child
        distortion = _distortion(path, model)
        if distortion is None:
            kind = model.findtext("TypeModele") or str(model.tag)
            cx, cy = centre
            return Intrinsics.pinhole(width, height, focal, cx, cy), kind.strip()
        distortions.append(distortion)

    def project(ideal_points: FloatArray) -> FloatArray:
        pixels = ideal_points * focal + centre
        for distortion in distortions:
            pixels = distortion(pixels)
        return pixels

    lens, error_px = fit_lens(width, height, focal, project)
    return lens, None if error_px <= MAX_ERROR_PX else "MicMac"


def _distortion(path: Path, model: Element) -> Distortion | None:
    """Return a distortion, or None if its model is not known."""
    if model.tag == "ModNoDist":
        return lambda pixels: pixels
    if model.tag == "ModRad":
        return _polynomial(path, model, model)
    if model.tag == "ModPhgrStd":
        return _polynomial(path, _child(path, model, "RadialePart"), model)
    return None


def _polynomial(path: Path, radial: Element, model: Element) -> Distortion:
    distortion_centre = _numbers(path, radial, "CDist", 2)
    coefficients = [float(_values(path, element, 1)[0]) for element in radial.findall("CoeffDist")]
    p1, p2, b1, b2 = (
        float(_values(path, element, 1)[0]) if (element := model.find(name)) is not None else 0.0
        for name in ("P1", "P2", "b1", "b2")
    )

    def distort(pixels: FloatArray) -> FloatArray:
        x, y = (pixels - distortion_centre).T
        r2 = x * x + y * y
        factor = np.zeros(len(r2))
        for power, coefficient in enumerate(coefficients, 1):
            factor += coefficient * r2**power
        dx = x * factor + p1 * (2 * x * x + r2) + 2 * p2 * x * y + b1 * x + b2 * y
        dy = y * factor + p2 * (2 * y * y + r2) + 2 * p1 * x * y
        return np.asarray(pixels + np.column_stack([dx, dy]), np.float64)

    return distort


# --- elements ---------------------------------------------------------------------------------
def _child(path: Path, element: Element, name: str) -> Element:
    child = element.find(name)
    if child is None:
        raise _damage_error(path, element, tr("{name} is missing", name=name))
    return child


def _require(path: Path, element: Element, name: str, value: str) -> None:
    child = element.find(name)
    if child is not None and (child.text or "").strip() != value:
        reason = tr("{given} is not supported, only {value}", given=child.text, value=value)
        raise _damage_error(path, child, reason)


def _numbers(path: Path, element: Element, name: str, count: int) -> FloatArray:
    return _values(path, _child(path, element, name), count)


def _values(path: Path, element: Element, count: int) -> FloatArray:
    try:
        values: Sequence[float] = [float(word) for word in (element.text or "").split()]
    except ValueError:
        values = []
    if len(values) != count or not np.isfinite(values).all():
        raise _damage_error(path, element, tr("the number of values must be {count}", count=count))
    return np.array(values, np.float64)


def _damage_error(path: Path, element: Element, reason: str) -> InputError:
    finding = Finding("file.damaged", reason=reason.rstrip("."), format="MicMac")
    return InputError(finding, file=path, line=element.sourceline, field=str(element.tag))
