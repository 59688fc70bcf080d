"""The map of how well a plane could be measured: against closed forms, laws, and traces that are
picked on the same surface by other means."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from scipy.stats import chi2, spearmanr

from tests.tiers import first_in_default_tier
from vomstudio.core.errors import Cancelled, GeometryError, UsageError
from vomstudio.core.progress import SilentProgress
from vomstudio.extraction.measurable import QUALITY_CLASSES, Measurable, map_measurability
from vomstudio.extraction.measurable_options import MeasurableOptions
from vomstudio.extraction.refinement import subdivide_mesh
from vomstudio.geology.orientation import Plane
from vomstudio.geology.quality import total_error_deg
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.plane_sizes import PlaneSizes
from vomstudio.geometry.planes import fit_plane
from vomstudio.geometry.surface import VertexSurface

Floats = npt.NDArray[np.float64]
UP = (0.0, 0.0, 1.0)


def walls(*quads: tuple[Floats, Floats, Floats]) -> Mesh:
    """Of two triangles each: a corner and two sides."""
    corners, faces = [], []
    for at, one, other in quads:
        n = len(corners)
        corners += [at, at + one, at + one + other, at + other]
        faces += [[n, n + 1, n + 2], [n, n + 2, n + 3]]
    return Mesh(np.array(corners, np.float64), np.array(faces, np.int32))


def axis(x: float, y: float, z: float) -> Floats:
    return np.array([x, y, z], np.float64)


CORNER = (
    (axis(0, 0, 0), axis(2, 0, 0), axis(0, 0, 4)),
    (axis(0, 0, 0), axis(0, 2, 0), axis(0, 0, 4)),
)
WALL = (CORNER[0],)


def at(result: Measurable, place: Floats) -> int:
    places = result.elements.places + result.elements.origin
    return int(np.argmin(np.linalg.norm(places - place, axis=1)))


def turned(data: Mesh, degrees: float) -> Mesh:
    """About up, clockwise as azimuths count."""
    a = np.radians(degrees)
    turn = np.array([[np.cos(a), np.sin(a), 0], [-np.sin(a), np.cos(a), 0], [0, 0, 1]])
    return Mesh(data.vertices @ turn.T, data.faces)


# --- closed forms -----------------------------------------------------------------------------
def test_trace_on_planar_face_determines_no_plane() -> None:
    result = map_measurability(walls(*WALL), UP, MeasurableOptions(1.0, resolution_m=0.01))
    assert np.all(result.trace_deg == 90.0)
    assert np.all(result.classes == QUALITY_CLASSES.index("none"))
    assert np.all(result.relief < 1e-6)
    middle = at(result, axis(1, 0, 2))
    assert result.extent[middle] == pytest.approx(1.0, rel=0.05)


@pytest.mark.parametrize("away", first_in_default_tier([0.03, 0.1, 0.2, 0.3, 0.4], 2))
def test_line_at_right_angled_corner_has_two_arms(away: float) -> None:
    result = map_measurability(walls(*CORNER), UP, MeasurableOptions(1.0, resolution_m=0.01))
    row = at(result, axis(away, 0, 2))
    x = result.elements.places[row, 0] + result.elements.origin[0]
    # Arms from the corner, cut by a circle of half a metre about the place.
    arms = x + 0.5, np.sqrt(0.25 - x * x)
    both = sum(arms)
    means = [arm**2 / 2 / both for arm in arms]
    squares = [arm**3 / 3 / both - mean**2 for arm, mean in zip(arms, means, strict=True)]
    mixed = -means[0] * means[1]
    smaller, larger = np.linalg.eigvalsh([[squares[0], mixed], [mixed, squares[1]]])
    assert result.extent[row] == pytest.approx(np.sqrt(12 * larger), rel=0.06)
    assert result.relief[row] == pytest.approx(np.sqrt(12 * smaller), rel=0.12)
    # What errors of 0.08 of the resolution of each point tilt is more than the noise can.
    joint = np.sqrt(chi2.ppf(0.95, 2))
    expected = np.degrees(np.arctan2(joint * 0.08 * 0.01, np.sqrt(both / 0.01 * smaller)))
    assert result.trace_deg[row] == pytest.approx(expected, rel=0.12)
    assert QUALITY_CLASSES[result.classes[row]] == "good"


@pytest.mark.full
def test_line_around_pillar_is_an_arc() -> None:
    radius, turn = 1.0, np.linspace(0, 2 * np.pi, 241)[:-1]
    ring = radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    levels = np.linspace(0, 3, 121)
    vertices = np.concatenate([np.column_stack([ring, np.full(240, z)]) for z in levels])
    a = (np.arange(120)[:, None] * 240 + np.arange(240)).ravel()
    b = (np.arange(120)[:, None] * 240 + (np.arange(240) + 1) % 240).ravel()
    faces = np.concatenate([np.stack([a, b, a + 240], 1), np.stack([b, b + 240, a + 240], 1)])
    result = map_measurability(
        Mesh(vertices, faces.astype(np.int32)), UP, MeasurableOptions(1.0, resolution_m=0.026)
    )
    row = at(result, axis(1, 0, 1.5))
    # The chord from the place to the end of the arc is half of the length.
    half = 2.0 * np.arcsin(0.25 / radius)
    across = radius**2 * (0.5 + np.sin(2 * half) / (4 * half) - (np.sin(half) / half) ** 2)
    along = radius**2 * (0.5 - np.sin(2 * half) / (4 * half))
    assert result.extent[row] == pytest.approx(np.sqrt(12 * along), rel=0.05)
    assert result.relief[row] == pytest.approx(np.sqrt(12 * across), rel=0.15)
    # Along the pillar's axis the line is straight.
    upright = map_measurability(
        Mesh(vertices, faces.astype(np.int32)), (0, 1, 0), MeasurableOptions(1.0)
    )
    assert upright.trace_deg[at(upright, axis(1, 0, 1.5))] >= 30.0


def test_face_parallel_to_plane_exposes_it_as_a_patch() -> None:
    ledge = walls(
        (axis(0, 0, 0), axis(2, 0, 0), axis(0, 2, 0)), (axis(0, 2, 0), axis(2, 0, 0), axis(0, 0, 2))
    )
    result = map_measurability(ledge, UP, MeasurableOptions(1.0, resolution_m=0.02, noise_m=0.001))
    row = at(result, axis(1, 1, 0))
    assert np.isnan(result.trace_deg[row])
    # Four square metres.
    expected = PlaneSizes(0.02, 0.001).error_deg(2.0 * np.sqrt(4.0 / np.pi))
    assert result.patch_deg[row] == pytest.approx(expected, rel=1e-6)
    assert result.patches[row] == 0
    wall = at(result, axis(1, 2, 1))
    assert np.isnan(result.patch_deg[wall])
    assert result.patches[wall] == -1


def test_patch_below_ten_resolutions_has_no_error_estimate() -> None:
    ledge = walls((axis(0, 0, 0), axis(2, 0, 0), axis(0, 2, 0)))
    result = map_measurability(ledge, UP, MeasurableOptions(2.0, resolution_m=0.3))
    assert np.isnan(result.patch_deg).all()
    assert np.all(result.classes == 0)


# --- laws ---------------------------------------------------------------------------------------
def waves(seed: int = 0, count: int = 120) -> Mesh:
    """A steep wall with relief at several scales, 3 x 3 m."""
    rng = np.random.default_rng(seed)
    z, x = np.mgrid[0:count, 0:count] * (3.0 / count)
    y = np.zeros_like(x)
    for _ in range(12):
        length = 10 ** rng.uniform(-0.4, 0.5)
        angle, phase = rng.uniform(0, 2 * np.pi, 2)
        k = 2 * np.pi / length
        y += 0.05 * length * np.sin(k * (x * np.cos(angle) + z * np.sin(angle)) + phase)
    points = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
    a = (np.arange(count - 1)[:, None] * count + np.arange(count - 1)).ravel()
    faces = np.concatenate(
        [np.stack([a, a + 1, a + count], 1), np.stack([a + 1, a + count + 1, a + count], 1)]
    )
    return Mesh(points, faces.astype(np.int32))


def test_rotating_model_and_plane_keeps_the_map() -> None:
    mesh = waves()
    one = map_measurability(mesh, tuple(Plane(40, 30).normal()), MeasurableOptions(1.0))
    other = map_measurability(
        turned(mesh, 30), tuple(Plane(70, 30).normal()), MeasurableOptions(1.0)
    )
    ratio = other.best_deg / one.best_deg
    # Strips and cells lie otherwise; the surface does not.
    assert np.percentile(np.abs(np.log(ratio)), 90) < 0.25
    assert np.median(ratio) == pytest.approx(1.0, abs=0.03)


def test_a_normal_and_its_opposite_are_one_plane() -> None:
    mesh, normal = waves(), Plane(40, 30).normal()
    one = map_measurability(mesh, tuple(normal), MeasurableOptions(1.0))
    other = map_measurability(mesh, tuple(-normal), MeasurableOptions(1.0))
    assert np.median(other.best_deg / one.best_deg) == pytest.approx(1.0, abs=0.03)


def test_longer_trace_and_less_noise_reduce_the_error() -> None:
    mesh, normal = waves(), tuple(Plane(40, 30).normal())
    short = map_measurability(mesh, normal, MeasurableOptions(0.6))
    long = map_measurability(mesh, normal, MeasurableOptions(1.8))
    noisy = map_measurability(mesh, normal, MeasurableOptions(1.8, noise_m=0.05))
    assert np.median(long.best_deg) < 0.8 * np.median(short.best_deg)
    assert np.median(noisy.best_deg) > 1.5 * np.median(long.best_deg)
    few = map_measurability(mesh, normal, MeasurableOptions(1.8, noise_m=0.05, points=5))
    assert np.median(few.best_deg) > 1.5 * np.median(noisy.best_deg)


def test_the_registration_is_added_in_quadrature() -> None:
    mesh, normal = waves(), tuple(Plane(40, 30).normal())
    one = map_measurability(mesh, normal, MeasurableOptions(1.0)).trace_deg
    other = map_measurability(
        mesh, normal, MeasurableOptions(1.0, registration_error_deg=3.0)
    ).trace_deg
    report = one < 80.0
    assert np.allclose(other[report], np.hypot(one[report], 3.0))


@pytest.mark.full
def test_cloud_and_mesh_of_same_surface_have_similar_maps() -> None:
    mesh, normal = waves(), tuple(Plane(40, 30).normal())
    of_mesh = map_measurability(mesh, normal, MeasurableOptions(1.0))
    cloud = map_measurability(PointCloud(mesh.vertices), normal, MeasurableOptions(1.0))
    corners = mesh.vertices[mesh.faces[of_mesh.elements.rows]].mean(axis=1)
    own = np.array([cloud.best_deg[at(cloud, place)] for place in corners[::37]])
    theirs = of_mesh.best_deg[::37]
    assert spearmanr(own, theirs).statistic > 0.8
    assert np.median(own / theirs) == pytest.approx(1.0, abs=0.2)


# --- what then comes --------------------------------------------------------------------------
def picked(mesh: Mesh, normal: Floats, place: Floats, length: float) -> Floats:
    """Points all along the line in which the plane through a place cuts the mesh, in the order
    along its longest axis."""
    off = (mesh.vertices - place) @ normal
    corners, own = mesh.vertices[mesh.faces], off[mesh.faces]
    near = (np.linalg.norm(corners.mean(axis=1) - place, axis=1) < length) & (
        (own.min(axis=1) < 0.0) & (own.max(axis=1) > 0.0)
    )
    ends = []
    for tri, s in zip(corners[near], own[near], strict=True):
        cut = [
            tri[k] + (tri[(k + 1) % 3] - tri[k]) * s[k] / (s[k] - s[(k + 1) % 3])
            for k in range(3)
            if (s[k] < 0.0) != (s[(k + 1) % 3] < 0.0)
        ]
        ends.append(cut)
    lines = np.array(ends)
    # From piece to piece, starting at the nearest.
    hold = np.linalg.norm(lines.mean(axis=1) - place, axis=1)
    reached = np.zeros(len(lines), bool)
    reached[np.argmin(hold)] = True
    while True:
        tips = lines[reached].reshape(-1, 3)
        gap = np.linalg.norm(lines.reshape(-1, 1, 3) - tips, axis=2).min(axis=1).reshape(-1, 2)
        more = ~reached & (gap.min(axis=1) < 1e-6) & (hold <= length / 2)
        if not more.any():
            break
        reached |= more
    kept = lines[reached]
    share = np.linspace(0.05, 0.95, 8)[:, None]
    points = np.concatenate([a + share * (b - a) for a, b in kept])
    along = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][0]
    return np.asarray(points[np.argsort(points @ along, kind="stable")])


SAMPLE = Path(__file__).parents[2] / "resources" / "sample" / "sample.obj"


def agreement(mesh: Mesh, planes: list[Plane], length: float, each: int) -> tuple[Floats, Floats]:
    """What the map tells at random places, and what simulated traces there state."""
    rng = np.random.default_rng(5)
    near = VertexSurface(np.asarray(mesh.vertices))
    near.build()
    report, stated = [], []
    for plane in planes:
        normal = plane.normal()
        result = map_measurability(mesh, tuple(normal), MeasurableOptions(length))
        places = result.elements.places + result.elements.origin
        share = result.areas / result.areas.sum()
        for row in rng.choice(len(places), each, p=share):
            if np.isnan(result.trace_deg[row]):
                continue
            line = picked(mesh, normal, places[row] + 1e-6, length)
            own = near.local_resolution(line)
            assert own is not None
            gaps = np.linalg.norm(np.diff(line, axis=0), axis=1).sum()
            rows = np.unique(np.linspace(0, len(line) - 1, max(int(gaps / own), 5)).astype(int))
            points = line[rows] + result.noise * rng.standard_normal((len(rows), 3))
            error = total_error_deg(fit_plane(points), own)
            report.append(result.trace_deg[row])
            stated.append(90.0 if error is None else error)
    return np.array(report), np.array(stated)


@pytest.mark.full
def test_simulated_traces_agree_with_map() -> None:
    planes = [Plane(40, 30), Plane(200, 70), Plane(310, 45)]
    report, stated = agreement(waves(), planes, 1.0, 25)
    assert spearmanr(report, stated).statistic > 0.85
    known = stated < 80.0
    assert 0.7 < np.median(report[known] / stated[known]) < 1.4


@pytest.mark.slow
def test_simulated_traces_on_sample_agree_with_map() -> None:
    from vomstudio.studio.world_models import read_in_world

    mesh = read_in_world(SAMPLE).data
    assert isinstance(mesh, Mesh)
    planes = [Plane(315.3, 38.3), Plane(94.3, 23.4), Plane(305.9, 66.5), Plane(140, 79)]
    report, stated = agreement(mesh, planes, 4.0, 18)
    known = stated < 80.0
    assert spearmanr(report, stated).statistic > 0.8
    assert 0.7 < np.median(report[known] / stated[known]) < 1.7


# --- bad input ----------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("length_m", 0.0),
        ("length_m", -1.0),
        ("length_m", float("nan")),
        ("resolution_m", 0.0),
        ("noise_m", float("inf")),
        ("points", 3),
        ("angle_deg", 60.0),
        ("registration_error_deg", 90.0),
    ],
)
def test_values_outside_their_bounds_are_refused(name: str, value: float) -> None:
    with pytest.raises(UsageError) as error:
        MeasurableOptions(**{name: value})
    is_length = name.endswith("_m")
    assert error.value.code == ("option.not-a-length" if is_length else "option.out-of-range")


def test_a_length_under_the_resolution_is_refused() -> None:
    with pytest.raises(GeometryError, match="longer"):
        map_measurability(waves(), UP, MeasurableOptions(0.05))


def test_a_length_that_would_need_too_many_faces_is_refused() -> None:
    with pytest.raises(GeometryError, match="longer"):
        map_measurability(walls(*CORNER), UP, MeasurableOptions(0.01, resolution_m=0.001))


def test_degenerate_surfaces_are_refused_and_broken_vertices_tolerated() -> None:
    with pytest.raises(GeometryError):
        map_measurability(PointCloud(np.zeros((3, 3))), UP, MeasurableOptions(1.0))
    flat = Mesh(np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0.0]]), np.array([[0, 1, 2]], np.int32))
    with pytest.raises(GeometryError):
        map_measurability(flat, UP, MeasurableOptions(1.0))
    mesh = waves()
    vertices = np.array(mesh.vertices)
    vertices[7] = np.nan
    twice = np.concatenate([mesh.faces, mesh.faces[:50], [[5, 5, 6]]]).astype(np.int32)
    result = map_measurability(
        Mesh(vertices, twice), tuple(Plane(40, 30).normal()), MeasurableOptions(1.0)
    )
    whole = map_measurability(mesh, tuple(Plane(40, 30).normal()), MeasurableOptions(1.0))
    assert np.median(result.best_deg) == pytest.approx(np.median(whole.best_deg), rel=0.1)


def test_disconnected_islands_do_not_share_traces() -> None:
    # A second wall at right angles that the first does not hang together with.
    apart = walls(WALL[0], (axis(-0.1, 0.1, 0), axis(0, 2, 0), axis(0, 0, 4)))
    result = map_measurability(apart, UP, MeasurableOptions(1.0, resolution_m=0.01))
    assert np.all(result.trace_deg == 90.0)


def test_map_computation_can_be_cancelled() -> None:
    class Stop(SilentProgress):
        def step(self, done: int) -> None:
            raise Cancelled

    with pytest.raises(Cancelled):
        map_measurability(waves(), UP, MeasurableOptions(1.0), Stop())


# --- cutting large faces --------------------------------------------------------------------
def test_faces_are_cut_without_gaps() -> None:
    mesh = walls(*CORNER)
    from vomstudio.geometry.coincident_points import weld_points

    number = weld_points(mesh.vertices)
    places = np.zeros((number.max() + 1, 3))
    places[number] = mesh.vertices
    vertices, faces, of = subdivide_mesh(places, number[mesh.faces], 0.3)
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    lengths = np.linalg.norm(vertices[edges[:, 0]] - vertices[edges[:, 1]], axis=1)
    assert lengths.max() <= 0.3
    # Every edge inside belongs to two faces; those of the rim, 16 m of it, to one.
    _, first, count = np.unique(edges, axis=0, return_index=True, return_counts=True)
    assert set(count.tolist()) == {1, 2}
    assert lengths[first[count == 1]].sum() == pytest.approx(16.0)
    own = np.cross(
        vertices[faces[:, 1]] - vertices[faces[:, 0]], vertices[faces[:, 2]] - vertices[faces[:, 0]]
    )
    areas = np.bincount(of, 0.5 * np.linalg.norm(own, axis=1))
    assert np.allclose(areas, 4.0)
