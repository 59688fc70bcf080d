"""A mesh as parallel rays see it: one ray per pixel, four more where depth jumps."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import numpy.typing as npt

from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.raycast import RayCaster
from vomstudio.products.textures import TextureStore, picture_size
from vomstudio.products.tiles import TILE, Grid, Tile, TilePicture, empty

Array = npt.NDArray[np.float64]

PLAIN = (200.0, 200.0, 200.0)
"""Colour of a surface that has none."""

_INWARD = np.array([[0.0, 0.0, 1.0]])
_QUARTERS = np.array([(-0.25, -0.25), (0.25, -0.25), (-0.25, 0.25), (0.25, 0.25)])


class MeshSource:
    """Draws tiles of a mesh.

    Textured faces show their texture, averaged over each pixel's footprint; others the colours of
    their vertices; others their material's colour, or grey, darker the more they are turned away
    from the viewer, for else nothing of their shape would be seen.
    """

    def __init__(self, mesh: Mesh, view: Array, grid: Grid) -> None:
        """view : (n, 3) the mesh's vertices as `ViewFrame.to_view` gives them."""
        from vomstudio.products._mesh_kernels import bin_faces

        self._mesh = mesh
        self._view = np.ascontiguousarray(view)
        self._faces = np.ascontiguousarray(mesh.faces, np.int32)
        self._grid = grid
        g = grid.gsd
        starts = np.zeros(grid.columns * grid.rows + 1, np.int64)
        where = (self._view, self._faces, grid.left, grid.top, TILE * g, 2 * g)
        bin_faces(*where, grid.columns, grid.rows, starts, np.empty(0, np.int32))
        starts = np.cumsum(starts)
        self._members = np.empty(starts[-1], np.int32)
        if len(self._members):
            bin_faces(*where, grid.columns, grid.rows, starts[:-1].copy(), self._members)
        self._starts = starts
        self._store = TextureStore(self._coarser())

    def draw(self, tile: Tile) -> TilePicture:
        from vomstudio.products._mesh_kernels import find_edges

        chosen = self._members[self._starts[tile.number] : self._starts[tile.number + 1]]
        if not len(chosen):
            return empty(tile)
        g = self._grid.gsd
        corners = self._view[self._faces[chosen]]
        # In the tile's own metres, so that float32 rays keep their digits.
        x0 = self._grid.left + tile.column * g
        y0 = self._grid.top + tile.row * g
        corners[..., 0] -= x0
        corners[..., 1] -= y0
        caster = RayCaster(corners)
        front = float(corners[..., 2].min()) - g
        # One pixel more all round, for the edges between tiles.
        h, w = tile.height + 2, tile.width + 2
        columns, rows = np.meshgrid(np.arange(w) - 0.5, np.arange(h) - 0.5)
        hits = caster.cast(_starts(columns.ravel() * g, rows.ravel() * g, front), _INWARD)
        face = hits.face.reshape(h, w)
        depth = hits.distance.reshape(h, w) + front
        edge = np.zeros((h, w), bool)
        find_edges(corners, face, depth, g, edge)
        inner = (slice(1, -1), slice(1, -1))
        met = (face >= 0)[inner].ravel()
        rgb = self._shade(
            chosen,
            corners,
            np.ascontiguousarray(face[inner]).ravel(),
            np.ascontiguousarray(hits.weights.reshape(h, w, 2)[inner]).reshape(-1, 2),
        )
        alpha = np.where(met, 255, 0).astype(np.uint8)
        out_depth = np.where(met, depth[inner].ravel(), np.nan)
        at = np.flatnonzero(edge[inner])
        if len(at):
            self._refine(tile, chosen, corners, caster, front, at, rgb, alpha, out_depth)
        rgba = np.concatenate([rgb, alpha[:, None]], axis=1)
        shape = (tile.height, tile.width)
        return TilePicture(rgba.reshape(*shape, 4), out_depth.astype(np.float32).reshape(shape))

    def warnings(self) -> list[str]:
        return [
            f"{path}: this texture cannot be read; its faces are drawn without it."
            for path in sorted(self._store.unreadable)
        ]

    def _refine(
        self,
        tile: Tile,
        chosen: npt.NDArray[np.int32],
        corners: Array,
        caster: RayCaster,
        front: float,
        at: npt.NDArray[np.intp],
        rgb: npt.NDArray[np.uint8],
        alpha: npt.NDArray[np.uint8],
        depth: Array,
    ) -> None:
        """Colour and opacity of edge pixels from four rays. The depth stays that of the centre,
        and where only the others meet something it is the nearest of theirs."""
        g = self._grid.gsd
        row, column = np.divmod(at, tile.width)
        x = (column[:, None] + 0.5 + _QUARTERS[:, 0]) * g
        y = (row[:, None] + 0.5 + _QUARTERS[:, 1]) * g
        hits = caster.cast(_starts(x.ravel(), y.ravel(), front), _INWARD)
        colors = self._shade(chosen, corners, hits.face, hits.weights, 0.5).reshape(-1, 4, 3)
        met = (hits.face >= 0).reshape(-1, 4)
        count = met.sum(axis=1)
        some = count > 0
        at, met, count, colors = at[some], met[some], count[some], colors[some].astype(np.float64)
        mean = (colors * met[:, :, None]).sum(axis=1) / count[:, None]
        rgb[at] = np.rint(mean).astype(np.uint8)
        alpha[at] = np.rint(count * 63.75).astype(np.uint8)
        nearest = np.where(met, hits.distance.reshape(-1, 4)[some] + front, np.inf).min(axis=1)
        depth[at] = np.where(np.isnan(depth[at]), nearest, depth[at])

    def _shade(
        self,
        chosen: npt.NDArray[np.int32],
        corners: Array,
        face: npt.NDArray[np.int32],
        weights: Array,
        footprint: float = 1.0,
    ) -> npt.NDArray[np.uint8]:
        """(n, 3) colours of hits on `chosen` faces; black where nothing was met."""
        from vomstudio.products._mesh_kernels import blend_corners
        from vomstudio.products._texture_kernels import sample

        mesh = self._mesh
        rgb = np.zeros((len(face), 3), np.uint8)
        pixels = np.flatnonzero(face >= 0)
        if not len(pixels):
            return rgb
        if mesh.materials:
            wears = np.searchsorted(mesh.material_offsets, chosen, side="right") - 1
        else:
            wears = np.full(len(chosen), -1)
        uv = None if mesh.uv is None else mesh.uv[self._faces[chosen]]
        mapped = np.zeros(len(chosen), bool)
        if uv is not None:
            mapped = np.asarray(np.isfinite(uv).all(axis=(1, 2)))
        of_pixel = wears[face[pixels]]
        for number in np.unique(of_pixel):
            rows = pixels[of_pixel == number]
            material = mesh.materials[number] if 0 <= number < len(mesh.materials) else None
            if material is not None and material.texture is not None and uv is not None:
                pyramid = self._store.get(material.texture)
                textured = mapped[face[rows]]
                if pyramid is not None and textured.any():
                    sample(
                        pyramid.texels, pyramid.offsets, pyramid.sizes, *pyramid.size,
                        rows[textured], face, weights, corners, uv,
                        self._grid.gsd * footprint, rgb,
                    )  # fmt: skip
                    rows = rows[~textured]
            if not len(rows):
                continue
            if mesh.colors is not None:
                values = mesh.colors[self._faces[chosen]].astype(np.float32)
                blend_corners(rows, face, weights, values, rgb)
            else:
                color = PLAIN if material is None or material.diffuse is None else [
                    255.0 * c for c in material.diffuse
                ]  # fmt: skip
                light = _facing(corners[face[rows]])
                rgb[rows] = np.clip(np.rint(light[:, None] * np.array(color)), 0, 255)
        return rgb

    def _coarser(self) -> dict[Path, int]:
        """How many of the finest levels of each texture no pixel will need."""
        return {
            path: max(0, math.floor(math.log2(max(self._grid.gsd / low, 1.0))))
            for path, (low, _, _) in texel_sizes(self._mesh, self._view).items()
        }


