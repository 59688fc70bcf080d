"""Drawing of the pages of a texture tile by tile, and filling of gaps between charts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from vomstudio.core.arrays import (
    BoolArray,
    ByteArray,
    Float32Array,
    FloatArray,
    Int32Array,
    IntArray,
)
from vomstudio.core.progress import Executor, Progress
from vomstudio.core.words import tr
from vomstudio.photogrammetry.surface.atlas import Atlas
from vomstudio.photogrammetry.surface.blending import Blend
from vomstudio.photogrammetry.surface.topology import compact
from vomstudio.photogrammetry.surface.visibility import MaskedPhoto, decode, project, pyramid

# Size of tiles; a photo is decoded once for each of its tiles.
_TILE_TEXELS = 2048
# Exponent of the fade between two photos: higher is narrower.
_SEAM_EXPONENT = 4.0
_MAX_LEVEL = 6


@dataclass(frozen=True, eq=False)
class TilePhoto:
    """Part of one photo in a tile.

    gain : RGB gain of the photo
    face : (e,) rows of the tile's faces
    pixels, depths, weights, offsets : (e, 3, 2), (e, 3), (e, 3), (e, 3, 3) values at their corners
    """

    photo: bytes
    view: Any
    gain: tuple[float, float, float]
    face: Int32Array
    pixels: Float32Array
    depths: Float32Array
    weights: Float32Array
    offsets: Float32Array


@dataclass(frozen=True, eq=False)
class TileTask:
    """Rectangle of a page.

    left, top, width, height : texels of the page
    corners : (m, 3, 2) corners of the faces on the page
    fallback : (m, 3, 3) colours at the corners
    """

    left: int
    top: int
    width: int
    height: int
    gutter: int
    corners: FloatArray
    fallback: Float32Array
    photos: tuple[TilePhoto, ...]


@dataclass(frozen=True, eq=False)
class TextureTile:
    """Result of a tile.

    Attributes
    ----------
    rgb : (h, w, 3) ndarray
    is_filled : (h, w) ndarray
        Pixels of charts with their gutters.
    """

    rgb: ByteArray
    is_filled: BoolArray


def draw_tile(task: TileTask) -> TextureTile:
    """Draw one tile, decoding one photo at a time."""
    from vomstudio.photogrammetry.surface._texture_kernels import (
        add_view,
        compute_colors,
        draw_faces,
        grow_faces,
    )

    # Include gutters of charts beyond the tile.
    margin = task.gutter + 1
    left, top = float(task.left - margin), float(task.top - margin)
    shape = (task.height + 2 * margin, task.width + 2 * margin)
    texel_faces = np.full(shape, -1, np.int32)
    draw_faces(task.corners, left, top, texel_faces)
    grow_faces(texel_faces, np.empty_like(texel_faces), task.gutter)
    texel_faces = np.ascontiguousarray(texel_faces[margin:-margin, margin:-margin])
    total = np.zeros((*texel_faces.shape, 4), np.float32)
    origin = (float(task.left), float(task.top))
    for photo in task.photos:
        layers = pyramid(decode(photo.photo, photo.view), _MAX_LEVEL)
        entry_rows = np.full(len(task.corners), -1, np.int32)
        entry_rows[photo.face] = np.arange(len(photo.face), dtype=np.int32)
        levels = np.minimum(_levels(task.corners[photo.face], photo.pixels), len(layers) - 1)
        levels = levels.astype(np.int32)
        for drawn_level in np.unique(levels):
            add_view(
                texel_faces,
                task.corners,
                *origin,
                entry_rows,
                photo.pixels,
                photo.depths,
                photo.weights,
                photo.offsets,
                levels,
                int(drawn_level),
                np.ascontiguousarray(layers[drawn_level]),
                np.array(photo.gain),
                _SEAM_EXPONENT,
                total,
            )
    rgb = np.zeros((*texel_faces.shape, 3), np.uint8)
    compute_colors(texel_faces, task.corners, *origin, task.fallback, total, rgb)
    return TextureTile(rgb, texel_faces >= 0)


def _levels(corners: FloatArray, pixels: Float32Array) -> IntArray:
    """Return the pyramid level at which a pixel is about the size of a texel."""

    def area(p: Any) -> FloatArray:
        a, b = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
        return np.asarray(np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]))

    ratio = area(pixels.astype(np.float64)) / np.maximum(area(corners), 1e-12)
    level = np.floor(0.5 * np.log2(np.maximum(ratio, 1e-12)) + 0.4)
    return np.asarray(np.clip(level, 0, _MAX_LEVEL).astype(np.int64))


def draw_pages(
    photos: Sequence[MaskedPhoto],
    vertices: FloatArray,
    faces: Int32Array,
    atlas: Atlas,
    blend_result: Blend,
    colors: Float32Array,
    gutter: int,
    executor: Executor,
    progress: Progress,
) -> list[ByteArray]:
    """Draw RGB pages (h, w, 3) of the atlas.

    colors : (n, 3) colours of the vertices, for faces without a photo
    """
    positions = [
        (page, left, top)
        for page, (width, height) in enumerate(atlas.sizes.tolist())
        for top in range(0, height, _TILE_TEXELS)
        for left in range(0, width, _TILE_TEXELS)
    ]
    pages = [np.zeros((h, w, 3), np.uint8) for w, h in atlas.sizes.tolist()]
    filled_masks = [np.zeros((h, w), bool) for w, h in atlas.sizes.tolist()]
    progress.stage(tr("Rendering the texture"), len(positions))
    tasks = _TileTasks(photos, vertices, faces, atlas, blend_result, colors, gutter)
    tiles = (tasks.create_task(*position) for position in positions)
    for number, tile in executor.map(draw_tile, tiles, progress, _tile_memory_bytes(photos)):
        page, left, top = positions[number]
        h, w = tile.is_filled.shape
        pages[page][top : top + h, left : left + w] = tile.rgb
        filled_masks[page][top : top + h, left : left + w] = tile.is_filled
    progress.stage(tr("Filling gaps between charts"), len(pages))
    for number, (page_rgb, is_filled) in enumerate(zip(pages, filled_masks, strict=True)):
        progress.step(number)
        fill_gaps(page_rgb, is_filled)
    return pages


def _tile_memory_bytes(photos: Sequence[MaskedPhoto]) -> int:
    """Return the peak memory of `draw_tile`: sums of a tile, and a photo with its pyramid."""
    max_pixels = max(p.view.intrinsics.width * p.view.intrinsics.height for p in photos)
    return 35 * _TILE_TEXELS**2 + 6 * max_pixels + 20_000_000


class _TileTasks:
    def __init__(
        self,
        photos: Sequence[MaskedPhoto],
        vertices: FloatArray,
        faces: Int32Array,
        atlas: Atlas,
        blend_result: Blend,
        colors: Float32Array,
        gutter: int,
    ) -> None:
        self._photos, self._vertices, self._faces = photos, vertices, faces
        self._atlas, self._blend_result, self._colors, self._gutter = (
            atlas,
            blend_result,
            colors,
            gutter,
        )
        self._min_corners = atlas.corners.min(axis=1)
        self._max_corners = atlas.corners.max(axis=1)
        starts = np.zeros(len(faces) + 1, np.int64)
        np.cumsum(np.bincount(blend_result.entry_faces, minlength=len(faces)), out=starts[1:])
        self._starts = starts

    def create_task(self, page: int, left: int, top: int) -> TileTask:
        width, height = self._atlas.sizes[page].tolist()
        width, height = min(_TILE_TEXELS, width - left), min(_TILE_TEXELS, height - top)
        margin = self._gutter + 1
        min_corners, max_corners = self._min_corners, self._max_corners
        faces_in_tile = np.flatnonzero(
            (self._atlas.page == page)
            & (max_corners[:, 0] > left - margin)
            & (min_corners[:, 0] < left + width + margin)
            & (max_corners[:, 1] > top - margin)
            & (min_corners[:, 1] < top + height + margin)
        )
        blend_result = self._blend_result
        counts = self._starts[faces_in_tile + 1] - self._starts[faces_in_tile]
        entry_rows = np.repeat(self._starts[faces_in_tile], counts) + (
            np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        )
        local_faces = np.repeat(np.arange(len(faces_in_tile)), counts).astype(np.int32)
        view = blend_result.entry_views[entry_rows]
        photos = []
        for k in np.unique(view).tolist():
            is_in_view = view == k
            rows, face = entry_rows[is_in_view], local_faces[is_in_view]
            _, corners, used_vertices = compact(self._vertices, self._faces[faces_in_tile[face]])
            pixels, depths = project(self._photos[k].view, self._vertices[used_vertices])
            photos.append(
                TilePhoto(
                    self._photos[k].photo,
                    self._photos[k].view,
                    tuple(blend_result.gains[k].tolist()),
                    face,
                    pixels[corners].astype(np.float32),
                    depths[corners].astype(np.float32),
                    blend_result.entry_weights[rows],
                    blend_result.entry_offsets[rows],
                )
            )
        return TileTask(
            left,
            top,
            width,
            height,
            self._gutter,
            np.ascontiguousarray(self._atlas.corners[faces_in_tile]),
            self._colors[self._faces[faces_in_tile]],
            tuple(photos),
        )


def fill_gaps(page: ByteArray, is_filled: BoolArray) -> None:
    """Fill free texels with smooth colours of the surrounding charts (pull-push).

    Otherwise JPEG compression or the mipmaps of a renderer would draw black lines into the charts.
    """
    if is_filled.all() or not is_filled.any():
        return
    # The page itself stays in bytes, four times smaller than as float.
    page[~is_filled] = 0
    levels = [_halve_size(page, is_filled.astype(np.uint8) * np.uint8(255), 255.0)]
    while min(levels[-1][1].shape) > 1:
        levels.append(_halve_size(*levels[-1], 1.0))
    color, weight = levels[-1]
    mean_color = color / np.maximum(weight, 1e-12)[..., None]
    for color, weight in reversed(levels[:-1]):
        mean_color = color + (1 - weight)[..., None] * _enlarge(mean_color, color.shape)
    enlarged_page = _enlarge(np.clip(np.rint(mean_color), 0, 255).astype(np.uint8), page.shape)
    np.copyto(page, enlarged_page, where=~is_filled[..., None])


def _halve_size(color: Any, weight: Any, full_weight: float) -> tuple[Any, Any]:
    """Return weighted means of pixel pairs, and their weights.

    Colours are multiplied by their weights.

    full_weight : weight of a complete texel
    """
    import cv2

    size = (max(1, (weight.shape[1] + 1) // 2), max(1, (weight.shape[0] + 1) // 2))
    opacity_share = (
        cv2.resize(weight, size, interpolation=cv2.INTER_AREA).astype(np.float32) / full_weight
    )
    mean = cv2.resize(color, size, interpolation=cv2.INTER_AREA).astype(np.float32)
    opacity = np.minimum(opacity_share * 4, 1)
    ratio = np.where(opacity_share > 0, opacity / np.maximum(opacity_share, 1e-12), 0)
    return mean * ratio[..., None], opacity


def _enlarge(picture: Any, shape: tuple[int, ...]) -> Any:
    import cv2

    enlarged_picture = cv2.resize(
        np.ascontiguousarray(picture), (shape[1], shape[0]), interpolation=cv2.INTER_LINEAR
    )
    return enlarged_picture.reshape(shape)
