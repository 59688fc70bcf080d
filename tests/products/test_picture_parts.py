"""What pictures are made of, against closed forms: shares, spacings, greys, sizes of texels."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rasterio
from PIL import Image

from tests.marked import UTM
from tests.messages import refused
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.geology.orientation import lines_to_vectors
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Material, Mesh
from vomstudio.geometry.view_frame import ViewFrame
from vomstudio.products.ortho import cloud_picture, mesh_picture, planning, view_directions
from vomstudio.products.ortho._mesh_kernels import blend_corners
from vomstudio.products.ortho._texture_kernels import sample_texture
from vomstudio.products.ortho.cloud_picture import CloudSource, local_spacing
from vomstudio.products.ortho.mesh_picture import MeshSource, texel_sizes
from vomstudio.products.ortho.orthophoto import write_orthophoto
from vomstudio.products.ortho.planning import ViewRegion, plan
from vomstudio.products.ortho.tiles import Grid, Tile
from vomstudio.products.ortho.view_directions import view_along_axis, view_along_line

SAME = np.eye(4)
UP = np.array([0.0, 0.0, -1.0])
"""World's up in the axes of a view straight down."""

# Which side is seen


def layers(seed: int, n: int = 4000) -> tuple[np.ndarray, np.ndarray]:
    """Two level sheets over a unit square, one half a metre behind the other, and normals: of the
    near one 30 % turn their back, of the far one all."""
    rng = np.random.default_rng(seed)
    points = np.column_stack([rng.uniform(size=(2 * n, 2)), np.repeat([0.0, 0.5], n)])
    away = (points[:, 0] < 0.3) | (points[:, 2] > 0.0)
    return points, np.column_stack([np.zeros((2 * n, 2)), np.where(away, 1.0, -1.0)])


@pytest.mark.parametrize("n", [400, 4000, 40_000, 300_000])
def test_only_front_points_of_a_cloud_count_for_the_away_facing_share(n: int) -> None:
    points, normals = layers(n, n)
    result, guessed = cloud_picture.away_facing_share(points, normals, UP)
    # Columns hold four points, or are a 256th of the extent wide: some have none of the near sheet.
    none = np.exp(-n / min(2 * n / 4, 256**2))
    assert result == pytest.approx(0.3 + 0.7 * none / (1.0 + none), abs=0.1 if n == 400 else 0.03)
    assert not guessed
    moved = points + [-7.0, 3.0, 9.0]
    again, _ = cloud_picture.away_facing_share(moved, normals, UP)
    assert again == pytest.approx(result, abs=0.05)
    # Normals that are none say nothing.
    unknown = normals.copy()
    unknown[points[:, 0] < 0.3] = 0.0
    unknown[points[:, 0] < 0.15] = np.nan
    share, _ = cloud_picture.away_facing_share(points, unknown, UP)
    assert share < 1.05 * np.exp(-2.0) + 0.05


@pytest.mark.parametrize("most", [2_000_000, 900])
def test_surfaces_without_normals_are_assumed_to_face_up(
    monkeypatch: pytest.MonkeyPatch, most: int
) -> None:
    """A roof seen from the south, level: its southern side is toward the viewer, and where it hangs
    over, the side that is seen is taken for the upper one, away from the viewer."""
    monkeypatch.setattr(cloud_picture, "_MAX_TREE_POINTS", most)
    rng = np.random.default_rng(1)
    across, rise = rng.uniform(size=(2, 3000))
    # x to the right, y down, z away from the viewer: the upper 40 % hang over.
    back = np.where(rise < 0.6, rise, 1.2 - rise)
    view = np.column_stack([across, -rise, back])
    result, guessed = cloud_picture.away_facing_share(view, None, np.array([0.0, -1.0, 0.0]))
    assert guessed
    assert result == pytest.approx(0.4, abs=0.05)
    two, guessed = cloud_picture.away_facing_share(view[:2], None, UP)
    assert np.isnan(two)
    assert guessed


