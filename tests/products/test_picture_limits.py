"""Pictures at the ends of what they are made for: lone points, crumbs of pixels, huge files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Material, Mesh
from vomstudio.products.ortho.cloud_picture import CloudSource, away_facing_share
from vomstudio.products.ortho.mesh_picture import texel_sizes
from vomstudio.products.ortho.orthophoto import _ReducedPicture
from vomstudio.products.ortho.textures import load_pyramid, picture_size
from vomstudio.products.ortho.tiles import Grid


@pytest.mark.parametrize("seed", range(3))
def test_every_point_of_a_cloud_is_visible_and_small(seed: int) -> None:
    """However small the points are against a pixel, and wherever in it they lie: a corner of a
    pixel is 0.71 of its side from the centre."""
    rng = np.random.default_rng(seed)
    places = 10.0 * np.array([(i, j) for i in range(6) for j in range(6)]) + 5.0
    places += rng.uniform(0.0, 1.0, places.shape)
    places[:2] = [[5.0, 5.0], [5.0, 16.0]]  # at corners of pixels
    view = np.column_stack([places, np.zeros(len(places))])
    grid = Grid(0.0, 0.0, 1.0, 70, 70)
    colors = np.full((len(view), 3), 90, np.uint8)
    picture = CloudSource(PointCloud(view, colors), view, grid, 0.01).draw(grid.tiles()[0])
    seen = picture.rgba[..., 3] > 0
    for x, y in places:
        row, column = np.nonzero(seen)
        near = np.hypot(column + 0.5 - x, row + 0.5 - y)
        assert 1 <= (near < 5.0).sum() <= 4
    assert (picture.rgba[seen] == (90, 90, 90, 255)).all()


@pytest.mark.parametrize(("close", "gap"), [(4, 7), (4, 8), (6, 11)])
@pytest.mark.parametrize("shift", [0.0, 3.0, 9.0])
def test_points_beyond_a_tile_are_considered_when_closing_holes(
    monkeypatch: pytest.MonkeyPatch, close: int, gap: int, shift: float
) -> None:
    """Stripes of points with gaps between them that are closed or not, across the edges of small
    tiles; a tile that looked less far than twice the closing would differ from the whole."""
    from vomstudio.products.ortho import tiles

    along = np.arange(0.5, 64.0)
    across = [shift + 0.5 + k * (gap + 1) for k in range(64 // (gap + 1))]
    view = np.array([(x, y, 0.0) for x in across for y in along])
    view = np.concatenate([view, view[:, [1, 0, 2]] + [0, 20.0, 0]])
    colors = np.random.default_rng(0).integers(0, 256, (len(view), 3), np.uint8)
    cloud = PointCloud(view, colors)

    def alpha() -> np.ndarray:
        grid = Grid(0.0, 0.0, 1.0, 64, 64)
        source = CloudSource(cloud, view, grid, close / 2.0)
        assert source._closing_radius == close
        source._radii[:] = 0.8
        out = np.zeros((64, 64), np.uint8)
        for tile in grid.tiles():
            part = source.draw(tile).rgba[..., 3]
            rows = slice(tile.row, tile.row + tile.height)
            out[rows, tile.column : tile.column + tile.width] = part
        return out

    whole = alpha()
    monkeypatch.setattr(tiles, "TILE", 16)
    assert np.array_equal(alpha(), whole)
    assert 0 < (whole == 0).sum() < whole.size


@pytest.mark.parametrize(
    ("extent", "pixels"), [(100.0, 100), (100.0 + 5e-8, 100), (100.0 + 5e-5, 101), (99.9, 100)]
)
def test_rounding_error_adds_no_extra_pixel(extent: float, pixels: int) -> None:
    grid = Grid.from_bounds((0.0, 0.0), (extent * 0.1, 0.0), 0.1)
    assert (grid.width, grid.height) == (pixels, 1)


@pytest.mark.parametrize(("width", "factor"), [(2_457_600, 1024), (9_000_000, 1024)])
def test_sheet_is_reduced_to_at_most_one_pixel_per_tile(width: int, factor: int) -> None:
    """Or a pixel would be shared between tiles that come one by one."""
    assert _ReducedPicture(Grid(0.0, 0.0, 0.1, width, 10)).factor == factor


def test_faces_without_an_area_have_no_texels(tmp_path: Path) -> None:
    """On the surface or on the picture; the others count."""
    Image.new("RGB", (100, 100)).save(tmp_path / "t.png")
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0)], float)
    flat = np.array([(0, 0, 0), (1, 0, 0), (2, 0, 0)], float)
    own = np.array([(0, 0), (0.5, 0), (0, 0.5)], np.float32)
    places = np.concatenate([corners, flat, corners, 0.01 * corners])
    uv = np.concatenate([own, own, np.full((3, 2), 0.3, np.float32), 0.01 * own])
    mesh = Mesh(
        places,
        np.arange(12, dtype=np.int32).reshape(-1, 3),
        uv=uv,
        materials=(Material("m", tmp_path / "t.png"),),
        material_offsets=np.array([0, 4]),
    )
    low, middle, area = texel_sizes(mesh, mesh.vertices)[tmp_path / "t.png"]
    assert (low, middle) == pytest.approx((0.02, 0.02), rel=1e-3)
    assert area == pytest.approx(0.50005)
    none = Mesh(
        flat,
        np.array([[0, 1, 2]], np.int32),
        uv=own,
        materials=mesh.materials,
        material_offsets=np.array([0, 1]),
    )
    assert texel_sizes(none, none.vertices) == {}


def test_a_texture_may_be_larger_than_pillow_expects(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its limit is there for pictures from strangers; textures of outcrops are huge."""
    Image.new("RGB", (40, 30), (9, 8, 7)).save(tmp_path / "t.png")
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 10)
    assert picture_size(tmp_path / "t.png") == (40, 30)
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 10)
    pyramid = load_pyramid(tmp_path / "t.png", 0)
    assert pyramid is not None
    assert pyramid.size == (40, 30)


@pytest.mark.parametrize("side", [2, 3, 6])
def test_away_facing_share_of_few_clusters_counts_each_once(side: int) -> None:
    """Crowds of 25 points on one place each, far apart; every other crowd turns its back."""
    rng = np.random.default_rng(side)
    at = 10.0 * np.array([(i, j) for j in range(side) for i in range(side)], float) + 0.37
    places = np.repeat(at, 25, axis=0) + 1e-6 * rng.uniform(size=(25 * side**2, 2))
    view = np.column_stack([places, rng.uniform(size=len(places))])
    away = np.repeat(np.arange(side**2) % 2 == 0, 25)
    normals = np.column_stack([np.zeros((len(view), 2)), np.where(away, 0.3, -0.3)])
    up = np.array([0.0, -1.0, 0.0])
    share, guessed = away_facing_share(view, normals, up)
    assert share == pytest.approx(np.ceil(side**2 / 2) / side**2)
    assert not guessed
