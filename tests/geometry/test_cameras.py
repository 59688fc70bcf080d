"""Projection and its inverse, against COLMAP's own cameras."""

import numpy as np
import pytest

from vomstudio.core.errors import GeometryError
from vomstudio.geometry.cameras import CAMERA_MODELS, Intrinsics, View

LENSES = {
    "SIMPLE_PINHOLE": (1000.0, 810.0, 590.0),
    "PINHOLE": (1000.0, 1010.0, 810.0, 590.0),
    "SIMPLE_RADIAL": (1000.0, 810.0, 590.0, -0.08),
    "RADIAL": (1000.0, 810.0, 590.0, -0.08, 0.03),
    "OPENCV": (1000.0, 1010.0, 810.0, 590.0, -0.08, 0.03, 0.001, -0.002),
    "FULL_OPENCV": (
        *(1000.0, 1010.0, 810.0, 590.0, -0.08, 0.03, 0.001, -0.002, 0.01, 0.02, 0.01, 0.001),
    ),
    "OPENCV_FISHEYE": (1000.0, 1010.0, 810.0, 590.0, 0.02, -0.01, 0.003, 0.001),
}


@pytest.fixture
def points():
    rng = np.random.default_rng(4)
    return np.column_stack([rng.uniform(-0.8, 0.8, (500, 2)), np.ones(500)]) * rng.uniform(
        2, 30, (500, 1)
    )


@pytest.mark.parametrize("model", CAMERA_MODELS)
def test_projected_pixels_match_colmap(model, points):
    import pycolmap

    theirs = pycolmap.Camera(model=model, width=1600, height=1200, params=list(LENSES[model]))
    ours = Intrinsics(model, 1600, 1200, LENSES[model]).project(points)
    np.testing.assert_allclose(ours, theirs.img_from_cam(points), atol=1e-9)


@pytest.mark.parametrize("model", CAMERA_MODELS)
def test_pixel_ray_round_trips_to_its_point(model, points):
    lens = Intrinsics(model, 1600, 1200, LENSES[model])
    rays = lens.rays(lens.project(points))
    np.testing.assert_allclose(rays, points / points[:, 2:], atol=1e-9)


def test_points_behind_or_beyond_the_lens_are_not_projected():
    lens = Intrinsics("SIMPLE_RADIAL", 1600, 1200, (1000.0, 800.0, 600.0, -0.2))
    # r (1 - 0.2 r^2) turns back at r = sqrt(1 / 0.6) = 1.29.
    pixels = lens.project([[0, 0, -1], [1.25, 0, 1], [1.35, 0, 1], [0, 0, 1]])
    assert np.isnan(pixels[[0, 2]]).all()
    assert np.isfinite(pixels[[1, 3]]).all()
    np.testing.assert_allclose(pixels[3], [800, 600])


def test_resampled_photo_projects_to_scaled_pixels(points):
    lens = Intrinsics("OPENCV", 1600, 1200, LENSES["OPENCV"])
    small = lens.scaled(400, 300)
    np.testing.assert_allclose(small.project(points), lens.project(points) / 4)


def test_moving_scene_and_camera_together_keeps_the_pixels(points):
    rng = np.random.default_rng(1)
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.linalg.det(turn)
    other, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    other *= np.linalg.det(other)
    view = View(
        "a", Intrinsics("RADIAL", 1600, 1200, LENSES["RADIAL"]), turn, np.array([1, 2, 3.0])
    )
    world = (points - view.translation) @ turn
    moved = view.moved(2.5, other, np.array([7.0, -8, 9]))
    there = 2.5 * world @ other.T + [7, -8, 9]
    np.testing.assert_allclose(moved.project(there), view.project(world), atol=1e-8)
    np.testing.assert_allclose(moved.centre, 2.5 * other @ view.centre + [7, -8, 9], atol=1e-9)
    np.testing.assert_allclose(
        np.cross(moved.rays(moved.project(there)), there - moved.centre), 0, atol=1e-6
    )


