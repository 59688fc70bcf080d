"""Visibility of a mesh in a photo: visible faces, their quality, and vertex colours."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from vomstudio.core.arrays import BoolArray, Float32Array, FloatArray, Int32Array
from vomstudio.core.errors import InputError
from vomstudio.core.files.untrusted.pictures import COLOR_BYTES, MASK_BYTES, decode_picture
from vomstudio.core.findings import Finding
from vomstudio.geometry.cameras import View
from vomstudio.photogrammetry.surface.topology import cross_products

# Maximum number of pixels of the depth buffer; larger photos are reduced.
_MAX_DEPTH_PIXELS = 12_000_000
# Margin to the foreground and to masks in pixels, since the shape and poses are not exact.
_MARGIN_PX = 2
_DEPTH_TOLERANCE_PX = 3.0
# Minimum cosine between the normal and the ray for a well visible and for a visible face.
_MIN_CLEAR_COSINE, _MIN_COSINE = 0.17, 0.04
# Minimum visible share of the pixels of a face; other faces would show the foreground.
_MIN_VISIBLE_SHARE = 0.98
# Width of the border with decreasing quality, as a share of the photo.
_BORDER_SHARE = 0.04
_LEVELS = 6


class MaskedPhoto(Protocol):
    """Protocol of an encoded photo with its mask (white parts are used) and its view."""

    @property
    def photo(self) -> bytes: ...
    @property
    def mask(self) -> bytes | None: ...
    @property
    def view(self) -> View: ...


@dataclass(frozen=True, eq=False)
class VisibilityTask:
    """Input of `compute_visibility`: a photo with its view, and the mesh in the same frame."""

    photo: bytes
    mask: bytes | None
    view: View
    vertices: FloatArray
    faces: Int32Array


@dataclass(frozen=True, eq=False)
class PhotoVisibility:
    """Visible part of a mesh in a photo.

    Attributes
    ----------
    faces : (k,) int32 array
    quality : (k,) float32 array
        Minimum number of pixels per unit of length on the rock over all directions; reduced towards
        the border of the photo.
    resolution : (k,) float32 array
        Number of pixels per unit of length at the distance of the face.
    is_clearly_visible : (k,) array of bool
        Whether each face is visible with a margin and not at a grazing angle.
    vertices : (l,) int32 array
        Rows of the corners of these faces.
    colors : (l, 3) float32 array
        RGB averaged over about the area of the vertex.
    detail : (l,) float32 array
        Logarithm of the ratio of fine to coarse contrast.
    """

    name: str
    faces: Int32Array
    quality: Float32Array
    resolution: Float32Array
    is_clearly_visible: BoolArray
    vertices: Int32Array
    colors: Float32Array
    detail: Float32Array


def peak_memory_bytes(width: int, height: int, faces: int) -> int:
    """Return the peak memory of `compute_visibility` for a photo and number of faces, bytes."""
    return int(width * height * 18 + faces * 170) + 20_000_000


def decode(content: bytes, view: View, *, is_grey: bool = False) -> Any:
    """Decode a picture to (h, w, 3) uint8 BGR, or (h, w) for a mask.

    Raises InputError if it is not a picture of the camera's shape.
    """
    import cv2

    flags = cv2.IMREAD_GRAYSCALE if is_grey else cv2.IMREAD_COLOR
    pixel_bytes = MASK_BYTES if is_grey else COLOR_BYTES
    picture = decode_picture(content, flags, view.name, min_pixel_bytes=pixel_bytes)
    if picture is None:
        raise InputError(Finding("photo.unreadable"), file=view.name)
    width, height = view.intrinsics.width, view.intrinsics.height
    if is_grey and picture.shape != (height, width):
        return cv2.resize(picture, (width, height), interpolation=cv2.INTER_NEAREST)
    if picture.shape[:2] != (height, width):
        raise InputError(
            Finding(
                "photo.other-size",
                width=picture.shape[1],
                height=picture.shape[0],
                aligned_width=width,
                aligned_height=height,
            ),
            file=view.name,
        )
    return picture


def compute_visibility(task: VisibilityTask) -> PhotoVisibility:
    """Compute the visible part of the mesh. Raises InputError as in `decode`."""
    view, faces = task.view, task.faces
    picture = decode(task.photo, view)
    pixels, depths = project(view, task.vertices)
    is_in_photo = view.contains(np.nan_to_num(pixels, nan=-1.0))
    is_projectable = np.isfinite(pixels).all(axis=1) & (depths > 0)
    is_drawable = is_projectable[faces].all(axis=1)
    selection = np.flatnonzero(is_drawable & is_in_photo[faces].any(axis=1)).astype(np.int32)
    visible_share, clear_share = _visible_shares(task, pixels, depths, selection)
    cross = cross_products(task.vertices, faces[selection])
    length = np.linalg.norm(cross, axis=1)
    rays = view.centre - task.vertices[faces[selection, 0]]
    distances = np.linalg.norm(rays, axis=1)
    cosine = (cross * rays).sum(axis=1) / np.maximum(length * distances, 1e-300)
    corners = faces[selection]
    is_kept = (
        (visible_share >= _MIN_VISIBLE_SHARE)
        & (cosine > _MIN_COSINE)
        & is_in_photo[corners].all(axis=1)
    )
    selection, corners, cosine, clear_share, distances = (
        a[is_kept] for a in (selection, corners, cosine, clear_share, distances)
    )
    width, height = view.intrinsics.width, view.intrinsics.height
    border_distance = (
        np.minimum(pixels, np.array([width, height]) - pixels).min(axis=1)[corners].min(axis=1)
    )
    focal = math.sqrt(view.intrinsics.focal[0] * view.intrinsics.focal[1])
    resolution = focal / distances
    quality = (
        cosine
        * resolution
        * np.clip(border_distance / (_BORDER_SHARE * max(width, height)), 0.02, 1)
    )
    is_clearly_visible = (
        (clear_share > 0.999) & (cosine > _MIN_CLEAR_COSINE) & (border_distance > 2)
    )
    rows = np.unique(corners).astype(np.int32)
    edge_lengths_px = _mean_edge_lengths_px(pixels, corners, len(task.vertices))[rows]
    return PhotoVisibility(
        view.name,
        selection,
        quality.astype(np.float32),
        resolution.astype(np.float32),
        is_clearly_visible,
        rows,
        _sample_colors(picture, pixels[rows], edge_lengths_px),
        _detail(picture, pixels[rows]),
    )


def project(view: View, vertices: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Project vertices to pixels (n, 2), NaN if undefined, and depths (n,)."""
    return np.ascontiguousarray(view.project(vertices)), np.ascontiguousarray(view.depths(vertices))


