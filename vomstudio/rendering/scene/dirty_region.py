"""Part of the picture affected by a change, and the features visible in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.rendering.view.camera import Eye


@dataclass(frozen=True)
class PixelRegion:
    """Rectangle of device pixels, measured from the lower-left corner of the picture.

    The edges are the first and last column and row, inclusive.
    """

    left: int
    bottom: int
    right: int
    top: int

    @property
    def size(self) -> tuple[int, int]:
        return self.right - self.left + 1, self.top - self.bottom + 1

    def enlarged(self, margin: int) -> PixelRegion:
        """Return the rectangle enlarged by a margin in pixels on each side."""
        return PixelRegion(
            self.left - margin, self.bottom - margin, self.right + margin, self.top + margin
        )

    def clip_to(self, size: tuple[int, int]) -> PixelRegion:
        """Return the part inside a picture, or at least one pixel at the picture's edge."""
        (left, right), (bottom, top) = (
            np.clip((low, high), 0, end - 1).tolist()
            for low, high, end in (
                (self.left, self.right, size[0]),
                (self.bottom, self.top, size[1]),
            )
        )
        return PixelRegion(left, bottom, right, top)


def find_dirty_region(points: FloatArray, eye: Eye, size: tuple[int, int]) -> PixelRegion | None:
    """Return the part of the picture in which lines between points (n, 3) may be visible.

    Points are in the World frame. The result is None if there are no points, or if the lines may be
    anywhere because points are behind the viewer or not finite. The rectangle may be outside the
    picture.
    """
    offset = points - eye.position
    depth = offset @ eye.direction
    if not len(points) or not np.isfinite(depth).all():
        return None
    if not eye.orthographic and depth.min() <= eye.near:
        return None
    half_height = eye.half_height * (1.0 if eye.orthographic else depth)
    width, height = size
    columns = width / 2.0 + offset @ eye.right / half_height * height / 2.0
    rows = height / 2.0 + offset @ eye.up / half_height * height / 2.0
    margin = 16.0 * max(size)
    (left, right), (bottom, top) = (
        (
            int(np.floor(np.clip(v.min(), -margin, margin))),
            int(np.ceil(np.clip(v.max(), -margin, margin))),
        )
        for v in (columns, rows)
    )
    return PixelRegion(left, bottom, right, top)


def visible_in_region(
    region: PixelRegion, boxes: FloatArray, eye: Eye, size: tuple[int, int]
) -> BoolArray:
    """Return whether World boxes (n, 2, 3) may be visible in a rectangle.

    The result is true for all visible boxes and for a few that are not visible. It is false for
    a box of NaN.
    """
    width, height = size
    centre = boxes.mean(axis=1) - eye.position
    max_distance = (boxes[:, 1] - boxes[:, 0]) / 2.0
    is_visible = np.ones(len(boxes), np.bool_)
    for axis, first_pixel, last_pixel, midpoint in (
        (eye.right, region.left, region.right + 1, width / 2.0),
        (eye.up, region.bottom, region.top + 1, height / 2.0),
    ):
        for sign, limit in ((1.0, first_pixel), (-1.0, last_pixel)):
            # Plane that contains an edge of the rectangle and the eye (or the view direction).
            offset = (limit - midpoint) * eye.half_height
            normal, shift = sign * height / 2.0 * axis, 0.0
            if eye.orthographic:
                shift = -sign * offset
            else:
                normal = normal - sign * offset * eye.direction
            is_visible &= centre @ normal + max_distance @ np.abs(normal) + shift >= 0.0
    return is_visible
