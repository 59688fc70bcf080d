"""Contour lines of heights as vector data."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import Float32Array, FloatArray
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.io.gis.layer_writing import write_layer
from vomstudio.io.gis.raster import Affine

MAX_LEVELS = 2000


def contour_lines(
    heights: Float32Array, transform: Affine, spacing: float
) -> list[tuple[float, FloatArray]]:
    """Trace contour lines by linear interpolation between cell centres.

    Parameters
    ----------
    heights : (h, w) array
        Heights in metres.
    transform : Affine
        Transform from (column, row) to coordinates.
    spacing : float
        Contour interval in metres; levels are multiples of it.

    Returns
    -------
    list of (level, (k, 2) array)

    Raises
    ------
    UsageError
        If there are more than `MAX_LEVELS` levels.
    """
    is_known = np.isfinite(heights)
    if not is_known.any() or min(heights.shape) < 2:
        return []
    low, high = float(heights[is_known].min()), float(heights[is_known].max())
    if (high - low) / spacing > MAX_LEVELS:
        raise UsageError(
            Finding(
                "dem.too-many-contours", spacing_m=spacing, maximum=MAX_LEVELS, range_m=high - low
            ),
            field="--contours",
        )
    levels = np.arange(math.ceil(low / spacing), math.floor(high / spacing) + 1) * spacing
    # A level that only touches the lowest or highest cell has no contour.
    levels = levels[(levels > low) & (levels < high)]
    if not len(levels):
        return []
    from matplotlib.figure import Figure

    a, b, c, d, e, f = transform
    column, row = (np.arange(n) + 0.5 for n in heights.shape[::-1])
    # Trace relative to the corner, because map coordinates leave few digits for precision.
    contour_set = (
        Figure()
        .add_subplot()
        .contour(
            a * column, e * row, np.ma.masked_invalid(heights.astype(np.float64)), levels=levels
        )
    )
    assert b == d == 0.0
    return [
        (float(level), np.asarray(line, np.float64) + (c, f))
        for level, lines in zip(levels, contour_set.allsegs, strict=True)
        for line in lines
        if len(line) > 1
    ]


def write_contours(path: Path, lines: list[tuple[float, FloatArray]], crs: str | None) -> None:
    """Write a GeoPackage with the layer `contours`, which contains lines with heights.

    Raises
    ------
    TargetError
    """
    import shapely

    geometry = np.empty(len(lines), object)
    for k, (_, line) in enumerate(lines):
        geometry[k] = shapely.linestrings(line)
    heights = np.array([level for level, _ in lines], np.float64)
    write_layer(path, "contours", "LineString", geometry, {"height_m": heights}, crs)
