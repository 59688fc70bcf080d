"""Removal of foreground fattening, i.e. depths of sky pixels caused by windows at edges."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import BoolArray, ByteArray

# Distance by which matching windows extend beyond an edge, pixels.
_MAX_FRINGE_WIDTH_PX = 16
_WINDOW_SIZE_PX = 5
# Limits of the standard deviation in a featureless window, in grey values of 0..255. Between them,
# the threshold is 1.5 times the deviation of the smoothest parts of the photo, which is its noise.
_MIN_DEVIATION, _MAX_DEVIATION = 2.0, 4.0
_NOISE_PERCENTILE = 2.0
_SKY_WINDOW_SIZE_PX, _MIN_SKY_SHARE = 33, 0.85
# Maximum difference in brightness between pixels at an edge and the sky.
_MAX_BRIGHTNESS_DIFFERENCE = 15.0


def find_sky_fringe(gray: ByteArray, is_valid: BoolArray, has_depth: BoolArray) -> BoolArray:
    """Find pixels that have a depth although they show sky.

    These pixels are featureless, bright and adjacent to sky without depth. A window that lies on
    the sky but contains the skyline is matched at the depth of the rock.

    Parameters
    ----------
    gray : (h, w) array
    is_valid : (h, w) array of bool
        Mask of the photo.
    has_depth : (h, w) array of bool
        Pixels with a depth.

    Returns
    -------
    (h, w) array of bool
    """
    import cv2

    gray_values = gray.astype(np.float32)
    texture_window_size = (_WINDOW_SIZE_PX, _WINDOW_SIZE_PX)
    mean = cv2.blur(gray_values, texture_window_size)
    deviation = np.sqrt(
        np.maximum(cv2.blur(gray_values * gray_values, texture_window_size) - mean * mean, 0)
    )
    noise = float(np.percentile(deviation[::3, ::3], _NOISE_PERCENTILE))
    # Rock in deep shade is also featureless, but dark.
    is_featureless = deviation < np.clip(1.5 * noise, _MIN_DEVIATION, _MAX_DEVIATION)
    is_featureless &= mean > np.median(gray[::3, ::3])
    # Mortar and plaster have gaps too, but only sky fills a complete square without depth.
    window_size = (_SKY_WINDOW_SIZE_PX, _SKY_WINDOW_SIZE_PX)
    is_open_sky = (
        cv2.blur((is_featureless & is_valid & ~has_depth).astype(np.float32), window_size)
        > _MIN_SKY_SHARE
    )
    dilated_mask = np.asarray(
        cv2.dilate(is_open_sky.astype(np.uint8), np.ones(window_size, np.uint8)), np.uint8
    )
    is_near_sky = dilated_mask & ~has_depth
    cross_kernel = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    for _ in range(_MAX_FRINGE_WIDTH_PX):
        is_near_sky = np.where(is_featureless, cv2.dilate(is_near_sky, cross_kernel), is_near_sky)
    is_fringe = np.asarray(has_depth & (is_near_sky > 0))
    if not is_fringe.any():
        return is_fringe
    sky = (is_featureless & (is_near_sky > 0)).astype(np.float32)
    window_size = (2 * _WINDOW_SIZE_PX - 1, 2 * _WINDOW_SIZE_PX - 1)
    sky_share = cv2.blur(sky, window_size)
    brightness = cv2.blur(sky * gray_values, window_size) / np.maximum(sky_share, 1e-6)
    is_like_sky = (sky_share > 1e-3) & (
        np.abs(gray_values - brightness) < _MAX_BRIGHTNESS_DIFFERENCE
    )
    return np.asarray(has_depth & ((is_near_sky > 0) | is_like_sky))
