"""Computation of cameras and tie points from matches with COLMAP's mappers.

Schönberger & Frahm 2016 (CVPR), structure from motion revisited; Pan et al. 2024 (ECCV) for global
mapping.
"""

from __future__ import annotations

import shutil
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from vomstudio.core.arrays import Float32Array, FloatArray, IntArray
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import tr
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.photogrammetry.align.features import Features
from vomstudio.photogrammetry.align.photo_protocol import PhotoLike
from vomstudio.photogrammetry.base.colmap import colmap, run_cancellable
from vomstudio.photogrammetry.base.scene import SparseScene

# The run time of incremental mapping grows faster than the number of photos.
_MAX_INCREMENTAL_PHOTOS = 300
# If a smaller share of the photos is placed, the EXIF focal lengths are freed.
_MIN_PLACED_SHARE = 0.9


FreeFocals = Literal["none", "unknown", "all"]
"""Focal lengths that are free during mapping; "unknown" selects those missing from EXIF."""


@dataclass(frozen=True)
class MappingOptions:
    """Options of mapping.

    mapper : "auto" selects the global mapper for more than 300 photos
    threads : number of threads; -1 uses all cores. With 1, the same seed gives bit-identical
    results.
    """

    mapper: Literal["auto", "incremental", "global"] = "auto"
    threads: int = -1
    seed: int = 0


@dataclass(frozen=True, eq=False)
class MappingResult:
    """Result of mapping.

    Attributes
    ----------
    reconstructions : tuple of pycolmap.Reconstruction
        Reconstructions of the connected components, largest first.
    notes : tuple of Finding
    is_exif_trusted : bool
        False if more photos could be placed without the focal lengths from EXIF.
    """

    reconstructions: tuple[Any, ...]
    notes: tuple[Finding, ...] = ()
    is_exif_trusted: bool = True


def map_photos(
    database: Path,
    photos: Sequence[PhotoLike],
    work_folder: Path,
    options: MappingOptions,
    progress: Progress,
) -> MappingResult:
    """Compute poses and tie points from the matches in a database.

    Focal lengths from EXIF are fixed during mapping; the global mapper fixes them only if all
    photos have one. If more than a tenth of the photos are missing from the largest part, mapping
    is repeated with free focal lengths, since EXIF does not account for digital zoom. The result
    with more photos is used. Raises Cancelled.
    """
    has_focal = [p.focal_px is not None for p in photos]
    if options.mapper == "auto":
        mapper = "incremental" if len(photos) <= _MAX_INCREMENTAL_PHOTOS else "global"
    else:
        mapper = options.mapper
    run = _map_incrementally if mapper == "incremental" else _map_globally
    notes: list[Finding] = []
    if mapper == "global":
        notes.append(Finding("alignment.global-mapping"))
    free_text: FreeFocals = "none" if all(has_focal) else "unknown"
    parts = run(database, photos, work_folder, options, progress, free_text)
    placed_count = _count_placed_photos(parts)
    if any(has_focal) and placed_count < _MIN_PLACED_SHARE * len(photos):
        other_parts = run(database, photos, work_folder, options, progress, "all")
        if _count_placed_photos(other_parts) > placed_count:
            notes.append(
                Finding(
                    "alignment.exif-focal-dropped",
                    aligned=placed_count,
                    aligned_without=_count_placed_photos(other_parts),
                )
            )
            return MappingResult(tuple(other_parts), tuple(notes), is_exif_trusted=False)
    return MappingResult(tuple(parts), tuple(notes))


def _count_placed_photos(parts: Sequence[Any]) -> int:
    return int(parts[0].num_reg_images()) if parts else 0


