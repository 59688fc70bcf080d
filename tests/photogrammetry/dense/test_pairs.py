from dataclasses import replace

import numpy as np
import pytest

from tests.messages import refused
from tests.photogrammetry.dense.dense_truth import look
from vomstudio.core.errors import GeometryError
from vomstudio.geometry.cameras import Intrinsics
from vomstudio.photogrammetry.base.scene import SparseScene
from vomstudio.photogrammetry.dense.pairs import select_pairs

LENS = Intrinsics.pinhole(600, 400, 500.0, 300.0, 200.0)


def scene_of(views, points):
    seen = np.stack([view.contains(view.project(points)) for view in views], axis=1)
    rows, columns = np.nonzero(seen)
    pixels = np.array([views[c].project(points[r])[0] for r, c in zip(rows, columns, strict=True)])
    return SparseScene(
        tuple(views),
        points,
        np.zeros((len(points), 3), np.uint8),
        np.zeros(len(points), np.float32),
        np.concatenate([[0], np.cumsum(seen.sum(axis=1))]).astype(np.int64),
        columns.astype(np.int32),
        pixels.reshape(-1, 2).astype(np.float32),
    )


def wall(n=400, seed=0):
    return np.random.default_rng(seed).uniform([-6, -2, -0.3], [6, 2, 0.3], (n, 3))


def row_of(count, apart=1.0, distance=5.0):
    centres = [np.array([apart * i - 1.0, 0.0, distance]) for i in range(count)]
    return [look(f"{i}.jpg", LENS, c, c - [0.0, 0.0, 1.0]) for i, c in enumerate(centres)]


def test_neighbours_in_a_row_are_selected_first_on_both_sides():
    pairs = select_pairs(scene_of(row_of(5), wall()), count=2)
    assert {source.view for source in pairs.plans[2].sources} == {1, 3}
    assert all(source.method == "sgbm" for source in pairs.plans[2].sources)
    assert pairs.left_out == ()


def test_convergent_photos_are_not_rectified():
    turned = [
        look(f"{a}.jpg", LENS, 5 * np.array([np.sin(t), 0.0, np.cos(t)]), np.zeros(3))
        for a, t in ((a, np.radians(a)) for a in (0, 10, 60))
    ]
    plan = select_pairs(scene_of(turned, wall() * [0.2, 0.5, 1.0])).plans[0]
    assert {source.view: source.method for source in plan.sources} == {1: "sgbm", 2: "patchmatch"}
    by_view = {source.view: source for source in plan.sources}
    assert by_view[2].convergence_deg == pytest.approx(60.0)


def test_photos_one_behind_the_other_are_not_rectified():
    centres = np.array([[0.0, 0.0, 5.0], [0.3, 0.0, 4.0]])
    views = [look(f"{i}.jpg", LENS, c, c - [0.0, 0.0, 1.0]) for i, c in enumerate(centres)]
    plan = select_pairs(scene_of(views, wall() * [0.4, 1.0, 1.0])).plans[0]
    assert plan.sources[0].method == "patchmatch"


def test_depth_range_contains_the_rock_and_excludes_outliers():
    points = np.vstack([wall(), [[0.0, 0.0, -400.0]]])
    plan = select_pairs(scene_of(row_of(3), points)).plans[1]
    assert 4.0 < plan.near < 4.7
    assert 5.3 < plan.far < 7.0


def test_scaling_the_scene_by_ten_scales_the_depth_range_by_ten():
    scene = scene_of(row_of(3), wall())
    larger = replace(
        scene,
        points=10 * scene.points,
        views=tuple(view.moved(10.0, np.eye(3), np.zeros(3)) for view in scene.views),
    )
    for one, ten in zip(select_pairs(scene).plans, select_pairs(larger).plans, strict=True):
        assert (ten.near, ten.far) == pytest.approx((10 * one.near, 10 * one.far))
        assert [s.view for s in ten.sources] == [s.view for s in one.sources]


def test_photo_without_tie_points_is_left_out_and_reported():
    away = look("away.jpg", LENS, [0.0, 0.0, 5.0], [0.0, 0.0, 50.0])
    pairs = select_pairs(scene_of([*row_of(3), away], wall()))
    assert [plan.view for plan in pairs.plans] == [0, 1, 2]
    (finding,) = pairs.left_out
    assert (finding.code, finding.values["photo"]) == ("dense.few-tie-points", "away.jpg")


def test_photos_without_a_neighbour_are_rejected():
    same = row_of(1) * 2
    with refused("dense.no-photos", GeometryError):
        select_pairs(scene_of(same, wall()))


def test_one_photo_has_no_depth():
    with refused("dense.too-few-photos", GeometryError):
        select_pairs(scene_of(row_of(1), wall()))
