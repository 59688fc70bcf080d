"""Import of stations, contact lines, rock areas, traces and planes from files.

The files are exports of this program, 3-D drawings, or exports of other programs.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import open_regular_file
from vomstudio.core.files.spreadsheet_cells import unescape_formula
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.words import tr
from vomstudio.geology.orientation import Plane
from vomstudio.geometry import transform
from vomstudio.geometry.coordinate_limits import check_coordinates, check_near_model
from vomstudio.io.gate.points import ModelFrame, points_to_world
from vomstudio.io.gate.stated_crs import table_crs
from vomstudio.io.gis.dxf_properties import ENTITY_COLUMNS, select_lines
from vomstudio.io.gis.layer_reading import is_vector_file, symbol_layers
from vomstudio.io.gis.wkb_shapes import shapes_from_wkb
from vomstudio.io.text.tables import TABLE_EXTENSIONS
from vomstudio.io.text.wkt_columns import parse_wkt
from vomstudio.project.imports.attitude_json import attitude_rows, is_attitude_json
from vomstudio.project.imports.compass_xml import compass_xml_rows, is_compass_xml
from vomstudio.project.imports.listed_rows import (
    LAYERS,
    ListedRow,
    ReadingReport,
    read_table_lines,
    stated_plane,
)
from vomstudio.project.imports.program_tables import program_table_rows
from vomstudio.project.imports.row_features import (
    MIN_POINTS,
    AreaFunction,
    FeatureFactory,
    MeasureSurroundings,
    check_measurements,
)
from vomstudio.project.imports.trace_tables import trace_table_rows
from vomstudio.project.kinds.station import merge_stations
from vomstudio.project.records import Feature, FeatureType, Model, Record
from vomstudio.project.tables.feature_lists import WKT_COLUMN

_COLUMNS = (
    "name",
    "number",
    "station",
    "id",
    "kind",
    "what",
    "type",
    "photo",
    "notes",
    "note",
    "description",
    "set",
    "lithology",
    "rock",
    "area_m2",
    "set_name",
    *("dip_direction_deg", "dip_direction", "dip_dir", "dipdir", "ddir", "dip_deg", "dip"),
)
"""Columns that are read; a layer or table may have additional ones."""
_WGS84 = "EPSG:4326"
_LENGTH_LAYERS = ("dimensions", "known_lines", "grids")
"""Layers of this program's exports whose lines are not traces."""
_MARKS = ("planes", "lines", "patches", "discs", "symbols", "control_points")
"""Layers of this program's exports with other shapes, which repeat features or belong to none."""
HEAD_BYTES = 4096
ROWS_PER_PROGRESS_STEP = 2000
"""Number of rows between two progress reports, which also check for cancellation."""


@dataclass(frozen=True)
class ImportedFeatures:
    """Result of an import.

    Attributes
    ----------
    features : tuple of Feature
        Features that are not in the project yet.
    skipped : tuple of tuple of str and Finding
        Name of each skipped feature and the reason.
    warnings : tuple of Finding
    """

    features: tuple[Feature, ...]
    skipped: tuple[tuple[str, Finding], ...]
    warnings: tuple[Finding, ...]


def read_listed_features(
    path: Path,
    model: Model,
    records: Mapping[str, Record],
    crs: str | None,
    area_inside: AreaFunction | None = None,
    bounds: FloatArray | None = None,
    progress: Progress | None = None,
    surroundings: MeasureSurroundings | None = None,
) -> ImportedFeatures:
    """Read features from a file and assign them to a model.

    Parameters
    ----------
    path : Path
        GeoPackage, GeoJSON, shapefile, DXF, KML or table.
    model : Model
    records : mapping
    crs : str or None
        CRS of the World frame.
    area_inside : callable or None
        Function that returns the area of the model surface inside an outline; None if the model is
        not loaded.
    bounds : (2, 3) float64 or None
        Bounds of the model in its file frame, or None if it is not loaded.
    progress : Progress, optional
    surroundings : callable or None
        Function that returns the resolution and the outcrop normal around vertices; None if the
        model is not loaded.

    Raises
    ------
    InputError
        If the file cannot be read or contains no usable features.
    """
    if not path.is_file():
        raise InputError(Finding("file.missing"), file=path)
    progress = SilentProgress() if progress is None else progress
    report = ReadingReport()
    rows: list[ListedRow] = []
    for row in _rows(path, report, progress):
        if not len(rows) % ROWS_PER_PROGRESS_STEP:
            progress.step(len(rows))
        rows.append(row)
    if not rows and not report.skipped:
        raise InputError(
            Finding("import.no-layers", layers=list(LAYERS)),
            file=path,
        )
    to_file = transform.invert(model.to_world)
    types = [record for record in records.values() if isinstance(record, FeatureType)]
    factory = FeatureFactory(model, types, path.name, area_inside, surroundings)
    features: list[Feature] = []
    labels: dict[str, str] = {}
    planes: dict[str, Plane] = {}
    world_points, findings = _points_in_world(rows, path, crs)
    progress.stage(tr("Importing features"), len(rows))
    for index, (row, points) in enumerate(zip(rows, world_points, strict=True), 1):
        if not index % ROWS_PER_PROGRESS_STEP:
            progress.step(index)
        row = replace(row, layer=factory.line_kind(row))
        file_points = transform.apply(to_file, points)
        reason = _invalid_points(row, points) or _distance_finding(file_points, bounds)
        if reason is not None:
            report.skipped.append((row.label(index), reason))
            continue
        vertices = tuple((x, y, z) for x, y, z in file_points.tolist())
        feature = factory.create(row, vertices, points)
        features.append(feature)
        labels[feature.id] = row.label(index)
        if row.plane is not None:
            planes[feature.id] = row.plane
    problems, differences = check_measurements({**records, model.id: model}, features, planes)
    report.skipped += [(labels[id_], problem) for id_, problem in problems.items()]
    features = [feature for feature in features if feature.id not in problems]
    warnings: list[Finding] = [
        *report.findings,
        *findings,
        *(
            Finding("import.type-replaced", type=kind, used=used)
            for kind, used in sorted(factory.replaced_types.items())
        ),
        *differences,
    ]
    if not features:
        name, first_problem = report.skipped[0]
        raise InputError(
            Finding("import.nothing-usable", name=name, reason=first_problem), file=path
        )
    features = merge_stations(features, transform.scale_factor(transform.matrix(model.to_world)))
    return ImportedFeatures(tuple(features), tuple(report.skipped), tuple(warnings))


