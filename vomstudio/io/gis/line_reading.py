"""Lines and outlines out of GIS layers and drawings, as the file has their coordinates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.errors import InputError
from vomstudio.io.gis.dxf_facts import OF_ENTITIES, features_of, why_unreadable
from vomstudio.io.gis.layer_reading import layers_of, symbol_layers, wanted_columns
from vomstudio.words import tr, tr_n

Array = npt.NDArray[np.float64]

_NAMES = ("name", "label", "id", "title")
NO_LAYERS = ("", "0", "defpoints", "entities")
"""Layers of CAD on which lies what nobody put on one."""


@dataclass(frozen=True, eq=False)
class ReadLine:
    """points : (n, 2) or, where the file has heights and they are wanted, (n, 3); of an outline the
    first is repeated at the end; crs : of its layer, None where that states none. layer : of a
    drawing for CAD that of the entity"""

    layer: str
    name: str
    points: Array
    closed: bool
    crs: str | None = None


@dataclass(frozen=True, eq=False)
class ReadLines:
    """systems : the CRS that its layers state; described : by the names of its layers; warnings :
    what was left out, sentences"""

    lines: tuple[ReadLine, ...]
    systems: tuple[str, ...]
    described: Mapping[str, str]
    warnings: tuple[str, ...]


@np.errstate(all="ignore")
def read_gis_lines(path: str | Path) -> ReadLines:
    """All lines and polygons of all layers of a GeoPackage, GeoJSON, shapefile or DXF; rings of a
    polygon and parts of a collection are lines of their own. Symbols, hidden layers of a drawing
    for CAD, and lines without length or with coordinates that are no numbers are none. Raises
    InputError where the file cannot be read."""
    import pyogrio

    path = Path(path)
    found: list[ReadLine] = []
    described: dict[str, str] = {}
    systems: list[str] = []
    warnings: list[str] = []
    skipped = 0
    with layers_of(path, lambda: _unreadable(path)) as named:
        layers = pyogrio.list_layers(named)
        symbols = symbol_layers(str(layer) for layer, _ in layers)
        for layer, kind in layers:
            if kind is None or str(layer).casefold() in symbols:
                continue
            wanted = wanted_columns(named, str(layer), (*_NAMES, *OF_ENTITIES))
            told, _, shapes, fields = pyogrio.raw.read(
                named, layer=layer, force_2d=True, columns=wanted
            )
            crs = None if told["crs"] is None else str(told["crs"])
            systems += [] if crs is None else [crs]
            info = pyogrio.read_info(named, layer=layer)
            told_of = (info.get("layer_metadata") or {}).get("DESCRIPTION", "")
            described[str(layer)] = str(told_of)
            if path.suffix.lower() == ".dxf":
                columns = dict(zip(map(str, told["fields"]), fields, strict=True))
                keep, said = features_of(path, columns, len(shapes))
                warnings += said
                shapes, fields = shapes[keep], [values[keep] for values in fields]
            names = _names(told["fields"], fields, len(shapes))
            homes = [str(layer)] * len(shapes)
            if path.suffix.lower() == ".dxf":
                homes = _column(told["fields"], fields, "layer") or homes
            lines, others = _lines(homes, names, shapes, crs)
            found += lines
            skipped += others
    if skipped:
        warnings.append(
            tr_n(
                "{count} shape is neither a line nor a polygon.",
                "{count} shapes are neither lines nor polygons.",
                skipped,
            )
        )
    kept = tuple(line for line in found if _is_sound(line.points))
    if len(kept) < len(found):
        warnings.append(
            tr_n(
                "{count} line without length, or with coordinates that are no numbers, is left "
                "out.",
                "{count} lines without length, or with coordinates that are no numbers, are left "
                "out.",
                len(found) - len(kept),
            )
        )
    return ReadLines(kept, tuple(systems), described, tuple(warnings))


def _is_sound(points: Array) -> bool:
    return bool(len(points) > 1 and np.isfinite(points).all() and (points != points[0]).any())


def _unreadable(path: Path) -> InputError:
    return InputError(
        why_unreadable(path)
        or tr(
            "The file cannot be read as lines. Save them as GeoPackage, GeoJSON, shapefile, DXF or "
            "SVG."
        ),
        file=path,
    )


def _names(keys: Any, fields: Any, count: int) -> list[str]:
    for name in _NAMES:
        if (found := _column(keys, fields, name)) is not None:
            return found
    return [""] * count


def _column(keys: Any, fields: Any, name: str) -> list[str] | None:
    """By its name in small letters."""
    lower = {str(key).casefold(): k for k, key in enumerate(keys)}
    if name not in lower:
        return None
    return ["" if value is None else str(value) for value in fields[lower[name]]]


def _lines(
    layers: list[str], names: list[str], shapes: Any, crs: str | None
) -> tuple[list[ReadLine], int]:
    import shapely

    found: list[ReadLine] = []
    skipped = 0
    for layer, name, shape in zip(layers, names, shapely.from_wkb(shapes), strict=True):
        parts = _parts(shape)
        skipped += not parts
        for points, closed in parts:
            found.append(ReadLine(layer, name, points, closed, crs))
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
