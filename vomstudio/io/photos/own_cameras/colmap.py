"""Cameras of COLMAP: `cameras` and `images` files, as text or binary data.

Each image has a rotation (quaternion, w first) and a translation from the World frame to the
camera, with x right, y down, z forward (COLMAP documentation, "Output Format").
"""

from __future__ import annotations

import struct
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.errors import GeometryError, InputError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.cameras import CAMERA_MODELS, Intrinsics, View
from vomstudio.io.photos.own_cameras.result import (
    ModelCameras,
    cameras_from_views,
    pinhole_lens,
    unknown_lens_finding,
    view_from_pose,
)
from vomstudio.io.text.file_text import read_bytes, read_text

Lenses = dict[int, tuple[Intrinsics, str | None]]
"""Lenses by camera ID, with the name of the lens model if it is not supported."""

FILE_NAMES = ("images.bin", "images.txt")
# Number, name and parameter count of the lens models of COLMAP 4.2.
_MODELS = (
    (0, "SIMPLE_PINHOLE", 3),
    (1, "PINHOLE", 4),
    (2, "SIMPLE_RADIAL", 4),
    (3, "RADIAL", 5),
    (4, "OPENCV", 8),
    (5, "OPENCV_FISHEYE", 8),
    (6, "FULL_OPENCV", 12),
    (7, "FOV", 5),
    (8, "SIMPLE_RADIAL_FISHEYE", 4),
    (9, "RADIAL_FISHEYE", 5),
    (10, "THIN_PRISM_FISHEYE", 12),
    (11, "RAD_TAN_THIN_PRISM_FISHEYE", 16),
    (12, "SIMPLE_DIVISION", 4),
    (13, "DIVISION", 5),
    (14, "SIMPLE_FISHEYE", 3),
    (15, "FISHEYE", 4),
    (16, "EUCM", 6),
    (17, "EQUIRECTANGULAR", 2),
)
_MODELS_BY_NUMBER = {number: (name, count) for number, name, count in _MODELS}
_PARAMETER_COUNTS = {name: count for _, name, count in _MODELS}
_TWO_FOCAL_MODELS = {"FOV", "THIN_PRISM_FISHEYE", "RAD_TAN_THIN_PRISM_FISHEYE", "DIVISION", "EUCM"}


def find_folder(path: Path) -> Path | None:
    """Return the folder of a sparse model from its path or one of its files, or None."""
    folder = path if path.is_dir() else path.parent
    if path.is_dir() or path.name in (*FILE_NAMES, "cameras.bin", "cameras.txt"):
        for name in FILE_NAMES:
            if (folder / name).is_file() and (folder / name.replace("images", "cameras")).is_file():
                return folder
    return None


def read_colmap(folder: Path) -> ModelCameras:
    """Read the cameras of COLMAP.

    Raises
    ------
    InputError
        If a file is not valid; states the file and the line or field.
    """
    is_binary = (folder / FILE_NAMES[0]).is_file() and (folder / "cameras.bin").is_file()
    images = folder / FILE_NAMES[0 if is_binary else 1]
    lenses = (
        _binary_lenses(folder / "cameras.bin")
        if is_binary
        else _text_lenses(folder / "cameras.txt")
    )
    camera_images = list(
        _binary_images(images, lenses) if is_binary else _text_images(images, lenses)
    )
    used_models = Counter(lenses[camera][1] for camera, _ in camera_images)
    warnings = [
        unknown_lens_finding(name, count) for name, count in used_models.items() if name is not None
    ]
    return cameras_from_views(images, (view for _, view in camera_images), None, warnings)


# --- lenses -----------------------------------------------------------------------------------
def _lens(
    model: str, width: int, height: int, parameters: tuple[float, ...]
) -> tuple[Intrinsics, str | None]:
    if model not in _PARAMETER_COUNTS:
        raise ValueError(tr("{model} is not a camera model of COLMAP", model=model[:40]))
    if len(parameters) != _PARAMETER_COUNTS[model]:
        raise ValueError(
            tr(
                "the camera model {model} needs {count} parameters, not {given}",
                model=model,
                count=_PARAMETER_COUNTS[model],
                given=len(parameters),
            )
        )
    if not (width > 0 and height > 0 and np.isfinite(parameters).all()):
        raise ValueError(tr("the size or a parameter of the camera is invalid"))
    if model in CAMERA_MODELS:
        return Intrinsics(model, width, height, parameters), None
    if model == "EQUIRECTANGULAR":
        return pinhole_lens(width, height, max(width, height) / 2.0), model
    if model in ("SIMPLE_FISHEYE", "SIMPLE_RADIAL_FISHEYE", "RADIAL_FISHEYE"):
        f, cx, cy, *k = parameters
        distortion = (*k, 0.0, 0.0, 0.0, 0.0)[:4]
        return Intrinsics("OPENCV_FISHEYE", width, height, (f, f, cx, cy, *distortion)), None
    if model == "FISHEYE":
        return Intrinsics("OPENCV_FISHEYE", width, height, (*parameters, 0.0, 0.0, 0.0, 0.0)), None
    if model in _TWO_FOCAL_MODELS:
        return Intrinsics("PINHOLE", width, height, parameters[:4]), model
    f, cx, cy = parameters[:3]
    return Intrinsics("PINHOLE", width, height, (f, f, cx, cy)), model


