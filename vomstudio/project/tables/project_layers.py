"""Features of a project as layers of points, lines and rings with attributes, in World.

They form the content of a GIS or CAD file, whatever its format.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from vomstudio.core.arrays import AnyArray
from vomstudio.io.gis.layers import Layer
from vomstudio.project import catalogue
from vomstudio.project.figures import Figure, Form, Subject
from vomstudio.project.kind import GisLayer, Kind, get_color
from vomstudio.project.kinds import KINDS, get_kind
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.records import Feature, Record
from vomstudio.project.repeated_features import first_picks
from vomstudio.project.tables.grid_layer import LAYER as GRIDS
from vomstudio.project.tables.grid_layer import grid_cells
from vomstudio.project.tables.orientation_table import to_python_value
from vomstudio.project.tables.project_table import ProjectTable

_POINT_LAYERS = {"plane": "planes", "line": "lines"}
"""Layers of points, one per type of orientation."""


def subjects_by_kind(
    records: Mapping[str, Record], features: Sequence[Feature], measurements: Measurements
) -> dict[Kind, list[Subject]]:
    """Return the measured features by kind.

    Parameters
    ----------
    records : mapping of str to Record
    features : sequence of Feature
    measurements : Measurements

    Returns
    -------
    dict of Kind to list of Subject
    """
    measurements_by_id = measurements.of(records, [feature.id for feature in features])
    subjects: dict[Kind, list[Subject]] = {}
    for feature in features:
        subjects.setdefault(get_kind(feature), []).append(
            Subject(feature, measurements_by_id[feature.id], records)
        )
    return subjects


def project_layers(
    records: Mapping[str, Record], table: ProjectTable, measurements: Measurements
) -> list[Layer]:
    """Return the layers of the kinds, excluding repeats, and the cells of grids.

    The point layers of the orientations of a kind precede the layer of the kind. Empty layers are
    omitted, except `planes` and `traces`. A compass reading without a position is included only in
    the table.
    """
    features = first_picks(
        (record for record in records.values() if isinstance(record, Feature)), records
    )
    subjects = subjects_by_kind(records, features, measurements)
    layers: dict[str, Layer] = {}
    for kind in KINDS:
        for nature in kind.orientations:
            if (name := _POINT_LAYERS[nature]) not in layers:
                layers[name] = _points(name, nature, table)
        if kind.layer is not None:
            layers[kind.layer.name] = _layer(kind.layer, subjects.get(kind, []))
    shapes, columns, colors = grid_cells(records)
    layers[GRIDS] = Layer(GRIDS, "ring", shapes, columns, by="found", colors=colors)
    return [
        layer
        for layer in layers.values()
        if layer.shapes or layer.main or layer.name == _POINT_LAYERS["plane"]
    ]


def _points(layer_name: str, geometry: str, table: ProjectTable) -> Layer:
    table = table.drop_repeats()
    rows = [row for row in table.rows if row["x"] is not None and row["element"] == geometry]
    positions = [np.array([[row[axis] for axis in "xyz"]], np.float64) for row in rows]
    # The key of the layer is `fid`, so `id` remains the ID of the record.
    columns = {
        figure.name: _to_array([row[figure.name] for row in rows], figure.form)
        for figure in catalogue.ORIENTATION
    }
    for name in table.extra_columns:
        columns[name] = _to_array([row.get(name) or "" for row in rows], "text")
    return Layer(layer_name, "point", positions, columns)


def _layer(layer: GisLayer, subjects: Sequence[Subject]) -> Layer:
    drawn_shapes = [
        (subject, shape) for subject in subjects if (shape := layer.shape(subject)) is not None
    ]
    columns = {}
    for figure in layer.figures:
        values = [to_python_value(figure.value(subject)) for subject, _ in drawn_shapes]
        if layer.sparse and figure.form != "text" and all(value is None for value in values):
            continue
        columns[figure.name] = _column(values, figure)
    shapes = [shape for _, shape in drawn_shapes]
    colors = [get_color(s.feature, s.records) for s, _ in drawn_shapes]
    return Layer(layer.name, layer.geometry, shapes, columns, layer.main, layer.by, colors)


def _column(values: list[Any], figure: Figure) -> AnyArray:
    """Convert values to an array, with empty text for missing text and counts as integers."""
    if figure.form == "text":
        return _to_array([value or "" for value in values], "text")
    if figure.form == "count":
        return np.array(values, dtype=np.int32)
    return _to_array(values, figure.form)


def _to_array(values: list[Any], kind: Form) -> AnyArray:
    if kind == "text":
        return np.array(values, dtype=object)
    if kind == "flag":
        return np.array([bool(value) for value in values], dtype=bool)
    return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
