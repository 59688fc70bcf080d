"""The part of a reference that has stayed where it was, by a mask."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.errors import InputError
from vomstudio.io.gis.layer_reading import names_no_crs
from vomstudio.io.gis.vector_layers import VectorLayer, read_layers
from vomstudio.progress import Progress
from vomstudio.words import tr

Array = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

POLYGONS = (".geojson", ".json", ".gpkg", ".shp", ".kml")
REACH = 3.0
"""Of the spacing of a cloud that is a mask: points of the reference this near to it are stable."""


def near_cloud(points: Array, mask: Array, spacing: float) -> tuple[Flags, float]:
    """(n,) which of the points (n, 3) lie within REACH spacings of those of a mask (m, 3), and that
    distance."""
    reach = REACH * spacing
    return near_places(points, mask, reach), reach


def near_places(points: Array, places: Array, reach: float) -> Flags:
    """(n,) which of the points (n, 3) lie within `reach` of one of the places (m, 3)."""
    from scipy.spatial import cKDTree

    origin = points.mean(axis=0)
    distance, _ = cKDTree(places - origin).query(
        points - origin, distance_upper_bound=reach, workers=-1
    )  # fmt: skip
    return np.asarray(np.isfinite(distance), np.bool_)


def in_polygons(
    points: Array, path: Path, progress: Progress | None = None
) -> tuple[Flags, str | None]:
    """(n,) which of the points (n, 3) lie inside polygons of a layer, seen from above; and the CRS
    that the layer states. Raises InputError where it cannot be read or has none."""
    import shapely

    layer = next(
        iter(read_layers(path, [None], (), lambda: _unreadable(path), progress)),
        VectorLayer("", None),
    )
    try:
        shapes = shapely.from_wkb([] if layer.shapes is None else layer.shapes)
    except shapely.GEOSException as error:
        raise _unreadable(path) from error
    found = [shape for shape in shapes if _is_area(shape)]
    if not found:
        raise InputError(
            tr("The mask holds no polygon. Draw one around what has stayed where it was."),
            file=path,
            field="--stable",
        )
    area = shapely.union_all([shapely.make_valid(shape) for shape in found])
    shapely.prepare(area)
    return np.asarray(shapely.contains_xy(area, points[:, 0], points[:, 1]), np.bool_), (
        None if names_no_crs(path) else layer.crs
    )


def _unreadable(path: Path) -> InputError:
    return InputError(
        tr("The mask cannot be read as a layer of polygons. Save it as GeoJSON or GeoPackage."),
        file=path,
        field="--stable",
    )


def _is_area(shape: Any) -> bool:
    return shape is not None and shape.geom_type in ("Polygon", "MultiPolygon")
