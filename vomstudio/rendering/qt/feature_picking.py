"""Picking of features at a pixel."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.rendering.view.camera import Camera
from vomstudio.rendering.view.drawing import FeatureDrawing

PICK_DISTANCE_PIXELS = 7.0


def feature_at(
    shown_feature_drawings: Sequence[FeatureDrawing],
    x: float,
    y: float,
    camera: Camera,
    extent: tuple[float, float],
    *,
    include_discs: bool = True,
) -> str | None:
    """Return the id of the feature with the nearest line, or else the front-most disc.

    The result is None if no line is near the pixel and no disc contains it. `extent` is the size of
    the picture.
    """
    lines = [d for d in shown_feature_drawings if len(d.line) >= 2]
    if lines:
        sizes = [len(d.line) for d in lines]
        pixels, _ = camera.project(
            np.concatenate([np.asarray(d.line, float) for d in lines]), extent
        )
        owner = np.repeat(np.arange(len(lines)), sizes)
        a, b = pixels[:-1], pixels[1:]
        ab = b - a
        with np.errstate(invalid="ignore", divide="ignore"):
            t = np.einsum("ij,ij->i", np.array([x, y]) - a, ab) / np.einsum("ij,ij->i", ab, ab)
            t = np.clip(np.nan_to_num(t), 0.0, 1.0)
            distance = np.hypot(*(a + t[:, None] * ab - np.array([x, y])).T)
        distance[(owner[:-1] != owner[1:]) | ~np.isfinite(distance)] = np.inf
        if len(distance) and distance.min() <= PICK_DISTANCE_PIXELS:
            return lines[int(owner[int(np.argmin(distance))])].id
    best_distance, feature_id = np.inf, None
    for d in shown_feature_drawings if include_discs else ():
        if d.disc is None:
            continue
        ring, depth = camera.project(np.asarray(d.disc, float), extent)
        if (
            np.isfinite(ring).all()
            and is_inside_convex(ring, x, y)
            and depth.mean() < best_distance
        ):
            best_distance, feature_id = float(depth.mean()), d.id
    return feature_id


def is_inside_convex(ring: FloatArray, x: float, y: float) -> bool:
    """Return whether a pixel lies inside a convex ring (n, 2) of any orientation."""
    a, b = ring, np.roll(ring, -1, axis=0)
    cross_products = (b[:, 0] - a[:, 0]) * (y - a[:, 1]) - (b[:, 1] - a[:, 1]) * (x - a[:, 0])
    return bool((cross_products >= 0.0).all() or (cross_products <= 0.0).all())
