"""Layers as GeoJSON, with one file per layer, in the CRS of the project.

RFC 7946 only allows longitude and latitude, in which an outcrop loses millimetres and distances can
no longer be measured on a map. Therefore the coordinates are those of the project, and the CRS is
stated in the `crs` member of the 2008 specification, which GDAL and QGIS support. It is null for a
local frame, because a file without it would be interpreted as degrees.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.io.exchange.columns import sibling_path
from vomstudio.io.gis.layers import Layer

_GEOMETRY = {"point": "Point", "line": "LineString", "ring": "Polygon"}


def geojson_files(out: Path, layers: Sequence[Layer], crs: str | None) -> dict[Path, str]:
    """Return the texts of `planes` (`out`) and of the other layers (NAME_layer next to it)."""
    names = [out if layer.name == "planes" else sibling_path(out, layer.name) for layer in layers]
    return {path: _collection(layer, crs) for path, layer in zip(names, layers, strict=True)}


def _collection(layer: Layer, crs: str | None) -> str:
    features = [
        {
            "type": "Feature",
            "properties": {
                name: _to_plain_value(column[row]) for name, column in layer.columns.items()
            },
            "geometry": {"type": _GEOMETRY[layer.kind], "coordinates": _coordinates(layer, shape)},
        }
        for row, shape in enumerate(layer.shapes)
    ]
    crs_member = None if crs is None else {"type": "name", "properties": {"name": _urn(crs)}}
    collection = {
        "type": "FeatureCollection",
        "name": layer.name,
        "crs": crs_member,
        "features": features,
    }
    return json.dumps(collection, ensure_ascii=False, allow_nan=False) + "\n"


def _urn(crs: str) -> str:
    """Return the name of an EPSG code in GeoJSON, or the text of other systems."""
    authority, _, code = crs.partition(":")
    return f"urn:ogc:def:crs:EPSG::{code}" if authority == "EPSG" and code.isdigit() else crs


def _coordinates(layer: Layer, shape: Any) -> list[Any]:
    points: list[list[float]] = shape.tolist()
    if layer.kind == "point":
        return points[0]
    # Repeat the first point of a ring.
    return points if layer.kind == "line" else [[*points, points[0]]]


def _to_plain_value(value: Any) -> Any:
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


def properties_of(layer: Layer, row: int) -> Mapping[str, Any]:
    """Return the known figures of one feature."""
    values = {name: _to_plain_value(column[row]) for name, column in layer.columns.items()}
    return {name: value for name, value in values.items() if value not in (None, "")}
