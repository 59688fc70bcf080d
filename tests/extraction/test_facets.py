"""Facets of surfaces whose planes are known by construction."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import shapely

from tests.extraction.planes_by_construction import (
    angle_deg,
    axes_of,
    clouds_of,
    grid_mesh,
    normal_of,
    sheet,
)
from tests.messages import by_code
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import Cancelled, GeometryError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.options import declarations
from vomstudio.core.progress import CancelToken, SilentProgress
from vomstudio.extraction.facet_options import FacetOptions
from vomstudio.extraction.facets import FacetSegmentation, find_facets
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh

ATTITUDES = [(40.0, 70.0), (130.0, 85.0), (250.0, 15.0)]


def three_sheets(rng: np.random.Generator, **options: float) -> tuple[PointCloud, np.ndarray]:
    parts = [
        sheet(rng, attitude, (4.0 * i, 0.0, 0.0), **options)  # type: ignore[arg-type]
        for i, attitude in enumerate(ATTITUDES)
    ]
    return clouds_of(*parts)


def errors(found: FacetSegmentation, part: np.ndarray) -> dict[int, float]:
    """The angle to the truth, by the part that most of a facet's points are of."""
    result = {}
    for facet in found.facets:
        own = int(np.bincount(part[facet.rows]).argmax())
        result[own] = angle_deg(facet.fit.normal, normal_of(*ATTITUDES[own]))
    return result


def test_planes_of_a_cloud_are_found_with_their_attitudes() -> None:
    cloud, part = three_sheets(np.random.default_rng(1))
    result = find_facets(cloud)
    assert len(result.facets) == 3
    assert max(errors(result, part).values()) < 0.03
    assert result.exposure.coverage is not None
    assert result.exposure.coverage > 0.97
    for facet in result.facets:
        # 4 m2, but for the half spacing that the points leave free at the border.
        assert facet.area == pytest.approx(4.0, rel=0.05)
        assert len(facet.rows) > 3900


def test_large_coordinates_do_not_reduce_precision() -> None:
    cloud, part = three_sheets(np.random.default_rng(1))
    here = find_facets(cloud)
    there = find_facets(PointCloud(cloud.points + [500_000.0, 5_000_000.0, 1000.0]))
    assert len(here.facets) == len(there.facets) == 3
    for own, error in errors(there, part).items():
        assert error == pytest.approx(errors(here, part)[own], abs=1e-3)


def test_rotating_cloud_rotates_dip_directions() -> None:
    cloud, _ = three_sheets(np.random.default_rng(2))
    turn = np.radians(30.0)
    # Clockwise, as azimuths count.
    rotation = np.array(
        [[np.cos(turn), np.sin(turn), 0.0], [-np.sin(turn), np.cos(turn), 0.0], [0.0, 0.0, 1.0]]
    )
    before = find_facets(cloud).facets
    after = find_facets(PointCloud(cloud.points @ rotation.T)).facets

    def attitudes(facets: list) -> list[tuple[float, float]]:  # type: ignore[type-arg]
        return sorted((f.fit.dip_deg, f.fit.dip_direction_deg) for f in facets)

    for (dip, direction), (dip_after, direction_after) in zip(
        attitudes(before), attitudes(after), strict=True
    ):
        assert dip_after == pytest.approx(dip, abs=0.02)
        assert (direction_after - direction) % 360.0 == pytest.approx(30.0, abs=0.05)


def test_planes_are_found_despite_unequal_density_and_clutter() -> None:
    rng = np.random.default_rng(3)
    parts = [
        sheet(rng, attitude, (4.0 * i, 0.0, 0.0), count=count)
        for i, (attitude, count) in enumerate(zip(ATTITUDES, (20_000, 2_000, 600), strict=True))
    ]
    clutter = rng.uniform([-2.0, -2.0, -2.0], [10.0, 2.0, 2.0], (2_000, 3))
    cloud, part = clouds_of(*parts, clutter)
    result = find_facets(cloud)
    own = [int(np.bincount(part[facet.rows]).argmax()) for facet in result.facets]
    assert sorted(own) == [0, 1, 2]
    assert max(errors(result, part).values()) < 0.2
    for facet in result.facets:
        assert np.bincount(part[facet.rows]).max() > 0.97 * len(facet.rows)


