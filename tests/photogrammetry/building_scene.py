"""A rock face with a building at several times its distance."""

from __future__ import annotations

import numpy as np

from tests.photogrammetry import rock_face
from vomstudio.core.arrays import FloatArray
from vomstudio.geometry.cameras import View

DISTANCE, FOCAL = 8.0, 1190.0


def building_scene(times: float | None, *, ground: bool) -> rock_face.Face:
    """A face of 10 x 3.4 m, a building above and beside it in the photos, and ground."""
    rough = rock_face.rough_face(10.0, 3.4, 0.015)
    parts = [rock_face.Face(rough.vertices - [0, 0, 0.8], rough.faces, rough.paint)]
    if times is not None:
        y = DISTANCE * (times - 1)
        stone = rock_face.rock_paint(3, 0.015 * times)

        def windows(points: FloatArray) -> FloatArray:
            is_glass = (points[:, 0] / times % 1.2 < 0.5) & (points[:, 2] / times % 1.4 < 0.8)
            return np.where(is_glass[:, None], 0.4, 1.0) * stone(points)

        size = 1.3 * (y + DISTANCE)
        parts.append(rock_face.wall_at(size, size / 2, (0, y, size / 4 - 2.4), 2, windows))
        if ground:
            level = rock_face.wall_at(size, y, (0, 0, 0), 2)
            x, _, z = level.vertices.T
            vertices = np.stack([x, z + y / 2 + 0.5, np.full_like(x, -2.5)], axis=1)
            parts.append(rock_face.Face(vertices, level.faces, rock_face.rock_paint(9, 0.03)))
    return rock_face.joined(*parts)


def views(count: int = 6, width: int = 1296) -> list[View]:
    """Two rows of `count` photos."""
    names = rock_face.ring_of_views(
        2,
        count,
        spread=(6.5, 1.6),
        distance=DISTANCE,
        size=(width, 2 * width // 3),
        focal=FOCAL * width / 1296,
        toward=0.6,
    )
    return [
        View(f"p{i:02d}.jpg", v.intrinsics, v.rotation, v.translation) for i, v in enumerate(names)
    ]
