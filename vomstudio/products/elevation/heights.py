"""Computation of the heights of grid cells, tile by tile."""

from __future__ import annotations

import numpy as np

from vomstudio.core.arrays import Float32Array, FloatArray, Int32Array
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.words import tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.kernels.jit import to_kernel_array
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.rays.raycast import cast_grid
from vomstudio.products.elevation.cloud_surface import (
    average_top_points,
    default_side_limit,
    extract_top_sheet,
    interpolate_tile,
)
from vomstudio.products.elevation.planning import HeightPlan
from vomstudio.products.ortho.drawn_tiles import draw_tiles
from vomstudio.products.ortho.tiles import Drawer, Grid, Members, Tile

TILE_POINTS = 500_000
"""Maximum number of points per tile before they are averaged per cell."""


def compute_heights(
    data: Mesh | PointCloud,
    plan: HeightPlan,
    limit: float | None = None,
    progress: Progress | None = None,
    threads: int | None = None,
) -> tuple[Float32Array, float | None]:
    """Compute the heights of a grid.

    The height of a cell is that of the surface at its centre. If there are several sheets, it is
    that of the sheet farthest along the normal.

    Parameters
    ----------
    data : Mesh or PointCloud
    plan : HeightPlan
    limit : float, optional
        Maximum side of a triangle between the points of a cloud, m.
    progress : Progress, optional
    threads : int, optional

    Returns
    -------
    heights : (h, w) float32 array
        Heights along the upward normal of the reference plane, m; NaN outside the surface.
    limit : float or None
        Maximum side used; None for a mesh.

    Raises
    ------
    UsageError
        If a limit is given for a mesh.
    InputError
        If a cloud does not form a surface.
    Cancelled
    """
    if limit is not None and isinstance(data, Mesh):
        raise UsageError(Finding("option.clouds-only", option="--limit"), field="--limit")
    progress = progress or SilentProgress()
    progress.stage(tr("Preparing the model"))
    source: Drawer[FloatArray]
    if isinstance(data, Mesh):
        source, side_limit = MeshHeights(plan.points, data.faces, plan.grid), None
    else:
        default_limit = default_side_limit(plan.points[:, :2])
        side_limit = default_limit if limit is None else limit
        source = CloudHeights(plan.points, side_limit, plan.grid)
    grid = plan.grid
    heights = np.full((grid.height, grid.width), np.nan, np.float32)
    level = plan.reference_height
    for tile, depth in draw_tiles(source, grid, progress, threads):
        rows, columns = slice(tile.row, tile.row + tile.height), slice(tile.column, None)
        heights[rows, columns][:, : tile.width] = level - depth
    return heights, side_limit


class MeshHeights:
    """Source of depths of a mesh; NaN outside the surface."""

    def __init__(self, view: FloatArray, faces: Int32Array, grid: Grid) -> None:
        """Assign faces to tiles; `view` (n, 3) contains the vertices in the axes of the frame."""
        from vomstudio.products.ortho._mesh_kernels import bin_faces

        self._view = np.ascontiguousarray(view)
        self._faces = to_kernel_array(faces, np.int32)
        self._grid = grid
        gsd = grid.gsd
        self._members = Members.of(bin_faces, self._view, self._faces, grid, gsd)

    def draw(self, tile: Tile) -> FloatArray:
        members = self._members.tile_rows(tile)
        return _cast_rays(self._view, self._faces, members, self._grid, tile)


class CloudHeights:
    """Source of depths of a cloud; NaN outside the surface.

    Each tile also uses the points within the maximum triangle side around it.
    """

    def __init__(self, view: FloatArray, limit: float, grid: Grid) -> None:
        from vomstudio.products.ortho._splat_kernels import bin_points

        self._view = np.ascontiguousarray(view)
        self._limit, self._grid = limit, grid
        gsd = grid.gsd
        radii = np.zeros(len(view))
        self._members = Members.of(bin_points, self._view, radii, grid, limit + gsd)

    def draw(self, tile: Tile) -> FloatArray:
        members = self._members.tile_rows(tile)
        points = self._view[members]
        if len(points) > TILE_POINTS:
            points = average_top_points(points, self._grid.gsd)
        if len(points) < 3:
            return np.full((tile.height, tile.width), np.nan)
        return interpolate_tile(extract_top_sheet(points), self._limit, self._grid, tile)


def _cast_rays(
    view: FloatArray,
    faces: Int32Array,
    members: Int32Array,
    grid: Grid,
    tile: Tile,
) -> FloatArray:
    if not len(members):
        return np.full((tile.height, tile.width), np.nan)
    gsd = grid.gsd
    depth = cast_grid(
        view,
        faces,
        members,
        left=grid.left + tile.column * gsd,
        top=grid.top + tile.row * gsd,
        step=gsd,
        width=tile.width,
        height=tile.height,
    ).depth
    return np.where(np.isfinite(depth), depth, np.nan)
