"""The resolution of a mesh against its laws: dividing faces adds none, measuring more does."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import pyvista as pv

from vomstudio.extraction.measurable import typical_resolution
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.streaming.surfaces import create_surface
from vomstudio.io.models.opening import resolution

STEP = 0.1


def wall(count: int = 30, noise: float = 0.02, seed: int = 0) -> Mesh:
    """A wall of count x count vertices 10 cm apart, with noise across it."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[0:count, 0:count] * STEP
    z = noise * rng.standard_normal(x.shape)
    a = (np.arange(count - 1)[:, None] * count + np.arange(count - 1)).ravel()
    faces = np.concatenate(
        [
            np.stack([a, a + 1, a + count], axis=1),
            np.stack([a + 1, a + count + 1, a + count], axis=1),
        ]
    )
    return Mesh(np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1), faces.astype(np.int32))


def from_vtk(data: pv.PolyData) -> Mesh:
    return Mesh(np.asarray(data.points, np.float64), data.regular_faces.astype(np.int32))


def divided(mesh: Mesh, times: int) -> Mesh:
    """Each face in four, by VTK's linear subdivision."""
    if not times:
        return mesh
    return from_vtk(pv.make_tri_mesh(mesh.vertices, mesh.faces).subdivide(times, "linear"))


def cut_at_centroids(mesh: Mesh) -> Mesh:
    """Each face in three."""
    a, b, c = mesh.faces.T
    centre = len(mesh.vertices) + np.arange(len(mesh.faces))
    faces = np.concatenate(
        [np.stack(f, axis=1) for f in ((a, b, centre), (b, c, centre), (c, a, centre))]
    )
    places = np.concatenate([mesh.vertices, mesh.vertices[mesh.faces].mean(axis=1)])
    return Mesh(places, faces.astype(np.int32))


def near(mesh: Mesh) -> float:
    found = create_surface(mesh).local_resolution(mesh.vertices[:: len(mesh.vertices) // 20])
    assert found is not None
    return found


DOORS = pytest.mark.parametrize("door", [resolution, typical_resolution, near])


@pytest.mark.full
@DOORS
@pytest.mark.parametrize("times", [1, 2, 3])
def test_dividing_the_faces_of_a_rough_wall_leaves_its_resolution(
    door: Callable[[Mesh], float], times: int
) -> None:
    mesh = wall()
    assert door(divided(mesh, times)) == pytest.approx(door(mesh), rel=0.1)


@DOORS
def test_cutting_faces_at_their_centroids_adds_no_resolution(
    door: Callable[[Mesh], float],
) -> None:
    mesh = wall()
    assert door(cut_at_centroids(mesh)) == pytest.approx(door(mesh), rel=0.1)


@DOORS
def test_resolution_of_flat_wall_is_its_spacing(door: Callable[[Mesh], float]) -> None:
    flat = wall(noise=0.0)
    assert door(flat) == pytest.approx(STEP, rel=0.2)
    assert door(divided(flat, 2)) == pytest.approx(STEP / 4.0, rel=0.2)


@DOORS
def test_a_decimated_mesh_is_coarser(door: Callable[[Mesh], float]) -> None:
    mesh = wall(60)
    few = pv.make_tri_mesh(mesh.vertices, mesh.faces).decimate(0.75)
    assert door(from_vtk(few)) > 1.6 * door(mesh)


@pytest.mark.parametrize("times", [0, 2])
@pytest.mark.parametrize("seed", range(3))
def test_undivided_mesh_recovers_original_vertices(times: int, seed: int) -> None:
    mesh = wall(noise=0.005, seed=seed)
    fine = divided(mesh, times)
    assert (fine.undivided is fine) == (times == 0)
    assert np.array_equal(_sorted(fine.undivided.vertices), _sorted(mesh.vertices))
    assert len(fine.undivided.faces) == pytest.approx(len(mesh.faces), rel=0.1)


def _sorted(places: np.ndarray) -> np.ndarray:
    places = places.round(6) + 0.0
    return places[np.lexsort(places.T)]


@pytest.mark.parametrize("rounded", [np.float32, 4])
def test_subdivision_is_detected_in_rounded_coordinates(rounded: type | int) -> None:
    mesh = divided(wall(), 2)
    far = mesh.vertices + [430.0, 210.0, 95.0]
    written = np.round(far, rounded) if isinstance(rounded, int) else far.astype(rounded)
    found = resolution(Mesh(written.astype(np.float64), mesh.faces))
    assert found == pytest.approx(resolution(wall()), rel=0.1)


def test_duplicate_vertices_count_as_one_position() -> None:
    """As a texture's seam has it: every face has vertices of its own."""
    mesh = divided(wall(), 1)
    apart = Mesh(mesh.vertices[mesh.faces.ravel()], np.arange(mesh.faces.size).reshape(-1, 3))
    assert near(apart) == pytest.approx(near(wall()), rel=0.1)


def test_a_half_flat_wall_keeps_the_spacing_of_its_flat_half() -> None:
    mesh = wall()
    flat = mesh.vertices[:, 0] < 1.5
    mesh.vertices[flat, 2] = 0.0
    fine = create_surface(divided(mesh, 2))
    y = np.linspace(0.5, 2.4, 20)
    assert fine.local_resolution(np.stack([0.0 * y + 0.7, y, 0.0 * y], 1)) == pytest.approx(
        STEP / 4.0, rel=0.15
    )
    assert fine.local_resolution(np.stack([0.0 * y + 2.3, y, 0.0 * y], 1)) == pytest.approx(
        STEP, rel=0.15
    )


@pytest.mark.parametrize("seed", range(3))
def test_no_vertex_of_a_cube_or_a_sphere_is_left_out(seed: int) -> None:
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    for solid in (pv.Cube().triangulate().subdivide(2, "linear"), pv.Sphere()):
        mesh = from_vtk(solid)
        turned = Mesh(mesh.vertices @ turn.T, mesh.faces)
        assert turned.undivided is turned
