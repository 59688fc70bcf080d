"""Right, down and into the picture."""

from __future__ import annotations

import numpy as np
import pytest

from vomstudio.core.errors import GeometryError
from vomstudio.geology.orientation import lines_to_vectors
from vomstudio.geometry.view_frame import ViewFrame


def from_direction(trend: float, plunge: float) -> ViewFrame:
    return ViewFrame.from_direction(lines_to_vectors(trend, plunge))


@pytest.mark.parametrize(
    ("trend", "plunge", "right", "down"),
    [
        (0, 0, (1, 0, 0), (0, 0, -1)),  # toward North: East is right
        (90, 0, (0, -1, 0), (0, 0, -1)),  # toward East: South is right
        (180, 0, (-1, 0, 0), (0, 0, -1)),
        (0, 90, (1, 0, 0), (0, -1, 0)),  # straight down: a map
        (77, 90, (1, 0, 0), (0, -1, 0)),  # whatever its trend
        (0, -90, (-1, 0, 0), (0, -1, 0)),  # straight up: a mirrored map
        (0, 45, (1, 0, 0), (0, -(0.5**0.5), -(0.5**0.5))),
    ],
)
def test_right_and_down_as_a_viewer_has_them(trend, plunge, right, down) -> None:  # type: ignore[no-untyped-def]
    frame = from_direction(trend, plunge)
    assert frame.right == pytest.approx(right, abs=1e-15)
    assert frame.down == pytest.approx(down, abs=1e-15)


def test_axes_are_right_handed_for_every_direction() -> None:
    for trend in range(0, 360, 23):
        for plunge in (-90, -89.95, -60, -5, 0, 30, 89.85, 89.9, 90):
            axes = from_direction(trend, plunge).axes
            assert axes.T @ axes == pytest.approx(np.eye(3), abs=1e-14)
            assert np.linalg.det(axes) == pytest.approx(1.0)


@pytest.mark.parametrize("trend", [0.0, 33.0, 90.0, 200.0, 301.0])
def test_up_is_north_from_plunge_89_9(trend: float) -> None:
    assert from_direction(trend, 89.9).right == pytest.approx((1, 0, 0), abs=2e-3)
    below = from_direction(trend, 89.89).right
    t = np.radians(trend)
    assert below == pytest.approx((np.cos(t), -np.sin(t), 0), abs=1e-12)


def test_the_other_side_is_a_mirror_image() -> None:
    frame = from_direction(125.3, 26.1)
    other = ViewFrame.from_direction(-frame.direction)
    assert other.right == pytest.approx(-frame.right)
    assert other.down == pytest.approx(frame.down)


def test_pixel_to_world_reproduces_utm_points_to_micrometres() -> None:
    rng = np.random.default_rng(1)
    points = np.array([576_700.0, 5_188_150.0, 160.0]) + rng.uniform(-50, 50, (100, 3))
    reference = points.mean(axis=0)
    frame = from_direction(311.7, 38.2)
    view = frame.to_view(points, reference)
    gsd, left, top = 0.0037, -71.3, -64.9
    pixels = np.stack(
        [(view[:, 0] - left) / gsd, (view[:, 1] - top) / gsd, view[:, 2], np.ones(100)], axis=1
    )
    matrix = frame.pixel_to_world(gsd, reference, left, top)
    assert np.abs((pixels @ matrix.T)[:, :3] - points).max() < 5e-9 * 1e3


@pytest.mark.parametrize(
    ("plunge", "vertical"), [(90, True), (-90, True), (89.99, False), (-89.99, False), (0, False)]
)
def test_only_vertical_views_count_as_maps(plunge: float, vertical: bool) -> None:
    for trend in (0.0, 77.0, 205.0):
        assert from_direction(trend, plunge).is_vertical == vertical


@pytest.mark.parametrize("trend", [12.0, 250.0])
def test_steep_upward_view_also_has_north_up(trend: float) -> None:
    for plunge, north in ((-89.95, True), (-89.85, False)):
        right = from_direction(trend, plunge).right
        assert (abs(right[1]) < 2e-3) == north


def test_the_length_of_a_direction_does_not_matter() -> None:
    for length in (1e-12, 1.0, 1e9):
        frame = ViewFrame.from_direction(length * lines_to_vectors(33.0, 20.0))
        assert frame.axes == pytest.approx(from_direction(33.0, 20.0).axes)


def test_zero_direction_is_rejected() -> None:
    with pytest.raises(GeometryError):
        ViewFrame.from_direction((0, 0, 0))
    with pytest.raises(GeometryError):
        ViewFrame.from_direction((0, np.nan, 1))
