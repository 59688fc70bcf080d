"""Cameras of RealityCapture and RealityScan: "Internal/External camera parameters".

Positions are in the output coordinate system of the project, and angles in degrees. The rotation
from the camera (x right, y up, z backward) to the World frame rotates about z by minus the heading,
then about x by the pitch, then about y by the roll. The focal length is the 35 mm equivalent in
millimetres; the principal point is in units of the longer side of the photo. The table does not
state photo sizes. The convention is that of nerfstudio's reader `realitycapture_utils`.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.io.photos.own_cameras.fitted_lens import MAX_ERROR_PX, fit_lens
from vomstudio.io.photos.own_cameras.frames import Candidate
from vomstudio.io.photos.own_cameras.photo_sizes import (
    Size,
    placeholder_lens,
    read_sizes,
    unknown_size_findings,
)
from vomstudio.io.photos.own_cameras.result import unknown_lens_finding, view_from_centre
from vomstudio.io.text.named_columns import PHOTO_NAMES, WORLD, NamedTable

_ANGLE_COLUMNS = (("heading", "yaw"), ("pitch",), ("roll",))
_LENS_COLUMNS = ("f", "px", "py", "k1", "k2", "k3", "k4", "t1", "t2")
_FILM_WIDTH_MM = 36.0
_AXES = np.diag([1.0, -1.0, -1.0])
"""Rotation from a camera frame with y up, z backward to one with y down, z forward."""


def is_reality_capture(table: NamedTable) -> bool:
    """Return whether the columns of a table are those of RealityCapture."""
    return table.has(("f",)) and all(table.has(column) for column in _ANGLE_COLUMNS)


def read_reality_capture(path: Path, table: NamedTable) -> list[Candidate]:
    """Read the cameras.

    Parameters
    ----------
    path : Path
        Path of the file; the photos are searched for in folders near it.
    table : NamedTable
        Content of the file.

    Raises
    ------
    InputError
        If the table is not valid; states line and column.
    """
    names = [name.replace("\\", "/") for name in table.words(PHOTO_NAMES, "photo")]
    table.require_unique(names)
    positions = table.columns(WORLD, ("x", "y", "z"))
    table.require_coordinates(positions)
    angles = table.columns(_ANGLE_COLUMNS, ("heading", "pitch", "roll"))
    columns = [name for name in _LENS_COLUMNS if table.has((name,))]
    values = table.columns([(name,) for name in columns], columns)
    sizes = read_sizes(path, names)
    views, n_inexact = list[View](), 0
    for row, name in enumerate(names):
        value_by_column = dict(zip(columns, values[row].tolist(), strict=True))
        try:
            lens, error_px = _lens(value_by_column, sizes.get(name))
            views.append(view_from_centre(name, lens, _rotation(angles[row]), positions[row]))
        except (ValueError, GeometryError) as error:
            finding = Finding("cameras.invalid-pose", reason=str(error).rstrip("."))
            raise table.cell_error(row, finding, "f") from error
        n_inexact += error_px > MAX_ERROR_PX
    warnings = unknown_size_findings(sizes, names)
    if n_inexact:
        warnings.append(unknown_lens_finding("RealityCapture", n_inexact))
    return [Candidate(tr("the frame of the file"), views, tuple(warnings))]


def _rotation(angles_deg: FloatArray) -> FloatArray:
    """Return the rotation from the World frame to the camera."""
    from scipy.spatial.transform import Rotation

    heading, pitch, roll = angles_deg
    to_world = Rotation.from_euler("ZXY", [-heading, pitch, roll], degrees=True).as_matrix()
    return np.asarray((to_world @ _AXES).T, np.float64)


def _lens(value_by_column: dict[str, float], size: Size | None) -> tuple[Intrinsics, float]:
    """Return the lens and its error in pixels."""
    if size is None:
        return placeholder_lens(), 0.0
    width, height = size
    long_side = float(max(size))
    focal = value_by_column["f"] / _FILM_WIDTH_MM * long_side
    if not (focal > 0 and np.isfinite(list(value_by_column.values())).all()):
        raise ValueError(tr("the focal length is missing or not positive"))
    cx = width / 2.0 + value_by_column.get("px", 0.0) * long_side
    cy = height / 2.0 + value_by_column.get("py", 0.0) * long_side
    k1, k2, k3, k4, p1, p2 = (
        value_by_column.get(key, 0.0) for key in ("k1", "k2", "k3", "k4", "t1", "t2")
    )
    params = (focal, focal, cx, cy, k1, k2, p1, p2, k3, 0.0, 0.0, 0.0)
    lens = Intrinsics("FULL_OPENCV", width, height, params)
    if not k4:
        return lens, 0.0

    def project(ideal_points: FloatArray) -> FloatArray:
        r2 = (ideal_points**2).sum(axis=1)[:, None]
        x, y = ideal_points.T
        tangential_shift = _tangential_shift(x, y, p1, p2)
        radial_factor = 1 + r2 * (k1 + r2 * (k2 + r2 * (k3 + r2 * k4)))
        return np.asarray(
            focal * (ideal_points * radial_factor + tangential_shift) + (cx, cy), np.float64
        )

    return fit_lens(width, height, focal, project)


def _tangential_shift(x: FloatArray, y: FloatArray, p1: float, p2: float) -> FloatArray:
    r2 = x * x + y * y
    return np.column_stack(
        [2 * p1 * x * y + p2 * (r2 + 2 * x * x), p1 * (r2 + 2 * y * y) + 2 * p2 * x * y]
    )