def _visible_shares(
    task: VisibilityTask, pixels: FloatArray, depths: FloatArray, selection: Int32Array
) -> tuple[Float32Array, Float32Array]:
    import cv2

    from vomstudio.photogrammetry.surface._visibility_kernels import (
        draw_depths,
        measure_visible_shares,
    )

    lens = task.view.intrinsics
    reduction_factor = max(1.0, math.sqrt(lens.width * lens.height / _MAX_DEPTH_PIXELS))
    size = (
        max(1, round(lens.width / reduction_factor)),
        max(1, round(lens.height / reduction_factor)),
    )
    scaled_pixels = pixels * (np.array(size) / (lens.width, lens.height))
    depth_buffer = np.full(size[::-1], np.inf, np.float32)
    draw_depths(scaled_pixels, depths, task.faces, selection, depth_buffer)
    kernel = np.ones((2 * _MARGIN_PX + 1,) * 2, np.uint8)
    nearest_depths = np.ascontiguousarray(cv2.erode(depth_buffer, kernel, borderValue=math.inf))
    usable_mask = np.full(size[::-1], 255, np.uint8)
    if task.mask is not None:
        mask = cv2.resize(
            decode(task.mask, task.view, is_grey=True), size, interpolation=cv2.INTER_AREA
        )
        usable_mask = np.ascontiguousarray(cv2.erode((mask > 127).astype(np.uint8), kernel))
    visible_share = np.zeros(len(selection), np.float32)
    clear_share = np.zeros(len(selection), np.float32)
    pixel_size = lens.width / size[0] / lens.focal[0]
    measure_visible_shares(
        scaled_pixels,
        depths,
        task.faces,
        selection,
        depth_buffer,
        nearest_depths,
        usable_mask,
        pixel_size,
        float(_MARGIN_PX),
        _DEPTH_TOLERANCE_PX,
        visible_share,
        clear_share,
    )
    return visible_share, clear_share


