"""Picture of a point cloud as the scanned surface would appear in parallel projection."""

from __future__ import annotations

import math

import numpy as np

from vomstudio.core.arrays import BoolArray, ByteArray, Float32Array, FloatArray
from vomstudio.core.findings import Finding
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.kernels.jit import to_kernel_array
from vomstudio.products.ortho.tiles import Grid, Members, Tile, TilePicture, empty_picture

MAX_HOLE_SPACINGS = 4.0
"""Maximum width of the holes to be closed, in spacings of the cloud."""

MIN_RADIUS_PIXELS = 0.8
"""Minimum disc radius in pixels; smaller discs could miss all pixel centres."""

_MIN_GAP_CHANGES = 2.0
"""Minimum depth behind a hole, as a multiple of the depth change around it."""

_CELL_SPACINGS = 6.0

_MAX_TREE_POINTS = 2_000_000
"""Maximum number of points for a neighbour search; larger clouds are thinned evenly."""


class CloudSource:
    """Source of tiles of a cloud, drawn as discs, with holes up to `hole_m` closed.

    The discs have the size of the local spacing. Points without colours are shown by their
    intensity or, if that is missing, by their depth in grey.
    """

    def __init__(self, cloud: PointCloud, view: FloatArray, grid: Grid, spacing: float) -> None:
        """Assign the points to tiles.

        `view` (n, 3) contains the points from `ViewFrame.to_view`, and `spacing` is their mean
        spacing, m.
        """
        from vomstudio.products.ortho._splat_kernels import bin_points

        self._view = np.ascontiguousarray(view)
        self._grid = grid
        self._colors = _colors(cloud, self._view)
        gsd = grid.gsd
        self._radii = np.maximum(local_spacing(self._view, spacing), MIN_RADIUS_PIXELS * gsd)
        self.hole_m = max(MAX_HOLE_SPACINGS * spacing, 2 * gsd)
        self._closing_radius = max(1, math.ceil(self.hole_m / gsd / 2))
        # The distance of pixels that close a hole, plus the distance of pixels that keep it open.
        self._margin = 2 * self._closing_radius
        self._members = Members.of(bin_points, self._view, self._radii, grid, self._margin * gsd)

    def draw(self, tile: Tile) -> TilePicture:
        from vomstudio.products.ortho._splat_kernels import splat

        members = self._members.tile_rows(tile)
        if not len(members):
            return empty_picture(tile)
        gsd, halo = self._grid.gsd, self._margin
        height, width = tile.height + 2 * halo, tile.width + 2 * halo
        nearest_depths = np.full((height, width), np.inf, np.float32)
        limit = np.zeros((height, width), np.float32)
        color = np.zeros((height, width, 3), np.float32)
        weight = np.zeros((height, width), np.float32)
        depth = np.zeros((height, width))
        x_left = self._grid.left + (tile.column - halo) * gsd
        top = self._grid.top + (tile.row - halo) * gsd
        splat(
            members,
            self._view,
            self._radii,
            self._colors,
            x_left,
            top,
            gsd,
            nearest_depths,
            limit,
            color,
            weight,
            depth,
        )
        is_visible = weight > 0
        divisor = np.where(is_visible, weight, 1.0)
        rgb = np.clip(color / divisor[..., None] + 0.5, 0, 255).astype(np.uint8)
        z = np.where(is_visible, depth / divisor, np.nan).astype(np.float32)
        is_visible &= ~self._is_seen_through(is_visible, z)
        is_filled = self._close_holes(is_visible, rgb, z)
        inner_slices = (slice(halo, -halo), slice(halo, -halo))
        alpha = np.where(is_visible | is_filled, 255, 0).astype(np.uint8)
        rgba = np.concatenate([rgb, alpha[..., None]], axis=2)[inner_slices]
        rgba[rgba[..., 3] == 0] = 0
        return TilePicture(
            np.ascontiguousarray(rgba),
            np.ascontiguousarray(z[inner_slices]),
            int(is_filled[inner_slices].sum()),
        )

    def warnings(self) -> list[Finding]:
        return []

    def _is_seen_through(self, is_visible: BoolArray, z: Float32Array) -> BoolArray:
        """Find pixels that show a deeper surface through a hole that will be closed.

        A morphological opening of the depth removes pixels that are deeper and not wider than such
        a hole. Removed pixels must be deeper by more than the width of the hole and by more than
        the depth change of the surface around it, since an oblique slope has no holes.
        """
        from scipy.ndimage import maximum_filter, minimum_filter

        if not is_visible.any():
            return np.zeros_like(is_visible)
        size = 2 * self._closing_radius + 1
        visible_depth = np.where(is_visible, z, np.float32(np.inf))
        surface = maximum_filter(minimum_filter(visible_depth, size), size)
        with np.errstate(invalid="ignore"):
            gap = visible_depth - surface
            if not (gap > self.hole_m).any():
                return np.zeros_like(is_visible)
            change = maximum_filter(surface, size) - minimum_filter(surface, size)
            return np.asarray(is_visible & (gap > self.hole_m) & (gap > _MIN_GAP_CHANGES * change))

    def _close_holes(self, is_visible: BoolArray, rgb: ByteArray, z: Float32Array) -> BoolArray:
        """Fill holes with the colour and depth of the nearest visible pixel; return a mask.

        A morphological closing finds the pixels that are enclosed within `_closing_radius` pixels.
        """
        from scipy.ndimage import distance_transform_edt

        if is_visible.all() or not is_visible.any():
            return np.zeros_like(is_visible)
        distance, nearest_pixels = distance_transform_edt(~is_visible, return_indices=True)
        is_grown = distance <= self._closing_radius
        # Pixels beyond the border are not necessarily empty.
        is_closed = (
            is_grown if is_grown.all() else distance_transform_edt(is_grown) > self._closing_radius
        )
        is_filled: BoolArray = is_closed & ~is_visible
        source_row, source_column = nearest_pixels[0][is_filled], nearest_pixels[1][is_filled]
        rgb[is_filled] = rgb[source_row, source_column]
        z[is_filled] = z[source_row, source_column]
        return is_filled


