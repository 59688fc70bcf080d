"""Which triangle a ray meets first. Every triangle is asked which of the camera's rays meet it;
rays are taken as the lens bends them, so nothing is resampled."""

from __future__ import annotations

import numba
import numpy as np
import numpy.typing as npt

from .camera import LENS, Shot, bend
from .geology import Array

Ints = npt.NDArray[np.int64]


def cast_block(
    shot: Shot, points: Array, triangles: Ints, x: Array, y: Array, first: float, samples: int
) -> tuple[Array, Ints]:
    """What is seen through part of a photo: depths along the axis, infinite where nothing is, and
    triangles.

    points (n, 3), triangles (m, 3); x, y (rows, columns): image coordinates of the rays, without
    the lens, `samples` to each pixel and direction; the block begins `first` pixels down the photo
    """
    local = (points - shot.centre) @ shot.rotation.T
    with np.errstate(divide="ignore", invalid="ignore"):
        a, b = bend(local[:, 0] / local[:, 2], local[:, 1] / local[:, 2])
    on = np.stack([LENS["fx"] * a + LENS["cx"], LENS["fy"] * b + LENS["cy"] - first], axis=-1)
    depth, triangle = np.full(x.shape, np.inf), np.full(x.shape, -1, np.int64)
    _cast(local, on * samples, triangles, x, y, depth, triangle)
    return depth, triangle


@numba.njit(cache=False)
def _cast(local, on, triangles, x, y, depth, triangle):  # type: ignore[no-untyped-def]
    rows, columns = x.shape
    for k in range(len(triangles)):
        a, b, c = triangles[k, 0], triangles[k, 1], triangles[k, 2]
        if min(local[a, 2], local[b, 2], local[c, 2]) < 0.3:
            continue
        left, right = min(on[a, 0], on[b, 0], on[c, 0]), max(on[a, 0], on[b, 0], on[c, 0])
        top, foot = min(on[a, 1], on[b, 1], on[c, 1]), max(on[a, 1], on[b, 1], on[c, 1])
        # The lens bends edges.
        spare = 2.0 + 0.03 * max(right - left, foot - top)
        i0, i1 = max(int(top - spare), 0), min(int(foot + spare) + 1, rows)
        j0, j1 = max(int(left - spare), 0), min(int(right + spare) + 1, columns)
        if i0 >= i1 or j0 >= j1:
            continue
        p, q, r = local[a], local[b], local[c]
        qr, rp, pq = np.cross(q, r), np.cross(r, p), np.cross(p, q)
        volume = p[0] * qr[0] + p[1] * qr[1] + p[2] * qr[2]
        if volume == 0.0:
            continue
        for i in range(i0, i1):
            for j in range(j0, j1):
                u, v = x[i, j], y[i, j]
                wa = (qr[0] * u + qr[1] * v + qr[2]) / volume
                wb = (rp[0] * u + rp[1] * v + rp[2]) / volume
                wc = (pq[0] * u + pq[1] * v + pq[2]) / volume
                if wa >= -1e-12 and wb >= -1e-12 and wc >= -1e-12:
                    t = 1.0 / (wa + wb + wc)
                    if 0.0 < t < depth[i, j]:
                        depth[i, j] = t
                        triangle[i, j] = k


def distance_along(points: Array, triangles: Ints, centre: Array, way: Array) -> float:
    """From the centre (3,) along a unit vector to the first triangle, m; infinite if none."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    p = np.cross(way, c - a)
    det = ((b - a) * p).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        away = centre - a
        u = (away * p).sum(axis=1) / det
        q = np.cross(away, b - a)
        v = q @ way / det
        t = ((c - a) * q).sum(axis=1) / det
    met = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0)
    return float(t[met].min(initial=np.inf))
