"""Cameras of Metashape and PhotoScan: XML files written by "Export Cameras".

The transform of a camera maps from the camera (x right, y down, z forward) to the chunk. The
transform of the chunk (or component) maps to its reference system, which is in metres, or
geocentric for a CRS on Earth (Metashape manual, appendix "Camera models"; Python reference,
`Chunk.transform`).
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
from vomstudio.io.photos.own_cameras.result import (
    pinhole_lens,
    unknown_lens_finding,
    view_from_centre,
)
from vomstudio.io.text.xml_tree import Element

_LOCAL_PREFIXES = ("LOCAL", "ENGCRS", "ENGINEERING")
_STEP_M = 10.0


def is_metashape(root: Element) -> bool:
    """Return whether an XML document is a camera file of Metashape."""
    return root.tag in ("document", "chunk") and next(root.iter("camera"), None) is not None


def read_metashape(path: Path, root: Element) -> list[Candidate]:
    """Return the cameras in one or two frames. Raises InputError with line and element.

    The first frame is the map of the reference system or, if that is local, the chunk with its
    transform. The second is the inner frame of the chunk, which is the only one if there is no
    transform. The chunk with the most aligned cameras is read.
    """
    chunks = [root] if root.tag == "chunk" else list(root.iter("chunk"))
    chunk = max(chunks, key=_aligned_count)
    warnings: list[Finding] = []
    if len(chunks) > 1:
        warnings.append(
            Finding("cameras.several-chunks", count=len(chunks), label=chunk.get("label", ""))
        )
    lenses = {
        sensor.get("id"): _lens(path, sensor)
        for sensor in chunk.iter("sensor")
        if sensor.get("id") is not None
    }
    transforms = {
        component.get("id"): _transform(path, component) for component in chunk.iter("component")
    }
    chunk_transform = _transform(path, chunk)
    poses, unknown_models = list[tuple[str, Intrinsics, FloatArray, FloatArray]](), list[str]()
    for camera in chunk.iter("camera"):
        transform = camera.find("transform")
        if transform is None or camera.get("enabled") in ("false", "0"):
            continue
        matrix = _numbers(path, transform, 16).reshape(4, 4)
        lens, unknown_model = lenses.get(camera.get("sensor_id"), (None, None))
        if lens is None:
            raise _damage_error(path, camera, tr("the sensor of the camera does not exist"))
        if unknown_model is not None:
            unknown_models.append(unknown_model)
        component_transform = transforms.get(camera.get("component_id"))
        if component_transform is None:
            component_transform = (
                chunk_transform if not transforms else next(iter(transforms.values()))
            )
        poses.append(
            (
                _label(path, camera),
                lens,
                matrix,
                np.eye(4) if component_transform is None else component_transform,
            )
        )
    views = [_view(path, chunk, *pose[:3], np.eye(4)) for pose in poses]
    if not views:
        raise InputError(Finding("cameras.none-aligned"), file=path, line=chunk.sourceline)
    warnings += [
        unknown_lens_finding(name, count) for name, count in Counter(unknown_models).items()
    ]
    findings = tuple(warnings)
    candidates = [Candidate(tr("the internal frame of the chunk"), views, findings)]
    if all((component_transform == np.eye(4)).all() for *_, component_transform in poses):
        return candidates
    chunk_views = [_view(path, chunk, *pose) for pose in poses]
    reference = (chunk.findtext("reference") or "").strip()
    if reference and not reference.upper().startswith(_LOCAL_PREFIXES):
        map_views, name = _convert_to_map(path, chunk, reference, chunk_views)
        return [Candidate(name, map_views, findings), *candidates]
    return [
        Candidate(
            tr("the frame of the chunk, with the chunk transform applied"), chunk_views, findings
        ),
        *candidates,
    ]


def _aligned_count(chunk: Element) -> int:
    return sum(camera.find("transform") is not None for camera in chunk.iter("camera"))


def _label(path: Path, camera: Element) -> str:
    label = camera.get("label") or ""
    if not label.strip():
        raise _damage_error(path, camera, tr("the camera has no label"))
    return str(label.strip().replace("\\", "/"))


def _view(
    path: Path,
    chunk: Element,
    name: str,
    lens: Intrinsics,
    matrix: FloatArray,
    outer_matrix: FloatArray,
) -> View:
    scale = np.cbrt(abs(np.linalg.det(outer_matrix[:3, :3])))
    camera_to_world = outer_matrix @ matrix
    try:
        if not scale > 0:
            raise ValueError(tr("the transform of the chunk has no scale"))
        return view_from_centre(
            name, lens, (camera_to_world[:3, :3] / scale).T, camera_to_world[:3, 3]
        )
    except ValueError as error:
        camera = next(element for element in chunk.iter("camera") if _label(path, element) == name)
        raise _damage_error(path, camera, str(error)) from error


def _transform(path: Path, element: Element) -> FloatArray | None:
    """Return the transform (4, 4) of a chunk or component, or None.

    Raises InputError if it is not valid.
    """
    transform = element.find("transform")
    if transform is None:
        return None
    rotation, translation = transform.find("rotation"), transform.find("translation")
    if rotation is None or translation is None:
        if (transform.text or "").strip():
            return _numbers(path, transform, 16).reshape(4, 4)
        return None
    scale = transform.find("scale")
    factor = 1.0 if scale is None else float(_numbers(path, scale, 1)[0])
    if not factor > 0:
        raise _damage_error(path, transform, tr("the scale must be positive"))
    matrix = np.eye(4)
    matrix[:3, :3] = factor * _numbers(path, rotation, 9).reshape(3, 3)
    matrix[:3, 3] = _numbers(path, translation, 3)
    return matrix


# --- on Earth ---------------------------------------------------------------------------------
def _convert_to_map(
    path: Path, chunk: Element, reference: str, chunk_views: list[View]
) -> tuple[list[View], str]:
    """Convert geocentric views to a projected CRS, that of the chunk or the UTM zone.

    Raises InputError.
    """
    from pyproj import CRS, Transformer
    from pyproj.exceptions import CRSError, ProjError

    from vomstudio.io.gis.crs import utm_zone

    element = chunk.find("reference")
    try:
        crs = CRS.from_user_input(reference)
        crs = crs.sub_crs_list[0] if crs.is_compound else crs
        ellipsoid = crs.ellipsoid
        if ellipsoid is None:
            raise ValueError(tr("the reference system has no ellipsoid"))
        shape = {"a": ellipsoid.semi_major_metre, "rf": ellipsoid.inverse_flattening}
        geocentric_crs = CRS.from_dict({"proj": "geocent", **shape})
        geographic_crs = CRS.from_dict({"proj": "longlat", **shape})
        centre = np.mean([view.centre for view in chunk_views], axis=0)
        if not crs.is_projected:
            to_degrees = Transformer.from_crs(geocentric_crs, geographic_crs, always_xy=True)
            longitude, latitude = to_degrees.transform(*centre)[:2]
            crs = CRS.from_user_input(utm_zone(longitude, latitude))
        transformer = Transformer.from_crs(geocentric_crs, crs, always_xy=True)
        views = [_project_view(view, transformer) for view in chunk_views]
    except (CRSError, ProjError, ValueError) as error:
        raise _damage_error(
            path,
            chunk if element is None else element,
            tr("the reference system of the chunk cannot be used"),
        ) from error
    return views, str(crs.name)


def _project_view(view: View, transformer: Any) -> View:
    """Convert a view from geocentric to map coordinates.

    The axes are those of the map at the camera. The scale of the map differs from 1 by less than a
    thousandth and is therefore neglected.
    """
    centre = view.centre
    step_points = np.concatenate(
        [centre + _STEP_M * np.eye(3), centre - _STEP_M * np.eye(3), [centre]]
    )
    x, y, z = transformer.transform(*step_points.T, errcheck=True)
    projected_points = np.column_stack([x, y, z])
    jacobian = (projected_points[:3] - projected_points[3:6]).T / (2 * _STEP_M)
    u, _, vt = np.linalg.svd(jacobian)
    return view_from_centre(
        view.name, view.intrinsics, view.rotation @ (u @ vt).T, projected_points[6]
    )


# --- lenses -----------------------------------------------------------------------------------
def _lens(path: Path, sensor: Element) -> tuple[Intrinsics, str | None]:
    """Return the lens, and the name of its model if that is not supported, or None.

    Metashape's polynomial is that of OpenCV with p1 and p2 exchanged; its centre is relative to the
    centre of the photo. Raises InputError if the sensor is damaged.
    """
    calibrations = sensor.findall("calibration")
    adjusted_calibrations = [
        element for element in calibrations if element.get("class") == "adjusted"
    ] or calibrations
    calibration = adjusted_calibrations[-1] if adjusted_calibrations else None
    size = None if calibration is None else calibration.find("resolution")
    size = sensor.find("resolution") if size is None else size
    if size is None:
        raise _damage_error(path, sensor, tr("the sensor has no resolution"))
    try:
        width, height = int(size.get("width")), int(size.get("height"))
    except (TypeError, ValueError) as error:
        raise _damage_error(path, size, tr("width and height must be whole numbers")) from error
    if width <= 0 or height <= 0:
        raise _damage_error(path, size, tr("width and height must be positive"))
    if calibration is None:
        return pinhole_lens(width, height, float(max(width, height))), tr("without calibration")

    def value(name: str) -> float:
        element = calibration.find(name)
        return 0.0 if element is None else float(_numbers(path, element, 1)[0])

    kind = calibration.get("type") or sensor.get("type") or "frame"
    is_old_format = calibration.find("f") is None and calibration.find("fx") is not None
    if is_old_format:
        # PhotoScan before 1.2 writes two focal lengths, and the centre relative to the corner.
        fx, fy, cx, cy = (value(n) for n in ("fx", "fy", "cx", "cy"))
    else:
        fx, fy = value("f") + value("b1"), value("f")
        cx, cy = width / 2 + value("cx"), height / 2 + value("cy")
    if not (fx > 0 and fy > 0):
        if kind not in ("frame", "fisheye"):
            return pinhole_lens(width, height, max(width, height) / 2.0), kind
        raise _damage_error(path, calibration, tr("the focal length is missing or not positive"))
    k1, k2, k3, k4 = (value(n) for n in ("k1", "k2", "k3", "k4"))
    if kind == "frame":
        params = (fx, fy, cx, cy, k1, k2, value("p2"), value("p1"), k3, 0.0, 0.0, 0.0)
        unused_names = [n for n in ("k4", "b2", "p3", "p4") if value(n)]
        lens = Intrinsics("FULL_OPENCV", width, height, params)
        if not unused_names:
            return lens, None
        return lens, tr("with the coefficients {names}", names=", ".join(unused_names))
    if kind in ("fisheye", "equidistant_fisheye"):
        return Intrinsics("OPENCV_FISHEYE", width, height, (fx, fy, cx, cy, k1, k2, k3, k4)), None
    return Intrinsics("PINHOLE", width, height, (fx, fy, cx, cy)), kind


# --- elements ---------------------------------------------------------------------------------
def _numbers(path: Path, element: Element, count: int) -> FloatArray:
    try:
        values = np.array([float(word) for word in (element.text or "").split()])
    except ValueError as error:
        reason = tr(
            "'{text}' contains a value that is not a number",
            text=(element.text or "").strip()[:40],
        )
        raise _damage_error(path, element, reason) from error
    if len(values) != count or not np.isfinite(values).all():
        raise _damage_error(
            path,
            element,
            tr(
                "the number of finite values must be {count} (values given: {given})",
                count=count,
                given=len(values),
            ),
        )
    return values


def _damage_error(path: Path, element: Element, error: str) -> InputError:
    name = element.get("label") or element.get("id")
    field = f"{element.tag} {name}" if name else str(element.tag)
    finding = Finding("file.damaged", reason=error.rstrip("."), format="Metashape")
    return InputError(finding, file=path, line=element.sourceline, field=field)
