"""COLMAP's database: the photos, their features, and every pair that has been compared.

Only COLMAP's own SQLite opens it in this process, never Python's `sqlite3`: of two SQLite libraries
in one process, neither sees the locks of the other (they belong to the process), so one shortens
the shared index of the write-ahead log under the other, which then dies of a bus error, or loses
rows (sqlite.org, "How to corrupt an SQLite database file", 2.2.1). Several processes, or several
connections of one library, may have it open.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import Float32Array, IntArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import JSON_BYTES, read_small
from vomstudio.core.findings import Finding
from vomstudio.photogrammetry.align.features import Features
from vomstudio.photogrammetry.align.photo_protocol import PhotoLike
from vomstudio.photogrammetry.base.colmap import colmap

Pair = tuple[int, int]

_DEFAULT_FOCAL = 1.2
_QUICK_CHECK = """
import sqlite3, sys
checked = sqlite3.connect(sys.argv[1]).execute("PRAGMA quick_check").fetchone()
sys.exit(checked != ("ok",))
"""


def open_database(
    path: Path,
    photos: Sequence[PhotoLike],
    features: Sequence[Features],
    keys: Sequence[str],
    lenses: Sequence[int] | None = None,
) -> None:
    """Make the database of these photos, or keep one that is of exactly these and sound.

    Photo number i becomes image i + 1; photos with the same `camera_key`, size and number of the
    lens share a camera.
    """
    lenses = lenses or [0] * len(photos)
    stated = json.dumps(
        [
            [p.name, p.width, p.height, repr(p.camera_key), p.focal_px, k, lens]
            for p, k, lens in zip(photos, keys, lenses, strict=True)
        ]
    )
    note = path.with_suffix(".json")
    try:
        if read_small(note, JSON_BYTES) == stated.encode() and _is_sound(path):
            return
    except (InputError, OSError):
        pass
    note.unlink(missing_ok=True)
    for tail in ("", "-wal", "-shm", "-journal"):
        path.with_name(path.name + tail).unlink(missing_ok=True)
    pycolmap = colmap()
    cameras: dict[tuple[object, ...], int] = {}
    database = pycolmap.Database.open(path)
    try:
        of_photo = [
            (p.camera_key, p.width, p.height, lens) for p, lens in zip(photos, lenses, strict=True)
        ]
        for photo, key in zip(photos, of_photo, strict=True):
            if key not in cameras:
                cameras[key] = len(cameras) + 1
                camera = _camera(photo, cameras[key])
                database.write_camera(camera, use_camera_id=True)
                rig = pycolmap.Rig(rig_id=cameras[key])
                rig.add_ref_sensor(camera.sensor_id)
                database.write_rig(rig, use_rig_id=True)
        for row, found in enumerate(features):
            camera_id = cameras[of_photo[row]]
            image = pycolmap.Image(name=image_name(row), camera_id=camera_id, image_id=row + 1)
            database.write_image(image, use_image_id=True)
            frame = pycolmap.Frame(frame_id=row + 1, rig_id=camera_id)
            frame.add_data_id(image.data_id)
            database.write_frame(frame, use_frame_id=True)
            database.write_keypoints(row + 1, found.keypoints)
            descriptors = pycolmap.FeatureDescriptors(
                pycolmap.FeatureExtractorType.SIFT, found.descriptors
            )
            database.write_descriptors(row + 1, descriptors)
    finally:
        database.close()
    note.write_text(stated, encoding="utf-8")


def image_name(row: int) -> str:
    """In the database: COLMAP's lists of pairs take no name with a space."""
    return f"{row + 1:06d}"


def starting_focal(photo: PhotoLike) -> float:
    """Pixels; of a lens of ordinary width where the photo does not say."""
    return photo.focal_px or _DEFAULT_FOCAL * max(photo.width, photo.height)


def _camera(photo: PhotoLike, number: int) -> Any:
    camera = colmap().Camera(
        model="SIMPLE_RADIAL",
        width=photo.width,
        height=photo.height,
        params=[starting_focal(photo), photo.width / 2, photo.height / 2, 0.0],
    )
    camera.camera_id = number
    camera.has_prior_focal_length = photo.focal_px is not None
    return camera


def _is_sound(path: Path) -> bool:
    """COLMAP has no such check, so that it runs in a process of its own."""
    if not path.exists():
        return False
    command = [sys.executable, "-I", "-c", _QUICK_CHECK, str(path)]
    return subprocess.run(command, capture_output=True, check=False).returncode == 0


