"""Tables of camera centres in the frame of a model.

These are `cameras.csv`, the reference and angle tables of Metashape, and similar tables of other
programs. If a table contains both given and estimated centres, the estimated ones are those of the
model. The angles in such tables are not used because programs define them differently; the
rotations in `cameras.csv` are used.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError, InputError
from vomstudio.core.findings import Finding
from vomstudio.geometry.cameras import CAMERA_MODELS, Intrinsics, View
from vomstudio.io.photos.own_cameras.result import (
    ModelCameras,
    cameras_from_views,
    view_from_centre,
)
from vomstudio.io.text.named_columns import PHOTO_NAMES, WORLD, NamedTable

_ESTIMATED_COLUMNS = (
    ("x est", "x estimated", "x east est", "x longitude est", "east est"),
    ("y est", "y estimated", "y north est", "y latitude est", "north est"),
    ("z est", "z estimated", "z altitude est", "altitude est"),
)
_ROTATION_COLUMNS = tuple((f"r{row}{column}",) for row in "123" for column in "123")


def open_table(path: Path) -> NamedTable:
    """Read a table of cameras.

    Raises
    ------
    InputError
        If the table is not valid; states the line.
    """
    return NamedTable(path, ("photo", "x", "y", "z"))


def read_centres(path: Path, table: NamedTable) -> ModelCameras:
    """Return the camera centres of a table, with the views if it is a `cameras.csv`.

    Parameters
    ----------
    path : Path
    table : NamedTable
        Content of the file.

    Raises
    ------
    InputError
        If the table is not valid or its positions are in degrees; states line and column.
    """
    names = [name.replace("\\", "/") for name in table.words(PHOTO_NAMES, "photo")]
    table.require_unique(names)
    is_estimated = all(table.has(column) for column in _ESTIMATED_COLUMNS)
    has_degrees = table.has(("lon", "longitude", "x longitude")) and not is_estimated
    columns = _ESTIMATED_COLUMNS if is_estimated else WORLD
    positions = table.columns(columns, ("x", "y", "z"))
    if has_degrees or (is_estimated and _are_degrees(positions)):
        raise InputError(
            Finding("cameras.centres-in-degrees"),
            file=path,
            line=table.table.header_line,
            field=table.table.label(0),
        )
    table.require_coordinates(positions)
    has_rotations = all(
        table.has(column) for column in (*_ROTATION_COLUMNS, ("model",), ("params",), ("width",))
    )
    if has_rotations:
        return cameras_from_views(path, _views(table, names, positions))
    return ModelCameras(path, {}, dict(zip(names, positions, strict=True)))


def _views(table: NamedTable, names: list[str], positions: FloatArray) -> list[View]:
    rotations = table.columns(_ROTATION_COLUMNS, [name for (name,) in _ROTATION_COLUMNS]).reshape(
        -1, 3, 3
    )
    sizes = table.columns((("width",), ("height",)), ("width", "height")).astype(int)
    models, params = table.words(("model",), "model"), table.words(("params",), "params")
    views = []
    for row, name in enumerate(names):
        try:
            stated_params = dict(cell.split("=", 1) for cell in params[row].split())
            param_names = CAMERA_MODELS.get(models[row], ())
            lens = Intrinsics(
                models[row],
                int(sizes[row, 0]),
                int(sizes[row, 1]),
                tuple(float(stated_params[key]) for key in param_names),
            )
            views.append(view_from_centre(name, lens, rotations[row], positions[row]))
        except (KeyError, ValueError, GeometryError) as error:
            finding = Finding("cameras.invalid-pose", reason=str(error).rstrip("."))
            raise table.cell_error(row, finding, "params") from error
    return views


def _are_degrees(positions: FloatArray) -> bool:
    extent = np.ptp(positions, axis=0)
    is_in_range = (np.abs(positions[:, 0]) <= 180).all() and (np.abs(positions[:, 1]) <= 90).all()
    return bool(is_in_range and max(extent[:2]) < 0.1 and extent[2] > 100 * max(extent[:2]))
