"""A point cloud as parallel rays would see the surface it was taken from."""

from __future__ import annotations

import math

import numpy as np

from vomstudio.core.arrays import BoolArray, ByteArray, Float32Array, FloatArray
from vomstudio.core.findings import Finding
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.kernels.jit import for_kernels
from vomstudio.products.ortho.tiles import Grid, Members, Tile, TilePicture, empty

HOLE_SPACINGS = 4.0
"""Holes up to this many times the cloud's spacing across are closed."""

MIN_REACH_PIXELS = 0.8
"""Smaller discs could fall between the centres of pixels."""

_GAP_CHANGES = 2.0
"""What is seen through a hole lies so many times deeper than the surface changes around it."""

_CELL_SPACINGS = 6.0

_TREE_POINTS = 2_000_000
"""Of a larger cloud neighbours are sought among so many points, evenly thinned."""


class CloudSource:
    """Draws tiles of a cloud as discs of the local spacing, holes closed up to `hole_m` across.

    Colour: that of the points; else their intensity as grey; else grey by depth.
    """

    def __init__(self, cloud: PointCloud, view: FloatArray, grid: Grid, spacing: float) -> None:
        """view : (n, 3) the points as `ViewFrame.to_view` gives them. spacing : mean distance of
        a point from its nearest neighbour, metres."""
        from vomstudio.products.ortho._splat_kernels import bin_points

        self._view = np.ascontiguousarray(view)
        self._grid = grid
        self._colors = _colors(cloud, self._view)
        g = grid.gsd
        self._reach = np.maximum(local_spacing(self._view, spacing), MIN_REACH_PIXELS * g)
        self.hole_m = max(HOLE_SPACINGS * spacing, 2 * g)
        self._close = max(1, math.ceil(self.hole_m / g / 2))
        # What closes a hole lies so far from it, and what keeps it open as far from that.
        self._halo = 2 * self._close
        self._members = Members.of(bin_points, self._view, self._reach, grid, self._halo * g)

    def draw(self, tile: Tile) -> TilePicture:
        from vomstudio.products.ortho._splat_kernels import splat

        chosen = self._members.in_tile(tile)
        if not len(chosen):
            return empty(tile)
        g, halo = self._grid.gsd, self._halo
        h, w = tile.height + 2 * halo, tile.width + 2 * halo
        nearest = np.full((h, w), np.inf, np.float32)
        limit = np.zeros((h, w), np.float32)
        color = np.zeros((h, w, 3), np.float32)
        weight = np.zeros((h, w), np.float32)
        depth = np.zeros((h, w))
        left = self._grid.left + (tile.column - halo) * g
        top = self._grid.top + (tile.row - halo) * g
        splat(
            chosen,
            self._view,
            self._reach,
            self._colors,
            left,
            top,
            g,
            nearest,
            limit,
            color,
            weight,
            depth,
        )
        seen = weight > 0
        some = np.where(seen, weight, 1.0)
        rgb = np.clip(color / some[..., None] + 0.5, 0, 255).astype(np.uint8)
        z = np.where(seen, depth / some, np.nan).astype(np.float32)
        seen &= ~self._seen_through(seen, z)
        filled = self._close_holes(seen, rgb, z)
        inner = (slice(halo, -halo), slice(halo, -halo))
        alpha = np.where(seen | filled, 255, 0).astype(np.uint8)
        rgba = np.concatenate([rgb, alpha[..., None]], axis=2)[inner]
        rgba[rgba[..., 3] == 0] = 0
        return TilePicture(
            np.ascontiguousarray(rgba), np.ascontiguousarray(z[inner]), int(filled[inner].sum())
        )

    def warnings(self) -> list[Finding]:
        return []

    def _seen_through(self, seen: BoolArray, z: Float32Array) -> BoolArray:
        """Pixels that show what lies behind a surface, in a hole of it that is to be closed.

        Morphological opening of the depth takes away what is deeper and no wider than such a hole.
        What it takes must be deeper by more than the hole is wide, and by more than the surface
        itself changes around it: on a slope that is seen at a small angle nothing is a hole.
        """
        from scipy.ndimage import maximum_filter, minimum_filter

        if not seen.any():
            return np.zeros_like(seen)
        size = 2 * self._close + 1
        deep = np.where(seen, z, np.float32(np.inf))
        surface = maximum_filter(minimum_filter(deep, size), size)
        with np.errstate(invalid="ignore"):
            gap = deep - surface
            if not (gap > self.hole_m).any():
                return np.zeros_like(seen)
            change = maximum_filter(surface, size) - minimum_filter(surface, size)
            return np.asarray(seen & (gap > self.hole_m) & (gap > _GAP_CHANGES * change))

    def _close_holes(self, seen: BoolArray, rgb: ByteArray, z: Float32Array) -> BoolArray:
        """Give pixels in holes the colour and depth of the nearest one that is seen; returns which.

        Morphological closing: what lies within `_close` pixels of something, all round.
        """
        from scipy.ndimage import distance_transform_edt

        if seen.all() or not seen.any():
            return np.zeros_like(seen)
        away, nearest = distance_transform_edt(~seen, return_indices=True)
        grown = away <= self._close
        # Beyond the border nothing is known to be empty.
        closed = grown if grown.all() else distance_transform_edt(grown) > self._close
        filled: BoolArray = closed & ~seen
        from_row, from_column = nearest[0][filled], nearest[1][filled]
        rgb[filled] = rgb[from_row, from_column]
        z[filled] = z[from_row, from_column]
        return filled


