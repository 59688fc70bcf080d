"""Picture of a mesh by parallel rays, one per pixel and four more at jumps in depth."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import (
    ByteArray,
    Float32Array,
    FloatArray,
    IndexArray,
    Int32Array,
    IntArray,
)
from vomstudio.core.findings import Finding
from vomstudio.geometry.kernels.jit import to_kernel_array
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.rays.raycast import GridHits, cast_grid, cast_quarters
from vomstudio.products.ortho.textures import TextureStore, picture_size
from vomstudio.products.ortho.tiles import Grid, Members, Tile, TilePicture, empty_picture

_MAX_LEVELS = 24
"""Number of pyramid levels, more than any picture has."""
PLAIN_COLOR = (200.0, 200.0, 200.0)
"""Colour of surfaces that have no colours."""


class MeshSource:
    """Source of tiles of a mesh.

    Textured faces show their texture, averaged over the footprint of each pixel. Other faces show
    the colours of their vertices. If the mesh has no such colours, they show the colour of their
    material, or grey, darker the more they are inclined to the viewer.
    """

    def __init__(self, mesh: Mesh, view: FloatArray, grid: Grid) -> None:
        """Assign faces to tiles; `view` (n, 3) contains vertices from `ViewFrame.to_view`."""
        from vomstudio.products.ortho._mesh_kernels import bin_faces

        self._mesh = mesh
        self._view = np.ascontiguousarray(view)
        self._faces = to_kernel_array(mesh.faces, np.int32)
        self._grid = grid
        gsd = grid.gsd
        self._members = Members.of(bin_faces, self._view, self._faces, grid, 2 * gsd)
        # Materials are counted from 1; 0 is for faces before the first material.
        all_faces = np.arange(len(self._faces))
        materials = np.searchsorted(mesh.material_offsets, all_faces, side="right")
        self._face_materials = materials.astype(np.int32)
        self._store = TextureStore(self._skipped_level_counts())
        self._uv = np.zeros((0, 2), np.float32)
        self._has_uv = np.zeros(len(self._faces), bool)
        if mesh.uv is not None:
            self._uv = to_kernel_array(mesh.uv, np.float32)
            is_finite_uv = np.asarray(np.isfinite(self._uv).all(axis=1))
            self._has_uv = np.asarray(is_finite_uv[self._faces].all(axis=1))

    def draw(self, tile: Tile) -> TilePicture:
        from vomstudio.products.ortho._mesh_kernels import find_edges

        members = self._members.tile_rows(tile)
        if not len(members):
            return empty_picture(tile)
        gsd = self._grid.gsd
        view, faces = self._view, self._faces
        x_left = self._grid.left + tile.column * gsd
        y_top = self._grid.top + tile.row * gsd
        # Add a pixel on each side to detect edges between tiles.
        height, width = tile.height + 2, tile.width + 2
        hits = cast_grid(
            view,
            faces,
            members,
            left=x_left - gsd,
            top=y_top - gsd,
            step=gsd,
            width=width,
            height=height,
        )
        is_edge = np.zeros((height, width), bool)
        find_edges(view, faces, hits.face, hits.depth, gsd, is_edge)
        inner_slices = (slice(1, -1), slice(1, -1))
        face = hits.face[inner_slices].ravel()
        is_hit = face >= 0
        rgba = np.zeros((len(face), 4), np.uint8)
        rgba[:, :3] = self._shade(
            face, np.ascontiguousarray(hits.weights[inner_slices]).reshape(-1, 2)
        )
        rgba[:, 3] = np.where(is_hit, 255, 0)
        depth = np.where(is_hit, hits.depth[inner_slices].ravel(), np.nan).astype(np.float32)
        is_edge = np.ascontiguousarray(is_edge[inner_slices])
        if is_edge.any():
            quarter_hits = cast_quarters(
                view, faces, members, is_edge, left=x_left, top=y_top, step=gsd
            )
            self._antialias_edges(quarter_hits, np.flatnonzero(is_edge), rgba, depth)
        shape = (tile.height, tile.width)
        return TilePicture(rgba.reshape(*shape, 4), depth.reshape(shape))

    def warnings(self) -> list[Finding]:
        return [
            Finding("texture.not-drawn", file=path) for path in sorted(self._store.unreadable_paths)
        ]

    def _antialias_edges(
        self,
        hits: GridHits,
        index: IndexArray,
        rgba: ByteArray,
        depth: Float32Array,
    ) -> None:
        """Average the colour and opacity of the edge pixels `index` from four rays each.

        The depth remains that of the pixel centre, or the nearest of the four if the centre is
        empty.
        """
        colors = self._shade(hits.face.ravel(), hits.weights.reshape(-1, 2), 0.5).reshape(-1, 4, 3)
        is_hit = hits.face >= 0
        count = is_hit.sum(axis=1)
        has_hits = count > 0
        index, is_hit, count = index[has_hits], is_hit[has_hits], count[has_hits]
        mean = (colors[has_hits].astype(np.float64) * is_hit[:, :, None]).sum(axis=1) / count[
            :, None
        ]
        rgba[index, :3] = np.rint(mean)
        rgba[index, 3] = np.rint(count * 63.75)
        nearest_depth = hits.depth[has_hits].min(axis=1)
        depth[index] = np.where(np.isnan(depth[index]), nearest_depth, depth[index])

    def _shade(self, face: Int32Array, weights: FloatArray, footprint: float = 1.0) -> ByteArray:
        """Return the colours (n, 3) of hits: face (n,), weights (n, 2); black if empty."""
        from vomstudio.products.ortho._mesh_kernels import blend_corners
        from vomstudio.products.ortho._texture_kernels import sample_texture

        mesh = self._mesh
        rgb = np.zeros((len(face), 3), np.uint8)
        for material_index, rows in self._group_by_material(face):
            material = None if material_index is None else mesh.materials[material_index]
            if material is not None and material.texture is not None and mesh.uv is not None:
                pyramid = self._store.get(material.texture)
                is_textured = self._has_uv[face[rows]]
                if pyramid is not None and is_textured.any():
                    sample_texture(
                        pyramid.texels,
                        pyramid.offsets,
                        pyramid.sizes,
                        *pyramid.size,
                        rows[is_textured],
                        face,
                        weights,
                        self._view,
                        self._faces,
                        self._uv,
                        self._grid.gsd * footprint,
                        rgb,
                    )
                    rows = rows[~is_textured]
            if not len(rows):
                continue
            if mesh.colors is not None:
                colors = to_kernel_array(mesh.colors, np.uint8)
                blend_corners(rows, face, weights, self._faces, colors, rgb)
            else:
                color = (
                    PLAIN_COLOR
                    if material is None or material.diffuse is None
                    else [255.0 * c for c in material.diffuse]
                )
                brightness = _face_brightness(self._view[self._faces[face[rows]]])
                rgb[rows] = np.clip(np.rint(brightness[:, None] * np.array(color)), 0, 255)
        return rgb

    def _group_by_material(self, face: Int32Array) -> Iterator[tuple[int | None, IntArray]]:
        """Yield the rows of `face` that have hits, grouped by the material of the face."""
        pixels = np.flatnonzero(face >= 0)
        count = len(self._mesh.materials)
        pixel_materials = self._face_materials[face[pixels]]
        indices = np.flatnonzero(np.bincount(pixel_materials)).tolist()
        for material_index in indices:
            yield (
                material_index - 1 if 1 <= material_index <= count else None,
                pixels if len(indices) == 1 else pixels[pixel_materials == material_index],
            )

    def _skipped_level_counts(self) -> dict[Path, int]:
        """Return, for each texture, the number of finest levels that no pixel requires."""
        return {
            path: min(_MAX_LEVELS, math.floor(math.log2(max(self._grid.gsd / low, 1.0))))
            for path, (low, _, _) in texel_sizes(self._mesh, self._view).items()
        }


def texel_sizes(mesh: Mesh, vertices: FloatArray) -> dict[Path, tuple[float, float, float]]:
    """Return the texel sizes and the area of each texture, in the unit of the vertices.

    The sizes are the first percentile and the median on the surface, weighted by area.
    """
    statistics: dict[Path, tuple[float, float, float]] = {}
    if mesh.uv is None:
        return statistics
    sizes: dict[Path, list[FloatArray]] = {}
    areas: dict[Path, list[FloatArray]] = {}
    for k, material in enumerate(mesh.materials):
        pixels = None if material.texture is None else picture_size(material.texture)
        if material.texture is None or pixels is None:
            continue
        faces = mesh.faces[mesh.material_offsets[k] : mesh.material_offsets[k + 1]]
        faces = faces[:: max(1, len(faces) // 200_000)]
        p, t = vertices[faces], mesh.uv[faces].astype(np.float64) * pixels
        area = 0.5 * np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1)
        a, b = t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]
        texels = 0.5 * np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
        is_measurable = (texels > 1e-9) & (area > 0)
        sizes.setdefault(material.texture, []).append(
            np.sqrt(area[is_measurable] / texels[is_measurable])
        )
        areas.setdefault(material.texture, []).append(area[is_measurable])
    for path, parts in sizes.items():
        size, area = np.concatenate(parts), np.concatenate(areas[path])
        if not len(size):
            continue
        order = np.argsort(size)
        cumulative_share = np.cumsum(area[order]) / area.sum()
        index = np.minimum(np.searchsorted(cumulative_share, (0.01, 0.5)), len(size) - 1)
        low, middle = size[order][index].tolist()
        statistics[path] = (low, middle, float(area.sum()))
    return statistics


def away_facing_share(view: FloatArray, faces: Int32Array, rays: int = 256) -> float:
    """Return the share of first hits along +z that face away from the viewer.

    Corners must be counter-clockwise seen from outside. The result is NaN if there are no hits.
    """
    low, high = view.min(axis=0), view.max(axis=0)
    step = max(float((high - low)[:2].max()), 1e-12) / rays
    width, height = (max(1, math.ceil(v / step)) for v in (high - low)[:2].tolist())
    faces = to_kernel_array(faces, np.int32)
    all_faces = np.arange(len(faces), dtype=np.int32)
    face = cast_grid(
        np.ascontiguousarray(view),
        faces,
        all_faces,
        left=float(low[0]),
        top=float(low[1]),
        step=step,
        width=width,
        height=height,
    ).face
    corners = view[faces[face[face >= 0]]]
    if not len(corners):
        return float("nan")
    a, b, c = (corners[:, k] for k in range(3))
    return float((np.cross(b - a, c - a)[:, 2] > 0).mean())


def _face_brightness(corners: FloatArray) -> FloatArray:
    """Return the brightness of faces, from 1 (facing the viewer) to 0.35 (edge-on)."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1)
    return 0.35 + 0.65 * np.abs(normal[:, 2]) / np.where(length > 0, length, 1.0)
