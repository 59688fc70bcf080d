"""Elevation models against surfaces whose heights are known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import LinearNDInterpolator
from scipy.spatial import Delaunay

from tests.messages import refused
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import UsageError
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.products.elevation import heights as drawing
from vomstudio.products.elevation.contours import contour_lines
from vomstudio.products.elevation.heights import compute_heights
from vomstudio.products.elevation.planning import HeightPlan, plan_heights
from vomstudio.products.elevation.shading import compute_dips, hillshade

LEVEL = Plane(0.0, 0.0)
UTM = np.array([576_700.0, 5_188_150.0, 160.0])
PLANES = (LEVEL, Plane(130.0, 0.04), Plane(37.0, 52.0), Plane(200.0, 90.0))


def plan_of(data, plane=LEVEL, gsd=None) -> HeightPlan:  # type: ignore[no-untyped-def]
    return plan_heights(data, plane, to_world=np.eye(4), gsd=gsd)


def centres(plan: HeightPlan, heights: np.ndarray) -> np.ndarray:
    """World points of the cells that have a height."""
    rows, columns = np.nonzero(np.isfinite(heights))
    z = heights[rows, columns].astype(np.float64)
    pixel = np.stack([columns + 0.5, rows + 0.5, z, np.ones(len(z))])
    return np.asarray((plan.cell_to_world @ pixel).T[:, :3])


def grid_mesh(surface, n: int = 60, size: float = 10.0) -> Mesh:  # type: ignore[no-untyped-def]
    g = np.linspace(0, size, n)
    x, y = np.meshgrid(g, g)
    i = np.arange(n * n).reshape(n, n)
    a, b, c, d = (k.ravel() for k in (i[:-1, :-1], i[:-1, 1:], i[1:, :-1], i[1:, 1:]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)]).astype(np.int32)
    return Mesh(np.stack([x, y, surface(x, y)], -1).reshape(-1, 3), faces)


@pytest.mark.parametrize("plane", PLANES, ids=str)
def test_cells_are_on_the_sampled_plane(plane: Plane) -> None:
    """A tilted square of points, over any plane of reference, at the coordinates of a map."""
    rng = np.random.default_rng(0)
    s, t = rng.uniform(-5, 5, (2, 4000))
    normal = plane.normal() + [0.1, -0.2, 0.15]
    normal /= np.linalg.norm(normal)
    a = np.cross(normal, [0.3, 0.5, -0.8])
    a /= np.linalg.norm(a)
    points = UTM + s[:, None] * a + t[:, None] * np.cross(normal, a)
    plan = plan_of(PointCloud(points), plane, 0.2)
    heights, limit = compute_heights(PointCloud(points), plan)
    assert limit is not None
    assert np.isfinite(heights).mean() > 0.4
    assert np.abs((centres(plan, heights) - UTM) @ normal).max() < 2e-5
    reference = points.min(axis=0) / 2 + points.max(axis=0) / 2
    assert plan.reference == pytest.approx(reference, abs=1e-6)
    # Rows run down dip, heights along the upward normal, above the reference point.
    matrix = plan.cell_to_world
    if plane is not LEVEL:
        assert matrix[:3, 1] / 0.2 == pytest.approx(plane.dip_vector())
        at_reference = np.linalg.solve(matrix, [*reference, 1])
        assert at_reference[2] == pytest.approx(0, abs=1e-6)
    else:
        assert matrix[:3, 1] / 0.2 == pytest.approx([0, -1, 0])
        assert heights[np.isfinite(heights)].mean() == pytest.approx(160, abs=3)
    assert matrix[:3, 2] == pytest.approx(plane.normal())


def test_cloud_is_interpolated_like_in_scipy() -> None:
    rng = np.random.default_rng(3)
    xy = rng.uniform(0, 10, (3000, 2))
    z = np.sin(xy[:, 0]) + 0.3 * xy[:, 1] ** 2
    cloud = PointCloud(np.column_stack([xy, z]))
    plan = plan_of(cloud, gsd=0.1)
    heights, _ = compute_heights(cloud, plan, limit=100.0)
    at = centres(plan, heights)
    expected = LinearNDInterpolator(xy, z)(at[:, :2])
    inside = np.isfinite(expected)
    assert inside.mean() > 0.999
    assert np.abs(at[inside, 2] - expected[inside]).max() < 5e-6


def test_mesh_is_sampled_at_cell_centres() -> None:
    mesh = grid_mesh(lambda x, y: 3 + 0.4 * x - 0.2 * y)
    plan = plan_of(mesh, gsd=0.23)
    heights, limit = compute_heights(mesh, plan)
    assert limit is None
    at = centres(plan, heights)
    assert np.abs(at[:, 2] - (3 + 0.4 * at[:, 0] - 0.2 * at[:, 1])).max() < 1e-6
    width, rows = plan.grid.width, plan.grid.height
    assert heights.shape == (rows, width) == (44, 44)
    # The corner of the raster: what is left over of the last cells is shared between both sides.
    a, _, c, _, e, f = plan.transform
    assert (a, e) == (0.23, -0.23)
    assert c == pytest.approx(5 - 22 * 0.23)
    assert f == pytest.approx(5 + 22 * 0.23)


@pytest.mark.parametrize("as_cloud", [False, True])
@pytest.mark.parametrize("azimuth", [0.0, 90.0, 215.0])
def test_sheet_farthest_along_the_normal_wins(as_cloud: bool, azimuth: float) -> None:
    """A roof over half of a floor, seen from above and, the whole turned, along a horizontal."""
    plane = Plane(azimuth, 90.0)
    rng = np.random.default_rng(5)
    floor = np.column_stack([rng.uniform(-5, 5, (6000, 2)), np.zeros(6000)])
    roof = np.column_stack([rng.uniform(-5, 0, 3000), rng.uniform(-5, 5, 3000), np.full(3000, 2.0)])
    local = np.vstack([floor, roof])
    axes = np.stack([plane.strike_vector(), plane.dip_vector(), plane.normal()])
    if as_cloud:
        data: Mesh | PointCloud = PointCloud(local @ axes)
    else:
        low, high = (grid_mesh(lambda x, y, z=z: z + 0 * x, 20) for z in (0.0, 2.0))
        low, high = low.vertices - [5, 5, 0], (high.vertices - [5, 5, 0]) * [0.5, 1, 1]
        high = high - [2.5, 0, 0]
        faces = grid_mesh(lambda x, y: x, 20).faces
        data = Mesh(np.vstack([low, high]) @ axes, np.vstack([faces, faces + 400]).astype(np.int32))
    plan = plan_of(data, plane, 0.25)
    heights, _ = compute_heights(data, plan)
    at = centres(plan, heights) @ axes.T
    # Beside the edges of a cloud's roof triangles lead down to the floor.
    clear = (np.abs(at[:, 0]) > 0.6) & (np.abs(at[:, :2]) < 4.5).all(axis=1)
    expected = np.where(at[clear, 0] < 0, 2.0, 0.0)
    right = np.abs(at[clear, 2] - expected) < 1e-5
    # Of strewn points a few of the floor are left where the roof has a gap by chance.
    assert right.mean() > 0.99 if as_cloud else right.all()
    assert clear.sum() > 1000


def test_upper_of_two_curved_sheets_is_sampled() -> None:
    g = np.arange(0, 10, 0.5)
    x, y = (v.ravel() for v in np.meshgrid(g, g))
    hollow = 0.15 * ((x - 5) ** 2 + (y - 5) ** 2)
    two = np.vstack([np.column_stack([x, y, hollow]), np.column_stack([x, y, hollow - 3.0])])
    plan = plan_of(PointCloud(two), gsd=0.5)
    heights, _ = compute_heights(PointCloud(two), plan)
    at = centres(plan, heights)
    expected = 0.15 * ((at[:, 0] - 5) ** 2 + (at[:, 1] - 5) ** 2)
    assert np.abs(at[:, 2] - expected).max() < 0.02


def test_holes_are_bridged_up_to_the_limit() -> None:
    g = np.arange(0, 20, 0.25)
    x, y = (v.ravel() for v in np.meshgrid(g, g))
    hole = (np.abs(x - 10) < 2) & (np.abs(y - 10) < 2)
    cloud = PointCloud(np.column_stack([x, y, 0 * x])[~hole])
    plan = plan_of(cloud, gsd=0.25)
    open_, limit = compute_heights(cloud, plan)
    assert limit == pytest.approx(1.25, rel=0.1)
    # The hole is that of the points about it: 4 m wide, and the diagonals of its corners.
    missing = (~np.isfinite(open_)).sum() * 0.25**2
    assert missing == pytest.approx(16, abs=1.5)
    closed, _ = compute_heights(cloud, plan, limit=6.0)
    assert np.isfinite(closed).all()


@pytest.mark.parametrize("lattice", first_in_default_tier([False, True]))
def test_cells_match_the_triangulation_of_all_points(lattice: bool) -> None:
    """Qhull's triangles without those that have a side over the limit, across the seams of tiles,
    around a hole and past the edge; on a lattice four points lie on each circle."""
    rng = np.random.default_rng(7)
    if lattice:
        xy = np.array([(i, j) for i in range(140) for j in range(140)]) * 0.2
    else:
        xy = rng.uniform(0, 30, (20_000, 2)) * [1, 0.9]
    xy = xy[np.hypot(*(xy - [12, 9]).T) > 3]
    cloud = PointCloud(np.column_stack([xy, 0.2 * xy[:, 0] + 0.1 * xy[:, 1]]))
    z = cloud.points[:, 2] if lattice else np.hypot(*(xy - 15).T)
    cloud = PointCloud(np.column_stack([xy, z]))
    plan = plan_of(cloud, gsd=0.021)
    assert plan.grid.columns == plan.grid.rows == 2
    limit = 0.7
    heights, _ = compute_heights(cloud, plan, limit=limit)
    triangles = Delaunay(xy)
    corners = xy[triangles.simplices]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    rows, columns = np.indices(heights.shape)
    matrix = plan.cell_to_world
    at = np.stack([columns + 0.5, rows + 0.5], axis=-1) @ matrix[:2, :2].T + matrix[:2, 3]
    owner = triangles.find_simplex(at)
    known = (owner >= 0) & (longest[owner] <= limit)
    # An edge may fall to either side.
    assert (np.isfinite(heights) == known).mean() > 0.9999
    assert 0.02 < (~known).mean() < 0.2
    expected = LinearNDInterpolator(triangles, z)(at)
    both = np.isfinite(heights) & known
    assert np.abs(heights[both] - expected[both]).max() < 1e-4
    assert np.median(np.abs(heights[both] - expected[both])) < 1e-6


def test_cells_of_a_dense_cloud_contain_the_mean(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(7)
    xy = rng.uniform(0, 30, (20_000, 2))
    cloud = PointCloud(np.column_stack([xy, np.hypot(*(xy - 15).T)]))
    monkeypatch.setattr(drawing, "TILE_POINTS", 100)
    coarse = plan_of(cloud, gsd=0.5)
    dense, _ = compute_heights(cloud, coarse)
    at = centres(coarse, dense)
    away = np.hypot(*(at[:, :2] - 15).T)
    assert np.abs(at[:, 2] - away)[away > 1].max() < 0.12


@pytest.mark.parametrize("plane", PLANES, ids=str)
@pytest.mark.parametrize("turn", [0.0, 30.0])
def test_slope_and_aspect_are_dip_and_dip_direction_in_world(plane: Plane, turn: float) -> None:
    truth = Plane(100.0 + turn, 35.0)
    a, b = truth.strike_vector(), truth.dip_vector()
    s, t = np.random.default_rng(1).uniform(-5, 5, (2, 2000))
    cloud = PointCloud(s[:, None] * a + t[:, None] * b)
    if abs(float(plane.normal() @ truth.normal())) < 0.2:
        pytest.skip("seen edge-on")
    plan = plan_of(cloud, plane, 0.25)
    heights, _ = compute_heights(cloud, plan)
    dip, toward = compute_dips(heights, 0.25, plan.frame)
    known = np.isfinite(dip)
    assert known.sum() > 100
    assert np.abs(dip[known] - 35).max() < 1e-3
    assert np.abs(toward[known] - 100 - turn).max() < 1e-2
    assert not known[0].any()


def test_shading_is_the_cosine_of_the_angle_to_the_light() -> None:
    x, y = np.meshgrid(np.arange(8.0), np.arange(9.0))
    light = np.array([-0.5, 0.5, np.sqrt(0.5)])
    for p, q in ((0.0, 0.0), (0.7, 0.2), (-0.4, 1.1), (3.0, -3.0)):
        shade = hillshade((p * x - q * y).astype(np.float32), 1.0)
        cosine = np.array([-p, -q, 1.0]) @ light / np.sqrt(1 + p * p + q * q)
        assert set(np.unique(shade[1:-1, 1:-1])) == {round(1 + 254 * max(0.0, cosine))}
        assert not shade[0].any()


def test_contours_of_a_cone_are_circles() -> None:
    mesh = grid_mesh(lambda x, y: 10 - 2 * np.hypot(x - 5, y - 5), 200)
    plan = plan_of(mesh, gsd=0.05)
    heights, _ = compute_heights(mesh, plan)
    lines = contour_lines(heights, plan.transform, 2.0)
    closed = {level: line for level, line in lines if (line[0] == line[-1]).all()}
    assert sorted(closed) == [2.0, 4.0, 6.0, 8.0]
    for level, line in closed.items():
        assert np.abs(np.hypot(*(line - 5).T) - (10 - level) / 2).max() < 0.01
    with refused("dem.too-many-contours", UsageError, spacing_m=1e-4):
        contour_lines(heights, plan.transform, 1e-4)


def test_points_in_line_in_plan_view_are_rejected() -> None:
    line = PointCloud(np.linspace([0, 0, 0], [5, 5, 1], 50))
    with refused("dem.points-in-line"):
        compute_heights(line, plan_of(line, gsd=1.0))
    wall = PointCloud(
        np.column_stack([np.zeros(100), np.random.default_rng(0).uniform(0, 5, (100, 2))])
    )
    with refused("dem.points-in-line"):
        compute_heights(wall, plan_of(wall, gsd=1.0))