def _points_in_world(
    rows: Sequence[ListedRow], path: Path, crs: str | None
) -> tuple[list[FloatArray], tuple[Finding, ...]]:
    """Return the points of each row in the World frame, converted in one batch per CRS."""
    points: list[FloatArray] = [row.points for row in rows]
    findings: list[Finding] = []
    for frame in dict.fromkeys(row.frame for row in rows):
        row_indices = [i for i, row in enumerate(rows) if row.frame == frame]
        placed_points = points_to_world(
            np.concatenate([rows[i].points for i in row_indices]),
            file=path,
            stated_crs=frame,
            model=ModelFrame(crs),
        )
        findings += placed_points.findings
        ends = np.cumsum([len(rows[i].points) for i in row_indices])
        for i, part in zip(row_indices, np.split(placed_points.points, ends[:-1]), strict=True):
            points[i] = part
    return points, tuple(dict.fromkeys(findings))


def _invalid_points(row: ListedRow, points: FloatArray) -> Finding | None:
    """Return the reason why the points of a row cannot be used, or None if they are valid."""
    if not np.isfinite(row.points[:, 2]).all():
        return Finding("import.no-heights")
    minimum = MIN_POINTS[row.layer]
    if len(points) < minimum:
        return Finding("import.too-few-points", count=minimum)
    return check_coordinates(points.ravel().tolist())


def _distance_finding(points: FloatArray, bounds: FloatArray | None) -> Finding | None:
    """Return a finding if the farthest point is too far from the model, otherwise None."""
    if bounds is None:
        return None
    low, high = bounds
    distances = np.linalg.norm(np.maximum(np.maximum(low - points, points - high), 0.0), axis=1)
    return check_near_model(points[int(np.argmax(distances))], bounds)


# --- files -----------------------------------------------------------------------------------
def _rows(path: Path, report: ReadingReport, progress: Progress) -> Iterator[ListedRow]:
    """Yield the rows of a file, whose format is recognised by its content.

    Raises InputError if the format is unknown.
    """
    with open_regular_file(path) as file:
        head = file.read(HEAD_BYTES)
    if is_vector_file(head):
        yield from _layers(path, report, progress)
    elif is_compass_xml(head):
        yield from compass_xml_rows(path, report)
    elif is_attitude_json(head):
        yield from attitude_rows(path, report)
    elif path.suffix.lower() not in TABLE_EXTENSIONS:
        raise _reading_error(path)
    else:
        lines = read_table_lines(path)
        for read in (program_table_rows, trace_table_rows):
            rows = read(path, lines, report)
            if rows is not None:
                yield from rows
                return
        yield from _table(path, lines, report.findings)


def _find_layer(name: str, layers: Sequence[str] = LAYERS) -> str:
    """Return the layer in `layers` that the name equals or ends with, or an empty string.

    For example, "site_traces" belongs to the layer "traces".
    """
    folded_name = name.casefold()
    return next(
        (layer for layer in layers if folded_name == layer or folded_name.endswith(f"_{layer}")), ""
    )


