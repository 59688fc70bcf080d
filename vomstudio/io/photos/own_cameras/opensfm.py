"""Cameras of OpenSfM and OpenDroneMap: `reconstruction.json` and `shots.geojson`.

The rotation of a shot is an angle times an axis, from the World frame to the camera, with x right,
y down, z forward. `reconstruction.json` contains the translation from the World frame to the
camera, and `shots.geojson` contains the camera centre in UTM coordinates. Lens parameters are
in units of the longer side of the photo.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import read_small_text
from vomstudio.core.findings import Finding
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
    view_from_pose,
)

FILE_NAMES = ("shots.geojson", "reconstruction.json")
_FORMAT = "OpenSfM"


def is_opensfm(data: Any) -> bool:
    """Return whether the content of a JSON file is a list of reconstructions."""
    return (
        isinstance(data, list)
        and bool(data)
        and all(
            isinstance(entry, dict) and "shots" in entry and "cameras" in entry for entry in data
        )
    )


def is_shot_collection(data: Any) -> bool:
    """Return whether the content of a JSON file is an OpenDroneMap collection of shots."""
    if not isinstance(data, dict) or data.get("type") != "FeatureCollection":
        return False
    features = data.get("features")
    return isinstance(features, list) and any(
        isinstance(feature, dict)
        and isinstance(feature.get("properties"), dict)
        and {"filename", "rotation", "translation"} <= feature["properties"].keys()
        for feature in features
    )


def read_reconstruction(path: Path, data: Sequence[Mapping[str, Any]]) -> list[Candidate]:
    """Read the cameras of the reconstruction with the most shots.

    Parameters
    ----------
    path : Path
        Path of the file, for error messages and for finding files next to it.
    data : sequence of mapping
        Content of the file.

    Raises
    ------
    InputError
        If the file is not valid; states the field.
    """
    reconstruction = max(data, key=lambda entry: len(entry["shots"]))
    warnings = []
    if len(data) > 1:
        warnings.append(Finding("cameras.several-parts", count=len(data)))
    if find_offset(path) is not None:
        warnings.append(Finding("cameras.own-frame"))
    fields = JsonFields(path, _FORMAT)
    lenses = {
        name: fields.call(f"cameras/{name}", _lens, camera)
        for name, camera in reconstruction["cameras"].items()
    }
    views, unknown_models = [], []
    missing_lens_ids: dict[str, object] = {}
    for name, shot in reconstruction["shots"].items():
        field = f"shots/{name}"
        lens, unknown_model = lenses.get(fields.get(field, shot, "camera"), (None, None))
        if lens is None:
            missing_lens_ids[name] = shot["camera"]
            lens = placeholder_lens()
        if unknown_model is not None:
            unknown_models.append(unknown_model)
        rotation = _matrix(fields.numbers(field, shot, "rotation", 3))
        translation = fields.numbers(field, shot, "translation", 3)
        views.append(fields.call(field, view_from_pose, name, lens, rotation, translation))
    warnings += [
        unknown_lens_finding(name, count) for name, count in Counter(unknown_models).items()
    ]
    warnings += missing_lens_findings(missing_lens_ids)
    return [Candidate(tr("the frame of the file"), views, tuple(warnings))]


def read_shots(path: Path, data: Mapping[str, Any]) -> list[Candidate]:
    """Return shots in UTM coordinates and, if known, relative to the offset of the models.

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
    fields = JsonFields(path, _FORMAT)
    views: list[View] = []
    for index, feature in enumerate(data["features"]):
        field = f"features/{index}/properties"
        shot = feature.get("properties") if isinstance(feature, dict) else None
        if not isinstance(shot, dict):
            raise fields.damage_error(field, tr("the properties are missing"))
        name = str(fields.get(field, shot, "filename"))
        lens = fields.call(field, _shot_lens, shot)
        rotation = _matrix(fields.numbers(field, shot, "rotation", 3))
        centre = fields.numbers(field, shot, "translation", 3)
        views.append(fields.call(field, view_from_centre, name, lens, rotation, centre))
    candidates = [Candidate(tr("map coordinates"), views)]
    offset = find_offset(path)
    if offset is not None:
        shifted_views = [view.moved(1.0, np.eye(3), -np.array([*offset, 0.0])) for view in views]
        candidates.append(
            Candidate(tr("map coordinates minus the offset in coords.txt"), shifted_views)
        )
    return candidates


def find_offset(path: Path) -> tuple[float, float] | None:
    """Return the east and north offset of OpenDroneMap models in `coords.txt`, or None."""
    for folder in (path.parent, path.parent / ".." / "odm_georeferencing"):
        try:
            lines = read_small_text(folder / "coords.txt").split("\n")
            east, north = (float(cell) for cell in lines[1].split()[:2])
        except (OSError, ValueError, IndexError, InputError):
            continue
        return east, north
    return None


# --- lenses -----------------------------------------------------------------------------------
def _lens(camera: Mapping[str, Any]) -> tuple[Intrinsics, str | None]:
    kind = str(camera.get("projection_type", "perspective"))
    width, height = int(camera["width"]), int(camera["height"])
    long_side = float(max(width, height))
    if kind in ("spherical", "equirectangular"):
        return pinhole_lens(width, height, long_side / 2.0), kind
    fx = float(camera.get("focal_x", camera.get("focal", 0.0))) * long_side
    fy = float(camera.get("focal_y", camera.get("focal", 0.0))) * long_side
    if not (fx > 0 and fy > 0 and width > 0 and height > 0):
        raise ValueError(tr("the focal length is missing or not positive"))
    # OpenSfM's centre is relative to the centre of the photo.
    cx = width / 2.0 + float(camera.get("c_x", 0.0)) * long_side
    cy = height / 2.0 + float(camera.get("c_y", 0.0)) * long_side
    k1, k2, k3, k4, p1, p2 = (
        float(camera.get(key, 0.0)) for key in ("k1", "k2", "k3", "k4", "p1", "p2")
    )
    if kind in ("perspective", "brown", "simple_radial", "radial"):
        params = (fx, fy, cx, cy, k1, k2, p1, p2, k3, 0.0, 0.0, 0.0)
        return Intrinsics("FULL_OPENCV", width, height, params), None
    if kind in ("fisheye", "fisheye_opencv"):
        return Intrinsics("OPENCV_FISHEYE", width, height, (fx, fy, cx, cy, k1, k2, k3, k4)), None
    return Intrinsics("PINHOLE", width, height, (fx, fy, cx, cy)), kind


def _shot_lens(shot: Mapping[str, Any]) -> Intrinsics:
    """Return the lens of a shot, for which only the focal length is stated."""
    width, height = int(shot.get("width") or 0), int(shot.get("height") or 0)
    focal = float(shot.get("focal") or 0.0)
    if not (width > 0 and height > 0 and focal > 0):
        # In this case, only positions and attitudes can be used.
        width, height, focal = 2, 2, 1.0
    return pinhole_lens(width, height, focal * max(width, height))


def _matrix(rotation_vector: FloatArray) -> FloatArray:
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_rotvec(rotation_vector).as_matrix(), np.float64)