def test_duplicate_points_change_nothing() -> None:
    cloud, _ = three_sheets(np.random.default_rng(4), count=2000)
    once = find_facets(cloud)
    twice = find_facets(PointCloud(np.repeat(cloud.points, 2, axis=0)))
    assert [f.fit.n for f in twice.facets] == [f.fit.n for f in once.facets]
    assert np.array_equal(twice.labels[::2], twice.labels[1::2])
    assert np.array_equal(twice.labels[::2], once.labels)


def test_treads_and_risers_of_staircase_are_separate_facets() -> None:
    step, high = 0.02, 0.3
    y = np.arange(0.0, 2.0, step)
    profile = []
    for number in range(4):
        profile += [(x, high * number) for x in np.arange(0.5 * number, 0.5 * (number + 1), step)]
        profile += [(0.5 * (number + 1), z) for z in high * number + np.arange(0.0, high, step)]
    points = np.array([(x, v, z) for x, z in profile for v in y])
    result = find_facets(PointCloud(points))
    dips = sorted(round(f.fit.dip_deg or 0.0, 3) for f in result.facets)
    assert dips == [0.0] * 4 + [90.0] * 4
    levels = sorted(f.fit.centroid[2] for f in result.facets if (f.fit.dip_deg or 0.0) < 1.0)
    assert np.allclose(np.diff(levels), high, atol=1e-6)


@pytest.mark.full
def test_curved_surface_gives_warning() -> None:
    angle, along = np.meshgrid(np.arange(0.0, np.pi, 0.01), np.arange(0.0, 3.0, 0.02))
    cylinder = np.stack([2.0 * np.cos(angle), along, 2.0 * np.sin(angle)], axis=-1)
    result = find_facets(PointCloud(cylinder.reshape(-1, 3)))
    assert len(result.facets) > 3
    assert "facets.wavy" in by_code(result.warnings)
    ball = np.random.default_rng(5).standard_normal((6000, 3))
    result = find_facets(PointCloud(ball / np.linalg.norm(ball, axis=1)[:, None]))
    assert "facets.wavy" in by_code(result.warnings)
    assert not find_facets(tent(0.001)).warnings
    flat, _ = three_sheets(np.random.default_rng(5))
    assert not find_facets(flat).warnings


@pytest.mark.parametrize(
    ("amplitude", "wavelength"),
    first_in_default_tier([(0.1, 4.0), (0.3, 4.0), (0.6, 4.0), (0.05, 1.0), (0.2, 2.0)]),
)
def test_folded_beds_give_curvature_warning(amplitude: float, wavelength: float) -> None:
    x, y = np.random.default_rng(77).uniform(0.0, 8.0, (2, 26_000))
    z = amplitude * np.sin(2.0 * np.pi * x / wavelength)
    z += 0.003 * np.random.default_rng(78).standard_normal(len(x))
    result = find_facets(PointCloud(np.column_stack([x, y, z])))
    assert "facets.wavy" in by_code(result.warnings)


@pytest.mark.full
def test_chevrons_and_flat_steps_give_no_curvature_warning() -> None:
    rng = np.random.default_rng(79)
    x, y = rng.uniform(0.0, 8.0, (2, 26_000))
    z = 0.6 / np.pi * np.arcsin(np.sin(2.0 * np.pi * x / 4.0)) + 0.01 * rng.standard_normal(len(x))
    result = find_facets(PointCloud(np.column_stack([x, y, z])))
    assert len(result.facets) >= 4
    assert not result.warnings
    down, normal = axes_of(100.0, 60.0)[1], normal_of(100.0, 60.0)
    for step in (0.03, 0.05):
        parts = [
            sheet(rng, (100.0, 60.0), tuple(i * down + step * i * normal), size=1.0, noise=0.002)
            for i in range(8)
        ]
        result = find_facets(PointCloud(np.concatenate(parts)))
        assert len(result.facets) == 8
        assert not result.warnings


def rough(rng: np.random.Generator, *, steep: bool) -> np.ndarray:
    """A rough wall, or ground, of 100 m2 without any plane."""
    x, y = rng.uniform(0.0, 10.0, (2, 40_000))
    off = 0.25 * np.sin(4.0 * x) * np.sin(5.0 * y) + 0.05 * np.sin(17.0 * x + 13.0 * y)
    return np.stack([x, off, y] if steep else [x, y, off], axis=1)


