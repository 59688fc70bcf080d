"""Lines and polygons that were drawn in a GIS or CAD program, in metres.

GeoPackage, GeoJSON, shapefiles, DXF and whatever else GDAL reads as vectors. A layer in degrees is
refused: it has no true lengths; GeoJSON that names no reference system is in degrees (RFC 7946).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.core.findings import Finding, Message
from vomstudio.errors import InputError, UsageError
from vomstudio.files.regular import is_folder, is_there
from vomstudio.geometry.outlines.self_crossing import taken_apart
from vomstudio.io.gate.frame_options import AS_STATED, FrameOptions
from vomstudio.io.gate.points import ModelFrame, WorldPoints, points_to_world
from vomstudio.io.gate.stated_crs import StatedCrs, crs_of_table
from vomstudio.io.gis.axis_units import MOST_DEGREES, suggested_zone
from vomstudio.io.gis.dxf_facts import OF_ENTITIES, dxf_facts, features_of, why_unreadable
from vomstudio.io.gis.layer_reading import names_no_crs, symbol_layers
from vomstudio.io.gis.vector_layers import VectorLayer, list_layers, read_layers
from vomstudio.io.gis.wkb_shapes import shapes_from_wkb, surfaces_left_out
from vomstudio.progress import Progress
from vomstudio.words import tr, tr_n

Shapes = npt.NDArray[np.object_]

_LINES, _AREAS = ("LineString", "LinearRing"), ("Polygon",)
OUTLINE_LAYERS = ("patches", "lithologies")
"""Layers of closed lines in drawings of this program, behind the type of the feature."""


@dataclass(frozen=True, eq=False)
class DrawnLayer:
    """shapes : (n,) shapely lines or polygons in metres, single parts; feature : (n,) number of the
    feature that each is of, from 1; columns : (n,) attributes of each that were asked for, by their
    names; crs : "EPSG:n" or WKT, None where the file names none; fields : names of all there
    are"""

    path: Path
    shapes: Shapes
    feature: npt.NDArray[np.int64]
    columns: Mapping[str, npt.NDArray[Any]]
    crs: str | None
    warnings: tuple[Message, ...]
    fields: tuple[str, ...] = ()

    def column(self, name: str, field: str) -> list[str]:
        """(n,) the words of an attribute, "" where it is empty. Raises UsageError."""
        found = next((c for c in self.columns if c.casefold() == name.casefold()), None)
        if found is None:
            raise UsageError(
                tr(
                    "There is no attribute '{name}'. The layer has: {columns}.",
                    name=name, columns=", ".join(self.fields or self.columns) or "-",
                ),
                file=self.path, field=field,
            )  # fmt: skip
        return ["" if _is_empty(v) else str(v).strip() for v in self.columns[found]]


@dataclass(frozen=True, eq=False)
class RawLayer:
    """Features of a layer as they were read, with their heights, before any is left out.

    Parameters
    ----------
    path : Path
        The file.
    shapes : (n,) array of shapely geometries or None
        Coordinates in metres; those of a file without heights have none.
    feature : (n,) array of int
        Row of each in the file.
    columns, crs, fields
        As in `DrawnLayer`.
    warnings, left_out : tuple
        What reading reported of coordinates, and of entities of a drawing.
    field : str or None
        Argument of the Python interface, if there is no file.
    """

    path: Path
    shapes: Shapes
    feature: npt.NDArray[np.int64]
    columns: Mapping[str, npt.NDArray[Any]]
    crs: str | None
    warnings: tuple[Message, ...] = ()
    left_out: tuple[Message, ...] = ()
    fields: tuple[str, ...] = ()
    field: str | None = None

    def only(self, rows: npt.NDArray[np.bool_]) -> RawLayer:
        """Return the layer with these features (n,) only."""
        return replace(
            self,
            shapes=self.shapes[rows],
            feature=self.feature[rows],
            columns={name: values[rows] for name, values in self.columns.items()},
        )

    def are_outlines(self) -> npt.NDArray[np.bool_]:
        """Return which features (n,) lie on a layer of outlines in a drawing of this program."""
        names = next((v for n, v in self.columns.items() if n.casefold() == "layer"), ())
        found = np.zeros(len(self.shapes), np.bool_)
        for row, name in enumerate(names):
            found[row] = str(name).casefold().rpartition("_")[2] in OUTLINE_LAYERS
        return found


def read_raw_lines(
    path: str | Path,
    layer: str | None = None,
    columns: Iterable[str] = (),
    progress: Progress | None = None,
    options: FrameOptions = AS_STATED,
    model: ModelFrame | None = None,
) -> RawLayer:
    """Read all features of a layer of lines in World, with heights.

    GeoJSON without a ``crs`` is in degrees by its standard and is converted to a metric CRS.

    Parameters
    ----------
    path : str or Path
    layer : str, optional
        Name of the layer, if there are several.
    columns : iterable of str
        Names of the attributes to read.
    progress : Progress, optional
    options : FrameOptions
        What the caller knows about the frame.
    model : ModelFrame, optional
        Frame of the data that the drawing belongs to, to which it is converted.

    Raises
    ------
    InputError
        For a file that is not a drawing, and as `points_to_world`.
    UsageError
        If the layer must be named.
    """
    return _read(Path(path), layer, _LINES, columns, progress, options, model)


def read_raw_areas(
    path: str | Path,
    layer: str | None = None,
    progress: Progress | None = None,
    options: FrameOptions = AS_STATED,
    model: ModelFrame | None = None,
) -> RawLayer:
    """Read all features of a layer of polygons in World, as `read_raw_lines`."""
    return _read(Path(path), layer, _AREAS, (), progress, options, model)


def raw_shapes(
    shapes: Shapes, name: str, crs: str | None = None, options: FrameOptions = AS_STATED
) -> RawLayer:
    """Return shapes (n,) of the Python interface in World, as if they had been read.

    Without a CRS they are in World, in metres.

    Raises
    ------
    InputError, UsageError
        As `points_to_world`.
    """
    path = Path(name)
    rows = np.arange(len(shapes), dtype=np.int64)
    if crs is None and not options.is_given:
        return RawLayer(path, shapes, rows, {}, None, field=name)
    shapes, placed = _in_world(path, shapes, crs, options, None)
    return RawLayer(path, shapes, rows, {}, placed.crs, placed.findings, field=name)


def read_lines(
    path: str | Path,
    layer: str | None = None,
    columns: Iterable[str] = (),
    progress: Progress | None = None,
) -> DrawnLayer:
    """The lines of a file, with those of their attributes that are called so, in any letters.
    Raises InputError for files that are no drawing, hold no line or are in degrees, UsageError
    where the layer must be named, and Cancelled."""
    return lines_of(read_raw_lines(path, layer, columns, progress))


def read_area(
    path: str | Path, layer: str | None = None, progress: Progress | None = None
) -> tuple[Any, DrawnLayer]:
    """All polygons of a file as one shapely area, with what was read. Raises as `read_lines`."""
    return area_of(read_raw_areas(path, layer, progress))


def lines_of(raw: RawLayer, *, with_rings: bool = True) -> DrawnLayer:
    """Return the lines of a layer, heights dropped, each part by itself.

    Parameters
    ----------
    with_rings : bool
        False leaves closed lines out, with the finding ``lines.closed``.

    Raises
    ------
    InputError
        If there are none.
    """
    return _drawn(raw, _LINES, (), with_rings)


def area_of(raw: RawLayer) -> tuple[Any, DrawnLayer]:
    """Return all polygons of a layer, heights dropped, as one shapely area, and the layer. Raises
    InputError if there are none."""
    import shapely

    shapes, said = _outlines(shapely.force_2d(raw.shapes))
    found = _drawn(replace(raw, shapes=shapes), _AREAS, said, True)
    area, crossing = taken_apart(found.shapes)
    return area, replace(found, warnings=(*found.warnings, *crossing))


def _drawn(
    raw: RawLayer, wanted: tuple[str, ...], said: Iterable[Message], with_rings: bool
) -> DrawnLayer:
    import shapely

    shapes = shapely.force_2d(raw.shapes)
    parts, row, left = _parts(shapes, raw.feature, wanted, with_rings)
    if not len(parts):
        raise _no_shape(raw, wanted)
    return DrawnLayer(
        raw.path, parts, raw.feature[row] + 1,
        {name: values[row] for name, values in raw.columns.items()},
        raw.crs, (*raw.warnings, *said, *left, *raw.left_out), raw.fields,
    )  # fmt: skip


def _read(
    path: Path,
    layer: str | None,
    wanted: tuple[str, ...],
    attributes: Iterable[str],
    progress: Progress | None,
    options: FrameOptions,
    model: ModelFrame | None,
) -> RawLayer:
    import shapely

    if not is_there(path) or is_folder(path):
        raise InputError(tr("There is no such file. Check its name."), file=path)
    layer = layer or _layer_of(path, wanted, progress)
    names = {name.casefold() for name in (*attributes, *OF_ENTITIES, "layer")}
    read = next(
        iter(read_layers(path, [layer], names, lambda: _unreadable(path), progress, flat=False)),
        VectorLayer("", None),
    )
    # A table without geometry has none at all.
    shapes, surfaces = shapes_from_wkb(read.shapes)
    columns = dict(read.columns or {})
    left_out: list[Message] = []
    keep = np.ones(len(shapes), np.bool_)
    if path.suffix.lower() == ".dxf":
        keep, left_out = features_of(path, columns, surfaces)
    elif surfaces.any():
        left_out.append(surfaces_left_out(int(surfaces.sum())))
    # A surface is reported once, and not as a shape without coordinates.
    keep = keep & ~(shapely.is_missing(shapes) & (surfaces > 0))
    if not keep.all():
        shapes = shapes[keep]
        columns = {name: values[keep] for name, values in columns.items()}
    shapes, placed = _in_world(path, shapes, read.crs, options, model)
    feature = np.arange(len(shapes), dtype=np.int64)
    return RawLayer(
        path,
        shapes,
        feature,
        columns,
        placed.crs,
        placed.findings,
        tuple(left_out),
        read.fields,
    )


def _no_shape(raw: RawLayer, wanted: tuple[str, ...]) -> InputError:
    if raw.field is not None:
        return InputError(tr("There are no lines with a length."), field=raw.field)
    for finding in raw.left_out:
        if isinstance(finding, Finding) and finding.code == "drawing.no-lines":
            return InputError.of_finding(
                Finding("drawing.only-bodies", **finding.values), file=raw.path
            )
    if wanted is _AREAS:
        words = tr(
            "The file holds no polygon. Draw one around the area in which traces were mapped."
        )
    else:
        words = tr("The file holds no line. Save the traces as lines, each from end to end.")
    return InputError(words, file=raw.path)


def _unreadable(path: Path) -> InputError:
    return InputError(
        why_unreadable(path)
        or tr(
            "This cannot be read as a drawing. Save it as GeoPackage, GeoJSON, shapefile or DXF."
        ),
        file=path,
    )


def _layer_of(path: Path, wanted: tuple[str, ...], progress: Progress | None) -> str | None:
    """The only layer that can hold such shapes."""
    layers = list_layers(path, lambda: _unreadable(path), progress)
    symbols = symbol_layers(layer.name for layer in layers)
    # None is no geometry at all, Unknown is any.
    kinds = ("Unknown", *wanted, "Curve", "GeometryCollection")
    fit = [
        layer.name
        for layer in layers
        if layer.kind is not None
        and layer.name.casefold() not in symbols
        and any(part in layer.kind for part in kinds)
    ]
    if len(fit) > 1:
        raise UsageError(
            tr("The file has several layers: {names}. Name one of them.", names=", ".join(fit)),
            file=path, field="--layer",
        )  # fmt: skip
    return fit[0] if fit else None


def _frame(
    path: Path,
    crs: str | None,
    bounds: npt.NDArray[np.float64],
    options: FrameOptions,
    *,
    alone: bool,
) -> tuple[StatedCrs, FrameOptions]:
    """Return what a drawing states about its CRS, and the options that complete it.

    Parameters
    ----------
    crs : str or None
        As GDAL reports it: WGS 84 for GeoJSON without a ``crs``, by its standard.
    bounds : (2, 2) float
        Lowest and highest x and y.
    alone : bool
        Whether the drawing belongs to no other data, whose CRS it would be converted to.
    """
    if names_no_crs(path):
        if options.crs is not None:
            return StatedCrs(), options
        in_degrees = float(np.abs(bounds).max(initial=0.0)) <= MOST_DEGREES
        if alone and options.to_crs is None and in_degrees:
            options = replace(options, to_crs=suggested_zone(bounds))
        return StatedCrs(crs), options
    if crs is None:
        beside, _ = crs_of_table(path, ())
        if beside.text is not None:
            return beside, options
    if crs is None and options.unit is None and path.suffix.lower() == ".dxf":
        unit_m = dxf_facts(path).unit_m
        return StatedCrs(is_local=unit_m is not None, unit_m=unit_m), options
    return StatedCrs(crs), options


def _in_world(
    path: Path,
    shapes: Shapes,
    crs: str | None,
    options: FrameOptions,
    model: ModelFrame | None,
) -> tuple[Shapes, WorldPoints]:
    """Convert shapes (n,) to World, with or without heights."""
    import shapely

    points, row = shapely.get_coordinates(shapes, include_z=True, return_index=True)
    is_flat = np.isnan(points[:, 2])
    points[is_flat, 2] = 0.0
    finite = points[np.isfinite(points).all(axis=1), :2]
    bounds = np.array([finite.min(axis=0), finite.max(axis=0)]) if len(finite) else np.zeros((2, 2))
    stated, options = _frame(path, crs, bounds, options, alone=model is None)
    placed = points_to_world(points, file=path, stated=stated, options=options, model=model)
    if placed.points is points or np.array_equal(placed.points, points, equal_nan=True):
        return shapes, placed
    converted = shapes.copy()
    has_z = shapely.has_z(shapes)
    for with_z in (False, True):
        chosen = has_z == with_z
        if chosen.any():
            new = placed.points[chosen[row]]
            converted[chosen] = shapely.set_coordinates(
                shapes[chosen].copy(), new if with_z else new[:, :2]
            )
    return converted, placed


def _outlines(shapes: Shapes) -> tuple[Shapes, list[str]]:
    """Closed lines as polygons where there is none, since drawings for CAD have no polygons; and
    what is said of them."""
    import shapely

    kinds = shapely.get_type_id(shapes)
    if np.isin(kinds, (3, 6)).any():
        return shapes, []
    lines = _finite(shapes) & np.isin(kinds, (1, 2)) & (shapely.get_num_coordinates(shapes) >= 4)
    rows = np.flatnonzero(lines)
    closed = rows[shapely.is_closed(shapes[rows])]
    if not len(closed):
        return shapes, []
    made = shapes.copy()
    made[closed] = [shapely.Polygon(shapely.get_coordinates(shapes[i])) for i in closed]
    return made, [
        tr_n(
            "{count} closed line was taken as the outline of the area.",
            "{count} closed lines were taken as outlines of the area.",
            len(closed),
        )
    ]


def _parts(
    shapes: Shapes,
    numbers: npt.NDArray[np.int64],
    wanted: tuple[str, ...],
    with_rings: bool,
) -> tuple[Shapes, npt.NDArray[np.int64], list[Message]]:
    """Single shapes of the wanted kind, the row of each, and what was left out.

    numbers : (n,) row of each shape in its file, for the messages
    """
    import shapely

    there = np.flatnonzero(~(shapely.is_missing(shapes) | shapely.is_empty(shapes)))
    whole = np.flatnonzero(np.isfinite(shapely.bounds(shapes)).all(axis=1))
    finite = np.intersect1d(np.intersect1d(there, whole), np.flatnonzero(_finite(shapes)))
    merged = shapes[finite]
    multi = np.flatnonzero(shapely.get_type_id(merged) == 5)
    merged[multi] = shapely.line_merge(merged[multi])
    parts, at = shapely.get_parts(merged, return_index=True)
    kind = np.isin(shapely.get_type_id(parts), (3,) if "Polygon" in wanted else (1, 2))
    size = shapely.length(parts)
    if "Polygon" in wanted:
        # The parts of an outline that crosses itself may cancel.
        size = shapely.area(shapely.make_valid(parts))
    long = kind & (size > 0)
    feature = finite.astype(np.int64)[at]
    said: list[Message] = []
    if lost := len(shapes) - len(finite):
        said.append(
            tr_n(
                "{count} feature without finite coordinates is left out.",
                "{count} features without finite coordinates are left out.",
                lost,
            )
        )
    if other := int(np.sum(~kind)):
        said.append(
            tr_n(
                "{count} shape of another kind is left out.",
                "{count} shapes of another kind are left out.",
                other,
            )
        )
    if short := int(np.sum(kind & ~long)):
        said.append(
            tr_n(
                "{count} shape without length or area is left out: feature {first}.",
                "{count} shapes without length or area are left out, the first is feature {first}.",
                short,
                first=int(numbers[feature[kind & ~long][0]]) + 1,
            )
        )
    parts, feature = parts[long], feature[long]
    if not with_rings:
        closed = np.asarray(shapely.is_closed(parts))
        if closed.any():
            said.append(Finding("lines.closed", lines=int(closed.sum())))
        parts, feature = parts[~closed], feature[~closed]
    again = len(feature) - len(np.unique(feature))
    if again and "Polygon" not in wanted:
        said.append(
            tr_n(
                "Parts of a feature that do not join are traces of their own: {count} more than "
                "there are features.",
                "Parts of features that do not join are traces of their own: {count} more than "
                "there are features.",
                again,
            )
        )
    kept = _first_of_each(parts)
    if twice := len(parts) - len(kept):
        said.append(
            tr_n(
                "{count} shape that is drawn twice is counted once.",
                "{count} shapes that are drawn twice are counted once.",
                twice,
            )
        )
    return parts[kept], feature[kept], said


def _finite(shapes: Shapes) -> npt.NDArray[np.bool_]:
    """(n,) which of them have no coordinate that is no number."""
    import shapely

    points, row = shapely.get_coordinates(shapes, return_index=True)
    found = np.ones(len(shapes), np.bool_)
    found[row[~np.isfinite(points).all(axis=1)]] = False
    return found


def _first_of_each(shapes: Shapes) -> npt.NDArray[np.int64]:
    import shapely

    _, first = np.unique(shapely.to_wkb(shapely.normalize(shapes)), return_index=True)
    return np.sort(first)


def _is_empty(value: Any) -> bool:
    return value is None or (isinstance(value, float) and np.isnan(value)) or str(value) == "NaT"
