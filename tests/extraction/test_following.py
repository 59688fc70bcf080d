"""Paths that follow a contact whose place is known by construction."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from tests.benchmarks.bench_followed import population
from tests.extraction.planes_by_construction import grid_mesh
from tests.messages import refused
from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.extraction.followed_trace import fit_trace_plane
from vomstudio.extraction.following import Follower
from vomstudio.extraction.surface_graph import SurfaceGraph
from vomstudio.geology.profiles import DEFAULT_THRESHOLDS
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Material, Mesh
from vomstudio.geometry.surface import VertexSurface


def hills(step: float = 0.05, count: int = 61) -> Mesh:
    y, x = np.mgrid[0:count, 0:count] * step
    return grid_mesh(0.4 * np.sin(2.0 * x) * np.cos(1.5 * y), step)


def with_bed(mesh: Mesh, rng: np.random.Generator, noise: float = 6.0) -> tuple[Mesh, np.ndarray]:
    """Darker where a plane cuts it; and the distance of each vertex from that plane."""
    normal = np.array([-0.3, 0.8, 0.5])
    off = (mesh.vertices - [1.5, 1.5, 0.1]) @ (normal / np.linalg.norm(normal))
    grey = np.where(np.abs(off) < 0.04, 60.0, 170.0) + noise * rng.standard_normal(len(off))
    colours = np.repeat(np.clip(grey, 0, 255)[:, None], 3, axis=1).astype(np.uint8)
    return Mesh(mesh.vertices, mesh.faces, colors=colours), off


def clicks(mesh: Mesh, off: np.ndarray) -> np.ndarray:
    """Three vertices on the bed, from one end of it to the other."""
    on = np.flatnonzero(np.abs(off) < 0.02)
    on = on[np.argsort(mesh.vertices[on, 0])]
    return np.asarray(mesh.vertices[on[[0, len(on) // 2, -1]]])


@pytest.mark.parametrize("cost", ["colour", "dark"])
@pytest.mark.parametrize("kind", ["mesh", "cloud"])
def test_the_path_keeps_to_the_bed(kind: str, cost: str) -> None:
    mesh, off = with_bed(hills(), np.random.default_rng(1))
    data = mesh if kind == "mesh" else PointCloud(mesh.vertices, colors=mesh.colors)
    way_points = clicks(mesh, off)
    path = Follower(SurfaceGraph(data), cost).follow(way_points)
    normal = np.array([-0.3, 0.8, 0.5])
    beside = np.abs((path.points - [1.5, 1.5, 0.1]) @ (normal / np.linalg.norm(normal)))
    # The bed is 8 cm wide, and a node 5 cm.
    assert np.percentile(beside, 90) < 0.07
    assert np.allclose(path.points[path.way_point_rows], way_points)
    assert path.snap_distances.max() == 0.0
    assert path.length == pytest.approx(
        np.linalg.norm(np.diff(path.points, axis=0), axis=1).sum(), abs=1e-12
    )


def test_every_step_is_an_edge_of_the_mesh() -> None:
    mesh, off = with_bed(hills(), np.random.default_rng(2))
    path = Follower(SurfaceGraph(mesh), "dark").follow(clicks(mesh, off))
    place = {tuple(v): i for i, v in enumerate(mesh.vertices.tolist())}
    edges = {frozenset((f[i], f[i - 1])) for f in mesh.faces.tolist() for i in range(3)}
    nodes = [place[tuple(p)] for p in path.points.tolist()]
    assert all(frozenset(pair) in edges for pair in pairwise(nodes))


@pytest.mark.parametrize("seed", range(4))
def test_path_is_shortest_on_uniform_colour(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mesh = hills()
    plain = Mesh(mesh.vertices, mesh.faces, colors=np.full((len(mesh.vertices), 3), 128, np.uint8))
    one, other = rng.integers(0, len(mesh.vertices), 2)
    path = Follower(SurfaceGraph(plain), "dark").follow(
        mesh.vertices[[one, other]], uses_whole_surface=True
    )
    a = mesh.faces.ravel()
    b = np.roll(mesh.faces, -1, axis=1).ravel()
    length = np.linalg.norm(mesh.vertices[a] - mesh.vertices[b], axis=1)
    key = np.unique(
        np.stack([np.minimum(a, b), np.maximum(a, b)], axis=1), axis=0, return_index=True
    )
    edges, rows = key
    n = len(mesh.vertices)
    graph = coo_array((length[rows], (edges[:, 0], edges[:, 1])), shape=(n, n)).tocsr()
    assert path.length == pytest.approx(dijkstra(graph, directed=False, indices=one)[other])


def test_the_best_of_all_paths_costs_no_more_than_one_in_a_corridor() -> None:
    mesh, off = with_bed(hills(), np.random.default_rng(3), noise=40.0)
    follower = Follower(SurfaceGraph(mesh), "dark")
    way_points = clicks(mesh, off)
    assert mesh.colors is not None
    costs = follower._compute_costs(follower.surface.whole_graph, None)
    place = {tuple(v): i for i, v in enumerate((mesh.vertices - follower.surface.origin).tolist())}

    def cost_of(points: np.ndarray) -> float:
        own = points - follower.surface.origin
        rows = follower.surface.tree.query(own)[1]
        step = np.linalg.norm(np.diff(own, axis=0), axis=1)
        return float((step * 0.5 * (costs[rows[:-1]] + costs[rows[1:]])).sum())

    assert place
    best = follower.follow(way_points, uses_whole_surface=True)
    near = follower.follow(way_points)
    assert cost_of(best.points) <= cost_of(near.points) + 1e-9


def test_reversed_path_has_same_length() -> None:
    mesh, off = with_bed(hills(), np.random.default_rng(4))
    follower = Follower(SurfaceGraph(mesh), "dark")
    way_points = clicks(mesh, off)[[0, 2]]
    forth, back = follower.follow(way_points), follower.follow(way_points[::-1])
    assert back.length == pytest.approx(forth.length, rel=0.02)


def test_rotating_and_shifting_model_moves_the_path() -> None:
    mesh, off = with_bed(hills(), np.random.default_rng(5))
    way_points = clicks(mesh, off)
    here = Follower(SurfaceGraph(mesh), "dark").follow(way_points)
    turn = np.radians(30.0)
    rotation = np.array(
        [[np.cos(turn), np.sin(turn), 0.0], [-np.sin(turn), np.cos(turn), 0.0], [0.0, 0.0, 1.0]]
    )
    shift = np.array([500_000.0, 4_000_000.0, 300.0])
    moved = Mesh(mesh.vertices @ rotation.T + shift, mesh.faces, colors=mesh.colors)
    there = Follower(SurfaceGraph(moved), "dark").follow(way_points @ rotation.T + shift)
    assert there.length == pytest.approx(here.length, rel=1e-6)
    assert np.allclose(there.points, here.points @ rotation.T + shift, atol=1e-6)


def test_light_gradient_curvature_and_fields_are_followed() -> None:
    count, step = 61, 0.05
    y, x = np.mgrid[0:count, 0:count] * step
    flat = grid_mesh(0.3 * np.abs(y - 1.0), step)
    yy = flat.vertices[:, 1]
    grey = np.where(np.abs(yy - 1.0) < 0.04, 230, np.where(yy > 2.0, 130, 90))
    mesh = Mesh(
        flat.vertices,
        flat.faces,
        colors=np.repeat(grey[:, None], 3, axis=1).astype(np.uint8),
        fields={"deep": np.abs(yy - 1.5)},
    )

    def typical(cost: str, level: float) -> float:
        ends = np.array(
            [[0.0, level, 0.3 * abs(level - 1.0)], [3.0, level, 0.3 * abs(level - 1.0)]]
        )
        path = Follower(SurfaceGraph(mesh), cost).follow(ends, uses_whole_surface=True)
        return float(np.median(path.points[:, 1]))

    assert typical("light", 1.2) == pytest.approx(1.0, abs=0.03)
    assert typical("curvature", 1.2) == pytest.approx(1.0, abs=0.03)
    assert typical("gradient", 1.9) == pytest.approx(2.0, abs=0.06)
    assert typical("deep", 1.7) == pytest.approx(1.5, abs=0.03)
    assert x.shape == y.shape


def test_a_textured_mesh_is_followed_to_the_pixel(tmp_path: object) -> None:
    """Two faces of one metre, and a dark line of the picture across them."""
    from pathlib import Path

    from PIL import Image

    pixels = np.full((256, 256, 3), 200, np.uint8)
    column = np.arange(256)
    height = 128 + np.round(40 * np.sin(column / 40.0)).astype(int)
    for thick in (-2, -1, 0, 1, 2):
        pixels[height + thick, column] = 30
    file = Path(str(tmp_path)) / "face.png"
    Image.fromarray(pixels).save(file)
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1]])
    mesh = Mesh(
        corners,
        np.array([[0, 1, 2], [0, 2, 3]], np.int32),
        (Material("face", file),),
        np.array([0, 2], np.int64),
        uv=corners[:, [0, 2]].astype(np.float32),
    )
    on = 1.0 - (height + 0.5) / 256.0
    ends = np.array([[0.02, 0.0, on[5]], [0.98, 0.0, on[250]]])
    path = Follower(SurfaceGraph(mesh), "dark").follow(ends)
    middle = path.points[5:-5]
    expected = np.interp(middle[:, 0], (column + 0.5) / 256.0, on)
    # The line is 5/256 m wide, and so is the way across it.
    assert np.abs(middle[:, 2] - expected).max() < 0.02
    assert path.snap_distances.max() < 0.01


def textured_bed(folder: Path, count: int, pixels: int = 1) -> tuple[Mesh, np.ndarray]:
    """Hills with the bed in a texture, so many pixels between vertices; and three on the bed."""
    mesh, off = with_bed(hills(3.0 / (count - 1), count), np.random.default_rng(7))
    assert mesh.colors is not None
    picture = folder / "bed.png"
    grid = mesh.colors.reshape(count, count, 3)[::-1]
    Image.fromarray(grid.repeat(pixels, axis=0).repeat(pixels, axis=1)).save(picture)
    index = np.arange(count**2)
    uv = (np.stack([index % count, index // count], axis=1) + 0.5) / count
    textured = Mesh(
        mesh.vertices,
        mesh.faces,
        (Material("rock", picture),),
        np.array([0, len(mesh.faces)]),
        uv.astype(np.float32),
    )
    return textured, clicks(mesh, off)


def test_long_path_on_texture_matches_path_on_vertex_colours(
    tmp_path: Path,
) -> None:
    """A long corridor has so many faces that they are not subdivided to the pixel."""
    textured, way_points = textured_bed(tmp_path, 270)
    surface = SurfaceGraph(textured)
    path = Follower(surface, "dark").follow(way_points[[0, 2]])
    assert surface.textures is not None
    colours = np.rint(surface.textures.vertex_colours).astype(np.uint8)
    coloured = Mesh(textured.vertices, textured.faces, colors=colours)
    expected = Follower(SurfaceGraph(coloured), "dark").follow(way_points[[0, 2]])
    np.testing.assert_array_equal(path.points, expected.points)


@pytest.mark.parametrize(
    ("kind", "cost"),
    [("mesh", "colour"), ("texture", "colour"), ("texture", "curvature"), ("cloud", "dark")],
)
def test_a_path_does_not_depend_on_what_was_followed_before(
    kind: str, cost: str, tmp_path: Path
) -> None:
    textured, way_points = textured_bed(tmp_path, 240, 6)
    data: Mesh | PointCloud = textured
    if kind != "texture":
        textures = SurfaceGraph(textured).textures
        assert textures is not None
        colours = np.rint(textures.vertex_colours).astype(np.uint8)
        mesh = Mesh(textured.vertices, textured.faces, colors=colours)
        data = mesh if kind == "mesh" else PointCloud(mesh.vertices, colors=mesh.colors)
    surface = SurfaceGraph(data)
    Follower(surface, cost).follow(way_points)
    Follower(surface, "dark").follow(way_points[[2, 1]])
    near = np.stack([way_points[1], way_points[1] + [0.3, 0.1, 0.0]])
    for ends in (way_points[[0, 2]], near):
        kept = Follower(surface, cost).follow(ends)
        fresh = Follower(SurfaceGraph(data), cost).follow(ends)
        np.testing.assert_array_equal(kept.points, fresh.points)
        np.testing.assert_array_equal(kept.costs, fresh.costs)


def test_corridor_has_same_roughness_as_whole_surface(
    tmp_path: Path,
) -> None:
    textured, way_points = textured_bed(tmp_path, 60, 8)
    surface = SurfaceGraph(textured)
    one, other = way_points[:2] - surface.origin
    part = surface.corridor(one, other, 1.4, 0.2)
    own = part.row >= 0
    assert own.sum() < len(part.row)  # it is subdivided
    rough = dict(zip(surface.whole_graph.row, surface.whole_graph.roughness, strict=True))
    np.testing.assert_allclose(part.roughness[own], [rough[row] for row in part.row[own]])


def test_gap_without_connecting_path_is_reported() -> None:
    mesh = hills(count=21)
    apart = mesh.vertices + [10.0, 0.0, 0.0]
    both = Mesh(
        np.concatenate([mesh.vertices, apart]),
        np.concatenate([mesh.faces, mesh.faces + len(apart)]),
    )
    with refused("path.separate-parts", GeometryError, first=1, second=2):
        Follower(SurfaceGraph(both), "curvature").follow(np.array([[0.0, 0, 0], [10.0, 0, 0]]))


def test_single_location_is_refused() -> None:
    mesh = hills(count=21)
    follower = Follower(SurfaceGraph(mesh), "curvature")
    with refused("points.coincident", GeometryError):
        follower.follow(mesh.vertices[[5, 5]])
    with refused("feature.too-few-points", GeometryError, count=1, minimum=2):
        follower.follow(mesh.vertices[[5]])


def test_coincident_points_are_refused_as_surface() -> None:
    with refused("path.no-surface", GeometryError):
        SurfaceGraph(PointCloud(np.ones((20, 3))))


def test_a_cost_that_the_model_does_not_have_is_refused() -> None:
    surface = SurfaceGraph(hills(count=21))
    with refused("model.no-colours", UsageError, field="--cost"):
        Follower(surface, "dark")
    with refused("option.not-a-choice", UsageError, value="intensity", field="--cost"):
        Follower(surface, "intensity")


def test_duplicate_points_and_nan_do_not_change_path() -> None:
    mesh, off = with_bed(hills(), np.random.default_rng(6))
    points = np.concatenate([mesh.vertices, mesh.vertices[::3], [[np.nan, 0, 0]]])
    assert mesh.colors is not None
    colours = np.concatenate([mesh.colors, mesh.colors[::3], [[0, 0, 0]]])
    once = Follower(SurfaceGraph(PointCloud(mesh.vertices, colors=mesh.colors)), "dark")
    twice = Follower(SurfaceGraph(PointCloud(points, colors=colours)), "dark")
    way_points = clicks(mesh, off)
    assert twice.follow(way_points).length == pytest.approx(once.follow(way_points).length)


@pytest.mark.slow
@pytest.mark.parametrize("mesh", [False, True])
def test_stated_95_percent_error_of_followed_traces_is_reliable(mesh: bool) -> None:
    result = population(200, 1, mesh=mesh, cost="colour")
    assert result["joint"] >= 0.93
    assert result["total"] >= 0.93
    assert result["good_but_off"] <= 0.05


def test_an_edge_is_followed_through_grain() -> None:
    """Two greys that meet along a line that bends, with as much grain as step."""
    count, step = 121, 0.025
    y, x = np.mgrid[0:count, 0:count] * step
    flat = grid_mesh(np.zeros((count, count)), step)
    bent = 1.5 + 0.2 * np.sin(2.0 * flat.vertices[:, 0])
    grain = 20.0 * np.random.default_rng(8).standard_normal(count * count)
    grey = np.where(flat.vertices[:, 1] > bent, 140.0, 100.0) + grain
    colours = np.repeat(np.clip(grey, 0, 255)[:, None], 3, axis=1).astype(np.uint8)
    mesh = Mesh(flat.vertices, flat.faces, colors=colours)
    ends = np.array([[0.0, 1.5, 0.0], [3.0, 1.5 + 0.2 * np.sin(6.0), 0.0]])
    path = Follower(SurfaceGraph(mesh), "gradient").follow(ends)
    off = np.abs(path.points[:, 1] - 1.5 - 0.2 * np.sin(2.0 * path.points[:, 0]))
    assert np.percentile(off, 90) < 3.0 * step
    assert x.shape == y.shape


def test_path_along_straight_line_has_reason_for_missing_plane() -> None:
    x = np.arange(5.0)
    straight = np.column_stack([x, 0.0 * x, 0.0 * x])
    surface = VertexSurface(straight)
    row, band, messages = fit_trace_plane(
        straight,
        surface,
        model="m",
        frame="local",
        thresholds=DEFAULT_THRESHOLDS,
        notes="",
        priors=(),
    )
    assert row is None
    assert band is None
    assert messages == (Finding("points.collinear", n=5),)
