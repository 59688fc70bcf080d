"""Stations, contact lines and rock areas from files: those that were exported, and what others
drew in three dimensions under the same names of layers and columns."""

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
from vomstudio.core.progress import Progress, Silent
from vomstudio.core.words import tr
from vomstudio.geometry import transform
from vomstudio.geometry.coordinate_limits import why_no_coordinate, why_not_at
from vomstudio.geometry.lines import ring_area
from vomstudio.geometry.matrices import Point
from vomstudio.io.gate.points import ModelFrame, points_to_world
from vomstudio.io.gate.stated_crs import StatedCrs, table_crs
from vomstudio.io.text.encodings import decode_text
from vomstudio.io.text.file_text import MAX_OBJECTS, refuse_many_lines
from vomstudio.io.text.wkt_columns import parse_wkt
from vomstudio.project.kinds.contact import Contact
from vomstudio.project.kinds.lithology import Lithology
from vomstudio.project.kinds.station import WHATS, Station, What
from vomstudio.project.records import Feature, FeatureType, Model, Record
from vomstudio.project.tables.feature_lists import WKT

AreaInside = Callable[[FloatArray], float | None]
LAYERS = ("stations", "contacts", "lithologies")
_WORDS = (
    "name",
    "number",
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
"""Columns of which something is taken: a layer or table may have any number of others."""
_DEGREES = "EPSG:4326"
_LARGEST_TABLE = 256 << 20
_LOOKED_AT = 2000
"""Rows between two looks at whether the work is still wanted."""


@dataclass(frozen=True)
class ImportedFeatures:
    """features : new, without a place in the document yet; skipped : name and reason of each that
    was left out; warnings : sentences"""

    features: tuple[Feature, ...]
    skipped: tuple[tuple[str, Finding], ...]
    warnings: tuple[Finding, ...]


@dataclass(frozen=True)
class _Row:
    layer: str
    points: FloatArray
    told: Mapping[str, Any]
    crs: str | None

    def word(self, *names: str) -> str:
        """The first of these columns that is there, as text."""
        values = (self.told.get(name) for name in names)
        found = next((v for v in values if v is not None and v == v and str(v).strip()), "")
        return str(found).strip()


def read_listed(
    path: Path,
    model: Model,
    records: Mapping[str, Record],
    crs: str | None,
    area_inside: AreaInside | None = None,
    bounds: FloatArray | None = None,
    progress: Progress | None = None,
) -> ImportedFeatures:
    """The features of a GeoPackage, GeoJSON, shapefile, KML or table (CSV with `wkt`, or stations
    with x, y, z), on a model. crs : that of World; area_inside : of the model's surface, and
    bounds (2, 3) of the model, in its file frame; None where the model is not at hand.

    Raises InputError for a file that cannot be read, or holds none of them.
    """
    if not path.is_file():
        raise InputError(Finding("file.missing"), file=path)
    table = path.suffix.lower() in (".csv", ".txt")
    watched = Silent() if progress is None else progress
    rows: list[_Row] = []
    stated: list[Finding] = []
    for row in _table(path, stated) if table else _layers(path, watched):
        if not len(rows) % _LOOKED_AT:
            watched.step(len(rows))
        rows.append(row)
    if not rows:
        raise InputError(
            Finding("import.no-layers", layers=list(LAYERS)),
            file=path,
        )
    to_file = transform.invert(model.to_world)
    types = {r.name.casefold(): r.id for r in records.values() if isinstance(r, FeatureType)}
    made: list[Feature] = []
    skipped: list[tuple[str, Finding]] = []
    unknown: set[str] = set()
    in_world, findings = _in_world(rows, path, crs)
    watched.stage(tr("Importing features"), len(rows))
    for number, (row, points) in enumerate(zip(rows, in_world, strict=True), 1):
        if not number % _LOOKED_AT:
            watched.step(number)
        name = row.word("name", "number", "id") or tr("row {number}", number=number)
        if (reason := _why_unusable(row, points)) is not None:
            skipped.append((name, reason))
            continue
        placed = transform.apply(to_file, points)
        if (far := _why_not_on(placed, bounds)) is not None:
            skipped.append((name, far))
            continue
        places = tuple((x, y, z) for x, y, z in placed.tolist())
        kind = row.word("kind", "type").casefold()
        if row.layer == "contacts" and kind and kind not in types:
            unknown.add(kind)
        type_id = types.get(kind) or types.get("contact") or next(iter(types.values()), "")
        made.append(_feature(row, model, places, type_id, area_inside, points))
    warnings: list[Finding] = [
        *stated,
        *findings,
        *(Finding("import.type-replaced", type=kind) for kind in sorted(unknown)),
    ]
    if not made:
        name, first = skipped[0]
        raise InputError(Finding("import.nothing-usable", name=name, reason=first), file=path)
    return ImportedFeatures(tuple(made), tuple(skipped), tuple(warnings))


def _feature(
    row: _Row,
    model: Model,
    places: tuple[Point, ...],
    type_id: str,
    area_inside: AreaInside | None,
    points: FloatArray,
) -> Feature:
    name, notes = row.word("name"), row.word("notes", "note", "description")
    if row.layer == "stations":
        said = row.word("kind", "what", "type").casefold()
        what: What = next((known for known, _ in WHATS if known == said), "station")
        return Station(
            new_id("station"),
            name,
            model.id,
            model.content_hash,
            places[:1],
            what,
            row.word("number"),
            row.word("photo"),
            notes,
        )
    if row.layer == "contacts":
        return Contact(
            new_id("contact"),
            name,
            type_id,
            model.id,
            model.content_hash,
            places,
            row.word("set"),
            notes,
        )
    made = Lithology(
        new_id("lithology"),
        name,
        model.id,
        model.content_hash,
        places,
        row.word("lithology", "rock"),
        None,
        notes,
    )
    area = None if area_inside is None else area_inside(np.asarray(places, np.float64))
    if area is None and (told := row.word("area_m2")):
        # The model is not at hand: what was measured on it still holds, as far as it is plausible.
        scale = transform.scale_of(transform.matrix(model.to_world))
        try:
            value = float(told)
        except ValueError:
            value = 0.0
        sound = math.isfinite(value) and value >= 0.5 * ring_area(points) > 0.0
        area = value / scale**2 if sound else None
    return replace(made, area=area)


def _in_world(
    rows: Sequence[_Row], path: Path, crs: str | None
) -> tuple[list[FloatArray], tuple[Finding, ...]]:
    """Return the points of each row in World, all rows with the same CRS at once."""
    places: list[FloatArray] = [row.points for row in rows]
    findings: list[Finding] = []
    for stated in dict.fromkeys(row.crs for row in rows):
        numbers = [i for i, row in enumerate(rows) if row.crs == stated]
        placed = points_to_world(
            np.concatenate([rows[i].points for i in numbers]),
            file=path,
            stated=StatedCrs(stated),
            model=ModelFrame(crs),
        )
        findings += placed.findings
        ends = np.cumsum([len(rows[i].points) for i in numbers])
        for i, points in zip(numbers, np.split(placed.points, ends[:-1]), strict=True):
            places[i] = points
    return places, tuple(dict.fromkeys(findings))


def _why_unusable(row: _Row, points: FloatArray) -> Finding | None:
    """Return why the points of a row cannot be used; None if they can."""
    least = {"stations": 1, "contacts": 2, "lithologies": 3}[row.layer]
    if len(points) < least:
        return Finding("import.too-few-points", count=least)
    if not np.isfinite(row.points[:, 2]).all():
        return Finding("import.no-heights")
    return why_no_coordinate(points.ravel().tolist())


def _why_not_on(points: FloatArray, bounds: FloatArray | None) -> Finding | None:
    """Return a finding if the farthest of points is too far from the model."""
    if bounds is None:
        return None
    low, high = bounds
    off = np.linalg.norm(np.maximum(np.maximum(low - points, points - high), 0.0), axis=1)
    return why_not_at(points[int(np.argmax(off))], bounds)


# --- files -----------------------------------------------------------------------------------
def _layer_word(name: str) -> str:
    """Which kind a layer or file is of; "" for others."""
    plain = name.casefold()
    return next((layer for layer in LAYERS if plain == layer or plain.endswith(f"_{layer}")), "")


def _layers(path: Path, progress: Progress) -> Iterator[_Row]:
    import shapely

    from vomstudio.io.gis.vector_layers import list_layers, read_layers

    def unreadable() -> InputError:
        return _unreadable(path)

    known = [layer.name for layer in list_layers(path, unreadable, progress)]
    named = {name: _layer_word(name) for name in known}
    if len(known) == 1 and not named[known[0]]:
        named = {known[0]: _layer_word(path.stem)}
    wanted = [name for name, layer in named.items() if layer]
    if not wanted:
        return
    for read in read_layers(path, wanted, _WORDS, unreadable, progress, flat=False):
        crs = read.crs or (_DEGREES if path.suffix.lower() == ".kml" else None)
        columns = {name.casefold(): values for name, values in (read.columns or {}).items()}
        try:
            shapes = shapely.from_wkb([] if read.shapes is None else read.shapes)
        except shapely.GEOSException as error:
            raise unreadable() from error
        for i, shape in enumerate(shapes):
            told = {name: values[i] for name, values in columns.items()}
            for points in _points(shape):
                yield _Row(named[read.name], points, told, crs)


def _unreadable(path: Path) -> InputError:
    return InputError(
        Finding("import.not-vectors"),
        file=path,
    )


def _points(shape: Any) -> Iterator[FloatArray]:
    """(n, 3) of each part; NaN for heights that are missing. A ring without its last point."""
    import shapely

    for part in shapely.get_parts(shape):
        if part.geom_type == "GeometryCollection":
            yield from _points(part)
            continue
        ring = part.exterior if part.geom_type == "Polygon" else part
        points = shapely.get_coordinates(ring, include_z=True)
        closed = part.geom_type == "Polygon" and len(points) > 1
        yield points[:-1] if closed else points


def _table(path: Path, findings: list[Finding]) -> Iterator[_Row]:
    """Yield the rows of a table. findings : receives those about its CRS"""
    import shapely

    try:
        lines = decode_text(read_small(path, _LARGEST_TABLE)).removeprefix("\ufeff").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(Finding("table.unreadable", reason=error), file=path) from (error)
    refuse_many_lines(path, len(lines), MAX_OBJECTS)
    comments = [line[1:].strip() for line in lines if line.startswith("#")]
    frame, about_crs = table_crs(path, comments)
    crs = frame.text
    findings += about_crs
    layer = _layer_word(path.stem)
    body = csv.DictReader(line for line in lines if not line.startswith("#"))
    known = {*_WORDS, *"xyz", WKT}
    while True:
        try:
            wanted = [k for k in body.fieldnames or () if str(k).casefold() in known]
            told = next(body)
        except StopIteration:
            return
        except csv.Error as error:
            message = Finding("table.unreadable", reason=error)
            raise InputError(message, file=path, line=body.line_num) from error
        row = {
            k.casefold(): unescape_formula(v) for k in wanted if isinstance(v := told.get(k), str)
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
                place = [float(row[axis]) for axis in "xyz"]
            except ValueError:
                place = [np.nan] * 3
            yield _Row("stations", np.array([place]), row, crs)
