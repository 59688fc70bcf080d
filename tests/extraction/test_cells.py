"""Planes that are found on cells of a dense cloud before single points are looked at."""

from __future__ import annotations

import numpy as np
import pytest

from tests.extraction.planes_by_construction import angle_deg, clouds_of, normal_of, sheet
from vomstudio.core.errors import GeometryError
from vomstudio.core.progress import SilentProgress
from vomstudio.extraction.cells.planes import find_cell_planes
from vomstudio.extraction.facet_options import FacetOptions
from vomstudio.extraction.facets import find_facets
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.nearby.cell_grid import create_cell_grid

ATTITUDES = [(40.0, 70.0), (130.0, 85.0), (250.0, 15.0)]


@pytest.mark.parametrize("per_cell", [3.0, 16.0, 60.0])
def test_cells_contain_all_points_and_list_their_neighbours(per_cell: float) -> None:
    rng = np.random.default_rng(1)
    points = np.concatenate([sheet(rng, (40.0, 70.0), (0.0, 0.0, 0.0)), rng.normal(size=(500, 3))])
    local = points - np.floor(points.min(axis=0))
    grid = create_cell_grid(local, per_cell)
    assert np.array_equal(np.sort(grid.rows), np.arange(len(local)))
    assert np.array_equal(local[grid.rows], grid.places)
    assert np.array_equal(grid.places[grid.inverse_rows], local)
    count = np.diff(grid.starts)
    assert np.median(np.repeat(count, count)) == pytest.approx(per_cell, rel=0.7)
    starts, near = grid.neighbouring_cells()
    # The number of a cell from its three, counted in another way.
    i, j, k = grid.keys % grid.row, grid.keys % grid.layer // grid.row, grid.keys // grid.layer
    cell = np.stack([i, j, k], axis=1)
    for c in rng.choice(len(cell), 40):
        beside = np.flatnonzero(np.abs(cell - cell[c]).max(axis=1) == 1)
        assert np.array_equal(np.sort(near[starts[c] : starts[c + 1]]), beside)


def test_coincident_points_are_merged_in_grid() -> None:
    rng = np.random.default_rng(2)
    local = rng.uniform(0.0, 4.0, (3000, 3))
    few = np.concatenate([local, local[:1]])
    many = np.concatenate([local, np.tile(local[5], (1000, 1))])
    for points in (few, many):
        grid = create_cell_grid(points, 16.0)
        assert len(grid.places) == 3000
        assert np.array_equal(grid.places[grid.inverse_rows], points)


def test_points_inside_plane_are_closed_and_points_at_edge_open() -> None:
    rng = np.random.default_rng(3)
    floor = np.stack([*rng.uniform(0.0, 2.0, (2, 40_000)), np.zeros(40_000)], axis=1)
    wall = np.stack(
        [np.zeros(40_000), rng.uniform(0.0, 2.0, 40_000), rng.uniform(0.0, 2.0, 40_000)], axis=1
    )
    points = np.concatenate([floor, wall])
    points += 0.002 * rng.standard_normal(points.shape)
    local = points - np.floor(points.min(axis=0))
    grid, begun = find_cell_planes(local, 20.0, None, 50, 0.0, SilentProgress())
    corner = np.hypot(points[grid.rows, 0], points[grid.rows, 2])
    assert begun.is_open[corner < 0.02].all()
    assert begun.is_open[corner > 0.3].mean() < 0.05
    closed = ~begun.is_open
    assert (begun.labels[closed] >= 0).all()
    # The area that the points stand for is that of the two faces.
    assert begun.areas[closed].sum() == pytest.approx(8.0 * closed.mean(), rel=0.05)
    assert np.median(begun.noise[closed]) == pytest.approx(0.002, rel=0.1)


