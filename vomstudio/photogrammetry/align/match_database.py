"""Access to COLMAP's database of photos, their features, and all compared pairs.

In this process, only COLMAP's SQLite library may open the database, never Python's `sqlite3`. Two
SQLite libraries in one process do not see each other's locks, because locks belong to the process.
One may then truncate the shared index of the write-ahead log while the other uses it, which crashes
or loses rows (sqlite.org, "How to corrupt an SQLite database file", 2.2.1). Several processes, or
several connections of the same library, may open the database.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.core.arrays import Float32Array, IntArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import MAX_JSON_BYTES, read_small_file
from vomstudio.core.findings import Finding
from vomstudio.photogrammetry.align.features import Features
from vomstudio.photogrammetry.align.photo_protocol import PhotoLike
from vomstudio.photogrammetry.base.colmap import colmap

Pair = tuple[int, int]

_DEFAULT_FOCAL_RATIO = 1.2
_QUICK_CHECK_SCRIPT = """
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
    matching_key: str = "",
) -> None:
    """Create the database of the given photos, or reuse an existing one.

    A database is reused if it is valid and belongs to exactly these photos, features and lenses.
    `matching_key` identifies the version and options of the comparison of photos.

    Photo number i becomes image i + 1. Photos with the same `camera_key`, size and lens number
    share a camera.
    """
    lenses = lenses or [0] * len(photos)
    rows = [
        [p.name, p.width, p.height, repr(p.camera_key), p.focal_px, k, lens]
        for p, k, lens in zip(photos, keys, lenses, strict=True)
    ]
    description = {"matching": matching_key, "photos": rows}
    description_path = path.with_suffix(".json")
    if _read_description(path) == (matching_key, rows) and _is_valid(path):
        return
    description_path.unlink(missing_ok=True)
    for suffix in ("", "-wal", "-shm", "-journal"):
        path.with_name(path.name + suffix).unlink(missing_ok=True)
    pycolmap = colmap()
    cameras: dict[tuple[object, ...], int] = {}
    database = pycolmap.Database.open(path)
    try:
        camera_keys = [
            (p.camera_key, p.width, p.height, lens) for p, lens in zip(photos, lenses, strict=True)
        ]
        for photo, key in zip(photos, camera_keys, strict=True):
            if key not in cameras:
                cameras[key] = len(cameras) + 1
                camera = _make_camera(photo, cameras[key])
                database.write_camera(camera, use_camera_id=True)
                rig = pycolmap.Rig(rig_id=cameras[key])
                rig.add_ref_sensor(camera.sensor_id)
                database.write_rig(rig, use_rig_id=True)
        for row, photo_features in enumerate(features):
            camera_id = cameras[camera_keys[row]]
            image = pycolmap.Image(name=image_name(row), camera_id=camera_id, image_id=row + 1)
            database.write_image(image, use_image_id=True)
            frame = pycolmap.Frame(frame_id=row + 1, rig_id=camera_id)
            frame.add_data_id(image.data_id)
            database.write_frame(frame, use_frame_id=True)
            database.write_keypoints(row + 1, photo_features.keypoints)
            descriptors = pycolmap.FeatureDescriptors(
                pycolmap.FeatureExtractorType.SIFT, photo_features.descriptors
            )
            database.write_descriptors(row + 1, descriptors)
    finally:
        database.close()
    description_path.write_text(json.dumps(description), encoding="utf-8")


def _read_description(path: Path) -> tuple[str, list[list[Any]]]:
    """Return the matching key and the photos of a database; empty if they cannot be read."""
    try:
        description = json.loads(read_small_file(path.with_suffix(".json"), MAX_JSON_BYTES))
        return str(description["matching"]), [list(row) for row in description["photos"]]
    except (InputError, OSError, ValueError, KeyError, TypeError):
        return "", []


