"""Depth maps against truth: planes in closed form, and a rock face by ray casting."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from tests.messages import refused
from tests.photogrammetry.dense.dense_truth import (
    accuracy,
    completeness,
    look,
    lying_face,
    tie_points,
    true_depth,
    true_points,
)
from tests.photogrammetry.rock_face import photograph
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import GeometryError
from vomstudio.geometry.cameras import Intrinsics
from vomstudio.photogrammetry.dense.depthmaps import (
    DepthMap,
    DepthTask,
    depth_map,
    make_task,
    peak_memory_bytes,
)
from vomstudio.photogrammetry.dense.fusion import fuse_depth_maps, neighbours_by_name
from vomstudio.photogrammetry.dense.pairs import select_pairs
from vomstudio.photogrammetry.dense.undistortion import UndistortedPhoto, UndistortTask, undistort

DISTANCE, FOCAL = 4.0, 480.0
GSD = DISTANCE / FOCAL
LENS = Intrinsics.pinhole(520, 390, FOCAL, 262.4, 193.1)
BENT = Intrinsics("OPENCV", 520, 390, (480.0, 480.0, 262.4, 193.1, -0.12, 0.03, 0.001, -0.001))


def png(picture):
    return cv2.imencode(".png", np.ascontiguousarray(picture[..., ::-1]))[1].tobytes()


def taken(face, views, masks=None):
    photos = [png(photograph(face, view, samples=1, seed=i)) for i, view in enumerate(views)]
    masks = masks or [None] * len(views)
    tasks = [
        UndistortTask(p, m, v, None, True) for p, m, v in zip(photos, masks, views, strict=True)
    ]
    return [undistort(task) for task in tasks]


def parallel(lens=LENS, apart=0.6):
    centres = [[x, y, DISTANCE] for y in (-apart / 2, apart / 2) for x in (-apart, 0.0, apart)]
    return [look(f"{i}.png", lens, c, [*c[:2], 0.0]) for i, c in enumerate(np.array(centres))]


def around(degrees, lens=LENS):
    angles = np.radians(degrees)
    centres = DISTANCE * np.column_stack([np.sin(angles), 0 * angles, np.cos(angles)])
    return [look(f"{i}.png", lens, c, np.zeros(3)) for i, c in enumerate(centres)]


def maps_of(photos, scene, **choice):
    pairs = select_pairs(scene, **choice)
    return pairs, [depth_map(make_task(plan, photos.__getitem__)) for plan in pairs.plans]


def plane(slope=(0.0, 0.0)):
    return lying_face((5.0, 4.0), 0.02, relief=0.0, ledge=0.0, slope=slope)


@pytest.fixture(scope="module")
def rock():
    return lying_face((5.0, 4.0), 0.01, relief=0.12, ledge=0.05, seed=3)


@pytest.fixture(scope="module")
def front():
    """Six photos of a plane at right angles, and their scene."""
    face, views = plane(), parallel()
    return taken(face, views), tie_points(face, views, 600)


@pytest.mark.parametrize("method", first_in_default_tier(["sgbm", "patchmatch"]))
def test_frontal_plane_has_its_depth(front, method):
    photos, scene = front
    plan = select_pairs(scene, method=method).plans[1]
    made = depth_map(make_task(plan, photos.__getitem__))
    inside = made.depth > 0
    assert inside.mean() > 0.9
    # Of thousands of pixels: half a pixel of shift, or of disparity, would be far off.
    assert np.median(made.depth[inside]) == pytest.approx(DISTANCE, rel=5e-4)
    assert np.median(np.abs(made.depth[inside] - DISTANCE)) < 0.5 * GSD
    mean = made.normals[inside].mean(axis=0)
    # Each within some degrees, all together exactly.
    assert np.linalg.norm(mean) > np.cos(np.radians(10.0))
    limit = 0.5 if method == "sgbm" else 2.0
    assert np.degrees(np.arccos(-mean[2] / np.linalg.norm(mean))) < limit


@pytest.mark.full
@pytest.mark.parametrize("method", ["sgbm", "patchmatch"])
def test_an_oblique_plane_has_its_normal_and_its_depths(method):
    slope = (0.4, -0.25)
    face, views = plane(slope), parallel()
    photos, scene = taken(face, views), tie_points(face, views, 600)
    made = depth_map(make_task(select_pairs(scene, method=method).plans[1], photos.__getitem__))
    normal = np.array([-slope[0], -slope[1], 1.0]) / np.linalg.norm([*slope, 1.0])
    inside = made.normals.any(axis=2)
    assert inside.mean() > 0.85
    mean = made.normals[inside].mean(axis=0)
    mean /= np.linalg.norm(mean)
    limit = 0.5 if method == "sgbm" else 2.0
    assert np.degrees(np.arccos(mean @ (views[1].rotation @ normal))) < limit
    truth = true_depth(face, views[1])
    both = inside & (truth > 0)
    # A pixel's offset along the slope would show as 0.4 GSD.
    assert abs(np.median(made.depth[both] - truth[both])) < 0.1 * GSD


@pytest.mark.full
@pytest.mark.parametrize("method", first_in_default_tier(["sgbm", "patchmatch"], 1))
def test_scaling_the_scene_by_ten_scales_the_depths_by_ten(front, method):
    photos, scene = front
    larger = [
        UndistortedPhoto(p.photo, p.mask, p.view.moved(10.0, np.eye(3), np.zeros(3)))
        for p in photos
    ]
    plan = select_pairs(scene, method=method).plans[1]
    task = make_task(plan, photos.__getitem__)
    ten = replace(
        make_task(plan, larger.__getitem__),
        points=10 * plan.points,
        near=10 * plan.near,
        far=10 * plan.far,
    )
    one, ten = depth_map(task), depth_map(ten)
    both = (one.depth > 0) & (ten.depth > 0)
    assert np.mean((one.depth > 0) != (ten.depth > 0)) < 0.01
    np.testing.assert_allclose(np.median(ten.depth[both] / one.depth[both]), 10.0, rtol=1e-4)
    assert np.mean(np.abs(ten.depth[both] / one.depth[both] - 10.0) < 0.05) > 0.95


@pytest.mark.parametrize(
    "lens",
    [
        pytest.param(LENS, marks=pytest.mark.full),
        pytest.param(BENT, marks=pytest.mark.slow),
    ],
    ids=["straight", "bent"],
)
def test_rock_face_in_parallel_photos_is_reconstructed(rock, lens):
    views = parallel(lens)
    photos = taken(rock, views)
    scene = tie_points(rock, views, 1500)
    pairs, maps = maps_of(photos, scene)
    assert all(source.method == "sgbm" for plan in pairs.plans for source in plan.sources)
    cloud = fuse_depth_maps([m.name for m in maps], maps, photos, neighbours_by_name(scene, pairs))
    median, most = accuracy(rock, cloud.points)
    assert median < 0.35 * GSD
    assert most < 1.6 * GSD
    assert completeness(cloud.points, true_points(rock, views, 20_000), GSD) > 0.97


@pytest.mark.full
@pytest.mark.parametrize(("chosen", "found"), [(None, "sgbm"), ("patchmatch", "patchmatch")])
def test_rock_face_in_convergent_photos_is_reconstructed(rock, chosen, found):
    views = around([-48, -24, 0, 24, 48])
    photos = taken(rock, views)
    scene = tie_points(rock, views, 1500)
    pairs, maps = maps_of(photos, scene, count=2, method=chosen)
    assert all(source.method == found for plan in pairs.plans for source in plan.sources)
    cloud = fuse_depth_maps([m.name for m in maps], maps, photos, neighbours_by_name(scene, pairs))
    median, most = accuracy(rock, cloud.points)
    assert median < 0.4 * GSD
    assert most < 3.0 * GSD
    assert completeness(cloud.points, true_points(rock, views, 20_000), GSD) > 0.85


@pytest.mark.full
def test_masked_pixels_neither_get_nor_contribute_depths(rock):
    views = parallel()[:3]
    mask = np.full((390, 520), 255, np.uint8)
    mask[:, :260] = 0
    photos = taken(rock, views, [None, cv2.imencode(".png", mask)[1].tobytes(), None])
    scene = tie_points(rock, views, 1500)
    plan = select_pairs(scene).plans[1]
    assert not depth_map(make_task(plan, photos.__getitem__)).depth[:, :260].any()
    # Photo 0 with the masked one alone: what lies under its mask cannot be measured.
    plan = select_pairs(scene).plans[0]
    only = replace(plan, sources=tuple(s for s in plan.sources if s.view == 1))
    for method in ("sgbm", "patchmatch"):
        forced = replace(only, sources=tuple(replace(s, method=method) for s in only.sources))
        made = depth_map(make_task(forced, photos.__getitem__))
        assert made.depth.any()
        rows, columns = np.nonzero(made.depth)
        rays = views[0].intrinsics.rays(np.column_stack([columns, rows]) + 0.5)
        points = (rays * made.depth[rows, columns][:, None] - views[0].translation) @ views[
            0
        ].rotation
        assert np.percentile(views[1].project(points)[:, 0], 2) > 256


@pytest.mark.full
def test_threads_do_not_change_the_result_and_the_seed_fixes_it(front):
    photos, scene = front
    task = make_task(select_pairs(scene, method="patchmatch", count=2).plans[0], photos.__getitem__)
    one = depth_map(task)
    two = depth_map(replace(task, options=replace(task.options, threads=2)))
    np.testing.assert_array_equal(one.depth, two.depth)
    np.testing.assert_array_equal(one.confidence, two.confidence)


def test_completely_masked_photo_has_an_empty_map(front):
    photos, scene = front
    black = cv2.imencode(".png", np.zeros((390, 520), np.uint8))[1].tobytes()
    task = make_task(select_pairs(scene).plans[0], photos.__getitem__)
    made = depth_map(replace(task, reference=replace(task.reference, mask=black)))
    assert made.filled == 0.0
    assert not made.normals.any()


def test_invalid_depth_tasks_are_rejected(front):
    photos, scene = front
    task = make_task(select_pairs(scene).plans[0], photos.__getitem__)
    with refused("dense.no-sources", GeometryError):
        depth_map(replace(task, sources=(), methods=()))
    with refused("dense.depth-range", GeometryError):
        depth_map(replace(task, near=5.0, far=4.0))
    with refused("dense.no-base", GeometryError):
        depth_map(replace(task, sources=task.sources[:1] * 2 + (photos[0],), methods=("sgbm",) * 3))
    with refused("photo.unreadable"):
        depth_map(replace(task, reference=replace(task.reference, photo=b"")))
    bent = replace(task.reference.view, intrinsics=BENT)
    with refused("dense.distorted", GeometryError):
        depth_map(replace(task, reference=replace(task.reference, view=bent)))
    assert isinstance(task, DepthTask)


def test_depth_map_is_read_from_its_file_and_a_partial_file_is_rejected(front, tmp_path):
    photos, scene = front
    made = depth_map(make_task(select_pairs(scene).plans[0], photos.__getitem__))
    made.save(tmp_path / "map.npz")
    back = DepthMap.load(tmp_path / "map.npz")
    np.testing.assert_array_equal(back.depth, made.depth)
    np.testing.assert_array_equal(back.confidence, made.confidence)
    np.testing.assert_allclose(back.normals, made.normals, atol=1e-3)
    assert back.view.name == made.name
    whole = (tmp_path / "map.npz").read_bytes()
    (tmp_path / "map.npz").write_bytes(whole[: len(whole) // 2])
    with refused("reconstruct.damaged"):
        DepthMap.load(tmp_path / "map.npz")


def test_memory_grows_with_pixels_and_sources():
    assert peak_memory_bytes(2000, 1500, 4) > 3 * peak_memory_bytes(1000, 750, 4) - 200_000_000
    assert peak_memory_bytes(4000, 3000, 8) > peak_memory_bytes(4000, 3000, 4)
