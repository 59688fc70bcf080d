"""The brush: what lies in a ball and hangs together with what was hit."""

from __future__ import annotations

import numpy as np
import pytest

from vomstudio.geometry.brush import CloudSurface, MeshSurface
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.streaming.surfaces import surface_of

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


@pytest.mark.parametrize("radius", [0.01, 0.11, 0.35, 1.3, 9.0])
def test_the_brush_takes_what_its_definition_says(radius):
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
                    got = surface.within(face, centre, radius)
                    assert got.tolist() == expected, (name, face)


def test_of_two_sheets_a_centimetre_apart_the_brush_takes_one():
    """20 000 faces 2 cm wide in two sheets, a brush of half a metre."""
    lower, upper = grid(101, 2.0, rough=0.001), grid(101, 2.0, z=0.01, rough=0.001, seed=1)
    mesh = together(lower, upper)
    for sheet, first in enumerate((0, len(lower.faces))):
        face = first + len(lower.faces) // 4
        for surface in brushes(mesh):
            got = surface.within(face, centre_of(mesh, face), 0.5)
            assert len(got) > 1000
            assert (got // len(lower.faces) == sheet).all()


def test_of_two_sheets_of_points_a_centimetre_apart_the_brush_takes_one():
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
                got = surface.within(index, points[index], 0.1)
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
            surface.within(face, centre_of(whole, face), radius).tolist()
            == MeshSurface(whole).within(face, centre_of(whole, face), radius).tolist()
        )


def test_the_brush_goes_with_the_rock():
    """Turned and moved, the same faces are taken."""
    mesh = grid(rough=0.02)
    turn = np.linalg.qr(np.random.default_rng(1).standard_normal((3, 3)))[0]
    other = moved(mesh, turn, np.array([3.0, -2.0, 5.0]))
    for face in (5, 900):
        a = MeshSurface(mesh).within(face, centre_of(mesh, face), 0.61)
        b = MeshSurface(other).within(face, centre_of(other, face), 0.61)
        assert a.tolist() == b.tolist()


def test_a_brush_smaller_than_a_face_takes_the_face():
    mesh = grid(5, 40.0)
    for surface in brushes(mesh):
        assert surface.within(3, mesh.vertices[mesh.faces[3]][0], 0.1).tolist() == [3]
    cloud = CloudSurface(PointCloud(mesh.vertices))
    assert cloud.within(3, mesh.vertices[3], 0.1).tolist() == [3]


def test_area_border_and_normal_of_a_square():
    mesh = moved(grid(11, 1.0), np.eye(3), UTM)
    surface = surface_of(mesh)
    surface.build()
    every = np.arange(surface.count)
    assert surface.area_of(every) == pytest.approx(1.0)
    edges = surface.border(every)
    assert np.linalg.norm(edges[:, 0] - edges[:, 1], axis=1).sum() == pytest.approx(4.0)
    assert split_border(mesh) == pytest.approx(4.0)
    normal = surface.normal_near(0, centre_of(mesh, 0), 0.3)
    assert abs(normal[2]) == pytest.approx(1.0)


def split_border(mesh: Mesh) -> float:
    surface = MeshSurface(split(mesh))
    edges = surface.border(np.arange(surface.count))
    return float(np.linalg.norm(edges[:, 0] - edges[:, 1], axis=1).sum())


@pytest.mark.slow
def test_a_step_on_a_large_model_takes_some_milliseconds():
    import time

    n = 1600
    mesh = grid(n, 16.0, rough=0.003)
    surface = MeshSurface(mesh)
    surface.build()
    face = len(mesh.faces) // 4
    surface.within(face, centre_of(mesh, face), 0.3)
    best = np.inf
    for _ in range(10):
        started = time.perf_counter()
        got = surface.within(face, centre_of(mesh, face), 0.3)
        best = min(best, time.perf_counter() - started)
    assert len(got) > 5000
    assert best < 0.02
