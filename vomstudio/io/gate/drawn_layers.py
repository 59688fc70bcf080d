"""Lines and polygons that were drawn in a GIS or CAD program, in metres.

The formats are GeoPackage, GeoJSON, shapefile, DXF and KML. Layers in degrees are rejected because
their lengths are not metric; GeoJSON without a ``crs`` is in degrees (RFC 7946) and is converted.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import AnyArray, BoolArray, FloatArray, IntArray, ObjectArray
from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.files.regular import folder_finding, is_folder, path_exists
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.geometry.outlines.self_crossing import resolve_crossings
from vomstudio.io.gate.frame_options import DEFAULT_FRAME, FrameOptions
from vomstudio.io.gate.points import ModelFrame, WorldPoints, points_to_world
from vomstudio.io.gate.stated_crs import StatedCrs, table_crs
from vomstudio.io.gis.axis_units import MAX_DEGREES, suggested_zone
from vomstudio.io.gis.dxf_properties import (
    ENTITY_COLUMNS,
    read_dxf_properties,
    select_lines,
    unreadable_reason,
)
from vomstudio.io.gis.layer_reading import is_geojson_without_crs, symbol_layers
from vomstudio.io.gis.vector_layers import VectorLayer, list_layers, read_layers
from vomstudio.io.gis.wkb_shapes import excluded_surfaces_finding, shapes_from_wkb

_LINE_TYPES, _AREA_TYPES = ("LineString", "LinearRing"), ("Polygon",)
OUTLINE_LAYERS = ("patches", "lithologies")
"""Suffixes of layer names that contain outlines in drawings created by this program."""


@dataclass(frozen=True, eq=False)
class DrawnLayer:
    """Lines or polygons of a layer, split into single parts.

    Parameters
    ----------
    path : Path
        Path of the file.
    shapes : (n,) array of shapely geometries
        Lines or polygons in metres.
    feature : (n,) array of int
        1-based number of the feature to which each part belongs.
    columns : mapping of str to (n,) array
        Requested attributes by name.
    crs : str or None
        "EPSG:n" or WKT; None if the file states no CRS.
    warnings : tuple of Finding
    fields : tuple of str
        Names of all attributes of the layer.
    """

    path: Path
    shapes: ObjectArray
    feature: IntArray
    columns: Mapping[str, AnyArray]
    crs: str | None
    warnings: tuple[Finding, ...]
    fields: tuple[str, ...] = ()

    def column(self, name: str, field: str) -> list[str]:
        """Return the texts (n,) of an attribute, "" if empty. Raises UsageError."""
        key = next(
            (column for column in self.columns if column.casefold() == name.casefold()), None
        )
        if key is None:
            raise UsageError(
                Finding(
                    "table.unknown-column", column=name, columns=self.fields or tuple(self.columns)
                ),
                file=self.path,
                field=field,
            )
        return ["" if _is_empty(v) else str(v).strip() for v in self.columns[key]]


@dataclass(frozen=True, eq=False)
class RawLayer:
    """Features of a layer with heights, before shapes of other kinds are excluded.

    Parameters
    ----------
    path : Path
        Path of the file.
    shapes : (n,) array of shapely geometries
        Geometries in metres, 2D if the file has no heights; None if missing.
    feature : (n,) array of int
        Row of each shape in the file.
    columns, crs, fields
        As for `DrawnLayer`.
    warnings, exclusion_findings : tuple
        Findings about coordinates, and about entities of a drawing that were not read.
    field : str or None
        Name of the argument if shapes are passed to the Python interface instead of a file.
    """

    path: Path
    shapes: ObjectArray
    feature: IntArray
    columns: Mapping[str, AnyArray]
    crs: str | None
    warnings: tuple[Finding, ...] = ()
    exclusion_findings: tuple[Finding, ...] = ()
    fields: tuple[str, ...] = ()
    field: str | None = None

    def select_rows(self, rows: BoolArray) -> RawLayer:
        """Return the layer with only those features for which `rows` (n,) is True."""
        return replace(
            self,
            shapes=self.shapes[rows],
            feature=self.feature[rows],
            columns={name: values[rows] for name, values in self.columns.items()},
        )

    def outline_mask(self) -> BoolArray:
        """Return a mask (n,) of the features on outline layers of this program's drawings."""
        names = next((v for n, v in self.columns.items() if n.casefold() == "layer"), ())
        is_outline = np.zeros(len(self.shapes), np.bool_)
        for row, name in enumerate(names):
            is_outline[row] = str(name).casefold().rpartition("_")[2] in OUTLINE_LAYERS
        return is_outline