def _mean_edge_lengths_px(pixels: FloatArray, corners: Int32Array, n: int) -> FloatArray:
    """Return the mean length (n,) of the edges of each vertex in the photo, in pixels."""
    length_sums, edge_counts = np.zeros(n), np.zeros(n)
    for k in range(3):
        a, b = corners[:, k], corners[:, (k + 1) % 3]
        length = np.hypot(*(pixels[a] - pixels[b]).T)
        for end in (a, b):
            length_sums += np.bincount(end, length, minlength=n)
            edge_counts += np.bincount(end, minlength=n)
    return np.asarray(length_sums / np.maximum(edge_counts, 1))


def pyramid(picture: Any, levels: int) -> list[Any]:
    """Return the picture and successive reductions to half its size.

    Pixel p of a level is pixel (p - 0.5) / 2 + 0.5 of the next level.
    """
    import cv2

    pictures = [picture]
    for _ in range(levels):
        if min(pictures[-1].shape[:2]) < 8:
            break
        pictures.append(cv2.pyrDown(pictures[-1]))
    return pictures


def scale_to_level(pixels: FloatArray, level: int) -> FloatArray:
    """Convert pixels (n, 2) of a picture to a level of its `pyramid`."""
    return np.ascontiguousarray((pixels - 0.5) / 2**level + 0.5)


def _sample_colors(picture: Any, pixels: FloatArray, edge_lengths_px: FloatArray) -> Float32Array:
    """Return the RGB of each vertex, averaged over a third of the length of its edges.

    A larger area would include the surface beyond an edge.
    """
    from vomstudio.photogrammetry.surface._visibility_kernels import interpolate_picture

    layers = pyramid(picture, _LEVELS)
    level = np.clip(
        np.rint(np.log2(np.maximum(0.35 * edge_lengths_px, 1))), 0, len(layers) - 1
    ).astype(int)
    colors = np.zeros((len(pixels), 3), np.float32)
    for k, layer in enumerate(layers):
        rows = np.flatnonzero(level == k)
        values = np.zeros((len(rows), 3), np.float32)
        interpolate_picture(np.ascontiguousarray(layer), scale_to_level(pixels[rows], k), values)
        colors[rows] = values[:, ::-1]
    return colors


def _detail(picture: Any, pixels: FloatArray) -> Float32Array:
    """Return the log ratio of the contrast over about two pixels to that over about eight.

    It is lower for blurred photos, regardless of their content. The finest scale, which contains
    noise, is excluded.
    """
    import cv2

    from vomstudio.photogrammetry.surface._visibility_kernels import interpolate_picture

    grey = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY).astype(np.float32)
    fine_detail = cv2.GaussianBlur(grey, (0, 0), 0.8) - cv2.GaussianBlur(grey, (0, 0), 1.6)
    reduced_picture = cv2.resize(grey, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
    coarse_detail = reduced_picture - cv2.GaussianBlur(reduced_picture, (0, 0), 1.2)
    energies = []
    for band in (fine_detail, coarse_detail):
        reduced_band = cv2.resize(
            np.abs(band), (reduced_picture.shape[1], reduced_picture.shape[0]), interpolation=3
        )
        energies.append(cv2.GaussianBlur(reduced_band, (0, 0), 3))
    ratio = np.log((energies[0] + 0.05) / (energies[1] + 0.05))
    # Use bytes in steps of 0.02, the type for which the kernel is compiled.
    quantized_ratio = np.clip(np.rint(ratio * 50 + 200), 0, 255).astype(np.uint8)[..., None]
    values = np.zeros((len(pixels), 1), np.float32)
    scale = np.array(
        [reduced_picture.shape[1] / picture.shape[1], reduced_picture.shape[0] / picture.shape[0]]
    )
    interpolate_picture(
        np.ascontiguousarray(quantized_ratio), np.ascontiguousarray(pixels * scale), values
    )
    return ((values[:, 0] - 200) / 50).astype(np.float32)