def test_estimated_view_side_is_reported_and_known_side_is_not() -> None:
    rng = np.random.default_rng(2)
    points = np.column_stack([rng.uniform(size=(900, 2)), np.zeros(900)])
    up = np.tile(np.array([0.0, 0.0, 1.0], np.float32), (900, 1))
    for cloud, judged in ((PointCloud(points), True), (PointCloud(points, normals=up), False)):
        view = view_along_axis(30.0, 60.0, cloud, SAME)
        code = "view.down-plunge-estimated" if judged else "view.down-plunge"
        assert view.reason == Finding(code, share_percent=100.0)
    square = Mesh(points[:3], np.array([[0, 1, 2]], np.int32))
    assert view_along_axis(30.0, 60.0, square, SAME).reason.code == "view.down-plunge"


def test_away_facing_share_of_a_mesh_is_that_of_the_rays() -> None:
    """A quarter of a square turns its back; behind it lies one that does so all over."""

    def part(x0: float, x1: float, z: float, toward: bool) -> tuple[np.ndarray, np.ndarray]:
        corners = np.array([(x0, 0, z), (x1, 0, z), (x1, 1, z), (x0, 1, z)])
        faces = np.array([[0, 1, 2], [0, 2, 3]])
        # x right, y down, z away: this order turns its back.
        return corners, faces[:, ::-1] if toward else faces

    parts = [part(0, 0.25, 0, False), part(0.25, 1, 0, True), part(0, 1, 2, False)]
    view = np.concatenate([corners for corners, _ in parts])
    faces = np.concatenate([f + 4 * k for k, (_, f) in enumerate(parts)]).astype(np.int32)
    for rays in (64, 256):
        for scale in (1.0, 1e-3, 5e3):
            result = mesh_picture.away_facing_share(scale * view - 7.0 * scale, faces, rays)
            assert result == pytest.approx(0.25, abs=1.01 / rays)
    assert np.isnan(mesh_picture.away_facing_share(np.ones((3, 3)), np.array([[0, 1, 2]]), 8))


@pytest.mark.parametrize(("trend", "plunge"), [(0.0, 30.0), (77.0, -30.0), (200.0, -1.0)])
def test_axis_is_viewed_downward_regardless_of_its_sign(trend: float, plunge: float) -> None:
    """A level floor is seen from above."""
    corners = UTM + np.array([(0, 0, 0), (4, 0, 0), (4, 4, 0), (0, 4, 0)], float)
    floor = Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]], np.int32))
    view = view_along_axis(trend, plunge, floor, SAME)
    down = lines_to_vectors(trend, plunge) * (1.0 if plunge > 0 else -1.0)
    assert view.frame.direction == pytest.approx(down)
    assert view.sense == "down-plunge"


@pytest.mark.parametrize(("error", "depth"), [(None, 12.0), (3.0, 40.0), (0.5, 7.5)])
@pytest.mark.parametrize("metric", [True, False])
def test_cost_of_a_wrong_direction_is_computed(
    error: float | None, depth: float, metric: bool
) -> None:
    cost = view_directions.cost_of_direction(error, depth, is_metric=metric)
    angle = np.radians(5.0 if error is None else error)
    assert cost.code == ("view.axis-error-unknown" if error is None else "view.axis-error")
    assert cost.values["unit"] == ("m" if metric else "units")
    assert cost.values["share_percent"] == pytest.approx(100 * (1 - np.cos(angle)))
    assert cost.values["displacement"] == pytest.approx(depth * np.sin(angle))
    assert cost.values["depth"] == depth


@pytest.mark.parametrize("size", [1e-3, 0.3, 1.0, 40.0])
def test_face_brightness_depends_on_tilt_and_not_on_size(size: float) -> None:
    """From 1 where it looks at the viewer, either side, to 0.35 where it is seen edge-on; one that
    has no area is as dark."""
    tilt = np.radians([0.0, 30.0, 60.0, 90.0, 150.0, 180.0])
    corners = np.zeros((len(tilt) + 1, 3, 3))
    corners[:-1, 1, 0] = size
    corners[:-1, 2, 1], corners[:-1, 2, 2] = 3 * size * np.cos(tilt), 3 * size * np.sin(tilt)
    expected = [*(0.35 + 0.65 * np.abs(np.cos(tilt))), 0.35]
    assert mesh_picture._face_brightness(corners + 5.0) == pytest.approx(expected, rel=1e-6)