def local_spacing(points: FloatArray, spacing: float) -> FloatArray:
    """(n,) the side of the square that each point has to itself, from how many share its cell of
    some 6 x 6 spacings; within half and twice the typical one."""
    side = _CELL_SPACINGS * spacing
    low = points.min(axis=0)
    cells = np.floor((points - low) / side).astype(np.int64)
    n = cells.max(axis=0) + 1
    key = (cells[:, 0] * n[1] + cells[:, 1]) * n[2] + cells[:, 2]
    order = np.argsort(key, kind="stable")
    ordered = key[order]
    first = np.flatnonzero(np.concatenate([[True], ordered[1:] != ordered[:-1]]))
    counts = np.diff(np.append(first, len(ordered)))
    found = np.empty(len(points))
    found[order] = np.repeat(side / np.sqrt(counts), counts)
    typical = float(np.median(found))
    return np.clip(found, 0.5 * typical, 2.0 * typical)


def share_facing_away(
    cloud: PointCloud,
    view: FloatArray,
    normals: FloatArray | None,
    up: FloatArray,
    samples: int = 3000,
) -> tuple[float, bool]:
    """Of the points that are seen first along +z, the share whose surface turns its back to the
    viewer, and whether that had to be guessed.

    normals : (n, 3) in the view's axes, or None; then planes through the nearest neighbours stand
    in, taken to face `up` (3,), World's, in the view's axes.
    """
    low, high = view.min(axis=0), view.max(axis=0)
    cell = max(float((high - low)[:2].max()), 1e-12) / 256
    cell = max(cell, 2.0 * math.sqrt(float(np.prod((high - low)[:2] + cell)) / len(view)))
    columns = ((view[:, :2] - low[:2]) / cell).astype(np.int64)
    key = columns[:, 1] * (columns[:, 0].max() + 1) + columns[:, 0]
    order = np.lexsort((view[:, 2], key))
    first = order[np.concatenate([[True], np.diff(key[order]) != 0])]
    first = first[:: max(1, len(first) // samples)]
    if normals is not None:
        z = normals[first, 2]
        return float((z[np.isfinite(z) & (z != 0)] > 0).mean()), False
    from scipy.spatial import cKDTree

    thin = view[:: max(1, len(view) // _TREE_POINTS)]
    if len(thin) < 3:
        return float("nan"), True
    _, near = cKDTree(thin).query(view[first], k=min(12, len(thin)))
    around = thin[near]
    around = around - around.mean(axis=1, keepdims=True)
    _, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", around, around))
    normal = axes[:, :, 0]
    normal = normal * np.where(normal @ up < 0, -1.0, 1.0)[:, None]
    return float((normal[:, 2] > 0).mean()), True


def _colors(cloud: PointCloud, view: FloatArray) -> ByteArray:
    if cloud.colors is not None:
        return for_kernels(cloud.colors, np.uint8)
    values = view[:, 2]
    for name, field in cloud.fields.items():
        if name.casefold() == "intensity" and len(field) == len(view):
            values = np.asarray(field, np.float64)
    low, high = np.nanpercentile(values, [2, 98])
    grey = np.clip((values - low) / max(high - low, 1e-30), 0, 1)
    return np.repeat((40 + 200 * np.nan_to_num(grey)).astype(np.uint8)[:, None], 3, axis=1)
