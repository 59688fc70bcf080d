"""Export of a project's layers as shapefiles and as a CAD drawing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import UsageError
from vomstudio.core.files.atomic import atomic_group
from vomstudio.core.findings import Finding
from vomstudio.geology.map_symbols import strike_and_dip_symbol, symbol_size, trend_arrow
from vomstudio.geometry.plane_discs import disc
from vomstudio.geometry.units import WORLD_AXES, Axes
from vomstudio.io.gis import dxf, shapefile
from vomstudio.io.gis.layers import Layer
from vomstudio.io.models.writers._common import is_same_prj, prj_text
from vomstudio.project import catalogue
from vomstudio.project.records import FeatureType, Record

SHORT_NAMES = {figure.name: figure.short for figure in catalogue.ORIENTATION if figure.short}
"""Column names of the orientation table for shapefiles, with at most ten characters; in degrees."""

DISC_CORNERS = 24
_SYMBOL_LAYERS = ("planes", "lines")
_KINDS = {"line": shapefile.LINE_Z, "ring": shapefile.RING_Z}


def write_shapefiles(
    out: Path, layers: Sequence[Layer], crs: str | None, *, force: bool = False
) -> list[Path]:
    """Write one shapefile per layer, because a shapefile contains only one geometry type.

    The layer `planes` is written to `out` itself and the other layers to `NAME_layer.shp` next to
    it, either all or none. Raises UsageError for another suffix, and TargetError.
    """
    if out.suffix.lower() != ".shp":
        raise UsageError(Finding("export.not-shp"), file=out)
    # O.SHP is written as O.shp because its parts need the same name on case-sensitive file systems.
    names = [
        out.with_name(out.stem + ("" if layer.name == "planes" else f"_{layer.name}") + ".shp")
        for layer in layers
    ]
    text = None if crs is None else prj_text(crs, uses_esri_wkt=True)
    missing_prj_paths: list[Path] = []
    if crs is not None and text is not None:
        prj_paths = [name.with_suffix(".prj") for name in names]
        missing_prj_paths = [path for path in prj_paths if not is_same_prj(path, text, crs)]
    parts = [name.with_suffix(suffix) for name in names for suffix in (".shp", ".shx", ".dbf")]
    pages = [name.with_suffix(".cpg") for name in names]
    paths = [*parts, *pages, *missing_prj_paths]
    with atomic_group(paths, force) as temporaries:
        for k, layer in enumerate(layers):
            shp, shx, dbf = temporaries[3 * k : 3 * k + 3]
            columns = _columns(layer)
            if layer.kind == "point":
                points = np.concatenate(layer.shapes) if layer.shapes else np.empty((0, 3))
                blocks = [slice(0, len(points))]
                shapefile.write_points(shp, shx, dbf, points, columns, blocks)
            else:
                kind = _KINDS[layer.kind]
                shapefile.write_shapes(shp, shx, dbf, kind, layer.shapes, columns)
        remaining_paths = temporaries[len(parts) :]
        for temporary in remaining_paths[: len(pages)]:
            temporary.write_text("UTF-8", encoding="ascii")
        for temporary in remaining_paths[len(pages) :]:
            temporary.write_text(text or "", encoding="utf-8")
    return names


def _columns(layer: Layer) -> list[shapefile.DbfColumn]:
    names = shapefile.short_names(layer.columns, SHORT_NAMES)
    return [shapefile.column(names[name], values) for name, values in layer.columns.items()]


def write_dxf(
    out: Path,
    layers: Sequence[Layer],
    records: Mapping[str, Record],
    crs: str | None,
    *,
    axes: Axes = WORLD_AXES,
    force: bool = False,
) -> list[Path]:
    """Write polylines of traces and dimensions to a DXF layer for each feature type.

    Each plane and line is also written as a point and as a map symbol with its dip or plunge, and a
    plane of known extent as a disc of faces, on separate layers. Attributes are written as extended
    data of the entity. Raises TargetError.
    """
    colors = {
        record.name.casefold(): record.color
        for record in records.values()
        if isinstance(record, FeatureType)
    }
    dxf_layers = {
        (layer.name, kind): _dxf_layer(layer, kind)
        for layer in layers
        for kind in _geometry_kinds(layer)
    }
    discs = {
        dxf_layer: f"{dxf_layer}_discs"
        for (name, _), dxf_layer in dxf_layers.items()
        if name == "planes"
    }
    symbols = {
        dxf_layer: f"{kind or name}_symbols"
        for (name, kind), dxf_layer in dxf_layers.items()
        if name in _SYMBOL_LAYERS
    }
    names = dxf.layer_names([*dxf_layers.values(), *discs.values(), *symbols.values()])
    color_numbers: dict[str, int] = {}
    layer_colors = {layer.name: layer.colors_by_class(colors, "") for layer in layers}
    for (name, kind), dxf_layer in dxf_layers.items():
        color = layer_colors[name].get(kind, "")
        for label in (dxf_layer, discs.get(dxf_layer), symbols.get(dxf_layer)):
            if label is not None:
                color_numbers.setdefault(
                    names[label], dxf.color_number(color) if color else dxf.WHITE_COLOR_NUMBER
                )
    shapes = [shape for layer in layers for shape in layer.shapes]
    points = np.concatenate(shapes) if shapes else np.zeros((1, 3))
    bounds = np.stack([points.min(axis=0), points.max(axis=0)])
    size = symbol_size(points)
    prj_paths: list[Path] = []
    text = None if crs is None else prj_text(crs)
    if crs is not None and text is not None:
        prj_path = out.with_suffix(".prj")
        prj_paths = [] if is_same_prj(prj_path, text, crs) else [prj_path]
    with atomic_group([out, *prj_paths], force) as (temporary, *prj_temporaries):
        for prj_path in prj_temporaries:
            prj_path.write_text(text or "", encoding="utf-8")
        with open(temporary, "w", encoding="ascii", newline="\n") as file:
            comment = f"VOM Studio, coordinates of {crs or 'a local frame'}, {axes.unit}"
            drawing = dxf.DxfWriter(file, color_numbers, bounds, comment, is_metric=axes.metric)
            for layer in layers:
                kinds = layer.classes
                for row, shape in enumerate(layer.shapes):
                    dxf_layer = dxf_layers[layer.name, kinds[row]]
                    values = {name: column[row] for name, column in layer.columns.items()}
                    if layer.kind != "point":
                        drawing.polyline(
                            shape, names[dxf_layer], values, is_closed=layer.kind == "ring"
                        )
                        continue
                    drawing.point(shape[0], names[dxf_layer], values)
                    if dxf_layer in discs:
                        drawing.faces(_disc(shape[0], values), names[discs[dxf_layer]])
            for layer in layers:
                kinds = layer.classes
                for row, shape in enumerate(layer.shapes):
                    dxf_layer = dxf_layers[layer.name, kinds[row]]
                    if dxf_layer in symbols:
                        values = {name: column[row] for name, column in layer.columns.items()}
                        _symbol(drawing, shape[0], values, size, names[symbols[dxf_layer]])
            drawing.close()
    return [out]


def _geometry_kinds(layer: Layer) -> list[str]:
    return list(dict.fromkeys(layer.classes))


def _dxf_layer(layer: Layer, kind: str) -> str:
    """Return the name of the DXF layer for a kind of feature."""
    if layer.main:
        return kind or layer.name
    return f"{kind}_{layer.name}" if kind else layer.name


def _symbol(
    drawing: dxf.DxfWriter,
    centre: FloatArray,
    values: Mapping[str, Any],
    size: float,
    layer: str,
) -> None:
    """Draw a strike and dip symbol with the dip, or an arrow with the plunge.

    If an angle is unknown, nothing is drawn.
    """
    plane = np.isfinite(values.get("dip_deg", np.nan))
    names = ("dip_direction_deg", "dip_deg") if plane else ("trend_deg", "plunge_deg")
    azimuth, angle = (float(values.get(name, np.nan)) for name in names)
    if not np.isfinite([azimuth, angle]).all():
        return
    if plane:
        is_overturned = bool(values.get("overturned", False))
        parts, distance = (
            strike_and_dip_symbol(centre, azimuth, angle, size, is_overturned),
            0.5 * size,
        )
    else:
        parts, distance = trend_arrow(centre, azimuth, angle, size), 1.3 * size
    for part in parts:
        drawing.line(part, layer)
    azimuth_rad = np.radians(azimuth)
    offset = distance * np.array([np.sin(azimuth_rad), np.cos(azimuth_rad), 0.0])
    drawing.text(centre + offset, str(round(angle)), 0.3 * size, layer)


def _disc(centre: FloatArray, values: Mapping[str, Any]) -> FloatArray:
    """Return the faces (n, 4, 3) of a disc as wide as the feature.

    There are none if its extent is unknown.
    """
    normal = np.array([values[f"normal_{axis}"] for axis in "xyz"], np.float64)
    radius = float(values["extent_m"]) / 2
    if not (np.isfinite(normal).all() and np.isfinite(radius) and radius > 0):
        return np.empty((0, 4, 3))
    ring = disc(centre, normal, radius, DISC_CORNERS)
    next_corners = np.roll(ring, -1, axis=0)
    # One quadrilateral for every second corner, formed by the centre and three points of the ring.
    return np.stack(
        [
            np.broadcast_to(centre, ring[::2].shape),
            ring[::2],
            next_corners[::2],
            next_corners[1::2],
        ],
        axis=1,
    )