def read_raw_lines(
    path: str | Path,
    layer: str | None = None,
    columns: Iterable[str] = (),
    progress: Progress | None = None,
    options: FrameOptions = DEFAULT_FRAME,
    model: ModelFrame | None = None,
) -> RawLayer:
    """Read all features of a layer of lines in the World frame, with heights.

    GeoJSON without a ``crs`` is in degrees according to its standard and is converted to a metric
    CRS.

    Parameters
    ----------
    path : str or Path
    layer : str, optional
        Name of the layer, required if there are several.
    columns : iterable of str
        Names of the attributes to read.
    progress : Progress, optional
    options : FrameOptions
        Frame options of the caller, which complement the statements of the file.
    model : ModelFrame, optional
        Frame of the data to which the drawing belongs; the drawing is converted to this frame.

    Raises
    ------
    InputError
        If the file is not a drawing, and as for `points_to_world`.
    UsageError
        If there are several layers and none is named.
    """
    return _read(Path(path), layer, _LINE_TYPES, columns, progress, options, model)


def read_raw_areas(
    path: str | Path,
    layer: str | None = None,
    progress: Progress | None = None,
    options: FrameOptions = DEFAULT_FRAME,
    model: ModelFrame | None = None,
) -> RawLayer:
    """Read all polygons of a layer in the World frame, in the same way as `read_raw_lines`."""
    return _read(Path(path), layer, _AREA_TYPES, (), progress, options, model)


def layer_from_shapes(
    shapes: ObjectArray, name: str, crs: str | None = None, options: FrameOptions = DEFAULT_FRAME
) -> RawLayer:
    """Convert shapes (n,) passed to the Python interface to a layer in the World frame.

    If no CRS is given, the shapes are assumed to be in World coordinates, metres.

    Raises
    ------
    InputError, UsageError
        As for `points_to_world`.
    """
    path = Path(name)
    rows = np.arange(len(shapes), dtype=np.int64)
    if crs is None and not options.is_given:
        return RawLayer(path, shapes, rows, {}, None, field=name)
    shapes, world_points = _convert_to_world(path, shapes, crs, options, None)
    return RawLayer(path, shapes, rows, {}, world_points.crs, world_points.findings, field=name)


def extract_lines(raw_layer: RawLayer, *, include_rings: bool = True) -> DrawnLayer:
    """Return the lines of a layer as single parts, without heights.

    Parameters
    ----------
    raw_layer : RawLayer
    include_rings : bool
        Whether to include closed lines. If False, they are excluded and reported as
        ``lines.closed``.

    Raises
    ------
    InputError
        If the layer contains no lines.
    """
    return _build_layer(raw_layer, _LINE_TYPES, (), include_rings)


def extract_area(raw_layer: RawLayer) -> tuple[Any, DrawnLayer]:
    """Return all polygons of a layer as one shapely geometry without heights, and the layer.

    Raises
    ------
    InputError
        If the layer contains no polygons.
    """
    import shapely

    shapes, findings = _close_outlines(shapely.force_2d(raw_layer.shapes))
    layer = _build_layer(replace(raw_layer, shapes=shapes), _AREA_TYPES, findings, True)
    area, crossing_findings = resolve_crossings(layer.shapes)
    return area, replace(layer, warnings=(*layer.warnings, *crossing_findings))


