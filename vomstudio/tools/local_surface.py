"""Resolution and outcrop normal of the surface around a measurement."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vomstudio.document.records import Point
from vomstudio.geometry.surface import Surface


def around(surface: Surface, vertices: Sequence[Point]) -> tuple[float | None, Point | None]:
    """Typical spacing of the surface around the vertices, and (3,) the outcrop's normal there; each
    None where it is not known. All in the model's file frame and unit."""
    points = np.asarray(vertices, dtype=np.float64)
    found = surface.outcrop_normal(points) if len(points) > 1 else None
    normal = None if found is None else (float(found[0]), float(found[1]), float(found[2]))
    return surface.resolution_near(points), normal
