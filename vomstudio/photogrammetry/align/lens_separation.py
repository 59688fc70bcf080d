"""Grouping of photos without EXIF by the lens with which they were taken.

Photos of the same size without camera metadata are treated as photos of one camera. If they are not
(a zoomed phone, two cameras of the same format, cropped pictures), a single focal length for all of
them bends the scene: it looks valid, but camera positions are wrong by a tenth of their distance.
The focal length of every such photo is therefore estimated from its fundamental matrices (Sweeney,
Kneip, Hoellerer and Turk 2015, ICCV; implemented in COLMAP). If the focal lengths differ, the
photos are placed with separate lenses, similar lenses are merged, and the photos are placed again.
The result is used if it fits clearly better.
"""

from __future__ import annotations

import itertools
import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.files.regular import require_regular_file
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import tr_n
from vomstudio.photogrammetry.align import mapping, match_database
from vomstudio.photogrammetry.align.features import Features
from vomstudio.photogrammetry.align.mapping import MappingOptions, MappingResult
from vomstudio.photogrammetry.align.photo_protocol import PhotoLike
from vomstudio.photogrammetry.base.colmap import colmap, run_cancellable

# Standard deviation of the logarithm of the focal lengths from pairs. For photos of one lens it is
# less than 0.01, or 0.1 with strong distortion.
_MAX_LOG_SCATTER = 0.08
# Maximum relative difference between focal lengths of the same lens after mapping.
_MAX_LOG_FOCAL_GAP = 0.06
# Maximum ratio of the new reprojection error to the previous one. Wrong lenses more than double the
# error.
_MAX_ERROR_RATIO = 0.8


def separate_lenses(
    database: Path,
    photos: Sequence[PhotoLike],
    features: Sequence[Features],
    work_folder: Path,
    options: MappingOptions,
    current_reconstructions: Sequence[Any],
    progress: Progress,
) -> MappingResult | None:
    """Map the photos again, with separate lenses for photos without EXIF.

    Returns None if these photos do not show different lenses or if the new reconstruction does not
    fit clearly better than the present one. Raises Cancelled.

    database : database of these photos, with matches
    """
    groups = group_unknown_photos(photos)
    if not groups or not current_reconstructions:
        return None
    scratch_folder = work_folder / "lenses"
    shutil.rmtree(scratch_folder, ignore_errors=True)
    scratch_folder.mkdir()
    try:
        lens_numbers = [0] * len(photos)
        for group in groups:
            for number, row in enumerate(group):
                lens_numbers[row] = number + 1
        separate_database = _create_database(
            database, scratch_folder / "own.db", photos, features, lens_numbers
        )
        focals = _estimate_focal_lengths(separate_database, options, progress)
        if all(float(np.std(np.log([focals[r] for r in g]))) < _MAX_LOG_SCATTER for g in groups):
            return None
        separate_mapping = mapping.map_photos(
            separate_database, photos, scratch_folder, options, progress
        ).reconstructions
        if not separate_mapping:
            return None
        lenses, sizes = _merge_similar_lenses(separate_mapping[0], groups, len(photos))
        if not any(lenses):
            return None
        merged_database = _create_database(
            database, scratch_folder / "joined.db", photos, features, lenses
        )
        mapping_result = mapping.map_photos(
            merged_database, photos, scratch_folder, options, progress
        )
        if not mapping_result.reconstructions or not _is_better(
            mapping_result.reconstructions[0], current_reconstructions[0]
        ):
            return None
    finally:
        shutil.rmtree(scratch_folder, ignore_errors=True)
    note = Finding(
        "lens.several-lenses",
        lenses=len(sizes),
        groups=", ".join(
            tr_n("{count} photo: {focal:.0f} px", "{count} photos: {focal:.0f} px", n, focal=focal)
            for focal, n in sizes
        ),
        after_px=_reprojection_error(mapping_result.reconstructions[0]),
        before_px=_reprojection_error(current_reconstructions[0]),
    )
    return replace(mapping_result, notes=(*mapping_result.notes, note))


def group_unknown_photos(photos: Sequence[PhotoLike]) -> list[list[int]]:
    """Group the photos (rows) without an EXIF focal length that share a camera.

    Groups of fewer than three photos are omitted.
    """
    groups: dict[tuple[object, ...], list[int]] = {}
    for row, photo in enumerate(photos):
        if photo.focal_px is None:
            key = (photo.camera_key, photo.width, photo.height)
            groups.setdefault(key, []).append(row)
    return [rows for rows in groups.values() if len(rows) > 2]


def _create_database(
    source: Path,
    path: Path,
    photos: Sequence[PhotoLike],
    features: Sequence[Features],
    lenses: Sequence[int],
) -> Path:
    """Create a database with the given lenses and the pairs of `source`."""
    keys = [str(row) for row in range(len(photos))]
    match_database.open_database(path, photos, features, keys, lenses)
    match_database.copy_pairs(source, path)
    return path


def _estimate_focal_lengths(
    database: Path, options: MappingOptions, progress: Progress
) -> list[float]:
    """Estimate the focal length of every photo from its pairs, with one camera per photo."""
    pycolmap = colmap()
    settings = pycolmap.ViewGraphCalibrationOptions()
    settings.random_seed = options.seed
    settings.reestimate_relative_pose = False
    trial = database.with_name("pairs.db")
    require_regular_file(database)
    shutil.copy(database, trial)
    run_cancellable(lambda _token: pycolmap.calibrate_view_graph(trial, settings), progress)
    connection = pycolmap.Database.open(trial)
    try:
        focal = {c.camera_id: float(c.params[0]) for c in connection.read_all_cameras()}
        images = sorted(connection.read_all_images(), key=lambda image: image.image_id)
        return [focal[image.camera_id] for image in images]
    finally:
        connection.close()


def _merge_similar_lenses(
    reconstruction: Any, groups: Sequence[Sequence[int]], count: int
) -> tuple[list[int], list[tuple[float, int]]]:
    """Merge lenses with similar focal lengths.

    Returns
    -------
    lenses : list of int
        Lens of every photo within its group, 0 for the most common one and for photos without a
        pose.
    sizes : list of (float, int)
        Focal length and number of photos of each lens in the groups.
    """
    lenses, sizes = [0] * count, []
    for group in groups:
        placed_group = [r for r in group if reconstruction.exists_image(r + 1)]
        placed_group = [r for r in placed_group if reconstruction.image(r + 1).has_pose]
        if not placed_group:
            continue
        focal = {
            r: float(reconstruction.camera(reconstruction.image(r + 1).camera_id).params[0])
            for r in placed_group
        }
        order = sorted(placed_group, key=lambda r: focal[r])
        clusters = [[order[0]]]
        for previous_row, row in itertools.pairwise(order):
            if np.log(focal[row] / focal[previous_row]) > _MAX_LOG_FOCAL_GAP:
                clusters.append([])
            clusters[-1].append(row)
        clusters.sort(key=len, reverse=True)
        for number, cluster in enumerate(clusters):
            sizes.append((float(np.median([focal[r] for r in cluster])), len(cluster)))
            for row in cluster:
                lenses[row] = number
    return lenses, sizes


def _is_better(new: Any, current: Any) -> bool:
    """Return whether a mapping has at least as many photos and clearly smaller residuals."""
    return new.num_reg_images() >= current.num_reg_images() and _reprojection_error(
        new
    ) < _MAX_ERROR_RATIO * _reprojection_error(current)


def _reprojection_error(reconstruction: Any) -> float:
    reconstruction.update_point_3d_errors()
    return float(reconstruction.compute_mean_reprojection_error())
