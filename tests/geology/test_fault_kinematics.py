"""Fault kinematics against published tables, another library and closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from vomstudio.geology.faults.kinematics import (
    compressed_share,
    fault_movements,
    kinematic_axes,
    p_axes,
    right_dihedra,
    t_axes,
)
from vomstudio.geology.orientation import (
    Line,
    Plane,
    angle_between_lines,
    compute_rake,
    slip_from_rake,
)
from vomstudio.geology.slip import slip_rake

AGIA_VARVARA = """
329 71 10.372108 65.35251
315 65 357.248859 57.79119
312 70 1.751099 60.60630
317 63 330.035014 62.39035
134 56 146.384168 55.37193
162 65 141.455533 63.52766
153 70 128.151847 68.14416
316 61 330.212091 60.23864
340 73 356.659170 72.30080
342 72 338.767039 71.97316
323 86 40.883188 71.57529
330 74 21.322413 65.35251
317 77 24.911582 58.45212
325 65 18.796010 51.71010
165 52 124.184821 44.08878
309 85 24.795705 70.37664
312 71 1.697588 61.97195
329 63 6.178380 57.40115
319 58 354.918900 52.34664
317 57 338.319236 55.11920
174 56 136.798420 49.74119
319 40 346.808006 36.58269
159 51 121.223788 44.30632
167 32 140.410590 29.19564
322 54 11.988412 41.50672
149 67 110.958314 61.67654
317 65 9.677250 52.43617
151 86 70.332342 66.67339
317 74 29.406985 46.50824
301 69 11.283948 41.31063
149 65 160.695922 64.53645
146 56 126.832105 54.46945
340 80 334.259926 79.95063
"""
"""Normal faults of Agia Varvara, Crete (Angelier 1990, Geophysical Journal International 103,
363-376, site AVB): dip direction, dip, trend and plunge of the striae, as the documentation of the
R package structr prints them."""


def agia_varvara() -> tuple[np.ndarray, np.ndarray]:
    rows = np.array([line.split() for line in AGIA_VARVARA.strip().splitlines()], float)
    rakes = []
    for azimuth, dip, trend, plunge in rows:
        plane = Plane(azimuth, dip)
        rake = slip_rake(plane, compute_rake(Line(trend, plunge), plane), "normal")
        assert rake is not None
        rakes.append(rake)
    return fault_movements(rows[:, 0], rows[:, 1], rakes)


def axis(vector: np.ndarray) -> Line:
    return Line.from_vector(vector)


def test_movements_match_single_slips() -> None:
    planes = [Plane(30, 40), Plane(200, 90), Plane(20, 90), Plane(350, 5)]
    rakes = [-90.0, 30.0, 30.0, 170.0]
    normals, slips = fault_movements(
        [p.dip_direction_deg for p in planes], [p.dip_deg for p in planes], rakes
    )
    for plane, rake, normal, slip in zip(planes, rakes, normals, slips, strict=True):
        assert slip == pytest.approx(slip_from_rake(plane, rake).vector(), abs=1e-12)
        assert abs(normal @ plane.normal()) == pytest.approx(1.0)
        assert normal @ slip == pytest.approx(0.0, abs=1e-12)


def test_a_vertical_fault_has_the_same_axes_whichever_way_it_is_written() -> None:
    """Rakes of vertical planes count from the strike in [0, 180): so does the hanging wall."""
    one = fault_movements([110], [90], [0])
    other = fault_movements([290], [90], [0])
    assert p_axes(*one)[0] == pytest.approx(p_axes(*other)[0])
    # A north-south wall that moves sinistrally is shortened from north-east to south-west.
    wall = fault_movements([90], [90], [0])
    assert axis(p_axes(*wall)[0]).trend_deg % 180 == pytest.approx(135.0)


def test_a_sinistral_fault_shortens_at_45_degrees_to_its_strike() -> None:
    """East of a north-south fault moves north: shortening from north-west to south-east."""
    normals, slips = fault_movements([90], [89.999], [0])
    assert slips[0] == pytest.approx([0, 1, 0], abs=1e-4)
    assert angle_between_lines(axis(p_axes(normals, slips)[0]), Line(135, 0)) < 0.01
    assert angle_between_lines(axis(t_axes(normals, slips)[0]), Line(45, 0)) < 0.01


@pytest.mark.parametrize(
    ("fault", "sense", "p", "t"),
    [
        ((120, 60, 110, 58), "normal", (314.97, 75.20), (116.21, 14.05)),
        ((100, 50, 30, 23), "normal", (342.45, 46.65), (241.33, 10.32)),
    ],
)
def test_p_and_t_axes_match_structr(fault, sense, p, t) -> None:
    """Of its article on faults. Its striae are up to 2 degrees off the planes; it turns the plane
    half way, we turn the line."""
    plane = Plane(*fault[:2])
    rake = slip_rake(plane, compute_rake(Line(*fault[2:]), plane), sense)
    normals, slips = fault_movements([fault[0]], [fault[1]], [rake])
    assert angle_between_lines(axis(p_axes(normals, slips)[0]), Line(*p)) < 1.5
    assert angle_between_lines(axis(t_axes(normals, slips)[0]), Line(*t)) < 1.5


def test_p_and_t_axes_of_angelier_faults_match_apsg() -> None:
    """Of the first four, by apsg 1.4.0."""
    normals, slips = agia_varvara()
    p = [
        (125.45496, 60.796737),
        (99.997749, 63.782984),
        (100.964538, 59.084299),
        (123.62171, 71.370686),
    ]
    t = [
        (341.354121, 24.360176),
        (330.402151, 17.424857),
        (328.597313, 21.977013),
        (321.452094, 17.792197),
    ]
    for i in range(4):
        assert angle_between_lines(axis(p_axes(normals, slips)[i]), Line(*p[i])) < 1e-4
        assert angle_between_lines(axis(t_axes(normals, slips)[i]), Line(*t[i])) < 1e-4


def test_angelier_faults_are_compatible_with_one_stress() -> None:
    """A dip-slip set of normal faults that strike north-east: compression upright, extension to the
    north-west, as published; the dihedra of all 33 overlap."""
    dihedra = right_dihedra(*agia_varvara())
    compression, share = dihedra.compression_maximum()
    assert share == 1.0
    assert axis(compression).plunge_deg > 65
    extension, share = dihedra.extension_maximum()
    assert share == 1.0
    assert angle_between_lines(axis(extension), Line(323, 0)) < 20
    found = kinematic_axes(*agia_varvara())
    assert angle_between_lines(axis(found.axes[2]), axis(compression)) < 15
    assert angle_between_lines(axis(found.axes[0]), axis(extension)) < 20


def test_faults_of_one_mechanism_have_its_axes_without_error() -> None:
    found = kinematic_axes(*fault_movements([90] * 6, [45] * 6, [-90] * 6))
    assert found.values == pytest.approx([1.0, 0.0, -1.0], abs=1e-12)
    assert axis(found.axes[2]).plunge_deg == pytest.approx(90.0)
    assert found.confidence95_deg == pytest.approx([0, 0, 0], abs=1e-5)


def test_conjugate_faults_share_their_axes() -> None:
    found = kinematic_axes(*fault_movements([90, 270, 90, 270, 90], [60] * 5, [-90] * 5))
    assert angle_between_lines(axis(found.axes[2]), Line(0, 90)) < 10
    assert angle_between_lines(axis(found.axes[1]), Line(0, 0)) < 1e-6
    assert found.values.sum() == pytest.approx(0.0, abs=1e-12)


def test_rotating_faults_rotates_the_axes() -> None:
    generator = np.random.default_rng(2)
    azimuth, dip = generator.uniform(0, 330, 12), generator.uniform(20, 80, 12)
    rake = generator.uniform(-180, 180, 12)
    one = kinematic_axes(*fault_movements(azimuth, dip, rake))
    other = kinematic_axes(*fault_movements(azimuth + 30, dip, rake))
    assert one.values == pytest.approx(other.values)
    for a, b in zip(one.axes, other.axes, strict=True):
        turned = axis(a)
        turned = Line(turned.trend_deg + 30, turned.plunge_deg)
        assert angle_between_lines(turned, axis(b)) < 1e-6
    assert one.confidence95_deg == pytest.approx(other.confidence95_deg)


def test_single_fault_has_no_confidence_cone() -> None:
    assert kinematic_axes(*fault_movements([90], [45], [-90])).confidence95_deg is None


def test_dihedra_of_one_fault_cover_half_of_the_net() -> None:
    dihedra = right_dihedra(*fault_movements([130], [50], [-60]))
    assert dihedra.share.mean() == pytest.approx(0.5, abs=0.01)
    normals, slips = fault_movements([130], [50], [-60])
    p = p_axes(normals, slips)[0]
    nearest = np.argmax(np.abs(dihedra.directions @ p))
    assert dihedra.share[nearest] == 1.0


def test_common_strike_of_faults_is_not_an_extension_maximum() -> None:
    """Normal and reverse faults that strike north: along the strike none shortens or extends."""
    normals, slips = fault_movements([90, 90, 270, 270], [60, 60, 60, 60], [-90, 90, -90, 90])
    along = compressed_share(np.array([[0.0, 1.0, 0.0]]), normals, slips)
    assert along[0] == pytest.approx(0.5)
    _, share = right_dihedra(normals, slips).extension_maximum()
    assert share == pytest.approx(0.5)
    normals, slips = fault_movements([90, 270], [60, 60], [-90, -90])
    axis, share = right_dihedra(normals, slips).extension_maximum()
    assert share == 1.0
    assert abs(axis[0]) == pytest.approx(1.0, abs=1e-3)
    pressed, share = right_dihedra(normals, slips).compression_maximum()
    assert share == 1.0
    assert abs(pressed[2]) == pytest.approx(1.0, abs=1e-3)