COLOURS = [(0.9, 0.0, 0.0), (0.0, 0.8, 0.0), (0.0, 0.0, 0.7), None]


@pytest.mark.parametrize(
    "offsets",
    [[0], [0, 6], [1, 6], [0, 5], [2, 3], [0, 0, 6], [0, 6, 6], [0, 2, 2, 5], [0, 1, 3, 4, 6]],
)
def test_every_face_has_exactly_its_own_material(offsets: list[int]) -> None:
    """Six squares in a row, seen from above: faces[o[i]:o[i + 1]] wear materials[i]."""
    corners = [(k + x, y, 0.0) for k in range(6) for x, y in ((0, 0), (2, 0), (0, 2))]
    materials = tuple(Material(f"m{i}", None, COLOURS[i]) for i in range(len(offsets) - 1))
    # Each triangle a little below the next, of which it shows one metre.
    places = np.array(corners) - np.repeat(np.arange(6.0), 3)[:, None] * [0, 0, 1.0]
    mesh = Mesh(
        places,
        np.arange(18, dtype=np.int32).reshape(-1, 3),
        materials=materials,
        material_offsets=np.array(offsets),
    )
    grid = Grid.from_bounds((0, 0), (7, 2), 0.25)
    picture = MeshSource(mesh, places, grid).draw(grid.tiles()[0])
    for k in range(6):
        (worn,) = [i for i in range(len(materials)) if offsets[i] <= k < offsets[i + 1]] or [None]
        diffuse = None if worn is None else COLOURS[worn]
        expected = (200, 200, 200) if diffuse is None else np.rint(255.0 * np.array(diffuse))
        row, column = 0, round(k / 0.25) + 1
        assert picture.rgba[row, column].tolist() == [*expected, 255]


def test_vertex_colour_takes_precedence_over_the_material() -> None:
    """Of a face without texture coordinates beside one that has them, too."""
    corners = np.array([(0, 0, 0), (2, 0, 0), (0, 2, 0)], float)
    places = np.concatenate([corners, corners + [4, 0, 0]])
    colors = np.full((6, 3), (10, 120, 230), np.uint8)
    mesh = Mesh(
        places,
        np.arange(6, dtype=np.int32).reshape(-1, 3),
        colors=colors,
        materials=(Material("m", None, (1.0, 0.0, 0.0)),),
        material_offsets=np.array([0, 2]),
    )
    grid = Grid.from_bounds((0, 0), (6, 2), 0.25)
    picture = MeshSource(mesh, places, grid).draw(grid.tiles()[0])
    for column in (2, 18):
        assert picture.rgba[2, column].tolist() == [10, 120, 230, 255]


@pytest.mark.parametrize("colored", [False, True])
@pytest.mark.parametrize("missing", [0, 1, 2])
def test_face_with_a_missing_texture_coordinate_is_drawn_untextured(
    tmp_path: Path, colored: bool, missing: int
) -> None:
    """NaN at one corner of the second triangle; the first shows its texture."""
    Image.new("RGB", (8, 8), (30, 60, 90)).save(tmp_path / "t.png")
    corners = np.array([(0, 0, 0), (2, 0, 0), (0, 2, 0)], float)
    places = np.concatenate([corners, corners + [4, 0, 0]])
    uv = np.full((6, 2), 0.5, np.float32)
    uv[3 + missing, missing % 2] = np.nan
    mesh = Mesh(
        places,
        np.arange(6, dtype=np.int32).reshape(-1, 3),
        uv=uv,
        colors=np.full((6, 3), 77, np.uint8) if colored else None,
        materials=(Material("m", tmp_path / "t.png", (1.0, 0.0, 0.5)),),
        material_offsets=np.array([0, 2]),
    )
    grid = Grid.from_bounds((0, 0), (6, 2), 0.25)
    source = MeshSource(mesh, places, grid)
    picture = source.draw(grid.tiles()[0])
    assert picture.rgba[2, 2].tolist() == [30, 60, 90, 255]
    assert picture.rgba[2, 18].tolist() == ([77, 77, 77, 255] if colored else [255, 0, 128, 255])
    assert source.warnings() == []


# Points