@pytest.mark.full
def test_mostly_non_planar_surface_gives_warning() -> None:
    rng = np.random.default_rng(6)
    plane = sheet(rng, (90.0, 80.0), (14.0, 5.0, 0.0), size=2.0, count=4000)
    cloud = PointCloud(np.concatenate([rough(rng, steep=True), plane]))
    result = find_facets(cloud, FacetOptions(min_area_m2=1.0))
    assert len(result.facets) == 1
    share = result.exposure.near_planar_share
    assert share is not None
    assert share < 0.1
    assert by_code(result.warnings)["facets.little-planar"]["recommended_percent"] == 30.0


@pytest.mark.full
def test_debris_below_wall_is_not_counted_as_exposure() -> None:
    rng = np.random.default_rng(6)
    wall = sheet(rng, (90.0, 80.0), (14.0, 5.0, 5.0), size=8.0, count=40_000)
    cloud = PointCloud(np.concatenate([rough(rng, steep=False), wall]))
    result = find_facets(cloud, FacetOptions(min_area_m2=1.0))
    assert result.exposure.coverage is not None
    assert result.exposure.coverage < 0.5
    assert result.exposure.debris_share > 0.3
    assert result.exposure.near_planar_share is not None
    assert result.exposure.near_planar_share > 0.8


def tent(noise: float = 0.0, seed: int = 0) -> Mesh:
    """Two planes that meet in a ridge, dipping 30 degrees west and east."""
    columns = np.arange(101)
    ridge = np.tan(np.radians(30.0)) * 0.02 * (50 - np.abs(columns - 50))
    heights = np.tile(ridge, (81, 1))
    return grid_mesh(
        heights + noise * np.random.default_rng(seed).standard_normal(heights.shape), 0.02
    )


@pytest.mark.parametrize(("noise", "within"), [(0.0, 1e-6), (0.002, 0.1)])
def test_mesh_faces_are_separated_at_a_ridge(noise: float, within: float) -> None:
    result = find_facets(tent(noise))
    assert len(result.facets) == 2
    for facet, truth in zip(
        sorted(result.facets, key=lambda f: f.fit.centroid[0]), [(270, 30), (90, 30)], strict=True
    ):
        assert angle_deg(facet.fit.normal, normal_of(*truth)) < within
        assert facet.area == pytest.approx(1.6 / np.cos(np.radians(30.0)), rel=0.06)
    assert result.exposure.coverage is not None
    assert result.exposure.coverage > 0.95


def test_a_mesh_of_few_large_faces_has_facets() -> None:
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], np.float64)
    faces = np.array(
        [
            [0, 1, 3],
            [0, 3, 2],
            [4, 6, 7],
            [4, 7, 5],
            [0, 4, 5],
            [0, 5, 1],
            [2, 3, 7],
            [2, 7, 6],
            [0, 2, 6],
            [0, 6, 4],
            [1, 5, 7],
            [1, 7, 3],
        ],
        np.int32,
    )
    result = find_facets(Mesh(corners, faces))
    assert len(result.facets) == 6
    assert sorted(round(f.area, 9) for f in result.facets) == [1.0] * 6
    assert result.exposure.coverage == pytest.approx(1.0)


def test_texture_seam_does_not_split_a_facet() -> None:
    mesh = tent()
    # Every face with vertices of its own.
    loose = Mesh(
        mesh.vertices[mesh.faces.ravel()],
        np.arange(mesh.faces.size, dtype=np.int32).reshape(-1, 3),
    )
    whole, apart = find_facets(mesh), find_facets(loose)
    assert [f.fit.n for f in apart.facets] == [f.fit.n for f in whole.facets]


def test_degenerate_faces_islands_and_shared_edges_are_tolerated() -> None:
    mesh = tent()
    n = len(mesh.vertices)
    extra = np.array([[0.0, 0.0, 0.1], [0.1, 0.0, 0.1], [0.0, 0.1, 0.1], [np.nan, 0.0, 0.0]])
    faces = np.array(
        [[0, 0, 1], [5, 6, 5], [n, n + 1, n + 2], [0, 1, n], [0, 1, n + 1], [0, 1, n + 3]], np.int32
    )
    spoilt = Mesh(np.concatenate([mesh.vertices, extra]), np.concatenate([mesh.faces, faces]))
    result = find_facets(spoilt)
    assert len(result.facets) == 2
    assert result.labels.dtype == np.int32
    assert len(result.labels) == n + 4
    assert (result.labels[n:] == -1).all()


