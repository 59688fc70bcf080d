"""The scene in World: in metres, relative to an integer origin near it."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.registration.similarity import Similarity


def moved(
    scene: SparseScene, fit: Similarity, origin: tuple[int, int, int], crs: str | None
) -> SparseScene:
    """The scene after a similarity into World minus `origin`, in metres."""
    return replace(
        scene,
        views=tuple(v.moved(fit.scale, fit.rotation, fit.translation) for v in scene.views),
        points=fit(scene.points),
        origin=origin,
        crs=crs,
        scaled=True,
    )


def integer_origin(positions: FloatArray) -> tuple[int, int, int]:
    """Whole hundreds of metres near the positions."""
    x, y, z = (int(math.floor(v / 100) * 100) for v in np.median(positions, axis=0))
    return x, y, z
