"""Depth map of a photo, computed from all of its pairs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import BoolArray, ByteArray, Float32Array, FloatArray
from vomstudio.core.errors import GeometryError, InputError
from vomstudio.core.files.arrays import open_arrays
from vomstudio.core.files.disk_errors import damage_reason
from vomstudio.core.findings import Finding
from vomstudio.geometry.cameras import View
from vomstudio.geometry.kernels.jit import to_kernel_array
from vomstudio.io.photos.cameras_file import view_from_dict, view_to_dict
from vomstudio.photogrammetry.dense.foreground_fattening import find_sky_fringe
from vomstudio.photogrammetry.dense.pairs import N_SOURCES, PATCHMATCH, SGBM, DepthMapPlan
from vomstudio.photogrammetry.dense.undistortion import UndistortedPhoto


@dataclass(frozen=True)
class DepthOptions:
    """Options of depth maps.

    Attributes
    ----------
    max_mark_distance_px : float
        Maximum difference between the disparities of agreeing sources.
    min_sources : int
        Minimum number of agreeing sources.
    min_measured_share : float
        If SGBM measures a larger share of the tie points, PatchMatch is not used.
    seed, threads : int
        Random seed and number of threads of PatchMatch; the result does not depend on the threads.
    """

    max_mark_distance_px: float = 1.0
    min_sources: int = 1
    min_measured_share: float = 0.85
    seed: int = 0
    threads: int = 1


@dataclass(frozen=True, eq=False)
class DepthTask:
    """Input for the computation of one depth map.

    Attributes
    ----------
    reference : UndistortedPhoto
        Photo of the depth map.
    sources, methods : tuple
        Source photos, and the method for each, "sgbm" or "patchmatch".
    near, far : float
        Range of depths.
    points : (n, 3) array
        Tie points that the reference sees.
    """

    reference: UndistortedPhoto
    sources: tuple[UndistortedPhoto, ...]
    methods: tuple[str, ...]
    near: float
    far: float
    points: FloatArray
    options: DepthOptions = field(default_factory=DepthOptions)


@dataclass(frozen=True, eq=False)
class DepthMap:
    """Depth map of a photo.

    Attributes
    ----------
    name : str
    view : View
        Pinhole view of the map.
    depth : (h, w) float32 array
        Depth along the optical axis at the centre of each pixel; 0 if unknown.
    normals : (h, w, 3) float32 array
        Unit normals towards the camera, in the camera frame; 0 if unknown.
    confidence : (h, w) uint8 array
        Confidence, 0 to 255; each agreeing source halves the difference from 255.
    """

    name: str
    view: View
    depth: Float32Array
    normals: Float32Array
    confidence: ByteArray

    @property
    def filled(self) -> float:
        """Share of pixels that have a depth."""
        return float(np.mean(self.depth > 0))

    def save(self, path: str | Path) -> None:
        """Write the map to an npz file, with normals in half precision (0.03 degrees)."""
        import json

        with open(path, "wb") as file:
            np.savez(
                file,
                view=np.array(json.dumps(view_to_dict(self.view))),
                depth=self.depth,
                normals=self.normals.astype(np.float16),
                confidence=self.confidence,
            )

    @classmethod
    def load(cls, path: str | Path) -> DepthMap:
        """Load a depth map. Raises InputError if the file is incomplete."""
        import json

        try:
            with open_arrays(path) as arrays:
                view = view_from_dict(json.loads(str(arrays["view"])))
                return cls(
                    view.name,
                    view,
                    arrays["depth"],
                    arrays["normals"].astype(np.float32),
                    arrays["confidence"],
                )
        except (OSError, ValueError, KeyError, TypeError, EOFError) as error:
            raise InputError(
                Finding("reconstruct.damaged", reason=damage_reason(error)),
                file=path,
            ) from error


def make_task(
    plan: DepthMapPlan,
    photo: Callable[[int], UndistortedPhoto],
    options: DepthOptions | None = None,
) -> DepthTask:
    """Return the task of a plan; `photo` maps the row of a view to its undistorted photo."""
    return DepthTask(
        photo(plan.view),
        tuple(photo(source.view) for source in plan.sources),
        tuple(source.method for source in plan.sources),
        plan.near,
        plan.far,
        plan.points,
        options or DepthOptions(),
    )


def depth_map(task: DepthTask) -> DepthMap:
    """Compute depths, normals and confidence of one photo.

    The map is empty if the photo is completely masked or has no matches.

    Raises
    ------
    GeometryError
        If the task is invalid: no sources, a source without a method or at the position of the
        reference, no depth range, or a lens with distortion.
    InputError
        If a photo cannot be read.
    """
    _check_task(task)
    view, is_valid = task.reference.view, task.reference.valid_mask
    if not is_valid.any():
        return _empty_depth_map(view, is_valid.shape)
    reference = (view, task.reference.gray(), is_valid)
    other_photos = [(source.view, source.gray(), source.valid_mask) for source in task.sources]
    inverse_depths, agreement_counts = _match_rectified_pairs(task, reference, other_photos)
    # Remove the noise that small windows leave, without smoothing across edges.
    inverse_depths = _fit_planes(view, inverse_depths, 1.0, 1, 1)[1]
    if (
        PATCHMATCH in task.methods
        and _measured_share(task, inverse_depths) < task.options.min_measured_share
    ):
        _fill_by_patchmatch(task, reference, other_photos, inverse_depths, agreement_counts)
    return _finish_depth_map(reference, other_photos, inverse_depths, agreement_counts)


def peak_memory_bytes(width: int, height: int, sources: int = N_SOURCES) -> int:
    """Estimate the peak memory of `depth_map` including its inputs, in bytes.

    Measured with four sources: 50 to 70 bytes per pixel if all pairs can be rectified, and 122 with
    PatchMatch, including 12 for each source.
    """
    return int(width * height * (14 * sources + 80) + 20_000_000)


PhotoArrays = tuple[View, ByteArray, BoolArray]


def _match_rectified_pairs(
    task: DepthTask, reference: PhotoArrays, other_photos: Sequence[PhotoArrays]
) -> tuple[Float32Array, ByteArray]:
    """Return inverse depths from rectified pairs, and the number of agreeing sources."""
    from vomstudio.photogrammetry.dense._depth_kernels import merge_depths
    from vomstudio.photogrammetry.dense.sgbm import pair_inverse_depth

    shape = reference[1].shape
    merged_inverse_depths, agreement_counts = np.zeros(shape, np.float32), np.zeros(shape, np.uint8)
    pair_inverse_depths, steps = [], []
    for other_photo, method in zip(other_photos, task.methods, strict=True):
        if method == SGBM:
            pair_depths = pair_inverse_depth(
                reference, other_photo, task.points, task.near, task.far
            )
            if pair_depths is not None:
                pair_inverse_depths.append(pair_depths[0])
                steps.append(pair_depths[1])
    if pair_inverse_depths:
        merge_depths(
            np.stack(pair_inverse_depths),
            np.array(steps, np.float32),
            np.float32(task.options.max_mark_distance_px),
            np.float32(1.0 / task.far),
            np.float32(1.0 / task.near),
            min(task.options.min_sources, len(pair_inverse_depths)),
            merged_inverse_depths,
            agreement_counts,
        )
    return merged_inverse_depths, agreement_counts


def _measured_share(task: DepthTask, inverse_depths: Float32Array) -> float:
    """Return the share of the photo's unmasked tie points that have a depth.

    Returns 0 if there are no such points.
    """
    view, is_valid = task.reference.view, task.reference.valid_mask
    pixels = view.project(task.points)
    pixels = pixels[np.isfinite(pixels).all(axis=1)]
    column, row = np.floor(pixels).astype(int).T
    is_on_photo = (
        (column >= 0) & (row >= 0) & (column < is_valid.shape[1]) & (row < is_valid.shape[0])
    )
    column, row = column[is_on_photo], row[is_on_photo]
    is_unmasked = is_valid[row, column]
    return (
        float(np.mean(inverse_depths[row, column][is_unmasked] > 0)) if is_unmasked.any() else 0.0
    )


def _fill_by_patchmatch(
    task: DepthTask,
    reference: PhotoArrays,
    other_photos: Sequence[PhotoArrays],
    inverse_depths: Float32Array,
    agreement_counts: ByteArray,
) -> None:
    """Fill missing depths with PatchMatch, in place."""
    from vomstudio.photogrammetry.dense.patchmatch import match_patches

    is_unmeasured = reference[2] & (inverse_depths == 0)
    result = match_patches(
        reference[0],
        reference[1],
        is_unmeasured,
        inverse_depths,
        other_photos,
        task.points,
        task.near,
        task.far,
        seed=task.options.seed,
        threads=task.options.threads,
    )
    # Each pixel was fitted separately, so a plane through its neighbours is more accurate.
    smoothed_inverse_depths = _fit_planes(reference[0], result.inverse_depths, 2.0, 3, 1)[1]
    inverse_depths[is_unmeasured] = smoothed_inverse_depths[is_unmeasured]
    agreement_counts[is_unmeasured] = result.agreement_counts[is_unmeasured]


def _check_task(task: DepthTask) -> None:
    name = task.reference.view.name
    if not task.sources:
        raise GeometryError(Finding("dense.no-sources"), file=name)
    if len(task.sources) != len(task.methods):
        raise GeometryError(Finding("dense.no-method"), file=name)
    if not 0 < task.near < task.far < np.inf:
        raise GeometryError(
            Finding("dense.depth-range", near=task.near, far=task.far),
            file=name,
        )
    for photo in (task.reference, *task.sources):
        if photo.view.intrinsics.has_distortion:
            raise GeometryError(Finding("dense.distorted"), file=photo.view.name)
    for photo in task.sources:
        if not np.linalg.norm(photo.view.centre - task.reference.view.centre) > 0:
            raise GeometryError(
                Finding("dense.no-base", photo=photo.view.name),
                file=name,
            )


def _finish_depth_map(
    reference: PhotoArrays,
    other_photos: Sequence[PhotoArrays],
    inverse_depths: Float32Array,
    agreement_counts: ByteArray,
) -> DepthMap:
    """Create the depth map, without depths that no other photo confirms.

    Matching assigns smooth disparities even to sky and featureless surfaces, and a wrong pair may
    still be consistent with itself.
    """
    from vomstudio.photogrammetry.dense.patchmatch import count_similar_sources

    view = reference[0]
    normals = _fit_planes(view, inverse_depths, 4.0, 4, 2)[0]
    is_measured = (inverse_depths > 0) & normals.any(axis=2)
    depth = np.zeros_like(inverse_depths)
    np.divide(1.0, inverse_depths, out=depth, where=is_measured)
    similar_counts = count_similar_sources(view, reference[1], depth, normals, other_photos)
    is_measured &= similar_counts > 0
    is_measured &= ~find_sky_fringe(reference[1], reference[2], is_measured)
    depth[~is_measured] = 0.0
    normals[~is_measured] = 0.0
    agreement_counts = np.maximum(agreement_counts, similar_counts)
    confidence = np.where(
        is_measured, 255.0 * (1.0 - 0.5 ** agreement_counts.astype(np.float32)), 0.0
    )
    return DepthMap(view.name, view, depth, normals, np.round(confidence).astype(np.uint8))


def _fit_planes(
    view: View, inverse_depths: Float32Array, max_steepness: float, radius: int, stride: int
) -> tuple[Float32Array, Float32Array]:
    """Fit planes to neighbouring pixels; return normals (h, w, 3) and inverse depths (h, w)."""
    from vomstudio.photogrammetry.dense._depth_kernels import fit_plane_normals

    (fx, fy), (cx, cy) = view.intrinsics.focal, view.intrinsics.centre
    normals = np.empty((*inverse_depths.shape, 3), np.float32)
    smoothed_inverse_depths = np.empty(inverse_depths.shape, np.float32)
    fit_plane_normals(
        to_kernel_array(inverse_depths, np.float32),
        np.float32(max_steepness / min(fx, fy)),
        radius,
        stride,
        fx,
        fy,
        cx - 0.5,
        cy - 0.5,
        normals,
        smoothed_inverse_depths,
    )
    return normals, smoothed_inverse_depths


def _empty_depth_map(view: View, shape: tuple[int, ...]) -> DepthMap:
    return DepthMap(
        view.name,
        view,
        np.zeros(shape, np.float32),
        np.zeros((*shape, 3), np.float32),
        np.zeros(shape, np.uint8),
    )
