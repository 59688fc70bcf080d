"""The points of a model in World."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vomstudio.errors import GeometryError
from vomstudio.geometry.transform import apply
from vomstudio.words import tr

Array = npt.NDArray[np.float64]


def in_world(to_world: npt.ArrayLike, points: Array) -> Array:
    m = np.asarray(to_world, np.float64)
    if m.shape != (4, 4) or not np.isfinite(m).all():
        raise GeometryError(tr("The model's transform to World is not a matrix of 4 x 4 numbers."))
    return points if np.array_equal(m, np.eye(4)) else apply(m, points)
