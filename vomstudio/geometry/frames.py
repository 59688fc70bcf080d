"""Frames of models: the integer origin that keeps drawing arrays exact."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vomstudio.errors import GeometryError

# Below this, float32 keeps better than a millimetre and the model may keep its own origin.
LARGE_COORDINATE_M = 1e4


def model_origin(bounds: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """(3,) whole-numbered origin near the centre of `bounds` (2, 3), to be taken off in float64
    before anything becomes float32.

    (0, 0, 0) where no coordinate goes beyond 1e4: a float32 has steps of 1 mm there, and of 0.5 m
    at a UTM northing. Raises GeometryError where the bounds are not finite.
    """
    box = np.asarray(bounds, np.float64)
    if box.shape != (2, 3) or not np.isfinite(box).all():
        raise GeometryError("The bounds of the model are not finite numbers.")
    if np.abs(box).max() <= LARGE_COORDINATE_M:
        return np.zeros(3)
    return np.asarray(np.rint(box[0] + (box[1] - box[0]) / 2) + 0.0)
