"""Cameras of COLMAP: `cameras` and `images`, as text or binary.

Both give rotation (quaternion, w first) and translation from World to the camera, x right, y down,
z forward (COLMAP's documentation, "Output Format").
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
from vomstudio.geometry.cameras import MODELS, Intrinsics, View
from vomstudio.io.photos.own_cameras.result import (
    OwnCameras,
    of_views,
    posed,
    straight,
    unknown_lens,
)
from vomstudio.io.text.file_text import read_bytes, read_text

Lenses = dict[int, tuple[Intrinsics, str | None]]
"""By number, and the name of the model where it is not known here."""

NAMES = ("images.bin", "images.txt")
# Number, name and count of parameters of the models that COLMAP 4.2 knows.
_KNOWN = (
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
_BY_NUMBER = {number: (name, count) for number, name, count in _KNOWN}
_COUNTS = {name: count for _, name, count in _KNOWN}
_TWO_FOCAL = {"FOV", "THIN_PRISM_FISHEYE", "RAD_TAN_THIN_PRISM_FISHEYE", "DIVISION", "EUCM"}


def folder_of(path: Path) -> Path | None:
    """The folder of a sparse model, given by itself or by one of its files; None where it is
    none."""
    folder = path if path.is_dir() else path.parent
    if path.is_dir() or path.name in (*NAMES, "cameras.bin", "cameras.txt"):
        for name in NAMES:
            if (folder / name).is_file() and (folder / name.replace("images", "cameras")).is_file():
                return folder
    return None


def read_colmap(folder: Path) -> OwnCameras:
    """Raises InputError with file and line, or the field in a binary file."""
    binary = (folder / NAMES[0]).is_file() and (folder / "cameras.bin").is_file()
    images = folder / NAMES[0 if binary else 1]
    lenses = (
        _binary_lenses(folder / "cameras.bin") if binary else _text_lenses(folder / "cameras.txt")
    )
    found = list(_binary_images(images, lenses) if binary else _text_images(images, lenses))
    used = Counter(lenses[camera][1] for camera, _ in found)
    warnings = [unknown_lens(name, count) for name, count in used.items() if name is not None]
    return of_views(images, (view for _, view in found), None, warnings)


# --- lenses -----------------------------------------------------------------------------------
def _lens(
    model: str, width: int, height: int, params: tuple[float, ...]
) -> tuple[Intrinsics, str | None]:
    """Raises ValueError, or GeometryError."""
    if model not in _COUNTS:
        raise ValueError(tr("{model} is no camera model of COLMAP", model=model[:40]))
    if len(params) != _COUNTS[model]:
        raise ValueError(
            tr(
                "the camera model {model} has {count} parameters, not {given}",
                model=model,
                count=_COUNTS[model],
                given=len(params),
            )
        )
    if not (width > 0 and height > 0 and np.isfinite(params).all()):
        raise ValueError(tr("the size or a parameter of the camera is not possible"))
    if model in MODELS:
        return Intrinsics(model, width, height, params), None
    if model == "EQUIRECTANGULAR":
        return straight(width, height, max(width, height) / 2.0), model
    if model in ("SIMPLE_FISHEYE", "SIMPLE_RADIAL_FISHEYE", "RADIAL_FISHEYE"):
        f, cx, cy, *k = params
        bent = (*k, 0.0, 0.0, 0.0, 0.0)[:4]
        return Intrinsics("OPENCV_FISHEYE", width, height, (f, f, cx, cy, *bent)), None
    if model == "FISHEYE":
        return Intrinsics("OPENCV_FISHEYE", width, height, (*params, 0.0, 0.0, 0.0, 0.0)), None
    if model in _TWO_FOCAL:
        return Intrinsics("PINHOLE", width, height, params[:4]), model
    f, cx, cy = params[:3]
    return Intrinsics("PINHOLE", width, height, (f, f, cx, cy)), model


def _text_lenses(path: Path) -> Lenses:
    lenses: Lenses = {}
    for number, line in _lines(path):
        cells = line.split()
        if not cells:
            continue
        try:
            width, height = int(cells[2]), int(cells[3])
            params = tuple(float(cell) for cell in cells[4:])
            lenses[int(cells[0])] = _lens(cells[1], width, height, params)
        except (ValueError, IndexError, GeometryError) as error:
            raise _bad(path, error, tr("CAMERA_ID MODEL WIDTH HEIGHT PARAMS"), number) from error
    return lenses


def _binary_lenses(path: Path) -> Lenses:
    file = _Binary(path)
    lenses: Lenses = {}
    for _ in range(file.count(tr("cameras"))):
        number, model = file.take("<ii", tr("cameras"))
        width, height = file.take("<QQ", tr("cameras"))
        if model not in _BY_NUMBER:
            raise file.bad(tr("{model} is no camera model of COLMAP", model=model), tr("cameras"))
        name, count = _BY_NUMBER[model]
        params = file.take(f"<{count}d", tr("cameras"))
        try:
            lenses[number] = _lens(name, width, height, params)
        except (ValueError, GeometryError) as error:
            raise file.bad(str(error), tr("camera {number}", number=number)) from error
    return lenses


# --- images -----------------------------------------------------------------------------------
def _text_images(path: Path, lenses: Lenses) -> Iterator[tuple[int, View]]:
    """Two lines each: the pose, and the points that are seen, which may be none."""
    of_pose = True
    for number, line in _lines(path):
        if not of_pose:
            of_pose = True
            continue
        cells = line.split(maxsplit=9)
        if not cells:
            continue
        of_pose = False
        try:
            pose = [float(cell) for cell in cells[1:8]]
            camera, name = int(cells[8]), cells[9].strip()
            yield camera, _view(name, lenses, camera, pose)
        except (ValueError, IndexError) as error:
            wanted = tr("IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME")
            raise _bad(path, error, wanted, number) from error


def _binary_images(path: Path, lenses: Lenses) -> Iterator[tuple[int, View]]:
    file = _Binary(path)
    for at in range(file.count(tr("images"))):
        called = tr("image {number}", number=at + 1)
        file.take("<i", called)
        pose = file.take("<7d", called)
        (camera,) = file.take("<i", called)
        name = file.word(called)
        file.skip(24 * file.count(called), called)
        try:
            yield camera, _view(name, lenses, camera, list(pose))
        except ValueError as error:
            raise file.bad(str(error), name) from error


def _view(name: str, lenses: Lenses, camera: int, pose: list[float]) -> View:
    """Raises ValueError."""
    from scipy.spatial.transform import Rotation

    if camera not in lenses:
        raise ValueError(tr("the camera {number} is not among the cameras", number=camera))
    w, x, y, z = pose[:4]
    length = float(np.linalg.norm([w, x, y, z]))
    if not 0.9 < length < 1.1:
        raise ValueError(tr("the quaternion has the length {length:.3g}", length=length))
    rotation = Rotation.from_quat([x, y, z, w]).as_matrix()
    return posed(name.replace("\\", "/"), lenses[camera][0], rotation, np.array(pose[4:]))


# --- files ------------------------------------------------------------------------------------
def _lines(path: Path) -> Iterator[tuple[int, str]]:
    text, _ = read_text(path, accepted=("colmap",))
    for number, line in enumerate(text.split("\n"), 1):
        if not line.lstrip().startswith("#"):
            yield number, line


def _bad(path: Path, error: Exception, wanted: str, line: int) -> InputError:
    finding = Finding(
        "file.damaged", format="COLMAP", reason=f"{str(error)[:120].rstrip('.')} ({wanted})"
    )
    return InputError(finding, file=path, line=line)


class _Binary:
    """Numbers of a file, in their order."""

    def __init__(self, path: Path) -> None:
        self.path, self._data, self._at = path, read_bytes(path), 0

    def take(self, form: str, called: str) -> tuple[Any, ...]:
        size = struct.calcsize(form)
        if self._at + size > len(self._data):
            raise self.bad(tr("the file ends too early"), called)
        self._at += size
        return struct.unpack_from(form, self._data, self._at - size)

    def count(self, called: str) -> int:
        (number,) = self.take("<Q", called)
        if number > len(self._data):
            raise self.bad(tr("the file ends too early"), called)
        return int(number)

    def skip(self, size: int, called: str) -> None:
        self._at += size
        if self._at > len(self._data):
            raise self.bad(tr("the file ends too early"), called)

    def word(self, called: str) -> str:
        end = self._data.find(b"\0", self._at)
        if end < 0:
            raise self.bad(tr("the file ends too early"), called)
        text = self._data[self._at : end].decode("utf-8", "replace")
        self._at = end + 1
        return text

    def bad(self, error: str, called: str) -> InputError:
        finding = Finding("file.damaged", reason=error, format="COLMAP")
        return InputError(finding, file=self.path, field=called)
