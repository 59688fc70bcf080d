"""Which photos without EXIF were taken through one lens.

Photos of one size that say nothing of their camera are taken for photos of one camera. Where they
are not (a phone that was zoomed, two cameras of one format, pixels cut out), one focal length for
all bends the scene to fit: it then looks sound, and cameras are wrong by a tenth of it. So the
focal length of every such photo is estimated by itself from its fundamental matrices (Sweeney,
Kneip, Hoellerer and Turk 2015, ICCV, by COLMAP). Where these differ, the photos are placed with
lenses of their own, lenses that come out alike are made one, and the photos are placed with these;
that is kept where it explains the photos clearly better.
"""

from __future__ import annotations

import itertools
import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.files.regular import require_regular
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.core.words import tr_n
from vomstudio.photogrammetry.align import mapping, match_database
from vomstudio.photogrammetry.align.features import Features
from vomstudio.photogrammetry.align.mapping import Mapped, MappingOptions
from vomstudio.photogrammetry.align.photo_protocol import PhotoLike
from vomstudio.photogrammetry.base.colmap import cancellable, colmap

# Of the natural logarithm of focal lengths, each from its pairs alone: photos of one lens scatter
# by less than a hundredth, by a tenth with strong distortion.
_SUSPICIOUS = 0.08
# Lenses after their photos were placed: an unknown focal length is known to a few per cent then.
_ALIKE = 0.06
# Of the reprojection error with one lens: mistaken lenses leave more than twice the error.
_CLEARLY_BETTER = 0.8


def separate_lenses(
    database: Path,
    photos: Sequence[PhotoLike],
    features: Sequence[Features],
    work: Path,
    options: MappingOptions,
    found: Sequence[Any],
    progress: Progress,
) -> Mapped | None:
    """The mapping with separate lenses, None where the `found` reconstructions are as good.

    database : matched, of these photos. Raises Cancelled.
    """
    groups = unknown_groups(photos)
    if not groups or not found:
        return None
    scratch = work / "lenses"
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir()
    try:
        own = [0] * len(photos)
        for group in groups:
            for number, row in enumerate(group):
                own[row] = number + 1
        apart = _database(database, scratch / "own.db", photos, features, own)
        focals = _from_pairs(apart, options, progress)
        if all(float(np.std(np.log([focals[r] for r in g]))) < _SUSPICIOUS for g in groups):
            return None
        others = mapping.map_photos(apart, photos, scratch, options, progress).reconstructions
        if not others:
            return None
        lenses, sizes = _alike(others[0], groups, len(photos))
        if not any(lenses):
            return None
        joined = _database(database, scratch / "joined.db", photos, features, lenses)
        mapped = mapping.map_photos(joined, photos, scratch, options, progress)
        if not mapped.reconstructions or not _better(mapped.reconstructions[0], found[0]):
            return None
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    note = Finding(
        "lens.several-lenses",
        lenses=len(sizes),
        groups=", ".join(
            tr_n("{count} photo: {focal:.0f} px", "{count} photos: {focal:.0f} px", n, focal=focal)
            for focal, n in sizes
        ),
        after_px=_error(mapped.reconstructions[0]),
        before_px=_error(found[0]),
    )
    return replace(mapped, notes=(*mapped.notes, note))


def unknown_groups(photos: Sequence[PhotoLike]) -> list[list[int]]:
    """Rows of the photos that are taken for one camera for want of EXIF, three or more each."""
    groups: dict[tuple[object, ...], list[int]] = {}
    for row, photo in enumerate(photos):
        if photo.focal_px is None:
            key = (photo.camera_key, photo.width, photo.height)
            groups.setdefault(key, []).append(row)
    return [rows for rows in groups.values() if len(rows) > 2]


def _database(
    source: Path,
    path: Path,
    photos: Sequence[PhotoLike],
    features: Sequence[Features],
    lenses: Sequence[int],
) -> Path:
    """A database with other cameras and the pairs of `source`."""
    keys = [str(row) for row in range(len(photos))]
    match_database.open_database(path, photos, features, keys, lenses)
    match_database.copy_pairs(source, path)
    return path


def _from_pairs(database: Path, options: MappingOptions, progress: Progress) -> list[float]:
    """Focal length of every photo, by its row, from its pairs; each has a camera of its own."""
    pycolmap = colmap()
    settings = pycolmap.ViewGraphCalibrationOptions()
    settings.random_seed = options.seed
    settings.reestimate_relative_pose = False
    trial = database.with_name("pairs.db")
    require_regular(database)
    shutil.copy(database, trial)
    cancellable(lambda _token: pycolmap.calibrate_view_graph(trial, settings), progress)
    opened = pycolmap.Database.open(trial)
    try:
        focal = {c.camera_id: float(c.params[0]) for c in opened.read_all_cameras()}
        images = sorted(opened.read_all_images(), key=lambda image: image.image_id)
        return [focal[image.camera_id] for image in images]
    finally:
        opened.close()


def _alike(
    reconstruction: Any, groups: Sequence[Sequence[int]], count: int
) -> tuple[list[int], list[tuple[float, int]]]:
    """Number of the lens of every photo within its group, 0 for the most common one; and
    (focal length, photos) of all lenses of the groups. Photos that were not placed are taken for
    the most common one."""
    lenses, sizes = [0] * count, []
    for group in groups:
        placed = [r for r in group if reconstruction.exists_image(r + 1)]
        placed = [r for r in placed if reconstruction.image(r + 1).has_pose]
        if not placed:
            continue
        focal = {
            r: float(reconstruction.camera(reconstruction.image(r + 1).camera_id).params[0])
            for r in placed
        }
        order = sorted(placed, key=lambda r: focal[r])
        clusters = [[order[0]]]
        for before, row in itertools.pairwise(order):
            if np.log(focal[row] / focal[before]) > _ALIKE:
                clusters.append([])
            clusters[-1].append(row)
        clusters.sort(key=len, reverse=True)
        for number, cluster in enumerate(clusters):
            sizes.append((float(np.median([focal[r] for r in cluster])), len(cluster)))
            for row in cluster:
                lenses[row] = number
    return lenses, sizes


def _better(one: Any, other: Any) -> bool:
    return one.num_reg_images() >= other.num_reg_images() and _error(
        one
    ) < _CLEARLY_BETTER * _error(other)


def _error(reconstruction: Any) -> float:
    reconstruction.update_point_3d_errors()
    return float(reconstruction.compute_mean_reprojection_error())
