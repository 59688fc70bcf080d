"""Normals, their angles, and the lines of strike and dip."""

from __future__ import annotations

import numpy as np
import pytest

from vomstudio.geology.orientation import Plane
from vomstudio.geometry.moment_planes import fit_moments
from vomstudio.geometry.patches import moments
from vomstudio.geometry.planes import fit_planes
from vomstudio.geometry.vectors import dips_from_normals, flip_upward, strike_and_dip_lines


@pytest.mark.parametrize("hair", [1e-20, 1e-17, 1e-16, 2e-15, 1e-12])
def test_dip_direction_just_west_of_north_is_never_360(hair: float) -> None:
    normals = np.array([[-hair, 1.0, 1.0], [-hair, 0.5, 0.01], [-hair, 1.0, 0.0]])
    azimuth, _, flat = dips_from_normals(normals)
    assert not flat.any()
    assert ((azimuth >= 0.0) & (azimuth < 360.0)).all()
    assert np.minimum(azimuth, 360.0 - azimuth) == pytest.approx(np.zeros(3), abs=1e-8)


def test_planes_that_dip_to_the_north_are_fitted_with_dip_directions_below_360() -> None:
    """The sides of the squares are along east, but for roundings of either sign."""
    rng = np.random.default_rng(1)
    sides = np.array([[-1.0, 0, 0], [1.0, 0, 0], [0, 1.0, -1.0], [0, -1.0, 1.0]])
    groups = sides + rng.normal(0.0, 1e-16, (400, 4, 3))
    fits = fit_planes(groups.reshape(-1, 3), np.arange(401) * 4)
    patches = [fit_moments(m.n, m.mean, m.scatter) for m in map(moments, groups)]
    for azimuth in (fits.dip_direction_deg, np.array([p.dip_direction_deg for p in patches])):
        assert ((azimuth >= 0.0) & (azimuth < 360.0)).all()
        assert np.minimum(azimuth, 360.0 - azimuth) == pytest.approx(np.zeros(400), abs=1e-6)


def test_normals_give_the_same_attitudes_as_geology_module() -> None:
    normals = np.random.default_rng(2).normal(size=(200, 3))
    up = flip_upward(normals)
    assert (up[:, 2] > 0).all()
    azimuth, dip, flat = dips_from_normals(up)
    assert not flat.any()
    strike, down = strike_and_dip_lines(azimuth, dip)
    for i, normal in enumerate(normals):
        plane = Plane.from_normal(normal)
        assert azimuth[i] == pytest.approx(plane.dip_direction_deg)
        assert dip[i] == pytest.approx(plane.dip_deg)
        assert strike[i] == pytest.approx(plane.strike_vector())
        assert down[i] == pytest.approx(plane.dip_vector())


@pytest.mark.parametrize("azimuth", [90.0, 91.0, 179.0, 180.0, 269.0])
@pytest.mark.parametrize("rest", [0.0, 9e-13, -9e-13])
def test_horizontal_normals_flip_to_the_canonical_direction(azimuth: float, rest: float) -> None:
    a = np.radians(azimuth)
    normal = np.array([np.sin(a), np.cos(a), 0.0])
    if azimuth in (90.0, 180.0):
        normal = normal.round()
    for sign in (1.0, -1.0):
        found = flip_upward(np.array([sign * normal + [0, 0, rest]]))[0]
        assert found == pytest.approx(normal)
        assert found[2] == 0.0
        assert not np.signbit(found)[found == 0.0].any()


def test_normal_tilted_less_than_its_rounding_has_no_azimuth() -> None:
    normals = np.array([[3e-4, 0.0, 1.0], [0.0, 3e-4, 1.0]])
    azimuth, dip, flat = dips_from_normals(normals, np.array([2.9e-4, 3.1e-4]))
    assert flat.tolist() == [False, True]
    assert azimuth.tolist() == [90.0, 0.0]
    assert dip == pytest.approx([np.degrees(np.arctan(3e-4)), 0.0])