def test_unknown_camera_model_is_rejected_by_name():
    with pytest.raises(GeometryError, match="FOV"):
        Intrinsics("FOV", 10, 10, (1.0, 5.0, 5.0, 0.1, 0.2))
    with pytest.raises(GeometryError, match="4 parameters"):
        Intrinsics("PINHOLE", 10, 10, (1.0, 5.0))


def test_a_photo_contains_its_pixels_up_to_its_outer_edges():
    view = View("a", Intrinsics("PINHOLE", 16, 12, LENSES["PINHOLE"]), np.eye(3), np.zeros(3))
    inside = [[0, 0], [16, 12], [16, 0], [0, 12], [8, 6]]
    outside = [[-0.01, 6], [16.01, 6], [8, -0.01], [8, 12.01], [np.nan, 6], [8, np.nan]]
    assert view.contains(inside).all()
    assert not view.contains(outside).any()


def test_depths_grow_along_the_view_from_its_centre(points):
    turn, _ = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))
    turn *= np.linalg.det(turn)
    view = View("a", Intrinsics("PINHOLE", 16, 12, LENSES["PINHOLE"]), turn, np.array([1, 2, 3.0]))
    np.testing.assert_allclose(turn @ view.centre + view.translation, 0, atol=1e-12)
    along = (points - view.centre) @ view.direction
    np.testing.assert_allclose(view.depths(points), along, atol=1e-9)
    np.testing.assert_allclose(view.depths(view.centre), 0, atol=1e-9)


@pytest.mark.parametrize("model", CAMERA_MODELS)
def test_lens_without_distortion_is_linear(model, points):
    names, params = CAMERA_MODELS[model], LENSES[model]
    bent = [i for i, name in enumerate(names) if name[0] in "kp"]
    assert Intrinsics(model, 1600, 1200, params).has_distortion == bool(bent)
    straight = list(params)
    for i in bent:
        straight[i] = 0.0
    lens = Intrinsics(model, 1600, 1200, tuple(straight))
    if model == "OPENCV_FISHEYE":
        # The radius is the angle, not its tangent.
        assert lens.has_distortion
        pixel = lens.project([[1.0, 0.0, 1.0]])[0]
        np.testing.assert_allclose(pixel, [810 + 1000 * np.pi / 4, 590])
        return
    assert not lens.has_distortion
    pixels = points @ lens.matrix.T
    np.testing.assert_allclose(lens.project(points), pixels[:, :2] / pixels[:, 2:], atol=1e-9)
    for i in bent:
        one = list(straight)
        one[i] = 1e-3
        assert Intrinsics(model, 1600, 1200, tuple(one)).has_distortion, names[i]


def test_resampled_single_focal_camera_keeps_one_focal_length():
    lens = Intrinsics("SIMPLE_RADIAL", 1600, 1200, LENSES["SIMPLE_RADIAL"])
    small = lens.scaled(400, 306)
    assert (small.width, small.height) == (400, 306)
    assert small.focal == pytest.approx((1000 * (0.25 + 0.255) / 2,) * 2)
    assert small.centre == pytest.approx((810 / 4, 590 * 0.255))
    uneven = Intrinsics("PINHOLE", 1600, 1200, LENSES["PINHOLE"]).scaled(800, 300)
    assert uneven.focal == pytest.approx((500.0, 252.5))


def test_principal_point_ray_is_straight_ahead():
    for model in CAMERA_MODELS:
        lens = Intrinsics(model, 1600, 1200, LENSES[model])
        np.testing.assert_allclose(lens.rays([lens.centre]), [[0, 0, 1]], atol=1e-12)


def test_pixels_beyond_lens_limit_have_no_rays():
    lens = Intrinsics("SIMPLE_RADIAL", 1600, 1200, (1000.0, 800.0, 600.0, -0.2))
    # The real radius grows up to 1.29 (1 - 0.2 1.29^2) = 0.86 and no further.
    rays = lens.rays([[800 + 855, 600], [800 + 870, 600], [800, 600 + 2000]])
    assert np.isfinite(rays[0]).all()
    assert np.isnan(rays[1:, :2]).all()


