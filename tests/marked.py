"""Models with dots at places that are known exactly, at UTM coordinates."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Material, Mesh

UTM = np.array([576_700.0, 5_188_150.0, 160.0])
SIDE = 8
SPAN = 4.0
"""Metres: the surface lies over SPAN x SPAN in East and North."""


def height(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    # No steeper than 20 degrees: every dot is seen from a plunge of 35.
    return 0.12 * np.sin(1.7 * x) + 0.1 * np.cos(1.3 * y + 0.4) + 0.02 * x


def marked_mesh(folder: Path, texels: int = 800) -> tuple[Mesh, np.ndarray]:
    """A bumpy surface of 8 x 8 x 2 triangles with a dot in the middle of each, and where the dots
    are in World. The texture is stretched over East and North."""
    g = np.linspace(-SPAN / 2, SPAN / 2, SIDE + 1)
    x, y = np.meshgrid(g, g)
    vertices = np.stack([x, y, height(x, y)], -1).reshape(-1, 3)
    i = np.arange((SIDE + 1) ** 2).reshape(SIDE + 1, SIDE + 1)
    a, b, c, d = (k.ravel() for k in (i[:-1, :-1], i[:-1, 1:], i[1:, :-1], i[1:, 1:]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)]).astype(np.int32)
    uv = (vertices[:, :2] / SPAN + 0.5).astype(np.float32)
    dots = vertices[faces].mean(axis=1)
    image = np.zeros((texels, texels))
    for du, dv in dots[:, :2] / SPAN + 0.5:
        i, j = int(du * texels), int((1 - dv) * texels)
        part = (slice(j - 15, j + 16), slice(i - 15, i + 16))
        rows, columns = np.mgrid[part]
        away = (columns + 0.5 - du * texels) ** 2 + (rows + 0.5 - (1 - dv) * texels) ** 2
        image[part] += np.exp(-away / (2 * 3.0**2))
    path = folder / "dots.png"
    Image.fromarray(np.rint(255 * np.clip(image, 0, 1)).astype(np.uint8)).convert("RGB").save(path)
    mesh = Mesh(
        vertices + UTM,
        faces,
        (Material("dots", path),),
        np.array([0, len(faces)], np.int64),
        uv,
    )
    return mesh, dots + UTM


def marked_cloud(n: int = 160_000, seed: int = 3) -> tuple[PointCloud, np.ndarray]:
    """The same surface, smooth, as points thrown at random; and where the dots are in World."""
    rng = np.random.default_rng(seed)
    xy = rng.uniform(-SPAN / 2, SPAN / 2, (n, 2))
    g = (np.arange(6) + 0.5) / 6 * SPAN - SPAN / 2
    dots = np.stack(np.meshgrid(g, g), -1).reshape(-1, 2)
    points = np.column_stack([xy, height(*xy.T)])
    places = np.column_stack([dots, height(*dots.T)])
    away = ((points[:, None] - places[None]) ** 2).sum(axis=2).min(axis=1)
    grey = np.rint(255 * np.exp(-away / (2 * 0.05**2))).astype(np.uint8)
    return PointCloud(points + UTM, np.repeat(grey[:, None], 3, axis=1)), places + UTM


def found_dots(
    rgba: np.ndarray, pixel_to_world: np.ndarray, places: np.ndarray, radius: int
) -> tuple[np.ndarray, np.ndarray]:
    """Expected and measured (column, row) of dots: the brightness' centre of gravity around where
    each should be. pixel_to_world as in the sidecar."""
    inverse = np.linalg.inv(pixel_to_world - np.column_stack([np.zeros((4, 3)), [*UTM, 0]]))
    expected = (np.column_stack([places - UTM, np.ones(len(places))]) @ inverse.T)[:, :2]
    grey = rgba[..., 0].astype(float)
    measured = []
    for column, row in expected:
        i, j = int(column), int(row)
        part = grey[j - radius : j + radius + 1, i - radius : i + radius + 1]
        rows, columns = np.mgrid[: part.shape[0], : part.shape[1]]
        measured.append(
            (
                (part * columns).sum() / part.sum() + i - radius + 0.5,
                (part * rows).sum() / part.sum() + j - radius + 0.5,
            )
        )
    return expected, np.array(measured)