def test_border_of_facet_has_hole_and_correct_area() -> None:
    rng = np.random.default_rng(7)
    points = sheet(rng, (250.0, 35.0), (100.0, 200.0, 50.0), count=40_000, noise=0.001)
    u = (points - [100.0, 200.0, 50.0]) @ np.array(
        [np.cos(np.radians(250.0)), -np.sin(np.radians(250.0)), 0.0]
    )
    inside = (np.abs(u) < 0.4) & (np.abs(points[:, 2] - 50.0) < 0.2)
    result = find_facets(PointCloud(points[~inside]))
    assert len(result.facets) == 1
    facet = result.facets[0]
    border = shapely.from_wkt(facet.border)
    assert border.has_z
    assert border.geom_type == "Polygon"
    assert len(border.interiors) == 1
    hole = 0.8 * 0.4 / np.sin(np.radians(35.0))
    assert facet.area == pytest.approx(4.0 - hole, rel=0.02)
    ring = shapely.get_coordinates(border, include_z=True)
    off = (ring - facet.fit.centroid) @ facet.fit.normal
    assert np.abs(off).max() < 1e-3


def test_hole_in_mesh_is_hole_in_border() -> None:
    mesh = grid_mesh(np.zeros((41, 41)), 0.05)
    middle = mesh.vertices[mesh.faces].mean(axis=1)
    kept = np.abs(middle - [1.0, 1.0, 0.0]).max(axis=1) > 0.25
    result = find_facets(replace(mesh, faces=mesh.faces[kept]))
    border = shapely.from_wkt(result.facets[0].border)
    assert border.area == pytest.approx(4.0 - 0.25, abs=1e-6)
    assert result.facets[0].area == pytest.approx(4.0 - 0.25, abs=1e-9)
    assert len(border.interiors) == 1


def test_wrong_normals_of_a_file_are_not_used() -> None:
    cloud, part = three_sheets(np.random.default_rng(8))
    up = np.zeros((len(cloud.points), 3), np.float32)
    up[:, 0] = 1.0
    result = find_facets(PointCloud(cloud.points, normals=up))
    assert max(errors(result, part).values()) < 0.03
    assert by_code(result.warnings)["cloud.normals-unused"]["angle_deg"] > 30.0


def test_planes_are_found_with_noise_larger_than_spacing() -> None:
    rng = np.random.default_rng(9)
    cloud, part = clouds_of(
        *(
            sheet(rng, attitude, (4.0 * i, 0.0, 0.0), count=40_000, noise=0.015)
            for i, attitude in enumerate(ATTITUDES)
        )
    )
    result = find_facets(cloud)
    assert len(result.facets) == 3
    assert max(errors(result, part).values()) < 0.1


def test_thresholds_that_select_nothing_give_empty_result() -> None:
    cloud, _ = three_sheets(np.random.default_rng(10), count=500)
    result = find_facets(cloud, FacetOptions(min_area_m2=1e6))
    assert result.facets == []
    assert (result.labels == -1).all()
    assert result.exposure.coverage == 0.0
    assert result.warnings == (Finding("facets.none"),)
    everything = find_facets(cloud, FacetOptions(angle_deg=89.0, max_distance_m=1e6, min_points=3))
    assert everything.facets or everything.warnings


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("angle_deg", (0.0, 90.0, float("nan"))),
        ("max_distance_m", (0.0, float("inf"))),
        ("min_points", (2,)),
        ("min_area_m2", (-1.0,)),
        ("preset", ("cse",)),
    ],
)
def test_invalid_thresholds_are_refused(name: str, values: tuple[Any, ...]) -> None:
    for value in values:
        with pytest.raises(UsageError) as error:
            FacetOptions(**{name: value})
        assert error.value.code.startswith("option.")
        (declared,) = (each for each in declarations(FacetOptions) if each.name == name)
        assert error.value.field == declared.flag


def test_a_model_without_a_surface_is_refused() -> None:
    with pytest.raises(GeometryError):
        find_facets(PointCloud(np.full((10, 3), np.nan)))
    with pytest.raises(GeometryError):
        find_facets(PointCloud(np.zeros((10, 3))))
    line = np.linspace(0.0, 1.0, 200)[:, None] * [1.0, 2.0, 3.0]
    assert find_facets(PointCloud(line)).facets == []
    with pytest.raises(GeometryError):
        find_facets(Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]], np.int32)))


def test_the_search_can_be_cancelled() -> None:
    cloud, _ = three_sheets(np.random.default_rng(12))
    token = CancelToken()
    token.cancel()
    with pytest.raises(Cancelled):
        find_facets(cloud, progress=SilentProgress(token))