def _build_layer(
    raw_layer: RawLayer, kinds: tuple[str, ...], findings: Iterable[Finding], include_rings: bool
) -> DrawnLayer:
    import shapely

    shapes = shapely.force_2d(raw_layer.shapes)
    parts, row, part_findings = _parts(shapes, raw_layer.feature, kinds, include_rings)
    if not len(parts):
        raise _no_shapes_error(raw_layer, kinds)
    return DrawnLayer(
        raw_layer.path,
        parts,
        raw_layer.feature[row] + 1,
        {name: values[row] for name, values in raw_layer.columns.items()},
        raw_layer.crs,
        (*raw_layer.warnings, *findings, *part_findings, *raw_layer.exclusion_findings),
        raw_layer.fields,
    )


def _read(
    path: Path,
    layer: str | None,
    kinds: tuple[str, ...],
    attributes: Iterable[str],
    progress: Progress | None,
    options: FrameOptions,
    model: ModelFrame | None,
) -> RawLayer:
    import shapely

    if is_folder(path):
        raise InputError(folder_finding(path), file=path)
    if not path_exists(path):
        raise InputError(Finding("file.missing"), file=path)
    requested_layer, layer = layer, layer or _find_layer(path, kinds, progress)
    names = {name.casefold() for name in (*attributes, *ENTITY_COLUMNS, "layer")}
    raw_layer = next(
        iter(
            read_layers(
                path,
                [layer],
                names,
                lambda: _reading_error(path, requested_layer, progress),
                progress,
                is_flat=False,
            )
        ),
        VectorLayer("", None),
    )
    # A table without geometry is not a layer of shapes.
    shapes, surfaces = shapes_from_wkb(raw_layer.shapes)
    columns = dict(raw_layer.columns or {})
    excluded_findings: list[Finding] = []
    is_included = np.ones(len(shapes), np.bool_)
    if path.suffix.lower() == ".dxf":
        is_included, excluded_findings = select_lines(path, columns, surfaces)
    elif surfaces.any():
        excluded_findings.append(excluded_surfaces_finding(int(surfaces.sum())))
    # Report a surface only once, not again as a shape without coordinates.
    is_included = is_included & ~(shapely.is_missing(shapes) & (surfaces > 0))
    if not is_included.all():
        shapes = shapes[is_included]
        columns = {name: values[is_included] for name, values in columns.items()}
    shapes, world_points = _convert_to_world(path, shapes, raw_layer.crs, options, model)
    feature = np.arange(len(shapes), dtype=np.int64)
    return RawLayer(
        path,
        shapes,
        feature,
        columns,
        world_points.crs,
        world_points.findings,
        tuple(excluded_findings),
        raw_layer.fields,
    )


def _no_shapes_error(raw_layer: RawLayer, kinds: tuple[str, ...]) -> InputError:
    if raw_layer.field is not None:
        return InputError(Finding("drawing.zero-length"), field=raw_layer.field)
    for finding in raw_layer.exclusion_findings:
        if isinstance(finding, Finding) and finding.code == "drawing.no-lines":
            return InputError(Finding("drawing.only-bodies", **finding.values), file=raw_layer.path)
    code = "drawing.no-polygons" if kinds is _AREA_TYPES else "drawing.no-traces"
    return InputError(Finding(code), file=raw_layer.path)


def _reading_error(
    path: Path, layer: str | None = None, progress: Progress | None = None
) -> InputError:
    if layer is not None:
        layers = [
            listed_layer.name
            for listed_layer in list_layers(path, lambda: _reading_error(path), progress)
        ]
        if layer not in layers:
            finding = Finding("drawing.unknown-layer", layer=layer, layers=layers)
            return UsageError(finding, file=path, field="--layer")
    return InputError(
        unreadable_reason(path) or Finding("drawing.unreadable"),
        file=path,
    )