def _map_incrementally(
    database: Path,
    photos: Sequence[PhotoLike],
    work_folder: Path,
    options: MappingOptions,
    progress: Progress,
    free_focals: FreeFocals,
) -> list[Any]:
    pycolmap = colmap()
    settings = pycolmap.IncrementalPipelineOptions()
    settings.extract_colors = False
    settings.random_seed = options.seed
    settings.num_threads = options.threads
    settings.min_model_size = 2
    settings.ba_refine_focal_length = free_focals != "none"
    settings.mapper.abs_pose_refine_focal_length = free_focals != "none"
    # With many photos, points seen in only two of them are more often wrong matches. With only two
    # photos, every point is seen in two.
    settings.triangulation.ignore_two_view_tracks = len(photos) > 3
    if free_focals == "unknown":
        settings.constant_cameras = _known_cameras(database)
    progress.stage(tr("Computing poses"), len(photos))
    placed_count = [0]

    def count_next_image() -> None:
        placed_count[0] = min(placed_count[0] + 1, len(photos))

    def count_initial_pair() -> None:
        placed_count[0] = min(placed_count[0] + 2, len(photos))

    folder = _make_empty_folder(work_folder / "mapping")
    reconstructions = run_cancellable(
        lambda token: pycolmap.incremental_mapping(
            database,
            work_folder,
            folder,
            settings,
            initial_image_pair_callback=count_initial_pair,
            next_image_callback=count_next_image,
            cancellation_token=token,
        ),
        progress,
        lambda: placed_count[0],
    )
    progress.step(placed_count[0])
    shutil.rmtree(folder, ignore_errors=True)
    return _sort_parts(reconstructions)


def _map_globally(
    database: Path,
    photos: Sequence[PhotoLike],
    work_folder: Path,
    options: MappingOptions,
    progress: Progress,
    free_focals: FreeFocals,
) -> list[Any]:
    pycolmap = colmap()
    settings = pycolmap.GlobalPipelineOptions()
    settings.num_threads = options.threads
    settings.random_seed = options.seed
    settings.min_model_size = 2
    settings.mapper.bundle_adjustment.refine_focal_length = free_focals != "none"
    progress.stage(tr("Computing poses"))
    folder = _make_empty_folder(work_folder / "mapping")
    # The mapper cannot be interrupted: to cancel, wait until it ends or kill the worker.
    reconstructions = run_cancellable(
        lambda token: pycolmap.global_mapping(database, work_folder, folder, settings), progress
    )
    shutil.rmtree(folder, ignore_errors=True)
    return _sort_parts(reconstructions)


def _make_empty_folder(folder: Path) -> Path:
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder


def _known_cameras(database: Path) -> set[int]:
    connection = colmap().Database.open(database)
    try:
        return {c.camera_id for c in connection.read_all_cameras() if c.has_prior_focal_length}
    finally:
        connection.close()


def _sort_parts(reconstructions: dict[int, Any]) -> list[Any]:
    """Sort the parts by number of photos, and drop those that add fewer than two photos.

    COLMAP may place a photo in several parts; `shared_images` lists these photos for each part.
    """
    order = sorted(
        reconstructions,
        key=lambda k: (-reconstructions[k].num_reg_images(), -reconstructions[k].num_points3D(), k),
    )
    parts: list[Any] = []
    placed_images: set[int] = set()
    for key in order:
        images = set(reconstructions[key].reg_image_ids())
        if len(images - placed_images) < 2:
            continue
        parts.append(reconstructions[key])
        placed_images |= images
    return parts


def shared_images(parts: Sequence[Any]) -> list[set[int]]:
    """List the images of each part that also belong to an earlier part."""
    images_by_part: list[set[int]] = []
    placed_images: set[int] = set()
    for part in parts:
        images = set(part.reg_image_ids())
        images_by_part.append(images & placed_images)
        placed_images |= images
    return images_by_part


def remove_images(reconstruction: Any, images: Collection[int]) -> None:
    """Remove images and their observations.

    Points that fewer than two other images observe are removed too.
    """
    for image in sorted(images):
        reconstruction.deregister_frame(reconstruction.image(image).frame_id)
    # Until this call, COLMAP keeps a deregistered frame without a pose.
    reconstruction.tear_down()


# ------------------------------------------------------------------------------------------------
def convert_camera(camera: Any) -> Intrinsics:
    """Convert a COLMAP camera; the names and the order of the parameters do not change."""
    return Intrinsics(
        str(camera.model_name),
        int(camera.width),
        int(camera.height),
        tuple(float(p) for p in camera.params),
    )


