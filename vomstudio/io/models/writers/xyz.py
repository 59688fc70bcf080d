"""Writer of points as text: a header line followed by one row per point."""

from __future__ import annotations

from typing import Any

import numpy as np

from vomstudio.core.arrays import AnyArray
from vomstudio.core.files.atomic import atomic_group
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.models.writer import Writer, WriteRequest
from vomstudio.io.models.writers._common import (
    field_names,
    model_positions,
    prj_sidecar,
    report_unwritten_faces,
    shorten_numbers,
    step_rows,
    write_lines,
)

COLUMN_NAMES = ("x", "y", "z", "r", "g", "b", "nx", "ny", "nz")
# Names that a reader would interpret as a coordinate, a colour or a normal.
RESERVED_NAMES = COLUMN_NAMES + ("red", "green", "blue", "normal_x", "normal_y", "normal_z")


def write(request: WriteRequest) -> list[Finding]:
    """Write points, with floats as the shortest decimals that restore the same value.

    `.csv` files are separated by commas, other files by spaces; the CRS is written to NAME.prj.
    """
    findings: list[Finding] = []
    data = request.data
    report_unwritten_faces(data, findings)
    points = model_positions(data)
    columns: list[tuple[str, AnyArray]] = [(name, points[:, k]) for k, name in enumerate("xyz")]
    if data.colors is not None:
        columns += [(name, data.colors[:, k]) for k, name in enumerate("rgb")]
    for name, label in field_names(data.fields, RESERVED_NAMES, findings).items():
        columns.append((label, data.fields[name]))
    if not isinstance(data, Mesh) and data.normals is not None:
        columns += [(name, data.normals[:, k]) for k, name in enumerate(COLUMN_NAMES[6:])]
    sidecars = prj_sidecar(request, findings)
    separator = "," if request.path.suffix.lower() == ".csv" else " "
    template = separator.join("%r" for _ in columns)
    paths = [request.path, *(path for path, _ in sidecars)]
    with atomic_group(paths, request.force, request.inputs) as temporaries:
        for (_, text), temporary in zip(sidecars, temporaries[1:], strict=True):
            temporary.write_text(text, encoding="utf-8")
        with open(temporaries[0], "w", encoding="utf-8", newline="\n") as file:
            file.write(separator.join(name for name, _ in columns) + "\n")
            for rows in step_rows(len(points), request, tr("Writing points")):
                write_lines(file, [_to_plain_list(values[rows]) for _, values in columns], template)
    return findings


def _to_plain_list(values: AnyArray) -> list[Any]:
    if values.dtype.kind == "f":
        return shorten_numbers(values)
    plain_values: list[Any] = values.astype(
        np.int64 if values.dtype != np.uint64 else object
    ).tolist()
    return plain_values


WRITER = Writer(to_translate("text table of points"), (".xyz", ".csv", ".txt", ".asc"), write)
