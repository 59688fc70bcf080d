"""Untilting, turning and intersections against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from vomstudio.geology.orientation import (
    Line,
    Plane,
    angle_between_lines,
    intersection,
    lines_to_vectors,
    planes_to_poles,
)
from vomstudio.geology.rotations import pairwise_intersections, rotate_vectors, untilt


@pytest.mark.parametrize(("dip_direction", "dip"), [(132, 41), (0, 90), (270, 5), (45, 0)])
def test_untilting_a_plane_by_itself_makes_it_horizontal(dip_direction: float, dip: float) -> None:
    pole = untilt(planes_to_poles(dip_direction, dip), Plane(dip_direction, dip))
    assert abs(abs(pole[2]) - 1) < 1e-12


def test_a_line_in_the_plane_keeps_its_angle_from_the_strike() -> None:
    # A dip line of 090/30 becomes horizontal toward 090; the strike stays.
    plane = Plane(90, 30)
    dip_line = Line.from_vector(untilt(Line(90, 30).vector(), plane))
    assert angle_between_lines(dip_line, Line(90, 0)) < 1e-9
    strike = Line.from_vector(untilt(Line(0, 0).vector(), plane))
    assert angle_between_lines(strike, Line(0, 0)) < 1e-9


def test_untilting_unconformity_restores_limb() -> None:
    # Beds of 090/50 under an unconformity of 090/20 dipped by 30 to the east.
    older = Line.from_vector(untilt(planes_to_poles(90, 50), Plane(90, 20))).normal_plane()
    assert (older.dip_direction_deg, older.dip_deg) == (pytest.approx(90), pytest.approx(30))


def test_rotation_about_vertical_only_changes_trends() -> None:
    line = Line.from_vector(rotate_vectors(Line(40, 20).vector(), Line(0, 90), 30))
    assert (line.trend_deg, line.plunge_deg) == (pytest.approx(70), pytest.approx(20))


def test_inverse_rotation_restores_vectors() -> None:
    v = lines_to_vectors([10, 120, 300], [5, 40, 80])
    there = rotate_vectors(v, Line(77, 33), 64)
    np.testing.assert_allclose(rotate_vectors(there, Line(77, 33), -64), v, atol=1e-12)
    np.testing.assert_allclose(there @ there.T, v @ v.T, atol=1e-12)


def test_pairwise_intersections_match_single_intersections() -> None:
    found = pairwise_intersections(planes_to_poles([90, 200, 330], [30, 60, 45]))
    wanted = [(0, 1), (0, 2), (1, 2)]
    planes = [Plane(90, 30), Plane(200, 60), Plane(330, 45)]
    for line, (i, j) in zip(found, wanted, strict=True):
        assert (
            angle_between_lines(Line.from_vector(line), intersection(planes[i], planes[j])) < 1e-9
        )


def test_parallel_planes_have_no_intersection() -> None:
    assert len(pairwise_intersections(planes_to_poles([90, 90, 90.2], [30, 30, 30]))) == 0