def to_scene(
    reconstruction: Any, photos: Sequence[PhotoLike], features: Sequence[Features]
) -> SparseScene:
    """Convert a reconstruction, in which image i + 1 is photo number i, to a scene.

    Cameras are in the order of the photos, and points in the order of their numbers, so that the
    same reconstruction always gives the same scene.
    """
    images = sorted(reconstruction.reg_image_ids())
    row_by_image = {image: row for row, image in enumerate(images)}
    lenses: dict[int, Intrinsics] = {}
    views = []
    for image_id in images:
        image = reconstruction.image(image_id)
        if image.camera_id not in lenses:
            lenses[image.camera_id] = convert_camera(reconstruction.camera(image.camera_id))
        pose = np.asarray(image.cam_from_world().matrix(), np.float64)
        views.append(
            View(
                photos[image_id - 1].name,
                lenses[image.camera_id],
                np.ascontiguousarray(pose[:, :3]),
                np.ascontiguousarray(pose[:, 3]),
            )
        )
    ids = sorted(reconstruction.point3D_ids())
    points = np.zeros((len(ids), 3))
    lengths = np.zeros(len(ids), np.int64)
    track_images: list[int] = []
    track_indices: list[int] = []
    for row, key in enumerate(ids):
        point = reconstruction.point3D(key)
        points[row] = point.xyz
        elements = sorted((e.image_id, e.point2D_idx) for e in point.track.elements)
        lengths[row] = len(elements)
        track_images += [image for image, _ in elements]
        track_indices += [number for _, number in elements]
    track_views = np.array([row_by_image[i] for i in track_images], np.int32)
    numbers = np.array(track_indices, np.intp)
    pixels = np.zeros((len(track_images), 2), np.float32)
    colors = np.zeros((len(track_images), 3), np.float64)
    for row, image_id in enumerate(images):
        rows_of_view = np.flatnonzero(track_views == row)
        photo_features = features[image_id - 1]
        # Use the pixels of the reconstruction, which may contain marks as well as features.
        image_pixels = np.array([p.xy for p in reconstruction.image(image_id).points2D]).reshape(
            -1, 2
        )
        pixels[rows_of_view] = image_pixels[numbers[rows_of_view]]
        is_inside = numbers[rows_of_view] < len(photo_features.colors)
        colors[rows_of_view[is_inside]] = photo_features.colors[numbers[rows_of_view[is_inside]]]
    offsets = np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)
    scene = SparseScene(
        tuple(views),
        points,
        _grouped_means(colors, offsets).round().astype(np.uint8),
        np.zeros(len(ids), np.float32),
        offsets,
        track_views,
        pixels,
    )
    return replace(scene, errors_px=point_errors(scene))


def residuals(scene: SparseScene) -> FloatArray:
    """Return the residuals (m, 2), observed minus projected, in pixels; NaN behind a camera."""
    misclosures = np.full((len(scene.track_views), 2), np.nan)
    points = scene.points[scene.track_points]
    for row, view in enumerate(scene.views):
        is_in_view = scene.track_views == row
        misclosures[is_in_view] = scene.track_pixels[is_in_view] - view.project(points[is_in_view])
    return misclosures


def point_errors(scene: SparseScene) -> Float32Array:
    """Return the mean length (n,) of each point's residuals, in pixels."""
    lengths = np.linalg.norm(residuals(scene), axis=1)[:, None]
    return _grouped_means(lengths, scene.track_offsets)[:, 0].astype(np.float32)


def mean_error(scene: SparseScene) -> float:
    """Return the mean error of the points, in pixels; 0 if there are no points."""
    errors = point_errors(scene)
    return float(np.nanmean(errors)) if len(errors) else 0.0


def _grouped_means(values: FloatArray, offsets: IntArray) -> FloatArray:
    if len(offsets) < 2:
        return np.zeros((0, values.shape[1]))
    return np.add.reduceat(values, offsets[:-1], axis=0) / np.diff(offsets)[:, None]
