"""Faces and points chosen by hand, against closed forms and second libraries: what lies inside a
shape, what is seen, what grows from a click, and rings of neighbours."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from tests.messages import refused
from vomstudio.core.errors import GeometryError
from vomstudio.extraction.selection.field_values import ElementColours, select_by_value
from vomstudio.extraction.selection.neighbours import build_neighbour_graph
from vomstudio.extraction.selection.visible_region import ViewSnapshot
from vomstudio.geometry.boxes import ClipBox
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.rendering.view.camera import Camera, rotation

UTM = np.array([372_410.0, 4_709_820.0, 613.0])
HERE = np.eye(4)


def looking(*, parallel: bool = False, depth=None, clip=None) -> ViewSnapshot:
    """From 20 m in the south towards the north."""
    camera = Camera()
    camera.position = UTM + [0.0, -20.0, 0.0]
    camera.distance, camera.orthographic = 20.0, parallel
    right, up, direction = camera.frame
    half = camera.distance * camera.tangent if parallel else camera.tangent
    return ViewSnapshot(
        camera.position, right, up, direction, half, parallel, (400, 300), 1.0, depth, clip
    )


def sheet(n: int = 41, size: float = 4.0, *, y=lambda x, z: 0.0 * x) -> Mesh:
    """A grid in the plane of x and z, with y a function of both."""
    x, z = np.meshgrid(np.linspace(-size, size, n), np.linspace(-size, size, n))
    points = np.stack([x.ravel(), y(x.ravel(), z.ravel()), z.ravel()], axis=1)
    first = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    faces = np.concatenate(
        [
            np.stack([first, first + 1, first + n], axis=1),
            np.stack([first + 1, first + n + 1, first + n], axis=1),
        ]
    )
    return Mesh(points + UTM, faces.astype(np.int32))


def joined(*meshes: Mesh) -> Mesh:
    """Beside each other, none of their vertices shared."""
    starts = np.cumsum([0, *(len(m.vertices) for m in meshes)])
    faces = [m.faces + start for m, start in zip(meshes, starts, strict=False)]
    return Mesh(
        np.concatenate([m.vertices for m in meshes]), np.concatenate(faces).astype(np.int32)
    )


def centres(mesh: Mesh) -> np.ndarray:
    return mesh.vertices[mesh.faces].mean(axis=1)


# --- inside a shape --------------------------------------------------------------------------
@pytest.mark.parametrize("parallel", [False, True])
def test_elements_inside_outline_match_shapely(parallel):
    mesh, look = sheet(y=lambda x, z: 0.3 * np.sin(x) + 0.2 * z), looking(parallel=parallel)
    ring = [(90.0, 40.0), (310.0, 70.0), (200.0, 150.0), (330.0, 260.0), (60.0, 230.0)]
    result = look.inside(mesh, HERE, look.outline_mask(ring), is_through=True)
    camera = Camera()
    camera.position, camera.distance = look.position, 20.0
    camera.orthographic = parallel
    pixels, _ = camera.project(centres(mesh), (400.0, 300.0))
    area, places = shapely.Polygon(ring), shapely.points(pixels)
    expected = shapely.contains(area, places)
    # The shape is drawn in whole pixels.
    sure = shapely.distance(area.exterior, places) > 1.5
    assert 300 < expected.sum() < len(result)
    assert (result == expected)[sure].all()
    assert sure.mean() > 0.95


def test_selection_in_transformed_model_matches_view():
    mesh, look = sheet(), looking()
    shape = look.outline_mask([(100.0, 100.0), (300.0, 100.0), (300.0, 200.0), (100.0, 200.0)])
    expected = look.inside(mesh, HERE, shape, is_through=True)
    to_world = np.eye(4)
    to_world[:3, :3] = 0.01 * rotation(np.array([0.0, 0.0, 1.0]), 30.0)
    to_world[:3, 3] = UTM
    back = np.linalg.inv(to_world)
    own = Mesh(mesh.vertices @ back[:3, :3].T + back[:3, 3], mesh.faces)
    result = look.inside(own, to_world, shape, is_through=True)
    assert (result != expected).sum() <= 2


def test_only_visible_side_of_sphere_is_selected():
    """Of a sphere seen in parallel from afar that is the half that faces the viewer."""
    points = np.random.default_rng(1).normal(size=(40_000, 3))
    points *= 3.0 / np.linalg.norm(points, axis=1)[:, None]
    look = looking(parallel=True)
    column, row = np.meshgrid(np.arange(400) + 0.5, np.arange(300) + 0.5)
    x, z = (column - 200.0) / look.scale, (150.0 - row) / look.scale
    with np.errstate(invalid="ignore"):
        depth = 20.0 - np.sqrt(9.0 - x * x - z * z)
    look = looking(parallel=True, depth=np.nan_to_num(depth, nan=np.inf).astype(np.float32))
    whole = look.outline_mask([(0.0, 0.0), (400.0, 0.0), (400.0, 300.0), (0.0, 300.0)])
    cloud = PointCloud(points + UTM)
    seen = look.inside(cloud, HERE, whole, is_through=False)
    off = points[:, 1] / 3.0
    assert seen[off < -0.2].mean() > 0.999
    assert not seen[off > 0.2].any()
    assert look.inside(cloud, HERE, whole, is_through=True).all()


def test_clipped_and_hidden_elements_are_not_selected():
    mesh = joined(sheet(), Mesh(sheet().vertices - [0.0, 40.0, 0.0], sheet().faces))
    box = ClipBox(tuple(UTM - 10.0), tuple(UTM + [0.0, 10.0, 10.0]))
    look = looking(clip=box)
    whole = look.outline_mask([(0.0, 0.0), (400.0, 0.0), (400.0, 300.0), (0.0, 300.0)])
    result = look.inside(mesh, HERE, whole, is_through=True)
    half = len(result) // 2
    assert not result[half:].any()
    assert (result[:half] == (centres(mesh)[:half, 0] <= UTM[0])).all()


def test_line_outline_and_nan_points_select_nothing():
    look = looking()
    assert not look.outline_mask([(0.0, 0.0), (200.0, 200.0)]).any()
    cloud = PointCloud(np.array([UTM, UTM * np.nan]))
    whole = look.outline_mask([(0.0, 0.0), (400.0, 0.0), (400.0, 300.0), (0.0, 300.0)])
    assert look.inside(cloud, HERE, whole, is_through=True).tolist() == [True, False]


# --- growing on meshes -----------------------------------------------------------------------
def fold(n: int = 41) -> Mesh:
    """Two planes that meet at 40 degrees along x = 0."""
    return sheet(n, y=lambda x, z: np.where(x > 0.0, np.tan(np.radians(40.0)) * x, 0.0))


def test_piece_ends_at_fold_of_surface():
    mesh = fold()
    x = centres(mesh)[:, 0] - UTM[0]
    seed = int(np.argmin(np.abs(centres(mesh) - UTM - [-2.0, 0.0, 0.0]).sum(axis=1)))
    piece = build_neighbour_graph(mesh, 0.0).piece(
        seed, angle_deg=15.0, distance=0.05, is_excluded=None
    )
    assert not piece.is_truncated
    assert piece.mask.sum() == piece.count
    # Normals are averaged over those who share a corner, so one row at the edge may go either way.
    assert piece.mask[x < -0.3].all()
    assert not piece.mask[x > 0.2].any()


def test_a_piece_is_the_connected_component_that_scipy_finds():
    """Of a plane of which three faces in ten are left out."""
    mesh = sheet(61)
    n = len(mesh.faces)
    left_out = np.random.default_rng(5).random(n) < 0.3
    corners = np.sort(mesh.faces, axis=1)
    edges = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [0, 2]]])
    face = np.tile(np.arange(n), 3)
    order = np.lexsort(edges.T)
    same = (np.diff(edges[order], axis=0) == 0).all(axis=1)
    a, b = face[order][:-1][same], face[order][1:][same]
    both = ~left_out[a] & ~left_out[b]
    graph = coo_array((np.ones(both.sum()), (a[both], b[both])), (n, n))
    label = connected_components(graph, directed=False)[1]
    near = build_neighbour_graph(mesh, 0.0)
    sizes = []
    for seed in np.flatnonzero(~left_out)[::400]:
        piece = near.piece(int(seed), angle_deg=20.0, distance=0.01, is_excluded=left_out)
        assert np.array_equal(piece.mask, label == label[seed])
        sizes.append(piece.count)
    assert min(sizes) < n // 10 < max(sizes)


def test_rotating_model_gives_same_piece():
    mesh = fold()
    turn = rotation(np.array([0.3, 0.2, np.sqrt(0.87)]), 30.0)
    turned = Mesh((mesh.vertices - UTM) @ turn.T + UTM, mesh.faces)
    expected = {"angle_deg": 15.0, "distance": 0.05, "is_excluded": None}
    one = build_neighbour_graph(mesh, 0.0).piece(300, **expected)
    other = build_neighbour_graph(turned, 0.0).piece(300, **expected)
    assert np.array_equal(one.mask, other.mask)


def test_piece_limits_can_select_one_element_or_all():
    rough = sheet(y=lambda x, z: np.random.default_rng(2).normal(0.0, 0.3, len(x)))
    near = build_neighbour_graph(rough, 0.0)
    assert near.piece(500, angle_deg=1.0, distance=1e-9, is_excluded=None).count == 1
    assert near.piece(500, angle_deg=90.0, distance=1e3, is_excluded=None).mask.all()
    left_out = np.zeros(len(rough.faces), np.bool_)
    left_out[centres(rough)[:, 0] > UTM[0]] = True
    seed = int(np.flatnonzero(~left_out)[0])
    piece = near.piece(seed, angle_deg=90.0, distance=1e3, is_excluded=left_out)
    assert np.array_equal(piece.mask, ~left_out)


def test_piece_crosses_seams_and_triple_edges_but_not_gaps():
    """Two halves of a plane with vertices of their own at the seam, a third sheet that stands on
    it (so that an edge has three faces), and an island in the same plane."""
    flat = sheet(21)
    left = flat.faces[centres(flat)[:, 0] < UTM[0]]
    right = flat.faces[centres(flat)[:, 0] > UTM[0]]
    z = np.linspace(-4.0, 4.0, 21)
    foot = np.stack([0.0 * z, 0.0 * z, z], axis=1)
    wall = np.concatenate([foot, foot + [0.0, 1.0, 0.0]])
    first = np.arange(20)
    low = np.stack([first, first + 1, first + 21], axis=1)
    faces = np.concatenate([low, np.stack([first + 1, first + 22, first + 21], axis=1)])
    island = Mesh(flat.vertices + [20.0, 0.0, 0.0], flat.faces)
    mesh = joined(
        Mesh(flat.vertices, left), Mesh(flat.vertices, right), Mesh(wall + UTM, faces), island
    )
    piece = build_neighbour_graph(mesh, 0.0).piece(
        0, angle_deg=30.0, distance=0.01, is_excluded=None
    )
    ends = np.cumsum([len(left), len(right), len(faces), len(flat.faces)])
    halves = piece.mask[: ends[1]]
    assert halves.all()
    assert not piece.mask[ends[1] :].any()


def test_zero_area_faces_do_not_block_piece():
    flat = sheet(21)
    # Between the two halves each edge is a face of two corners in one place.
    left = flat.faces[centres(flat)[:, 0] < UTM[0]]
    right = flat.faces[centres(flat)[:, 0] > UTM[0]]
    apart = Mesh(
        np.concatenate([flat.vertices, flat.vertices]),
        np.concatenate([left, right + len(flat.vertices)]).astype(np.int32),
    )
    middle = np.flatnonzero(np.isclose(flat.vertices[:, 0], UTM[0]))
    middle = middle[np.argsort(flat.vertices[middle, 2])]
    slivers = np.stack([middle[:-1], middle[1:], middle[1:] + len(flat.vertices)], axis=1)
    mesh = Mesh(apart.vertices, np.concatenate([apart.faces, slivers]).astype(np.int32))
    near = build_neighbour_graph(mesh, 0.0)
    piece = near.piece(0, angle_deg=20.0, distance=0.01, is_excluded=None)
    assert piece.mask[: len(apart.faces)].all()
    # And one of them is no bad beginning.
    begun = near.piece(len(mesh.faces) - 1, angle_deg=20.0, distance=0.01, is_excluded=None)
    assert begun.mask[: len(apart.faces)].all()


def test_mesh_of_only_slivers_gives_one_element():
    mesh = Mesh(np.zeros((3, 3)) + UTM, np.array([[0, 1, 2]], np.int32))
    assert (
        build_neighbour_graph(mesh, 0.0)
        .piece(0, angle_deg=20.0, distance=1.0, is_excluded=None)
        .count
        == 1
    )
    with refused("model.no-faces", GeometryError):
        build_neighbour_graph(Mesh(np.zeros((3, 3)), np.zeros((0, 3), np.int32)), 0.0)


# --- growing on clouds -----------------------------------------------------------------------
def corner_cloud(count: int = 30_000, seed: int = 3) -> tuple[PointCloud, np.ndarray]:
    """A wall and a floor that meet at right angles, with 2 mm of noise; which is the wall."""
    rng = np.random.default_rng(seed)
    u, v = rng.uniform(0.0, 3.0, (2, count))
    off = rng.normal(0.0, 0.002, count)
    wall = np.arange(count) < count // 2
    points = np.where(wall[:, None], np.stack([u, off, v], 1), np.stack([u, -v, off], 1))
    return PointCloud(points + UTM), wall


SPACING = float(np.sqrt(18.0 / 30_000))


@pytest.mark.parametrize("inputs", [False, True])
def test_a_piece_of_a_cloud_ends_at_the_corner(inputs):
    cloud, wall = corner_cloud()
    if inputs:
        normals = np.where(wall[:, None], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]).astype(np.float32)
        cloud = PointCloud(cloud.points, normals=normals)
    seed = int(np.argmin(np.abs(cloud.points - UTM - [1.5, 0.0, 1.5]).sum(axis=1)))
    near = build_neighbour_graph(cloud, SPACING)
    piece = near.piece(seed, angle_deg=20.0, distance=0.01, is_excluded=None)
    height = cloud.points[:, 2] - UTM[2]
    assert piece.mask[wall & (height > 0.15)].mean() > 0.99
    away = cloud.points[:, 1] - UTM[1] < -0.1
    assert not piece.mask[away].any()
    # Again, with what is known of the normals by now, it is the same.
    again = near.piece(seed, angle_deg=20.0, distance=0.01, is_excluded=None)
    assert np.array_equal(again.mask, piece.mask)


def test_duplicate_points_and_nan_are_tolerated():
    cloud, _ = corner_cloud()
    points = np.concatenate([cloud.points, cloud.points[:5000], np.full((3, 3), np.nan)])
    near = build_neighbour_graph(PointCloud(points), SPACING)
    piece = near.piece(100, angle_deg=20.0, distance=0.01, is_excluded=None)
    # Of a place that stands twice both are taken.
    assert np.array_equal(piece.mask[:5000], piece.mask[30_000:35_000])
    assert not piece.mask[-3:].any()
    assert near.piece(len(points) - 1, angle_deg=20.0, distance=0.1, is_excluded=None).count == 0
    selection = piece.mask.copy()
    assert not near.expand(selection)[-3:].any()


def test_collinear_points_give_no_piece():
    line = np.zeros((1000, 3)) + UTM
    line[:, 0] += np.linspace(0.0, 10.0, 1000)
    near = build_neighbour_graph(PointCloud(line), 0.01)
    assert near.piece(500, angle_deg=30.0, distance=1.0, is_excluded=None).count == 0
    with refused("cloud.too-few-points", GeometryError, n=3, minimum=4):
        build_neighbour_graph(PointCloud(line[:3]), 0.01)


# --- rings -----------------------------------------------------------------------------------
def test_expanding_mesh_selection_adds_faces_that_share_a_corner():
    mesh = sheet()
    selection = np.hypot(*(centres(mesh) - UTM)[:, [0, 2]].T) < 1.5
    near = build_neighbour_graph(mesh, 0.0)
    corners = np.unique(mesh.faces[selection])
    assert np.array_equal(near.expand(selection), np.isin(mesh.faces, corners).any(axis=1))
    others = np.unique(mesh.faces[~selection])
    expected = selection & ~np.isin(mesh.faces, others).any(axis=1)
    assert np.array_equal(near.shrink(selection), expected)
    assert near.expand(np.ones_like(selection)).all()
    assert not near.shrink(np.zeros_like(selection)).any()


def test_expanding_cloud_selection_matches_search_tree():
    cloud, _ = corner_cloud()
    near = build_neighbour_graph(cloud, SPACING)
    selection = np.linalg.norm(cloud.points - UTM - [1.5, 0.0, 1.0], axis=1) < 0.8
    link = 2.0 * SPACING
    far, _ = cKDTree(cloud.points[selection]).query(cloud.points)
    assert np.array_equal(near.expand(selection), far <= link)
    out, _ = cKDTree(cloud.points[~selection]).query(cloud.points)
    assert np.array_equal(near.shrink(selection), selection & (out > link))


# --- values ----------------------------------------------------------------------------------
def test_field_range_uses_corner_means_and_wraps_at_north():
    mesh = sheet(11)
    azimuth = np.where(mesh.vertices[:, 0] < UTM[0], 350.0, 10.0)
    mesh = Mesh(mesh.vertices, mesh.faces, fields={"dip_direction": azimuth})
    height = centres(mesh)[:, 2]
    low = select_by_value(mesh, HERE, "elevation", UTM[2] - 1.0, UTM[2] + 1.0)
    assert np.array_equal(low, np.abs(height - UTM[2]) <= 1.0)
    assert select_by_value(mesh, HERE, "dip_direction", 340.0, 20.0).all()
    even = azimuth[mesh.faces].std(axis=1) == 0.0
    assert not select_by_value(mesh, HERE, "dip_direction", 20.0, 340.0)[even].any()
    cloud = PointCloud(mesh.vertices, fields={"class": np.arange(len(mesh.vertices))})
    assert select_by_value(cloud, HERE, "class", 5, 9).sum() == 5


def test_colour_selection_includes_shaded_rock_but_not_other_rock():
    rng = np.random.default_rng(4)
    sand = np.array([180, 140, 90]) + rng.integers(-6, 7, (500, 3))
    shade = np.array([150, 115, 72]) + rng.integers(-6, 7, (500, 3))
    mud = np.array([90, 95, 120]) + rng.integers(-6, 7, (500, 3))
    colours = np.concatenate([sand, shade, mud]).astype(np.uint8)
    cloud = PointCloud(rng.random((1500, 3)), colours)
    result = ElementColours(cloud).like(np.arange(100), 15.0)
    assert result[:1000].mean() > 0.98
    assert not result[1000:].any()
    with refused("model.no-colours", GeometryError):
        ElementColours(PointCloud(rng.random((5, 3))))
