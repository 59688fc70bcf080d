"""The division of tie points into rock and background."""

from __future__ import annotations

import numpy as np
import pytest

from tests.photogrammetry.dense.dense_truth import tie_points
from tests.photogrammetry.rock_face import (
    Face,
    joined,
    looking,
    ring_of_views,
    rough_face,
    wall_at,
)
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.photogrammetry.base.background import find_rock, propose_region
from vomstudio.photogrammetry.base.region import Region
from vomstudio.photogrammetry.base.scene import SparseScene

LENS = Intrinsics.pinhole(1200, 864, 1100.0, 600.0, 432.0)


def rock() -> Face:
    return rough_face(10.0, 5.0, 0.05)


def behind(y: float) -> Face:
    """A building that rises above the rock and beside it, with more tie points than the rock."""
    return wall_at(0.9 * y + 12, 0.5 * y + 8, (0, y, 0.25 * y), 200)


def of_rock(scene: SparseScene, y: float = 3.0) -> np.ndarray:
    """Which tie points are nearer than y."""
    return scene.points[:, 1] < y


@pytest.mark.parametrize("times", [5, 7, 10])
def test_a_building_behind_the_rock_is_background(times: int) -> None:
    scene = tie_points(joined(rock(), behind(8.0 * (times - 1))), ring_of_views(), count=8000)
    is_rock = of_rock(scene)
    assert 0.3 < is_rock.mean() < 0.6
    extent = find_rock(scene)
    assert extent.has_background
    np.testing.assert_array_equal(extent.is_rock, is_rock)


def test_rock_without_background_is_kept_whole() -> None:
    scene = tie_points(rock(), ring_of_views())
    extent = find_rock(scene)
    assert not extent.has_background
    assert extent.contains(scene, scene.points).all()


def overview() -> list[View]:
    """Four photos from far away, and six of a part from near."""
    far = [looking(f"far{i}.jpg", LENS, (4.0 * i - 6, -40.0, 0), (0, 0, 0)) for i in range(4)]
    near = [looking(f"near{i}.jpg", LENS, (i - 2.5, -5.0, 0), (i - 2.5, 0, 0)) for i in range(6)]
    return far + near


def along() -> list[View]:
    """Photos along a wall that all look ahead, so that each shows the wall near and far."""
    return [looking(f"{i}.jpg", LENS, (2.0 * i, -4.0, 0), (2.0 * i + 8, 0, 0)) for i in range(20)]


@pytest.mark.parametrize(
    ("face", "views"),
    [
        (wall_at(40, 14, (0, 0, 0), 300), overview()),
        (wall_at(90, 5, (30, 0, 0), 300), along()),
        (joined(wall_at(60, 5, (0, 0, 0)), wall_at(60, 5, (0, 9, 5))), ring_of_views()),
    ],
    ids=["overview and close-up photos", "along a wall", "a second bench"],
)
def test_rock_at_several_distances_is_not_background(face: Face, views: list[View]) -> None:
    assert find_rock(tie_points(face, views, count=8000)).is_rock.all()


def test_photo_past_the_rock_does_not_keep_the_building() -> None:
    past = [looking(f"p{i}.jpg", LENS, (6 + i, -8, 1), (25 + i, 56, 8)) for i in range(2)]
    scene = tie_points(joined(rock(), behind(56.0)), [*ring_of_views(), *past], count=8000)
    is_rock = of_rock(scene)
    shows_rock = np.bincount(scene.track_views, is_rock[scene.track_points])
    assert shows_rock[-2:].sum() < 0.1 * len(scene.observed_points(12))
    np.testing.assert_array_equal(find_rock(scene).is_rock, is_rock)


def test_dense_points_follow_the_tie_points_and_are_never_far_from_them() -> None:
    face = joined(rock(), behind(56.0))
    scene = tie_points(face, ring_of_views(), count=8000)
    points, _ = face.scattered(10_000, np.random.default_rng(0))
    extent = find_rock(scene)
    np.testing.assert_array_equal(extent.contains(scene, points), points[:, 1] < 3)
    assert not extent.contains(scene, np.array([[0.0, 40.0, 30.0], [0.0, -200.0, 0.0]])).any()


def test_proposed_region_contains_the_rock_and_no_background() -> None:
    scene = tie_points(joined(rock(), behind(56.0)), ring_of_views(), count=8000)
    box = Region.of(propose_region(scene, find_rock(scene)))
    assert box is not None
    contains = box.contains(scene.points, scene.origin)
    assert contains[of_rock(scene)].mean() > 0.995
    assert not contains[~of_rock(scene)].any()
