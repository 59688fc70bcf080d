"""Transformation of a scene to the World frame, in metres from a nearby integer origin."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.registration.similarity import Similarity


def place_in_world(
    scene: SparseScene, fit: Similarity, origin: tuple[int, int, int], crs: str | None
) -> SparseScene:
    """Transform the scene by a similarity to World coordinates minus `origin`, in metres."""
    return replace(
        scene,
        views=tuple(v.moved(fit.scale, fit.rotation, fit.translation) for v in scene.views),
        points=fit(scene.points),
        origin=origin,
        crs=crs,
        scaled=True,
    )


def integer_origin(positions: FloatArray) -> tuple[int, int, int]:
    """Return an origin near the positions, rounded down to whole hundreds of metres."""
    x, y, z = (int(math.floor(v / 100) * 100) for v in np.median(positions, axis=0))
    return x, y, z
