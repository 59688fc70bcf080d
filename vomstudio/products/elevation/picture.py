"""Shaded picture of an elevation model for the screen, coloured by height."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import ByteArray, Float32Array
from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import require_regular_siblings
from vomstudio.core.files.untrusted.pictures import RASTER_CACHE_BYTES, check_raster
from vomstudio.core.findings import Finding
from vomstudio.products.elevation.shading import hillshade

MAX_SIDE_PX = 1400
"""Maximum length of the longer side in pixels."""
_MIN_BRIGHTNESS = 0.25


@dataclass(frozen=True, eq=False)
class ElevationPicture:
    """Picture of an elevation model.

    Parameters
    ----------
    rgba : (h, w, 4) uint8 array
        Colours; transparent in cells without a height.
    heights : (h, w) float32 array
        Heights in metres.
    step : float
        Pixel size, m.
    low, high : float
        Heights of the first and last colour, m.
    table : (256, 3) uint8 array
        Colours from `low` to `high`.
    """

    rgba: ByteArray
    heights: Float32Array
    step: float
    low: float
    high: float
    table: ByteArray


def read_picture(raster: Path, maximum: int = MAX_SIDE_PX) -> ElevationPicture:
    """Read a raster of `write_elevation`, averaged to at most `maximum` pixels per side.

    Raises
    ------
    InputError
        If the file cannot be read.
    """
    import rasterio
    from rasterio.enums import Resampling

    require_regular_siblings(raster)
    try:
        check_raster(raster)
        with (
            rasterio.Env(GDAL_CACHEMAX=RASTER_CACHE_BYTES),
            rasterio.open(raster, driver="GTiff") as file,
        ):
            reduction = max(file.width, file.height, maximum) / maximum
            size = tuple(max(1, round(length / reduction)) for length in (file.height, file.width))
            values = file.read(1, out_shape=size, resampling=Resampling.average)
            step = float(file.transform.a) * file.width / size[1]
    except (OSError, rasterio.errors.RasterioError) as error:
        raise InputError(
            Finding("file.damaged", format="GeoTIFF", reason=error), file=raster
        ) from error
    heights = np.asarray(values, np.float32)
    return colour_heights(heights, step)


def colour_heights(heights: Float32Array, step: float) -> ElevationPicture:
    """Colour and shade heights.

    Parameters
    ----------
    heights : (h, w) array
        Heights in metres; NaN outside the surface.
    step : float
        Cell size, m.
    """
    from matplotlib import colormaps

    table = colormaps["viridis"].resampled(256)(np.arange(256), bytes=True)[:, :3]
    is_known = np.isfinite(heights)
    low, high = (
        (float(function(heights[is_known])) for function in (np.min, np.max))
        if is_known.any()
        else (0.0, 0.0)
    )
    fraction = np.where(is_known, (heights - low) / max(high - low, 1e-12), 0.0)
    rgb = table[np.clip(255 * fraction, 0, 255).astype(np.uint8)].astype(np.float32)
    shade = hillshade(heights, step).astype(np.float32) / 255
    # Next to an edge the shading is unknown, so draw it as on a level surface.
    shade[shade == 0] = np.sqrt(0.5)
    rgb *= (_MIN_BRIGHTNESS + (1 - _MIN_BRIGHTNESS) * shade)[:, :, None]
    rgba = np.dstack([rgb.astype(np.uint8), np.where(is_known, 255, 0).astype(np.uint8)])
    return ElevationPicture(
        np.ascontiguousarray(rgba), heights, step, low, high, np.ascontiguousarray(table)
    )
