"""The program's own camera file `cameras.json`: photos with their cameras and poses.

`cameras.json` contains all data needed to view the model in its photos. `cameras.csv` contains the
camera centres for other programs.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.errors import GeometryError, InputError
from vomstudio.core.files.atomic import atomic_write
from vomstudio.core.files.regular import read_json
from vomstudio.core.files.spreadsheet_cells import escape_formula
from vomstudio.core.findings import Finding
from vomstudio.geometry.cameras import CAMERA_MODELS, Intrinsics, View
from vomstudio.geometry.coordinate_limits import find_invalid_points

FILE_NAME = "cameras.json"
"""Name of the file next to the model."""
_FORMAT = "vomstudio cameras"
_VERSION = 1


@dataclass(frozen=True, eq=False)
class Cameras:
    """Cameras of a model.

    Attributes
    ----------
    views : tuple of View
        Views in the frame of the model minus `origin`.
    photos : Path
        Folder to which the names of the views are relative.
    crs : str or None
        "EPSG:n"; None if the frame of the model is local.
    is_scaled : bool
        Whether the frame is in metres with known north and up directions, even if it has no CRS.
    weak_names : frozenset of str
        Photos that are weakly connected to the others.
    """

    views: tuple[View, ...]
    photos: Path
    origin: tuple[int, int, int] = (0, 0, 0)
    crs: str | None = None
    is_scaled: bool = False
    weak_names: frozenset[str] = frozenset()


def find_photos(cameras: Cameras, path: Path, other_folders: Sequence[Path] = ()) -> Path | None:
    """Return the folder that contains any of the first three photos, or None.

    The folders searched are `other_folders`, the stored folder, and folders next to the cameras
    file `path`.
    """
    stored_folder = cameras.photos
    folders = [
        *other_folders,
        stored_folder if stored_folder.is_absolute() else path.parent / stored_folder,
    ]
    folders += [path.parent / stored_folder.name, path.parent / "photos", path.parent]
    names = [view.name for view in cameras.views[:3]]
    for folder in folders:
        if any((folder / name).is_file() for name in names):
            return folder
    return None


def has_known_scale(model: str | Path) -> bool | None:
    """Return whether the model next to a `cameras.json` has a known scale and north.

    Returns None if the file is missing or cannot be read.
    """
    try:
        return read_cameras(Path(model).with_name(FILE_NAME)).is_scaled
    except InputError:
        return None


def view_to_dict(view: View) -> dict[str, Any]:
    """Return a view as plain data for JSON."""
    lens = view.intrinsics
    return {
        "name": view.name,
        "model": lens.model,
        "width": lens.width,
        "height": lens.height,
        "params": list(lens.params),
        "rotation": np.asarray(view.rotation).tolist(),
        "translation": np.asarray(view.translation).tolist(),
    }


def view_from_dict(row: dict[str, Any]) -> View:
    """Return a view from plain data.

    Raises
    ------
    KeyError, TypeError, ValueError, GeometryError
        If a value is not valid.
    """
    lens = Intrinsics(
        str(row["model"]),
        int(row["width"]),
        int(row["height"]),
        tuple(float(value) for value in row["params"]),
    )
    rotation = np.array(row["rotation"], np.float64)
    translation = np.array(row["translation"], np.float64)
    if rotation.shape != (3, 3) or translation.shape != (3,):
        raise ValueError("a pose is a rotation of 3 x 3 numbers and a translation of 3")
    if not np.isfinite(rotation).all() or find_invalid_points(translation[None]).any():
        raise ValueError(f"the pose of {row['name']} is nowhere on Earth")
    return View(str(row["name"]), lens, rotation, translation)


def write_cameras(path: str | Path, cameras: Cameras, *, force: bool = False) -> None:
    """Write `cameras.json`. Raises TargetError."""
    content = {
        "format": _FORMAT,
        "version": _VERSION,
        "about": "x_camera = rotation @ (x - origin) + translation; camera x right, y down, z "
        "forward; pixels of the photo as stored, (0.5, 0.5) is the centre of the top-left one; "
        "lens models and parameters as in COLMAP",
        "crs": cameras.crs,
        "scaled": cameras.is_scaled,
        "origin": list(cameras.origin),
        "photos": str(cameras.photos),
        "weak": sorted(cameras.weak_names),
        "views": [view_to_dict(view) for view in cameras.views],
    }
    with atomic_write(path, force) as temporary:
        temporary.write_text(json.dumps(content, indent=1, ensure_ascii=False), encoding="utf-8")


def read_cameras(path: str | Path) -> Cameras:
    """Read `cameras.json`. Raises InputError if the file is not valid."""
    path = Path(path)
    try:
        content = read_json(path)
    except OSError as error:
        raise InputError(Finding("file.unreadable", reason=error.strerror), file=path) from error
    except ValueError as error:
        raise InputError(Finding("file.damaged", reason=error, format="JSON"), file=path) from error
    if not isinstance(content, dict) or content.get("format") != _FORMAT:
        raise InputError(Finding("file.other-format", format="cameras.json"), file=path)
    if content.get("version", 0) > _VERSION:
        raise InputError(Finding("file.newer-version"), file=path)
    try:
        x, y, z = (int(value) for value in content["origin"])
        return Cameras(
            tuple(view_from_dict(row) for row in content["views"]),
            Path(content["photos"]),
            (x, y, z),
            content["crs"],
            bool(content.get("scaled", content["crs"] is not None)),
            frozenset(str(name) for name in content.get("weak", ())),
        )
    except (KeyError, TypeError, ValueError, GeometryError) as error:
        raise InputError(
            Finding(
                "file.damaged", format="cameras.json", reason=f"{type(error).__name__}: {error}"
            ),
            file=path,
        ) from error


def write_cameras_csv(
    path: str | Path,
    cameras: Cameras,
    errors: Mapping[str, tuple[float, float]] | None = None,
    *,
    force: bool = False,
) -> None:
    """Write the name, centre, rotation and lens of every photo. Raises TargetError.

    The centre x, y, z is in the frame of the model; the rotation, in row order, is from that frame
    to the camera.

    Parameters
    ----------
    path : str or Path
    cameras : Cameras
    errors : mapping of str to (float, float), optional
        95 % errors of the centre, in the unit of the frame, and of the rotation, in degrees.
    force : bool
    """
    error_unit = "_m" if cameras.is_scaled or cameras.crs is not None else ""
    error_names = [f"position_error95{error_unit}", "rotation_error95_deg"] if errors else []
    with atomic_write(path, force) as temporary, temporary.open("w", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(
            ["name", "x", "y", "z", *(f"r{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3))]
            + ["model", "width", "height", "params", *error_names]
        )
        for view in cameras.views:
            lens = view.intrinsics
            parameters = zip(CAMERA_MODELS[lens.model], lens.params, strict=True)
            writer.writerow(
                [escape_formula(view.name)]
                + [f"{value:.6f}" for value in view.centre + cameras.origin]
                + [f"{value:.12f}" for value in np.ravel(view.rotation)]
                + [lens.model, lens.width, lens.height]
                + [" ".join(f"{name}={value:.10g}" for name, value in parameters)]
                + [f"{value:.4g}" for value in (errors or {}).get(view.name, ())]
            )
