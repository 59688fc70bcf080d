"""Cameras of AliceVision and Meshroom: `cameras.sfm` and other scenes in JSON.

The nine numbers of a rotation are the columns of the matrix from the World frame to the camera,
with x right, y down, z forward; the centre is that of the camera. Numbers are written as text. From
version 1.2.1 on the principal point is relative to the centre of the photo, and from version 1.2.2
on the focal length is in millimetres (AliceVision, source of its module `sfmDataIO`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.words import tr
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.io.photos.own_cameras.frames import Candidate
from vomstudio.io.photos.own_cameras.json_fields import JsonFields
from vomstudio.io.photos.own_cameras.photo_sizes import placeholder_lens
from vomstudio.io.photos.own_cameras.result import (
    missing_lens_findings,
    unknown_lens_finding,
    view_from_centre,
)

FILE_NAMES = ("cameras.sfm", "sfm.json")
_BROWN_TYPES = ("brown",)
_RADIAL_TYPES = ("pinhole", "radial1", "radialk1", "radial3", "radialk3", "none")
_FISHEYE_TYPES = ("fisheye4",)
_HALF_TURN = np.diag([1.0, -1.0, -1.0])
"""Rotation by 180 degrees about x that Meshroom applies to models written as OBJ."""


def is_alicevision(data: Any) -> bool:
    """Return whether the content of a JSON file is a scene of AliceVision."""
    if not isinstance(data, dict) or not {"version", "views", "intrinsics"} <= data.keys():
        return False
    views = data["views"]
    return isinstance(views, list) and bool(views) and "viewId" in views[0]


def read_alicevision(path: Path, data: Mapping[str, Any]) -> list[Candidate]:
    """Read the cameras of a scene.

    The candidates are the frame of the file and that of models that Meshroom writes as OBJ.

    Parameters
    ----------
    path : Path
        Path of the file, for error messages and for finding files next to it.
    data : mapping
        Content of the file.

    Raises
    ------
    InputError
        If the file is not valid; states the field.
    """
    fields = JsonFields(path, "AliceVision")
    version = tuple(int(value) for value in fields.numbers("", data, "version", 3))
    lenses = {}
    for index, row in enumerate(data["intrinsics"]):
        field = f"intrinsics/{index}"
        key = str(fields.get(field, row, "intrinsicId"))
        lenses[key] = fields.call(field, _lens, row, version)
    poses = {
        str(fields.get(f"poses/{index}", row, "poseId")): (index, row)
        for index, row in enumerate(data.get("poses", []))
    }
    views = list[View]()
    unknown_models = Counter[str]()
    missing_lens_ids: dict[str, object] = {}
    for index, row in enumerate(data["views"]):
        field = f"views/{index}"
        pose_number, pose = poses.get(str(row.get("poseId")), (0, None))
        if pose is None:
            continue
        lens, unknown_model = lenses.get(str(fields.get(field, row, "intrinsicId")), (None, None))
        if unknown_model is not None:
            unknown_models[unknown_model] += 1
        name = str(fields.get(field, row, "path")).replace("\\", "/").rpartition("/")[2]
        if lens is None:
            missing_lens_ids[name] = row["intrinsicId"]
            lens = placeholder_lens()
        field = f"poses/{pose_number}/pose/transform"
        transform = _nested_value(fields, f"poses/{pose_number}", pose, ("pose", "transform"))
        rotation = fields.numbers(field, transform, "rotation", 9).reshape(3, 3).T
        centre = fields.numbers(field, transform, "center", 3)
        views.append(fields.call(field, view_from_centre, name, lens, rotation, centre))
    warnings = tuple(unknown_lens_finding(name, count) for name, count in unknown_models.items())
    warnings += missing_lens_findings(missing_lens_ids)
    turned_views = [view.moved(1.0, _HALF_TURN, np.zeros(3)) for view in views]
    return [
        Candidate(tr("the frame of the file"), views, warnings),
        Candidate(tr("the frame of Meshroom's OBJ models"), turned_views, warnings),
    ]


def _nested_value(fields: JsonFields, field: str, row: Any, keys: Sequence[str]) -> Any:
    """Return a nested value. Raises InputError if it is missing."""
    for key in keys:
        row = fields.get(field, row, key)
        field = f"{field}/{key}"
    return row


def _lens(row: Mapping[str, Any], version: Sequence[int]) -> tuple[Intrinsics, str | None]:
    width, height = int(row["width"]), int(row["height"])
    fx, fy = _focal(row, version, width)
    cx, cy = (float(value) for value in row["principalPoint"])
    if tuple(version) >= (1, 2, 1):
        cx, cy = cx + width / 2.0, cy + height / 2.0
    if not (fx > 0 and fy > 0 and width > 0 and height > 0 and np.isfinite([cx, cy]).all()):
        raise ValueError(tr("the focal length is missing or not positive"))
    kind = str(row.get("distortionType") or row.get("type", "pinhole"))
    values = [float(value) for value in row.get("distortionParams", ()) or ()]
    if kind in _FISHEYE_TYPES:
        k = (*values, 0.0, 0.0, 0.0, 0.0)[:4]
        return Intrinsics("OPENCV_FISHEYE", width, height, (fx, fy, cx, cy, *k)), None
    k1, k2, k3, p1, p2 = (*values, 0.0, 0.0, 0.0, 0.0, 0.0)[:5]
    params = (fx, fy, cx, cy, k1, k2, p1, p2, k3, 0.0, 0.0, 0.0)
    if kind in _BROWN_TYPES or kind in _RADIAL_TYPES or not any(values):
        return Intrinsics("FULL_OPENCV", width, height, params), None
    return Intrinsics("PINHOLE", width, height, (fx, fy, cx, cy)), kind


def _focal(row: Mapping[str, Any], version: Sequence[int], width: int) -> tuple[float, float]:
    """Return the focal lengths in x and y, in pixels."""
    if tuple(version) < (1, 2, 0):
        focal = float(row["pxFocalLength"])
        return focal, focal
    if tuple(version) < (1, 2, 2):
        fx, fy = (float(value) for value in row["pxFocalLength"])
        return fx, fy
    fx = float(row["focalLength"]) / float(row["sensorWidth"]) * width
    ratio = float(row.get("pixelRatio", 1.0))
    return fx, fx / ratio if tuple(version) < (1, 2, 5) else fx * ratio
