"""A block photographed all around: its truth, and what exact depth maps say of it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tests.photogrammetry import rock_face as rock
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.photogrammetry.dense.depthmaps import DepthMap

SIZE = (2.0, 1.4, 1.0)
LENS = Intrinsics.pinhole(150, 120, 170.0, 75.0, 60.0)


def block() -> rock.Face:
    """A box about the origin with rounded edges, painted in noise; its bottom is closed."""
    n = 48
    polar = np.linspace(0.0, np.pi, n)
    turn = np.linspace(-np.pi, np.pi, 2 * n, endpoint=False)
    t, p = np.meshgrid(polar, turn, indexing="ij")
    way = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], -1).reshape(-1, 3)
    # A superellipsoid: sum of the sixth powers is 1.
    half = np.array(SIZE) / 2
    reach = ((np.abs(way / half) ** 6).sum(axis=1)) ** (-1 / 6)
    rows, columns = np.meshgrid(np.arange(n - 1), np.arange(2 * n), indexing="ij")
    a = (rows * 2 * n + columns).ravel()
    b = (rows * 2 * n + (columns + 1) % (2 * n)).ravel()
    c, d = a + 2 * n, b + 2 * n
    faces = np.concatenate([np.stack([a, c, b], 1), np.stack([b, c, d], 1)]).astype(np.int32)
    return rock.Face(way * reach[:, None], faces, rock.rock_paint(3, finest=0.05))


def cameras(count: int = 12) -> list[View]:
    """Two rings about the block, one from above and one from below."""
    views = []
    for ring, height in enumerate((1.6, -1.6)):
        for i in range(count):
            a = 2 * np.pi * (i + 0.5 * ring) / count
            place = (3.0 * np.cos(a), 3.0 * np.sin(a), height)
            views.append(rock.looking(f"{ring}-{i:02d}.png", LENS, place, (0, 0, 0)))
    return views


def exact_map(face: rock.Face, view: View) -> DepthMap:
    """The true depth map and normals of a view, 0 where it sees past the block."""
    lens = view.intrinsics
    x, y = np.meshgrid(np.arange(lens.width) + 0.5, np.arange(lens.height) + 0.5)
    rays = lens.rays(np.stack([x, y], axis=-1).reshape(-1, 2)) @ view.rotation
    reach, normals = face.hits(view.centre, rays)
    hit = np.isfinite(reach)
    normals = normals * -np.sign((normals * rays).sum(axis=1, keepdims=True))
    depth = np.where(hit, reach, 0.0).reshape(x.shape).astype(np.float32)
    seen = np.where(hit[:, None], normals @ view.rotation.T, 0.0)
    confidence: npt.NDArray[np.uint8] = np.where(depth > 0, 200, 0).astype(np.uint8)
    return DepthMap(
        view.name, view, depth, seen.reshape(*x.shape, 3).astype(np.float32), confidence
    )
