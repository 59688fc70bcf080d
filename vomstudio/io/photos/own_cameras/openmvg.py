"""Cameras of OpenMVG: `sfm_data.json`.

The rotation of a pose is from the World frame to the camera, with x right, y down, z forward; the
centre is that of the camera (OpenMVG documentation, "SfM: Structure from Motion"; source of its
module `cameras`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
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
    pinhole_lens,
    unknown_lens_finding,
    view_from_centre,
)

FILE_NAMES = ("sfm_data.json",)
_DISTORTIONS = {"disto_k1": 1, "disto_k3": 3, "disto_t2": 5, "fisheye": 4}
"""Number of distortion parameters by key."""


def is_openmvg(data: Any) -> bool:
    """Return whether the content of a JSON file is a scene of OpenMVG."""
    return isinstance(data, dict) and {"sfm_data_version", "views", "intrinsics"} <= data.keys()


def read_openmvg(path: Path, data: Mapping[str, Any]) -> list[Candidate]:
    """Read the cameras of a scene.

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
    fields = JsonFields(path, "OpenMVG")
    lenses = {}
    for index, row in enumerate(data["intrinsics"]):
        field = f"intrinsics/{index}"
        content = _content(fields, field, row)
        lenses[fields.get(field, row, "key")] = fields.call(field, _lens, row, content)
    poses = {
        fields.get(f"extrinsics/{index}", row, "key"): (index, row)
        for index, row in enumerate(data.get("extrinsics", []))
    }
    views = list[View]()
    unknown_models = Counter[str]()
    missing_lens_ids: dict[str, object] = {}
    for index, row in enumerate(data["views"]):
        field = f"views/{index}"
        photo = _content(fields, field, row)
        pose_number, pose = poses.get(fields.get(field, photo, "id_pose"), (0, None))
        if pose is None:
            continue
        lens, unknown_model = lenses.get(fields.get(field, photo, "id_intrinsic"), (None, None))
        if unknown_model is not None:
            unknown_models[unknown_model] += 1
        folder = str(photo.get("local_path", "")).replace("\\", "/").strip("/")
        name = str(fields.get(field, photo, "filename")).replace("\\", "/")
        field = f"extrinsics/{pose_number}/value"
        value = fields.get(f"extrinsics/{pose_number}", pose, "value")
        rotation = fields.numbers(field, value, "rotation", 3, 3)
        centre = fields.numbers(field, value, "center", 3)
        name = f"{folder}/{name}" if folder else name
        if lens is None:
            missing_lens_ids[name] = photo["id_intrinsic"]
            lens = placeholder_lens()
        views.append(fields.call(field, view_from_centre, name, lens, rotation, centre))
    warnings = tuple(unknown_lens_finding(name, count) for name, count in unknown_models.items())
    return [
        Candidate(
            tr("the frame of the file"),
            views,
            (*warnings, *missing_lens_findings(missing_lens_ids)),
        )
    ]


def _content(fields: JsonFields, field: str, row: Any) -> Mapping[str, Any]:
    """Return the content of a serialised object. Raises InputError."""
    for key in ("value", "ptr_wrapper", "data"):
        row = fields.get(field, row, key)
    if not isinstance(row, Mapping):
        raise fields.damage_error(field, tr("the field is missing"))
    return row


def _lens(row: Mapping[str, Any], content: Mapping[str, Any]) -> tuple[Intrinsics, str | None]:
    width, height = int(content["width"]), int(content["height"])
    if "focal_length" not in content:
        kind = str(row["value"].get("polymorphic_name", tr("without focal length")))
        return pinhole_lens(width, height, max(width, height) / 2.0), kind
    focal = float(content["focal_length"])
    cx, cy = (float(value) for value in content["principal_point"])
    if not (focal > 0 and width > 0 and height > 0 and np.isfinite([cx, cy]).all()):
        raise ValueError(tr("the focal length is missing or not positive"))
    for key, count in _DISTORTIONS.items():
        if key not in content:
            continue
        values = [float(value) for value in content[key]]
        if len(values) != count:
            reason = tr(
                "{name} has an unexpected number of values ({count})", name=key, count=len(values)
            )
            raise ValueError(reason)
        if key == "fisheye":
            params = (focal, focal, cx, cy, *values)
            return Intrinsics("OPENCV_FISHEYE", width, height, params), None
        k1, k2, k3, p1, p2 = (*values, 0.0, 0.0, 0.0, 0.0)[:5]
        params = (focal, focal, cx, cy, k1, k2, p1, p2, k3, 0.0, 0.0, 0.0)
        return Intrinsics("FULL_OPENCV", width, height, params), None
    return Intrinsics.pinhole(width, height, focal, cx, cy), None
