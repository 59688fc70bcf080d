"""Cells over a face: areas in closed form and by shapely, laws, absurd grids."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from scipy.spatial.transform import Rotation

from tests.messages import refused
from vomstudio.core.errors import GeometryError
from vomstudio.geology.coverage import cells as module
from vomstudio.geology.coverage.cells import (
    ExposedArea,
    SquareGrid,
    create_grid,
    measure_points,
)

EAST, NORTH, UP = np.eye(3)
SQUARE = np.array([[[-1, -1, 0], [5, -1, 0], [5, 5, 0]], [[-1, -1, 0], [5, 5, 0], [-1, 5, 0.0]]])


def measure_faces(grid: SquareGrid, corners: np.ndarray, *, pieces: bool = False) -> ExposedArea:
    rows = np.arange(3 * len(corners)).reshape(-1, 3)
    return module.measure_faces(grid, corners.reshape(-1, 3), rows, include_pieces=pieces)


def flat(columns: int = 4, rows: int = 3, cell: float = 0.5) -> SquareGrid:
    return SquareGrid(np.zeros(3), EAST, NORTH, cell, columns, rows)


def area(triangles: np.ndarray) -> np.ndarray:
    across = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    return np.linalg.norm(across, axis=1) / 2.0


def test_a_face_larger_than_the_grid_fills_every_cell() -> None:
    found = measure_faces(flat(), SQUARE, pieces=True)
    assert found.covered == pytest.approx(np.full(12, 0.25))
    assert found.surface == pytest.approx(np.full(12, 0.25))
    # The lines of the grid, and none of them outside of it: 5 upright of 1.5, 4 level of 2.
    lengths = np.linalg.norm(found.lines[:, 1] - found.lines[:, 0], axis=1) * 0.5
    assert lengths.sum() == pytest.approx(5 * 1.5 + 4 * 2.0)
    assert found.lines[..., :2].min() == pytest.approx(0.0)
    assert found.lines[..., 0].max() == pytest.approx(4.0)
    assert found.lines[..., 1].max() == pytest.approx(3.0)


@pytest.mark.parametrize("dip", [0.0, 30.0, 60.0, 85.0])
def test_inclined_plane_has_surface_divided_by_cosine(dip: float) -> None:
    tilted = SQUARE.copy()
    tilted[..., 2] = np.tan(np.radians(dip)) * tilted[..., 0]
    found = measure_faces(flat(), tilted)
    assert found.surface == pytest.approx(np.full(12, 0.25 / math.cos(math.radians(dip))))
    assert found.covered == pytest.approx(np.full(12, 0.25))


def test_triangle_areas_match_shapely() -> None:
    rng = np.random.default_rng(5)
    grid = SquareGrid(np.array([-1.0, 0.5, 0.0]), EAST, NORTH, 0.7, 5, 4)
    for _ in range(40):
        corners = rng.uniform(-4, 5, (1, 3, 3))
        found = measure_faces(grid, corners)
        seen = shapely.Polygon(corners[0, :, :2])
        cells = shapely.polygons(grid.corners(np.arange(grid.count))[..., :2])
        wanted = shapely.area(shapely.intersection(cells, seen))
        assert found.covered == pytest.approx(wanted, abs=1e-12)
        assert found.surface == pytest.approx(wanted * area(corners)[0] / seen.area, abs=1e-9)


def wavy() -> np.ndarray:
    """(m, 3, 3) of a bumpy face."""
    y, x = np.mgrid[0:30, 0:40] * 0.1
    points = np.stack([x, y, 0.2 * np.sin(3 * x) * np.cos(2 * y)], axis=-1).reshape(-1, 3)
    i = np.arange(1200).reshape(30, 40)
    a, b, c, d = (part.ravel() for part in (i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]))
    return points[np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])]


def sums(found: ExposedArea) -> tuple[float, float]:
    return float(found.surface.sum()), float(found.covered.sum())


def test_grid_cells_preserve_total_surface() -> None:
    corners = wavy()
    grid = create_grid(corners.reshape(-1, 3), EAST, NORTH, 0.33)
    found = measure_faces(grid, corners, pieces=True)
    assert sums(found) == pytest.approx((area(corners).sum(), 3.9 * 2.9))
    pieces = grid.cell**2 * area(found.pieces)
    assert np.bincount(found.cell, pieces, grid.count) == pytest.approx(found.surface)
    # Every piece lies in its cell.
    row, column = np.divmod(found.cell, grid.columns)
    low = np.stack([column, row], axis=1)[:, None]
    assert (found.pieces[..., :2] >= low - 1e-9).all()
    assert (found.pieces[..., :2] <= low + 1 + 1e-9).all()


def test_rotation_and_translation_change_nothing() -> None:
    corners = wavy()
    turn = Rotation.from_euler("zyx", [30.0, 50.0, 70.0], degrees=True).as_matrix()
    far = np.array([4.5e5, 5.2e6, 800.0])
    grid = SquareGrid(np.array([0.05, 0.02, 0.0]), EAST, NORTH, 0.4, 7, 5)
    moved = SquareGrid(turn @ grid.origin + far, turn @ EAST, turn @ NORTH, 0.4, 7, 5)
    there = measure_faces(moved, corners @ turn.T + far)
    here = measure_faces(grid, corners)
    assert there.surface == pytest.approx(here.surface, rel=1e-6)
    assert there.covered == pytest.approx(here.covered, rel=1e-6)
    places = np.array([[0.5, 0.5, 3.0], [2.0, 1.9, -1.0], [9.0, 0.0, 0.0]])
    assert (
        moved.find_cells(places @ turn.T + far).tolist()
        == grid.find_cells(places).tolist()
        == [8, 32, -1]
    )


def test_reversed_face_winding_gives_same_areas() -> None:
    corners = wavy()
    grid = create_grid(corners.reshape(-1, 3), EAST, NORTH, 0.5)
    assert sums(measure_faces(grid, corners[:, ::-1])) == pytest.approx(
        sums(measure_faces(grid, corners))
    )


def test_an_overhang_covers_a_cell_once() -> None:
    """A sheet folded over itself: two of its three limbs face the viewer, and cover a cell once."""
    upper, lower = SQUARE.copy(), SQUARE.copy()
    upper[..., 2] = 1.0
    middle = SQUARE[:, ::-1].copy()
    middle[..., 2] = 0.5
    found = measure_faces(flat(), np.concatenate([upper, middle, lower]))
    assert found.covered == pytest.approx(np.full(12, 0.25))
    assert found.surface == pytest.approx(np.full(12, 0.5))


def test_points_represent_squares() -> None:
    y, x = np.mgrid[0:10, 0:20] * 0.1 + 0.05
    points = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3)
    found = measure_points(flat(2, 2), points, 0.1)
    assert found.surface == pytest.approx(np.full(4, 0.25))
    found = measure_points(flat(2, 2), points[points[:, 0] < 0.25], 0.1)
    assert found.covered == pytest.approx([0.1, 0.0, 0.1, 0.0])


def test_empty_and_invalid_faces_have_no_area() -> None:
    assert measure_faces(flat(), np.zeros((0, 3, 3))).surface.sum() == 0.0
    broken = SQUARE.copy()
    broken[0, 0, 0] = np.nan
    assert measure_faces(flat(), broken).covered.sum() == pytest.approx(
        measure_faces(flat(), broken[1:]).covered.sum()
    )
    point = np.zeros((1, 3, 3))
    assert measure_faces(flat(), point).surface.sum() == 0.0
    huge = SQUARE * 1e7
    assert measure_faces(flat(), huge).covered == pytest.approx(np.full(12, 0.25))


@pytest.mark.parametrize("cell", [0.0, -1.0, math.nan, math.inf, 1e-9])
def test_invalid_cell_sizes_and_too_many_cells_are_refused(cell: float) -> None:
    code = "grid.too-many-cells" if cell == 1e-9 else "grid.cell-size"
    with refused(code, GeometryError, field="cell"):
        create_grid(wavy().reshape(-1, 3), EAST, NORTH, cell)


def test_suggested_cell_size_is_accepted() -> None:
    points = wavy().reshape(-1, 3)
    with refused("grid.too-many-cells", GeometryError) as error:
        create_grid(points, EAST, NORTH, 0.001)
    least = float(str(error.value.values["minimum"]))
    assert create_grid(points, EAST, NORTH, least * 1.02).count <= 40_000