def _find_layer(path: Path, kinds: tuple[str, ...], progress: Progress | None) -> str | None:
    """Return the only layer that may contain shapes of these kinds, or None.

    Raises UsageError if there are several.
    """
    layers = list_layers(path, lambda: _reading_error(path), progress)
    symbols = symbol_layers(layer.name for layer in layers)
    # In GDAL, None means no geometry, and Unknown means any kind.
    accepted_types = ("Unknown", *kinds, "Curve", "GeometryCollection")
    candidates = [
        layer.name
        for layer in layers
        if layer.kind is not None
        and layer.name.casefold() not in symbols
        and any(part in layer.kind for part in accepted_types)
    ]
    if len(candidates) > 1:
        raise UsageError(
            Finding("drawing.several-layers", layers=candidates), file=path, field="--layer"
        )
    return candidates[0] if candidates else None


def _frame(
    path: Path,
    crs: str | None,
    bounds: FloatArray,
    options: FrameOptions,
    *,
    is_only_layer: bool,
) -> tuple[StatedCrs, FrameOptions]:
    """Return the CRS stated by a drawing, and the options that complement it.

    Parameters
    ----------
    path : Path
    crs : str or None
        CRS as reported by GDAL: WGS 84 for GeoJSON without a ``crs``, according to its standard.
    bounds : (2, 2) float
        Minimum and maximum of x and y.
    options : FrameOptions
        Frame options of the caller.
    is_only_layer : bool
        Whether there is no model to whose CRS the drawing is converted.
    """
    if is_geojson_without_crs(path):
        if options.crs is not None:
            return StatedCrs(), options
        is_in_degrees = float(np.abs(bounds).max(initial=0.0)) <= MAX_DEGREES
        if is_only_layer and options.to_crs is None and is_in_degrees:
            options = replace(options, to_crs=suggested_zone(bounds))
        return StatedCrs(crs), options
    stated_crs = stated_frame(path, crs)
    if stated_crs.text is None and options.unit is not None:
        return StatedCrs(), options
    return stated_crs, options


def stated_frame(path: Path, crs: str | None) -> StatedCrs:
    """Return the frame that a drawing states: by its CRS, a sidecar, or the unit of a DXF.

    Parameters
    ----------
    path : Path
    crs : str or None
        CRS as reported by GDAL.
    """
    if crs is None:
        sidecar, _ = table_crs(path, ())
        if sidecar.text is not None:
            return sidecar
        if path.suffix.lower() == ".dxf":
            unit_m = read_dxf_properties(path).unit_m
            return StatedCrs(is_local=unit_m is not None, unit_m=unit_m)
    return StatedCrs(crs)


def _convert_to_world(
    path: Path,
    shapes: ObjectArray,
    crs: str | None,
    options: FrameOptions,
    model: ModelFrame | None,
) -> tuple[ObjectArray, WorldPoints]:
    """Convert shapes (n,), with or without heights, to the World frame."""
    import shapely

    points, row = shapely.get_coordinates(shapes, include_z=True, return_index=True)
    is_flat = np.isnan(points[:, 2])
    points[is_flat, 2] = 0.0
    finite_points = points[np.isfinite(points).all(axis=1), :2]
    bounds = (
        np.array([finite_points.min(axis=0), finite_points.max(axis=0)])
        if len(finite_points)
        else np.zeros((2, 2))
    )
    stated_crs, options = _frame(path, crs, bounds, options, is_only_layer=model is None)
    world = points_to_world(points, file=path, stated_crs=stated_crs, options=options, model=model)
    if world.points is points or np.array_equal(world.points, points, equal_nan=True):
        return shapes, world
    converted_shapes = shapes.copy()
    has_z = shapely.has_z(shapes)
    for is_3d in (False, True):
        is_selected = has_z == is_3d
        if is_selected.any():
            new_points = world.points[is_selected[row]]
            converted_shapes[is_selected] = shapely.set_coordinates(
                shapes[is_selected].copy(), new_points if is_3d else new_points[:, :2]
            )
    return converted_shapes, world


