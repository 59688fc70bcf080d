"""What a measurement asks of a model: the spacing around the pick, and the face it lies on."""

from __future__ import annotations

import numpy as np
import pytest

from vomstudio.geology.quality import total_error_deg
from vomstudio.geometry.planes import fit_plane
from vomstudio.geometry.surface import VertexSurface


def face(spacing: float, normal: np.ndarray, size: float = 4.0, seed: int = 0) -> np.ndarray:
    """Grid points of a rough plane with unit normal `normal` at UTM coordinates."""
    rng = np.random.default_rng(seed)
    steps = np.arange(0.0, size, spacing)
    u, v = np.meshgrid(steps, steps)
    e1 = np.linalg.svd(normal[None])[2][1]
    e2 = np.cross(normal, e1)
    points = u.reshape(-1, 1) * e1 + v.reshape(-1, 1) * e2
    rough = 0.1 * spacing * rng.standard_normal((len(points), 1))
    return points + rough * normal + np.array([465_123.0, 4_612_345.0, 820.0])


@pytest.mark.parametrize("built", [False, True])
@pytest.mark.parametrize("spacing", [0.02, 0.1])
def test_resolution_is_the_spacing_of_the_grid(built, spacing):
    points = face(spacing, np.array([0.0, -1.0, 0.0]))
    surface = VertexSurface(points)
    if built:
        surface.build()
    trace = points[:: len(points) // 7] + 0.3 * spacing
    assert surface.local_resolution(trace) == pytest.approx(spacing, rel=0.15)


def test_local_resolution_is_that_of_the_picked_part():
    fine = face(0.02, np.array([0.0, -1.0, 0.0]))
    coarse = face(0.2, np.array([0.0, -1.0, 0.0])) + np.array([100.0, 0.0, 0.0])
    surface = VertexSurface(np.concatenate([coarse, fine]))
    surface.build()
    assert surface.local_resolution(fine[:5]) == pytest.approx(0.02, rel=0.15)
    assert surface.local_resolution(coarse[:5]) == pytest.approx(0.2, rel=0.15)


def test_duplicate_seam_vertices_do_not_affect_resolution():
    points = face(0.05, np.array([0.0, -1.0, 0.0]))
    surface = VertexSurface(np.repeat(points, 2, axis=0))
    assert surface.local_resolution(points[40:43]) == pytest.approx(0.05, rel=0.2)


@pytest.mark.parametrize("built", [False, True])
def test_the_answers_do_not_depend_on_the_tree(built):
    points = face(0.1, np.array([0.6, -0.8, 0.0]), seed=3)
    plain, tree = VertexSurface(points), VertexSurface(points)
    tree.build()
    trace = points[[5, 200, 700, 900]]
    assert plain.local_resolution(trace) == pytest.approx(tree.local_resolution(trace), rel=1e-12)
    np.testing.assert_allclose(plain.outcrop_normal(trace), tree.outcrop_normal(trace))


@pytest.mark.parametrize("normal", [(0.0, -1.0, 0.0), (0.6, -0.8, 0.0), (0.3, -0.4, np.sqrt(0.75))])
def test_outcrop_normal_is_that_of_face_around_the_trace(normal):
    normal = np.array(normal)
    points = face(0.02, normal)
    along = np.linspace(0.1, 0.9, 9)
    corner, far = points.min(axis=0), points.max(axis=0)
    trace = corner + along[:, None] * (far - corner)
    near = points[[np.argmin(((points - p) ** 2).sum(axis=1)) for p in trace]]
    found = VertexSurface(points).outcrop_normal(near)
    angle = np.degrees(np.arccos(min(1.0, abs(found @ normal))))
    assert angle < 2.0


def test_too_few_vertices_give_no_face():
    line = np.stack([np.linspace(0, 1, 50), np.zeros(50), np.zeros(50)], axis=1)
    assert VertexSurface(line).outcrop_normal(line[::10]) is None
    assert VertexSurface(line[:2]).outcrop_normal(line[:2]) is None
    assert VertexSurface(line[:1]).local_resolution(line[:1]) is None


def test_the_extent_is_the_diagonal_of_the_box():
    points = np.array([[0.0, 0, 0], [3, 0, 1], [1, 4, 12], [2, 2, 2]])
    assert VertexSurface(points).extent == pytest.approx(13.0)


def test_ball_normal_is_fitted_to_its_vertices():
    normal = np.array([0.6, -0.8, 0.0])
    points = face(0.1, normal, seed=5)
    surface = VertexSurface(points)
    centre = points[len(points) // 2 + 20]
    assert surface._normal(centre, 0.5) is None  # nothing is known before the tree is there
    surface.build()
    found = surface._normal(centre, 0.5)
    assert abs(found @ normal) > np.cos(np.radians(4.0))
    inside = points[np.linalg.norm(points - centre, axis=1) <= 0.5]
    theirs = np.linalg.svd(inside - inside.mean(axis=0))[2][2]
    assert abs(found @ theirs) == pytest.approx(1.0, abs=1e-9)
    assert surface._normal(centre, 0.01) is None
    assert surface._normal(centre + 50.0, 0.5) is None
    line = np.column_stack([np.linspace(0, 1, 200), np.zeros((200, 2))])
    straight = VertexSurface(line)
    straight.build()
    assert straight._normal(line[100], 0.2) is None


@pytest.mark.parametrize("built", [False, True])
def test_ball_contains_vertices_within_its_radius(built):
    points = face(0.1, np.array([0.0, -1.0, 0.0]), seed=6)
    surface = VertexSurface(points)
    if built:
        surface.build()
    centre = points[700] + [0.02, 0.03, 0.01]
    for radius in (0.01, 0.15, 0.8):
        wanted = np.flatnonzero(np.linalg.norm(points - centre, axis=1) <= radius)
        assert np.array_equal(np.sort(surface._ids_in_ball(centre, radius)), wanted)


def test_outcrop_normal_is_that_of_cliff_and_not_of_the_ledge():
    """A bed crops out as a ledge, 3 m by 1 m and sloping by 45 degrees, in a wall of 40 by 20 m."""
    wall = np.array([0.0, -1.0, 0.0])
    u, v = (x.ravel() for x in np.meshgrid(np.arange(-20, 20, 0.1), np.arange(-10, 10, 0.1)))
    on_ledge = (np.abs(u) < 1.5) & (np.abs(v) < 0.5)
    points = np.column_stack([u, np.where(on_ledge, -v - 0.5, 0.0), v])
    x = np.linspace(-1.4, 1.4, 9)
    trace = np.column_stack([x, -0.3 * (-1.0) ** np.arange(9) - 0.5, 0.3 * (-1.0) ** np.arange(9)])
    surface = VertexSurface(points)
    for ends in (trace, trace[[0, -1]]):
        found = surface.outcrop_normal(ends)
        assert np.degrees(np.arccos(min(1.0, abs(found @ wall)))) < 2.0


def test_isotropic_point_cloud_has_no_face():
    blob = np.random.default_rng(0).normal(size=(400, 3))
    assert VertexSurface(blob).outcrop_normal(np.array([[-1.0, 0, 0], [1.0, 0, 0]])) is None


@pytest.mark.parametrize("step", [1, 7, 1681])
def test_blockwise_search_finds_all_points_in_a_ball(step, monkeypatch):
    monkeypatch.setattr("vomstudio.geometry.surface.BLOCK_SIZE", step)
    points = face(0.1, np.array([0.0, -1.0, 0.0]), seed=6)[:1681]
    centre = points[900]
    wanted = np.flatnonzero(np.linalg.norm(points - centre, axis=1) <= 0.5)
    assert np.array_equal(np.sort(VertexSurface(points)._ids_in_ball(centre, 0.5)), wanted)


@pytest.mark.parametrize("built", [False, True])
def test_long_trace_is_sampled_including_its_ends(built):
    """Half of the trace lies on fine points, the end of it on coarse ones."""
    fine = face(0.05, np.array([0.0, -1.0, 0.0]))
    coarse = face(0.4, np.array([0.0, -1.0, 0.0])) + [100.0, 0.0, 0.0]
    surface = VertexSurface(np.concatenate([fine, coarse]))
    if built:
        surface.build()
    mostly_fine = np.concatenate([fine[:2000], coarse[:60]])
    assert surface.local_resolution(mostly_fine) == pytest.approx(0.05, rel=0.15)
    mostly_coarse = np.concatenate([fine[:5], coarse[:90]])
    assert surface.local_resolution(mostly_coarse) == pytest.approx(0.4, rel=0.15)
    # Two vertices are enough for a spacing.
    assert VertexSurface(fine[:2]).local_resolution(fine[:1]) == pytest.approx(
        np.linalg.norm(fine[1] - fine[0]), rel=0.8
    )


def test_the_face_around_a_trace_reaches_three_times_its_extent_or_ten_spacings():
    """A strip beside the trace, nearer or farther than that."""
    steps = np.arange(-2.0, 2.0, 0.02)
    u, v = (x.ravel() for x in np.meshgrid(steps, np.arange(-0.05, 0.05, 0.02)))
    ribbon = np.column_stack([u, 0 * u, v])
    trace = np.column_stack([np.linspace(-1.5, 1.5, 5), np.zeros(5), np.zeros(5)])
    for height, seen in ((8.9, True), (9.1, False)):
        far = ribbon + [0.0, height, 0.0]
        normal = VertexSurface(np.concatenate([ribbon, far])).outcrop_normal(trace)
        # Both ribbons together stand across y, the one alone along it.
        assert (abs(normal[2]) > 0.9) == seen
    # One point of a trace has no length: ten spacings of the model then.
    for height, seen in ((0.19, True), (0.21, False)):
        far = ribbon + [0.0, height, 0.0]
        normal = VertexSurface(np.concatenate([ribbon, far])).outcrop_normal(trace[2:3])
        assert (abs(normal[2]) > 0.9) == seen


def test_resampled_trace_has_even_steps_and_keeps_its_ends():
    from vomstudio.geometry.surface import _resample_polyline

    corner = np.array([[0.0, 0, 0], [3, 0, 0], [3, 1, 0]])
    line = _resample_polyline(corner)
    assert len(line) == 200
    assert np.array_equal(line[[0, -1]], corner[[0, -1]])
    along = np.where(line[:, 0] < 3.0, line[:, 0], 3.0 + line[:, 1])
    assert along == pytest.approx(np.linspace(0.0, 4.0, 200))
    assert np.array_equal(_resample_polyline(corner[:1]), corner[:1])


@pytest.mark.parametrize("radius", [0.2, 0.9, 2.5])
def test_nearest_vertices_replace_a_sample_that_is_too_sparse(radius, monkeypatch):
    """Of a ball the sample counts where it holds 64 vertices, else the 64 nearest of all do."""
    monkeypatch.setattr("vomstudio.geometry.surface.MAX_COARSE_VERTICES", 100)
    points = face(0.1, np.array([0.6, -0.8, 0.0]), seed=7)
    surface, centre = VertexSurface(points), points[825] + 0.01
    surface.build()
    away = np.linalg.norm(points - centre, axis=1)
    sample = np.arange(0, len(points), len(points) // 100)
    chosen = sample[away[sample] <= radius]
    if len(chosen) < 64:
        chosen = np.argsort(away)[:64]
        chosen = chosen[away[chosen] <= radius]
    assert (len(chosen) > 64) == (radius > 2.0)
    theirs = np.linalg.svd(points[chosen] - points[chosen].mean(axis=0))[2][2]
    assert abs(surface._normal(centre, radius) @ theirs) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(
    ("halves", "is_face"),
    [
        ((2.0, 1.0, np.sqrt(0.45)), True),  # twice as wide as thick, in squares
        ((2.0, 1.0, np.sqrt(0.55)), False),
        ((1.0, 1.1e-6, 0.0), True),
        ((1.0, 0.9e-6, 0.0), False),
    ],
)
def test_face_must_be_thin_and_wide_enough(halves, is_face):
    ends = np.diag(halves)
    turn = np.linalg.qr(np.random.default_rng(9).normal(size=(3, 3)))[0]
    surface = VertexSurface(np.concatenate([ends, -ends]) @ turn)
    found = surface.outcrop_normal(halves[0] * np.array([[-1.0], [1.0]]) * turn[0])
    assert (found is not None) == is_face
    if is_face:
        assert abs(found @ turn[2]) == pytest.approx(1.0)


@pytest.mark.parametrize(("width", "has_one"), [(1.1e-6, True), (0.9e-6, False)])
def test_ball_containing_only_a_line_has_no_normal(width, has_one):
    points = np.array([[-1.0, 0, 0], [1.0, 0, 0], [0, width, 0], [0, -width, 0]])
    surface = VertexSurface(points)
    surface.build()
    assert (surface._normal(np.zeros(3), 2.0) is not None) == has_one


def test_coincident_vertices_have_no_normal_and_no_face():
    heap = VertexSurface(np.ones((9, 3)))
    heap.build()
    assert heap._normal(np.ones(3), 1.0) is None
    assert heap.outcrop_normal(np.array([[0.0, 1, 1], [2.0, 1, 1]])) is None


def ridge() -> tuple[VertexSurface, float]:
    """Two faces of 4 x 3 m that meet at a right angle along x, which together face up; vertices
    0.1 m apart."""
    x, t = np.meshgrid(np.arange(0.0, 4.0, 0.1), np.arange(-3.0, 3.0, 0.1))
    rows = np.column_stack([x.ravel(), t.ravel() * np.sqrt(0.5), -np.abs(t).ravel() * np.sqrt(0.5)])
    rows += np.random.default_rng(4).normal(0.0, 0.01, rows.shape)
    surface = VertexSurface(rows)
    surface.build()
    return surface, 0.1


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_line_within_one_face_uses_that_face(side: float) -> None:
    """Picks that stray along one side of a ridge say nothing of the plane about their line."""
    surface, spacing = ridge()
    rng = np.random.default_rng(1)
    t = 1.5 + 0.5 * spacing * rng.normal(size=30)
    x = np.linspace(1.0, 2.0, 30)
    picks = np.column_stack([x, side * t * np.sqrt(0.5), -t * np.sqrt(0.5)])
    face = surface.outcrop_normal(picks)
    assert face is not None
    assert abs(face @ (0.0, side * np.sqrt(0.5), np.sqrt(0.5))) > np.cos(np.radians(5.0))
    assert total_error_deg(fit_plane(picks), spacing, outcrop_normal=face) == 90.0


def test_narrow_line_cutting_into_rock_uses_surrounding_face() -> None:
    surface, spacing = ridge()
    x = np.linspace(1.0, 2.0, 30)
    # Over the crest, in the plane x - y = 1.5, as narrow as picks stray.
    picks = np.column_stack([x, x - 1.5, -np.abs(x - 1.5)])
    face = surface.outcrop_normal(picks)
    assert face is not None
    assert abs(face[2]) > np.cos(np.radians(10.0))
    stated = total_error_deg(fit_plane(picks), spacing, outcrop_normal=face)
    assert stated is not None
    assert stated < 15.0