def test_point_spacing_of_a_cloud_is_local() -> None:
    """Even points at 0.1 m, elsewhere at 0.05 m: cells of 0.6 m hold 36 and 144 of them."""

    def even(left: float, pitch: float) -> np.ndarray:
        own = np.arange(0.0, 3.6, pitch) + 0.5 * pitch
        return np.array([(left + x, y, 0.0) for x in own for y in own])

    coarse, fine = even(0.0, 0.1), even(3.6, 0.05)
    corner = np.array([[0.0, 0.0, 0.0]])  # where the first cell begins
    result = local_spacing(np.concatenate([corner, coarse, fine]), 0.1)[1:]
    first, rest = result[: len(coarse)], result[len(coarse) :]
    beside = np.hypot(*coarse[:, :2].T) > 0.9
    assert first[beside] == pytest.approx(np.full(beside.sum(), 0.1))
    assert rest == pytest.approx(np.full(len(fine), 0.05))
    # Within half and twice the typical one.
    lone = np.array([[40.0, 40.0, 0.0]])
    crowd = 60.0 + 0.001 * np.random.default_rng(0).uniform(size=(900, 3))
    ends = local_spacing(np.concatenate([corner, coarse, lone, crowd]), 0.1)[1 + len(coarse) :]
    assert ends[0] == pytest.approx(0.2)
    assert ends[1:] == pytest.approx(np.full(900, 0.05))


@pytest.mark.parametrize("name", ["intensity", "Intensity", None])
def test_cloud_without_colours_is_grey_by_intensity_or_else_by_depth(
    name: str | None,
) -> None:
    """From 40 to 240 between the 2nd and the 98th of a hundred parts."""
    rng = np.random.default_rng(3)
    view = rng.uniform(size=(500, 3))
    values = np.where(np.arange(500) % 50 == 7, np.nan, 900.0 * rng.uniform(size=500) ** 2)
    fields = {"other": np.arange(500.0), "short": np.arange(3.0)}
    if name is not None:
        fields[name] = values
    shown = view[:, 2] if name is None else values
    result = cloud_picture._colors(PointCloud(view, fields=fields), view)
    low, high = np.nanquantile(shown, [0.02, 0.98])
    expected = 40.0 + 200.0 * np.clip((np.nan_to_num(shown, nan=low) - low) / (high - low), 0, 1)
    assert np.abs(result - expected[:, None]).max() < 1.0
    assert result.dtype == np.uint8
    assert (result.min(), result.max()) == (40, 240)
    even = cloud_picture._colors(PointCloud(view), np.zeros_like(view))
    assert (even == 40).all()
    own = rng.integers(0, 256, (500, 3), np.uint8)
    coloured = PointCloud(view, own, fields=fields)
    assert np.array_equal(cloud_picture._colors(coloured, view), own)


@pytest.mark.parametrize(("spacing", "gsd"), [(0.1, 0.02), (0.1, 0.4)])
def test_holes_are_closed_up_to_four_spacings_or_two_pixels(spacing: float, gsd: float) -> None:
    own = np.arange(0.0, 2.0, spacing)
    view = np.array([(x, y, 0.0) for x in own for y in own])
    source = CloudSource(PointCloud(view), view, Grid.from_bounds((0, 0), (2, 2), gsd), spacing)
    assert source.hole_m == pytest.approx(max(4.0 * spacing, 2.0 * gsd))
    assert source.warnings() == []


def test_a_tile_without_points_is_empty() -> None:
    view = np.array([[0.5, 0.5, 1.0], [0.6, 0.6, 1.0]])
    grid = Grid(0.0, 0.0, 0.01, 1500, 100)
    source = CloudSource(PointCloud(view), view, grid, 0.05)
    picture = source.draw(grid.tiles()[1])
    assert picture.rgba.shape == (100, 476, 4)
    assert not picture.rgba.any()
    assert np.isnan(picture.depth).all()
    assert picture.filled == 0
    assert source.draw(grid.tiles()[0]).rgba.any()


# Textures


