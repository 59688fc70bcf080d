"""Cameras of OpenSfM and OpenDroneMap: `reconstruction.json` and `shots.geojson`.

A shot's rotation is an angle times an axis from World to the camera, x right, y down, z forward.
`reconstruction.json` has the translation from World to the camera, `shots.geojson` the centre of
the camera in UTM. Lenses are given in units of the longer side of the photo.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError, InputError
from vomstudio.core.files.regular import read_json, read_small_text
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.io.photos.own_cameras.frames import Candidate
from vomstudio.io.photos.own_cameras.result import from_centre, posed, straight, unknown_lens

NAMES = ("shots.geojson", "reconstruction.json")
_NUMBERS = (int, float)


def is_opensfm(data: Any) -> bool:
    """Of a JSON file: whether it is a list of reconstructions."""
    return (
        isinstance(data, list)
        and bool(data)
        and all(isinstance(each, dict) and "shots" in each and "cameras" in each for each in data)
    )


def is_shots(data: Any) -> bool:
    """Of a JSON file: whether it is the collection of shots of OpenDroneMap."""
    if not isinstance(data, dict) or data.get("type") != "FeatureCollection":
        return False
    features = data.get("features")
    return isinstance(features, list) and any(
        isinstance(each, dict)
        and isinstance(each.get("properties"), dict)
        and {"filename", "rotation", "translation"} <= each["properties"].keys()
        for each in features
    )


def read_reconstruction(path: Path, data: Sequence[Mapping[str, Any]]) -> list[Candidate]:
    """Raises InputError that names the field."""
    largest = max(data, key=lambda each: len(each["shots"]))
    warnings = []
    if len(data) > 1:
        warnings.append(Finding("cameras.several-parts", count=len(data)))
    if find_offset(path) is not None:
        warnings.append(Finding("cameras.own-frame"))
    lenses = {
        name: _checked(path, f"cameras/{name}", _lens, name, camera)
        for name, camera in largest["cameras"].items()
    }
    views, odd = [], []
    for name, shot in largest["shots"].items():
        where = f"shots/{name}"
        lens, unknown = lenses.get(_get(path, where, shot, "camera"), (None, None))
        if lens is None:
            raise _bad(path, where, tr("its camera is not among the cameras"))
        if unknown is not None:
            odd.append(unknown)
        rotation = _three(path, where, shot, "rotation")
        translation = _three(path, where, shot, "translation")
        views.append(_checked(path, where, posed, name, lens, _matrix(rotation), translation))
    warnings += [unknown_lens(name, count) for name, count in Counter(odd).items()]
    return [Candidate(tr("the file"), views, tuple(warnings))]


def read_shots(path: Path, data: Mapping[str, Any]) -> list[Candidate]:
    """In UTM, and from the offset that OpenDroneMap takes off its models. Raises InputError that
    names the field."""
    views: list[View] = []
    for number, feature in enumerate(data["features"]):
        where = f"features/{number}/properties"
        shot = feature.get("properties") if isinstance(feature, dict) else None
        if not isinstance(shot, dict):
            raise _bad(path, where, tr("there are none"))
        name = str(_get(path, where, shot, "filename"))
        lens = _checked(path, where, _plain_lens, shot)
        rotation = _matrix(_three(path, where, shot, "rotation"))
        centre = _three(path, where, shot, "translation")
        views.append(_checked(path, where, from_centre, name, lens, rotation, centre))
    found = [Candidate(tr("map coordinates"), views)]
    offset = find_offset(path)
    if offset is not None:
        moved = [view.moved(1.0, np.eye(3), -np.array([*offset, 0.0])) for view in views]
        found.append(Candidate(tr("map coordinates less the offset in coords.txt"), moved))
    return found


def find_offset(path: Path) -> tuple[float, float] | None:
    """East and north that OpenDroneMap takes off its models, from its `coords.txt`."""
    for folder in (path.parent, path.parent / ".." / "odm_georeferencing"):
        try:
            lines = read_small_text(folder / "coords.txt").split("\n")
            east, north = (float(cell) for cell in lines[1].split()[:2])
        except (OSError, ValueError, IndexError, InputError):
            continue
        return east, north
    return None


# --- lenses -----------------------------------------------------------------------------------
def _lens(name: str, camera: Mapping[str, Any]) -> tuple[Intrinsics, str | None]:
    """Raises KeyError, TypeError, ValueError or GeometryError."""
    kind = str(camera.get("projection_type", "perspective"))
    width, height = int(camera["width"]), int(camera["height"])
    side = float(max(width, height))
    if kind in ("spherical", "equirectangular"):
        return straight(width, height, side / 2.0), kind
    fx = float(camera.get("focal_x", camera.get("focal", 0.0))) * side
    fy = float(camera.get("focal_y", camera.get("focal", 0.0))) * side
    if not (fx > 0 and fy > 0 and width > 0 and height > 0):
        raise ValueError(tr("the focal length is missing or not positive"))
    # OpenSfM counts from the middle of the photo.
    cx = width / 2.0 + float(camera.get("c_x", 0.0)) * side
    cy = height / 2.0 + float(camera.get("c_y", 0.0)) * side
    k1, k2, k3, k4, p1, p2 = (
        float(camera.get(key, 0.0)) for key in ("k1", "k2", "k3", "k4", "p1", "p2")
    )
    if kind in ("perspective", "brown", "simple_radial", "radial"):
        params = (fx, fy, cx, cy, k1, k2, p1, p2, k3, 0.0, 0.0, 0.0)
        return Intrinsics("FULL_OPENCV", width, height, params), None
    if kind in ("fisheye", "fisheye_opencv"):
        return Intrinsics("OPENCV_FISHEYE", width, height, (fx, fy, cx, cy, k1, k2, k3, k4)), None
    return Intrinsics("PINHOLE", width, height, (fx, fy, cx, cy)), kind


def _plain_lens(shot: Mapping[str, Any]) -> Intrinsics:
    """What shots tell of their lens: the focal length alone."""
    width, height = int(shot.get("width") or 0), int(shot.get("height") or 0)
    focal = float(shot.get("focal") or 0.0)
    if not (width > 0 and height > 0 and focal > 0):
        # Only positions and attitudes can be used then.
        width, height, focal = 2, 2, 1.0
    return straight(width, height, focal * max(width, height))


# --- fields -----------------------------------------------------------------------------------
def load_json(path: Path) -> Any:
    """Raises InputError."""
    try:
        return read_json(path)
    except OSError as error:
        raise InputError(Finding("file.unreadable", reason=error.strerror), file=path) from error
    except ValueError as error:
        raise InputError(Finding("file.damaged", reason=error, format="JSON"), file=path) from error


def _matrix(turn: FloatArray) -> FloatArray:
    from scipy.spatial.transform import Rotation

    return np.asarray(Rotation.from_rotvec(turn).as_matrix(), np.float64)


def _get(path: Path, where: str, row: Any, key: str) -> Any:
    if not isinstance(row, dict) or key not in row:
        raise _bad(path, f"{where}/{key}", tr("it is missing"))
    return row[key]


def _three(path: Path, where: str, row: Any, key: str) -> FloatArray:
    value = _get(path, where, row, key)
    good = isinstance(value, list) and len(value) == 3
    if not good or not all(isinstance(v, _NUMBERS) and np.isfinite(v) for v in value):
        raise _bad(path, f"{where}/{key}", tr("three numbers are wanted"))
    return np.array(value, np.float64)


def _checked(path: Path, where: str, make: Any, *given: Any) -> Any:
    try:
        return make(*given)
    except (KeyError, TypeError, ValueError, AttributeError, GeometryError) as error:
        said = str(error)
        if isinstance(error, KeyError):
            said = tr("{name} is missing", name=error.args[0])
        raise _bad(path, where, said) from error


def _bad(path: Path, where: str, error: str) -> InputError:
    finding = Finding("file.damaged", reason=error.rstrip("."), format="OpenSfM")
    return InputError(finding, file=path, field=where)