def texel_sizes(mesh: Mesh, vertices: Array) -> dict[Path, tuple[float, float, float]]:
    """Per texture: the smallest size of a texel on the surface (but for 1 % of the area), the
    median by area, both in units of `vertices`, and the surface's area."""
    found: dict[Path, tuple[float, float, float]] = {}
    if mesh.uv is None:
        return found
    sizes: dict[Path, list[Array]] = {}
    areas: dict[Path, list[Array]] = {}
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
        good = (texels > 1e-9) & (area > 0)
        sizes.setdefault(material.texture, []).append(np.sqrt(area[good] / texels[good]))
        areas.setdefault(material.texture, []).append(area[good])
    for path, parts in sizes.items():
        size, area = np.concatenate(parts), np.concatenate(areas[path])
        if not len(size):
            continue
        order = np.argsort(size)
        share = np.cumsum(area[order]) / area.sum()
        at = np.minimum(np.searchsorted(share, (0.01, 0.5)), len(size) - 1)
        low, middle = size[order][at].tolist()
        found[path] = (low, middle, float(area.sum()))
    return found


def share_facing_away(view: Array, faces: npt.NDArray[np.int32], rays: int = 256) -> float:
    """Of what parallel rays along +z meet first, the share that turns its back to the viewer, by
    the order of its corners (counter-clockwise from outside). NaN where nothing is met."""
    corners = view[faces]
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    step = max(float((high - low)[:2].max()), 1e-12) / rays
    x = np.arange(low[0] + step / 2, high[0], step)
    y = np.arange(low[1] + step / 2, high[1], step)
    columns, rows = np.meshgrid(x, y)
    starts = _starts(columns.ravel(), rows.ravel(), float(low[2]) - 1.0)
    face = RayCaster(corners).cast(starts, _INWARD).face
    face = face[face >= 0]
    if not len(face):
        return float("nan")
    a, b, c = (corners[face, k] for k in range(3))
    return float((np.cross(b - a, c - a)[:, 2] > 0).mean())


def _starts(x: Array, y: Array, z: float) -> Array:
    return np.stack([x, y, np.full(len(x), z)], axis=1)


def _facing(corners: Array) -> Array:
    """From 1 where a face looks at the viewer to 0.35 where it is seen edge-on."""
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1)
    return 0.35 + 0.65 * np.abs(normal[:, 2]) / np.where(length > 0, length, 1.0)
