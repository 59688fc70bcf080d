"""The clipping box: what lies in it, and where rays meet it."""

from __future__ import annotations

import numpy as np
import pytest

from vomstudio.rendering.view.clipping import (
    BOX_EDGES,
    BOX_FACES,
    ClipBox,
    along_axis,
    find_pick_limits,
)

UTM = np.array([576_712.0, 5_188_140.0, 183.0])
BOX = ClipBox((0.0, 0.0, 0.0), (10.0, 4.0, 6.0))


@pytest.mark.full
def test_a_box_has_eight_corners_twelve_edges_and_six_faces() -> None:
    corners = BOX.corners()
    assert len(np.unique(corners, axis=0)) == 8
    assert len(BOX_EDGES) == 12
    for a, b in BOX_EDGES:
        assert np.count_nonzero(corners[a] != corners[b]) == 1
    assert len(BOX_FACES) == 6


def test_opposite_box_faces_cannot_cross() -> None:
    assert BOX.move_face(0, 1, 3.0).high == (3.0, 4.0, 6.0)
    moved = BOX.move_face(0, 1, -5.0)
    assert moved.low[0] < moved.high[0] < 0.1
    moved = BOX.move_face(2, 0, 99.0)
    assert 5.9 < moved.low[2] < moved.high[2]


def test_box_of_a_flat_model_has_nonzero_height() -> None:
    box = ClipBox.from_points(np.array([[0.0, 0, 5], [1, 1, 5]]))
    assert box.low[2] < 5.0 < box.high[2]


def test_ray_range_is_between_the_faces_that_the_ray_crosses() -> None:
    assert BOX.ray_range(np.array([5.0, -10, 3]), np.array([0.0, 1, 0])) == (10.0, 14.0)
    assert BOX.ray_range(np.array([5.0, 2, 3]), np.array([0.0, 1, 0])) == (0.0, 2.0)
    assert BOX.ray_range(np.array([5.0, -10, 9]), np.array([0.0, 1, 0])) is None
    assert BOX.ray_range(np.array([5.0, 10, 3]), np.array([0.0, 1, 0])) is None


def test_box_limits_are_in_model_units() -> None:
    """A model in millimetres, turned a quarter about the vertical."""
    to_world = np.eye(4)
    to_world[:3, :3] = 1e-3 * np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    to_world[:3, 3] = UTM
    box = ClipBox.from_points(BOX.corners() + UTM)
    start = UTM + [5.0, -10.0, 3.0]
    limits = find_pick_limits(
        box, start, np.array([0.0, 1.0, 0.0]), to_world, np.array([7.0, 0, 0])
    )
    assert limits is not None
    assert [limits.first, limits.last] == pytest.approx([10_000.0, 14_000.0])
    world = np.random.default_rng(0).uniform(-2, 12, (200, 3)) + UTM
    local = (world - UTM) @ np.linalg.inv(to_world[:3, :3]).T - [7.0, 0, 0]
    assert np.array_equal(limits.inside(local), box.contains(world))


def test_a_handle_follows_the_ray_along_its_axis() -> None:
    through = np.array([10.0, 2.0, 3.0])
    for x in (-4.0, 3.0, 25.0):
        eye = np.array([5.0, -40.0, 12.0])
        direction = np.array([x, 2.0, 3.0]) - eye
        found = along_axis(eye, direction / np.linalg.norm(direction), through, 0)
        assert found == pytest.approx(x)
    assert along_axis(np.array([-9.0, 2, 3]), np.array([1.0, 0, 0]), through, 0) is None