def copy_known_pairs(target: Path, sources: Iterable[Path]) -> int:
    """Copy the pairs of photos that earlier databases have already compared.

    Photos are recognised by their features, size, camera and lens, regardless of their names and
    order. Databases that are missing or damaged are ignored.

    Parameters
    ----------
    target : Path
        Database created by `open_database`.
    sources : iterable of Path
        Databases of other alignments. Those with another matching key are ignored.

    Returns
    -------
    int
        Number of copied pairs, with or without matches.
    """
    matching_key, photos = _read_description(target)
    row_by_photo = {json.dumps(photo[1:]): row for row, photo in enumerate(photos)}
    count = 0
    for source in sources:
        rows: dict[int, int] = {}
        source_key, source_photos = _read_description(source)
        for old_row, photo in enumerate(source_photos if source_key == matching_key else ()):
            new_row = row_by_photo.get(json.dumps(photo[1:]))
            if new_row is not None:
                rows.setdefault(new_row, old_row)
        if len(rows) > 1 and _is_valid(source):
            count += _copy_compared_pairs(source, target, rows)
    return count


def _copy_compared_pairs(source: Path, target: Path, rows: dict[int, int]) -> int:
    """Copy the compared pairs that `target` does not have; `rows` maps new to old rows."""
    count = 0
    with (
        open_for_reading(source) as database,
        open_for_reading(target) as target_database,
        colmap().DatabaseTransaction(target_database),
    ):
        for new, old in zip(combinations(rows, 2), combinations(rows.values(), 2), strict=True):
            if is_compared(target_database, new) or not is_compared(database, old):
                continue
            (a, b), (old_a, old_b) = ((i + 1, j + 1) for i, j in (new, old))
            target_database.write_matches(a, b, database.read_matches(old_a, old_b))
            target_database.write_two_view_geometry(
                a, b, database.read_two_view_geometry(old_a, old_b)
            )
            count += 1
    return count


def image_name(row: int) -> str:
    """Return the image name of a row; COLMAP's lists of pairs do not support spaces."""
    return f"{row + 1:06d}"


def initial_focal_px(photo: PhotoLike) -> float:
    """Return the focal length from EXIF, or a typical one if it is unknown, in pixels."""
    return photo.focal_px or _DEFAULT_FOCAL_RATIO * max(photo.width, photo.height)


def _make_camera(photo: PhotoLike, number: int) -> Any:
    camera = colmap().Camera(
        model="SIMPLE_RADIAL",
        width=photo.width,
        height=photo.height,
        params=[initial_focal_px(photo), photo.width / 2, photo.height / 2, 0.0],
    )
    camera.camera_id = number
    camera.has_prior_focal_length = photo.focal_px is not None
    return camera


def _is_valid(path: Path) -> bool:
    """Return whether the database exists and passes SQLite's quick check.

    The check runs in a separate process, because COLMAP does not offer it.
    """
    if not path.exists():
        return False
    command = [sys.executable, "-I", "-c", _QUICK_CHECK_SCRIPT, str(path)]
    return subprocess.run(command, capture_output=True, check=False).returncode == 0


@contextmanager
def open_existing_database(path: Path) -> Iterator[Any]:
    """Open an existing database while COLMAP may be writing it (write-ahead log).

    Raises InputError if the database cannot be opened.
    """
    if not path.exists():
        raise InputError(Finding("alignment.no-matches"), file=path)
    try:
        database = colmap().Database.open(path)
    except RuntimeError as error:
        raise _unreadable_error(path, error) from error
    try:
        yield database
    finally:
        database.close()


@contextmanager
def open_for_reading(path: Path) -> Iterator[Any]:
    """Open a database for queries. Raises InputError if the database is invalid."""
    with open_existing_database(path) as database:
        try:
            yield database
        except RuntimeError as error:
            raise _unreadable_error(path, error) from error


def _unreadable_error(path: Path, error: RuntimeError) -> InputError:
    return InputError(Finding("alignment.matches-unreadable", reason=error), file=path)