def local_spacing(points: FloatArray, spacing: float) -> FloatArray:
    """Return the local spacing (n,) of each point from the number of points in its cell.

    Cells are cubes with sides of `_CELL_SPACINGS` spacings. The values are limited to between half
    and twice their median.
    """
    cell_size = _CELL_SPACINGS * spacing
    low = points.min(axis=0)
    cells = np.floor((points - low) / cell_size).astype(np.int64)
    n = cells.max(axis=0) + 1
    key = (cells[:, 0] * n[1] + cells[:, 1]) * n[2] + cells[:, 2]
    order = np.argsort(key, kind="stable")
    ordered_key = key[order]
    first_rows = np.flatnonzero(np.concatenate([[True], ordered_key[1:] != ordered_key[:-1]]))
    counts = np.diff(np.append(first_rows, len(ordered_key)))
    spacings = np.empty(len(points))
    spacings[order] = np.repeat(cell_size / np.sqrt(counts), counts)
    typical_spacing = float(np.median(spacings))
    return np.clip(spacings, 0.5 * typical_spacing, 2.0 * typical_spacing)


def away_facing_share(
    view: FloatArray,
    normals: FloatArray | None,
    up: FloatArray,
    samples: int = 3000,
) -> tuple[float, bool]:
    """Return the share of visible points whose surface faces away from the viewer.

    Parameters
    ----------
    view : (n, 3) array
        Points in the axes of the view, seen along +z.
    normals : (n, 3) array or None
        Normals in the axes of the view. If None, planes are fitted to neighbours and assumed to
        face `up`.
    up : (3,) array
        Up direction of the World frame in the axes of the view.
    samples : int
        Approximate number of points to test.

    Returns
    -------
    share : float
        NaN if the normals are unknown.
    is_guessed : bool
        Whether the orientation of the normals was assumed.
    """
    low, high = view.min(axis=0), view.max(axis=0)
    cell = max(float((high - low)[:2].max()), 1e-12) / 256
    cell = max(cell, 2.0 * math.sqrt(float(np.prod((high - low)[:2] + cell)) / len(view)))
    columns = ((view[:, :2] - low[:2]) / cell).astype(np.int64)
    key = columns[:, 1] * (columns[:, 0].max() + 1) + columns[:, 0]
    order = np.lexsort((view[:, 2], key))
    first_rows = order[np.concatenate([[True], np.diff(key[order]) != 0])]
    first_rows = first_rows[:: max(1, len(first_rows) // samples)]
    if normals is not None:
        z = normals[first_rows, 2]
        return float((z[np.isfinite(z) & (z != 0)] > 0).mean()), False
    from scipy.spatial import cKDTree

    thinned_points = view[:: max(1, len(view) // _MAX_TREE_POINTS)]
    if len(thinned_points) < 3:
        return float("nan"), True
    _, neighbours = cKDTree(thinned_points).query(view[first_rows], k=min(12, len(thinned_points)))
    nearby_points = thinned_points[neighbours]
    nearby_points = nearby_points - nearby_points.mean(axis=1, keepdims=True)
    _, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", nearby_points, nearby_points))
    normal = axes[:, :, 0]
    normal = normal * np.where(normal @ up < 0, -1.0, 1.0)[:, None]
    return float((normal[:, 2] > 0).mean()), True


def _colors(cloud: PointCloud, view: FloatArray) -> ByteArray:
    if cloud.colors is not None:
        return to_kernel_array(cloud.colors, np.uint8)
    values = view[:, 2]
    for name, field in cloud.fields.items():
        if name.casefold() == "intensity" and len(field) == len(view):
            values = np.asarray(field, np.float64)
    low, high = np.nanpercentile(values, [2, 98])
    grey = np.clip((values - low) / max(high - low, 1e-30), 0, 1)
    return np.repeat((40 + 200 * np.nan_to_num(grey)).astype(np.uint8)[:, None], 3, axis=1)