def paved(folder: Path, sizes: list[tuple[float, int]], uv: bool = True) -> Mesh:
    """Level squares side by side, each with its own texture: (side in m, pixels of its picture)."""
    corners, parts, materials = [], [], []
    for k, (side, pixels) in enumerate(sizes):
        Image.new("RGB", (pixels, pixels), (50 * k, 90, 90)).save(folder / f"{k}.png")
        materials.append(Material(f"m{k}", folder / f"{k}.png", None))
        square = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], float)
        corners.append(square * side + [20.0 * k, 0, 0])
        parts.append(np.array([[0, 1, 2], [0, 2, 3]], np.int32) + 4 * k)
    own = np.tile(np.array([(0, 0), (1, 0), (1, 1), (0, 1)], np.float32), (len(sizes), 1))
    return Mesh(
        np.concatenate(corners),
        np.concatenate(parts),
        uv=own if uv else None,
        materials=tuple(materials),
        material_offsets=2 * np.arange(len(sizes) + 1),
    )


def test_texel_size_is_face_size_over_picture_size(tmp_path: Path) -> None:
    mesh = paved(tmp_path, [(2.0, 100), (3.0, 60)])
    result = texel_sizes(mesh, mesh.vertices)
    assert result[tmp_path / "0.png"] == pytest.approx((0.02, 0.02, 4.0))
    assert result[tmp_path / "1.png"] == pytest.approx((0.05, 0.05, 9.0))
    thrice = texel_sizes(mesh, 3.0 * mesh.vertices)
    assert thrice[tmp_path / "0.png"] == pytest.approx((0.06, 0.06, 36.0))
    (tmp_path / "1.png").write_bytes(b"no picture")
    assert list(texel_sizes(mesh, mesh.vertices)) == [tmp_path / "0.png"]
    assert texel_sizes(paved(tmp_path, [(2.0, 100)], uv=False), mesh.vertices) == {}


@pytest.mark.parametrize("seed", range(4))
def test_typical_texel_is_the_area_median_and_the_finest_ignores_one_percent(
    tmp_path: Path, seed: int
) -> None:
    """Loose triangles on one picture, each with texels of its own size."""
    rng = np.random.default_rng(seed)
    n, pixels = 300, 64
    Image.new("RGB", (pixels, pixels)).save(tmp_path / "t.png")
    texel = 10.0 ** rng.uniform(-3, 0, n)
    legs = rng.uniform(1.0, 30.0, n)  # in texels
    corners = np.zeros((n, 3, 3))
    corners[:, 1, 0] = corners[:, 2, 1] = legs * texel
    uv = np.zeros((n, 3, 2), np.float32)
    uv[:, 1, 0] = uv[:, 2, 1] = legs / pixels
    mesh = Mesh(
        corners.reshape(-1, 3),
        np.arange(3 * n, dtype=np.int32).reshape(-1, 3),
        uv=uv.reshape(-1, 2),
        materials=(Material("m", tmp_path / "t.png", None),),
        material_offsets=np.array([0, n]),
    )
    area = 0.5 * (legs * texel) ** 2
    low, middle, total = texel_sizes(mesh, mesh.vertices)[tmp_path / "t.png"]
    assert total == pytest.approx(area.sum(), rel=1e-5)
    for result, share in ((low, 0.01), (middle, 0.5)):
        finer = area[texel < result * (1 - 1e-4)].sum() / area.sum()
        upto = area[texel < result * (1 + 1e-4)].sum() / area.sum()
        assert finer < share <= upto + 1e-6


def test_default_pixel_size_is_the_median_texel_by_area(tmp_path: Path) -> None:
    """4, 9 and 16 square metres with texels of 1, 10 and 3 cm: 3 cm leave half on either side."""
    mesh = paved(tmp_path, [(2.0, 200), (3.0, 30), (4.0, 133)])
    result, code = planning.default_gsd(mesh, SAME, 10.0)
    assert result == pytest.approx(0.03)
    assert code == "gsd.texture"
    assert planning.default_gsd(mesh, np.diag([2.0, 2, 2, 1]), 10.0)[0] == pytest.approx(0.06)
    bare = replace(mesh, uv=None)
    assert planning.default_gsd(bare, SAME, 10.0)[1] == "gsd.edges"


@pytest.mark.parametrize(("gsd", "coarser"), [(0.009, 0), (0.019, 0), (0.021, 1), (0.041, 2)])
def test_levels_finer_than_a_pixel_are_not_decoded(
    tmp_path: Path, gsd: float, coarser: int
) -> None:
    mesh = paved(tmp_path, [(1.0, 100)])
    source = MeshSource(mesh, mesh.vertices, Grid.from_bounds((0, 0), (1, 1), gsd))
    assert source._skipped_level_counts() == {tmp_path / "0.png": coarser}


