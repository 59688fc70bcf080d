"""Pixel graph of a picture for path searches, and corridors around paths."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vomstudio.core.arrays import BoolArray, ByteArray, FloatArray
from vomstudio.extraction.surface_graph import Graph, neighbour_lists

PixelBox = tuple[slice, slice]
"""Ranges of rows and columns of a picture."""

_NEIGHBOUR_STEPS = ((0, 1), (1, 0), (1, 1), (1, -1))


def pixel_graph(picture: ByteArray, box: PixelBox, mask: BoolArray) -> Graph:
    """Build the graph of the masked pixels of a picture, each with up to eight neighbours.

    Parameters
    ----------
    picture : (h, w, 3) uint8 array
    box : PixelBox
        Part of the picture to use.
    mask : bool array
        Pixels to use, with the shape of the box.

    Returns
    -------
    Graph
        The places (n, 3) are column, row and 0; the centre of the first pixel is (0.5, 0.5).
    """
    number = np.full(mask.shape, -1, np.int64)
    rows, columns = np.nonzero(mask)
    n = len(rows)
    number[rows, columns] = np.arange(n)
    first_pixels, second_pixels = [], []
    for row_step, right in _NEIGHBOUR_STEPS:
        height, width = mask.shape
        pixel_number = number[: height - row_step, max(0, -right) : width - max(0, right)]
        neighbour = number[row_step:, max(0, right) : width + min(0, right)]
        is_edge = (pixel_number >= 0) & (neighbour >= 0)
        first_pixels.append(pixel_number[is_edge])
        second_pixels.append(neighbour[is_edge])
    starts, neighbours = neighbour_lists(
        np.concatenate(first_pixels), np.concatenate(second_pixels), n
    )
    corner = np.array([box[1].start, box[0].start]) + 0.5
    positions = np.column_stack([columns + corner[0], rows + corner[1], np.zeros(n)])
    colours = picture[box][rows, columns].astype(np.float64)
    return Graph(positions, starts, neighbours, colours, {}, lambda: np.zeros(n), np.full(n, -1))


def select_pixels_in_ellipse(
    start: FloatArray, end: FloatArray, max_distance: float, shape: Sequence[int]
) -> tuple[PixelBox, BoolArray]:
    """Select the pixels in an ellipse around two pixels.

    Parameters
    ----------
    start, end : (2,) ndarray
    max_distance : float
        Maximum sum of the distances to the two pixels.
    shape : sequence of int
        Height and width of the picture.

    Returns
    -------
    box : PixelBox
    mask : ndarray of bool
        Selected pixels of the box.
    """
    low = np.minimum(start, end) - 0.5 * max_distance
    high = np.maximum(start, end) + 0.5 * max_distance
    box = _pixel_box(low, high, shape)
    y, x = np.mgrid[box] + 0.5
    distance_sum = np.hypot(x - start[0], y - start[1]) + np.hypot(x - end[0], y - end[1])
    return box, np.asarray(distance_sum <= max_distance)


def select_pixels_along_line(
    line: FloatArray, width: float, shape: Sequence[int]
) -> tuple[PixelBox, BoolArray]:
    """Select the pixels within a distance of a line.

    Parameters
    ----------
    line : (k, 2) ndarray
    width : float
        Approximate maximum distance in pixels.
    shape : sequence of int
        Height and width of the picture.

    Returns
    -------
    box : PixelBox
    mask : ndarray of bool
        Selected pixels of the box.
    """
    import cv2

    box = _pixel_box(line.min(axis=0) - width - 1.0, line.max(axis=0) + width + 1.0, shape)
    mask = np.zeros([part.stop - part.start for part in box], np.uint8)
    vertices = np.floor(line - [box[1].start, box[0].start]).astype(np.int32)
    cv2.polylines(mask, [vertices[:, None]], False, 1, int(2 * width) + 1)
    return box, mask.astype(np.bool_)


def _pixel_box(low: FloatArray, high: FloatArray, shape: Sequence[int]) -> PixelBox:
    x0, y0 = np.clip(np.floor(low), 0, [shape[1] - 1, shape[0] - 1]).astype(int).tolist()
    x1, y1 = np.clip(np.ceil(high), 1, [shape[1], shape[0]]).astype(int).tolist()
    return slice(y0, max(y1, y0 + 1)), slice(x0, max(x1, x0 + 1))
