"""Boxes along the axes of World, against asking many points along a ray."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from vomstudio.geometry.boxes import (
    BOX_EDGES,
    BOX_FACES,
    ClipBox,
    are_boxes_hit,
    box_range,
    is_box_hit,
)

UTM = np.array([576_700.0, 5_188_150.0, 160.0])
BOX = ClipBox((0.0, 10.0, -3.0), (4.0, 11.0, 2.0))


def some_boxes(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    low = rng.uniform(-5.0, 4.0, (count, 3))
    return low, low + rng.uniform(0.2, 3.0, (count, 3))


def test_box_of_points_is_tight() -> None:
    points = np.random.default_rng(0).normal(size=(60, 3)) * [9.0, 1.0, 3.0] + UTM
    box = ClipBox.from_points(points)
    assert box.contains(points).all()
    assert np.array_equal([box.low, box.high], [points.min(axis=0), points.max(axis=0)])


@pytest.mark.parametrize("thick", [0.0, 0.9e-3])
def test_box_of_flat_model_is_padded_by_half_a_metre(thick: float) -> None:
    box = ClipBox.from_points(np.array([[0.0, 5.0, 1.0], [2.0, 5.0 + thick, 1.0]]))
    assert box.low == pytest.approx((0.0, 4.5, 0.5))
    assert box.high == pytest.approx((2.0, 5.5 + thick, 1.5))


def test_box_a_few_millimetres_thick_is_not_padded() -> None:
    box = ClipBox.from_points(np.array([[0.0, 0.0, 0.0], [2e-3, 1.0, 3.0]]))
    assert (box.low, box.high) == ((0.0, 0.0, 0.0), (2e-3, 1.0, 3.0))


def test_box_round_trips_through_dict() -> None:
    assert ClipBox.from_dict(BOX.to_dict()) == BOX
    assert BOX.to_dict() == {"low": [0.0, 10.0, -3.0], "high": [4.0, 11.0, 2.0]}


@pytest.mark.parametrize(
    "values",
    [
        None,
        {},
        {"low": [0, 0, 0]},
        {"low": [0, 0], "high": [1, 1, 1]},
        {"low": [0, 0, 0], "high": [1, 1]},
        {"low": [0, 0, 0], "high": [1, 1, 0]},
        {"low": [0, 0, 0], "high": [-1, 1, 1]},
        {"low": [0, 0, "a"], "high": [1, 1, 1]},
        {"low": [0, 0, float("nan")], "high": [1, 1, 1]},
    ],
)
def test_invalid_box_values_are_rejected(values: object) -> None:
    with pytest.raises(ValueError, match="box"):
        ClipBox.from_dict(values)


def test_corners_edges_and_faces_form_a_cuboid() -> None:
    corners = BOX.corners()
    assert ConvexHull(corners).volume == pytest.approx(4.0 * 1.0 * 5.0)
    assert len({tuple(corner) for corner in corners}) == 8
    lengths = sorted(float(np.abs(corners[a] - corners[b]).sum()) for a, b in BOX_EDGES)
    assert lengths == [1.0] * 4 + [4.0] * 4 + [5.0] * 4
    along_one_axis = [(corners[a] != corners[b]).sum() == 1 for a, b in BOX_EDGES]
    assert all(along_one_axis)
    assert len(BOX_FACES) == len(set(BOX_FACES)) == 6
    for axis, side in BOX_FACES:
        on_it = corners[corners[:, axis] == (BOX.low, BOX.high)[side][axis]]
        assert BOX.face_centre(axis, side) == pytest.approx(on_it.mean(axis=0))


@pytest.mark.parametrize(("axis", "side"), BOX_FACES)
def test_dragged_face_moves_and_stops_just_before_opposite_face(axis: int, side: int) -> None:
    ends = [BOX.low[axis], BOX.high[axis]]
    for value in (ends[side] + 0.1, ends[side] - 0.1, ends[side] + (2 * side - 1) * 50.0):
        moved = BOX.move_face(axis, side, value)
        assert (moved.low, moved.high)[side][axis] == value
        kept = [
            (end[k], own[k])
            for end, own in zip((moved.low, moved.high), (BOX.low, BOX.high), strict=True)
            for k in range(3)
            if k != axis
        ]
        assert all(now == before for now, before in kept)
        assert (moved.low, moved.high)[1 - side][axis] == ends[1 - side]
    beyond = ends[1 - side] - (2 * side - 1) * 7.0
    squeezed = BOX.move_face(axis, side, beyond)
    gap = squeezed.high[axis] - squeezed.low[axis]
    assert gap == pytest.approx(1e-3 * (ends[1] - ends[0]), rel=1e-9)
    assert (squeezed.low, squeezed.high)[1 - side][axis] == ends[1 - side]
    tiny = ClipBox((0.0, 0.0, 0.0), (0.1, 0.1, 0.1)).move_face(axis, side, 9.0 * (1 - 2 * side))
    assert tiny.high[axis] - tiny.low[axis] == pytest.approx(1e-3)


def test_boxes_intersect_if_they_share_at_least_one_point() -> None:
    cube = ClipBox((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    for axis in range(3):
        for way in (-1.0, 1.0):
            for gap, meets in ((0.9, True), (1.0, True), (1.001, False)):
                shift = np.zeros(3)
                shift[axis] = way * gap
                low, high = shift, shift + 1.0
                other = ClipBox(tuple(low.tolist()), tuple(high.tolist()))
                assert cube.intersects_box(other) is other.intersects_box(cube) is meets
    assert cube.intersects_box(ClipBox((0.4, 0.4, 0.4), (0.6, 0.6, 0.6)))


def test_box_contains_its_corners_and_nothing_outside() -> None:
    corners, middle = BOX.corners(), (np.array(BOX.low) + BOX.high) / 2
    assert BOX.contains(corners).all()
    assert not BOX.contains(middle + (corners - middle) * (1 + 1e-9)).any()
    for axis, side in BOX_FACES:
        beyond = BOX.face_centre(axis, side)
        beyond[axis] += (2 * side - 1) * 1e-9
        assert not BOX.contains(beyond)[0]


def test_ball_intersects_box_if_nearest_box_point_is_within_radius() -> None:
    rng = np.random.default_rng(1)
    centres = rng.uniform(-8.0, 16.0, (120, 3))
    steps = np.stack(np.meshgrid(*[np.linspace(0, 1, 21)] * 3), axis=-1).reshape(-1, 3)
    inside = np.array(BOX.low) + steps * (np.array(BOX.high) - BOX.low)
    nearest = np.array([np.linalg.norm(inside - c, axis=1).min() for c in centres])
    assert BOX.intersects_balls(centres, nearest + 1e-9).all()
    outside = nearest > 0.3
    assert outside.sum() > 90
    # Half a diagonal of the grid is 17 cm, and the box itself no nearer than that.
    assert not BOX.intersects_balls(centres[outside], nearest[outside] - 0.2).any()
    assert BOX.intersects_balls(np.array([[6.0, 10.5, 0.0]]), np.array([2.0])).all()


def test_box_range_of_ray_runs_from_entry_to_exit() -> None:
    low, high = some_boxes(60, 2)
    rng = np.random.default_rng(3)
    steps = np.linspace(-30.0, 30.0, 12_001)
    hit = 0
    for _ in range(6):
        origin, way = rng.uniform(-6.0, 6.0, 3), rng.normal(size=3)
        way /= np.linalg.norm(way)
        points = origin + steps[:, None] * way
        enter, leave = box_range(low, high, origin, way)
        ahead = are_boxes_hit(low, high, origin, way)
        for k in range(60):
            there = steps[((points >= low[k]) & (points <= high[k])).all(axis=1)]
            if len(there):
                hit += 1
                assert enter[k] == pytest.approx(there[0], abs=6e-3)
                assert leave[k] == pytest.approx(there[-1], abs=6e-3)
                assert ahead[k] == (there[-1] >= 0.0)
                assert is_box_hit(low[k], high[k], origin, way) == ahead[k]
                assert is_box_hit(low[k], high[k], origin, way, pad=0.1) or not ahead[k]
            else:
                # Grazed for less than a step, or not at all.
                assert leave[k] - enter[k] < 6e-3
    assert hit > 10


@pytest.mark.parametrize("axis", range(3))
def test_axis_parallel_ray_hits_box_in_its_path(axis: int) -> None:
    low, high = np.zeros((1, 3)), np.array([[1.0, 2.0, 3.0]])
    way = np.zeros(3)
    way[axis] = -2.0
    others = [k for k in range(3) if k != axis]
    origin = np.full(3, 0.5)
    origin[axis] = 9.0
    enter, leave = box_range(low, high, origin, way)
    assert enter[0] == pytest.approx((9.0 - high[0, axis]) / 2.0)
    assert leave[0] == pytest.approx(4.5)
    assert are_boxes_hit(low, high, origin, way)[0]
    assert not are_boxes_hit(low, high, origin, -way)[0]
    assert is_box_hit(low[0], high[0], origin, way)
    assert not is_box_hit(low[0], high[0], origin, -way)
    beside = origin.copy()
    beside[others[0]] = -0.1
    assert not is_box_hit(low[0], high[0], beside, way)
    assert is_box_hit(low[0], high[0], beside, way, pad=0.2)
    for k in others:
        for place, meets in (
            (0.0, True),
            (high[0, k], True),
            (-1e-9, False),
            (high[0, k] + 1e-9, False),
        ):
            beside = origin.copy()
            beside[k] = place
            assert are_boxes_hit(low, high, beside, way)[0] == meets
    # It ends in the near face, or begins on the far one.
    for start, meets in ((0.0, True), (-1e-9, False)):
        origin[axis] = start
        assert are_boxes_hit(low, high, origin, way)[0] == meets


def test_ray_range_starts_at_or_ahead_of_the_origin() -> None:
    way = np.array([0.0, 0.0, 2.0])
    assert BOX.ray_range(np.array([1.0, 10.5, -9.0]), way) == pytest.approx((3.0, 5.5))
    assert BOX.ray_range(np.array([1.0, 10.5, 0.0]), way) == pytest.approx((0.0, 1.0))
    assert BOX.ray_range(np.array([1.0, 10.5, 2.0]), way) == pytest.approx((0.0, 0.0))
    assert BOX.ray_range(np.array([1.0, 10.5, 2.1]), way) is None
    assert BOX.ray_range(np.array([1.0, 11.2, 0.0]), way) is None


def test_ray_range_grows_by_the_padding_on_each_axis() -> None:
    assert BOX.ray_range(
        np.array([1.0, 11.2, -9.0]), np.array([0.0, 0.0, 2.0]), 0.5
    ) == pytest.approx((2.75, 5.75))
    for reach, after in pairwise((0.0, 0.1, 0.2, 0.3)):
        first, second = (
            BOX.ray_range(np.array([-5.0, 10.5, 0.0]), np.array([1.0, 0.0, 0.0]), r)
            for r in (reach, after)
        )
        assert first is not None
        assert second is not None
        assert second[1] - first[1] == pytest.approx(0.1)
        assert second[0] - first[0] == pytest.approx(-0.1)
