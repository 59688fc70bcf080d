"""Tables of features without an orientation (stations, contact lines, lithologies).

There is one table per kind, in which the geometry is stored as well-known text.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.files.spreadsheet_cells import comment_line
from vomstudio.core.version import __version__
from vomstudio.project.figures import Subject
from vomstudio.project.kind import Kind
from vomstudio.project.kinds import KINDS, get_kind
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.records import Feature, Record
from vomstudio.project.tables.orientation_table import csv_cell
from vomstudio.project.tables.project_layers import subjects_by_kind
from vomstudio.project.tables.project_table import ProjectTable

_WKT_TYPES = {"point": "POINT Z", "line": "LINESTRING Z", "ring": "POLYGON Z"}
WKT_COLUMN = "wkt"


def listed_tables(
    records: Mapping[str, Record], table: ProjectTable, measurements: Measurements
) -> dict[str, str]:
    """Return the CSV text of each kind of listed features in the project, by layer name.

    The coordinates are in the World frame.
    """
    features = [
        record
        for record in records.values()
        if isinstance(record, Feature) and get_kind(record).listed
    ]
    subjects = subjects_by_kind(records, features, measurements)
    return {
        kind.layer.name: _text(kind, subjects[kind], table)
        for kind in KINDS
        if kind in subjects and kind.layer is not None
    }


def _text(kind: Kind, subjects: list[Subject], table: ProjectTable) -> str:
    assert kind.layer is not None
    names = {figure.name for figure in kind.figures}
    figures = [
        *kind.figures,
        *(figure for figure in kind.layer.figures if figure.name not in names),
    ]
    header = [
        f"VOM Studio {__version__}, {kind.layer.name}",
        f"CRS: {table.crs or 'none declared, coordinates as given'}",
        f"units: {table.axes.description}",
    ]
    lines = [comment_line(line).rstrip("\n") for line in header]
    lines.append(",".join([*(figure.name for figure in figures), WKT_COLUMN]))
    for subject in subjects:
        shape = kind.layer.shape(subject)
        cells = [csv_cell(figure.value(subject)) for figure in figures]
        lines.append(",".join([*cells, "" if shape is None else _wkt(kind.layer.geometry, shape)]))
    return "\n".join(lines) + "\n"


def _wkt(geometry_type: str, points: FloatArray) -> str:
    ring = np.vstack([points, points[:1]]) if geometry_type == "ring" else points
    coordinates = ", ".join(" ".join(f"{value:.12g}" for value in point) for point in ring.tolist())
    if geometry_type == "ring":
        coordinates = f"({coordinates})"
    return f'"{_WKT_TYPES[geometry_type]} ({coordinates})"'
