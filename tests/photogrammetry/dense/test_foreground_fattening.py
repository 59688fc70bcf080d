import numpy as np

from vomstudio.photogrammetry.dense.foreground_fattening import find_sky_fringe


def skyline(sky=210.0, rock=90.0, noise=1.5):
    """A photo with textured rock below row 60, and a depth map that laps over it by ten rows."""
    rng = np.random.default_rng(0)
    photo = np.full((160, 200), sky)
    photo[60:] = rock + 25 * rng.standard_normal((100, 200))
    photo += noise * rng.standard_normal(photo.shape)
    has = np.zeros(photo.shape, bool)
    has[50:] = True
    return np.clip(photo, 0, 255).astype(np.uint8), np.ones(photo.shape, bool), has


def test_fringe_over_the_skyline_is_detected_and_rock_is_kept():
    fringe = find_sky_fringe(*skyline())
    assert fringe[50:58].mean() > 0.98
    assert fringe[62:].mean() < 0.002
    assert not fringe[:50].any()


def test_sky_is_detected_in_a_noisy_photo():
    fringe = find_sky_fringe(*skyline(noise=2.4))
    assert fringe[50:57].mean() > 0.9
    assert fringe[62:].mean() < 0.005


def test_bare_ground_within_the_rock_keeps_its_depths():
    photo, valid, has = skyline()
    photo[100:140, 50:150] = 215
    assert not find_sky_fringe(photo, valid, has)[95:145].any()


def test_rock_in_deep_shade_keeps_its_depths():
    photo, valid, has = skyline(sky=20.0, rock=120.0)
    assert not find_sky_fringe(photo, valid, has).any()


def test_bare_ground_beside_a_masked_area_keeps_its_depths():
    photo, valid, has = skyline()
    photo[60:80] = 210
    valid[:50] = False
    assert not find_sky_fringe(photo, valid, has).any()


def test_small_holes_in_plaster_are_not_sky():
    photo, valid, has = skyline()
    photo[60:] = 200
    has[:] = True
    has[100:115, 60:90] = False
    assert not find_sky_fringe(photo, valid, has).any()
