"""Import of stations, contact lines and lithologies from files.

The files are exports of this program or 3-D drawings with the same layer and column names.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import read_small
from vomstudio.core.files.spreadsheet_cells import unescape_formula
from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.words import tr
from vomstudio.geometry import transform
from vomstudio.geometry.coordinate_limits import check_coordinates, check_near_model
from vomstudio.geometry.lines import ring_area
from vomstudio.geometry.matrices import Point
from vomstudio.io.gate.points import ModelFrame, points_to_world
from vomstudio.io.gate.stated_crs import StatedCrs, table_crs
from vomstudio.io.text.encodings import decode_text
from vomstudio.io.text.file_text import MAX_OBJECTS, refuse_many_lines
from vomstudio.io.text.wkt_columns import parse_wkt
from vomstudio.project.kinds.contact import Contact
from vomstudio.project.kinds.lithology import Lithology
from vomstudio.project.kinds.station import (
    STATION_KINDS,
    Station,
    StationKind,
    merge_stations,
)
from vomstudio.project.records import Feature, FeatureType, Model, Record
from vomstudio.project.tables.feature_lists import WKT

AreaInside = Callable[[FloatArray], float | None]
LAYERS = ("stations", "contacts", "lithologies")
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
)
"""Columns that are read; a layer or table may have additional ones."""
_WGS84 = "EPSG:4326"
MAX_TABLE_BYTES = 256 << 20
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


@dataclass(frozen=True)
class _Row:
    layer: str
    points: FloatArray
    values: Mapping[str, Any]
    crs: str | None

    def text(self, *names: str) -> str:
        """Return the text of the first of these columns that is not empty, or ""."""
        values = (self.values.get(name) for name in names)
        value = next(
            (
                value
                for value in values
                if value is not None and value == value and str(value).strip()
            ),
            "",
        )
        return str(value).strip()


def read_listed_features(
    path: Path,
    model: Model,
    records: Mapping[str, Record],
    crs: str | None,
    area_inside: AreaInside | None = None,
    bounds: FloatArray | None = None,
    progress: Progress | None = None,
) -> ImportedFeatures:
    """Read features from a file and assign them to a model.

    Parameters
    ----------
    path : Path
        GeoPackage, GeoJSON, shapefile, KML or table (CSV with a `wkt` column, or stations with x,
        y, z).
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

    Raises
    ------
    InputError
        If the file cannot be read or contains no features of these kinds.
    """
    if not path.is_file():
        raise InputError(Finding("file.missing"), file=path)
    is_table = path.suffix.lower() in (".csv", ".txt")
    report = SilentProgress() if progress is None else progress
    rows: list[_Row] = []
    table_findings: list[Finding] = []
    for row in _table(path, table_findings) if is_table else _layers(path, report):
        if not len(rows) % ROWS_PER_PROGRESS_STEP:
            report.step(len(rows))
        rows.append(row)
    if not rows:
        raise InputError(
            Finding("import.no-layers", layers=list(LAYERS)),
            file=path,
        )
    to_file = transform.invert(model.to_world)
    types = {
        record.name.casefold(): record.id
        for record in records.values()
        if isinstance(record, FeatureType)
    }
    features: list[Feature] = []
    skipped_rows: list[tuple[str, Finding]] = []
    unknown_names: set[str] = set()
    world_points, findings = _points_in_world(rows, path, crs)
    report.stage(tr("Importing features"), len(rows))
    for index, (row, points) in enumerate(zip(rows, world_points, strict=True), 1):
        if not index % ROWS_PER_PROGRESS_STEP:
            report.step(index)
        name = row.text("name", "number", "id") or tr("row {number}", number=index)
        if (reason := _invalid_points(row, points)) is not None:
            skipped_rows.append((name, reason))
            continue
        file_points = transform.apply(to_file, points)
        if (too_far := _distance_finding(file_points, bounds)) is not None:
            skipped_rows.append((name, too_far))
            continue
        vertices = tuple((x, y, z) for x, y, z in file_points.tolist())
        kind = row.text("kind", "type").casefold()
        if row.layer == "contacts" and kind and kind not in types:
            unknown_names.add(kind)
        type_id = types.get(kind) or types.get("contact") or next(iter(types.values()), "")
        features.append(_feature(row, model, vertices, type_id, area_inside, points))
    warnings: list[Finding] = [
        *table_findings,
        *findings,
        *(Finding("import.type-replaced", type=kind) for kind in sorted(unknown_names)),
    ]
    if not features:
        name, first_problem = skipped_rows[0]
        raise InputError(
            Finding("import.nothing-usable", name=name, reason=first_problem), file=path
        )
    features = merge_stations(features, transform.scale_factor(transform.matrix(model.to_world)))
    return ImportedFeatures(tuple(features), tuple(skipped_rows), tuple(warnings))


def _feature(
    row: _Row,
    model: Model,
    vertices: tuple[Point, ...],
    type_id: str,
    area_inside: AreaInside | None,
    points: FloatArray,
) -> Feature:
    name, notes = row.text("name"), row.text("notes", "note", "description")
    if row.layer == "stations":
        kind = row.text("kind", "what", "type").casefold()
        station_kind: StationKind = next(
            (choice for choice, _ in STATION_KINDS if choice == kind), "station"
        )
        return Station(
            new_id("station"),
            name,
            model.id,
            model.content_hash,
            vertices[:1],
            station_kind,
            row.text("number", "station"),
            row.text("photo"),
            notes,
        )
    if row.layer == "contacts":
        return Contact(
            new_id("contact"),
            name,
            type_id,
            model.id,
            model.content_hash,
            vertices,
            row.text("set"),
            notes,
        )
    lithology = Lithology(
        new_id("lithology"),
        name,
        model.id,
        model.content_hash,
        vertices,
        row.text("lithology", "rock"),
        None,
        notes,
    )
    area = None if area_inside is None else area_inside(np.asarray(vertices, np.float64))
    if area is None and (area_text := row.text("area_m2")):
        # The model is not loaded, so use the stored area if it is plausible.
        scale = transform.scale_factor(transform.matrix(model.to_world))
        try:
            # Balloons of KML have the unit behind the value.
            value = float(area_text.split()[0])
        except ValueError:
            value = 0.0
        is_plausible = math.isfinite(value) and value >= 0.5 * ring_area(points) > 0.0
        area = value / scale**2 if is_plausible else None
    return replace(lithology, area=area)


def _points_in_world(
    rows: Sequence[_Row], path: Path, crs: str | None
) -> tuple[list[FloatArray], tuple[Finding, ...]]:
    """Return the points of each row in the World frame, converting equal CRSs together."""
    points: list[FloatArray] = [row.points for row in rows]
    findings: list[Finding] = []
    for crs_text in dict.fromkeys(row.crs for row in rows):
        row_indices = [i for i, row in enumerate(rows) if row.crs == crs_text]
        placed_points = points_to_world(
            np.concatenate([rows[i].points for i in row_indices]),
            file=path,
            stated_crs=StatedCrs(crs_text),
            model=ModelFrame(crs),
        )
        findings += placed_points.findings
        ends = np.cumsum([len(rows[i].points) for i in row_indices])
        for i, part in zip(row_indices, np.split(placed_points.points, ends[:-1]), strict=True):
            points[i] = part
    return points, tuple(dict.fromkeys(findings))


def _invalid_points(row: _Row, points: FloatArray) -> Finding | None:
    """Return the reason why the points of a row cannot be used, or None if they are valid."""
    minimum = {"stations": 1, "contacts": 2, "lithologies": 3}[row.layer]
    if len(points) < minimum:
        return Finding("import.too-few-points", count=minimum)
    if not np.isfinite(row.points[:, 2]).all():
        return Finding("import.no-heights")
    return check_coordinates(points.ravel().tolist())


def _distance_finding(points: FloatArray, bounds: FloatArray | None) -> Finding | None:
    """Return a finding if the farthest point is too far from the model."""
    if bounds is None:
        return None
    low, high = bounds
    distances = np.linalg.norm(np.maximum(np.maximum(low - points, points - high), 0.0), axis=1)
    return check_near_model(points[int(np.argmax(distances))], bounds)


# --- files -----------------------------------------------------------------------------------
def _layer_of(name: str) -> str:
    """Return the kind of a layer or file, or "" for other layers."""
    folded_name = name.casefold()
    return next(
        (layer for layer in LAYERS if folded_name == layer or folded_name.endswith(f"_{layer}")), ""
    )


def _layers(path: Path, progress: Progress) -> Iterator[_Row]:
    import shapely

    from vomstudio.io.gis.vector_layers import list_layers, read_layers

    def reading_error() -> InputError:
        return _reading_error(path)

    names = [layer.name for layer in list_layers(path, reading_error, progress)]
    layer_by_name = {name: _layer_of(name) for name in names}
    if len(names) == 1 and not layer_by_name[names[0]]:
        layer_by_name = {names[0]: _layer_of(path.stem)}
    read_names = [name for name, layer in layer_by_name.items() if layer]
    if not read_names:
        return
    for read in read_layers(path, read_names, _COLUMNS, reading_error, progress, is_flat=False):
        crs = read.crs or (_WGS84 if path.suffix.lower() == ".kml" else None)
        columns = {name.casefold(): values for name, values in (read.columns or {}).items()}
        try:
            shapes = shapely.from_wkb([] if read.shapes is None else read.shapes)
        except shapely.GEOSException as error:
            raise reading_error() from error
        for i, shape in enumerate(shapes):
            values = {name: values[i] for name, values in columns.items()}
            for points in _points(shape):
                yield _Row(layer_by_name[read.name], points, values, crs)


def _reading_error(path: Path) -> InputError:
    return InputError(
        Finding("import.not-vectors"),
        file=path,
    )


def _points(shape: Any) -> Iterator[FloatArray]:
    """Yield the points (n, 3) of each part without closing points; missing heights are NaN."""
    import shapely

    for part in shapely.get_parts(shape):
        if part.geom_type == "GeometryCollection":
            yield from _points(part)
            continue
        ring = part.exterior if part.geom_type == "Polygon" else part
        points = shapely.get_coordinates(ring, include_z=True)
        is_closed = part.geom_type == "Polygon" and len(points) > 1
        yield points[:-1] if is_closed else points


def _table(path: Path, findings: list[Finding]) -> Iterator[_Row]:
    """Yield the rows of a table. Findings about its CRS are appended to `findings`."""
    import shapely

    try:
        lines = decode_text(read_small(path, MAX_TABLE_BYTES)).removeprefix("\ufeff").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(Finding("table.unreadable", reason=error), file=path) from (error)
    refuse_many_lines(path, len(lines), MAX_OBJECTS)
    comments = [line[1:].strip() for line in lines if line.startswith("#")]
    frame, crs_findings = table_crs(path, comments)
    crs = frame.text
    findings += crs_findings
    layer = _layer_of(path.stem)
    body = csv.DictReader(line for line in lines if not line.startswith("#"))
    known_columns = {*_COLUMNS, *"xyz", WKT}
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
        if row.get(WKT):
            try:
                (shape,) = parse_wkt([row[WKT]])
            except shapely.GEOSException:
                continue
            kind = {"Point": "stations", "LineString": "contacts", "Polygon": "lithologies"}.get(
                shape.geom_type, layer
            )
            for points in _points(shape) if kind else ():
                yield _Row(kind, points, row, crs)
        elif {"x", "y", "z"} <= row.keys() and layer in ("", "stations"):
            try:
                position = [float(row[axis]) for axis in "xyz"]
            except ValueError:
                position = [np.nan] * 3
            yield _Row("stations", np.array([position]), row, crs)