def _layers(path: Path, report: ReadingReport, progress: Progress) -> Iterator[ListedRow]:
    from vomstudio.io.gate.drawn_layers import stated_frame
    from vomstudio.io.gis.vector_layers import list_layers, read_layers

    def reading_error() -> InputError:
        return _reading_error(path)

    listed = list_layers(path, reading_error, progress)
    names = [layer.name for layer in listed]
    layer_by_name = {name: _find_layer(name) for name in names}
    if len(names) == 1 and not layer_by_name[names[0]]:
        layer_by_name = {names[0]: _find_layer(path.stem)}
    symbols = symbol_layers(names)
    # The layers of planes in a KML export contain the lines of map symbols.
    is_kml = path.suffix.lower() == ".kml"
    other_layers = (*_LENGTH_LAYERS, *_MARKS) if is_kml else _LENGTH_LAYERS
    layers_to_read = [
        layer.name
        for layer in listed
        if layer_by_name[layer.name]
        or (
            layer.kind is not None
            and layer.name.casefold() not in symbols
            and not _find_layer(layer.name, other_layers)
        )
    ]
    if not layers_to_read:
        return
    is_dxf = path.suffix.lower() == ".dxf"
    columns_to_read = (*_COLUMNS, *ENTITY_COLUMNS, "layer") if is_dxf else _COLUMNS
    for read in read_layers(
        path, layers_to_read, columns_to_read, reading_error, progress, is_flat=False
    ):
        crs = read.crs or (_WGS84 if is_kml else None)
        frame = stated_frame(path, crs)
        shapes, surfaces = shapes_from_wkb(read.shapes)
        columns = dict(read.columns or {})
        if is_dxf:
            is_kept, findings = select_lines(path, columns, surfaces)
            report.findings += findings
            shapes = shapes[is_kept]
            columns = {name: values[is_kept] for name, values in columns.items()}
        columns = {name.casefold(): values for name, values in columns.items()}
        other_shapes_count = 0
        for i, shape in enumerate(shapes):
            values = {name: values[i] for name, values in columns.items()}
            group = str(values.pop("layer", "")) if is_dxf else read.name
            layer = _find_layer(group) if is_dxf else layer_by_name[read.name]
            plane = stated_plane(values)
            for is_line, points in _points(shape):
                if layer or (is_line and not _find_layer(group, _LENGTH_LAYERS)):
                    yield ListedRow(layer or "traces", points, values, frame, (group,), plane)
                elif not _find_layer(group, (*_LENGTH_LAYERS, *_MARKS)):
                    other_shapes_count += 1
        if other_shapes_count:
            report.findings.append(Finding("drawing.other-shapes", count=other_shapes_count))


def _reading_error(path: Path) -> InputError:
    return InputError(
        Finding("import.not-vectors"),
        file=path,
    )


def _points(shape: Any) -> Iterator[tuple[bool, FloatArray]]:
    """Yield, for each part of a shape, whether it is a line, and its points (n, 3).

    Closing points are omitted, and missing heights are NaN.
    """
    import shapely

    for part in shapely.get_parts(shape):
        if hasattr(part, "geoms"):
            yield from _points(part)
            continue
        ring = part.exterior if part.geom_type == "Polygon" else part
        points = shapely.get_coordinates(ring, include_z=True)
        is_closed = part.geom_type == "Polygon" and len(points) > 1
        yield part.geom_type in ("LineString", "LinearRing"), points[:-1] if is_closed else points


def _table(path: Path, lines: list[str], findings: list[Finding]) -> Iterator[ListedRow]:
    """Yield the rows of a table. Findings about its CRS are appended to `findings`.

    Raises InputError if the table cannot be read.
    """
    import shapely

    comments = [line[1:].strip() for line in lines if line.startswith("#")]
    frame, crs_findings = table_crs(path, comments)
    findings += crs_findings
    layer = _find_layer(path.stem)
    body = csv.DictReader(line for line in lines if not line.startswith("#"))
    known_columns = {*_COLUMNS, *"xyz", WKT_COLUMN}
    while True:
        try:
            names = [k for k in body.fieldnames or () if str(k).casefold() in known_columns]
            cells = next(body)
        except StopIteration:
            return
        except csv.Error as error:
            message = Finding("table.unreadable", reason=error)
            raise InputError(message, file=path, line=body.line_num) from error
        row = {
            name.casefold(): unescape_formula(v)
            for name in names
            if isinstance(v := cells.get(name), str)
        }
        if row.get(WKT_COLUMN):
            try:
                (shape,) = parse_wkt([row[WKT_COLUMN]])
            except shapely.GEOSException:
                continue
            kind = {"Point": "stations", "LineString": "contacts", "Polygon": "lithologies"}.get(
                shape.geom_type, layer
            )
            for _, points in _points(shape) if kind else ():
                yield ListedRow(kind, points, row, frame)
        elif {"x", "y", "z"} <= row.keys() and layer in ("", "stations"):
            try:
                position = [float(row[axis]) for axis in "xyz"]
            except ValueError:
                position = [np.nan] * 3
            yield ListedRow("stations", np.array([position]), row, frame)
