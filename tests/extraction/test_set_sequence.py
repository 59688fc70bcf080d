"""The sequence of DSE on clouds that are known by construction, as its authors tested it (Riquelme
et al. 2014: solids with regular faces; 2015: parallel planes), and its clusters beside Open3D's."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest

from tests.extraction.planes_by_construction import angle_deg, normal_of, sheet
from vomstudio.core.errors import UsageError
from vomstudio.core.progress import SilentProgress
from vomstudio.extraction.facet_options import FacetOptions
from vomstudio.extraction.facet_search import search_facets
from vomstudio.extraction.facet_table import FacetTable
from vomstudio.extraction.set_sequence import dbscan, find_set_poles
from vomstudio.geometry.cloud import PointCloud

Array = np.ndarray


def found_in(points: Array, preset: Literal["dse"] | None = "dse", **limits: float) -> FacetTable:
    options = FacetOptions(
        angle_deg=limits.get("angle"),
        min_points=int(limits["fewest"]) if "fewest" in limits else None,
        propose_sets=True,
        preset=preset,
    )
    return search_facets(
        PointCloud(points), options, model="", frame="local", progress=SilentProgress()
    )


def mean_of(one: dict) -> Array:
    return normal_of(one.dip_direction_deg, one.dip_deg)


def cube(rng: np.random.Generator, turn: Array, side: float = 2.0) -> Array:
    faces = []
    for axis in range(3):
        for end in (-1, 1):
            at = rng.uniform(-side / 2, side / 2, (1500, 3))
            at[:, axis] = end * side / 2 + 0.003 * rng.standard_normal(1500)
            faces.append(at)
    return np.concatenate(faces) @ turn.T + [3e5, 4e6, 100.0]


def turned(seed: int) -> Array:
    q, _ = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))
    return q * np.sign(np.linalg.det(q))


@pytest.mark.full
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_cube_has_three_sets_of_two_planes_with_spacing_of_its_side(seed: int) -> None:
    turn = turned(seed)
    result = found_in(cube(np.random.default_rng(seed), turn))
    assert len(result.sets) == 3
    assert result.facets == 6
    for one in result.sets:
        assert min(angle_deg(mean_of(one), axis) for axis in turn.T) < 1.0
        assert one.discontinuities == 2
        assert one.spacing_m == pytest.approx(2.0, abs=0.03)
        assert one.rests_on == "several faces"
        assert one.area_m2 == pytest.approx(8.0, rel=0.15)
    assert result.coverage == pytest.approx(1.0, abs=0.1)


def test_parallel_joints_have_true_spacing_and_persistence() -> None:
    attitude, gap = (75.0, 80.0), 0.6
    rng = np.random.default_rng(7)
    normal = normal_of(*attitude)
    parts = [sheet(rng, attitude, tuple(k * gap * normal), size=2.0, count=2500) for k in range(7)]
    result = found_in(np.concatenate(parts))
    (one,) = result.sets
    assert angle_deg(mean_of(one), normal) < 0.2
    assert one.discontinuities == 7
    assert one.spacing_m == pytest.approx(gap, abs=0.005)
    assert one.spacing_ending_m == pytest.approx(gap, abs=0.005)
    assert one.persistence_dip_m == pytest.approx(2.0, abs=0.1)
    assert one.persistence_strike_m == pytest.approx(2.0, abs=0.1)
    assert one.p32_1_per_m == pytest.approx(1 / gap, rel=0.01)
    assert one.p32_exposed_1_per_m == pytest.approx(1 / gap, rel=0.1)
    assert len({row["discontinuity"] for row in result.rows}) == 7


@pytest.mark.parametrize("preset", ["dse", None])
def test_staircase_treads_and_risers_have_expected_spacing_and_area(preset: str | None) -> None:
    # Treads 0.5 m deep, risers 0.3 m high, 4 m wide.
    rng = np.random.default_rng(8)
    depth, height, width, steps = 0.5, 0.3, 4.0, 8
    parts = []
    for k in range(steps):
        x = rng.uniform(0, width, (1400, 1))
        tread = np.column_stack([x, k * depth + rng.uniform(0, depth, 1400), np.full(1400, k)])
        tread[:, 2] = (k + 1) * height
        riser = np.column_stack([x[:900], np.full(900, k * depth), np.zeros(900)])
        riser[:, 2] = k * height + rng.uniform(0, height, 900)
        parts += [tread, riser]
    points = np.concatenate(parts) + 0.002 * rng.standard_normal((steps * 2300, 3))
    result = found_in(points, preset)
    by_dip = sorted(result.sets, key=lambda s: s.dip_deg)
    flat, steep = by_dip[0], by_dip[-1]
    assert flat.dip_deg < 1.0
    assert steep.dip_deg > 89.0
    assert steep.dip_direction_deg % 180 == pytest.approx(0.0, abs=1.0) or (
        steep.dip_direction_deg % 180 > 179.0
    )
    for one, gap, area in ((flat, height, width * depth), (steep, depth, width * height)):
        assert one.discontinuities == steps
        assert one.spacing_m == pytest.approx(gap, abs=0.01)
        own = [d.hull_m2 for d in result.discontinuities if d.set == one.name]
        assert np.mean(own) == pytest.approx(area, rel=0.1)
    # The strike of what is almost level is anywhere.
    assert steep.persistence_strike_m == pytest.approx(width, abs=0.1)
    assert steep.persistence_dip_m == pytest.approx(height, abs=0.08)


def test_rotating_cloud_rotates_the_sets() -> None:
    points = cube(np.random.default_rng(5), turned(5)) - [3e5, 4e6, 100.0]
    c, s = np.cos(np.radians(30)), np.sin(np.radians(30))
    clockwise = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]])
    one, two = found_in(points), found_in(points @ clockwise.T)
    for axis in (mean_of(a) for a in one.sets):
        assert min(angle_deg(clockwise @ axis, mean_of(b)) for b in two.sets) < 0.2


def test_density_maxima_of_poles_are_found_regardless_of_sign() -> None:
    rng = np.random.default_rng(9)
    truth = [(10.0, 88.0, 3000), (100.0, 45.0, 1500), (250.0, 10.0, 400)]
    parts = []
    for direction, dip, n in truth:
        axes = normal_of(direction, dip) + 0.08 * rng.standard_normal((n, 3))
        parts.append(axes * rng.choice([-1, 1], (n, 1)))
    poles = np.concatenate(parts)
    poles /= np.linalg.norm(poles, axis=1)[:, None]
    poles[::50] = np.nan
    result = find_set_poles(poles)
    assert len(result) == 3
    for (direction, dip, _), mean in zip(truth, result, strict=True):
        assert angle_deg(mean, normal_of(direction, dip)) < 1.0


def test_clusters_match_open3d_dbscan() -> None:
    import open3d as o3d

    rng = np.random.default_rng(10)
    points = np.concatenate(
        [rng.normal(c, 0.3, (400, 3)) for c in ((0, 0, 0), (3, 0, 0), (0, 4, 1))]
        + [rng.uniform(-4, 6, (150, 3))]
    )
    for reach, core in ((0.2, 4), (0.35, 10), (0.1, 4)):
        cloud = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
        theirs = np.asarray(cloud.cluster_dbscan(reach, core))
        ours = dbscan(points, reach, core)
        # Border points may be in either of two clusters; cores and noise have one answer.
        distance = np.linalg.norm(points[:, None] - points[None], axis=2)
        is_core = (distance <= reach).sum(axis=1) >= core
        assert ((ours < 0) == (theirs < 0)).all()
        pairs = {(int(a), int(b)) for a, b in zip(ours[is_core], theirs[is_core], strict=True)}
        assert len(pairs) == len({a for a, _ in pairs}) == len({b for _, b in pairs})


def test_cloud_without_sets_gives_no_facets_and_conflicts_are_refused() -> None:
    rng = np.random.default_rng(11)
    assert found_in(rng.uniform(0, 1, (60, 3))).facets == 0
    with pytest.raises(UsageError) as error:
        FacetOptions(max_distance_m=0.1, preset="dse")
    assert error.value.code == "option.conflict"
    assert error.value.values == {"option": "--max-distance", "other": "--preset"}
