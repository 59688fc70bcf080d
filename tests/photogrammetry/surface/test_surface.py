import numpy as np
import pytest

from tests.messages import refused, with_code
from tests.photogrammetry import rock_face as rock
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.photogrammetry.surface.meshing import (
    MeshingOptions,
    _trim,
    build_surface,
)
from vomstudio.photogrammetry.surface.topology import (
    components,
    cross_products,
    is_manifold,
    make_manifold,
    neighbours,
)

UTM = np.array([576_700.0, 5_188_150.0, 160.0])


def patch(n: int = 20_000, seed: int = 0, noise: float = 0.0) -> PointCloud:
    """4 x 3 m, looking to -y, with one step of 0.3 m at x = 0."""
    rng = np.random.default_rng(seed)
    flat = rng.uniform([-2, 0, -1.5], [2, 0, 1.5], (n, 3))
    flat[:, 1] = np.where(flat[:, 0] > 0, 0.3, 0.0)
    riser = rng.uniform([0, 0, -1.5], [0, 0.3, 1.5], (n * 3 // 40, 3))
    points = np.concatenate([flat, riser]) + rng.normal(0, noise or 1e-9, (n + len(riser), 3))
    normals = np.zeros_like(points, np.float32)
    normals[:n, 1] = -1
    normals[n:, 0] = 1
    return PointCloud(points, np.full((len(points), 3), 99, np.uint8), normals)


def off_step(vertices: np.ndarray) -> np.ndarray:
    """Distance from the true surface of `patch`."""
    x, y = vertices[:, 0], vertices[:, 1]
    left = np.hypot(np.maximum(x, 0), y)
    right = np.hypot(np.minimum(x, 0), y - 0.3)
    riser = np.hypot(x, y - np.clip(y, 0, 0.3))
    return np.minimum(np.minimum(left, right), riser)


OPTIONS = MeshingOptions(faces=4000, smallest_island_faces=20)


@pytest.fixture(scope="module")
def base():
    return build_surface(patch(), OPTIONS)


def test_surface_is_manifold_with_the_requested_number_of_faces(base):
    made, mesh = base, base.mesh
    assert 0.9 * 4000 <= len(mesh.faces) <= 4000
    assert np.isfinite(mesh.vertices).all()
    assert is_manifold(mesh.faces)
    assert mesh.colors is not None
    assert (mesh.colors == 99).all()
    assert made.facts["faces"] == len(mesh.faces)
    assert made.facts["area_m2"] == pytest.approx(12.9, rel=0.03)


def test_faces_are_counter_clockwise_from_the_air(base):
    mesh = base.mesh
    cross = cross_products(mesh.vertices, mesh.faces)
    assert cross[:, 1].sum() < 0
    length = np.linalg.norm(cross, axis=1)
    assert length[cross[:, 1] > 0.3 * length].sum() < 0.002 * length.sum()


@pytest.mark.full
def test_step_stays_sharp_and_surface_follows_the_points():
    cloud = patch(noise=0.002)
    sharp = build_surface(cloud, OPTIONS).mesh
    plain = build_surface(cloud, MeshingOptions(faces=4000, sharpen=False)).mesh

    def near_step(mesh: Mesh) -> float:
        middle = mesh.vertices[mesh.faces].mean(axis=1)
        near = (np.abs(middle[:, 0]) < 0.1) & (np.abs(middle[:, 2]) < 1.3)
        weight = np.linalg.norm(cross_products(mesh.vertices, mesh.faces)[near], axis=1)
        return float((weight * off_step(middle[near])).sum() / weight.sum())

    assert near_step(sharp) < 0.8 * near_step(plain)
    inner = np.abs(sharp.vertices[:, 2]) < 1.4
    assert np.percentile(off_step(sharp.vertices[inner]), 95) < 0.012


def with_hole(radius: float) -> PointCloud:
    cloud = patch()
    away = np.hypot(cloud.points[:, 0] + 1, cloud.points[:, 2]) > radius
    return PointCloud(cloud.points[away], cloud.colors[away], cloud.normals[away])


def covered(mesh: Mesh, x: float, z: float) -> bool:
    corners = mesh.vertices[mesh.faces][:, :, [0, 2]] - [x, z]
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]

    def side(p, q):
        return p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]

    signs = np.sign(np.stack([side(a, b), side(b, c), side(c, a)]))
    return bool((np.abs(signs.sum(axis=0)) == 3).any())


@pytest.mark.full
def test_small_holes_are_closed_and_large_ones_stay_open():
    options = MeshingOptions(faces=4000, largest_hole_m=0.5)
    closed = build_surface(with_hole(0.2), options)
    assert covered(closed.mesh, -1, 0)
    assert closed.facts["holes_closed"] >= 1
    assert not covered(build_surface(with_hole(0.5), options).mesh, -1, 0)
    assert not covered(build_surface(with_hole(0.2), MeshingOptions(largest_hole_m=0)).mesh, -1, 0)


