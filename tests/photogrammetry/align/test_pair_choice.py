"""Which photos are compared with which before anything is matched."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from vomstudio.core.errors import Cancelled
from vomstudio.core.findings import Finding
from vomstudio.core.progress import SilentProgress
from vomstudio.photogrammetry.align.features import Features
from vomstudio.photogrammetry.align.matching import choose_pairs


def photo(number, longitude=None, latitude=None):
    return SimpleNamespace(
        path=Path(f"{number:03d}.jpg"),
        name=f"{number:03d}.jpg",
        longitude_deg=longitude,
        latitude_deg=latitude,
        altitude_m=None if longitude is None else 100.0,
        gps_accuracy_m=None,
    )


def features(descriptors, size):
    count = len(descriptors)
    keypoints = np.zeros((count, 6), np.float32)
    keypoints[:, 2] = keypoints[:, 5] = size
    return Features(
        keypoints, descriptors.astype(np.uint8), np.zeros((count, 3), np.uint8), 640, 480
    )


def sights(count, rng):
    """Descriptors of things in the rock: far apart from each other, as SIFT's are."""
    return np.clip(rng.gamma(0.35, 40.0, (count, 128)), 0, 255)


@pytest.fixture(scope="module")
def walls():
    """70 photos in turn of 35 walls, two of each, 400 large things on each wall, and noise; and 400
    small things of its own in each photo, which come first."""
    rng = np.random.default_rng(3)
    on = [sights(400, rng) for _ in range(35)]
    photos = []
    for k in range(70):
        large = on[k % 35][rng.permutation(400)] + rng.normal(0, 4, (400, 128))
        both = np.clip(np.concatenate([sights(400, rng), large]), 0, 255)
        photos.append(features(both, np.repeat([2.0, 9.0], 400)))
    return photos


class Told(SilentProgress):
    def __init__(self, stop_at=None):
        super().__init__()
        self.stages, self.steps, self.stop_at = [], [], stop_at

    def stage(self, name, total=None):
        self.stages.append((name, total))

    def step(self, done):
        self.steps.append(done)
        if self.stop_at is not None and done >= self.stop_at:
            raise Cancelled()


def test_small_set_is_matched_exhaustively():
    chosen = choose_pairs([photo(k) for k in range(60)], [None] * 60)
    assert len(chosen.pairs) == 60 * 59 // 2
    assert chosen.rule == Finding("alignment.matched-all", count=1770)


@pytest.mark.full
def test_photos_of_the_same_scene_are_paired_by_their_features(walls):
    chosen = choose_pairs([photo(k) for k in range(70)], walls)
    assert {(k, k + 35) for k in range(35)} <= set(chosen.pairs)
    # Besides them the next three by name, and a few by chance: no wall resembles another.
    rest = {(i, j) for i, j in chosen.pairs if j - i > 3}
    assert len(rest) < 2 * 35
    assert chosen.rule.code == "alignment.matched-by-likeness"


@pytest.mark.full
def test_comparison_reports_progress_and_can_be_stopped(walls):
    told = Told()
    choose_pairs([photo(k) for k in range(70)], walls, "auto", told)
    ((_, total),) = told.stages
    assert total == 70 * 69 // 2
    assert told.steps == sorted(told.steps)
    assert len(told.steps) == 70
    assert told.steps[-1] == 70 * 69 // 2
    stopped = Told(stop_at=500)
    with pytest.raises(Cancelled):
        choose_pairs([photo(k) for k in range(70)], walls, "auto", stopped)
    assert stopped.steps[-1] < 600


def test_each_of_many_similar_photos_gets_thirty_pairs():
    rng = np.random.default_rng(5)
    wall = sights(100, rng)
    same = [features(np.clip(wall + rng.normal(0, 4, wall.shape), 0, 255), 9.0) for _ in range(70)]
    pairs = choose_pairs([photo(k) for k in range(70)], same).pairs
    each = np.bincount(np.ravel(pairs), minlength=70)
    assert each.min() >= 30
    assert len(pairs) < 70 * 69 // 2


def test_photos_with_gps_are_compared_with_the_nearest():
    degree = 111_320.0
    photos = [photo(k, 7.0, 46.0 + 10.0 * k / degree) for k in range(100)]
    chosen = choose_pairs(photos, [None] * 100)
    assert chosen.rule.code == "alignment.matched-by-gps"
    pairs = set(chosen.pairs)
    # In a line each photo has its fifteen on either side; at the ends all thirty on one.
    assert all((k, k + d) in pairs for d in range(1, 16) for k in range(100 - d))
    assert max(j - i for i, j in pairs) == 30


def test_photo_without_gps_is_compared_with_all_others():
    degree = 111_320.0
    photos = [photo(k, 7.0, 46.0 + 10.0 * k / degree) for k in range(100)]
    photos[50] = photo(50)
    pairs = set(choose_pairs(photos, [None] * 100).pairs)
    assert all((min(k, 50), max(k, 50)) in pairs for k in range(100) if k != 50)


def test_video_frames_are_compared_with_neighbours_and_with_later_frames():
    pairs = set(choose_pairs([photo(k) for k in range(200)], [None] * 200, "sequential").pairs)
    assert {j - i for i, j in pairs} == {*range(1, 11), 20, 40, 80, 160}
