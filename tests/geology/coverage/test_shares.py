"""What was looked at, and figures per area over that: closed forms and shapely."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from scipy.spatial.transform import Rotation

from tests.messages import by_code
from vomstudio.geology.coverage.cells import SquareGrid
from vomstudio.geology.coverage.face_coverage import cell_name, lengths_in_cells, measure_coverage

EAST, NORTH, UP = np.eye(3)
GRID = SquareGrid(np.zeros(3), EAST, NORTH, 2.0, 3, 2)
FULL = np.full(6, 4.0)


def line(*xy: tuple[float, float]) -> np.ndarray:
    return np.array([[x, y, 0.3] for x, y in xy])


def test_areas_and_shares_are_summed_by_mark() -> None:
    covered = np.array([4.0, 4.0, 2.0, 4.0, 0.0, 2.0])
    found = measure_coverage(GRID, "ddeu-u", 2.0 * covered, covered)
    # The cell without any rock is none of them.
    assert found.cells == 5
    assert (found.done.cells, found.done.covered_m2, found.done.surface_m2) == (2, 8.0, 16.0)
    assert (found.unmeasurable.cells, found.unmeasurable.share) == (2, 6.0 / 16.0)
    assert (found.not_looked_at.cells, found.looked_at_share) == (0, 1.0)
    assert found.counted_m2 == 10.0
    assert by_code(found.reasons)["grid.unmeasurable-cells"] == {
        "count": 2,
        "share_percent": pytest.approx(100.0 * 6.0 / 16.0),
    }


def test_density_is_computed_over_done_and_empty_cells() -> None:
    """Ten metres of lines; four of them, and one middle, in cells that count: 12 m2."""
    marks = "de-du-"
    lines = [line((0.0, 1.0), (6.0, 1.0)), line((3.0, 2.5), (3.0, 3.5)), line((5.0, 3.0))]
    found = measure_coverage(GRID, marks, FULL, FULL, lines)
    assert found.counted_m2 == 12.0
    assert found.P21_1_per_m == pytest.approx(4.0 / 12.0)
    assert found.density_1_per_m2 == pytest.approx(1.0 / 12.0)
    assert found.features == 1
    # The first line runs through a cell where there was said to be nothing.
    assert found.contradictions == ("B2",)
    assert by_code(found.reasons)["grid.empty-cells-with-features"] == {"cells": ("B2",)}


def test_inclined_and_rotated_face_gives_same_density() -> None:
    turn = Rotation.from_euler("zx", [30.0, 60.0], degrees=True).as_matrix()
    far = np.array([5e5, 5e6, 100.0])
    moved = SquareGrid(far, turn @ EAST, turn @ NORTH, 2.0, 3, 2)
    lines = [line((0.3, 0.4), (5.0, 3.0), (2.2, 3.9))]
    here = measure_coverage(GRID, "dddddd", FULL, FULL, lines)
    there = measure_coverage(
        moved, "dddddd", FULL, FULL, [turned @ turn.T + far for turned in lines]
    )
    assert there.P21_1_per_m == pytest.approx(here.P21_1_per_m)


def test_lengths_in_cells_match_shapely() -> None:
    rng = np.random.default_rng(2)
    cells = shapely.polygons(GRID.corners(np.arange(6))[..., :2])
    for _ in range(50):
        points = rng.uniform(-3, 8, (4, 3))
        wanted = shapely.length(shapely.intersection(cells, shapely.LineString(points[:, :2])))
        found = lengths_in_cells(GRID, points)
        assert [found.get(k, 0.0) for k in range(6)] == pytest.approx(wanted.tolist(), abs=1e-9)


def test_very_long_line_is_clipped_and_zero_length_line_has_no_cells() -> None:
    far = lengths_in_cells(GRID, line((-1e9, 1.0), (1e9, 1.0)))
    assert far == pytest.approx({0: 2.0, 1: 2.0, 2: 2.0}, rel=1e-5)
    assert lengths_in_cells(GRID, line((1.0, 1.0), (1.0, 1.0))) == {}


def test_face_without_cells_has_no_share() -> None:
    found = measure_coverage(GRID, "", np.zeros(6), np.zeros(6), [line((1.0, 1.0))])
    assert (found.cells, found.looked_at_share, found.P21_1_per_m) == (0, None, None)


def test_cells_are_named_like_map_squares() -> None:
    assert [cell_name(GRID, k) for k in range(6)] == ["A2", "B2", "C2", "A1", "B1", "C1"]
    wide = SquareGrid(np.zeros(3), EAST, NORTH, 1.0, 800, 1)
    assert [cell_name(wide, k) for k in (25, 26, 701, 702)] == ["Z1", "AA1", "ZZ1", "AAA1"]
