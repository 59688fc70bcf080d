"""The fusion of maps that are known exactly."""

import numpy as np
import pytest

from tests.messages import refused
from tests.photogrammetry.dense.dense_truth import look
from vomstudio.core.errors import GeometryError
from vomstudio.geometry.cameras import Intrinsics
from vomstudio.photogrammetry.dense.depthmaps import DepthMap
from vomstudio.photogrammetry.dense.fusion import FusionOptions, fuse_depth_maps
from vomstudio.photogrammetry.pipeline.photo_results import PhotoResults

NORMAL = np.array([-0.3, 0.2, 1.0]) / np.linalg.norm([-0.3, 0.2, 1.0])


def exact(view, confidence=191):
    """The map of the plane NORMAL . x = 0."""
    lens = view.intrinsics
    x, y = np.meshgrid(np.arange(lens.width) + 0.5, np.arange(lens.height) + 0.5)
    rays = lens.rays(np.stack([x, y], axis=-1).reshape(-1, 2))
    depth = -(view.centre @ NORMAL) / (rays @ view.rotation @ NORMAL)
    normals = np.broadcast_to((view.rotation @ NORMAL).astype(np.float32), (*x.shape, 3))
    return DepthMap(
        view.name,
        view,
        depth.reshape(x.shape).astype(np.float32),
        normals.copy(),
        np.full(x.shape, confidence, np.uint8),
    )


def some_views(count=3, focal=200.0, distance=4.0):
    lens = Intrinsics.pinhole(160, 120, focal, 81.3, 58.8)
    centres = [np.array([0.5 * i, 0.1 * i, distance]) for i in range(count)]
    return [look(f"{i}", lens, c, c * [0.8, 0.8, 0.0]) for i, c in enumerate(centres)]


def names(maps):
    return [one.name for one in maps]


def test_each_point_is_fused_once_on_the_plane_with_its_normal():
    maps = [exact(view) for view in some_views()]
    cloud = fuse_depth_maps(names(maps), maps, None)
    # Half a pixel wrong in one of the maps would be 3 mm off along this slope.
    np.testing.assert_allclose(cloud.points @ NORMAL, 0.0, atol=2e-5)
    np.testing.assert_allclose(cloud.normals @ NORMAL, 1.0, atol=1e-5)
    from scipy.spatial import cKDTree

    near = cKDTree(cloud.points).query(cloud.points, k=2)[0][:, 1]
    # Two layers of the same pixels would halve the spacing of 4 / 200 m nearly everywhere.
    assert np.mean(near < 0.6 * 4 / 200) < 0.02
    assert cloud.fields["views"].min() >= 2
    assert cloud.fields["views"].max() == 3
    assert cloud.fields["confidence"].dtype == np.float32
    assert (cloud.fields["confidence"] > 0.9).all()
    assert (cloud.fields["confidence"] <= 1.0).all()


def test_fused_position_is_the_mean_weighted_by_confidence():
    maps = [exact(view) for view in some_views(2)]
    moved = maps[1].depth - np.float32(0.01)
    maps[1] = DepthMap(maps[1].name, maps[1].view, moved, maps[1].normals, maps[1].confidence)
    cloud = fuse_depth_maps(names(maps), maps, None, options=FusionOptions(max_reprojection_px=3.0))
    off = cloud.points @ NORMAL
    assert 0.3 * 0.01 < np.median(off) < 0.7 * 0.01


def test_depths_of_one_map_are_dropped_if_the_others_see_through_them():
    maps = [exact(view) for view in some_views()]
    depth = maps[0].depth.copy()
    depth[40:80, 60:100] *= np.float32(0.7)
    maps[0] = DepthMap(maps[0].name, maps[0].view, depth, maps[0].normals, maps[0].confidence)
    cloud = fuse_depth_maps(names(maps), maps, None)
    np.testing.assert_allclose(cloud.points @ NORMAL, 0.0, atol=2e-5)


def test_finest_photo_of_an_area_determines_its_points():
    coarse = [exact(view) for view in some_views(2)]
    fine = exact(some_views(1, focal=600.0)[0])
    fine = DepthMap("fine", fine.view, fine.depth, fine.normals, fine.confidence)
    cloud = fuse_depth_maps(["0", "1", "fine"], [*coarse, fine], None)
    pixels = fine.view.project(cloud.points)
    inside = ((pixels > 4) & (pixels < [156, 116])).all(axis=1)
    # One point for each pixel of the fine photo, and no more.
    assert inside.sum() == pytest.approx(152 * 112, rel=0.03)


def test_the_order_of_the_photos_does_not_move_the_surface():
    maps = [exact(view) for view in some_views()]
    one = fuse_depth_maps(names(maps), maps, None)
    other = fuse_depth_maps(names(maps)[::-1], maps[::-1], None)
    from scipy.spatial import cKDTree

    for a, b in ((one, other), (other, one)):
        away = cKDTree(a.points).query(b.points)[0]
        assert np.mean(away < 1.5 * 4 / 200) > 0.99


def test_stored_maps_and_a_small_cache_give_the_same_cloud(tmp_path):
    maps = [exact(view) for view in some_views()]
    stored = PhotoResults(tmp_path, names(maps), lambda path, one: one.save(path), DepthMap.load)
    for row, one in enumerate(maps):
        stored.put(row, one)
    around = {name: tuple(n for n in names(maps) if n != name) for name in names(maps)}
    a = fuse_depth_maps(names(maps), maps, None, around)
    b = fuse_depth_maps(names(maps), stored, None, around, FusionOptions(cache_bytes=1))
    assert len(a.points) == pytest.approx(len(b.points), rel=0.01)
    np.testing.assert_allclose(b.points @ NORMAL, 0.0, atol=1e-4)


def test_single_or_contradicting_maps_give_no_cloud():
    views = some_views(2)
    with refused("dense.no-agreement", GeometryError):
        fuse_depth_maps(["0"], [exact(views[0])], None)
    wrong = exact(views[1])
    wrong = DepthMap("1", wrong.view, 2 * wrong.depth, wrong.normals, wrong.confidence)
    with refused("dense.no-agreement", GeometryError):
        fuse_depth_maps(["0", "1"], [exact(views[0]), wrong], None)
