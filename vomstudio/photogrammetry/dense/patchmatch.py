"""Depth of a photo from several other photos by PatchMatch.

Every pixel has a plane. Good planes propagate to the neighbours and are changed at random (Bleyer,
Rhemann and Rother, 2011; red and black pixels in turn: Galliani, Lasinger and Schindler, 2015). The
similarity is the correlation of bilaterally weighted patches in the best sources, from coarse to
fine pictures. PatchMatch is used for convergent photos and takes about ten times as long as a
rectified pair.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vomstudio.core.arrays import AnyArray, BoolArray, ByteArray, Float32Array, FloatArray, IntArray
from vomstudio.core.threads import thread_pool
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.geometry.kernels.jit import to_kernel_array

if TYPE_CHECKING:
    from concurrent.futures import ThreadPoolExecutor


# Reduction, number of sweeps over both colours, initial size of the random changes, and distance of
# the far neighbours.
_LEVELS = ((4, 4, 1.0, 5), (2, 3, 0.4, 3), (1, 1, 0.15, 0))
_MIN_SIDE_PX = 48
_MAX_COST = 0.35
_MAX_SIMILAR_COST = 0.5
_BLOCK_ROWS = 32
# Number of best sources of a plane: at least this many see most of the rock.
_N_SOURCES = 3


@dataclass(frozen=True, eq=False)
class PatchMatchResult:
    """Result of `match_patches`.

    inverse_depths : (h, w) inverse depths, 0 if unknown
    agreement_counts : (h, w) number of sources with a similar patch
    """

    inverse_depths: Float32Array
    agreement_counts: ByteArray


def match_patches(
    view: View,
    gray: ByteArray,
    is_active: BoolArray,
    known_inverse_depths: Float32Array,
    sources: Sequence[tuple[View, ByteArray, BoolArray]],
    points: FloatArray,
    min_depth: float,
    max_depth: float,
    *,
    seed: int = 0,
    threads: int = 1,
) -> PatchMatchResult:
    """Compute the inverse depths of the active pixels.

    Parameters
    ----------
    view, gray : View, (h, w) array
        Pinhole view and greyscale picture of the photo.
    is_active : (h, w) array of bool
        Pixels to compute.
    known_inverse_depths : (h, w) array
        Inverse depths, 0 if unknown; their planes are propagated.
    sources : sequence of (View, array, array of bool)
        View, picture and mask of each source.
    points : (n, 3) array
        Tie points of the photo, from which the depths are initialised.
    min_depth, max_depth : float
        Range of depths.
    seed, threads : int
        Random seed and number of threads; the result does not depend on the number of threads.
    """
    rng = np.random.default_rng(seed)
    planes: tuple[Float32Array, Float32Array] | None = None
    h, w = gray.shape
    levels = [level for level in _LEVELS if min(h, w) / level[0] >= _MIN_SIDE_PX] or [_LEVELS[-1]]
    costs = np.empty((0, 0, 0), np.float32)
    with thread_pool(threads) as pool:
        for reduction, sweeps, perturbation, radius in levels:
            pyramid_level = _PyramidLevel.make(view, gray, is_active, sources, reduction)
            fixed_inverse_depths = _downsample(known_inverse_depths, pyramid_level.reference.shape)
            if planes is None:
                depth, normal = _initial_planes(
                    pyramid_level.lens,
                    fixed_inverse_depths,
                    view,
                    points,
                    min_depth,
                    max_depth,
                    rng,
                )
                sweeps, perturbation, radius = _LEVELS[0][1:]
            else:
                depth, normal = _refine_planes(planes, pyramid_level.lens, min_depth, max_depth)
            has_depth = fixed_inverse_depths > 0
            depth[has_depth] = 1.0 / fixed_inverse_depths[has_depth]
            is_unmatched = to_kernel_array(pyramid_level.is_active & ~has_depth, np.uint8)
            costs = np.full((*pyramid_level.reference.shape, len(sources)), 2.0, np.float32)
            seeds = rng.integers(1, 2**32 - 1, pyramid_level.reference.size, dtype=np.uint32)
            inverse_depth_unit = np.float32(
                _inverse_depth_unit(view, pyramid_level.lens, [s[0] for s in sources])
            )
            arrays = (
                pyramid_level.reference,
                pyramid_level.pictures,
                pyramid_level.sizes,
                pyramid_level.rotations,
                pyramid_level.shifts,
            )
            arrays += (pyramid_level.k, is_unmatched, depth, normal, costs)  # type: ignore[assignment]
            for sweep_number in range(sweeps):
                size = np.float32(perturbation * 0.5**sweep_number)
                for parity in (0, 1):
                    _run_in_blocks(
                        pool,
                        pyramid_level.reference.shape[0],
                        _sweep_planes,
                        arrays,
                        (
                            seeds,
                            np.float32(min_depth),
                            np.float32(max_depth),
                            inverse_depth_unit,
                            size,
                            _N_SOURCES,
                            radius,
                            parity,
                        ),
                    )
            planes = depth, normal
        _run_in_blocks(pool, h, _measure_costs, arrays, ())
    inverse_depths = np.zeros((h, w), np.float32)
    is_similar = costs < _MAX_COST
    for s, (_, _, mask) in enumerate(sources):
        if not mask.all():
            is_similar[..., s] &= _is_on_source(view, sources[s][0], depth, mask)
    agreement_counts = is_similar.sum(axis=2).astype(np.uint8)
    is_confirmed = (is_unmatched > 0) & (agreement_counts >= 1)
    inverse_depths[is_confirmed] = 1.0 / depth[is_confirmed]
    _remove_specks(inverse_depths, float(inverse_depth_unit))
    agreement_counts[inverse_depths == 0] = 0
    return PatchMatchResult(inverse_depths, agreement_counts)


def count_similar_sources(
    view: View,
    gray: ByteArray,
    depth: Float32Array,
    normals: Float32Array,
    sources: Sequence[tuple[View, ByteArray, BoolArray]],
) -> ByteArray:
    """Return the number (h, w) of sources in which the patches of a depth map are similar.

    Large pictures are compared at half their size, which reduces noise and takes a quarter of the
    time. A patch without texture is never similar.

    depth, normals : (h, w), (h, w, 3) depth map of the photo, 0 if unknown
    """
    step = 2 if min(depth.shape) >= 2 * _MIN_SIDE_PX else 1
    h, w = depth.shape
    masked_sources = [(v, np.where(mask, g, np.uint8(0)), mask) for v, g, mask in sources]
    pyramid_level = _PyramidLevel.make(view, gray, depth > 0, masked_sources, step)
    reduced_depth = _downsample(depth, pyramid_level.reference.shape)
    height, width = reduced_depth.shape
    rows = ((np.arange(height) + 0.5) * h / height).astype(int)
    columns = ((np.arange(width) + 0.5) * w / width).astype(int)
    costs = np.full((height, width, len(sources)), 2.0, np.float32)
    _measure_costs(
        pyramid_level.reference,
        pyramid_level.pictures,
        pyramid_level.sizes,
        pyramid_level.rotations,
        pyramid_level.shifts,
        pyramid_level.k,
        to_kernel_array(reduced_depth > 0, np.uint8),
        to_kernel_array(reduced_depth, np.float32),
        to_kernel_array(normals[rows[:, None], columns], np.float32),
        costs,
        0,
        height,
    )
    row_indices = ((np.arange(h) + 0.5) * height / h).astype(int)[:, None]
    column_indices = ((np.arange(w) + 0.5) * width / w).astype(int)
    return np.asarray(
        (costs < _MAX_SIMILAR_COST).sum(axis=2).astype(np.uint8)[row_indices, column_indices]
    )


def _sweep_planes(reference: Float32Array, pictures: Float32Array, *arguments: object) -> None:
    from vomstudio.photogrammetry.dense._patchmatch_kernels import PATCH_SAMPLES, sweep_planes

    samples, n = np.empty((3, PATCH_SAMPLES), np.float32), len(pictures)
    trial, selection = np.empty(n, np.float32), np.empty(n, np.int64)
    sweep_planes(reference, pictures, *arguments, samples, trial, selection)


def _measure_costs(*arguments: object) -> None:
    from vomstudio.photogrammetry.dense._patchmatch_kernels import PATCH_SAMPLES, measure_costs

    measure_costs(*arguments, np.empty((3, PATCH_SAMPLES), np.float32))


def _run_in_blocks(
    pool: ThreadPoolExecutor,
    height: int,
    block_function: Callable[..., None],
    arrays: tuple[object, ...],
    settings: tuple[object, ...],
) -> None:
    """Run a kernel on blocks of rows.

    Pixels of one colour read only the planes of the other colour.
    """
    futures = [
        pool.submit(block_function, *arrays, *settings, top, min(top + _BLOCK_ROWS, height))
        for top in range(0, height, _BLOCK_ROWS)
    ]
    for future in futures:
        future.result()


@dataclass(frozen=True, eq=False)
class _PyramidLevel:
    """Pictures and cameras at one reduction level, as input of the kernels."""

    lens: Intrinsics
    reference: Float32Array
    is_active: BoolArray
    k: Float32Array
    pictures: Float32Array
    sizes: IntArray
    rotations: Float32Array
    shifts: Float32Array

    @classmethod
    def make(
        cls,
        view: View,
        gray: ByteArray,
        is_active: BoolArray,
        sources: Sequence[tuple[View, ByteArray, BoolArray]],
        reduction: int,
    ) -> _PyramidLevel:
        reference = _reduce_photo(gray, reduction)
        lens = view.intrinsics.scaled(reference.shape[1], reference.shape[0])
        (fx, fy), (cx, cy) = lens.focal, lens.centre
        k = np.array([1 / fx, 1 / fy, cx - 0.5, cy - 0.5], np.float32)
        inverse_matrix = np.linalg.inv(_pixel_centre_matrix(lens))
        reduced_photos = [_reduce_photo(source[1], reduction) for source in sources]
        height, width = np.max([reduced_photo.shape for reduced_photo in reduced_photos], axis=0)
        pictures = np.zeros((len(reduced_photos), height, width), np.float32)
        rotations, translations = (
            np.empty((len(reduced_photos), 3, 3)),
            np.empty((len(reduced_photos), 3)),
        )
        for s, (reduced_photo, source) in enumerate(zip(reduced_photos, sources, strict=True)):
            pictures[s, : reduced_photo.shape[0], : reduced_photo.shape[1]] = reduced_photo
            source_view = source[0]
            matrix = _pixel_centre_matrix(
                source_view.intrinsics.scaled(reduced_photo.shape[1], reduced_photo.shape[0])
            )
            rotation = source_view.rotation @ view.rotation.T
            rotations[s] = matrix @ rotation @ inverse_matrix
            translations[s] = matrix @ (source_view.translation - rotation @ view.translation)
        return cls(
            lens,
            reference,
            _downsample(is_active.astype(np.float32), reference.shape) > 0,
            k,
            pictures,
            np.array([reduced_photo.shape[::-1] for reduced_photo in reduced_photos], np.int64),
            rotations.astype(np.float32),
            translations.astype(np.float32),
        )


def _pixel_centre_matrix(lens: Intrinsics) -> FloatArray:
    """Return the calibration matrix for pixels counted from the centre of the first pixel."""
    half_pixel = np.array([[0.0, 0.0, 0.5], [0.0, 0.0, 0.5], [0.0, 0.0, 0.0]])
    return np.asarray(lens.matrix - half_pixel)


def _reduce_photo(gray: ByteArray, reduction: int) -> Float32Array:
    import cv2

    h, w = gray.shape
    if reduction > 1:
        size = (max(1, round(w / reduction)), max(1, round(h / reduction)))
        gray = np.asarray(cv2.resize(gray, size, interpolation=cv2.INTER_AREA))
    return np.ascontiguousarray(gray, np.float32) / np.float32(255.0)


def _downsample(values: Float32Array, shape: tuple[int, ...]) -> Float32Array:
    """Sample values at the centre of each larger pixel."""
    rows = ((np.arange(shape[0]) + 0.5) * values.shape[0] / shape[0]).astype(int)
    columns = ((np.arange(shape[1]) + 0.5) * values.shape[1] / shape[1]).astype(int)
    return np.asarray(values[rows[:, None], columns])


def _inverse_depth_unit(view: View, lens: Intrinsics, sources: Sequence[View]) -> float:
    bases = [np.linalg.norm(source_view.centre - view.centre) for source_view in sources]
    return float(1.0 / (np.mean(lens.focal) * np.median(bases)))


def _initial_planes(
    lens: Intrinsics,
    fixed_inverse_depths: Float32Array,
    view: View,
    points: FloatArray,
    min_depth: float,
    max_depth: float,
    rng: np.random.Generator,
) -> tuple[Float32Array, Float32Array]:
    """Return initial depths and normals.

    If there are enough tie points, half of the pixels get approximately the depth of the nearest
    one. The other depths are random. The normals point towards the camera.
    """
    from scipy.spatial import cKDTree

    shape = fixed_inverse_depths.shape
    inverse_depths = 1 / max_depth + (1 / min_depth - 1 / max_depth) * rng.random(shape)
    pixels, depths = lens.project(_transform_to_camera(view, points)), view.depths(points)
    is_valid = np.isfinite(pixels).all(axis=1) & (depths > min_depth) & (depths < max_depth)
    if is_valid.sum() > 3:
        x, y = np.meshgrid(np.arange(shape[1]) + 0.5, np.arange(shape[0]) + 0.5)
        _, nearest_rows = cKDTree(pixels[is_valid]).query(np.stack([x, y], axis=-1))
        jitter = 1.0 + 0.02 * rng.standard_normal(shape)
        is_from_tie_point = rng.random(shape) < 0.5
        inverse_depths = np.where(
            is_from_tie_point, jitter / depths[is_valid][nearest_rows], inverse_depths
        )
    normal = rng.normal(0.0, 0.25, (*shape, 3)) - [0.0, 0.0, 1.0]
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    depth = np.clip(1.0 / inverse_depths, min_depth, max_depth)
    return to_kernel_array(depth, np.float32), to_kernel_array(normal, np.float32)


def _transform_to_camera(view: View, points: FloatArray) -> FloatArray:
    return np.asarray(points @ view.rotation.T + view.translation)


def _refine_planes(
    planes: tuple[Float32Array, Float32Array], lens: Intrinsics, min_depth: float, max_depth: float
) -> tuple[Float32Array, Float32Array]:
    """Intersect the planes of a coarser level with the rays of a finer one."""
    depth, normal = planes
    h, w = lens.height, lens.width
    height, width = depth.shape
    rows = ((np.arange(h) + 0.5) * height / h).astype(int)
    columns = ((np.arange(w) + 0.5) * width / w).astype(int)
    z, n = depth[rows[:, None], columns], normal[rows[:, None], columns]
    (fx, fy), (cx, cy) = lens.focal, lens.centre

    def ray_slopes(x: AnyArray, y: AnyArray) -> FloatArray:
        return np.asarray(
            n[..., 0] * ((x - cx) / fx) + n[..., 1] * ((y - cy) / fy)[:, None] + n[..., 2]
        )

    slope_before = ray_slopes((columns + 0.5) * w / width, (rows + 0.5) * h / height)
    slope_after = ray_slopes(np.arange(w) + 0.5, np.arange(h) + 0.5)
    refined_depths = z * slope_before / np.where(slope_after < -0.05, slope_after, -1.0)
    is_accurate = (slope_after < -0.05) & (np.abs(refined_depths - z) < 0.1 * z)
    depth = np.clip(np.where(is_accurate, refined_depths, z), min_depth, max_depth)
    return to_kernel_array(depth, np.float32), to_kernel_array(n, np.float32)


def _is_on_source(
    view: View, other_view: View, depth: Float32Array, is_valid: BoolArray
) -> BoolArray:
    """Return which pixels show points on an unmasked part of the other photo."""
    h, w = depth.shape
    x, y = np.meshgrid(np.arange(w) + 0.5, np.arange(h) + 0.5)
    rays = view.intrinsics.rays(np.stack([x, y], axis=-1).reshape(-1, 2))
    points = (rays * depth.reshape(-1, 1) - view.translation) @ view.rotation
    pixels = other_view.project(points)
    is_on_source = other_view.contains(pixels)
    is_on_source[~np.isfinite(pixels).all(axis=1)] = False
    column = np.clip(np.where(is_on_source, pixels[:, 0], 0), 0, is_valid.shape[1] - 1).astype(int)
    row = np.clip(np.where(is_on_source, pixels[:, 1], 0), 0, is_valid.shape[0] - 1).astype(int)
    return np.asarray((is_on_source & is_valid[row, column]).reshape(h, w))


def _remove_specks(inverse_depths: Float32Array, unit: float) -> None:
    """Remove small patches that differ from their surroundings."""
    import cv2

    if not (inverse_depths > 0).any():
        return
    # By chance, single pixels also lie in front of or behind a surface. These differ from most of
    # their neighbours.
    median = np.asarray(cv2.medianBlur(inverse_depths, 5))
    inverse_depths[np.abs(inverse_depths - median) > unit] = 0.0
    if not (inverse_depths > 0).any():
        return
    min_inverse = float(inverse_depths[inverse_depths > 0].min())
    steps = np.where(inverse_depths > 0, (inverse_depths - min_inverse) / (0.125 * unit) + 1.0, 0.0)
    levels = np.ascontiguousarray(np.minimum(steps, 32_000), np.int16)
    cv2.filterSpeckles(levels, 0, 60, 16)
    inverse_depths[levels == 0] = 0.0
