"""Reading of lines and outlines from GIS layers and drawings, in file coordinates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import AnyArray, FloatArray, ObjectArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.io.gis.dxf_properties import ENTITY_COLUMNS, select_lines, unreadable_reason
from vomstudio.io.gis.layer_reading import symbol_layers
from vomstudio.io.gis.vector_layers import list_layers, read_layers
from vomstudio.io.gis.wkb_shapes import excluded_surfaces_finding, shapes_from_wkb

_NAME_COLUMNS = ("name", "label", "id", "title")
_ATTRIBUTE_COLUMNS = ("id", "kind", "set")
DEFAULT_LAYERS = ("", "0", "defpoints", "entities")
"""Names of the default layers of CAD programs."""
_MIN_RELATIVE_LENGTH = 1e-13
"""Minimum length of a line relative to its largest coordinate."""
_SHAPES_PER_STEP = 10_000
"""Number of shapes between two checks for cancellation."""


@dataclass(frozen=True)
class FeatureAttributes:
    """Attributes of a shape that belong to a feature of a project; "" if the file has none.

    Parameters
    ----------
    id : str
        ID of the feature from which the shape was drawn.
    kind, set : str
        Feature type and set.
    """

    id: str = ""
    kind: str = ""
    set: str = ""


NO_ATTRIBUTES = FeatureAttributes()


@dataclass(frozen=True, eq=False)
class GisLine:
    """Line or outline of a drawing.

    Parameters
    ----------
    layer : str
        Layer name; in a CAD drawing, the layer of the entity.
    name : str
    points : (n, 2) or (n, 3) float64
        Coordinates as in the file; the first point of an outline is repeated at the end.
    closed : bool
    crs : str or None
        CRS of the layer, or None if the layer states none.
    words : FeatureAttributes
    """

    layer: str
    name: str
    points: FloatArray
    closed: bool
    crs: str | None = None
    words: FeatureAttributes = NO_ATTRIBUTES


@dataclass(frozen=True, eq=False)
class GisLines:
    """Lines of a file.

    Parameters
    ----------
    lines : tuple of GisLine
    systems : tuple of str
        CRSs of the layers.
    described : mapping of str to str
        Descriptions by layer name.
    warnings : tuple of Finding
        Findings about excluded shapes.
    """

    lines: tuple[GisLine, ...]
    systems: tuple[str, ...]
    described: Mapping[str, str]
    warnings: tuple[Finding, ...]


@np.errstate(all="ignore")
def read_gis_lines(path: str | Path, progress: Progress | None = None) -> GisLines:
    """Read all lines and polygons of a GeoPackage, GeoJSON, shapefile or DXF.

    Rings of polygons and parts of collections become separate lines. Symbols, hidden layers of a
    CAD drawing, and lines that have no length or contain non-finite coordinates are excluded.

    Raises
    ------
    InputError
        If the file cannot be read.
    Cancelled
    """
    path = Path(path)
    all_lines: list[GisLine] = []
    layer_descriptions: dict[str, str] = {}
    systems: list[str] = []
    warnings: list[Finding] = []
    skipped_count = 0

    def reading_error() -> InputError:
        return _reading_error(path)

    layers = list_layers(path, reading_error, progress)
    symbols = symbol_layers(layer.name for layer in layers)
    names = [n.name for n in layers if n.kind is not None and n.name.casefold() not in symbols]
    vector_layers = (
        read_layers(
            path,
            names,
            (*_NAME_COLUMNS, *_ATTRIBUTE_COLUMNS, *ENTITY_COLUMNS, "layer"),
            reading_error,
            progress,
        )
        if names
        else []
    )
    for layer in vector_layers:
        systems += [] if layer.crs is None else [layer.crs]
        layer_descriptions[layer.name] = layer.described
        columns, shapes = dict(layer.columns or {}), layer.shapes
        if shapes is None:
            continue
        geometries, surfaces = shapes_from_wkb(shapes)
        if path.suffix.lower() == ".dxf":
            is_kept, findings = select_lines(path, columns, surfaces)
            warnings += findings
            geometries, surfaces = geometries[is_kept], surfaces[is_kept]
            columns = {name: values[is_kept] for name, values in columns.items()}
        elif surfaces.any():
            warnings.append(excluded_surfaces_finding(int(surfaces.sum())))
        layer_names = [layer.name] * len(geometries)
        if path.suffix.lower() == ".dxf":
            layer_names = _column_texts(columns, "layer") or layer_names
        line_names = _names(columns, len(geometries))
        words = _feature_attributes(columns, len(geometries))
        lines, n_other_kinds = _lines(
            layer_names, line_names, words, geometries, layer.crs, progress
        )
        all_lines += lines
        skipped_count += n_other_kinds - sum(
            shape is None for shape, count in zip(geometries, surfaces, strict=True) if count
        )
    if skipped_count:
        warnings.append(Finding("drawing.other-shapes", count=skipped_count))
    valid_lines = tuple(line for line in all_lines if _is_valid(line.points))
    if len(valid_lines) < len(all_lines):
        warnings.append(Finding("drawing.invalid-shapes", count=len(all_lines) - len(valid_lines)))
    return GisLines(valid_lines, tuple(systems), layer_descriptions, tuple(warnings))


def _is_valid(points: FloatArray) -> bool:
    if len(points) < 2 or not np.isfinite(points).all():
        return False
    # The points of a degenerate curve in GDAL differ by rounding errors.
    return bool((np.abs(points - points[0]) > _MIN_RELATIVE_LENGTH * np.abs(points).max()).any())


def _reading_error(path: Path) -> InputError:
    return InputError(
        unreadable_reason(path) or Finding("drawing.unreadable"),
        file=path,
    )


def _names(columns: Mapping[str, AnyArray], count: int) -> list[str]:
    for name in _NAME_COLUMNS:
        if (names := _column_texts(columns, name)) is not None:
            return names
    return [""] * count


def _feature_attributes(columns: Mapping[str, AnyArray], count: int) -> list[FeatureAttributes]:
    texts = [_column_texts(columns, name) or [""] * count for name in _ATTRIBUTE_COLUMNS]
    return [FeatureAttributes(*item) for item in zip(*texts, strict=True)]


def _column_texts(columns: Mapping[str, AnyArray], name: str) -> list[str] | None:
    """Return the texts of the column `name`, or None if it is missing.

    The case of the column names is ignored.
    """
    for key, values in columns.items():
        if key.casefold() == name:
            return ["" if value is None else str(value) for value in values]
    return None


def _lines(
    layers: list[str],
    names: list[str],
    words: list[FeatureAttributes],
    shapes: ObjectArray,
    crs: str | None,
    progress: Progress | None,
) -> tuple[list[GisLine], int]:
    lines: list[GisLine] = []
    skipped_count = 0
    rows = zip(layers, names, words, shapes, strict=True)
    for index, (layer, name, word, shape) in enumerate(rows):
        if progress is not None and not index % _SHAPES_PER_STEP:
            progress.step(index)
        parts = _parts(shape)
        skipped_count += not parts
        for points, is_closed in parts:
            lines.append(GisLine(layer, name, points, is_closed, crs, word))
    return lines, skipped_count


def _parts(shape: Any) -> list[tuple[FloatArray, bool]]:
    import shapely

    if shape is None or shape.is_empty:
        return []
    if shape.geom_type == "Polygon":
        rings = [shape.exterior, *shape.interiors]
        return [(shapely.get_coordinates(ring), True) for ring in rings]
    if shape.geom_type in ("LineString", "LinearRing"):
        points = shapely.get_coordinates(shape)
        return [(points, bool(len(points) > 3 and (points[0] == points[-1]).all()))]
    if hasattr(shape, "geoms"):
        return [part for member in shape.geoms for part in _parts(member)]
    return []
