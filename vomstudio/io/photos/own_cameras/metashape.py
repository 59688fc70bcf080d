"""Cameras of Metashape and PhotoScan: the XML that "Export Cameras" writes.

A camera's transform leads from it (x right, y down, z forward) to the chunk, and the chunk's (or
component's) from there to its reference system: metres, or geocentric where that is a CRS on Earth
(Metashape manual, appendix "Camera models"; Python reference, `Chunk.transform`).
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.io.photos.own_cameras.frames import Candidate
from vomstudio.io.photos.own_cameras.result import from_centre, straight, unknown_lens
from vomstudio.io.text.xml_tree import Element

_LOCAL = ("LOCAL", "ENGCRS", "ENGINEERING")
_STEP_M = 10.0


def is_metashape(root: Element) -> bool:
    return root.tag in ("document", "chunk") and next(root.iter("camera"), None) is not None


def read_metashape(path: Path, root: Element) -> list[Candidate]:
    """In the chunk's reference system, with its transform alone, and in its inner frame. Raises
    InputError with line and element."""
    chunks = [root] if root.tag == "chunk" else list(root.iter("chunk"))
    chunk = max(chunks, key=_posed_in)
    warnings: list[Finding] = []
    if len(chunks) > 1:
        warnings.append(
            Finding("cameras.several-chunks", count=len(chunks), label=chunk.get("label", ""))
        )
    lenses = {s.get("id"): _lens(path, s) for s in chunk.iter("sensor") if s.get("id") is not None}
    transforms = {c.get("id"): _transform(path, c) for c in chunk.iter("component")}
    whole = _transform(path, chunk)
    poses, odd = list[tuple[str, Intrinsics, FloatArray, FloatArray]](), list[str]()
    for camera in chunk.iter("camera"):
        given = camera.find("transform")
        if given is None or camera.get("enabled") in ("false", "0"):
            continue
        matrix = _numbers(path, given, 16).reshape(4, 4)
        lens, unknown = lenses.get(camera.get("sensor_id"), (None, None))
        if lens is None:
            raise _bad(path, camera, tr("its sensor is not among the sensors"))
        if unknown is not None:
            odd.append(unknown)
        outer = transforms.get(camera.get("component_id"))
        if outer is None:
            outer = whole if not transforms else next(iter(transforms.values()))
        poses.append((_label(path, camera), lens, matrix, np.eye(4) if outer is None else outer))
    inner = [_view(path, chunk, *pose[:3], np.eye(4)) for pose in poses]
    if not inner:
        raise InputError(Finding("cameras.none-aligned"), file=path, line=chunk.sourceline)
    warnings += [unknown_lens(name, count) for name, count in Counter(odd).items()]
    findings = tuple(warnings)
    found = [Candidate(tr("the inner frame of the chunk"), inner, findings)]
    if all((outer == np.eye(4)).all() for *_, outer in poses):
        return found
    placed = [_view(path, chunk, *pose) for pose in poses]
    reference = (chunk.findtext("reference") or "").strip()
    if reference and not reference.upper().startswith(_LOCAL):
        on_map, name = _on_map(path, chunk, reference, placed)
        return [Candidate(name, on_map, findings), *found]
    return [Candidate(tr("the frame of the chunk, with its transform"), placed, findings), *found]


def _posed_in(chunk: Element) -> int:
    return sum(camera.find("transform") is not None for camera in chunk.iter("camera"))


def _label(path: Path, camera: Element) -> str:
    label = camera.get("label") or ""
    if not label.strip():
        raise _bad(path, camera, tr("it has no label"))
    return str(label.strip().replace("\\", "/"))


def _view(
    path: Path, chunk: Element, name: str, lens: Intrinsics, matrix: FloatArray, outer: FloatArray
) -> View:
    scale = np.cbrt(abs(np.linalg.det(outer[:3, :3])))
    both = outer @ matrix
    try:
        if not scale > 0:
            raise ValueError(tr("the transform of the chunk has no scale"))
        return from_centre(name, lens, (both[:3, :3] / scale).T, both[:3, 3])
    except ValueError as error:
        camera = next(c for c in chunk.iter("camera") if _label(path, c) == name)
        raise _bad(path, camera, str(error)) from error


def _transform(path: Path, element: Element) -> FloatArray | None:
    """(4, 4) of a chunk or component; None where it has none."""
    given = element.find("transform")
    if given is None:
        return None
    rotation, translation = given.find("rotation"), given.find("translation")
    if rotation is None or translation is None:
        if (given.text or "").strip():
            return _numbers(path, given, 16).reshape(4, 4)
        return None
    scale = given.find("scale")
    factor = 1.0 if scale is None else float(_numbers(path, scale, 1)[0])
    if not factor > 0:
        raise _bad(path, given, tr("its scale must be positive"))
    matrix = np.eye(4)
    matrix[:3, :3] = factor * _numbers(path, rotation, 9).reshape(3, 3)
    matrix[:3, 3] = _numbers(path, translation, 3)
    return matrix


# --- on Earth ---------------------------------------------------------------------------------
def _on_map(
    path: Path, chunk: Element, reference: str, placed: list[View]
) -> tuple[list[View], str]:
    """Geocentric views in a projected CRS, that of the chunk or the UTM zone of the place. Raises
    InputError."""
    from pyproj import CRS, Transformer
    from pyproj.exceptions import CRSError, ProjError

    from vomstudio.io.gis.crs import utm_zone

    element = chunk.find("reference")
    try:
        crs = CRS.from_user_input(reference)
        crs = crs.sub_crs_list[0] if crs.is_compound else crs
        body = crs.ellipsoid
        if body is None:
            raise ValueError(tr("it has no ellipsoid"))
        shape = {"a": body.semi_major_metre, "rf": body.inverse_flattening}
        geocentric = CRS.from_dict({"proj": "geocent", **shape})
        degrees = CRS.from_dict({"proj": "longlat", **shape})
        middle = np.mean([view.centre for view in placed], axis=0)
        if not crs.is_projected:
            to_degrees = Transformer.from_crs(geocentric, degrees, always_xy=True)
            longitude, latitude = to_degrees.transform(*middle)[:2]
            crs = CRS.from_user_input(utm_zone(longitude, latitude))
        transformer = Transformer.from_crs(geocentric, crs, always_xy=True)
        views = [_turned(view, transformer) for view in placed]
    except (CRSError, ProjError, ValueError) as error:
        raise _bad(
            path, chunk if element is None else element, tr("its reference system cannot be used")
        ) from error
    return views, str(crs.name)


def _turned(view: View, transformer: Any) -> View:
    """From geocentric to map coordinates: the axes of the map at the place of the camera, whose
    scale, which differs from 1 by less than a thousandth, does not matter."""
    centre = view.centre
    ends = np.concatenate([centre + _STEP_M * np.eye(3), centre - _STEP_M * np.eye(3), [centre]])
    x, y, z = transformer.transform(*ends.T, errcheck=True)
    there = np.column_stack([x, y, z])
    slopes = (there[:3] - there[3:6]).T / (2 * _STEP_M)
    u, _, vt = np.linalg.svd(slopes)
    return from_centre(view.name, view.intrinsics, view.rotation @ (u @ vt).T, there[6])


# --- lenses -----------------------------------------------------------------------------------
def _lens(path: Path, sensor: Element) -> tuple[Intrinsics, str | None]:
    """With the name of the lens model where it is not known here. Metashape's polynomial is that
    of OpenCV with p1 and p2 exchanged, its centre is counted from the middle of the photo."""
    found = sensor.findall("calibration")
    adjusted = [each for each in found if each.get("class") == "adjusted"] or found
    calibration = adjusted[-1] if adjusted else None
    size = None if calibration is None else calibration.find("resolution")
    size = sensor.find("resolution") if size is None else size
    if size is None:
        raise _bad(path, sensor, tr("it has no resolution"))
    try:
        width, height = int(size.get("width")), int(size.get("height"))
    except (TypeError, ValueError) as error:
        raise _bad(path, size, tr("width and height must be whole numbers")) from error
    if width <= 0 or height <= 0:
        raise _bad(path, size, tr("width and height must be positive"))
    if calibration is None:
        return straight(width, height, float(max(width, height))), tr("without calibration")

    def value(name: str) -> float:
        element = calibration.find(name)
        return 0.0 if element is None else float(_numbers(path, element, 1)[0])

    kind = calibration.get("type") or sensor.get("type") or "frame"
    old = calibration.find("f") is None and calibration.find("fx") is not None
    if old:
        # PhotoScan before 1.2: two focal lengths, the centre counted from the corner.
        fx, fy, cx, cy = (value(n) for n in ("fx", "fy", "cx", "cy"))
    else:
        fx, fy = value("f") + value("b1"), value("f")
        cx, cy = width / 2 + value("cx"), height / 2 + value("cy")
    if not (fx > 0 and fy > 0):
        if kind not in ("frame", "fisheye"):
            return straight(width, height, max(width, height) / 2.0), kind
        raise _bad(path, calibration, tr("its focal length is missing or not positive"))
    k1, k2, k3, k4 = (value(n) for n in ("k1", "k2", "k3", "k4"))
    if kind == "frame":
        params = (fx, fy, cx, cy, k1, k2, value("p2"), value("p1"), k3, 0.0, 0.0, 0.0)
        more = [n for n in ("k4", "b2", "p3", "p4") if value(n)]
        lens = Intrinsics("FULL_OPENCV", width, height, params)
        return lens, tr("with {names}", names=", ".join(more)) if more else None
    if kind in ("fisheye", "equidistant_fisheye"):
        return Intrinsics("OPENCV_FISHEYE", width, height, (fx, fy, cx, cy, k1, k2, k3, k4)), None
    return Intrinsics("PINHOLE", width, height, (fx, fy, cx, cy)), kind


# --- elements ---------------------------------------------------------------------------------
def _numbers(path: Path, element: Element, count: int) -> FloatArray:
    try:
        values = np.array([float(word) for word in (element.text or "").split()])
    except ValueError as error:
        said = tr("not a number among '{text}'", text=(element.text or "").strip()[:40])
        raise _bad(path, element, said) from error
    if len(values) != count or not np.isfinite(values).all():
        raise _bad(
            path,
            element,
            tr("{count} numbers are wanted, {given} are given", count=count, given=len(values)),
        )
    return values


def _bad(path: Path, element: Element, error: str) -> InputError:
    name = element.get("label") or element.get("id")
    field = f"{element.tag} {name}" if name else str(element.tag)
    finding = Finding("file.damaged", reason=error.rstrip("."), format="Metashape")
    return InputError(finding, file=path, line=element.sourceline, field=field)
