"""Cameras of nerfstudio, instant-ngp and similar programs: `transforms.json`.

The matrix of a frame is from the camera to the World frame, with x right, y up, z backward.
Parameters of the lens are in pixels, with the names of OpenCV, for the file or for each frame
(nerfstudio documentation, "Data conventions").
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.io.photos.own_cameras.frames import Candidate
from vomstudio.io.photos.own_cameras.json_fields import JsonFields
from vomstudio.io.photos.own_cameras.photo_sizes import (
    Size,
    placeholder_lens,
    read_sizes,
    unknown_size_findings,
)
from vomstudio.io.photos.own_cameras.result import (
    MAX_ROTATION_DEVIATION,
    unknown_lens_finding,
    view_from_centre,
)

FILE_NAMES = ("transforms.json",)
_AXES = np.diag([1.0, -1.0, -1.0])
"""Rotation from a camera frame with y up, z backward to one with y down, z forward."""
_KNOWN_MODELS = ("OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL", "PERSPECTIVE")


def is_nerfstudio(data: Any) -> bool:
    """Return whether the content of a JSON file has frames with matrices."""
    if not isinstance(data, dict) or not isinstance(data.get("frames"), list):
        return False
    return any(isinstance(row, dict) and "transform_matrix" in row for row in data["frames"])


def read_nerfstudio(path: Path, data: Mapping[str, Any]) -> list[Candidate]:
    """Read the cameras.

    The candidates are the frame of the file and, if the file states a transform that nerfstudio
    applied, the frame before it, which is that of a model from COLMAP.

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
    fields = JsonFields(path, "transforms.json")
    names = [
        str(fields.get(f"frames/{index}", row, "file_path")).replace("\\", "/").removeprefix("./")
        for index, row in enumerate(data["frames"])
    ]
    has_sizes = all({"w", "h"} <= {**data, **row}.keys() for row in data["frames"])
    sizes = {} if has_sizes else read_sizes(path, names)
    views = list[View]()
    unknown_models = Counter[str]()
    for index, (name, row) in enumerate(zip(names, data["frames"], strict=True)):
        field = f"frames/{index}"
        matrix = fields.numbers(field, row, "transform_matrix", 4, 4)
        lens, unknown_model = fields.call(field, _lens, {**data, **row}, sizes.get(name))
        if unknown_model is not None:
            unknown_models[unknown_model] += 1
        rotation = (matrix[:3, :3] @ _AXES).T
        views.append(fields.call(field, view_from_centre, name, lens, rotation, matrix[:3, 3]))
    warnings: list[Finding] = [] if has_sizes else unknown_size_findings(sizes, names)
    warnings += [unknown_lens_finding(name, count) for name, count in unknown_models.items()]
    candidates = [Candidate(tr("the frame of the file"), views, tuple(warnings))]
    if "applied_transform" in data:
        applied_transform = fields.numbers("", data, "applied_transform", 3, 4)
        inverse_rotation = applied_transform[:, :3].T
        if np.abs(inverse_rotation @ inverse_rotation.T - np.eye(3)).max() > MAX_ROTATION_DEVIATION:
            raise fields.damage_error("applied_transform", tr("the pose matrix is not a rotation"))
        untransformed_views = [
            view.moved(1.0, inverse_rotation, -inverse_rotation @ applied_transform[:, 3])
            for view in views
        ]
        candidates.append(
            Candidate(
                tr("the original frame, before applied_transform"),
                untransformed_views,
                tuple(warnings),
            )
        )
    return candidates


def _lens(row: Mapping[str, Any], size: Size | None) -> tuple[Intrinsics, str | None]:
    if size is None and not {"w", "h"} <= row.keys():
        return placeholder_lens(), None
    width, height = size or (int(row["w"]), int(row["h"]))
    if "fl_x" in row or "fl_y" in row:
        fx = float(row.get("fl_x", row.get("fl_y")))
        fy = float(row.get("fl_y", fx))
    elif "camera_angle_x" in row:
        fx = fy = width / 2.0 / float(np.tan(float(row["camera_angle_x"]) / 2.0))
    else:
        raise KeyError("fl_x")
    cx, cy = float(row.get("cx", width / 2.0)), float(row.get("cy", height / 2.0))
    if not (fx > 0 and fy > 0 and width > 0 and height > 0 and np.isfinite([cx, cy]).all()):
        raise ValueError(tr("the focal length is missing or not positive"))
    k1, k2, k3, k4, p1, p2 = (
        float(row.get(key, 0.0)) for key in ("k1", "k2", "k3", "k4", "p1", "p2")
    )
    model = str(row.get("camera_model", "OPENCV"))
    if model == "OPENCV_FISHEYE" or row.get("is_fisheye"):
        return Intrinsics("OPENCV_FISHEYE", width, height, (fx, fy, cx, cy, k1, k2, k3, k4)), None
    params = (fx, fy, cx, cy, k1, k2, p1, p2, k3, 0.0, 0.0, 0.0)
    lens = Intrinsics("FULL_OPENCV", width, height, params)
    return lens, None if model in _KNOWN_MODELS else model
