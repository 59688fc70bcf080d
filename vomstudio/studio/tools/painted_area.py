"""Painted parts of a model's surface for drawing."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vomstudio.core.arrays import Float32Array, FloatArray, IntArray
from vomstudio.geometry import transform
from vomstudio.geometry.brush import SelectableSurface
from vomstudio.geometry.patches import runs_to_ids
from vomstudio.project.records import Model, PaintedFeature
from vomstudio.studio.tools.interaction_types import Area

# Additional points of a cloud would only cover each other.
MAX_DOTS = 20_000
# Maximum number of selected faces that are filled, and that are drawn with a border.
MAX_FILLED_FACES = 120_000
MAX_BORDERED_FACES = 30_000


def known_ids(patch: PaintedFeature, count: int) -> IntArray:
    """Return the element indices (k,) of a patch that exist in a model of `count` elements."""
    ids = runs_to_ids(patch.runs)
    return ids[ids < count]


def local_corners(corners: FloatArray, model: Model, origin: FloatArray) -> Float32Array:
    """Transform points (k, 3) or (k, 3, 3) of a file frame to World minus `origin`."""
    rows = transform.matrix(model.to_world)
    local_origin = transform.apply(transform.invert(rows), [origin])[0]
    x, y, z = (corners.reshape(-1, 3) - local_origin).astype(np.float32).T
    local_points = np.empty((len(x), 3), np.float32)
    # Computed axis by axis, because a matrix product of many short rows takes ten times as long.
    for axis, (a, b, c) in enumerate(rows[:3, :3].astype(np.float32)):
        local_points[:, axis] = a * x + b * y + c * z
    return local_points.reshape(corners.shape)


def patch_area(patch: PaintedFeature, model: Model, surface: SelectableSurface) -> Area | None:
    """Return a patch for drawing, or None if the model has none of its elements."""
    ids = known_ids(patch, surface.count)
    if not len(ids) or surface.element != patch.element:
        return None
    border = surface.border(ids)
    if surface.element == "point":
        ring = np.array(patch.outline).reshape(-1, 3)
        border = np.stack([ring, np.roll(ring, -1, axis=0)], axis=1)
        ids = ids[:: max(1, len(ids) // MAX_DOTS)]
    corners = surface.corners(ids)
    origin = transform.apply(model.to_world, [patch.mean])[0]
    return Area(
        origin,
        local_corners(corners, model, origin),
        local_corners(border, model, origin),
    )


def merge_areas(areas: Sequence[Area]) -> Area | None:
    """Merge areas of one element type for drawing, or return None if `areas` is empty.

    Parameters
    ----------
    areas : sequence of Area

    Returns
    -------
    Area or None
    """
    if not areas:
        return None
    origin = areas[0].origin
    origin_shifts = [(area.origin - origin).astype(np.float32) for area in areas]
    return Area(
        origin,
        np.concatenate(
            [area.corners + shift for area, shift in zip(areas, origin_shifts, strict=True)]
        ),
        np.concatenate(
            [area.border + shift for area, shift in zip(areas, origin_shifts, strict=True)]
        ),
    )


def enclosed_area(ring: FloatArray, model: Model, surface: SelectableSurface) -> Area | None:
    """Return the area inside an outline (n, 3) in the file frame, without a border.

    Returns None if the area is unknown, as it is for point clouds.
    """
    corners = surface.clip_to_outline(ring)
    if corners is None or not len(corners):
        return None
    origin = transform.apply(model.to_world, [ring.mean(axis=0)])[0]
    empty_border = np.zeros((0, 2, 3), np.float32)
    return Area(origin, local_corners(corners, model, origin), empty_border)


def selection_area(ids: IntArray, model: Model, surface: SelectableSurface) -> Area:
    """Return selected faces or points for drawing; fast for any number of elements.

    More than MAX_FILLED_FACES faces are drawn as dots, and more than MAX_BORDERED_FACES faces have
    no border.
    """
    border = np.zeros((0, 2, 3))
    if surface.element == "face" and len(ids) <= MAX_BORDERED_FACES:
        border = surface.border(ids)
    if surface.element == "face" and len(ids) <= MAX_FILLED_FACES:
        corners = surface.corners(ids)
    elif surface.element == "face":
        corners = surface.corners(_thin_out(ids)).mean(axis=1)
    else:
        corners = surface.corners(_thin_out(ids))
    origin = transform.apply(model.to_world, corners.reshape(-1, 3)[:1])[0]
    return Area(origin, local_corners(corners, model, origin), local_corners(border, model, origin))


def _thin_out(ids: IntArray) -> IntArray:
    return ids[:: max(1, len(ids) // MAX_DOTS)]
