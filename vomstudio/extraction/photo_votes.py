"""Confirmation of a followed line by other photos of the model."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.arrays import (
    BoolArray,
    ByteArray,
    Float32Array,
    FloatArray,
    GenericArray,
    IntArray,
)

if TYPE_CHECKING:
    from vomstudio.photogrammetry.inspect.photo_views import PhotoViews


# Width of a patch in samples, distance between samples in pixels, and step between tested points.
_PATCH_SAMPLES = 7
_SAMPLE_STEP_PX = 2.0
_POINT_STEP = 4
# Minimum normalised correlation of patches that agree, and minimum contrast of a patch in grey
# levels.
_MIN_CORRELATION = 0.5
_MIN_CONTRAST = 2.0
_BLUR_SIGMA_PX = 1.0


class Voter:
    """Photo, other than the followed one, that may show a given point of the model.

    Parameters
    ----------
    views : PhotoViews
    view : int
        Row of the photo in the views.
    picture : (h, w, 3) uint8 array
    """

    def __init__(self, views: PhotoViews, view: int, picture: ByteArray) -> None:
        self._views, self._view, self._picture = views, view, picture
        self.name = views.views[view].name

    @cached_property
    def _grey(self) -> Float32Array:
        return blur_lightness(self._picture)

    def colours(self, positions: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Sample the colours of the photo at given points.

        Parameters
        ----------
        positions : (n, 3) array
            Points in the World frame, m.

        Returns
        -------
        colours : (n, 3) array
        is_visible : (n,) bool array
            Whether each point is visible in the photo.
        """
        pixels, is_visible = self._project(positions)
        colours = np.zeros((len(positions), 3))
        for c in range(3):
            colours[is_visible, c] = interpolate_pixels(self._picture[..., c], pixels[is_visible])
        return colours, is_visible

    def sample_lightness(self, positions: FloatArray) -> tuple[FloatArray, BoolArray]:
        """Sample the blurred lightness (n,) at points (n, 3), and return which are visible."""
        pixels, is_visible = self._project(positions)
        values = np.zeros(len(positions))
        values[is_visible] = interpolate_pixels(self._grey, pixels[is_visible])
        return values, is_visible

    def _project(self, positions: FloatArray) -> tuple[FloatArray, BoolArray]:
        pixels = np.full((len(positions), 2), np.nan)
        is_visible: BoolArray = np.asarray(np.isfinite(positions).all(axis=1))
        rows = np.flatnonzero(is_visible)
        if len(rows):
            pixels[rows] = self._views.pixels(self._view, positions[rows])
            is_visible[rows] = self._views.shows(self._view, positions[rows])
        return pixels, is_visible


def blur_lightness(picture: ByteArray) -> Float32Array:
    """Convert a picture to slightly blurred lightness.

    The blur is required because the pixels of two photos never match exactly.

    Parameters
    ----------
    picture : (h, w, 3) ndarray of uint8

    Returns
    -------
    (h, w) ndarray of float32
    """
    import cv2

    lightness = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY).astype(np.float32)
    return np.asarray(cv2.GaussianBlur(lightness, (0, 0), _BLUR_SIGMA_PX), np.float32)


def interpolate_pixels(values: GenericArray, pixels: FloatArray) -> FloatArray:
    """Interpolate values linearly between the centres of pixels.

    Parameters
    ----------
    values : (h, w) ndarray
    pixels : (n, 2) ndarray

    Returns
    -------
    (n,) ndarray
    """
    height, width = values.shape
    x, y = np.clip(pixels - 0.5, 0.0, [width - 1.0, height - 1.0]).T
    x0, y0 = np.minimum(x.astype(np.int64), width - 2), np.minimum(y.astype(np.int64), height - 2)
    fx, fy = x - x0, y - y0
    top = values[y0, x0] * (1.0 - fx) + values[y0, x0 + 1] * fx
    low = values[y0 + 1, x0] * (1.0 - fx) + values[y0 + 1, x0 + 1] * fx
    return np.asarray(top * (1.0 - fy) + low * fy, np.float64)


def count_agreeing_photos(
    picture: ByteArray,
    pixels: FloatArray,
    project: Callable[[FloatArray], FloatArray],
    voters: Sequence[Voter],
) -> tuple[IntArray, IntArray]:
    """Count the photos that show each point of a line, and those that confirm it.

    The patch around a pixel is projected onto the model and from there into the other photo. Both
    patches are compared by normalised correlation, which is independent of the exposure. Only some
    points are tested; the others receive the counts of the nearest tested point.

    Parameters
    ----------
    picture : (h, w, 3) uint8 array
    pixels : (n, 2) array
        Line in the picture, in pixels.
    project : callable
        Function that projects pixels (k, 2) onto the model (k, 3), in the World frame.
    voters : sequence of Voter

    Returns
    -------
    visible_count, agreement_count : (n,) int arrays
    """
    n = len(pixels)
    visible_count, agreement_count = np.zeros(n, np.int64), np.zeros(n, np.int64)
    if not voters:
        return visible_count, agreement_count
    tested_rows = np.unique(np.append(np.arange(0, n, _POINT_STEP), n - 1))
    step = _SAMPLE_STEP_PX * (np.arange(_PATCH_SAMPLES) - 0.5 * (_PATCH_SAMPLES - 1))
    offsets = np.stack(np.meshgrid(step, step), axis=-1).reshape(-1, 2)
    patches = (pixels[tested_rows][:, None] + offsets).reshape(-1, 2)
    height, width = picture.shape[:2]
    patches = np.clip(patches, 0.5, [width - 0.5, height - 0.5])
    positions = project(patches)
    patch_lightness = interpolate_pixels(blur_lightness(picture), patches).reshape(
        len(tested_rows), -1
    )
    judged_count, agreeing_count = (
        np.zeros(len(tested_rows), np.int64),
        np.zeros(len(tested_rows), np.int64),
    )
    for voter in voters:
        values, is_visible = voter.sample_lightness(positions)
        is_complete = is_visible.reshape(patch_lightness.shape).all(axis=1)
        correlation = _correlation(patch_lightness, values.reshape(patch_lightness.shape))
        is_judged = is_complete & np.isfinite(correlation)
        judged_count += is_judged
        agreeing_count += is_judged & (correlation >= _MIN_CORRELATION)
    nearest_rows = np.searchsorted(0.5 * (tested_rows[1:] + tested_rows[:-1]), np.arange(n))
    return judged_count[nearest_rows], agreeing_count[nearest_rows]


def _correlation(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the normalised correlation (n,) of rows; NaN if one of them has no texture."""
    a, b = (rows - rows.mean(axis=1, keepdims=True) for rows in (first, second))
    sizes = np.sqrt((a**2).mean(axis=1)), np.sqrt((b**2).mean(axis=1))
    is_flat = (sizes[0] < _MIN_CONTRAST) | (sizes[1] < _MIN_CONTRAST)
    product = np.where(is_flat, 1.0, sizes[0] * sizes[1])
    return np.where(is_flat, np.nan, (a * b).mean(axis=1) / product)
