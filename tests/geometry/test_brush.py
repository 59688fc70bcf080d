"""The brush: what lies in a ball and hangs together with what was hit."""

from __future__ import annotations

import numpy as np
import pytest

from tests.tiers import first_in_default_tier
from vomstudio.geometry.brush import CloudSurface, MeshSurface
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.streaming.surfaces import create_surface

UTM = np.array([465_123.0, 4_612_345.0, 820.0])


def grid(n: int = 40, size: float = 4.0, z: float = 0.0, rough: float = 0.0, seed: int = 0) -> Mesh:
    """(n - 1)^2 squares of two triangles each."""
    x = np.linspace(0.0, size, n)
    u, v = np.meshgrid(x, x)
    w = z + rough * np.random.default_rng(seed).standard_normal(u.shape)
    i = np.arange(n * n).reshape(n, n)
    a, b, c, d = (k.ravel() for k in (i[:-1, :-1], i[:-1, 1:], i[1:, :-1], i[1:, 1:]))
    faces = np.concatenate([np.stack([a, b, d], 1), np.stack([a, d, c], 1)]).astype(np.int32)
    return Mesh(np.stack([u.ravel(), v.ravel(), w.ravel()], 1), faces)


def together(*meshes: Mesh) -> Mesh:
    starts = np.cumsum([0, *(len(m.vertices) for m in meshes)])
    return Mesh(
        np.concatenate([m.vertices for m in meshes]),
        np.concatenate([m.faces + s for m, s in zip(meshes, starts, strict=False)]).astype(
            np.int32
        ),
    )


def moved(mesh: Mesh, turn: np.ndarray, shift: np.ndarray) -> Mesh:
    return Mesh(mesh.vertices @ turn.T + shift, mesh.faces)


def split(mesh: Mesh, seed: int = 0) -> Mesh:
    """The same triangles without any vertex in common, as seams of a texture may leave them."""
    order = np.random.default_rng(seed).permutation(3 * len(mesh.faces))
    faces = np.empty(3 * len(mesh.faces), np.int32)
    faces[order] = np.arange(len(faces))
    vertices = np.empty((len(faces), 3))
    vertices[faces] = mesh.vertices[mesh.faces.ravel()]
    return Mesh(vertices, faces.reshape(-1, 3))


def plainly(mesh: Mesh, index: int, centre: np.ndarray, radius: float) -> list[int]:
    """The definition, face by face, with places for corners."""
    corners = mesh.vertices[mesh.faces]
    inside = np.linalg.norm(corners.mean(axis=1) - centre, axis=1) <= radius
    inside[index] = True
    faces_at: dict[tuple, list[int]] = {}
    for face in np.flatnonzero(inside):
        for corner in corners[face]:
            faces_at.setdefault(tuple(corner), []).append(int(face))
    found, waiting = {index}, [index]
    while waiting:
        for corner in corners[waiting.pop()]:
            for face in faces_at[tuple(corner)]:
                if face not in found:
                    found.add(face)
                    waiting.append(face)
    return sorted(found)


def centre_of(mesh: Mesh, face: int) -> np.ndarray:
    return mesh.vertices[mesh.faces[face]].mean(axis=0)


def brushes(mesh: Mesh) -> list[MeshSurface]:
    """Before and after the search structures stand."""
    plain, built = MeshSurface(mesh), MeshSurface(mesh)
    built.build()
    return [plain, built]


