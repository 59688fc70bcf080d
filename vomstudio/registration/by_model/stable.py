"""Selection of the stable part of a reference by a mask."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.io.gate.drawn_layers import extract_area, read_raw_areas
from vomstudio.io.gate.points import ModelFrame

POLYGON_SUFFIXES = (".geojson", ".json", ".gpkg", ".shp", ".kml")
MAX_DISTANCE_SPACINGS = 3.0
"""Distance to a mask cloud, in spacings of the mask, within which reference points are stable."""


def find_near_cloud(
    points: FloatArray, mask: FloatArray, spacing: float
) -> tuple[BoolArray, float]:
    """Find the points near a mask cloud.

    Parameters
    ----------
    points : (n, 3) array
    mask : (m, 3) array
    spacing : float
        Point spacing of the mask.

    Returns
    -------
    near : (n,) array of bool
        Whether a point is within `MAX_DISTANCE_SPACINGS` spacings of the mask.
    distance : float
        Distance that equals `MAX_DISTANCE_SPACINGS` spacings.
    """
    max_distance = MAX_DISTANCE_SPACINGS * spacing
    return find_near_positions(points, mask, max_distance), max_distance


def find_near_positions(
    points: FloatArray, positions: FloatArray, max_distance: float
) -> BoolArray:
    """Find the points near the given positions.

    Parameters
    ----------
    points : (n, 3) ndarray
    positions : (m, 3) ndarray
    max_distance : float
        Maximum distance.

    Returns
    -------
    (n,) ndarray of bool
    """
    from scipy.spatial import cKDTree

    origin = points.mean(axis=0)
    distance, _ = cKDTree(positions - origin).query(
        points - origin, distance_upper_bound=max_distance, workers=-1
    )
    return np.asarray(np.isfinite(distance), np.bool_)


def find_inside_polygons(
    points: FloatArray, path: Path, crs: str | None = None, progress: Progress | None = None
) -> tuple[BoolArray, tuple[Finding, ...]]:
    """Find the points inside the polygons of a layer, seen from above.

    Parameters
    ----------
    points : (n, 3) float64
        Points in the World frame.
    path : Path
        Layer of polygons, which is converted to `crs`.
    crs : str or None
        CRS of the points.
    progress : Progress, optional

    Returns
    -------
    inside : (n,) bool
    findings : tuple of Finding
        Findings about the frame and the shapes of the layer.

    Raises
    ------
    InputError, UsageError
        Under the conditions of `read_raw_areas` and `extract_area`.
    """
    import shapely

    area, layer = extract_area(read_raw_areas(path, None, progress, model=ModelFrame(crs)))
    shapely.prepare(area)
    is_inside = np.asarray(shapely.contains_xy(area, points[:, 0], points[:, 1]), np.bool_)
    return is_inside, layer.warnings
