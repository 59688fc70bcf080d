"""Points that fit as a mirror image, and models that a registration turns upside down.

A similarity never mirrors: of points on flat ground whose easting and northing are exchanged it
makes a model that lies on its face, which fits nearly as well as the right one.
"""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.findings import Finding
from vomstudio.registration.checks.comparison import Left, far_better, left_over
from vomstudio.registration.checks.point_order import other_order
from vomstudio.registration.observations import Points
from vomstudio.registration.similarity import fit_robustly

_BY_CHANCE = 0.001
# By so many points that miss by so much of their reach a mirror image with a wrong one is told.
_FEWEST_WITHOUT, _FITS = 7, 0.01
_FLIPPED = np.array([1.0, 1.0, -1.0])
_ON_ITS_SIDE_DEG = 90.0
# Of a model whose up nobody knows: one frame in a hundred and thirty is tipped so far by chance.
_ON_ITS_FACE_DEG = 170.0


def fits_as_mirror(model: FloatArray, world: FloatArray) -> bool:
    """Whether points of the model (n, 3) fit their coordinates (n, 3) far better as a mirror image,
    and no other order of them explains it better."""
    mirrored, given = left_over(model * _FLIPPED, world), left_over(model, world)
    if mirrored is None or given is None:
        return False
    if not far_better(mirrored, given, _BY_CHANCE):
        # A wrong point lies in both; without it the better one is the better one still.
        return mirrored.variance < given.variance and _most_fit_so(model, world, given)
    order = other_order(model, world)
    return order is None or order.left.variance > mirrored.variance


def _most_fit_so(model: FloatArray, world: FloatArray, given: Left) -> bool:
    """Whether all but a few points, which are wrong besides, fit as a mirror image."""
    n = len(model)
    reach = float(((world - world.mean(axis=0)) ** 2).sum()) / n
    if n < _FEWEST_WITHOUT or 3.0 * given.variance < _FITS**2 * reach:
        return False
    try:
        _, agree = fit_robustly(model * _FLIPPED, world)
    except GeometryError:
        return False
    if agree.all() or int((~agree).sum()) > n // 3:
        return False
    # Those that agree as a mirror image are chosen for it, and so by much less chance.
    own, mirrored = (left_over(m[agree], world[agree]) for m in (model, model * _FLIPPED))
    return far_better(mirrored, own, _BY_CHANCE**2)


def mirror_findings(points: Points | None) -> list[Finding]:
    """Return a finding if points fit much better as a mirror image."""
    if points is None or not fits_as_mirror(points.model, points.world):
        return []
    return [Finding("control.swapped-columns", labels=(), points=points.name)]


def tipping_findings(
    rotation: FloatArray, up: FloatArray | None, points: Points | None
) -> list[Finding]:
    """Return a finding if a registration turns the model upside down.

    up : (3,) up direction of the model by its file or user; None if not known, then the finding
    requires that the points do not exclude a mirror image
    """
    axis = np.array([0.0, 0.0, 1.0]) if up is None else up / np.linalg.norm(up)
    tip = float(np.degrees(np.arccos(np.clip((rotation @ axis)[2], -1.0, 1.0))))
    if up is not None:
        if tip <= _ON_ITS_SIDE_DEG:
            return []
        return [Finding("registration.upside-down", tip_deg=tip)]
    if tip <= _ON_ITS_FACE_DEG or points is None or _tell_from_mirror(points):
        return []
    return [Finding("registration.upside-down-or-mirror", tip_deg=tip)]


def _tell_from_mirror(points: Points) -> bool:
    """Whether the points fit far better than their mirror image does."""
    given = left_over(points.model, points.world)
    return far_better(given, left_over(points.model * _FLIPPED, points.world), _BY_CHANCE)
