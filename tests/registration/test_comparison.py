"""Distances of models from benchmarks: closed forms, and M3C2 beside py4dgeo."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from tests.messages import refused, with_code
from vomstudio.core.errors import Cancelled, GeometryError, UsageError
from vomstudio.core.progress import CancelToken, SilentProgress
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.registration.distances import m3c2
from vomstudio.registration.distances.cloud_distance import OrientedCloud
from vomstudio.registration.distances.comparison import compare, statistics
from vomstudio.registration.distances.mesh_distance import OrientedMesh
from vomstudio.registration.overlap import crs_findings
from vomstudio.registration.surface_points import surface_points

Array = npt.NDArray[np.float64]
FAR = np.array([364_520.0, 4_721_864.0, 846.0])


def grid(n: int, step: float = 0.1) -> Array:
    x, y = np.meshgrid(np.arange(n) * step, np.arange(n) * step)
    return np.column_stack([x.ravel(), y.ravel(), np.zeros(n * n)])


def sheet(n: int, step: float = 0.1) -> Mesh:
    row = np.arange(n * n).reshape(n, n)
    a, b, c, d = row[:-1, :-1], row[:-1, 1:], row[1:, 1:], row[1:, :-1]
    faces = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))])
    return Mesh(grid(n, step), faces.astype(np.int32))


def cube() -> Mesh:
    """From -1 to 1, outwards; every face has vertices of its own, as texture seams make them."""
    corners, faces = [], []
    for axis in range(3):
        for side in (-1.0, 1.0):
            square = np.zeros((4, 3))
            square[:, axis] = side
            square[:, (axis + 1) % 3] = [-1, 1, 1, -1]
            square[:, (axis + 2) % 3] = [-1, -1, 1, 1]
            order = [0, 1, 2, 3] if side > 0 else [3, 2, 1, 0]
            first = len(corners) * 4
            corners.append(square[order])
            faces += [[first, first + 1, first + 2], [first, first + 2, first + 3]]
    return Mesh(np.concatenate(corners), np.array(faces, np.int32))


# --- meshes ---------------------------------------------------------------------------------------
@pytest.mark.full
def test_distance_to_a_cube_matches_its_formula() -> None:
    box = cube()
    places = np.random.default_rng(1).uniform(-3, 3, (4000, 3))
    off = np.abs(places) - 1.0
    outside = np.linalg.norm(np.maximum(off, 0.0), axis=1)
    truth = outside + np.minimum(off.max(axis=1), 0.0)
    for shift in (np.zeros(3), FAR):
        sides = OrientedMesh(Mesh(box.vertices + shift, box.faces))
        found = sides.find_counterparts(places + shift)
        assert found.distance == pytest.approx(truth, abs=1e-8)
        assert not found.distance_beyond_edge.any()
        assert np.linalg.norm(sides.mean_normal) == pytest.approx(0.0, abs=1e-9)


def test_distance_to_a_rough_mesh_matches_open3d() -> None:
    import open3d as o3d

    rng = np.random.default_rng(2)
    mesh = sheet(30)
    mesh = Mesh(mesh.vertices + rng.normal(0, 0.03, mesh.vertices.shape), mesh.faces)
    places = rng.uniform([-1, -1, -1], [4, 4, 1], (2000, 3))
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(
        o3d.core.Tensor(mesh.vertices.astype(np.float32)),
        o3d.core.Tensor(mesh.faces.astype(np.uint32)),
    )
    theirs = scene.compute_distance(o3d.core.Tensor(places.astype(np.float32))).numpy()
    found = OrientedMesh(mesh).find_counterparts(places)
    assert np.abs(found.distance) == pytest.approx(theirs, abs=2e-6)


def test_only_points_within_the_benchmark_edge_have_a_distance() -> None:
    model = PointCloud(grid(62) + [-1.05, -1.05, 0.02])
    found = compare(model, sheet(41))
    # As far beyond it as the model's points are apart they are still taken.
    inside = np.all((model.points[:, :2] > -0.06) & (model.points[:, :2] < 4.06), axis=1)
    assert np.isfinite(found.distances).tolist() == inside.tolist()
    assert (found.n, found.beyond) == (42 * 42, 62 * 62 - 42 * 42)
    assert found.median_m == pytest.approx(0.02)
    assert with_code(found.warnings, "comparison.partial")


def test_distance_sign_follows_the_face_winding() -> None:
    ground = sheet(21)
    above = PointCloud(grid(21) + [0.0, 0.0, 0.3])
    turned = Mesh(ground.vertices, np.ascontiguousarray(ground.faces[:, ::-1]))
    up, down = compare(above, ground), compare(above, turned)
    assert (up.mean_m, down.mean_m) == (pytest.approx(0.3), pytest.approx(-0.3))
    assert up.positive_toward is not None
    assert up.positive_toward.plunge_deg == pytest.approx(-90.0)
    assert compare(above, cube()).positive_toward is None


def test_degenerate_faces_and_nan_positions_are_ignored() -> None:
    ground = sheet(5)
    faces = np.concatenate([ground.faces, [[0, 0, 1], [3, 3, 3]]]).astype(np.int32)
    places = np.array([[0.2, 0.2, 0.1], [np.nan, 0, 0], [0.0, 0.0, -0.2]])
    found = OrientedMesh(Mesh(ground.vertices, faces)).find_counterparts(places)
    assert found.distance == pytest.approx([0.1, np.nan, -0.2], nan_ok=True)


# --- clouds ---------------------------------------------------------------------------------------
def test_distance_between_noisy_planes_matches_their_offset() -> None:
    rng = np.random.default_rng(3)
    tilt = np.array([[0.6, 0, 0.8], [0, 1, 0], [-0.8, 0, 0.6]])
    n, offset, noise = 40, 0.08, 0.01
    places = rng.uniform(0, 4, (2, n * n * 4, 3)) * [1, 1, 0]
    places[:, :, 2] = rng.normal(0, noise, places.shape[:2])
    model = PointCloud((places[0] + [0, 0, offset]) @ tilt.T + FAR)
    bench = PointCloud(places[1] @ tilt.T + FAR)
    found = compare(model, bench)
    assert found.mean_m == pytest.approx(offset, abs=4 * noise / np.sqrt(found.n) + 2e-4)
    # Each point's own noise, and that of a plane by some fifty points.
    assert found.std_m == pytest.approx(noise, rel=0.1)
    assert found.mad_m == pytest.approx(0.6745 * noise, rel=0.1)
    assert found.sides_by == "up"
    side = found.positive_toward
    assert side is not None
    assert side.plunge_deg == pytest.approx(-np.degrees(np.arcsin(0.6)), abs=1.0)
    assert side.trend_deg == pytest.approx(90.0, abs=1.0)


def test_distance_signs_agree_around_a_closed_cloud() -> None:
    rng = np.random.default_rng(4)
    ball = rng.normal(size=(6000, 3))
    ball /= np.linalg.norm(ball, axis=1, keepdims=True)
    bench = PointCloud(ball)
    places = 1.1 * ball[:500]
    distance = OrientedCloud(bench, 0.046).find_counterparts(places).distance
    assert np.abs(np.sign(distance).sum()) == 500
    # A chord's plane lies within the ball: half of the radius squared over four.
    assert np.abs(distance) == pytest.approx(np.full(500, 0.1), abs=0.02)
    # A model with normals, or the benchmark's own, tell which side is outside.
    outward = PointCloud(places, normals=places.astype(np.float32))
    assert compare(outward, bench).mean_m > 0
    assert compare(outward, bench).sides_by == "model"
    inward = PointCloud(ball, normals=-ball.astype(np.float32))
    assert compare(outward, inward).mean_m < 0
    assert compare(outward, inward).sides_by == "normals"


def test_a_hole_in_the_benchmark_gives_no_distances() -> None:
    points = grid(41)
    hole = np.linalg.norm(points[:, :2] - 2.0, axis=1) < 0.8
    found = compare(PointCloud(points + [0, 0, 0.01]), PointCloud(points[~hole]))
    deep = np.linalg.norm(points[:, :2] - 2.0, axis=1) < 0.4
    assert np.isnan(found.distances[deep]).all()
    assert np.isfinite(found.distances[~hole]).all()


# --- M3C2 -----------------------------------------------------------------------------------------
def waves(n: int, seed: int, up: float) -> Array:
    rng = np.random.default_rng(seed)
    flat = rng.uniform(0, 6, (n, 2))
    z = 0.4 * np.sin(flat[:, 0]) * np.cos(0.7 * flat[:, 1]) + rng.normal(0, 0.02, n) + up
    return np.column_stack([flat, z])


def ours(normals: Array | None = None) -> m3c2.Projection:
    first, second = waves(6000, 1, 0.0), waves(5000, 2, 0.05)
    core = first[::600]
    up = np.broadcast_to([0.0, 0.0, 1.0], core.shape)
    found = m3c2.normals_at(first, core, 0.8, up)
    return m3c2.project(
        core, found, first, second, radius=0.4, max_distance=1.0, registration_error=0.01
    )


def test_m3c2_matches_stored_py4dgeo_results() -> None:
    """The numbers are those of py4dgeo 1.2.0, `M3C2(cyl_radius=0.4, normal_radii=(0.8,),
    max_distance=1.0, registration_error=0.01)` on these clouds; its distances are those of the
    second from the first."""
    found = ours()
    theirs = [
        0.04822123,
        0.04740906,
        0.0481774,
        0.04788008,
        0.04619192,
        0.05175665,
        0.05192491,
        0.05743283,
        0.04470791,
        0.04270717,
    ]
    lod = [
        0.02688808,
        0.02570176,
        0.02624344,
        0.02610459,
        0.02692281,
        0.02599983,
        0.02614861,
        0.02670049,
        0.02811848,
        0.02662676,
    ]
    assert found.distance == pytest.approx([-d for d in theirs], abs=1e-8)
    assert found.lod95 == pytest.approx(lod, abs=1e-8)
    assert found.count[:, 0].tolist() == [78, 78, 72, 73, 79, 92, 76, 63, 53, 82]
    assert found.count[:, 1].tolist() == [60, 77, 93, 82, 57, 61, 64, 57, 51, 73]
    assert found.normal[0] == pytest.approx([-0.25599857, -0.01153167, 0.96660838], abs=1e-7)


def test_m3c2_matches_the_installed_py4dgeo() -> None:
    py4dgeo = pytest.importorskip("py4dgeo")
    first, second = waves(6000, 1, 0.0), waves(5000, 2, 0.05)
    theirs = py4dgeo.M3C2(
        epochs=(py4dgeo.Epoch(first), py4dgeo.Epoch(second)),
        corepoints=first[::600],
        cyl_radius=0.4,
        normal_radii=(0.8,),
        max_distance=1.0,
        registration_error=0.01,
    )
    distances, told = theirs.run()
    found = ours()
    assert found.distance == pytest.approx(-distances, abs=1e-9)
    assert found.lod95 == pytest.approx(told["lodetection"], abs=1e-9)


@pytest.mark.full
def test_level_of_detection_matches_the_formula() -> None:
    """Regular points, so that their number in a cylinder is known; noise of one size."""
    rng = np.random.default_rng(5)
    step, noise, reg, radius = 0.05, 0.01, 0.003, 0.5
    model, bench = grid(101, step), grid(101, step)
    model[:, 2] = 0.1 + rng.normal(0, noise, len(model))
    bench[:, 2] = rng.normal(0, noise, len(bench))
    found = compare(PointCloud(model), PointCloud(bench), radius_m=radius, registration_error_m=reg)
    inside = np.all((model[:, :2] > 1.1) & (model[:, :2] < 3.9), axis=1)
    n = np.pi * radius**2 / step**2
    stated = 1.96 * (noise * np.sqrt(2 / n) + reg)
    assert found.lod95 is not None
    assert np.median(found.lod95[inside]) == pytest.approx(stated, rel=0.02)
    assert found.significant_share == 1.0
    assert found.mean_m == pytest.approx(0.1, abs=5e-4)
    # Of two clouds of one plane chance makes one in twenty significant.
    same = compare(
        PointCloud(model - [0, 0, 0.1]),
        PointCloud(bench),
        radius_m=radius,
        registration_error_m=0.0,
    )
    assert same.significant_share is not None
    assert same.significant_share < 0.2
    assert (found.normal_radius_m, found.registration_error_m) == (1.0, reg)


def test_false_alarm_rate_matches_the_significance_level() -> None:
    """Cylinders that share no point: independent trials."""
    rng = np.random.default_rng(6)
    x, y = np.meshgrid(np.arange(30.0), np.arange(30.0))
    core = np.column_stack([x.ravel(), y.ravel(), np.zeros(900)])
    clouds = [
        np.repeat(core, 40, axis=0)
        + np.column_stack([rng.uniform(-0.2, 0.2, (36_000, 2)), rng.normal(0, 0.05, 36_000)])
        for _ in range(2)
    ]
    up = np.broadcast_to([0.0, 0.0, 1.0], core.shape)
    found = m3c2.project(core, up, *clouds, radius=0.4, max_distance=0.5)
    share = float((np.abs(found.distance) > found.lod95).mean())
    assert share == pytest.approx(0.05, abs=3 * np.sqrt(0.05 * 0.95 / 900))


def test_tilt_affects_the_standard_deviation_but_not_the_mean() -> None:
    bench, turn = grid(41), np.radians(2.0)
    model = grid(41)
    model[:, 2] = (model[:, 0] - 2.0) * np.tan(turn)
    found = compare(PointCloud(model), PointCloud(bench), radius_m=0.3)
    assert found.mean_m == pytest.approx(0.0, abs=1e-3)
    assert found.std_m == pytest.approx(4.0 * np.tan(turn) / np.sqrt(12), rel=0.06)
    assert with_code(found.warnings, "comparison.error-assumed")


def test_large_faces_are_densified_and_reported() -> None:
    ground = sheet(3, 2.0)
    points, added = surface_points(ground, 0.1)
    assert added == pytest.approx(16 / 0.01, rel=0.02)
    assert len(points) == added + 9
    assert np.ptp(points[:, 2]) == 0.0
    found = compare(PointCloud(grid(41) + [0, 0, 0.2]), ground, radius_m=0.5)
    assert found.mean_m == pytest.approx(0.2)
    assert with_code(found.warnings, "comparison.large-faces")


def test_too_few_points_give_no_level_of_detection() -> None:
    found = compare(
        PointCloud(grid(21) + [0, 0, 0.1]),
        PointCloud(grid(21)),
        radius_m=0.08,
        registration_error_m=0.0,
    )
    assert found.mean_m == pytest.approx(0.1)
    assert found.lod95_m is None
    assert found.significant_share is None
    assert with_code(found.warnings, "comparison.few-points")


def test_invalid_points_normals_and_faces_are_tolerated() -> None:
    """Points that are nowhere, normals of zero, a mesh without faces, a benchmark of one point."""
    flat = grid(21)
    raised = flat + [0, 0, 0.1]
    zeros = np.zeros((441, 3), np.float32)
    bare = Mesh(flat, np.zeros((0, 3), np.int32))
    for model, bench in (
        (PointCloud(np.vstack([raised, [[np.nan] * 3]])), PointCloud(flat)),
        (PointCloud(raised, normals=zeros), PointCloud(flat, normals=zeros)),
        (PointCloud(raised), bare),
    ):
        for radius in (None, 0.3):
            found = compare(model, bench, radius_m=radius, registration_error_m=0.0)
            assert (found.n, found.mean_m) == (441, pytest.approx(0.1))
            assert found.sides_by == "up"
    assert compare(PointCloud(flat[:9]), PointCloud(flat[:1])).n == 9


# --- what cannot be -------------------------------------------------------------------------------
def test_statistics_match_hand_calculation() -> None:
    told = statistics(np.array([1.0, 2.0, 6.0, np.nan]), np.array([1.5, 1.0, np.nan, 0.1]))
    assert told == {
        "n": 3,
        "beyond": 1,
        "mean_m": 3.0,
        "median_m": 2.0,
        "std_m": pytest.approx(np.sqrt(7)),
        "mad_m": 1.0,
        "rms_m": pytest.approx(np.sqrt(41 / 3)),
        "lod95_m": 1.25,
        "significant_share": 0.5,
    }


def test_models_without_overlap_are_rejected() -> None:
    with refused("reference.no-overlap", GeometryError):
        compare(PointCloud(grid(5)), PointCloud(grid(5) + FAR))
    with refused("comparison.no-overlap", GeometryError):
        compare(PointCloud(grid(5) + [3.0, 0, 0]), sheet(21))
    with refused("comparison.no-points", GeometryError):
        compare(PointCloud(np.zeros((0, 3))), sheet(5))


def test_crs_mismatch_is_reported() -> None:
    names = ("a.las", "b.obj")
    assert crs_findings(None, None, names) == []
    assert crs_findings("EPSG:32633", "EPSG:32633", names) == []
    (finding,) = crs_findings("EPSG:32633", None, names)
    assert (finding.code, finding.values["bare"]) == ("crs.taken-over", "b.obj")
    zones = {"crs": "WGS 84 / UTM zone 33N", "other": "WGS 84 / UTM zone 32N"}
    with refused("crs.different", UsageError, second="b.obj", **zones):
        crs_findings("EPSG:32633", "EPSG:32632", names)
    from pyproj import CRS

    assert crs_findings("EPSG:32633", CRS.from_epsg(32633).to_wkt("WKT1_ESRI"), names) == []
    (finding,) = crs_findings("EPSG:32633+5773", "EPSG:32633+3855", names)
    assert finding.code == "crs.other-heights"


def test_comparison_can_be_cancelled() -> None:
    token = CancelToken()
    token.cancel()
    with pytest.raises(Cancelled):
        compare(PointCloud(grid(20)), sheet(20), progress=SilentProgress(token))
