"""The project's GIS layers: planes and lines as points with their figures, traces, lineations and
dimensions as lines in 3-D, patches as polygons."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.document.measurement_cache import Measurements
from vomstudio.document.records import Record
from vomstudio.files.atomic import atomic_write
from vomstudio.io.gis.crs import world_crs
from vomstudio.io.gis.layer_writing import write_layer
from vomstudio.tables.project_layers import Layer, project_layers
from vomstudio.tables.project_table import ProjectTable

_TYPES = {"point": "Point Z", "line": "LineString Z", "ring": "Polygon Z"}


def write_layers(
    out: Path,
    records: Mapping[str, Record],
    table: ProjectTable,
    measurements: Measurements,
    *,
    force: bool = False,
) -> None:
    """Layers in World coordinates, as `project_layers` has them. Raises TargetError."""
    # Without a CRS, GDAL would say East and North.
    crs = world_crs(table.crs, table.unit_m) or table.axes.wkt
    with atomic_write(out, force=force) as part:
        append = False
        for layer in project_layers(records, table, measurements):
            write_layer(
                part, layer.name, _TYPES[layer.kind], _geometry(layer), layer.columns, crs,
                described=table.limits.in_words, append=append,
            )  # fmt: skip
            append = True


def _geometry(layer: Layer) -> npt.NDArray[Any]:
    import shapely

    if layer.kind == "point":
        places = np.concatenate(layer.shapes) if layer.shapes else np.empty((0, 3))
        return np.asarray(shapely.points(places))
    make = shapely.linestrings if layer.kind == "line" else shapely.polygons
    return np.array([make(shape) for shape in layer.shapes], dtype=object)
