"""The view's own geometry, against the conventions and against itself backwards."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from vomstudio.rendering.view.camera import STANDARD_VIEWS, Camera, direction_vector, view_frame

SIZE = (1400.0, 900.0)
UTM = np.array([576_712.314, 5_188_140.552, 183.207])

trends = st.floats(0.0, 359.9)
plunges = st.floats(-89.9, 89.9)


def looking(trend: float, plunge: float, *, orthographic: bool = False) -> Camera:
    camera = Camera()
    camera.orthographic = orthographic
    camera.look_along(trend, plunge)
    camera.fit(UTM + np.array([[-20.0, -30.0, -5.0], [20.0, 30.0, 5.0]]), SIZE)
    return camera


@given(trends, plunges)
def test_looking_along_a_line_returns_its_trend_and_plunge(trend: float, plunge: float) -> None:
    camera = looking(trend, plunge)
    t, p = camera.trend_plunge()
    assert p == pytest.approx(plunge, abs=1e-6)
    apart = abs((t - trend + 180.0) % 360.0 - 180.0) * math.cos(math.radians(plunge))
    assert apart == pytest.approx(0.0, abs=1e-6)


@given(trends, st.floats(-88.9, 88.9))
def test_image_up_is_world_up_projected_onto_the_image(trend: float, plunge: float) -> None:
    right, up, direction = view_frame(trend, plunge)
    assert right[2] == pytest.approx(0.0, abs=1e-9)
    assert up[2] > 0.0
    np.testing.assert_allclose(np.cross(direction, up), right, atol=1e-9)
    np.testing.assert_allclose(direction, direction_vector(trend, plunge), atol=1e-12)


@pytest.mark.parametrize("plunge", [89.5, 90.0, -89.5, -90.0])
@pytest.mark.parametrize("trend", [0.0, 77.0, 200.0])
def test_north_is_image_up_within_a_degree_of_the_vertical(trend: float, plunge: float) -> None:
    right, up, _ = view_frame(trend, plunge)
    assert up[1] > 0.999
    # Looking down east is right; looking up from below it is left.
    assert right[0] == pytest.approx(math.copysign(1.0, plunge), abs=1e-3)


def test_east_is_on_the_right_when_looking_north() -> None:
    camera = looking(*STANDARD_VIEWS["north"])
    pixels, _ = camera.project(UTM + np.array([[0, 0, 0], [5.0, 0, 0], [0, 0, 2.0]]), SIZE)
    assert pixels[1, 0] > pixels[0, 0]
    assert pixels[2, 1] < pixels[0, 1]


@settings(max_examples=60)
@given(trends, plunges, st.floats(0, 1400), st.floats(0, 900), st.booleans())
def test_a_point_on_a_pixels_ray_projects_to_that_pixel(
    trend: float, plunge: float, x: float, y: float, orthographic: bool
) -> None:
    camera = looking(trend, plunge, orthographic=orthographic)
    origin, direction = camera.ray(x, y, SIZE)
    pixels, depth = camera.project((origin + 40.0 * direction)[None], SIZE)
    np.testing.assert_allclose(pixels[0], [x, y], atol=1e-4)
    back = camera.point_at_depth(x, y, SIZE, float(depth[0]))
    np.testing.assert_allclose(back, origin + 40.0 * direction, atol=1e-6)


@pytest.mark.parametrize("orthographic", [False, True])
def test_orbiting_zooming_and_panning_keep_their_fixed_points(orthographic: bool) -> None:
    camera = looking(30.0, 20.0, orthographic=orthographic)
    point = UTM + np.array([3.0, -2.0, 1.0])
    before, _ = camera.project(point[None], SIZE)
    camera.set_pivot(point)
    np.testing.assert_allclose(camera.project(point[None], SIZE)[0], before, atol=1e-6)
    camera.orbit(25.0, 10.0)
    np.testing.assert_allclose(camera.project(point[None], SIZE)[0], before, atol=1e-6)
    camera.zoom(0.5, point)
    np.testing.assert_allclose(camera.project(point[None], SIZE)[0], before, atol=1e-6)
    depth = float((point - camera.position) @ camera.direction)
    camera.pan(40.0, -25.0, SIZE[1], depth)
    np.testing.assert_allclose(
        camera.project(point[None], SIZE)[0], before + np.array([[40.0, -25.0]]), atol=1e-6
    )
    camera.tumble(15.0, -5.0)
    np.testing.assert_allclose(camera.frame @ camera.frame.T, np.eye(3), atol=1e-12)


def test_the_turntable_never_rolls_and_stops_at_the_vertical() -> None:
    camera = looking(10.0, 80.0)
    for _ in range(50):
        camera.orbit(7.0, 3.0)
        assert abs(camera.frame[0, 2]) < 1e-9
    assert camera.trend_plunge()[1] == pytest.approx(90.0)
    camera.orbit(0.0, -30.0)
    assert camera.trend_plunge()[1] == pytest.approx(60.0)


def test_switching_the_projection_keeps_the_size_at_the_pivot() -> None:
    camera = looking(0.0, 10.0)
    ends = np.stack([camera.pivot, camera.pivot + 2.0 * camera.frame[0]])
    before, _ = camera.project(ends, SIZE)
    camera.orthographic = True
    after, _ = camera.project(ends, SIZE)
    np.testing.assert_allclose(after, before, atol=1e-6)


def test_projection_resolves_millimetres_at_utm_coordinates() -> None:
    camera = looking(0.0, 0.0, orthographic=True)
    camera.zoom(0.001, UTM)
    step = np.array([[0.0, 0.0, 0.0], [0.001, 0.0, 0.0]]) + UTM
    pixels, _ = camera.project(step, SIZE)
    expected = 0.001 / camera.metres_per_pixel(SIZE[1])
    assert expected > 1.0
    assert pixels[1, 0] - pixels[0, 0] == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("orthographic", [False, True])
def test_fitting_shows_every_point_and_fills_the_view(orthographic: bool) -> None:
    points = UTM + np.random.default_rng(3).uniform(-1, 1, (50, 3)) * [30.0, 8.0, 4.0]
    camera = looking(40.0, 25.0, orthographic=orthographic)
    camera.fit(points, SIZE)
    pixels, depth = camera.project(points, SIZE)
    assert (depth > 0).all()
    assert (pixels >= 0).all()
    assert (pixels <= SIZE).all()
    spread = np.ptp(pixels, axis=0) / SIZE
    assert spread.max() > 0.85


@pytest.mark.parametrize("orthographic", [False, True])
def test_depth_range_contains_the_scene_and_depth_values_invert(orthographic: bool) -> None:
    camera = looking(0.0, 45.0, orthographic=orthographic)
    corners = UTM + np.array([[-20.0, -30.0, -5.0], [20.0, 30.0, 5.0]])
    eye = camera.eye(corners)
    depth = eye.depth(corners)
    assert (depth > eye.near).all()
    assert (depth < eye.far).all()
    assert eye.near > 0.0
    n, f = eye.near, eye.far
    z = (depth - n) / (f - n) if orthographic else f * (depth - n) / (depth * (f - n))
    np.testing.assert_allclose(eye.depth_from_buffer(z), depth, rtol=1e-9)


def test_view_survives_json() -> None:
    camera = looking(123.0, 33.0, orthographic=True)
    camera.tumble(10.0, 20.0)
    other = Camera()
    other.restore(json.loads(json.dumps(camera.to_dict())))
    points = UTM + np.random.default_rng(0).normal(size=(5, 3))
    np.testing.assert_allclose(
        other.project(points, SIZE)[0], camera.project(points, SIZE)[0], atol=1e-6
    )


@pytest.mark.parametrize(
    "damage",
    [{"distance": -1.0}, {"position": [1.0, 2.0]}, {"up": [0, 0, 0]}, {"pivot": "north"}],
)
def test_damaged_view_is_rejected_and_changes_nothing(damage: dict[str, object]) -> None:
    camera = looking(12.0, 3.0)
    before = camera.to_dict()
    with pytest.raises(ValueError, match="camera"):
        camera.restore({**before, **damage})
    assert camera.to_dict() == before


@pytest.mark.parametrize("orthographic", [False, True])
@pytest.mark.parametrize("away", [-4.7e6, 4.7e6])
def test_distant_model_does_not_degrade_depth_precision_at_the_pivot(
    orthographic: bool, away: float
) -> None:
    """Nearness to the pivot stays in the depth range, and 24 bits tell millimetres apart there."""
    camera = looking(0.0, 0.0, orthographic=orthographic)
    own = camera.pivot + 0.2 * camera.distance * np.array([[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]])
    eye = camera.eye(np.concatenate([own, own + away * camera.direction]))
    depth = eye.depth(own)
    assert (depth > eye.near).all()
    assert (depth < eye.far).all()
    if orthographic:
        step = (eye.far - eye.near) / 2**24
    else:
        step = depth.max() ** 2 * (1 / eye.near - 1 / eye.far) / 2**24
    assert step < 2e-4 * camera.distance


def test_view_slightly_west_of_north_has_trend_0_not_360() -> None:
    camera = Camera()
    camera.look_along(-1e-14, 0.0)
    trend, _ = camera.trend_plunge()
    assert 0.0 <= trend < 360.0
