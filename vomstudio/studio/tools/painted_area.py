"""A painted piece of a model's surface as it is drawn."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import Float32Array, FloatArray, IntArray
from vomstudio.geometry import transform
from vomstudio.geometry.brush import PaintSurface
from vomstudio.geometry.patches import ids_of
from vomstudio.project.records import Model, Painted
from vomstudio.studio.tools.interaction_types import Area

# Number of points that show where a patch of a cloud is; more would only cover each other.
DOTS = 20_000
# Of what is being chosen, so many faces are drawn as such, and so many with a line around them.
MOST_FILLED = 120_000
MOST_BORDERED = 30_000


def known_ids(patch: Painted, count: int) -> IntArray:
    """(k,) indices of a patch's faces or points, without those that a model with `count` of them
    does not have."""
    ids = ids_of(patch.runs)
    return ids[ids < count]


def local_corners(corners: FloatArray, model: Model, origin: FloatArray) -> Float32Array:
    """Points (k, 3) or (k, 3, 3) of a model's file frame, in World minus `origin`."""
    rows = transform.matrix(model.to_world)
    near = transform.apply(transform.invert(rows), [origin])[0]
    x, y, z = (corners.reshape(-1, 3) - near).astype(np.float32).T
    local = np.empty((len(x), 3), np.float32)
    # Axis by axis: a matrix product of so many short rows takes ten times as long.
    for axis, (a, b, c) in enumerate(rows[:3, :3].astype(np.float32)):
        local[:, axis] = a * x + b * y + c * z
    return local.reshape(corners.shape)


def area_of(patch: Painted, model: Model, surface: PaintSurface) -> Area | None:
    """A patch as it is drawn; None where the model has none of it."""
    ids = known_ids(patch, surface.count)
    if not len(ids) or surface.element != patch.element:
        return None
    border = surface.border(ids)
    if surface.element == "point":
        ring = np.array(patch.outline).reshape(-1, 3)
        border = np.stack([ring, np.roll(ring, -1, axis=0)], axis=1)
        ids = ids[:: max(1, len(ids) // DOTS)]
    corners = surface.corners(ids)
    origin = transform.apply(model.to_world, [patch.mean])[0]
    return Area(
        origin,
        local_corners(corners, model, origin),
        local_corners(border, model, origin),
    )


def enclosed_area(ring: FloatArray, model: Model, surface: PaintSurface) -> Area | None:
    """What an outline (n, 3) in the model's file frame encloses, without a border; None where that
    is not known, as of points."""
    corners = surface.part_inside(ring)
    if corners is None or not len(corners):
        return None
    origin = transform.apply(model.to_world, [ring.mean(axis=0)])[0]
    none = np.zeros((0, 2, 3), np.float32)
    return Area(origin, local_corners(corners, model, origin), none)


def chosen_area(ids: IntArray, model: Model, surface: PaintSurface) -> Area:
    """Faces or points as they are drawn while they are being chosen: at once, however many. Of
    many faces there are dots, of all but few no border."""
    border = np.zeros((0, 2, 3))
    if surface.element == "face" and len(ids) <= MOST_BORDERED:
        border = surface.border(ids)
    if surface.element == "face" and len(ids) <= MOST_FILLED:
        corners = surface.corners(ids)
    elif surface.element == "face":
        corners = surface.corners(_some(ids)).mean(axis=1)
    else:
        corners = surface.corners(_some(ids))
    origin = transform.apply(model.to_world, corners.reshape(-1, 3)[:1])[0]
    return Area(origin, local_corners(corners, model, origin), local_corners(border, model, origin))


def _some(ids: IntArray) -> IntArray:
    return ids[:: max(1, len(ids) // DOTS)]
