"""Depth of the surface that an orthophoto shows at a given pixel."""

from __future__ import annotations

import math

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.rays.raytree import RayTree
from vomstudio.products.ortho.tiles import TILE, Grid

_MAX_STEP = 4.0
"""Maximum depth difference between neighbours on one surface, in pixels or spacings."""


def visible_depths(
    data: Mesh | PointCloud, matrix: FloatArray, size: tuple[int, int], pixels: FloatArray
) -> FloatArray:
    """Return the depths (n,) at pixels of a picture; NaN if a pixel is empty.

    Parameters
    ----------
    data : Mesh or PointCloud
        Model, m.
    matrix : (4, 4) array
        Matrix from (column, row, depth, 1) to the frame of the model.
    size : (int, int)
        Size of the picture in pixels.
    pixels : (n, 2) array
        Column and row of each pixel.
    """
    if isinstance(data, Mesh):
        return _mesh_depths(data, matrix, pixels)
    return _cloud_depths(data, matrix, size, pixels)


def _mesh_depths(mesh: Mesh, matrix: FloatArray, pixels: FloatArray) -> FloatArray:
    direction = matrix[:3, 2]
    low, high = mesh.bounds
    corners = np.array(
        [[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    )
    min_depth = float(((corners - matrix[:3, 3]) @ direction).min()) - 1.0
    starts = matrix[:3, 3] + pixels @ matrix[:3, :2].T + min_depth * direction
    hits = RayTree(mesh).cast(starts, np.broadcast_to(direction, starts.shape))
    return np.asarray(np.where(hits.index >= 0, min_depth + hits.distance, np.nan))


def _cloud_depths(
    cloud: PointCloud, matrix: FloatArray, size: tuple[int, int], pixels: FloatArray
) -> FloatArray:
    """Return the depths in a cloud by drawing the picture again.

    A single ray could pass between points that the picture shows as a surface.
    """
    from vomstudio.io.models.opening import point_spacing
    from vomstudio.products.ortho.cloud_picture import CloudSource

    gsd = float(np.linalg.norm(matrix[:3, 0]))
    axes = np.column_stack([matrix[:3, 0] / gsd, matrix[:3, 1] / gsd, matrix[:3, 2]])
    view = (cloud.points - matrix[:3, 3]) @ axes
    spacing = point_spacing(PointCloud(view))
    if not math.isfinite(spacing) or spacing <= 0:
        spacing = gsd
    width, height = size
    grid = Grid(0.0, 0.0, gsd, width, height)
    source = CloudSource(cloud, view, grid, spacing)
    position = np.clip(np.floor(pixels).astype(np.int64), 0, [width - 1, height - 1])
    is_inside = ((pixels >= -1.0) & (pixels <= np.array(size) + 1.0)).all(axis=1)
    depths = np.full(len(pixels), np.nan)
    tile_numbers = position[:, 1] // TILE * grid.columns + position[:, 0] // TILE
    for tile in grid.tiles():
        rows = np.flatnonzero(is_inside & (tile_numbers == tile.number))
        if len(rows):
            depth = source.draw(tile).depth.astype(np.float64)
            positions = pixels[rows] - [tile.column, tile.row]
            depths[rows] = _interpolate(depth, positions, _MAX_STEP * max(gsd, spacing))
    return depths


def _interpolate(depth: FloatArray, position: FloatArray, max_step: float) -> FloatArray:
    """Interpolate depths between pixel centres on the same surface as the pixel itself."""
    height, width = depth.shape
    last_pixel = np.array([width - 1, height - 1])
    pixel = np.clip(np.floor(position).astype(np.int64), 0, last_pixel)
    pixel_depth = depth[pixel[:, 1], pixel[:, 0]]
    corner = np.floor(position - 0.5).astype(np.int64)
    fraction = position - 0.5 - corner
    weighted_sum, weight = np.zeros(len(position)), np.zeros(len(position))
    for dx in (0, 1):
        for dy in (0, 1):
            neighbour = np.clip(corner + [dx, dy], 0, last_pixel)
            value = depth[neighbour[:, 1], neighbour[:, 0]]
            corner_weight = (fraction[:, 0] if dx else 1 - fraction[:, 0]) * (
                fraction[:, 1] if dy else 1 - fraction[:, 1]
            )
            is_same_surface = np.abs(value - pixel_depth) <= max_step
            weighted_sum += np.where(is_same_surface, corner_weight * value, 0.0)
            weight += np.where(is_same_surface, corner_weight, 0.0)
    return np.where(weight > 0, weighted_sum / np.where(weight > 0, weight, 1.0), pixel_depth)
