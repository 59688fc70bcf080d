import numpy as np

from tests.messages import refused
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.photogrammetry.base.scene import SparseScene


def scene():
    lens = Intrinsics("SIMPLE_RADIAL", 1600, 1200, (1000.0, 800.0, 600.0, -0.02))
    views = tuple(
        View(name, lens, np.eye(3), np.array([x, 0.0, 0.0]))
        for name, x in (("a/1.jpg", 0.0), ("b ü.jpg", 1 / 3))
    )
    return SparseScene(
        views,
        np.array([[0.1, 0.2, 5.0], [1, 2, 6]]),
        np.array([[1, 2, 3], [4, 5, 6]], np.uint8),
        np.array([0.3, 0.4], np.float32),
        np.array([0, 2, 3]),
        np.array([0, 1, 1], np.int32),
        np.array([[1, 2], [3, 4], [5, 6]], np.float32),
        origin=(400000, 5000000, 0),
        crs="EPSG:32615",
        scaled=True,
        notes=("the focal length was held",),
    )


def test_scene_is_unchanged_after_saving_and_loading(tmp_path):
    before = scene()
    before.save(tmp_path)
    after = SparseScene.load(tmp_path)
    assert [v.name for v in after.views] == ["a/1.jpg", "b ü.jpg"]
    assert after.views[1].intrinsics == before.views[1].intrinsics
    np.testing.assert_array_equal(after.centres, before.centres)
    np.testing.assert_array_equal(after.points, before.points)
    np.testing.assert_array_equal(after.track_pixels, before.track_pixels)
    assert (after.origin, after.crs, after.scaled) == (before.origin, before.crs, before.scaled)
    assert after.notes == before.notes


def test_tracks_are_indexed_by_point_and_by_view():
    one = scene()
    np.testing.assert_array_equal(one.track_lengths, [2, 1])
    np.testing.assert_array_equal(one.observed_points(1), [0, 1])
    np.testing.assert_array_equal(one.observed_points(0), [0])


def test_damaged_scene_is_rejected(tmp_path):
    with refused("alignment.damaged"):
        SparseScene.load(tmp_path)
    scene().save(tmp_path)
    (tmp_path / "scene.npz").write_bytes(b"PK")
    with refused("alignment.damaged"):
        SparseScene.load(tmp_path)