@pytest.mark.parametrize("k1", [-0.02, -0.2, -0.5, -1.5])
@pytest.mark.parametrize("model", ["SIMPLE_RADIAL", "RADIAL", "OPENCV"])
def test_lens_projects_up_to_the_maximum_of_its_polynomial(model, k1):
    """r (1 + k1 r^2) turns back where 1 + 3 k1 r^2 = 0, and rays end at the same place."""
    named = dict.fromkeys(CAMERA_MODELS[model], 0.0) | {
        "f": 1000.0,
        "fx": 1000.0,
        "fy": 1000.0,
        "k1": k1,
    }
    lens = Intrinsics(model, 1600, 1200, tuple(named[name] for name in CAMERA_MODELS[model]))
    edge = np.sqrt(-1.0 / (3.0 * k1))
    for angle in (0.0, 1.0, 2.5, 4.0):
        way = np.array([np.cos(angle), np.sin(angle)])
        inside, beyond = (np.append(r * edge * way, 1.0) for r in (0.995, 1.005))
        pixel = lens.project(inside)[0]
        assert np.isfinite(pixel).all() == (0.995 * edge < 1e9)
        assert np.isnan(lens.project(beyond)).all()
        real = edge * (1.0 + k1 * edge**2)
        np.testing.assert_allclose(lens.rays(0.98 * 1000 * real * way)[0][2], 1.0)
        if edge < 5.0:
            back = lens.rays(pixel)[0]
            np.testing.assert_allclose(back, inside, atol=1e-6)
            assert np.isnan(lens.rays(1.01 * 1000 * real * way)[0, :2]).all()


@pytest.mark.parametrize("degrees", [0.0, 1e-9, 20.0, 60.0, 79.0])
def test_fisheye_without_coefficients_maps_angle_to_radius(degrees):
    lens = Intrinsics("OPENCV_FISHEYE", 1600, 1200, (900.0, 1100.0, 10.0, 20.0, 0, 0, 0, 0))
    a = np.radians(degrees)
    for turn in (0.3, 2.0, 5.5):
        ray = np.array([np.cos(turn) * np.tan(a), np.sin(turn) * np.tan(a), 1.0])
        pixel = [10.0 + 900.0 * a * np.cos(turn), 20.0 + 1100.0 * a * np.sin(turn)]
        np.testing.assert_allclose(lens.project(ray)[0], pixel, atol=1e-9)
        np.testing.assert_allclose(lens.rays(pixel)[0], ray, atol=1e-6)


def test_lens_with_monotonic_polynomial_projects_everything_in_front():
    wide = np.array([[40.0, 3.0, 1.0], [-900.0, 0.0, 1.0], [0.0, 5.6, 1.0]])
    for params in ((1000.0, 0.0, 0.0, 0.0), (1000.0, 0.0, 0.0, 0.2)):
        lens = Intrinsics("SIMPLE_RADIAL", 1600, 1200, params)
        assert np.isfinite(lens.project(wide)).all()
    lens = Intrinsics("SIMPLE_RADIAL", 1600, 1200, (1000.0, 0.0, 0.0, 0.2))
    np.testing.assert_allclose(lens.rays(lens.project(wide[2]))[0], wide[2], atol=1e-6)


@pytest.mark.parametrize("model", CAMERA_MODELS)
def test_pixels_outside_photo_have_rays_and_invalid_pixels_affect_no_other(model):
    lens = Intrinsics(model, 1600, 1200, LENSES[model])
    pixels = np.array([[-100.0, 300.0], [800.0, 600.0], [np.nan, 5.0], [1700.0, 1250.0]])
    rays = lens.rays(pixels)
    known = [0, 1, 3]
    np.testing.assert_allclose(lens.project(rays)[known], pixels[known], atol=1e-6)
    assert np.isnan(rays[2, :2]).any()
    np.testing.assert_allclose(lens.rays(pixels[1])[0], rays[1], atol=1e-12)
