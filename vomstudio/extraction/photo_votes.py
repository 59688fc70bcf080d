"""What other photos of a model say of a line that was found in one of them."""

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


# A patch of so many places across, so many pixels apart, is compared around every so many-th point.
_ACROSS = 7
_APART = 2.0
_EVERY = 4
# Normalised correlation from which two photos show the same, and the grey levels of texture below
# which a patch says nothing.
_SAME = 0.5
_LEAST_TEXTURE = 2.0
_BLUR = 1.0


class Voter:
    """A photo that may see a place of the model: row `view` of the views, with its pixels."""

    def __init__(self, views: PhotoViews, view: int, picture: ByteArray) -> None:
        self._views, self._view, self._picture = views, view, picture
        self.name = views.views[view].name

    @cached_property
    def _grey(self) -> Float32Array:
        return grey(self._picture)

    def colours(self, places: FloatArray) -> tuple[FloatArray, BoolArray]:
        """(n, 3) what it shows at places (n, 3), World, and where it sees them."""
        pixels, seen = self._seen(places)
        found = np.zeros((len(places), 3))
        for c in range(3):
            found[seen, c] = sampled(self._picture[..., c], pixels[seen])
        return found, seen

    def greys(self, places: FloatArray) -> tuple[FloatArray, BoolArray]:
        """(n,) likewise, as lightness, a little blurred."""
        pixels, seen = self._seen(places)
        found = np.zeros(len(places))
        found[seen] = sampled(self._grey, pixels[seen])
        return found, seen

    def _seen(self, places: FloatArray) -> tuple[FloatArray, BoolArray]:
        pixels = np.full((len(places), 2), np.nan)
        seen: BoolArray = np.asarray(np.isfinite(places).all(axis=1))
        rows = np.flatnonzero(seen)
        if len(rows):
            pixels[rows] = self._views.pixels(self._view, places[rows])
            seen[rows] = self._views.shows(self._view, places[rows])
        return pixels, seen


def grey(picture: ByteArray) -> Float32Array:
    """(h, w) lightness of a picture (h, w, 3), a little blurred: the pixels of two photos never
    meet exactly."""
    import cv2

    light = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY).astype(np.float32)
    return np.asarray(cv2.GaussianBlur(light, (0, 0), _BLUR), np.float32)


def sampled(values: GenericArray, pixels: FloatArray) -> FloatArray:
    """(n,) values (h, w) at pixels (n, 2) on it, linearly between the pixels' middles."""
    height, width = values.shape
    x, y = np.clip(pixels - 0.5, 0.0, [width - 1.0, height - 1.0]).T
    x0, y0 = np.minimum(x.astype(np.int64), width - 2), np.minimum(y.astype(np.int64), height - 2)
    fx, fy = x - x0, y - y0
    top = values[y0, x0] * (1.0 - fx) + values[y0, x0 + 1] * fx
    low = values[y0 + 1, x0] * (1.0 - fx) + values[y0 + 1, x0 + 1] * fx
    return np.asarray(top * (1.0 - fy) + low * fy, np.float64)


def agreement(
    picture: ByteArray,
    pixels: FloatArray,
    thrown: Callable[[FloatArray], FloatArray],
    voters: Sequence[Voter],
) -> tuple[IntArray, IntArray]:
    """For each pixel (n, 2) of a line in a picture: how many voters could judge the place of the
    model under it, and how many show there what the picture does.

    The surroundings of the pixel are brought to the model and into the other photo, and compared by
    normalised correlation, which does not mind another exposure.
    """
    n = len(pixels)
    seen, same = np.zeros(n, np.int64), np.zeros(n, np.int64)
    if not voters:
        return seen, same
    asked = np.unique(np.append(np.arange(0, n, _EVERY), n - 1))
    step = _APART * (np.arange(_ACROSS) - 0.5 * (_ACROSS - 1))
    offsets = np.stack(np.meshgrid(step, step), axis=-1).reshape(-1, 2)
    patches = (pixels[asked][:, None] + offsets).reshape(-1, 2)
    height, width = picture.shape[:2]
    patches = np.clip(patches, 0.5, [width - 0.5, height - 0.5])
    places = thrown(patches)
    own = sampled(grey(picture), patches).reshape(len(asked), -1)
    judged, agreed = np.zeros(len(asked), np.int64), np.zeros(len(asked), np.int64)
    for voter in voters:
        values, there = voter.greys(places)
        whole = there.reshape(own.shape).all(axis=1)
        correlation = _correlation(own, values.reshape(own.shape))
        tells = whole & np.isfinite(correlation)
        judged += tells
        agreed += tells & (correlation >= _SAME)
    nearest = np.searchsorted(0.5 * (asked[1:] + asked[:-1]), np.arange(n))
    return judged[nearest], agreed[nearest]


def _correlation(one: FloatArray, other: FloatArray) -> FloatArray:
    """(n,) normalised correlation of rows; NaN where one of them has no texture."""
    a, b = (rows - rows.mean(axis=1, keepdims=True) for rows in (one, other))
    sizes = np.sqrt((a**2).mean(axis=1)), np.sqrt((b**2).mean(axis=1))
    flat = (sizes[0] < _LEAST_TEXTURE) | (sizes[1] < _LEAST_TEXTURE)
    product = np.where(flat, 1.0, sizes[0] * sizes[1])
    return np.where(flat, np.nan, (a * b).mean(axis=1) / product)
