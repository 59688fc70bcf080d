"""The heights of a grid's cells, tile by tile."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import Float32Array, FloatArray, Int32Array
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, Silent
from vomstudio.core.words import tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.kernels.jit import for_kernels
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.rays.raycast import cast_grid
from vomstudio.products.elevation.cloud_surface import (
    interpolated,
    longest_side,
    thinned,
    top_sheet,
)
from vomstudio.products.elevation.planning import HeightPlan
from vomstudio.products.ortho.drawn_tiles import drawn_tiles
from vomstudio.products.ortho.tiles import Drawer, Grid, Members, Tile

TILE_POINTS = 500_000
"""From more points in a tile one for each cell is taken, the mean of those in it."""


def draw_heights(
    data: Mesh | PointCloud,
    plan: HeightPlan,
    limit: float | None = None,
    progress: Progress | None = None,
    threads: int | None = None,
) -> tuple[Float32Array, float | None]:
    """(h, w) float32 metres along the upward normal of the plane of reference, NaN where there is
    no surface; and the longest side of triangles between points, None for a mesh.

    Each cell has the height of the surface at its centre, of several sheets that of the farthest
    along the normal. limit : the longest side, for a cloud. Raises UsageError for a limit with a
    mesh, InputError for a cloud that spans no surface, Cancelled.
    """
    if limit is not None and isinstance(data, Mesh):
        raise UsageError(Finding("option.clouds-only", option="--limit"), field="--limit")
    progress = progress or Silent()
    progress.stage(tr("Preparing the model"))
    source: Drawer[FloatArray]
    if isinstance(data, Mesh):
        source, used = MeshHeights(plan.points, data.faces, plan.grid), None
    else:
        usual = longest_side(plan.points[:, :2])
        used = usual if limit is None else limit
        source = CloudHeights(plan.points, used, plan.grid)
    grid = plan.grid
    found = np.full((grid.height, grid.width), np.nan, np.float32)
    level = plan.height_at_reference
    for tile, depth in drawn_tiles(source, grid, progress, threads):
        rows, columns = slice(tile.row, tile.row + tile.height), slice(tile.column, None)
        found[rows, columns][:, : tile.width] = level - depth
    return found, used


class MeshHeights:
    """Draws depths of a mesh, NaN where there is none."""

    def __init__(self, view: FloatArray, faces: Int32Array, grid: Grid) -> None:
        """view : (n, 3) vertices in the axes of the frame."""
        from vomstudio.products.ortho._mesh_kernels import bin_faces

        self._view = np.ascontiguousarray(view)
        self._faces = for_kernels(faces, np.int32)
        self._grid = grid
        g = grid.gsd
        self._members = Members.of(bin_faces, self._view, self._faces, grid, g)

    def draw(self, tile: Tile) -> FloatArray:
        chosen = self._members.in_tile(tile)
        return _cast(self._view, self._faces, chosen, self._grid, tile)


class CloudHeights:
    """Draws depths of a cloud, NaN where there is none: of each tile with what lies within the
    longest side of it."""

    def __init__(self, view: FloatArray, limit: float, grid: Grid) -> None:
        from vomstudio.products.ortho._splat_kernels import bin_points

        self._view = np.ascontiguousarray(view)
        self._limit, self._grid = limit, grid
        g = grid.gsd
        reach = np.zeros(len(view))
        self._members = Members.of(bin_points, self._view, reach, grid, limit + g)

    def draw(self, tile: Tile) -> FloatArray:
        chosen = self._members.in_tile(tile)
        points = self._view[chosen]
        if len(points) > TILE_POINTS:
            points = thinned(points, self._grid.gsd)
        if len(points) < 3:
            return np.full((tile.height, tile.width), np.nan)
        return interpolated(top_sheet(points), self._limit, self._grid, tile)


def _cast(
    view: FloatArray,
    faces: Int32Array,
    chosen: Int32Array,
    grid: Grid,
    tile: Tile,
) -> FloatArray:
    if not len(chosen):
        return np.full((tile.height, tile.width), np.nan)
    g = grid.gsd
    depth = cast_grid(
        view,
        faces,
        chosen,
        left=grid.left + tile.column * g,
        top=grid.top + tile.row * g,
        step=g,
        width=tile.width,
        height=tile.height,
    ).depth
    return np.where(np.isfinite(depth), depth, np.nan)
