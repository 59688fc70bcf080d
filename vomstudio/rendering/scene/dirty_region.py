"""The spot of the picture that a change touches, and what else is seen in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray
from vomstudio.rendering.view.camera import Eye


@dataclass(frozen=True)
class Spot:
    """A rectangle of pixels of the device, from the lower left corner of the picture: the first
    column and row, and the last ones."""

    left: int
    bottom: int
    right: int
    top: int

    @property
    def size(self) -> tuple[int, int]:
        return self.right - self.left + 1, self.top - self.bottom + 1

    def wider(self, margin: int) -> Spot:
        """With so many more pixels on each side."""
        return Spot(
            self.left - margin, self.bottom - margin, self.right + margin, self.top + margin
        )

    def within(self, size: tuple[int, int]) -> Spot:
        """As much of it as lies in a picture; one pixel at its edge where nothing does."""
        (left, right), (bottom, top) = (
            np.clip((low, high), 0, end - 1).tolist()
            for low, high, end in (
                (self.left, self.right, size[0]),
                (self.bottom, self.top, size[1]),
            )
        )
        return Spot(left, bottom, right, top)


def spot_of(points: FloatArray, eye: Eye, size: tuple[int, int]) -> Spot | None:
    """Where the lines between World points (n, 3) may be seen, which need not be in the picture;
    None where they may be anywhere, since some lie behind the viewer."""
    off = points - eye.position
    depth = off @ eye.direction
    if not len(points) or not np.isfinite(depth).all():
        return None
    if not eye.orthographic and depth.min() <= eye.near:
        return None
    half = eye.half_height * (1.0 if eye.orthographic else depth)
    width, height = size
    columns = width / 2.0 + off @ eye.right / half * height / 2.0
    rows = height / 2.0 + off @ eye.up / half * height / 2.0
    far = 16.0 * max(size)
    (left, right), (bottom, top) = (
        (int(np.floor(np.clip(v.min(), -far, far))), int(np.ceil(np.clip(v.max(), -far, far))))
        for v in (columns, rows)
    )
    return Spot(left, bottom, right, top)


def seen_in(spot: Spot, boxes: FloatArray, eye: Eye, size: tuple[int, int]) -> BoolArray:
    """Whether boxes (n, 2, 3), lowest and highest corner in World, may be seen in a spot: true of
    all that are, and of a few that are not. False for a box of NaN."""
    width, height = size
    centre = boxes.mean(axis=1) - eye.position
    reach = (boxes[:, 1] - boxes[:, 0]) / 2.0
    seen = np.ones(len(boxes), np.bool_)
    for axis, first, last, middle in (
        (eye.right, spot.left, spot.right + 1, width / 2.0),
        (eye.up, spot.bottom, spot.top + 1, height / 2.0),
    ):
        for sign, limit in ((1.0, first), (-1.0, last)):
            # The plane through the eye, or along the view, that an edge of the spot lies in.
            off = (limit - middle) * eye.half_height
            normal, shift = sign * height / 2.0 * axis, 0.0
            if eye.orthographic:
                shift = -sign * off
            else:
                normal = normal - sign * off * eye.direction
            seen &= centre @ normal + reach @ np.abs(normal) + shift >= 0.0
    return seen