def count_compared(database: Any) -> int:
    """Return the number of compared pairs, with or without matches."""
    return int(database.num_verified_image_pairs())


def is_compared(database: Any, pair: Pair) -> bool:
    """Return whether two photos (rows) have been compared, with or without matches."""
    return bool(database.exists_two_view_geometry(pair[0] + 1, pair[1] + 1))


def pair_counts(path: Path) -> dict[Pair, int]:
    """Return the number of verified matches of each pair of photos (rows) with at least one.

    Raises InputError if the database is invalid.
    """
    with open_for_reading(path) as database:
        return _counts_by_pair(*database.read_two_view_geometry_num_inliers())


def match_counts(path: Path) -> dict[Pair, tuple[int, int]]:
    """Return the numbers of matches and of verified matches of all compared pairs (rows).

    Raises InputError if the database is invalid.
    """
    with open_for_reading(path) as database:
        matches = _counts_by_pair(*database.read_num_matches())
        verified_counts = _counts_by_pair(*database.read_two_view_geometry_num_inliers())
        pairs = {pair for pair in {*matches, *verified_counts} if is_compared(database, pair)}
        # COLMAP does not list pairs without a match.
        total = count_compared(database)
        for pair in combinations(range(database.num_images()), 2):
            if len(pairs) == total:
                break
            if pair not in pairs and is_compared(database, pair):
                pairs.add(pair)
    return {
        pair: (
            max(matches.get(pair, 0), verified_counts.get(pair, 0)),
            verified_counts.get(pair, 0),
        )
        for pair in pairs
    }


def _counts_by_pair(numbers: Sequence[int], counts: Sequence[int]) -> dict[Pair, int]:
    pycolmap = colmap()
    images = (pycolmap.pair_id_to_image_pair(number) for number in numbers)
    return {
        (min(a, b) - 1, max(a, b) - 1): int(count)
        for (a, b), count in zip(images, counts, strict=True)
        if count > 0
    }


def feature_counts(path: Path) -> dict[int, int]:
    """Return the number of features of each photo (row).

    Raises InputError if the database is invalid.
    """
    with open_for_reading(path) as database:
        return {
            row: int(database.num_keypoints_for_image(row + 1))
            for row in range(database.num_images())
        }


def copy_pairs(source: Path, target: Path) -> None:
    """Copy all pairs with verified matches from a database of the same features.

    Raises InputError if the database is invalid.
    """
    pycolmap = colmap()
    with open_for_reading(source) as database, open_for_reading(target) as target_database:
        numbers, geometries = database.read_two_view_geometries()
        for number, geometry in zip(numbers, geometries, strict=True):
            target_database.write_two_view_geometry(
                *pycolmap.pair_id_to_image_pair(number), geometry
            )


def read_pair_matches(
    path: Path, a: int, b: int
) -> tuple[Float32Array, Float32Array, IntArray, IntArray]:
    """Return the features and matches of two photos.

    Parameters
    ----------
    path : Path
    a, b : int
        Rows of the photos.

    Returns
    -------
    first, second : (n, 2) array
        Positions of the features of each photo, in pixels.
    matches, verified_matches : (m, 2) array
        Rows of the matching features in `first` and `second`: all matches, and the verified ones.

    Raises
    ------
    InputError
        If the database does not exist or is invalid.
    """
    with open_for_reading(path) as database:
        all_rows = database.read_matches(a + 1, b + 1)
        verified_rows = database.read_two_view_geometry(a + 1, b + 1).inlier_matches
        first_keypoints, second_keypoints = (database.read_keypoints(i + 1)[:, :2] for i in (a, b))
    # Copy out of COLMAP's memory.
    first, second = (
        np.array(points, np.float32).reshape(-1, 2)
        for points in (first_keypoints, second_keypoints)
    )
    matches, verified_matches = (
        np.array(rows, np.int64).reshape(-1, 2) for rows in (all_rows, verified_rows)
    )
    return first, second, matches, verified_matches
