"""The plane of three-dimensional traces: when there is one, and projections onto it."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from scipy.spatial.transform import Rotation

from vomstudio.core.errors import GeometryError
from vomstudio.geology.fractures.trace_plane import (
    MIN_DIP_DEG,
    TracePlane,
    find_trace_plane,
    vertices_with_heights,
)
from vomstudio.geology.orientation import Plane
from vomstudio.products.section.trace_map import curtain_from_traces, map_to_face

AT = np.array([500_000.0, 5_000_000.0, 100.0])


def traces_on_plane(plane: Plane, n: int = 40, seed: int = 1) -> list[np.ndarray]:
    """Return straight isotropic traces, 1 to 5 m long, on a plane through `AT`."""
    rng = np.random.default_rng(seed)
    start = rng.uniform(-10, 10, (n, 2))
    angle, length = rng.uniform(0, np.pi, n), rng.uniform(1, 5, n)
    end = start + length[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    axes = np.stack([plane.strike_vector(), 0.0 - plane.dip_vector()])
    return [np.stack([a, b]) @ axes + AT for a, b in zip(start, end, strict=True)]


def shapes_of(lines) -> np.ndarray:
    found = np.empty(len(lines), object)
    found[:] = [shapely.LineString(line) for line in lines]
    return found


@pytest.mark.parametrize("dip", [0.0, 5.0, 15.0])
def test_pavement_traces_have_no_plane(dip: float) -> None:
    assert find_trace_plane(traces_on_plane(Plane(130, dip))) is None


@pytest.mark.parametrize("dip", [30.0, 60.0, 90.0])
def test_traces_on_inclined_plane_recover_that_plane(dip: float) -> None:
    plane = find_trace_plane(traces_on_plane(Plane(130, dip)))
    assert plane is not None
    assert (plane.dip_direction_deg, plane.dip_deg) == pytest.approx((130, dip), abs=1e-6)
    assert plane.max_distance_m == pytest.approx(0, abs=1e-6)
    assert plane.shortening_percent == pytest.approx(0, abs=1e-7)


def test_rough_pavement_has_no_plane_at_any_vertex_density() -> None:
    rng = np.random.default_rng(3)
    dense = []
    for a, b in traces_on_plane(Plane(0, 0)):
        line = np.linspace(a, b, 200)
        line[:, 2] += rng.normal(0, 0.1, 200)  # steeper than 45 degrees from vertex to vertex
        dense.append(line)
    assert find_trace_plane(dense) is None


def test_single_row_of_traces_along_path_has_no_plane() -> None:
    """They are stacked by the slope of the path, on a plane that nothing defines."""
    rng = np.random.default_rng(4)
    steps = np.arange(0.0, 40.0, 2.0)
    lines = [
        AT + np.column_stack([[s, s + 1], rng.normal(0, 0.02, 2), 0.09 * np.array([s, s + 1])])
        for s in steps
    ]
    assert find_trace_plane(lines) is None


def test_horizontal_traces_above_each_other_have_a_plane() -> None:
    """Bedding on a cliff does not climb, and falls together on a map."""
    rng = np.random.default_rng(5)
    lines = [
        AT + np.column_stack([[x, x + 20], rng.normal(0, 0.05, 2), [z, z]])
        for x, z in zip(rng.uniform(0, 10, 9), np.linspace(0, 4, 9), strict=True)
    ]
    plane = find_trace_plane(lines)
    assert plane is not None
    assert plane.dip_deg > 85


def test_traces_on_several_walls_have_horizontal_plane_and_large_scatter() -> None:
    walls = [
        np.concatenate(traces_on_plane(Plane(azimuth, 90), 30, azimuth)).reshape(-1, 2, 3)
        for azimuth in (90, 210, 330)
    ]
    for k, wall in enumerate(walls):
        wall += 60 * np.array([math.sin(2 * k), math.cos(2 * k), 0])
    plane = find_trace_plane([line for wall in walls for line in wall])
    assert plane is not None
    assert plane.is_horizontal
    assert plane.scatter_m > 3


def test_climbing_collinear_traces_are_refused() -> None:
    lines = [AT + np.array([[s, 0, s], [s + 1, 0, s + 1]]) for s in (0.0, 2.0)]
    with pytest.raises(GeometryError) as refused:
        find_trace_plane(lines)
    assert refused.value.code == "lines.no-plane"


def test_threshold_matches_docstring() -> None:
    """Isotropic traces on a plane that dips 20 degrees climb 0.22, on a vertical one 0.64."""
    for dip, climb in ((MIN_DIP_DEG, 0.22), (90.0, 0.64)):
        lines = np.array(traces_on_plane(Plane(40, dip), 20_000))
        rise = np.abs(lines[:, 1, 2] - lines[:, 0, 2]).sum()
        assert rise / np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1).sum() == pytest.approx(
            climb, abs=0.01
        )


@pytest.mark.parametrize("attitude", [(130, 55), (250, 90), (10, 0), (300, 89.5)])
def test_projections_keep_lengths_and_agree_with_the_window(attitude: tuple[float, float]) -> None:
    lines = traces_on_plane(Plane(*attitude))
    plane = TracePlane.from_attitude(Plane(*attitude), lines)
    flat = plane.project(shapes_of(lines))
    lengths = [np.linalg.norm(b - a) for a, b in lines]
    assert shapely.length(flat) == pytest.approx(lengths, rel=1e-9)
    if plane.is_horizontal:
        return
    for line, mapped in zip(
        flat, map_to_face(lines, curtain_from_traces(lines, Plane(*attitude))), strict=True
    ):
        assert shapely.get_coordinates(line) == pytest.approx(mapped, abs=1e-6)
    # The result states how to return to World.
    back = np.array(plane.origin) + shapely.get_coordinates(flat) @ np.stack(
        [plane.right, plane.up]
    )
    assert back == pytest.approx(np.concatenate(lines), abs=1e-6)


def test_equal_points_stay_equal_after_projection() -> None:
    """Joins and repeats are recognised by exact coordinates."""
    lines = traces_on_plane(Plane(123.4, 67.8))
    plane = TracePlane.from_attitude(Plane(123.4, 67.8), lines)
    alone = [plane.coordinates(line) for line in lines]
    assert (plane.coordinates(np.concatenate(lines)) == np.concatenate(alone)).all()


def test_map_window_is_projected_onto_slope_and_refused_on_wall() -> None:
    slope = TracePlane.from_attitude(Plane(90, 60), [np.array([AT])])
    square = np.array([shapely.box(*(AT[:2] - 1), *(AT[:2] + 1))], object)
    assert shapely.area(slope.project_window(square, "area", (90, 110)))[0] == pytest.approx(8)
    at_zero = shapely.force_3d(square, 0.0)
    assert shapely.area(slope.project_window(at_zero, "area", (90, 110)))[0] == pytest.approx(8)
    x, y, radius = slope.project_circle((AT[0] + 1, AT[1], 5.0))
    assert (x, y, radius) == pytest.approx((0, -2, 5), abs=1e-6)
    wall = TracePlane.from_attitude(Plane(90, 85), [np.array([AT])])
    level = np.array([shapely.LineString([AT, AT + [0, 10, 0]])], object)
    for shapes, option in (
        (square, "area"),
        (at_zero, "area"),
        (shapely.force_2d(level), "scanline"),
    ):
        with pytest.raises(GeometryError) as refused:
            wall.project_window(shapes, option, (90, 110))
        assert (refused.value.code, refused.value.values["option"]) == ("lines.edge-on", option)
    with pytest.raises(GeometryError):
        wall.project_circle((AT[0], AT[1], 5.0))
    assert wall.project_circle((*AT, 5.0)) == pytest.approx((0, 0, 5), abs=1e-6)
    # A level scanline at the height of the traces has its height; one across the wall no length.
    assert shapely.length(wall.project_window(level, "scanline", (90, 110)))[0] == pytest.approx(10)
    across = np.array([shapely.LineString([AT, AT + [10, 0, 0.1]])], object)
    with pytest.raises(GeometryError):
        wall.project_window(across, "scanline", (90, 110))


def test_an_area_with_heights_is_projected_at_right_angles() -> None:
    turn = Rotation.from_euler("x", 70, degrees=True)
    corners = turn.apply([[0, 0, 0], [4, 0, 0], [4, 3, 0], [0, 3, 0]]) + AT
    plane = TracePlane.from_attitude(Plane(180, 70), [corners])
    shape = np.array([shapely.Polygon(corners)], object)
    assert shapely.area(plane.project_window(shape, "area", (0, 0)))[0] == pytest.approx(12)


def test_vertices_leave_out_rings_and_report_lines_without_heights() -> None:
    shapes = np.array(
        [
            shapely.LineString([(0, 0, 1), (1, 0, 2)]),
            shapely.LineString([(0, 0), (1, 0)]),
            shapely.LineString([(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 0)]),
            shapely.Point(0, 0, 0),
            shapely.LineString([(0, 0, 1), (0, 0, 5)]),  # vertical: the same place on a map
            None,
        ],
        object,
    )
    lines, without = vertices_with_heights(shapes)
    assert [line.tolist() for line in lines] == [[[0, 0, 1], [1, 0, 2]], [[0, 0, 1], [0, 0, 5]]]
    assert without.tolist() == [False, True, False, False, False, False]
