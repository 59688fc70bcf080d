"""The plane of a followed trace."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vomstudio.geometry.planes import PlaneFit, fit_plane

Array = npt.NDArray[np.float64]


def fit_followed(points: Array) -> PlaneFit:
    """The plane through the vertices (n, 3) of a path. Raises GeometryError where there is none."""
    return fit_plane(points)
