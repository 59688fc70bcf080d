"""Which side of a surface is outside: the one from which the photos saw it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, Int32Array
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.photogrammetry.surface.topology import components, cross_products
from vomstudio.photogrammetry.surface.visibility import PhotoVisibility

MOST_UNSEEN = 0.5
"""Share of a surface that may be in no photo. Beyond it most of the model would be invented."""


def seen_faces(visible: Sequence[PhotoVisibility], count: int) -> BoolArray:
    """(count,) which faces at least one photo sees from their outer side."""
    seen = np.zeros(count, bool)
    for one in visible:
        seen[one.faces] = True
    return seen


def facing_photos(
    vertices: FloatArray, faces: Int32Array, look: Callable[[Int32Array], list[PhotoVisibility]]
) -> tuple[Int32Array, list[PhotoVisibility], int]:
    """The faces with the sides outside from which the photos see them.

    look : what the photos see of faces (m, 3), counter-clockwise from outside

    A surface of which more than half is in no photo is looked at from its other side too, and
    each connected piece is turned over where more of its area is seen so. Returns the faces, what
    the photos see of them, and how many pieces were turned. Raises GeometryError where more than
    half of the area stays in no photo, or all of it.
    """
    area = np.linalg.norm(cross_products(vertices, faces), axis=1)
    whole = max(float(area.sum()), 1e-300)
    visible = look(faces)
    seen = seen_faces(visible, len(faces))
    turned = 0
    if area[~seen].sum() > MOST_UNSEEN * whole:
        seen_behind = seen_faces(look(faces[:, ::-1].copy()), len(faces))
        piece = components(faces)
        gain = np.bincount(piece, area * seen_behind) - np.bincount(piece, area * seen)
        turned = int((gain > 0).sum())
        if turned:
            over = (gain > 0)[piece]
            faces = faces.copy()
            faces[over] = faces[over][:, ::-1]
            visible = look(faces)
            seen = seen_faces(visible, len(faces))
    if not seen.any():
        raise GeometryError(Finding("texture.no-photo-sees"))
    unseen = float(area[~seen].sum() / whole)
    if unseen > MOST_UNSEEN:
        raise GeometryError(Finding("texture.mostly-unseen", share_percent=100 * unseen))
    return faces, visible, turned
