"""What is around single points of a dense cloud, beside SciPy's search tree."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree

from tests.extraction.planes_by_construction import angle_deg, sheet
from vomstudio.core.progress import SilentProgress
from vomstudio.extraction.elements import MIN_POINTS_AROUND
from vomstudio.extraction.point_neighbours import (
    N_NEIGHBOURS,
    NORMAL_POINT_COUNTS,
    find_neighbourhoods,
    find_scattered_points,
)
from vomstudio.geometry.nearby.cell_grid import create_cell_grid


def cloud(rng: np.random.Generator) -> np.ndarray:
    parts = [sheet(rng, (40.0 + 60 * i, 70.0), (3.0 * i, 0, 0), count=30_000) for i in range(2)]
    thin = sheet(rng, (250.0, 15.0), (6.0, 0.0, 0.0), count=800)
    points = np.concatenate([*parts, thin, rng.uniform(-2.0, 8.0, (500, 3))])
    return points - np.floor(points.min(axis=0))


@pytest.mark.parametrize("known", [16, 32, 64])
def test_neighbours_and_normals_match_search_tree(known: int) -> None:
    rng = np.random.default_rng(1)
    grid = create_cell_grid(cloud(rng), 16.0)
    few = grid.count_neighbourhood_points() < MIN_POINTS_AROUND
    rows = np.sort(rng.choice(len(grid.places), 4000, replace=False))
    around, seen = find_neighbourhoods(grid, rows, few, known, 20.0, SilentProgress())
    assert around == known
    thin = few[grid.find_cells(rows)]
    assert thin.any()
    assert np.array_equal(np.unique(seen.point_counts[thin]), [NORMAL_POINT_COUNTS[0]])
    assert np.array_equal(np.unique(seen.point_counts[~thin]), [known])
    distance, neighbours = cKDTree(grid.places).query(grid.places[rows], k=known)
    dense = ~thin
    assert np.array_equal(seen.neighbours[dense], neighbours[dense, 1 : N_NEIGHBOURS + 1])
    np.testing.assert_allclose(seen.farthest_distances[dense], distance[dense, N_NEIGHBOURS])
    off = []
    for i in rng.choice(np.flatnonzero(dense), 400):
        own = grid.places[neighbours[i]] - grid.places[neighbours[i]].mean(axis=0)
        off.append(angle_deg(np.linalg.svd(own)[2][2], seen.normals[i]))
    # Of what is dense beside a thin place a part of its points may stand for all.
    assert np.quantile(off, 0.98) < 1e-5
    assert max(off) < 3.0
    own, neighbours = seen.neighbours[thin], neighbours[thin, 1 : N_NEIGHBOURS + 1]
    same = [len(np.intersect1d(a, b)) for a, b in zip(own, neighbours, strict=True)]
    assert np.median(same) == N_NEIGHBOURS
    assert np.mean(same) > 0.94 * N_NEIGHBOURS


def test_volume_points_are_scattered_but_thin_sheet_is_not() -> None:
    rng = np.random.default_rng(2)
    volume = rng.uniform(0.0, 10.0, (20_000, 3))
    inner = (np.abs(volume - 5.0) < 3.5).all(axis=1)
    result, area = find_scattered_points(volume)
    assert result[inner].mean() > 0.97
    # Of a cube for each point, a face.
    assert area == pytest.approx((1000.0 / 20_000) ** (2.0 / 3.0), rel=0.5)
    plane = sheet(rng, (70.0, 50.0), (5.0, 5.0, 5.0), size=6.0, count=3_000, noise=0.01)
    assert find_scattered_points(plane)[0].sum() == 0
    both = find_scattered_points(np.concatenate([volume[:3_000], plane]))[0]
    assert both[3_000:].mean() < 0.03
