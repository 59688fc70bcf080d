"""Selection of pixels whose centres are inside drawn shapes.

Coordinates are in pixels of the image; (0.5, 0.5) is the centre of the first pixel.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import BoolArray, FloatArray


@dataclass(frozen=True, eq=False)
class PixelArea:
    """Pixels (h, w) inside a shape, in a box whose first pixel is in column `left`, row `top`."""

    left: int
    top: int
    is_inside: BoolArray

    @property
    def window(self) -> tuple[slice, slice]:
        """Box as an index into the image."""
        height, width = self.is_inside.shape
        return slice(self.top, self.top + height), slice(self.left, self.left + width)


def polygon_area(corners: npt.ArrayLike, width: int, height: int) -> PixelArea:
    """Return the pixels whose centres are inside a polygon, by the even-odd rule.

    Parameters
    ----------
    corners : (n, 2) array_like
        Pixels.
    width, height : int
        Size of the picture.

    Returns
    -------
    PixelArea
    """
    points = np.asarray(corners, np.float64).reshape(-1, 2)
    left, top, box_width, box_height = _pixel_box(points, 0.0, width, height)
    if not box_width or not box_height or len(points) < 3:
        return PixelArea(left, top, np.zeros((box_height, box_width), np.bool_))
    # In the rows whose centres it crosses, every edge toggles all pixels to its right.
    crossings = np.zeros((box_height, box_width + 1), np.uint8)
    for (xa, ya), (xb, yb) in zip(points, np.roll(points, -1, axis=0), strict=True):
        low, up = min(ya, yb), max(ya, yb)
        first_row = max(0, int(np.ceil(low - 0.5)) - top)
        last_row = min(box_height, int(np.ceil(up - 0.5)) - top)
        if last_row <= first_row:
            continue
        rows = np.arange(first_row, last_row)
        x = xa + (rows + top + 0.5 - ya) * (xb - xa) / (yb - ya)
        columns = np.clip(np.ceil(x - 0.5).astype(np.int64) - left, 0, box_width)
        crossings[rows, columns] ^= 1
    is_inside = np.bitwise_xor.accumulate(crossings[:, :box_width], axis=1)
    return PixelArea(left, top, is_inside.astype(np.bool_))


def stroke_area(polyline: npt.ArrayLike, radius: float, width: int, height: int) -> PixelArea:
    """Return the pixels whose centres are near a polyline.

    Parameters
    ----------
    polyline : (n, 2) array_like
        Pixels.
    radius : float
        Maximum distance, pixels.
    width, height : int
        Size of the picture.

    Returns
    -------
    PixelArea
    """
    points = np.asarray(polyline, np.float64).reshape(-1, 2)
    left, top, box_width, box_height = _pixel_box(points, radius, width, height)
    is_inside = np.zeros((box_height, box_width), np.bool_)
    starts = points[:-1] if len(points) > 1 else points
    ends = points[1:] if len(points) > 1 else points
    for start, end in zip(starts, ends, strict=True):
        x0, y0, w, h = _pixel_box(np.array([start, end]), radius, width, height)
        x = np.arange(x0, x0 + w) + 0.5
        y = (np.arange(y0, y0 + h) + 0.5)[:, None]
        segments = end - start
        square = float(segments @ segments)
        fraction = (
            ((x - start[0]) * segments[0] + (y - start[1]) * segments[1]) / square
            if square
            else 0.0
        )
        fraction = np.clip(fraction, 0.0, 1.0)
        offset = (x - start[0] - fraction * segments[0]) ** 2 + (
            y - start[1] - fraction * segments[1]
        ) ** 2
        is_inside[y0 - top : y0 - top + h, x0 - left : x0 - left + w] |= offset <= radius * radius
    return PixelArea(left, top, is_inside)


def whole_area(width: int, height: int) -> PixelArea:
    """Return all pixels of a picture.

    Parameters
    ----------
    width, height : int
        Size of the picture.

    Returns
    -------
    PixelArea
    """
    return PixelArea(0, 0, np.ones((height, width), np.bool_))


@dataclass(frozen=True, eq=False)
class MaskChange:
    """Change of a mask; applying it twice restores the mask."""

    left: int
    top: int
    shape: tuple[int, int]
    bits: bytes

    @classmethod
    def of(cls, area: PixelArea, is_changed: BoolArray) -> MaskChange:
        return cls(
            area.left,
            area.top,
            is_changed.shape,
            zlib.compress(np.packbits(is_changed).tobytes(), 1),
        )

    def toggle(self, is_used: BoolArray) -> None:
        height, width = self.shape
        bits = np.frombuffer(zlib.decompress(self.bits), np.uint8)
        is_changed = (
            np.unpackbits(bits, count=height * width).reshape(height, width).astype(np.bool_)
        )
        is_used[self.top : self.top + height, self.left : self.left + width] ^= is_changed


def draw_area(is_used: BoolArray, area: PixelArea, is_masking: bool) -> MaskChange | None:
    """Draw a shape into a mask.

    Parameters
    ----------
    is_used : (height, width) ndarray of bool
        Mask; changed in place.
    area : PixelArea
    is_masking : bool
        Whether the pixels of the shape are excluded instead of included.

    Returns
    -------
    MaskChange or None
        Change, or None if no pixel changed.
    """
    region = is_used[area.window]
    is_changed = area.is_inside & (region if is_masking else ~region)
    if not is_changed.any():
        return None
    region ^= is_changed
    return MaskChange.of(area, is_changed)


def _pixel_box(
    points: FloatArray, margin: float, width: int, height: int
) -> tuple[int, int, int, int]:
    """Return left, top, width and height of the pixels around points, within the picture."""
    if not len(points):
        return 0, 0, 0, 0
    low_pixel = np.floor(points.min(axis=0) - margin).astype(np.int64)
    high_pixel = np.ceil(points.max(axis=0) + margin).astype(np.int64)
    left, top = (int(v) for v in np.clip(low_pixel, 0, (width, height)))
    right, bottom = (int(v) for v in np.clip(high_pixel, 0, (width, height)))
    return left, top, max(right - left, 0), max(bottom - top, 0)