def _text_lenses(path: Path) -> Lenses:
    lenses: Lenses = {}
    for line_number, line in _lines(path):
        cells = line.split()
        if not cells:
            continue
        try:
            width, height = int(cells[2]), int(cells[3])
            params = tuple(float(cell) for cell in cells[4:])
            lenses[int(cells[0])] = _lens(cells[1], width, height, params)
        except (ValueError, IndexError, GeometryError) as error:
            raise _damage_error(
                path, error, tr("CAMERA_ID MODEL WIDTH HEIGHT PARAMS"), line_number
            ) from error
    return lenses


def _binary_lenses(path: Path) -> Lenses:
    file = _BinaryReader(path)
    lenses: Lenses = {}
    for _ in range(file.count(tr("cameras"))):
        camera_id, model = file.read_values("<ii", tr("cameras"))
        width, height = file.read_values("<QQ", tr("cameras"))
        if model not in _MODELS_BY_NUMBER:
            raise file.damage_error(
                tr("{model} is not a camera model of COLMAP", model=model), tr("cameras")
            )
        name, count = _MODELS_BY_NUMBER[model]
        params = file.read_values(f"<{count}d", tr("cameras"))
        try:
            lenses[camera_id] = _lens(name, width, height, params)
        except (ValueError, GeometryError) as error:
            raise file.damage_error(str(error), tr("camera {number}", number=camera_id)) from error
    return lenses


# --- images -----------------------------------------------------------------------------------
def _text_images(path: Path, lenses: Lenses) -> Iterator[tuple[int, View]]:
    """Yield camera ID and view of each image; a line of points follows each pose line.

    Raises InputError with the line.
    """
    is_pose_line = True
    for line_number, line in _lines(path):
        if not is_pose_line:
            is_pose_line = True
            continue
        cells = line.split(maxsplit=9)
        if not cells:
            continue
        is_pose_line = False
        try:
            pose = [float(cell) for cell in cells[1:8]]
            camera, name = int(cells[8]), cells[9].strip()
            yield camera, _view(name, lenses, camera, pose)
        except (ValueError, IndexError) as error:
            columns = tr("IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME")
            raise _damage_error(path, error, columns, line_number) from error


def _binary_images(path: Path, lenses: Lenses) -> Iterator[tuple[int, View]]:
    file = _BinaryReader(path)
    for index in range(file.count(tr("images"))):
        field = tr("image {number}", number=index + 1)
        file.read_values("<i", field)
        pose = file.read_values("<7d", field)
        (camera,) = file.read_values("<i", field)
        name = file.read_string(field)
        file.skip(24 * file.count(field), field)
        try:
            yield camera, _view(name, lenses, camera, list(pose))
        except ValueError as error:
            raise file.damage_error(str(error), name) from error


def _view(name: str, lenses: Lenses, camera: int, pose: list[float]) -> View:
    from scipy.spatial.transform import Rotation

    if camera not in lenses:
        raise ValueError(tr("camera {number} does not exist", number=camera))
    w, x, y, z = pose[:4]
    length = float(np.linalg.norm([w, x, y, z]))
    if not 0.9 < length < 1.1:
        raise ValueError(
            tr("the length of the quaternion is {length:.3g} instead of 1", length=length)
        )
    rotation = Rotation.from_quat([x, y, z, w]).as_matrix()
    return view_from_pose(name.replace("\\", "/"), lenses[camera][0], rotation, np.array(pose[4:]))


# --- files ------------------------------------------------------------------------------------
def _lines(path: Path) -> Iterator[tuple[int, str]]:
    text, _ = read_text(path, accepted_names=("colmap",))
    for line_number, line in enumerate(text.split("\n"), 1):
        if not line.lstrip().startswith("#"):
            yield line_number, line


def _damage_error(path: Path, error: Exception, columns: str, line: int) -> InputError:
    finding = Finding(
        "file.damaged", format="COLMAP", reason=f"{str(error)[:120].rstrip('.')} ({columns})"
    )
    return InputError(finding, file=path, line=line)


class _BinaryReader:
    """Sequential reader of the numbers of a file."""

    def __init__(self, path: Path) -> None:
        self.path, self._data, self._offset = path, read_bytes(path), 0

    def read_values(self, format_: str, field: str) -> tuple[Any, ...]:
        size = struct.calcsize(format_)
        if self._offset + size > len(self._data):
            raise self.damage_error(tr("the file ends too early"), field)
        self._offset += size
        return struct.unpack_from(format_, self._data, self._offset - size)

    def count(self, field: str) -> int:
        (count,) = self.read_values("<Q", field)
        if count > len(self._data):
            raise self.damage_error(tr("the file ends too early"), field)
        return int(count)

    def skip(self, size: int, field: str) -> None:
        self._offset += size
        if self._offset > len(self._data):
            raise self.damage_error(tr("the file ends too early"), field)

    def read_string(self, field: str) -> str:
        end = self._data.find(b"\0", self._offset)
        if end < 0:
            raise self.damage_error(tr("the file ends too early"), field)
        text = self._data[self._offset : end].decode("utf-8", "replace")
        self._offset = end + 1
        return text

    def damage_error(self, error: str, field: str) -> InputError:
        finding = Finding("file.damaged", reason=error, format="COLMAP")
        return InputError(finding, file=self.path, field=field)