@pytest.mark.full
def test_islands_are_removed_unless_nothing_else_remains():
    cloud = patch()
    blob = patch(300, seed=5).points * 0.05 + [1.0, -1.5, 0.0]
    both = PointCloud(
        np.concatenate([cloud.points, blob]),
        None,
        np.concatenate([cloud.normals, patch(300, seed=5).normals]),
    )
    made = build_surface(both, MeshingOptions(faces=4000, smallest_island_faces=400))
    assert components(made.mesh.faces).max() == 0
    assert made.mesh.vertices[:, 1].min() > -0.5
    whole = build_surface(cloud, MeshingOptions(faces=500, smallest_island_faces=10_000))
    assert len(whole.mesh.faces) > 100


@pytest.mark.full
def test_far_coordinates_keep_millimetre_precision(base):
    far = patch()
    far = PointCloud(far.points + UTM, far.colors, far.normals)
    a, b = base.mesh, build_surface(far, OPTIONS).mesh
    assert np.median(off_step(b.vertices - UTM)) < 1.5 * np.median(off_step(a.vertices)) + 1e-4


@pytest.mark.full
def test_one_thread_gives_an_identical_surface(base):
    a, b = base.mesh, build_surface(patch(), OPTIONS).mesh
    np.testing.assert_array_equal(a.vertices, b.vertices)
    np.testing.assert_array_equal(a.faces, b.faces)


@pytest.mark.full
def test_too_large_cloud_is_thinned_and_reported():
    made = build_surface(patch(), MeshingOptions(faces=2000, max_points=8000))
    assert made.facts["points"] == 8000
    (finding,) = with_code(made.warnings, "surface.thinned")
    assert finding.values["points"] == 8000


@pytest.mark.parametrize(
    ("points", "normals", "code"),
    [
        (np.zeros((0, 3)), np.zeros((0, 3)), "surface.no-points"),
        (np.random.default_rng(0).random((500, 3)), None, "surface.no-normals"),
        (np.eye(3), np.eye(3), "surface.few-points"),
        (np.ones((500, 3)), np.ones((500, 3)), "surface.coincident-points"),
        (np.full((500, 3), np.nan), np.ones((500, 3)), "surface.few-points"),
    ],
)
def test_clouds_without_a_surface_are_rejected(points, normals, code):
    normals = None if normals is None else normals.astype(np.float32)
    with refused(code, GeometryError):
        build_surface(PointCloud(points, None, normals))


@pytest.mark.parametrize(("name", "value"), [("faces", 0), ("depth", 40), ("trim", -1.0)])
def test_settings_out_of_range_are_rejected_with_their_field(name, value):
    with pytest.raises(UsageError) as raised:
        MeshingOptions(**{name: value})
    assert raised.value.field == name


def test_a_fin_and_touching_sheets_become_manifold():
    vertices = np.array(
        [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0.5, 0.5, 0.2], [-1, 0, 0], [0, -1, 0]], float
    )
    faces = np.array([[0, 1, 2], [1, 3, 2], [1, 2, 4], [0, 5, 6], [0, 1, 1], [2, 1, 3]], np.int32)
    assert not is_manifold(faces)
    found, kept = make_manifold(vertices, faces)
    assert len(kept) == 3
    assert is_manifold(kept)
    assert components(kept).max() == 1
    # The corner where two sheets touched stands twice.
    assert len(found) == 4 + 3
    assert (neighbours(kept) >= 0).sum() == 2


@pytest.mark.full
def test_rock_face_is_reconstructed_within_millimetres():
    import open3d as o3d

    face = rock.rough_face(3.0, 2.0, 0.02)
    views = rock.ring_of_views(1, 3, spread=(2.0, 0), distance=3.0, size=(300, 200), focal=250.0)
    cloud = rock.cloud_of(face, views, spacing=0.014, noise=0.001)
    mesh = build_surface(cloud, MeshingOptions(faces=20_000)).mesh
    found = face.scene.compute_closest_points(o3d.core.Tensor(mesh.vertices.astype(np.float32)))
    off = np.linalg.norm(mesh.vertices - found["points"].numpy(), axis=1)
    assert np.median(off) < 0.0015
    assert np.percentile(off, 95) < 0.012


def grid(nx: int, nz: int, step: float) -> tuple[np.ndarray, np.ndarray]:
    x, z = np.meshgrid(np.arange(nx) * step, np.arange(nz) * step)
    vertices = np.stack([x, 0 * x, z], -1).reshape(-1, 3)
    return vertices, rock.grid_faces(nz, nx)


def test_strip_without_points_is_closed_and_the_rim_is_trimmed():
    vertices, faces = grid(81, 61, 0.05)
    x, z = vertices[:, 0], vertices[:, 2]
    # Points stand at 1 <= z <= 2 but for a strip 0.2 wide that runs from the left end to the right.
    outside = np.maximum(np.maximum(1 - z, z - 2), 0)
    distance = np.maximum(outside, np.maximum(0.1 - np.abs(z - 1.5), 0))
    distance[x > 3.8] = 1.0
    kept, _ = _trim(vertices, faces, distance, max_distance=0.16, max_hole_width=0.3)
    middle = vertices[faces].mean(axis=1)
    strip = (np.abs(middle[:, 2] - 1.5) < 0.1) & (middle[:, 0] < 3.3)
    assert kept[strip].all()
    assert not kept[(middle[:, 2] < 0.85) | (middle[:, 2] > 2.15)].any()
    assert not kept[middle[:, 0] > 3.9].any()