@pytest.mark.parametrize("noise", [0.002, 0.012, 0.03])
def test_planes_of_dense_cloud_are_recovered(noise: float) -> None:
    rng = np.random.default_rng(4)
    counts = (60_000, 20_000, 8_000)
    parts = [
        sheet(rng, attitude, (4.0 * i, 0.0, 0.0), count=count, noise=noise)
        for i, (attitude, count) in enumerate(zip(ATTITUDES, counts, strict=True))
    ]
    clutter = rng.uniform([-2.0, -2.0, -2.0], [10.0, 2.0, 2.0], (4_000, 3))
    cloud, part = clouds_of(*parts, clutter)
    result = find_facets(cloud, FacetOptions(min_area_m2=0.5))
    planes = [(facet, int(np.bincount(part[facet.rows]).argmax())) for facet in result.facets]
    planes = [(facet, which) for facet, which in planes if which < 3]
    assert sorted(which for _, which in planes) == [0, 1, 2]
    for facet, which in planes:
        assert angle_deg(facet.fit.normal, normal_of(*ATTITUDES[which])) < 0.05 + 2.0 * noise
        assert facet.area == pytest.approx(4.0, rel=0.06)
        assert len(facet.rows) > 0.93 * counts[which]


def test_small_planes_beside_large_ones_are_found_in_a_dense_cloud() -> None:
    rng = np.random.default_rng(5)
    large = sheet(rng, (250.0, 15.0), (0.0, 0.0, 0.0), count=60_000, noise=0.002)
    # 15 cm wide, some 300 points each: hardly larger than the cells of the cloud.
    small = [
        sheet(rng, (40.0, 70.0), (3.0 + 0.5 * k, 0.0, 0.0), size=0.15, count=300, noise=0.002)
        for k in range(5)
    ]
    cloud, part = clouds_of(large, *small)
    result = find_facets(cloud)
    own = sorted(int(np.bincount(part[facet.rows]).argmax()) for facet in result.facets)
    assert own == [0, 1, 2, 3, 4, 5]
    for facet in result.facets[1:]:
        assert angle_deg(facet.fit.normal, normal_of(40.0, 70.0)) < 1.0


@pytest.mark.full
def test_duplicates_shifts_and_given_normals_do_not_change_dense_result() -> None:
    rng = np.random.default_rng(6)
    parts = [
        sheet(rng, attitude, (4.0 * i, 0.0, 0.0), count=20_000)
        for i, attitude in enumerate(ATTITUDES)
    ]
    cloud, part = clouds_of(*parts)
    plain = [facet.fit.n for facet in find_facets(cloud).facets]
    twins = PointCloud(np.repeat(cloud.points, 2, axis=0) + [500_000.0, 5_000_000.0, 100.0])
    assert [facet.fit.n for facet in find_facets(twins).facets] == pytest.approx(plain, rel=0.001)
    normals = np.array([normal_of(*ATTITUDES[i]) for i in part], np.float32)
    inputs = find_facets(PointCloud(cloud.points, normals=normals))
    assert [facet.fit.n for facet in inputs.facets] == pytest.approx(plain, rel=0.002)
    broken = cloud.points.copy()
    broken[::1000] = np.nan
    result = find_facets(PointCloud(broken))
    assert len(result.facets) == 3
    assert (result.labels[::1000] == -1).all()


@pytest.mark.full
def test_exact_plane_is_one_facet_and_line_has_none_in_dense_cloud() -> None:
    rng = np.random.default_rng(7)
    x, y = rng.uniform(0.0, 10.0, (2, 60_000))
    exact = np.stack([x, y, 0.5 * x], axis=1)
    grid = np.stack(np.meshgrid(np.arange(250.0), np.arange(250.0), [0.0]), axis=-1).reshape(-1, 3)
    truth = np.array([-0.5, 0.0, 1.0]) / np.sqrt(1.25)
    for points, normal in (
        (exact, truth),
        (exact + 1e9, truth),
        (np.concatenate([exact, [[1e7, 0.0, 0.0], [np.inf, 0.0, 0.0]]]), truth),
        (grid, np.array([0.0, 0.0, 1.0])),
    ):
        result = find_facets(PointCloud(points))
        assert len(result.facets) == 1
        assert angle_deg(result.facets[0].fit.normal, normal) < 1e-3
        assert len(result.facets[0].rows) >= len(points) - 60
    line = np.stack([np.linspace(0.0, 10.0, 60_000), *np.zeros((2, 60_000))], axis=1)
    assert not find_facets(PointCloud(line)).facets
    with pytest.raises(GeometryError):
        find_facets(PointCloud(np.ones((60_000, 3))))