def _close_outlines(shapes: ObjectArray) -> tuple[ObjectArray, list[Finding]]:
    """Convert closed lines to polygons if a layer has no polygons, and return findings.

    CAD drawings do not contain polygons.
    """
    import shapely

    kinds = shapely.get_type_id(shapes)
    if np.isin(kinds, (3, 6)).any():
        return shapes, []
    is_line = (
        _is_finite(shapes) & np.isin(kinds, (1, 2)) & (shapely.get_num_coordinates(shapes) >= 4)
    )
    rows = np.flatnonzero(is_line)
    closed_rows = rows[shapely.is_closed(shapes[rows])]
    if not len(closed_rows):
        return shapes, []
    polygons = shapes.copy()
    polygons[closed_rows] = [
        shapely.Polygon(shapely.get_coordinates(shapes[i])) for i in closed_rows
    ]
    return polygons, [Finding("drawing.lines-as-area", count=len(closed_rows))]


def _parts(
    shapes: ObjectArray,
    feature_rows: IntArray,
    kinds: tuple[str, ...],
    include_rings: bool,
) -> tuple[ObjectArray, IntArray, list[Finding]]:
    """Return single parts of the requested kinds, their rows, and findings about others.

    `feature_rows` (n,) contains the row of each shape in its file, for the findings.
    """
    import shapely

    is_empty = shapely.is_missing(shapes) | shapely.is_empty(shapes)
    has_bounds = np.isfinite(shapely.bounds(shapes)).all(axis=1)
    finite_indices = np.flatnonzero(~is_empty & has_bounds & _is_finite(shapes))
    merged_shapes = shapes[finite_indices]
    multi_rows = np.flatnonzero(shapely.get_type_id(merged_shapes) == 5)
    merged_shapes[multi_rows] = shapely.line_merge(merged_shapes[multi_rows])
    parts, offset = shapely.get_parts(merged_shapes, return_index=True)
    has_kind = np.isin(shapely.get_type_id(parts), (3,) if "Polygon" in kinds else (1, 2))
    size = shapely.length(parts)
    if "Polygon" in kinds:
        # The parts of a self-intersecting outline may cancel each other.
        size = shapely.area(shapely.make_valid(parts))
    has_size = has_kind & (size > 0)
    feature = finite_indices.astype(np.int64)[offset]
    findings: list[Finding] = []
    if n_invalid := len(shapes) - len(finite_indices):
        findings.append(Finding("drawing.invalid-shapes", count=n_invalid))
    if n_other_kinds := int(np.sum(~has_kind)):
        findings.append(Finding("drawing.other-shapes", count=n_other_kinds))
    if n_short := int(np.sum(has_kind & ~has_size)):
        findings.append(
            Finding(
                "drawing.invalid-shapes",
                count=n_short,
                first_feature=int(feature_rows[feature[has_kind & ~has_size][0]]) + 1,
            )
        )
    parts, feature = parts[has_size], feature[has_size]
    if not include_rings:
        is_closed = np.asarray(shapely.is_closed(parts))
        if is_closed.any():
            findings.append(Finding("lines.closed", lines=int(is_closed.sum())))
        parts, feature = parts[~is_closed], feature[~is_closed]
    extra_parts = len(feature) - len(np.unique(feature))
    if extra_parts and "Polygon" not in kinds:
        findings.append(Finding("drawing.separate-parts", count=extra_parts))
    unique_rows = _unique_rows(parts)
    if duplicates := len(parts) - len(unique_rows):
        findings.append(Finding("drawing.duplicates", count=duplicates))
    return parts[unique_rows], feature[unique_rows], findings


def _is_finite(shapes: ObjectArray) -> BoolArray:
    """Return a mask (n,) of the shapes whose coordinates are all finite."""
    import shapely

    points, row = shapely.get_coordinates(shapes, return_index=True)
    is_finite = np.ones(len(shapes), np.bool_)
    is_finite[row[~np.isfinite(points).all(axis=1)]] = False
    return is_finite


def _unique_rows(shapes: ObjectArray) -> IntArray:
    import shapely

    _, first_rows = np.unique(shapely.to_wkb(shapely.normalize(shapes)), return_index=True)
    return np.sort(first_rows)


def _is_empty(value: Any) -> bool:
    return value is None or (isinstance(value, float) and np.isnan(value)) or str(value) == "NaT"
