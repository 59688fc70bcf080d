"""Lines and outlines out of GIS layers and drawings, as the file has their coordinates."""

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
from vomstudio.io.gis.wkb_shapes import shapes_from_wkb, surfaces_left_out

_NAMES = ("name", "label", "id", "title")
_WORDS = ("id", "kind", "set")
NO_LAYERS = ("", "0", "defpoints", "entities")
"""Layers of CAD on which lies what nobody put on one."""
_ROUNDING = 1e-13
"""Of the largest coordinate: no point of a line without length is farther from its first."""
_LOOKED_AT = 10_000
"""Shapes between two looks at whether the work is still wanted."""


@dataclass(frozen=True)
class FeatureWords:
    """Attributes of a shape that belong to a feature of a project; "" if the file has none.

    Parameters
    ----------
    id : str
        Id of the feature from which the shape was drawn.
    kind, set : str
        Feature type and set.
    """

    id: str = ""
    kind: str = ""
    set: str = ""


NO_WORDS = FeatureWords()


@dataclass(frozen=True, eq=False)
class ReadLine:
    """Line or outline of a drawing.

    Parameters
    ----------
    layer : str
        Layer; in a drawing for CAD that of the entity.
    name : str
    points : (n, 2) or (n, 3) float64
        As in the file; the first point of an outline is repeated at the end.
    closed : bool
    crs : str or None
        CRS of the layer, None if it states none.
    words : FeatureWords
    """

    layer: str
    name: str
    points: FloatArray
    closed: bool
    crs: str | None = None
    words: FeatureWords = NO_WORDS


@dataclass(frozen=True, eq=False)
class ReadLines:
    """systems : the CRS that its layers state; described : by the names of its layers; warnings :
    what was left out, sentences"""

    lines: tuple[ReadLine, ...]
    systems: tuple[str, ...]
    described: Mapping[str, str]
    warnings: tuple[Finding, ...]


@np.errstate(all="ignore")
def read_gis_lines(path: str | Path, progress: Progress | None = None) -> ReadLines:
    """Read all lines and polygons of a GeoPackage, GeoJSON, shapefile or DXF.

    Rings of polygons and parts of collections become separate lines. Symbols, hidden layers of a
    CAD drawing, and lines without length or with non-finite coordinates are excluded.

    Raises
    ------
    InputError
        If the file cannot be read.
    Cancelled
    """
    path = Path(path)
    found: list[ReadLine] = []
    described: dict[str, str] = {}
    systems: list[str] = []
    warnings: list[Finding] = []
    skipped = 0

    def unreadable() -> InputError:
        return _unreadable(path)

    layers = list_layers(path, unreadable, progress)
    symbols = symbol_layers(layer.name for layer in layers)
    names = [n.name for n in layers if n.kind is not None and n.name.casefold() not in symbols]
    read = (
        read_layers(path, names, (*_NAMES, *_WORDS, *ENTITY_COLUMNS, "layer"), unreadable, progress)
        if names
        else []
    )
    for layer in read:
        systems += [] if layer.crs is None else [layer.crs]
        described[layer.name] = layer.described
        columns, shapes = dict(layer.columns or {}), layer.shapes
        if shapes is None:
            continue
        geometries, surfaces = shapes_from_wkb(shapes)
        if path.suffix.lower() == ".dxf":
            keep, messages = select_lines(path, columns, surfaces)
            warnings += messages
            geometries, surfaces = geometries[keep], surfaces[keep]
            columns = {name: values[keep] for name, values in columns.items()}
        elif surfaces.any():
            warnings.append(surfaces_left_out(int(surfaces.sum())))
        layer_names = [layer.name] * len(geometries)
        if path.suffix.lower() == ".dxf":
            layer_names = _words(columns, "layer") or layer_names
        line_names = _names(columns, len(geometries))
        words = _feature_words(columns, len(geometries))
        lines, others = _lines(layer_names, line_names, words, geometries, layer.crs, progress)
        found += lines
        skipped += others - sum(
            shape is None for shape, count in zip(geometries, surfaces, strict=True) if count
        )
    if skipped:
        warnings.append(Finding("drawing.other-shapes", count=skipped))
    valid = tuple(line for line in found if _is_sound(line.points))
    if len(valid) < len(found):
        warnings.append(Finding("drawing.invalid-shapes", count=len(found) - len(valid)))
    return ReadLines(valid, tuple(systems), described, tuple(warnings))


def _is_sound(points: FloatArray) -> bool:
    if len(points) < 2 or not np.isfinite(points).all():
        return False
    # Curves that GDAL draws of one point differ by the rounding of its sums.
    return bool((np.abs(points - points[0]) > _ROUNDING * np.abs(points).max()).any())


def _unreadable(path: Path) -> InputError:
    return InputError(
        unreadable_reason(path) or Finding("drawing.unreadable"),
        file=path,
    )


def _names(columns: Mapping[str, AnyArray], count: int) -> list[str]:
    for name in _NAMES:
        if (found := _words(columns, name)) is not None:
            return found
    return [""] * count


def _feature_words(columns: Mapping[str, AnyArray], count: int) -> list[FeatureWords]:
    texts = [_words(columns, name) or [""] * count for name in _WORDS]
    return [FeatureWords(*each) for each in zip(*texts, strict=True)]


def _words(columns: Mapping[str, AnyArray], name: str) -> list[str] | None:
    """Of the column that is called so, in any letters."""
    for key, values in columns.items():
        if key.casefold() == name:
            return ["" if value is None else str(value) for value in values]
    return None


def _lines(
    layers: list[str],
    names: list[str],
    words: list[FeatureWords],
    shapes: ObjectArray,
    crs: str | None,
    progress: Progress | None,
) -> tuple[list[ReadLine], int]:
    found: list[ReadLine] = []
    skipped = 0
    rows = zip(layers, names, words, shapes, strict=True)
    for number, (layer, name, word, shape) in enumerate(rows):
        if progress is not None and not number % _LOOKED_AT:
            progress.step(number)
        parts = _parts(shape)
        skipped += not parts
        for points, closed in parts:
            found.append(ReadLine(layer, name, points, closed, crs, word))
    return found, skipped


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
        return [part for one in shape.geoms for part in _parts(one)]
    return []
