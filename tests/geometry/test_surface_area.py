"""The area of a surface inside an outline: closed forms, and VTK's own clipping as the second."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import dblquad

from vomstudio.geometry.brush import CloudSurface, MeshSurface
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.outlines.surface_area import area_inside, clip_to_outline

SQUARE = np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])


def grid(height, size: float = 4.0, n: int = 60) -> Mesh:
    """A mesh of z = height(x, y) over a square about the origin."""
    x, y = np.meshgrid(*2 * [np.linspace(-size, size, n)], indexing="ij")
    vertices = np.stack([x, y, height(x, y) + 0.0 * x], axis=-1).reshape(-1, 3)
    i = np.arange(n * n).reshape(n, n)
    a, b, c, d = (part.ravel() for part in (i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return Mesh(vertices, faces.astype(np.int32))


def turned(mesh: Mesh, turn: np.ndarray, shift: np.ndarray) -> Mesh:
    return Mesh(mesh.vertices @ turn.T + shift, mesh.faces)


def rotation(seed: int) -> np.ndarray:
    turn, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return turn * np.sign(np.linalg.det(turn))


def corners(mesh: Mesh) -> np.ndarray:
    return mesh.vertices[mesh.faces]


@pytest.mark.parametrize("seed", range(8))
def test_a_square_on_a_tilted_plane_has_the_area_of_its_side_squared(seed):
    """However it is tilted, wherever it lies, whichever way round it was drawn."""
    rng = np.random.default_rng(seed)
    turn, shift = rotation(seed), rng.normal(size=3) * 1000.0
    side, about = rng.uniform(0.3, 3.0), rotation(seed + 100)[:2, :2]
    about, _ = np.linalg.qr(about)
    ring = 0.5 * side * SQUARE
    ring[:, :2] = ring[:, :2] @ about.T + rng.uniform(-0.7, 0.7, 2)
    ring = ring[:: 1 if seed % 2 else -1] @ turn.T + shift
    mesh = turned(grid(lambda x, y: 0.0), turn, shift)
    assert area_inside(corners(mesh), ring) == pytest.approx(side**2, rel=1e-9)


def test_rough_face_area_matches_vtk_clip():
    """A square outline is four planes, with which VTK clips exactly."""
    import pyvista

    mesh = grid(lambda x, y: 0.4 * np.sin(3.0 * x) * np.cos(2.0 * y) + 0.2 * x, n=90)
    lifted = SQUARE[:, :2]
    ring = np.array([[x, y, 0.2 * x] for x, y in lifted])
    # Laid flat, the outline's normal is that of the plane z = 0.2 x.
    normal = np.array([-0.2, 0.0, 1.0]) / np.hypot(1.0, 0.2)
    whole = pyvista.PolyData.from_regular_faces(mesh.vertices, mesh.faces)
    middle = ring.mean(axis=0)
    for one, other in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        across = np.cross(other - one, normal)
        across *= np.sign(across @ (one - middle))
        whole = whole.clip(normal=across, origin=one, invert=True)
    found = area_inside(corners(mesh), ring)
    assert found == pytest.approx(whole.area, rel=1e-6)
    assert found > 4.0 * 1.1


def test_round_outline_on_wavy_face_matches_integral():
    def height(x, y):
        return 0.3 * np.sin(2.0 * x) * np.cos(y)

    angle = np.linspace(0.0, 2.0 * np.pi, 300, endpoint=False)
    flat = 2.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    # Its corners lie in one plane, so that it is seen straight from above.
    ring = np.column_stack([flat, np.zeros(300)])

    def share(y, x):
        slope_x = 0.6 * np.cos(2.0 * x) * np.cos(y)
        slope_y = -0.3 * np.sin(2.0 * x) * np.sin(y)
        return np.sqrt(1.0 + slope_x**2 + slope_y**2)

    def edge(x):
        return np.sqrt(max(4.0 - x * x, 0.0))

    wanted, _ = dblquad(share, -2.0, 2.0, lambda x: -edge(x), edge, epsabs=1e-4)
    assert area_inside(corners(grid(height, n=300)), ring) == pytest.approx(wanted, rel=1e-3)


def test_concave_outline_and_faces_larger_than_outline_are_clipped():
    plane = corners(grid(lambda x, y: 0.0, n=2))
    letter = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], float)
    ring = np.column_stack([letter, np.zeros(6)])
    assert area_inside(plane, ring) == pytest.approx(3.0, rel=1e-12)
    assert area_inside(plane, 1e-3 * ring) == pytest.approx(3e-6, rel=1e-9)


def test_wall_behind_is_excluded_and_hole_reduces_area():
    front = grid(lambda x, y: 0.0)
    behind = grid(lambda x, y: -1.5)
    both = np.concatenate([corners(front), corners(behind)])
    assert area_inside(both, SQUARE) == pytest.approx(4.0, rel=1e-9)
    middle = corners(front).mean(axis=1)
    left = corners(front)[np.linalg.norm(middle[:, :2], axis=1) > 0.5]
    gone = 4.0 - area_inside(left, SQUARE)
    assert gone == pytest.approx(np.pi * 0.25, rel=0.1)


@pytest.mark.parametrize("seed", range(4))
def test_clipped_part_has_the_area_and_stays_within_outline(seed):
    rng = np.random.default_rng(seed)
    turn, shift = rotation(seed), rng.normal(size=3) * 1000.0
    angle = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
    ring = np.column_stack([(1.5 + 0.5 * np.sin(3 * angle)) * f(angle) for f in (np.cos, np.sin)])
    ring = np.column_stack([ring, 0.3 * ring[:, 0]])
    mesh = grid(lambda x, y: 0.3 * x, n=int(rng.integers(2, 40)))
    part = clip_to_outline(corners(turned(mesh, turn, shift)), ring @ turn.T + shift)
    assert part is not None
    edges = part[:, 1:] - part[:, :1]
    area = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1).sum()
    x, y = ring[:, 0], ring[:, 1]
    flat = 0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1))
    assert area == pytest.approx(flat * np.hypot(1.0, 0.3), rel=1e-9)
    local = (part.reshape(-1, 3) - shift) @ turn
    assert np.abs(local[:, 2] - 0.3 * local[:, 0]).max() < 1e-9
    import shapely

    outline = shapely.Polygon(ring[:, :2]).buffer(1e-9)
    assert outline.contains(shapely.MultiPoint(local[:, :2]))


@pytest.mark.parametrize(
    "ring",
    [
        SQUARE[:2],
        SQUARE[[0, 2, 1, 3]],
        np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]], float),
        SQUARE + [0.0, 0.0, np.nan],
        SQUARE + 100.0,
    ],
    ids=["two points", "crossing itself", "in a row", "no place", "beside the model"],
)
def test_degenerate_outline_has_no_area(ring):
    assert area_inside(corners(grid(lambda x, y: 0.0)), ring) is None
    assert clip_to_outline(corners(grid(lambda x, y: 0.0)), ring) is None


def test_mesh_selects_faces_itself_before_and_after_build():
    mesh = grid(lambda x, y: 0.1 * np.sin(4.0 * x))
    # One face far longer than the others, such as closes a hole, reaches below the outline.
    far = np.array([[100.0, 0.0, -5.0], [0.0, 100.0, -5.0], [-100.0, -100.0, -5.0]])
    n = len(mesh.vertices)
    mesh = Mesh(
        np.concatenate([mesh.vertices, far]),
        np.concatenate([mesh.faces, [[n, n + 1, n + 2]]]).astype(np.int32),
    )
    wanted = area_inside(corners(mesh), SQUARE)
    surface = MeshSurface(mesh)
    assert surface.area_inside(SQUARE) == pytest.approx(wanted, rel=1e-12)
    surface.build()
    assert surface.area_inside(SQUARE) == pytest.approx(wanted, rel=1e-12)
    only = MeshSurface(Mesh(far + [0.0, 0.0, 5.0], np.array([[0, 1, 2]], np.int32)))
    assert only.area_inside(SQUARE) == pytest.approx(4.0, rel=1e-9)
    assert CloudSurface(PointCloud(mesh.vertices)).area_inside(SQUARE) is None
