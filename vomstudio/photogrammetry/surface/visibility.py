"""What one photo sees of a mesh: which faces, how well, and the colours at its vertices."""

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

# Depths of larger photos are drawn smaller.
_MOST_DEPTHS = 12_000_000
# Pixels kept clear of whatever stands in front, and of masks; shape and poses are never exact.
_MARGIN = 2
_SLACK = 3.0
# Cosines of the angle between a face and the ray, for a face to be well seen and seen at all.
_WELL, _BARELY = 0.17, 0.04
# Share of a face's pixels that must be in sight: the rest would show what stands before it.
_IN_SIGHT = 0.98
# Over this share of the photo's width its quality falls to the border.
_BORDER = 0.04
_LEVELS = 6


class Photo(Protocol):
    """photo, mask : encoded; of a mask, white is used. view : of the photo as it is encoded, with
    whatever lens."""

    @property
    def photo(self) -> bytes: ...
    @property
    def mask(self) -> bytes | None: ...
    @property
    def view(self) -> View: ...


@dataclass(frozen=True, eq=False)
class VisibilityTask:
    """One photo and the whole mesh, in the photo's frame."""

    photo: bytes
    mask: bytes | None
    view: View
    vertices: FloatArray
    faces: Int32Array


@dataclass(frozen=True, eq=False)
class PhotoVisibility:
    """faces : (k,) int32 in sight. quality : (k,) float32 pixels per unit of length on the rock in
    the direction of least, less towards the border. well : (k,) whether by a margin, and not
    grazing
    vertices : (l,) int32 the corners of these faces. colors : (l, 3) float32 RGB over about the
    area that belongs to the vertex. detail : (l,) float32 logarithm of fine over coarse contrast
    """

    name: str
    faces: Int32Array
    quality: Float32Array
    well: BoolArray
    vertices: Int32Array
    colors: Float32Array
    detail: Float32Array


def memory_needed(width: int, height: int, faces: int) -> int:
    """Bytes that `compute_visibility` takes at most for a photo of this size and so many faces."""
    return int(width * height * 18 + faces * 170) + 20_000_000


def decode(content: bytes, view: View, *, grey: bool = False) -> Any:
    """(h, w, 3) uint8 BGR, or (h, w) for a mask. Raises InputError where this is no picture of the
    camera's shape."""
    import cv2

    flags = cv2.IMREAD_GRAYSCALE if grey else cv2.IMREAD_COLOR
    pixel_bytes = MASK_BYTES if grey else COLOR_BYTES
    picture = decode_picture(content, flags, view.name, min_pixel_bytes=pixel_bytes)
    if picture is None:
        raise InputError(Finding("photo.unreadable"), file=view.name)
    width, height = view.intrinsics.width, view.intrinsics.height
    if grey and picture.shape != (height, width):
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
    """What a photo sees of the mesh. Raises InputError as `decode`."""
    view, faces = task.view, task.faces
    picture = decode(task.photo, view)
    pixels, depths = project(view, task.vertices)
    inside = view.contains(np.nan_to_num(pixels, nan=-1.0))
    drawable = np.isfinite(pixels).all(axis=1) & (depths > 0)
    whole = drawable[faces].all(axis=1)
    chosen = np.flatnonzero(whole & inside[faces].any(axis=1)).astype(np.int32)
    seen, clear = _seen(task, pixels, depths, chosen)
    cross = cross_products(task.vertices, faces[chosen])
    length = np.linalg.norm(cross, axis=1)
    rays = view.centre - task.vertices[faces[chosen, 0]]
    reach = np.linalg.norm(rays, axis=1)
    cosine = (cross * rays).sum(axis=1) / np.maximum(length * reach, 1e-300)
    corners = faces[chosen]
    keep = (seen >= _IN_SIGHT) & (cosine > _BARELY) & inside[corners].all(axis=1)
    chosen, corners, cosine, clear, reach = (
        a[keep] for a in (chosen, corners, cosine, clear, reach)
    )
    width, height = view.intrinsics.width, view.intrinsics.height
    room = np.minimum(pixels, np.array([width, height]) - pixels).min(axis=1)[corners].min(axis=1)
    focal = math.sqrt(view.intrinsics.focal[0] * view.intrinsics.focal[1])
    quality = cosine * focal / reach * np.clip(room / (_BORDER * max(width, height)), 0.02, 1)
    well = (clear > 0.999) & (cosine > _WELL) & (room > 2)
    rows = np.unique(corners).astype(np.int32)
    span = _spans(pixels, corners, len(task.vertices))[rows]
    return PhotoVisibility(
        view.name,
        chosen,
        quality.astype(np.float32),
        well,
        rows,
        _colors(picture, pixels[rows], span),
        _detail(picture, pixels[rows]),
    )


