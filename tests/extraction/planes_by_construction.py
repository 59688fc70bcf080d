"""Clouds and meshes of planes whose attitude is known by construction."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh

Array = npt.NDArray[np.float64]


def normal_of(dip_direction: float, dip: float) -> Array:
    """Upward, World."""
    a, d = np.radians(dip_direction), np.radians(dip)
    return np.array([np.sin(a) * np.sin(d), np.cos(a) * np.sin(d), np.cos(d)])


def axes_of(dip_direction: float, dip: float) -> tuple[Array, Array]:
    """Along the strike, and down the dip."""
    a = np.radians(dip_direction)
    u = np.array([np.cos(a), -np.sin(a), 0.0])
    return u, np.cross(u, normal_of(dip_direction, dip))


def sheet(
    rng: np.random.Generator,
    attitude: tuple[float, float],
    centre: tuple[float, float, float],
    *,
    size: float = 2.0,
    count: int = 4000,
    noise: float = 0.004,
) -> Array:
    """(count, 3) points at random on a square, with Gaussian noise across it."""
    u, v = axes_of(*attitude)
    s, t = rng.uniform(-size / 2, size / 2, (2, count, 1))
    off = noise * rng.standard_normal((count, 1))
    return np.asarray(s * u + t * v + off * normal_of(*attitude) + np.asarray(centre))


def clouds_of(*parts: Array) -> tuple[PointCloud, npt.NDArray[np.int64]]:
    """The points of all parts as one cloud, and the part of each."""
    part = np.repeat(np.arange(len(parts)), [len(p) for p in parts])
    return PointCloud(np.concatenate(parts)), part


def grid_mesh(heights: Array, step: float) -> Mesh:
    """Over a grid of heights (rows along y, columns along x)."""
    rows, columns = heights.shape
    y, x = np.mgrid[0:rows, 0:columns] * step
    vertices = np.stack([x.ravel(), y.ravel(), heights.ravel()], axis=1)
    a = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).ravel()
    first = np.stack([a, a + 1, a + columns], axis=1)
    second = np.stack([a + 1, a + columns + 1, a + columns], axis=1)
    return Mesh(vertices, np.concatenate([first, second]).astype(np.int32))


def angle_deg(one: Array, other: Array) -> float:
    """Between two axes."""
    return float(np.degrees(np.arcsin(min(np.linalg.norm(np.cross(one, other)), 1.0))))
