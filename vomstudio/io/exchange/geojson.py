"""Layers as GeoJSON, with one file per layer.

Coordinates are longitude and latitude in WGS 84 (RFC 7946), to a tenth of a millimetre. On request,
they are those of the project, with the `crs` member of the 2008 specification, which GDAL and QGIS
support. For a local frame that member is null, because a file without it would be read as degrees.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.io.exchange.columns import sibling_path
from vomstudio.io.gis.crs import to_degrees
from vomstudio.io.gis.layers import Layer

_DEGREE_DECIMALS = 9  # 0.1 mm
_HEIGHT_DECIMALS = 4
_GEOMETRY_TYPES = {"point": "Point", "line": "LineString", "ring": "Polygon"}


def geojson_files(
    out: Path, layers: Sequence[Layer], crs: str | None, *, is_projected: bool = False
) -> dict[Path, str]:
    """Return the text of each file by path: `out` for planes, NAME_layer for other layers.

    Parameters
    ----------
    out : Path
    layers : sequence of Layer
    crs : str or None
        CRS of the layers; None for a local frame in metres.
    is_projected : bool
        Whether to write the coordinates of the layers instead of WGS 84 degrees.

    Raises
    ------
    InputError
        If a position is outside the area of the CRS.
    """
    if crs is not None and not is_projected:
        layers = [_to_degrees(layer, crs, out) for layer in layers]
        member: dict[str, Any] = {}
    else:
        name = None if crs is None else {"type": "name", "properties": {"name": _urn(crs)}}
        member = {"crs": name}
    paths = [out if layer.name == "planes" else sibling_path(out, layer.name) for layer in layers]
    return {
        path: _feature_collection(layer, member) for path, layer in zip(paths, layers, strict=True)
    }


def _to_degrees(layer: Layer, crs: str, out: Path) -> Layer:
    """Return a layer in longitude and latitude. Raises InputError."""
    if not layer.shapes:
        return layer
    points = np.concatenate(layer.shapes)
    degrees = to_degrees(crs, points[:, 0], points[:, 1])
    if degrees is None:
        raise InputError(Finding("geojson.outside-area", crs=crs[:60]), file=out)
    columns = [np.round(part, _DEGREE_DECIMALS) for part in degrees]
    converted_points = np.column_stack([*columns, np.round(points[:, 2], _HEIGHT_DECIMALS)])
    ends = np.cumsum([len(shape) for shape in layer.shapes])[:-1]
    return replace(layer, shapes=np.split(converted_points, ends))


def _feature_collection(layer: Layer, crs_member: Mapping[str, Any]) -> str:
    features = [
        {
            "type": "Feature",
            "properties": {
                name: _to_plain_value(column[row]) for name, column in layer.columns.items()
            },
            "geometry": {
                "type": _GEOMETRY_TYPES[layer.kind],
                "coordinates": _coordinates(layer, shape),
            },
        }
        for row, shape in enumerate(layer.shapes)
    ]
    collection = {
        "type": "FeatureCollection",
        "name": layer.name,
        **crs_member,
        "features": features,
    }
    return json.dumps(collection, ensure_ascii=False, allow_nan=False) + "\n"


def _urn(crs: str) -> str:
    """Return the GeoJSON name of an EPSG code, or the text of any other CRS."""
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


def feature_properties(layer: Layer, row: int) -> Mapping[str, Any]:
    """Return the attributes of a feature that have a value, by name."""
    values = {name: _to_plain_value(column[row]) for name, column in layer.columns.items()}
    return {name: value for name, value in values.items() if value not in (None, "")}