def project(view: View, vertices: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Pixels (n, 2), NaN where there are none, and depths (n,)."""
    return np.ascontiguousarray(view.project(vertices)), np.ascontiguousarray(view.depths(vertices))


def _seen(
    task: VisibilityTask, pixels: FloatArray, depths: FloatArray, chosen: Int32Array
) -> tuple[Float32Array, Float32Array]:
    import cv2

    from vomstudio.photogrammetry.surface._visibility_kernels import count_seen, draw_depths

    lens = task.view.intrinsics
    shrink = max(1.0, math.sqrt(lens.width * lens.height / _MOST_DEPTHS))
    size = (max(1, round(lens.width / shrink)), max(1, round(lens.height / shrink)))
    scaled = pixels * (np.array(size) / (lens.width, lens.height))
    buffer = np.full(size[::-1], np.inf, np.float32)
    draw_depths(scaled, depths, task.faces, chosen, buffer)
    kernel = np.ones((2 * _MARGIN + 1,) * 2, np.uint8)
    nearest = np.ascontiguousarray(cv2.erode(buffer, kernel, borderValue=math.inf))
    usable = np.full(size[::-1], 255, np.uint8)
    if task.mask is not None:
        mask = cv2.resize(
            decode(task.mask, task.view, grey=True), size, interpolation=cv2.INTER_AREA
        )
        usable = np.ascontiguousarray(cv2.erode((mask > 127).astype(np.uint8), kernel))
    seen = np.zeros(len(chosen), np.float32)
    clear = np.zeros(len(chosen), np.float32)
    pixel = lens.width / size[0] / lens.focal[0]
    count_seen(
        scaled,
        depths,
        task.faces,
        chosen,
        buffer,
        nearest,
        usable,
        pixel,
        float(_MARGIN),
        _SLACK,
        seen,
        clear,
    )
    return seen, clear


def _spans(pixels: FloatArray, corners: Int32Array, n: int) -> FloatArray:
    """(n,) mean length of a vertex's edges in the photo, pixels."""
    total, count = np.zeros(n), np.zeros(n)
    for k in range(3):
        a, b = corners[:, k], corners[:, (k + 1) % 3]
        length = np.hypot(*(pixels[a] - pixels[b]).T)
        for end in (a, b):
            total += np.bincount(end, length, minlength=n)
            count += np.bincount(end, minlength=n)
    return np.asarray(total / np.maximum(count, 1))


def pyramid(picture: Any, levels: int) -> list[Any]:
    """The picture, and halves of it; pixel p of one is ((p - 0.5) / 2 + 0.5) of the next."""
    import cv2

    made = [picture]
    for _ in range(levels):
        if min(made[-1].shape[:2]) < 8:
            break
        made.append(cv2.pyrDown(made[-1]))
    return made


def on_level(pixels: FloatArray, level: int) -> FloatArray:
    """Pixels (n, 2) of a picture on a level of its `pyramid`."""
    return np.ascontiguousarray((pixels - 0.5) / 2**level + 0.5)


def _colors(picture: Any, pixels: FloatArray, span: FloatArray) -> Float32Array:
    """RGB averaged over about a third of a vertex's edges, so that little of what is beside an
    edge in sight comes in."""
    from vomstudio.photogrammetry.surface._visibility_kernels import look_up

    layers = pyramid(picture, _LEVELS)
    level = np.clip(np.rint(np.log2(np.maximum(0.35 * span, 1))), 0, len(layers) - 1).astype(int)
    colors = np.zeros((len(pixels), 3), np.float32)
    for k, layer in enumerate(layers):
        rows = np.flatnonzero(level == k)
        values = np.zeros((len(rows), 3), np.float32)
        look_up(np.ascontiguousarray(layer), on_level(pixels[rows], k), values)
        colors[rows] = values[:, ::-1]
    return colors


def _detail(picture: Any, pixels: FloatArray) -> Float32Array:
    """Contrast of about two pixels over that of about eight: less in a blurred photo, whatever is
    on it. The finest scale is left out, where noise is."""
    import cv2

    from vomstudio.photogrammetry.surface._visibility_kernels import look_up

    grey = cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY).astype(np.float32)
    fine = cv2.GaussianBlur(grey, (0, 0), 0.8) - cv2.GaussianBlur(grey, (0, 0), 1.6)
    half = cv2.resize(grey, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
    coarse = half - cv2.GaussianBlur(half, (0, 0), 1.2)
    energies = []
    for band in (fine, coarse):
        shrunk = cv2.resize(np.abs(band), (half.shape[1], half.shape[0]), interpolation=3)
        energies.append(cv2.GaussianBlur(shrunk, (0, 0), 3))
    ratio = np.log((energies[0] + 0.05) / (energies[1] + 0.05))
    # As bytes, for the one compiled compute_visibility-up: steps of 0.02.
    steps = np.clip(np.rint(ratio * 50 + 200), 0, 255).astype(np.uint8)[..., None]
    values = np.zeros((len(pixels), 1), np.float32)
    scale = np.array([half.shape[1] / picture.shape[1], half.shape[0] / picture.shape[0]])
    look_up(np.ascontiguousarray(steps), np.ascontiguousarray(pixels * scale), values)
    return ((values[:, 0] - 200) / 50).astype(np.float32)
