"""COLMAP's database is opened by one SQLite library only, whoever else has it open."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pycolmap
import pytest

from tests.messages import refused
from vomstudio.io.photos.reading import read_photos
from vomstudio.photogrammetry.align import match_database
from vomstudio.photogrammetry.align.features import Features


def _features(seed: int) -> Features:
    rng = np.random.default_rng(seed)
    keypoints = np.zeros((40, 6), np.float32)
    keypoints[:, :2] = rng.uniform(0, [60, 40], (40, 2))
    keypoints[:, [2, 5]] = 3.0
    descriptors = rng.integers(0, 255, (40, 128), np.uint8)
    return Features(keypoints, descriptors, np.zeros((40, 3), np.uint8), 60, 40)


@pytest.fixture
def made(tmp_path: Path) -> tuple[Path, tuple[object, ...]]:
    """Three photos: of the first two, 12 of 13 matches are verified; the second and the third were
    compared and have nothing in common."""
    from PIL import Image

    (tmp_path / "photos").mkdir()
    for k, name in enumerate("abc"):
        Image.new("RGB", (60, 40), (80 * k, 90, 90)).save(tmp_path / "photos" / f"{name}.jpg")
    photos = read_photos(tmp_path / "photos").photos
    path = tmp_path / "database.db"
    asked = (photos, [_features(k) for k in range(3)], ["k"] * 3)
    match_database.open_database(path, *asked)
    rows = np.column_stack([np.arange(13), np.arange(13)]).astype(np.uint32)
    database = pycolmap.Database.open(path)
    for pair, tried, kept in (((1, 2), rows, rows[:12]), ((2, 3), rows[:0], rows[:0])):
        database.write_matches(*pair, tried)
        geometry = pycolmap.TwoViewGeometry()
        geometry.inlier_matches = kept
        geometry.config = 3 if len(kept) else 0
        database.write_two_view_geometry(*pair, geometry)
    database.close()
    return path, asked


def test_a_pair_without_a_match_counts_as_compared(made) -> None:
    path, _ = made
    assert match_database.match_counts(path) == {(0, 1): (13, 12), (1, 2): (0, 0)}
    assert match_database.pair_counts(path) == {(0, 1): 12}
    assert match_database.feature_counts(path) == {0: 40, 1: 40, 2: 40}
    with match_database.open_for_reading(path) as database:
        assert match_database.count_compared(database) == 2
        asked = [(0, 1), (1, 2), (0, 2)]
        assert [match_database.is_compared(database, pair) for pair in asked] == [True, True, False]


def test_pairs_with_matches_are_copied_completely(made, tmp_path: Path) -> None:
    path, asked = made
    other = tmp_path / "other.db"
    match_database.open_database(other, *asked, [0, 1, 0])
    match_database.copy_pairs(path, other)
    one, two = pycolmap.Database.open(path), pycolmap.Database.open(other)
    try:
        mine, copied = (d.read_two_view_geometry(1, 2) for d in (one, two))
        assert copied.config == mine.config
        assert np.array_equal(copied.inlier_matches, mine.inlier_matches)
        assert two.num_cameras() == 2
    finally:
        one.close()
        two.close()


def _database(
    path: Path, photos: Sequence[object], rows: Sequence[int], matching_key: str = "k"
) -> Path:
    """A database of some of the photos, in this order, whose features are those of `made`."""
    features = [_features(row) for row in rows]
    keys = [f"key {row}" for row in rows]
    match_database.open_database(
        path, [photos[row] for row in rows], features, keys, matching_key=matching_key
    )
    return path


def _write_pair(path: Path, pair: tuple[int, int], matches: np.ndarray) -> None:
    database = pycolmap.Database.open(path)
    database.write_matches(*pair, matches)
    geometry = pycolmap.TwoViewGeometry()
    geometry.inlier_matches = matches[:12]
    geometry.config = 3 if len(matches) else 0
    database.write_two_view_geometry(*pair, geometry)
    database.close()


def test_known_pairs_are_copied_in_another_order_of_photos(made, tmp_path: Path) -> None:
    photos = made[1][0]
    earlier = _database(tmp_path / "earlier.db", photos, [0, 1])
    matches = np.column_stack([np.arange(13), np.arange(13)[::-1]]).astype(np.uint32)
    _write_pair(earlier, (1, 2), matches)
    now = _database(tmp_path / "now.db", photos, [2, 1, 0])
    assert match_database.copy_known_pairs(now, [tmp_path / "missing.db", earlier]) == 1
    assert match_database.match_counts(now) == {(1, 2): (13, 12)}
    _, _, copied, verified = match_database.read_pair_matches(now, 1, 2)
    assert np.array_equal(copied, matches[:, ::-1])
    assert np.array_equal(verified, matches[:12, ::-1])
    assert match_database.copy_known_pairs(now, [earlier]) == 0


def test_pairs_without_matches_are_not_compared_again(made, tmp_path: Path) -> None:
    photos = made[1][0]
    earlier = _database(tmp_path / "earlier.db", photos, [0, 1, 2])
    _write_pair(earlier, (2, 3), np.zeros((0, 2), np.uint32))
    now = _database(tmp_path / "now.db", photos, [1, 2])
    assert match_database.copy_known_pairs(now, [earlier]) == 1
    assert match_database.match_counts(now) == {(0, 1): (0, 0)}


def test_pairs_compared_by_other_rules_or_in_damaged_databases_are_ignored(
    made, tmp_path: Path
) -> None:
    photos = made[1][0]
    matches = np.column_stack([np.arange(13), np.arange(13)]).astype(np.uint32)
    other = _database(tmp_path / "other.db", photos, [0, 1], matching_key="seed 1")
    damaged = _database(tmp_path / "damaged.db", photos, [0, 1])
    for path in (other, damaged):
        _write_pair(path, (1, 2), matches)
    damaged.write_bytes(b"damaged" * 1000)
    now = _database(tmp_path / "now.db", photos, [0, 1])
    assert match_database.copy_known_pairs(now, [other, damaged]) == 0
    for content in ("[]", '{"matching": "k", "photos": 3}'):
        damaged.with_suffix(".json").write_text(content)
        assert match_database.copy_known_pairs(now, [damaged]) == 0


def test_queries_keep_the_locks_of_an_open_database(made, tmp_path: Path) -> None:
    """Python's sqlite3 in the same process does not see that COLMAP has the database open: at its
    end it deletes the shared index, at its start it shortens it under COLMAP (a bus error)."""
    path, asked = made
    index = path.with_name(path.name + "-shm")
    with match_database.open_for_reading(path) as database:
        before = index.stat()
        match_database.match_counts(path)
        match_database.pair_counts(path)
        match_database.feature_counts(path)
        match_database.read_pair_matches(path, 0, 1)
        match_database.open_database(path, *asked)
        match_database.open_database(tmp_path / "other.db", *asked)
        match_database.copy_pairs(path, tmp_path / "other.db")
        assert index.stat().st_ino == before.st_ino
        assert match_database.count_compared(database) == 2


def test_errors_while_the_database_is_open_are_not_blamed_on_it(made) -> None:
    path, _ = made
    failure = RuntimeError("no graphics")
    with pytest.raises(RuntimeError) as error, match_database.open_existing_database(path):
        raise failure
    assert error.value is failure
    with refused("alignment.matches-unreadable"), match_database.open_for_reading(path):
        raise RuntimeError("no graphics")


def test_invalid_database_is_reported_with_its_path(tmp_path: Path) -> None:
    path = tmp_path / "database.db"
    with refused("alignment.no-matches") as raised:
        match_database.pair_counts(path)
    assert raised.value.file == str(path)
    path.write_bytes(b"nothing of the kind" * 400)
    with refused("alignment.matches-unreadable"):
        match_database.match_counts(path)
