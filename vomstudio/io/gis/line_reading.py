"""Lines and outlines out of GIS layers and drawings, as the file has their coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.errors import InputError
from vomstudio.io.gis.layer_reading import are_features, layers_of, symbol_layers, wanted_columns
from vomstudio.words import tr

Array = npt.NDArray[np.float64]

_NAMES = ("name", "label", "id", "title")


@dataclass(frozen=True, eq=False)
class ReadLine:
    """points : (n, 2) or, where the file has heights and they are wanted, (n, 3); of an outline the
    first is repeated at the end"""

    layer: str
    name: str
    points: Array
    closed: bool


@dataclass(frozen=True, eq=False)
class ReadLines:
    """crs : what the file states, None where it states none; described : of its layers; skipped :
    how many of its shapes were neither line nor outline"""

    lines: tuple[ReadLine, ...]
    crs: str | None
    described: tuple[str, ...]
    skipped: int


@np.errstate(all="ignore")
def read_gis_lines(path: str | Path) -> ReadLines:
    """All lines and polygons of all layers of a GeoPackage, GeoJSON, shapefile or DXF; rings of a
    polygon and parts of a collection are lines of their own, and symbols are none. Raises
    InputError where the file cannot be read."""
    import pyogrio

    path = Path(path)
    found: list[ReadLine] = []
    described: list[str] = []
    crs: str | None = None
    skipped = 0
    with layers_of(path, lambda: _unreadable(path)) as named:
        layers = pyogrio.list_layers(named)
        symbols = symbol_layers(str(layer) for layer, _ in layers)
        for layer, kind in layers:
            if kind is None or str(layer).casefold() in symbols:
                continue
            columns = wanted_columns(named, str(layer), _NAMES)
            told, _, shapes, fields = pyogrio.raw.read(
                named, layer=layer, force_2d=True, columns=columns
            )
            crs = crs or told["crs"]
            info = pyogrio.read_info(named, layer=layer)
            described.append(str((info.get("layer_metadata") or {}).get("DESCRIPTION", "")))
            if path.suffix.lower() == ".dxf":
                keep = are_features(dict(zip(told["fields"], fields, strict=True)), len(shapes))
                shapes, fields = shapes[keep], [values[keep] for values in fields]
            names = _names(told["fields"], fields, len(shapes))
            lines, others = _lines(str(layer), names, shapes)
            found += lines
            skipped += others
    return ReadLines(tuple(found), crs, tuple(described), skipped)


def _unreadable(path: Path) -> InputError:
    return InputError(
        tr(
            "The file cannot be read as lines. Save them as GeoPackage, GeoJSON, shapefile, DXF or "
            "SVG."
        ),
        file=path,
    )


def _names(keys: Any, fields: Any, count: int) -> list[str]:
    lower = {str(key).casefold(): k for k, key in enumerate(keys)}
    for name in _NAMES:
        if name in lower:
            return ["" if value is None else str(value) for value in fields[lower[name]]]
    return [""] * count


def _lines(layer: str, names: list[str], shapes: Any) -> tuple[list[ReadLine], int]:
    import shapely

    found: list[ReadLine] = []
    skipped = 0
    for name, shape in zip(names, shapely.from_wkb(shapes), strict=True):
        parts = _parts(shape)
        skipped += not parts
        for points, closed in parts:
            found.append(ReadLine(layer, name, points, closed))
    return found, skipped


def _parts(shape: Any) -> list[tuple[Array, bool]]:
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