@pytest.mark.parametrize("radius", first_in_default_tier([0.01, 0.11, 0.35, 1.3, 9.0], 2))
def test_brush_selection_matches_brute_force(radius):
    rough = grid(rough=0.03)
    shapes = {
        "grid": rough,
        "split": split(rough),
        "two walls": together(rough, grid(z=0.2, rough=0.03, seed=1)),
        "coarse beside fine": together(grid(4), moved(grid(40), np.eye(3), np.array([4.0, 0, 0]))),
    }
    for name, mesh in shapes.items():
        mesh = moved(mesh, np.eye(3), UTM)
        for face in (0, 777 % len(mesh.faces), len(mesh.faces) // 2 + 19):
            centre = centre_of(mesh, face)
            expected = plainly(mesh, face, centre, radius)
            for surface in brushes(mesh):
                for _ in range(2):
                    # Nothing of an earlier answer stays behind.
                    got = surface.connected_ids_in_ball(face, centre, radius)
                    assert got.tolist() == expected, (name, face)


def test_brush_selects_one_of_two_sheets_a_centimetre_apart():
    """20 000 faces 2 cm wide in two sheets, a brush of half a metre."""
    lower, upper = grid(101, 2.0, rough=0.001), grid(101, 2.0, z=0.01, rough=0.001, seed=1)
    mesh = together(lower, upper)
    for sheet, first in enumerate((0, len(lower.faces))):
        face = first + len(lower.faces) // 4
        for surface in brushes(mesh):
            got = surface.connected_ids_in_ball(face, centre_of(mesh, face), 0.5)
            assert len(got) > 1000
            assert (got // len(lower.faces) == sheet).all()


def test_brush_selects_one_of_two_point_sheets_a_centimetre_apart():
    """3 mm between the points, on a grid and at random."""
    rng = np.random.default_rng(0)
    n = 200
    steps = np.arange(n) * 0.003
    for flat in (
        np.stack(np.meshgrid(steps, steps), -1).reshape(-1, 2),
        rng.uniform(0.0, n * 0.003, (n * n, 2)),
    ):
        sheets = [
            np.column_stack([flat, z + 0.0003 * rng.standard_normal(n * n)]) for z in (0.0, 0.01)
        ]
        points = np.concatenate(sheets) + UTM
        for built in (False, True):
            surface = CloudSurface(PointCloud(points))
            if built:
                surface.build()
            for sheet in (0, 1):
                index = sheet * n * n + n * n // 2 + n // 2
                ball = np.linalg.norm(points - points[index], axis=1) <= 0.1
                got = surface.connected_ids_in_ball(index, points[index], 0.1)
                assert (got // (n * n) == sheet).all()
                own = np.flatnonzero(ball)
                own = own[own // (n * n) == sheet]
                assert len(got) > 0.99 * len(own)


@pytest.mark.parametrize("radius", [0.2, 0.7])
def test_a_seam_of_the_texture_does_not_stop_the_brush(radius):
    whole = grid(rough=0.02)
    face = 700
    for surface in brushes(split(whole)):
        assert (
            surface.connected_ids_in_ball(face, centre_of(whole, face), radius).tolist()
            == MeshSurface(whole)
            .connected_ids_in_ball(face, centre_of(whole, face), radius)
            .tolist()
        )


def test_brush_selection_is_invariant_to_rotation_and_translation():
    """Turned and moved, the same faces are taken."""
    mesh = grid(rough=0.02)
    turn = np.linalg.qr(np.random.default_rng(1).standard_normal((3, 3)))[0]
    other = moved(mesh, turn, np.array([3.0, -2.0, 5.0]))
    for face in (5, 900):
        a = MeshSurface(mesh).connected_ids_in_ball(face, centre_of(mesh, face), 0.61)
        b = MeshSurface(other).connected_ids_in_ball(face, centre_of(other, face), 0.61)
        assert a.tolist() == b.tolist()


def test_brush_smaller_than_a_face_selects_the_face():
    mesh = grid(5, 40.0)
    for surface in brushes(mesh):
        assert surface.connected_ids_in_ball(3, mesh.vertices[mesh.faces[3]][0], 0.1).tolist() == [
            3
        ]
    cloud = CloudSurface(PointCloud(mesh.vertices))
    assert cloud.connected_ids_in_ball(3, mesh.vertices[3], 0.1).tolist() == [3]


def test_square_selection_has_expected_area_border_and_normal():
    mesh = moved(grid(11, 1.0), np.eye(3), UTM)
    surface = create_surface(mesh)
    surface.build()
    every = np.arange(surface.count)
    assert surface.selected_area(every) == pytest.approx(1.0)
    edges = surface.border(every)
    assert np.linalg.norm(edges[:, 0] - edges[:, 1], axis=1).sum() == pytest.approx(4.0)
    assert split_border(mesh) == pytest.approx(4.0)
    normal = surface.local_normal(0, centre_of(mesh, 0), 0.3)
    assert abs(normal[2]) == pytest.approx(1.0)


def split_border(mesh: Mesh) -> float:
    surface = MeshSurface(split(mesh))
    edges = surface.border(np.arange(surface.count))
    return float(np.linalg.norm(edges[:, 0] - edges[:, 1], axis=1).sum())


@pytest.mark.slow
def test_brush_step_on_large_model_takes_under_20_milliseconds():
    import time

    n = 1600
    mesh = grid(n, 16.0, rough=0.003)
    surface = MeshSurface(mesh)
    surface.build()
    face = len(mesh.faces) // 4
    surface.connected_ids_in_ball(face, centre_of(mesh, face), 0.3)
    best = np.inf
    for _ in range(10):
        started = time.perf_counter()
        got = surface.connected_ids_in_ball(face, centre_of(mesh, face), 0.3)
        best = min(best, time.perf_counter() - started)
    assert len(got) > 5000
    assert best < 0.02


@pytest.fixture(params=[None, 100], ids=["at once", "in pieces"])
def pieces(request, monkeypatch):
    """Large models are searched a piece at a time while nothing has been built."""
    if request.param:
        monkeypatch.setattr("vomstudio.geometry.brush.BLOCK_SIZE", request.param)
        monkeypatch.setattr("vomstudio.geometry.surface.BLOCK_SIZE", request.param)


@pytest.mark.parametrize(
    "shift", [(0.0, 0.0, 0.0), (-1e3, 5e2, 3e3), (7e5, -4e2, -90.0), (-5.0, -6.0, -7.0)]
)
def test_brush_selection_does_not_depend_on_model_position_or_seams(pieces, shift):
    """A seam would stop it where the corners at one place were not found again."""
    whole = moved(grid(16, 4.0, rough=0.03), np.eye(3), np.array(shift))
    seamed = split(whole)
    for face in (3, 200, 440):
        centre = centre_of(whole, face)
        for radius in (0.3, 1.1):
            expected = plainly(whole, face, centre, radius)
            for surface in (*brushes(whole), *brushes(seamed)):
                assert surface.connected_ids_in_ball(face, centre, radius).tolist() == expected


def test_brush_reaches_large_faces_through_shared_corners(pieces):
    """Small faces around a fan of large ones, whose other ends the ball does not hold."""
    fan = np.linspace(0.0, 2.0 * np.pi, 9)[:-1]
    inner, outer = (r * np.column_stack([np.cos(fan), np.sin(fan), 0 * fan]) for r in (0.3, 1.6))
    points = np.concatenate([[[0.0, 0, 0]], inner, outer])
    faces = []
    for k in range(8):
        a, b = 1 + k, 1 + (k + 1) % 8
        faces += [[0, a, b], [a, b, a + 8], [b, b + 8, a + 8]]
    mesh = Mesh(points, np.array(faces, np.int32))
    for radius in (0.1, 0.6, 0.8, 0.95, 1.3):
        expected = plainly(mesh, 0, centre_of(mesh, 0), radius)
        for surface in (*brushes(mesh), *brushes(split(mesh))):
            assert surface.connected_ids_in_ball(0, centre_of(mesh, 0), radius).tolist() == expected


def points_plainly(points: np.ndarray, index: int, centre: np.ndarray, radius: float) -> list[int]:
    """The points of the ball that hang together within 1.8 mean spacings: so many points as lie
    around the one that was hit share the disc that they fill."""
    ids = np.flatnonzero(np.linalg.norm(points - centre, axis=1) <= radius)
    ids = np.union1d(ids, [index])
    near = np.sort(np.linalg.norm(points[ids] - points[index], axis=1))[:17]
    reach = 1.8 * near[-1] * np.sqrt(np.pi / max(len(near) - 1, 1))
    found, waiting = {index}, [index]
    while waiting:
        off = np.linalg.norm(points[ids] - points[waiting.pop()], axis=1)
        for other in ids[off <= reach].tolist():
            if other not in found:
                found.add(other)
                waiting.append(other)
    return sorted(found)


@pytest.mark.parametrize("radius", [0.02, 0.15, 0.4, 3.0])
def test_brush_on_cloud_selects_connected_points(pieces, radius):
    rng = np.random.default_rng(2)
    flat = rng.uniform(0.0, 1.0, (900, 2))
    flat = flat[np.abs(flat[:, 0] - 0.6) > 0.08]  # a gap
    points = np.column_stack([flat, 0.002 * rng.standard_normal(len(flat))]) + UTM
    plain, built = CloudSurface(PointCloud(points)), CloudSurface(PointCloud(points))
    built.build()
    for index in (0, 100, 333, 600):
        for off in (0.0, 0.1):
            centre = points[index] + [off, 0.0, 0.0]
            expected = points_plainly(points, index, centre, radius)
            assert plain.connected_ids_in_ball(index, centre, radius).tolist() == expected
            assert built.connected_ids_in_ball(index, centre, radius).tolist() == expected


def test_coincident_points_are_connected():
    points = np.concatenate([np.zeros((40, 3)), [[5.0, 0, 0]]])
    surface = CloudSurface(PointCloud(points))
    assert surface.connected_ids_in_ball(3, points[3], 0.1).tolist() == list(range(40))


def test_point_surface_reports_ids_points_and_no_area():
    points = np.random.default_rng(1).normal(size=(30, 3))
    surface = create_surface(PointCloud(points))
    assert (surface.element, surface.count) == ("point", 30)
    ids = np.array([3, 7, 8])
    assert np.array_equal(surface.corners(ids), points[ids])
    found, weights = surface.weighted_points(ids)
    assert np.array_equal(found, points[ids])
    assert weights is None
    assert surface.selected_area(ids) is None
    assert surface.border(ids).shape == (0, 2, 3)


@pytest.mark.parametrize("built", [False, True])
def test_local_normal_uses_the_ball_or_falls_back_to_the_face(built):
    """Before the tree is there, and where a ball holds too little, a face has a normal itself."""
    mesh = moved(grid(30, 3.0, rough=0.05), np.eye(3), UTM)
    surface = MeshSurface(mesh)
    if built:
        surface.build()
    face = 700
    a, b, c = mesh.vertices[mesh.faces[face]]
    own = np.cross(b - a, c - a) / np.linalg.norm(np.cross(b - a, c - a))
    assert abs(surface.local_normal(face, centre_of(mesh, face), 1e-3) @ own) == pytest.approx(1.0)
    wide = surface.local_normal(face, centre_of(mesh, face), 0.8)
    if built:
        assert abs(wide[2]) > 0.99 > abs(own[2])
    else:
        assert abs(wide @ own) == pytest.approx(1.0)
    flat = Mesh(np.zeros((3, 3)), np.array([[0, 1, 2]], np.int32))
    assert MeshSurface(flat).local_normal(0, np.zeros(3), 1.0) is None


def test_border_consists_of_edges_used_by_one_selected_face():
    """Against counting every edge by its ends."""
    mesh = grid(12, 3.0, rough=0.1)
    rng = np.random.default_rng(4)
    for ids in (np.array([5]), np.sort(rng.choice(len(mesh.faces), 60, replace=False))):
        count: dict[frozenset[tuple[float, ...]], int] = {}
        for corners in mesh.vertices[mesh.faces[ids]].tolist():
            for k in range(3):
                edge = frozenset((tuple(corners[k]), tuple(corners[(k + 1) % 3])))
                count[edge] = count.get(edge, 0) + 1
        wanted = {edge for edge, times in count.items() if times == 1}
        for surface in (MeshSurface(mesh), MeshSurface(split(mesh))):
            found = surface.border(ids).tolist()
            assert {frozenset(map(tuple, edge)) for edge in found} == wanted
            assert len(found) == len(wanted)
    assert MeshSurface(mesh).border(np.zeros(0, np.int64)).shape == (0, 2, 3)