@contextmanager
def opened(path: Path) -> Iterator[Any]:
    """The database. It may be read while COLMAP writes (write-ahead log). Raises InputError without
    a database; what happens while it is open is not its own."""
    if not path.exists():
        raise InputError(Finding("alignment.no-matches"), file=path)
    try:
        database = colmap().Database.open(path)
    except RuntimeError as error:
        raise _unreadable(path, error) from error
    try:
        yield database
    finally:
        database.close()


@contextmanager
def reading(path: Path) -> Iterator[Any]:
    """The database, for questions to it alone. Raises InputError without a sound database."""
    with opened(path) as database:
        try:
            yield database
        except RuntimeError as error:
            raise _unreadable(path, error) from error


def _unreadable(path: Path, error: RuntimeError) -> InputError:
    return InputError(Finding("alignment.matches-unreadable", reason=error), file=path)


def compared(database: Any) -> int:
    """Number of the pairs that have been compared, with whatever result."""
    return int(database.num_verified_image_pairs())


def is_compared(database: Any, pair: Pair) -> bool:
    """Whether two photos (rows) have been compared, with whatever result."""
    return bool(database.exists_two_view_geometry(pair[0] + 1, pair[1] + 1))


def pair_counts(path: Path) -> dict[Pair, int]:
    """Verified matches of every pair of photos (rows) that has any. Raises InputError without a
    sound database."""
    with reading(path) as database:
        return _by_pair(*database.read_two_view_geometry_num_inliers())


def match_counts(path: Path) -> dict[Pair, tuple[int, int]]:
    """(matches, verified matches) of every pair of photos (rows) that was compared. Raises
    InputError without a sound database."""
    with reading(path) as database:
        tried = _by_pair(*database.read_num_matches())
        kept = _by_pair(*database.read_two_view_geometry_num_inliers())
        pairs = {pair for pair in {*tried, *kept} if is_compared(database, pair)}
        # COLMAP lists no pair without a match.
        total = compared(database)
        for pair in combinations(range(database.num_images()), 2):
            if len(pairs) == total:
                break
            if pair not in pairs and is_compared(database, pair):
                pairs.add(pair)
    return {pair: (max(tried.get(pair, 0), kept.get(pair, 0)), kept.get(pair, 0)) for pair in pairs}


def _by_pair(numbers: Sequence[int], counts: Sequence[int]) -> dict[Pair, int]:
    pycolmap = colmap()
    images = (pycolmap.pair_id_to_image_pair(number) for number in numbers)
    return {
        (min(a, b) - 1, max(a, b) - 1): int(count)
        for (a, b), count in zip(images, counts, strict=True)
        if count > 0
    }


def feature_counts(path: Path) -> dict[int, int]:
    """Features of every photo (row). Raises InputError without a sound database."""
    with reading(path) as database:
        return {
            row: int(database.num_keypoints_for_image(row + 1))
            for row in range(database.num_images())
        }


def copy_pairs(source: Path, target: Path) -> None:
    """Take over all pairs with verified matches from a database of the same features. Raises
    InputError without a sound database."""
    pycolmap = colmap()
    with reading(source) as database, reading(target) as other:
        numbers, geometries = database.read_two_view_geometries()
        for number, geometry in zip(numbers, geometries, strict=True):
            other.write_two_view_geometry(*pycolmap.pair_id_to_image_pair(number), geometry)


def matches_of_pair(
    path: Path, a: int, b: int
) -> tuple[Float32Array, Float32Array, IntArray, IntArray]:
    """Features (n, 2) and (n, 2) in pixels of two photos (rows), and rows of both (m, 2): of all
    matches, and of the verified ones. Raises InputError without a database."""
    with reading(path) as database:
        tried = database.read_matches(a + 1, b + 1)
        kept = database.read_two_view_geometry(a + 1, b + 1).inlier_matches
        left, right = (database.read_keypoints(i + 1)[:, :2] for i in (a, b))
    # Cut loose from COLMAP's memory.
    first, second = (np.array(points, np.float32).reshape(-1, 2) for points in (left, right))
    every, agreeing = (np.array(rows, np.int64).reshape(-1, 2) for rows in (tried, kept))
    return first, second, every, agreeing
