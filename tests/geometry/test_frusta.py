"""Photos as pyramids in space."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.geometry.frusta import (
    choose_frustum_size,
    edge_pixels,
    find_frustum_at_pixel,
    frusta,
    frustum,
)


def view(seed: int, k1: float = -0.05) -> View:
    rng = np.random.default_rng(seed)
    lens = Intrinsics("SIMPLE_RADIAL", 4000, 3000, (3500.0, 2010.0, 1490.0, k1))
    rotation = Rotation.random(random_state=seed).as_matrix()
    return View("p", lens, rotation, rng.normal(0, 10, 3))


@given(st.integers(0, 500), st.floats(-0.1, 0.1), st.floats(0.01, 100))
def test_a_frustums_corners_are_the_corners_of_the_photo(seed, k1, depth) -> None:
    taken = view(seed, k1)
    found = frustum(taken, depth)
    corners = [[0, 0], [4000, 0], [4000, 3000], [0, 3000]]
    assert np.allclose(taken.project(found.corners), corners, atol=1e-3)
    assert np.allclose(taken.depths(found.corners), depth)
    assert np.allclose(found.tip, taken.centre)


def test_the_outline_runs_along_the_edge_of_the_photo() -> None:
    taken = view(3)
    pixels = taken.project(frustum(taken, 2.0).outline)
    x, y = pixels.T
    on_edge = (
        np.isclose(x, 0, atol=1e-3)
        | np.isclose(x, 4000, atol=1e-3)
        | np.isclose(y, 0, atol=1e-3)
        | np.isclose(y, 3000, atol=1e-3)
    )
    assert on_edge.all()
    assert np.allclose(pixels[0], pixels[-1])


def test_distorted_edge_has_six_segments_and_straight_edge_one() -> None:
    for k1, pieces in ((-0.05, 6), (0.0, 1)):
        found = frustum(view(4, k1), 2.0)
        assert found.outline.shape == (4 * pieces + 1, 3)
        assert np.array_equal(found.outline[:-1:pieces], found.corners)


def test_lens_not_reaching_the_photo_corners_still_has_a_frustum() -> None:
    lens = Intrinsics("SIMPLE_RADIAL", 4000, 3000, (1500.0, 2000.0, 1500.0, -0.4))
    assert np.isnan(lens.rays([[0.0, 0.0]])).any()
    found = frustum(View("p", lens, np.eye(3), np.zeros(3)), 1.0)
    assert np.isfinite(found.outline).all()


def test_transformed_frustum_matches_frustum_of_moved_photo() -> None:
    taken, turn = view(5), Rotation.random(random_state=1).as_matrix()
    shift, origin = np.array([5.0, -3.0, 2.0]), np.array([100.0, 200.0, 300.0])
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = 2.5 * turn, shift
    there = frustum(taken, 3.0).transform(matrix, origin)
    again = frustum(taken.moved(2.5, turn, shift + 2.5 * turn @ origin), 7.5)
    assert np.allclose(there.tip, again.tip)
    assert np.allclose(there.outline, again.outline)


def test_frustum_size_scales_with_spacing_and_distance() -> None:
    row = np.column_stack([np.arange(8.0), np.zeros(8), np.zeros(8)])
    assert 0.2 < choose_frustum_size(row, 30.0) < 0.6
    assert choose_frustum_size(10 * row, 300.0) == pytest.approx(
        10 * choose_frustum_size(row, 30.0)
    )
    # Frames of a video, far closer to each other than to the rock: still to be seen.
    assert choose_frustum_size(row / 1000, 30.0) > 0.1
    # Far apart, but near to the rock: they must not reach into it.
    assert choose_frustum_size(100 * row, 4.0) < 1.0
    assert choose_frustum_size(row[:1], 10.0) > 0.5
    # From one spot in all directions.
    assert choose_frustum_size(np.zeros((5, 3)), 10.0) > 0.5
    assert choose_frustum_size(np.zeros((1, 3)), 0.0) > 0.0
    assert frusta([], np.zeros(3)) == []


def test_the_camera_under_the_cursor_is_found() -> None:
    tips = np.array([[100.0, 100.0], [300.0, 100.0], [np.nan, np.nan]])
    corners = np.array(
        [
            [[60, 60], [140, 60], [140, 140], [60, 140]],
            [[290, 90], [310, 90], [310, 110], [290, 110]],
            [[np.nan, np.nan]] * 4,
        ]
    )
    assert find_frustum_at_pixel(tips, corners, 102, 99, 9.0) == 0
    assert find_frustum_at_pixel(tips, corners, 65, 65, 9.0) == 0
    assert find_frustum_at_pixel(tips, corners, 200, 100, 9.0) is None
    # Mirrored on the screen it is the same photo.
    assert find_frustum_at_pixel(tips, corners[:, ::-1], 65, 65, 9.0) == 0
    assert find_frustum_at_pixel(np.zeros((0, 2)), np.zeros((0, 4, 2)), 1, 1, 9.0) is None


def test_photos_from_one_spot_are_ignored_for_spacing_at_any_scale() -> None:
    """Two by two from one spot, but for a millionth of the scene."""
    for scale in (0.01, 1.0, 1000.0):
        spots = scale * np.column_stack([np.arange(6.0), np.zeros(6), np.zeros(6)])
        pairs = np.vstack([spots, spots + [0, 1e-7 * min(scale, 1.0), 0]])
        alone = choose_frustum_size(spots[:1], 10.0 * scale)
        assert choose_frustum_size(pairs, 10.0 * scale) == pytest.approx(alone)
    spots = 1000.0 * np.column_stack([np.arange(6.0), np.zeros(6), np.zeros(6)])
    pairs = np.vstack([spots, spots + [0, 1e-4, 0]])
    assert choose_frustum_size(pairs, 1e4) == pytest.approx(choose_frustum_size(spots[:1], 1e4))


@pytest.mark.parametrize(
    ("step", "distance", "wanted"),
    [
        (1.0, 30.0, 0.35),  # a share of the spacing
        (100.0, 30.0, 6.0),  # a share of the distance, where that is less
        (1e-3, 30.0, 0.3),  # a twentieth of this share at least
        (1.0, 0.0, 0.35),  # the distance is not known
        (0.0, 30.0, 6.0),  # one spot
        (0.0, 0.0, 1.0),  # nothing is known
    ],
)
def test_frustum_sizes_have_expected_values(step: float, distance: float, wanted: float) -> None:
    row = step * np.column_stack([np.arange(6.0), np.zeros(6), np.zeros(6)])
    assert choose_frustum_size(row, distance) == pytest.approx(wanted)


def test_frusta_of_photo_ring_share_one_size_and_keep_their_positions() -> None:
    """Eight photos on a circle of 10 m look at its middle."""
    lens = Intrinsics("PINHOLE", 400, 300, (350.0, 350.0, 200.0, 150.0))
    views = []
    for k in range(8):
        turn = Rotation.from_euler("y", 45.0 * k, degrees=True).as_matrix()
        views.append(View(f"p{k}", lens, turn, np.array([0.0, 0.0, 10.0])))
    middle = np.array([3.0, -4.0, 5.0])
    views = [v.moved(1.0, np.eye(3), middle) for v in views]
    found = frusta(views, middle)
    apart = 2.0 * 10.0 * np.sin(np.pi / 8)
    for taken, one in zip(views, found, strict=True):
        assert one.name == taken.name
        assert one.tip == pytest.approx(taken.centre)
        assert taken.depths(one.corners) == pytest.approx(np.full(4, min(0.35 * apart, 2.0)))
        assert len(one.outline) == 5


def test_smallest_of_overlapping_photos_is_found() -> None:
    tips = np.full((3, 2), -500.0)
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    corners = np.stack([100.0 + 90.0 * square, 120.0 + 20.0 * square, 110.0 + 50.0 * square])
    for order in ([0, 1, 2], [2, 0, 1], [1, 2, 0]):
        for x, smallest in ((130.0, 1), (155.0, 2), (185.0, 0)):
            found = find_frustum_at_pixel(tips, corners[order], x, x, 9.0)
            assert order[found] == smallest  # type: ignore[index]
    assert find_frustum_at_pixel(tips, corners, 191.0, 130.0, 9.0) is None
    # Its own edge is part of a photo, and a tip is met up to its reach.
    assert find_frustum_at_pixel(tips, corners, 190.0, 130.0, 9.0) == 0
    tips[2] = 300.0
    assert find_frustum_at_pixel(tips, corners, 303.0, 304.0, 5.0) == 2
    assert find_frustum_at_pixel(tips, corners, 303.0, 304.0, 4.9) is None


@pytest.mark.parametrize("steps", [1, 2, 6])
def test_border_pixels_are_evenly_spaced_clockwise_from_top_left(
    steps: int,
) -> None:
    found = edge_pixels(60, 30, steps)
    assert found.shape == (4 * steps, 2)
    assert found[::steps].tolist() == [[0, 0], [60, 0], [60, 30], [0, 30]]
    sides = np.linalg.norm(np.roll(found, -1, axis=0) - found, axis=1)
    assert sides == pytest.approx(np.repeat([60, 30, 60, 30], steps) / steps)
