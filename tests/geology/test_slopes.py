"""Kinematic analysis against mplstereonet, rotations, and intersections worked out one by one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.geology.orientation import (
    Line,
    Plane,
    intersection,
    normals_to_planes,
    planes_to_normals,
)
from vomstudio.geology.slope_options import SlopeOptions
from vomstudio.geology.slopes import (
    SlopeFace,
    count_pair_members,
    count_pairs,
    count_pairs_between_sets,
    direct_toppling,
    flexural_toppling,
    planar_sliding,
    to_face_frame,
    wedge_sliding,
)
from vomstudio.geology.table_slopes import slope_face


@pytest.fixture(scope="session")
def kinematic_analysis(mplstereonet: Any) -> Any:
    from mplstereonet import kinematic_analysis

    return kinematic_analysis


def many_planes(seed: int, n: int = 60) -> tuple[np.ndarray, np.ndarray]:
    """Attitudes to a degree in every second set, so that limits are met exactly."""
    generator = np.random.default_rng(seed)
    azimuth, dip, _ = normals_to_planes(generator.normal(size=(n, 3)))
    if seed % 2:
        azimuth, dip = np.round(azimuth) % 360, np.clip(np.round(dip), 1, 89)
    return azimuth, dip


def some_face(seed: int, limits: str) -> SlopeFace:
    generator = np.random.default_rng(1000 + seed)
    dip = float(generator.integers(35, 90))
    friction = float(generator.integers(10, int(dip)))
    azimuth, lateral = float(generator.integers(0, 360)), float(generator.integers(5, 80))
    return SlopeFace(Plane(azimuth, dip), SlopeOptions(friction, lateral, limits))


@pytest.mark.parametrize("limits", ["curved", "straight"])
@pytest.mark.parametrize("seed", range(12))
def test_critical_planes_match_mplstereonet(
    kinematic_analysis: Any, seed: int, limits: str
) -> None:
    azimuth, dip = many_planes(seed)
    face = some_face(seed, limits)
    normals = to_face_frame(face, planes_to_normals(azimuth, dip))
    strike = face.plane.strike_rhr_deg
    arguments = (strike, face.plane.dip_deg, face.options.friction_deg, face.options.lateral_deg)
    for theirs, ours in (
        (kinematic_analysis.PlanarSliding(*arguments), planar_sliding(face, normals)),
        (kinematic_analysis.FlexuralToppling(*arguments), flexural_toppling(face, normals)),
    ):
        critical, secondary = theirs.check_failure(azimuth - 90, dip.copy(), limits == "curved")
        assert (ours.critical == critical).all()
        assert (ours.secondary == secondary).all()


@pytest.mark.parametrize("seed", range(0, 12, 2))
def test_critical_wedges_match_mplstereonet(
    mplstereonet: Any, kinematic_analysis: Any, seed: int
) -> None:
    azimuth, dip = many_planes(seed)
    face = some_face(seed, "curved")
    first, second = np.triu_indices(len(dip), 1)
    plunge, bearing = mplstereonet.plane_intersection(
        azimuth[first] - 90, dip[first], azimuth[second] - 90, dip[second]
    )
    theirs = kinematic_analysis.WedgeSliding(
        face.plane.strike_rhr_deg, face.plane.dip_deg, face.options.friction_deg
    )
    critical, secondary = theirs.check_failure(bearing, plunge)
    found = count_pairs(face, to_face_frame(face, planes_to_normals(azimuth, dip))[None])
    assert found.of[0] == len(first)
    assert found.wedge[0] == critical.sum()
    assert found.wedge_secondary[0] == secondary.sum()


def lines(face: SlopeFace, *given: tuple[float, float]) -> np.ndarray:
    return to_face_frame(face, np.array([Line(*line).vector() for line in given]))


def test_blocks_topple_about_steep_intersections_into_the_face() -> None:
    """Hudson & Harrison 1997, fig. 18.6: from 90 less the dip of the face to 90, into the face."""
    face = SlopeFace(Plane(90, 70), SlopeOptions(30, 20))
    given = lines(face, (270, 20), (270, 19), (290, 25), (291, 25), (90, 85), (0, 90), (310, 61))
    found = direct_toppling(face, given)
    assert found.critical.tolist() == [True, False, True, False, False, True, False]
    assert found.secondary.tolist() == [False] * 6 + [True]


def test_direct_toppling_is_counted_over_all_pairs() -> None:
    azimuth, dip = many_planes(3, 25)
    face = some_face(3, "curved")
    found = count_pairs(face, to_face_frame(face, planes_to_normals(azimuth, dip))[None])
    planes = [Plane(a, d) for a, d in zip(azimuth, dip, strict=True)]
    counted = 0
    for i, a in enumerate(planes):
        for b in planes[i + 1 :]:
            line = intersection(a, b)
            turned = (line.trend_deg - face.plane.dip_direction_deg) % 360 - 180
            steep = line.plunge_deg >= 90 - face.plane.dip_deg
            counted += steep and abs(turned) <= face.options.lateral_deg
    assert found.toppling[0] == counted > 0


def test_rotating_planes_and_face_together_changes_nothing() -> None:
    azimuth, dip = many_planes(4)
    face = some_face(4, "straight")
    turned = SlopeFace(Plane(face.plane.dip_direction_deg + 30, face.plane.dip_deg), face.options)
    one = to_face_frame(face, planes_to_normals(azimuth, dip))
    other = to_face_frame(turned, planes_to_normals(azimuth + 30, dip))
    assert one == pytest.approx(other, abs=1e-12)
    assert count_pairs(face, one[None]) == count_pairs(turned, other[None])


def test_toppling_of_vertical_plane_ignores_dip_direction_sign() -> None:
    face = SlopeFace(Plane(90, 70), SlopeOptions(30))
    normals = to_face_frame(face, planes_to_normals([90, 270], [90, 90]))
    assert flexural_toppling(face, normals).critical.all()


def test_orientations_exactly_at_the_limits_are_critical() -> None:
    face = SlopeFace(Plane(90, 70), SlopeOptions(30))
    normals = to_face_frame(face, planes_to_normals([90, 90, 90, 90], [30, 70, 29.999, 70.001]))
    assert planar_sliding(face, normals).critical.tolist() == [True, True, False, False]
    wedges = wedge_sliding(face, lines(face, (90, 30), (90, 70), (90, 29.999), (90, 70.001)))
    assert wedges.critical.tolist() == [True, True, False, False]


def test_a_horizontal_plane_does_not_slide_even_without_friction() -> None:
    face = SlopeFace(Plane(0, 70), SlopeOptions(0, 90))
    assert not planar_sliding(face, to_face_frame(face, planes_to_normals([0], [0]))).critical.any()


def test_parallel_planes_have_no_intersection() -> None:
    face = SlopeFace(Plane(90, 70), SlopeOptions(30))
    normals = to_face_frame(face, planes_to_normals([90, 90, 180], [45, 45, 45]))
    found = count_pairs(face, normals[None])
    assert (found.of[0], found.parallel[0]) == (2, 1)


def test_intersections_of_many_planes_take_little_memory() -> None:
    import tracemalloc

    azimuth, dip = many_planes(2, 1500)
    face = some_face(2, "curved")
    normals = to_face_frame(face, planes_to_normals(azimuth, dip))[None]
    tracemalloc.start()
    found = count_pairs(face, normals)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert found.of[0] == 1500 * 1499 // 2
    assert peak < 60e6


def test_wedge_daylights_if_flatter_than_apparent_dip_of_face() -> None:
    """The apparent dip of the face along the trend of the wedge is the limit (Hoek & Bray 1981)."""
    face = SlopeFace(Plane(120, 65), SlopeOptions(20))
    for turn in (0, 30, 60):
        apparent = np.degrees(np.arctan(np.tan(np.radians(65)) * np.cos(np.radians(turn))))
        given = lines(face, (120 + turn, apparent - 0.01), (120 + turn, apparent + 0.01))
        assert wedge_sliding(face, given).critical.tolist() == [True, False]


@pytest.mark.parametrize(
    ("face", "friction", "lateral", "field"),
    [
        ("0/0", 30, 20, "--face"),
        ("90/95", 30, 20, "--face"),
        ("steep", 30, 20, "--face"),
        ("90/70", 90, 20, "--friction"),
        ("90/70", -1, 20, "--friction"),
        ("90/70", float("nan"), 20, "--friction"),
        ("90/70", 30, 0, "--lateral"),
        ("90/70", 30, 91, "--lateral"),
    ],
)
def test_invalid_angles_are_rejected(face, friction, lateral, field) -> None:
    with pytest.raises(UsageError) as refused:
        slope_face(face, SlopeOptions(friction, lateral))
    assert refused.value.field == field


def test_unknown_limit_shape_is_rejected() -> None:
    with pytest.raises(UsageError) as refused:
        SlopeFace(Plane(90, 70), SlopeOptions(30, 20, "round"))
    assert refused.value.code == "option.not-a-choice"
    with pytest.raises(GeometryError):
        Plane(90, 120)


def test_critical_pair_members_match_leave_one_out_counts() -> None:
    azimuth, dip = many_planes(4, 40)
    face = some_face(4, "curved")
    normals = to_face_frame(face, planes_to_normals(azimuth, dip))
    members = count_pair_members(face, normals)
    for i in range(len(dip)):
        others = np.delete(normals, i, axis=0)
        without = count_pairs(face, others[None])
        everything = count_pairs(face, normals[None])
        assert members.wedge[i] == everything.wedge[0] - without.wedge[0]
        assert members.toppling[i] == everything.toppling[0] - without.toppling[0]
    assert members.wedge.any()
    assert members.toppling.any()


def test_planes_of_one_set_form_no_wedges() -> None:
    azimuth, dip = many_planes(6, 50)
    face = some_face(6, "curved")
    normals = to_face_frame(face, planes_to_normals(azimuth, dip))
    sets = np.random.default_rng(6).integers(-1, 3, len(dip))
    found = count_pairs(face, normals[None], sets=sets)
    everything = count_pairs(face, normals[None])
    # What remains is everything less the pairs within each set.
    within = [count_pairs(face, normals[sets == one][None]) for one in range(3)]
    for name in ("of", "wedge", "toppling", "oblique"):
        left_out = sum(int(getattr(each, name)[0]) for each in within)
        assert left_out > 0 or name != "of"
        assert getattr(found, name)[0] == getattr(everything, name)[0] - left_out
    assert found.of[0] + found.parallel[0] == count_pairs_between_sets(len(dip), sets)
    assert count_pairs(face, normals[None], sets=np.zeros(len(dip), np.int64)).of[0] == 0
    members = count_pair_members(face, normals, sets)
    assert members.wedge.sum() == 2 * found.wedge[0]
