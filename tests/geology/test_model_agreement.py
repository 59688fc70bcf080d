"""Orientations of two models: which belong together, and whether they agree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from vomstudio.geology.model_agreement import OrientedPlane, compare_orientations
from vomstudio.geology.orientation import planes_to_poles


def plane(
    name: str,
    dip_direction: float,
    dip: float,
    place: tuple[float, float, float] | None = (0.0, 0.0, 0.0),
    *,
    kind: str = "bedding",
    extent: float | None = 2.0,
    error: float | None = 3.0,
) -> OrientedPlane:
    pole = planes_to_poles(np.array([dip_direction]), np.array([dip]))[0]
    there = None if place is None else np.array(place)
    return OrientedPlane(name, kind, pole, there, extent, error)


def test_name_unique_on_both_sides_matches() -> None:
    found = compare_orientations(
        [plane("B1", 90, 30), plane("twice", 10, 10, None), plane("twice", 20, 10, None)],
        [plane(" b1", 90, 50, (500.0, 0.0, 0.0)), plane("twice", 10, 10, None)],
    )
    (one,) = found.matched
    assert (one.first, one.by, one.distance_m) == ("B1", "name", 500.0)
    assert one.angle_deg == pytest.approx(20.0)
    # Both errors of 3 degrees.
    assert one.error95_deg == pytest.approx(np.sqrt(18.0))
    assert one.agree is False
    assert found.unmatched == (2, 1)
    assert found.agree_share == 0.0


def test_nearest_plane_of_same_kind_within_half_the_extent_matches() -> None:
    first = [plane("a", 90, 30), plane("b", 0, 90, (0.1, 0, 0), kind="joint")]
    near = [plane("c", 90, 32, (0.9, 0, 0)), plane("d", 90, 31, (0.8, 0, 0), extent=None)]
    found = compare_orientations(first, near)
    # Nearest to each other are a and d; a joint is no bed.
    assert [(one.first, one.second, one.by) for one in found.matched] == [("a", "d", "nearness")]
    assert found.matched[0].agree is True
    assert not compare_orientations(first, [plane("c", 90, 32, (1.1, 0, 0))]).n
    assert not compare_orientations(first, [plane("c", 90, 32, None)]).n


def test_angle_ignores_normal_sign_and_north() -> None:
    a, b = plane("x", 359, 80), plane("x", 181, 80)
    # Spherical law of cosines; their dips add up across the vertical.
    dip, apart = np.radians([80.0, 178.0])
    expected = np.degrees(np.arccos(-(np.cos(dip) ** 2 + np.sin(dip) ** 2 * np.cos(apart))))
    assert compare_orientations([a], [b]).matched[0].angle_deg == pytest.approx(expected, abs=1e-6)
    turned = Rotation.random(random_state=3).as_matrix()
    again = compare_orientations(
        [replace(a, normal=turned @ a.normal)], [replace(b, normal=-turned @ b.normal)]
    )
    assert again.matched[0].angle_deg == pytest.approx(expected, abs=1e-9)


def test_agreement_is_undefined_without_errors() -> None:
    found = compare_orientations([plane("x", 10, 10, error=None)], [plane("x", 10, 10)])
    assert found.matched[0].agree is None
    assert found.agree_share is None
    nothing = compare_orientations([], [plane("x", 10, 10)])
    assert (nothing.n, nothing.median_angle_deg, nothing.unmatched) == (0, None, (0, 1))


def test_planes_with_true_errors_agree_in_95_percent_or_more() -> None:
    """Normals that scatter by 1 degree (one sigma, each axis) lie within 2.4477 of the true one in
    95 % (chi, two degrees of freedom); so does the difference of two within the root of the sum."""
    rng = np.random.default_rng(5)
    sides = []
    for _ in range(2):
        tilts = np.radians(rng.normal(0.0, 1.0, (4000, 2)))
        normals = np.column_stack([tilts, np.ones(4000)])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        sides.append(
            [OrientedPlane(str(i), "", n, None, None, 2.4477) for i, n in enumerate(normals)]
        )
    share = compare_orientations(*sides).agree_share
    assert share == pytest.approx(0.95, abs=0.011)
