"""Facets as slopes: each as the single face of its attitude, and as mplstereonet counts it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.messages import by_code, refused
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.geology.fractures.facet_slopes import MODES, FacetFace, facet_slopes
from vomstudio.geology.orientation import Plane, normals_to_planes
from vomstudio.geology.slope_options import SlopeOptions
from vomstudio.geology.slopes import SlopeFace
from vomstudio.geology.table_slopes import table_slope
from vomstudio.io.gate.orientation_files import read_orientations


@pytest.fixture
def planes(tmp_path):
    """Eighty planes of all directions, and three that strike alike."""
    azimuth, dip, _ = normals_to_planes(np.random.default_rng(8).normal(size=(80, 3)))
    path = tmp_path / "planes.csv"
    # Of the same strike: their intersections are level.
    azimuth, dip = np.append(azimuth, [100.0, 280.0, 100.0]), np.append(dip, [30.0, 40.0, 60.0])
    rows = [f"{a:.3f},{d:.3f}" for a, d in zip(azimuth, dip, strict=True)]
    path.write_text("\n".join(["dipdir,dip", *rows]) + "\n")
    return read_orientations(path), azimuth.round(3), dip.round(3)


def some_facets(n: int = 25) -> list[FacetFace]:
    generator = np.random.default_rng(2)
    return [
        FacetFace(str(i), Plane(float(a), float(d)), overhangs=False)
        for i, (a, d) in enumerate(
            zip(generator.uniform(0, 360, n), generator.uniform(20, 89, n), strict=True)
        )
    ]


@pytest.mark.parametrize(("lateral", "limits"), [(20.0, "curved"), (35.0, "straight")])
def test_facet_result_matches_single_slope_of_its_attitude(
    planes, lateral: float, limits: str
) -> None:
    table, *_ = planes
    facets = [
        *some_facets(),
        FacetFace("v", Plane(100.0, 90.0)),
        FacetFace("w", Plane(280.0, 90.0)),
    ]
    found = facet_slopes(table, facets, SlopeOptions(30.0, lateral, limits))
    assert [f.id for f in found.facets] == [f.id for f in facets]
    for facet, each in zip(facets, found.facets, strict=True):
        single = table_slope(table, SlopeFace(facet.plane, SlopeOptions(30.0, lateral, limits)))
        for mode in MODES:
            one, other = getattr(each, mode), getattr(single, mode)
            assert (one.critical, one.of, one.share) == (other.critical, other.of, other.share)


def test_facet_is_not_tested_against_itself(tmp_path) -> None:
    """Of planes that are the facets themselves, each is held against all others: as the single
    slope of its attitude over the table without its row."""
    generator = np.random.default_rng(11)
    azimuth = np.round(generator.uniform(80, 160, 12), 3)
    dip = np.round(generator.uniform(35, 89, 12), 3)
    head, rows = (
        "id,dipdir,dip",
        [f"f{i},{a:.3f},{d:.3f}" for i, (a, d) in enumerate(zip(azimuth, dip, strict=True))],
    )

    def read(name: str, some: list[str]):  # type: ignore[no-untyped-def]
        path = tmp_path / name
        path.write_text("\n".join([head, *some]) + "\n")
        return read_orientations(path)

    facets = [
        FacetFace(f"f{i}", Plane(float(a), float(d)), overhangs=False)
        for i, (a, d) in enumerate(zip(azimuth, dip, strict=True))
    ]
    found = facet_slopes(read("all.csv", rows), facets, SlopeOptions(30.0, 20.0, "curved"))
    for i, (facet, each) in enumerate(zip(facets, found.facets, strict=True)):
        others = read(f"without{i}.csv", rows[:i] + rows[i + 1 :])
        single = table_slope(others, SlopeFace(facet.plane, SlopeOptions(30.0, 20.0, "curved")))
        for mode in MODES:
            one, other = getattr(each, mode), getattr(single, mode)
            assert (one.critical, one.of, one.share) == (other.critical, other.of, other.share)


def test_facet_counts_match_mplstereonet(planes, mplstereonet: Any) -> None:
    from mplstereonet import kinematic_analysis

    table, azimuth, dip = planes
    facet = some_facets()[0]
    (each,) = facet_slopes(table, [facet], SlopeOptions(28.0, 20.0, "curved")).facets
    plane = facet.plane
    arguments = (plane.strike_rhr_deg, plane.dip_deg, 28.0, 20.0)
    for theirs, ours in (
        (kinematic_analysis.PlanarSliding(*arguments), each.planar),
        (kinematic_analysis.FlexuralToppling(*arguments), each.flexural_toppling),
    ):
        critical, _ = theirs.check_failure(azimuth - 90, dip.copy(), True)
        assert ours.critical == critical.sum()
    first, second = np.triu_indices(len(dip), 1)
    plunge, bearing = mplstereonet.plane_intersection(
        azimuth[first] - 90, dip[first], azimuth[second] - 90, dip[second]
    )
    wedge = kinematic_analysis.WedgeSliding(plane.strike_rhr_deg, plane.dip_deg, 28.0)
    critical, _ = wedge.check_failure(bearing, plunge)
    assert (each.wedge.critical, each.wedge.of) == (critical.sum(), len(first))


def test_rotation_changes_no_share(planes, tmp_path) -> None:
    table, azimuth, dip = planes
    path = tmp_path / "turned.csv"
    rows = [f"{(a + 30) % 360:.3f},{d:.3f}" for a, d in zip(azimuth, dip, strict=True)]
    path.write_text("\n".join(["dipdir,dip", *rows]) + "\n")
    facets = some_facets(8)
    turned = [
        FacetFace(f.id, Plane((f.plane.dip_direction_deg + 30) % 360, f.plane.dip_deg))
        for f in facets
    ]
    one = facet_slopes(table, facets, SlopeOptions(30.0, 20.0, "curved"))
    other = facet_slopes(read_orientations(path), turned, SlopeOptions(30.0, 20.0, "curved"))
    for mode in MODES:
        assert one.shares(mode) == pytest.approx(other.shares(mode), abs=1e-9)


def test_overhang_is_treated_as_vertical_face_with_opposite_direction(planes) -> None:
    table, *_ = planes
    over = FacetFace("a", Plane(40.0, 80.0), overhangs=True)
    upright = FacetFace("b", Plane(220.0, 90.0), overhangs=False)
    found = facet_slopes(table, [over, upright], SlopeOptions(30.0, 20.0, "curved"))
    one, other = found.facets
    assert one.face == other.face
    assert one.wedge == other.wedge
    assert by_code(found.warnings)["slope.overhanging-facets"] == {"count": 1}


def test_horizontal_facets_are_skipped_and_reported(planes) -> None:
    table, *_ = planes
    flat, steep = FacetFace("flat", Plane(0.0, 0.0)), FacetFace("steep", Plane(10.0, 88.0))
    found = facet_slopes(table, [flat, steep], SlopeOptions(30.0, 20.0, "curved"))
    assert [each["id"] for each in found.skipped] == ["flat"]
    assert by_code([found.skipped[0]["reason"]]) == {"slope.horizontal-face": {}}
    assert by_code(found.warnings)["slope.vertical-facets"] == {"count": 1}
    with refused("slope.no-facet", GeometryError):
        facet_slopes(table, [flat], SlopeOptions(30.0, 20.0, "curved"))
    with refused("option.out-of-range", UsageError, field="--friction"):
        facet_slopes(table, [steep], SlopeOptions(95.0, 20.0, "curved"))
