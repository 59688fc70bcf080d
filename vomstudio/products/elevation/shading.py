"""Dip, dip direction and shading of heights.

Gradients are computed with Horn's weights from the eight neighbours of a cell (B. K. P. Horn 1981,
Hill shading and the reflectance map, *Proceedings of the IEEE* 69, 14). They are NaN if any of the
eight is missing.
"""

from __future__ import annotations

import math

import numpy as np

from vomstudio.core.arrays import ByteArray, Float32Array, FloatArray, FloatingArray
from vomstudio.geology.orientation import normals_to_planes
from vomstudio.geometry.view_frame import ViewFrame

LIGHT_AZIMUTH_DEG = 315.0
LIGHT_ELEVATION_DEG = 45.0
BLOCK_ROWS = 512
"""Number of rows per block."""


def compute_gradients(heights: FloatingArray, gsd: float) -> tuple[FloatArray, FloatArray]:
    """Compute the rise per metre along the rows (to the right) and the columns (downwards).

    Returns
    -------
    right, down : (h, w) arrays
        Gradients; NaN at the border and next to cells without a height.
    """
    height, width = heights.shape
    right, down = np.full((height, width), np.nan), np.full((height, width), np.nan)
    if height < 3 or width < 3:
        return right, down
    z = np.asarray(heights, np.float64)
    columns = z[:-2] + 2 * z[1:-1] + z[2:]
    rows = z[:, :-2] + 2 * z[:, 1:-1] + z[:, 2:]
    is_complete = np.isfinite(columns[:, :-2] + columns[:, 1:-1] + columns[:, 2:])
    x = (columns[:, 2:] - columns[:, :-2]) / (8 * gsd)
    y = (rows[2:] - rows[:-2]) / (8 * gsd)
    right[1:-1, 1:-1] = np.where(is_complete, x, np.nan)
    down[1:-1, 1:-1] = np.where(is_complete, y, np.nan)
    return right, down


def compute_dips(
    heights: Float32Array, gsd: float, frame: ViewFrame
) -> tuple[Float32Array, Float32Array]:
    """Compute the dip and dip direction of a surface over any reference plane.

    Parameters
    ----------
    heights : (h, w) array
        Heights in metres.
    gsd : float
        Cell size, m.
    frame : ViewFrame
        View frame of the reference plane.

    Returns
    -------
    dip : (h, w) array
        Dip from the World horizontal, 0 to 90 degrees; NaN if unknown.
    dip_direction : (h, w) array
        Dip direction, 0 to 360 degrees; NaN if unknown or on a level surface.
    """
    dip, azimuth = (np.full(heights.shape, np.nan, np.float32) for _ in range(2))
    for rows, part in _strips(heights):
        right, down = (gradient[rows[1]] for gradient in compute_gradients(part, gsd))
        is_known = np.isfinite(right)
        normals = (
            -right[is_known][:, None] * frame.right
            - down[is_known][:, None] * frame.down
            - frame.direction
        )
        direction, block_dip, is_horizontal = normals_to_planes(normals)
        dip[rows[0]][is_known] = block_dip
        azimuth[rows[0]][is_known] = np.where(is_horizontal, np.nan, direction)
    return dip, azimuth


def hillshade(heights: Float32Array, gsd: float) -> ByteArray:
    """Shade heights as (h, w) uint8: 1 (dark) to 255 (facing the light), 0 if unknown.

    The light comes from the upper left of the raster, 45 degrees above its plane.
    """
    shading = np.zeros(heights.shape, np.uint8)
    azimuth, height = math.radians(LIGHT_AZIMUTH_DEG), math.radians(LIGHT_ELEVATION_DEG)
    # The components to the right, down the rows, and up from the plane.
    x, y = math.cos(height) * math.sin(azimuth), -math.cos(height) * math.cos(azimuth)
    z = math.sin(height)
    for rows, part in _strips(heights):
        right, down = (gradient[rows[1]] for gradient in compute_gradients(part, gsd))
        light = (z - right * x - down * y) / np.sqrt(1 + right**2 + down**2)
        grey = np.rint(1 + 254 * np.clip(light, 0, 1))
        shading[rows[0]] = np.where(np.isfinite(grey), grey, 0)
    return shading


def _strips(heights: Float32Array):  # type: ignore[no-untyped-def]
    """Yield the rows of each strip, and the strip extended by one row on each side."""
    for start in range(0, len(heights), BLOCK_ROWS):
        stop = min(start + BLOCK_ROWS, len(heights))
        low, high = max(start - 1, 0), min(stop + 1, len(heights))
        yield (slice(start, stop), slice(start - low, stop - low)), heights[low:high]
