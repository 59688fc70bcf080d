"""Points of a model in the World frame."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.geometry.transform import apply


def transform_to_world(to_world: npt.ArrayLike, points: FloatArray) -> FloatArray:
    """Transform points (n, 3) to the World frame; return them unchanged for the identity.

    Raises GeometryError if the matrix is not finite or not (4, 4).
    """
    m = np.asarray(to_world, np.float64)
    if m.shape != (4, 4) or not np.isfinite(m).all():
        raise GeometryError(Finding("transform.not-a-matrix"))
    return points if np.array_equal(m, np.eye(4)) else apply(m, points)
