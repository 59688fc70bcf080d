"""Orientation of a surface by the side from which photos show it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from vomstudio.core.arrays import BoolArray, FloatArray, Int32Array
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.photogrammetry.surface.topology import components, cross_products
from vomstudio.photogrammetry.surface.visibility import PhotoVisibility

MAX_UNSEEN_SHARE = 0.5
"""Maximum share of a surface without a photo; beyond it most of the model would be invented."""


def visible_faces(visibilities: Sequence[PhotoVisibility], count: int) -> BoolArray:
    """Return a mask (count,) of the faces that at least one photo shows from outside."""
    is_visible = np.zeros(count, bool)
    for visibility in visibilities:
        is_visible[visibility.faces] = True
    return is_visible


def orient_to_photos(
    vertices: FloatArray,
    faces: Int32Array,
    find_visibility: Callable[[Int32Array], list[PhotoVisibility]],
) -> tuple[Int32Array, list[PhotoVisibility], int]:
    """Orient faces to the side from which the photos show them.

    If more than half of the surface is not visible in any photo, it is also tested from its other
    side. Each connected piece is flipped if this makes more of its area visible.

    Parameters
    ----------
    vertices, faces : array
    find_visibility : callable
        Returns the visibility of faces (m, 3), counter-clockwise from outside.

    Returns
    -------
    faces : (m, 3) array
    visibilities : list of PhotoVisibility
    turned : int
        Number of flipped pieces.

    Raises
    ------
    GeometryError
        If more than half of the area is not visible in any photo.
    """
    areas = np.linalg.norm(cross_products(vertices, faces), axis=1)
    total_area = max(float(areas.sum()), 1e-300)
    visibilities = find_visibility(faces)
    is_visible = visible_faces(visibilities, len(faces))
    flipped_count = 0
    if areas[~is_visible].sum() > MAX_UNSEEN_SHARE * total_area:
        is_visible_from_behind = visible_faces(find_visibility(faces[:, ::-1].copy()), len(faces))
        piece = components(faces)
        gain = np.bincount(piece, areas * is_visible_from_behind) - np.bincount(
            piece, areas * is_visible
        )
        flipped_count = int((gain > 0).sum())
        if flipped_count:
            is_flipped = (gain > 0)[piece]
            faces = faces.copy()
            faces[is_flipped] = faces[is_flipped][:, ::-1]
            visibilities = find_visibility(faces)
            is_visible = visible_faces(visibilities, len(faces))
    if not is_visible.any():
        raise GeometryError(Finding("texture.no-photo-sees"))
    unseen_share = float(areas[~is_visible].sum() / total_area)
    if unseen_share > MAX_UNSEEN_SHARE:
        raise GeometryError(Finding("texture.mostly-unseen", share_percent=100 * unseen_share))
    return faces, visibilities, flipped_count
