"""Local frame of a scene without position and scale."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.photogrammetry.base.scene import SparseScene

if TYPE_CHECKING:
    from vomstudio.io.photos.photo import Photo


# Up direction in the camera frame (x right, y down) for each EXIF orientation tag.
_UP_BY_ORIENTATION = {
    1: (0.0, -1.0),
    2: (0.0, -1.0),
    3: (0.0, 1.0),
    4: (0.0, 1.0),
    5: (-1.0, 0.0),
    6: (-1.0, 0.0),
    7: (1.0, 0.0),
    8: (1.0, 0.0),
}
# If the mean of the up vectors is shorter, the upper edges do not determine the vertical.
_MIN_UP_LENGTH = 0.3


def rotate_upright(scene: SparseScene, photos: Sequence[Photo]) -> SparseScene:
    """Rotate the scene upright according to its photos, and scale it for display.

    z points up, x points to the right as seen from the mean camera, and the median distance from a
    camera to its points is 10. The vertical is only accurate to a few degrees, because it assumes
    that the cameras were held level, and must not be used for measurements. `scaled` is False.
    """
    orientation = {photo.name: photo.orientation for photo in photos}
    up_vectors = np.array(
        [
            np.array([*_UP_BY_ORIENTATION[orientation.get(view.name, 1)], 0.0]) @ view.rotation
            for view in scene.views
        ]
    )
    mean_direction = np.array([view.direction for view in scene.views]).mean(axis=0)
    up = up_vectors.mean(axis=0)
    if np.linalg.norm(up) < _MIN_UP_LENGTH:
        # The camera was held in all directions, like that of a drone that looks down and rotates.
        up = -mean_direction
    up = up / np.linalg.norm(up)
    right = np.cross(mean_direction, up)
    if np.linalg.norm(right) < 1e-3:
        right = scene.views[0].rotation[0]
        right = right - up * (right @ up)
    right = right / np.linalg.norm(right)
    rotation = np.array([right, np.cross(up, right), up])
    depths = [
        float(np.median(view.depths(scene.points[point_rows])))
        for number, view in enumerate(scene.views)
        if len(point_rows := scene.observed_points(number))
    ]
    scale = 10.0 / float(np.median(depths)) if depths else 1.0
    median = np.median(scene.points, axis=0) if len(scene.points) else scene.centres.mean(axis=0)
    shift = -scale * rotation @ median
    return transform_scene(scene, scale, rotation, shift)


def transform_scene(
    scene: SparseScene, scale: float, rotation: FloatArray, translation: FloatArray
) -> SparseScene:
    """Transform the scene by x' = scale * rotation @ x + translation."""
    return replace(
        scene,
        views=tuple(view.moved(scale, rotation, translation) for view in scene.views),
        points=scale * scene.points @ rotation.T + translation,
    )