def test_pixel_over_a_square_of_texels_is_their_mean() -> None:
    """Four by four texels to a pixel, to the last digit: there is no long side."""
    rng = np.random.default_rng(4)
    fine = rng.integers(0, 256, (16, 16, 3)).astype(np.uint8)
    levels = [fine]
    while levels[-1].shape[0] > 1:
        below = levels[-1].astype(float)
        half = below.reshape(below.shape[0] // 2, 2, -1, 2, 3).mean(axis=(1, 3))
        levels.append(np.rint(half).astype(np.uint8))
    view = np.array([[0.0, 0, 0], [4, 0, 0], [0, 4, 0], [4, 4, 0]])
    uv = np.array([[0, 1], [1, 1], [0, 0], [1, 0]], np.float32)
    faces = np.array([[0, 1, 2], [1, 3, 2]], np.int32)
    sizes = np.array([[m.shape[1], m.shape[0]] for m in levels], np.int64)
    offsets = np.cumsum([0, *(m.size for m in levels)])[:-1].astype(np.int64)
    texels = np.concatenate([m.ravel() for m in levels])
    for i, j in ((0, 0), (1, 1), (2, 0), (0, 2)):  # of the first triangle
        u, v = (i + 0.5) / 4, (j + 0.5) / 4
        rgb = np.zeros((1, 3), np.uint8)
        sample_texture(
            texels,
            offsets,
            sizes,
            16.0,
            16.0,
            np.array([0]),
            np.array([0], np.int32),
            np.array([[u, v]]),
            view,
            faces,
            uv,
            1.0,
            rgb,
        )
        assert np.array_equal(rgb[0], levels[2][j, i])


@pytest.mark.parametrize("value", [0, 1, 254, 255])
def test_black_stays_black_and_white_stays_white(value: int) -> None:
    colors = np.full((3, 3), value, np.uint8)
    weights = np.array([[0.0, 0.0], [0.25, 0.5], [1.0, 0.0], [0.5, 0.5]])
    rows, face = np.arange(4), np.zeros(4, np.int32)
    faces = np.array([[0, 1, 2]], np.int32)
    rgb = np.full((4, 3), 99, np.uint8)
    blend_corners(rows, face, weights, faces, colors, rgb)
    assert (rgb == value).all()
    view = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    uv = np.array([[0, 0], [1, 0], [0, 1]], np.float32)
    sample_texture(
        np.full(3, value, np.uint8),
        np.array([0]),
        np.array([[1, 1]]),
        1.0,
        1.0,
        rows,
        face,
        weights,
        view,
        faces,
        uv,
        0.1,
        rgb,
    )
    assert (rgb == value).all()


# Grids


@pytest.mark.parametrize("seed", range(3))
def test_tiles_cover_every_pixel_once(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for width, height in [*rng.integers(1, 3500, (5, 2)), (1024, 1025), (1023, 2048)]:
        grid = Grid(0.0, 0.0, 0.1, int(width), int(height))
        count = np.zeros((height, width), np.uint8)
        for number, tile in enumerate(grid.tiles()):
            assert tile.number == number
            assert max(tile.width, tile.height) <= 1024
            count[tile.row : tile.row + tile.height, tile.column : tile.column + tile.width] += 1
        assert (count == 1).all()
        assert number + 1 == grid.columns * grid.rows
    assert isinstance(grid.tiles()[0], Tile)


@pytest.mark.parametrize(("trend", "plunge"), [(0, 90), (0, -90), (130, 35)])
def test_region_is_clipped_to_the_model(trend: float, plunge: float) -> None:
    rng = np.random.default_rng(6)
    cloud = PointCloud(UTM + rng.uniform(-5.0, 5.0, (3000, 3)))
    view = view_along_line(trend, plunge)
    whole = plan(cloud, view, to_world=SAME, gsd=0.1)
    frame = ViewFrame.from_direction(lines_to_vectors(trend, plunge))
    own = (cloud.points - whole.reference) @ np.stack([frame.right, frame.down], axis=1)
    low, high = own.min(axis=0), own.max(axis=0)
    for at, size in (((0.5, 0.2), (3.0, 2.0)), ((4.0, -4.0), (3.0, 6.0)), ((0, 0), (99.0, 1.0))):
        centre = whole.reference + at[0] * frame.right + at[1] * frame.down
        region = ViewRegion(tuple(centre.tolist()), *size)
        part = plan(cloud, view, to_world=SAME, gsd=0.1, region=region).grid
        first = np.maximum(low, np.array(at) - np.array(size) / 2)
        last = np.minimum(high, np.array(at) + np.array(size) / 2)
        assert [part.width, part.height] == np.ceil((last - first) / 0.1 - 1e-6).tolist()
        middle = np.array([part.left, part.top]) + 0.05 * np.array([part.width, part.height])
        assert middle == pytest.approx((first + last) / 2, abs=1e-6)
    outside = whole.reference + 9.0 * frame.right
    with refused("view.part-empty"):
        plan(cloud, view, to_world=SAME, gsd=0.1, region=ViewRegion(tuple(outside), 1.0, 1.0))


@pytest.mark.parametrize("gsd", [0.0, -1.0, np.nan, np.inf])
def test_pixel_size_must_be_a_positive_length(gsd: float) -> None:
    cloud = PointCloud(np.random.default_rng(0).uniform(size=(9, 3)))
    with refused("number.not-positive", UsageError, field="--gsd"):
        plan(cloud, view_along_line(0, 90), to_world=SAME, gsd=gsd)


def test_finest_possible_pixel_size_is_rounded_up_to_two_digits(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Sought one after the other; with a border of one pixel counted, as a picture may have."""
    monkeypatch.setattr(planning, "MAX_PIXELS", 1_000_000)
    rng = np.random.default_rng(7)
    for width, height in [*(10.0 ** rng.uniform(-1, 2, (60, 2))), (1.0, 0.0), (900.0, 0.1)]:
        result = planning._min_gsd(np.array([width, height]))

        def fits(gsd: float, width: float = width, height: float = height) -> bool:
            across, down = (np.ceil(v / gsd + 1) for v in (width, height))
            return bool(across * down <= 1_000_000)

        assert fits(result * (1 + 1e-9))
        step = 10.0 ** (np.floor(np.log10(result * (1 + 1e-9))) - 1)
        assert result / step == pytest.approx(round(result / step), abs=1e-6)
        floor = max(np.sqrt(width * height / 1e6), max(width, height) / 1e6)
        assert not fits(result - step) or result - step < floor * (1 + 1e-9)


@pytest.mark.parametrize(("plunge", "sign"), [(90.0, 1), (-90.0, -1)])
def test_map_pixels_match_its_world_file_and_matrix(
    tmp_path: Path, plunge: float, sign: int
) -> None:
    """Seen from below it is mirrored: to keep North up, East is on the left."""
    corners = UTM + np.array([(0, 0, 0), (3, 0, 0), (3, 2, 0), (0, 2, 0)], float)
    mesh = Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]], np.int32))
    planned = plan(mesh, view_along_line(0, plunge), to_world=SAME, gsd=0.25)
    output = write_orthophoto(mesh, planned, tmp_path / "m.tif")
    assert output.world_file is not None
    a, d, b, e, x, y = (float(line) for line in output.world_file.read_text().split())
    matrix = planned.pixel_to_world
    for column, row in ((0, 0), (11, 7), (3, 5)):
        # A world file has the centre of the first pixel.
        world = (matrix @ [column + 0.5, row + 0.5, 0.0, 1.0])[:2]
        assert (a * column + b * row + x, d * column + e * row + y) == pytest.approx(tuple(world))
        with rasterio.open(output.depth) as file:
            assert file.xy(row, column) == pytest.approx(tuple(world))
    assert abs(a) + abs(b) == pytest.approx(0.25)
    assert np.sign(a * e - b * d) == -sign
    facts: dict[str, Any] = output.metadata
    assert (facts["width"], facts["height"]) in ((12, 8), (8, 12))
    assert facts["crs"] is None
    assert output.warnings[-1].code == "raster.no-crs"
