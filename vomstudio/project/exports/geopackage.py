"""GeoPackage of the project's GIS layers with their styles, and a QGIS map next to it.

Planes and lines are points with attributes; traces, lineations and dimensions are 3-D lines;
patches are polygons.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Mapping, Sequence
from contextlib import closing
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import AnyArray
from vomstudio.core.errors import TargetError
from vomstudio.core.files.atomic import atomic_group
from vomstudio.core.files.names import replace_surrogates
from vomstudio.core.findings import Finding
from vomstudio.io.gis.crs import world_crs
from vomstudio.io.gis.layer_writing import write_layer
from vomstudio.io.gis.layers import Layer
from vomstudio.io.gis.qgis_project import MapLayer, qgs
from vomstudio.io.gis.qml import Style, qml
from vomstudio.project.exports.map_styles import layer_style
from vomstudio.project.records import Record
from vomstudio.project.tables.project_table import ProjectTable

_TYPES = {"point": "Point Z", "line": "LineString Z", "ring": "Polygon Z"}


_STYLES = """
CREATE TABLE layer_styles (
    id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, f_table_catalog TEXT(256),
    f_table_schema TEXT(256), f_table_name TEXT(256), f_geometry_column TEXT(256),
    styleName TEXT(30), styleQML TEXT, styleSLD TEXT, useAsDefault BOOLEAN, description TEXT,
    owner TEXT(30), ui TEXT(30),
    update_time DATETIME DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ','now'))
)"""
"""Table definition as created by QGIS."""


def write_layers(
    out: Path,
    records: Mapping[str, Record],
    table: ProjectTable,
    layers: Sequence[Layer],
    *,
    writes_map: bool = True,
    force: bool = False,
) -> list[Path]:
    """Write the layers of `project_layers` and return the written files.

    If `writes_map` is set, NAME.qgs, which QGIS opens as a map, is written next to the GeoPackage.
    Raises TargetError.
    """
    # Without a CRS, GDAL would declare east and north.
    crs = world_crs(table.crs, table.unit_m) or table.axes.wkt
    styles = [layer_style(layer, records) for layer in layers]
    paths = [out, out.with_suffix(".qgs")] if writes_map else [out]
    with atomic_group(paths, force=force) as temporary_paths:
        is_appending = False
        for layer in layers:
            write_layer(
                temporary_paths[0],
                layer.name,
                _TYPES[layer.kind],
                _geometry(layer),
                layer.columns,
                crs,
                description=table.limits.description,
                append=is_appending,
            )
            is_appending = True
        _add_styles(temporary_paths[0], [layer.name for layer in layers], styles)
        if writes_map:
            map_layers = [
                MapLayer(layer.name, style, _extent(layer))
                for layer, style in zip(layers, styles, strict=True)
                if layer.shapes
            ]
            geometry_order = ("point", "line", "ring")
            map_layers.sort(key=lambda map_layer: geometry_order.index(map_layer.style.geometry))
            temporary_paths[1].write_text(
                replace_surrogates(qgs(out.stem, out.name, map_layers, crs)), encoding="utf-8"
            )
    return paths


def _add_styles(path: Path, names: Sequence[str], styles: Sequence[Style]) -> None:
    """Write the table from which QGIS reads the styles of layers that are added to a map.

    Raises TargetError.
    """
    rows = [
        (
            "",
            "",
            name,
            "geom",
            name,
            replace_surrogates(qml(style)),
            "",
            True,
            "VOM Studio",
            "",
            None,
        )
        for name, style in zip(names, styles, strict=True)
    ]
    try:
        with closing(sqlite3.connect(path)) as file, file:
            file.execute(_STYLES)
            file.execute(
                "INSERT INTO gpkg_contents (table_name, data_type, identifier, description) "
                "VALUES ('layer_styles', 'attributes', 'layer_styles', '')"
            )
            file.executemany(
                "INSERT INTO layer_styles (f_table_catalog, f_table_schema, f_table_name, "
                "f_geometry_column, styleName, styleQML, styleSLD, useAsDefault, description, "
                "owner, ui) VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
                rows,
            )
    except sqlite3.Error as error:
        raise TargetError(Finding("output.unwritable", reason=error), file=path) from error


def _extent(layer: Layer) -> tuple[float, float, float, float]:
    points = np.concatenate(layer.shapes)[:, :2]
    (west, south), (east, north) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    return west, south, east, north


def _geometry(layer: Layer) -> AnyArray:
    import shapely

    if layer.kind == "point":
        positions = np.concatenate(layer.shapes) if layer.shapes else np.empty((0, 3))
        return np.asarray(shapely.points(positions))
    create_shapes = shapely.linestrings if layer.kind == "line" else shapely.polygons
    return np.array([create_shapes(shape) for shape in layer.shapes], dtype=object)
