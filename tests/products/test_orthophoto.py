"""Orthophotos: places, sides, files."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rasterio

from tests.marked import SPAN, UTM, found_dots, height, marked_cloud, marked_mesh
from tests.messages import by_code, figures, refused
from tests.tiers import first_in_default_tier
from vomstudio.core.errors import Cancelled, InputError, TargetError, UsageError
from vomstudio.core.progress import CancelToken, SilentProgress
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.frames import WORLD_NORTHS
from vomstudio.geometry.mesh import Material, Mesh
from vomstudio.products.ortho import orthophoto, planning, tiles, view_directions
from vomstudio.products.ortho.orthophoto import write_orthophoto
from vomstudio.products.ortho.planning import plan
from vomstudio.products.ortho.view_description import direction_text
from vomstudio.products.ortho.view_directions import (
    view_against_plane,
    view_along_axis,
    view_along_line,
)
from vomstudio.products.sample.check import Check
from vomstudio.products.sample.report import format_text

SAME = np.eye(4)
VIEWS = [(0, 90), (40, 35), (305, 62), (180, -90), (220, 50)]


def make(
    data: Any, view: view_directions.ViewDirection, folder: Path, gsd: float | None, **more: Any
) -> Any:
    """Write an orthophoto and return (made, rgba, depth, facts)."""
    planned = plan(data, view, to_world=SAME, gsd=gsd)
    output = write_orthophoto(data, planned, folder / "o.tif", force=True, **more)
    with rasterio.open(output.image) as file:
        rgba = np.moveaxis(file.read(), 0, 2)
    with rasterio.open(output.depth) as file:
        depth = file.read(1)
    return output, rgba, depth, json.loads(output.sidecar.read_text("utf-8"))


def quad(corners: Any, colors: Any = None, material: Material | None = None) -> Mesh:
    """Two triangles, with vertex colours or a material."""
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    parts = (
        {}
        if material is None
        else {"materials": (material,), "material_offsets": np.array([0, 2], np.int64)}
    )
    return Mesh(
        np.asarray(corners, np.float64),
        faces,
        uv=np.array([(0, 0), (1, 0), (1, 1), (0, 1)], np.float32),
        colors=None if colors is None else np.asarray(colors, np.uint8),
        **parts,
    )


# Places ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(("trend", "plunge"), first_in_default_tier(VIEWS, 3))
@pytest.mark.parametrize("gsd", first_in_default_tier([0.0041, 0.0093], 3))
def test_texture_marks_are_drawn_at_their_matrix_positions(tmp_path, trend, plunge, gsd) -> None:  # type: ignore[no-untyped-def]
    mesh, places = marked_mesh(tmp_path)
    _, rgba, depth, facts = make(mesh, view_along_line(trend, plunge), tmp_path, gsd)
    matrix = np.array(facts["pixel_to_world"])
    expected, measured = found_dots(rgba, matrix, places, radius=round(0.06 / gsd))
    error = np.hypot(*(measured - expected).T)
    assert error.mean() < 0.05
    assert np.abs((measured - expected).mean(axis=0)).max() < 0.02
    # And back: the pixel of each dot with its depth is the dot, to within the pixel.
    column, row = np.floor(expected).astype(int).T
    pixels = np.column_stack([column + 0.5, row + 0.5, depth[row, column], np.ones(len(row))])
    assert np.abs((pixels @ matrix.T)[:, :3] - places).max() < 3 * gsd


@pytest.mark.parametrize(("trend", "plunge"), first_in_default_tier(VIEWS))
def test_cloud_marks_are_drawn_at_their_matrix_positions(tmp_path, trend, plunge) -> None:  # type: ignore[no-untyped-def]
    cloud, places = marked_cloud()
    gsd = 0.01
    output, rgba, _, facts = make(cloud, view_along_line(trend, plunge), tmp_path, gsd)
    expected, measured = found_dots(rgba, np.array(facts["pixel_to_world"]), places, radius=16)
    error = np.hypot(*(measured - expected).T)
    assert error.mean() < 0.1
    assert np.abs((measured - expected).mean(axis=0)).max() < 0.04
    if abs(plunge) == 90:
        assert output.coverage > 0.99


def test_every_pixel_with_depth_lies_on_the_surface(tmp_path: Path) -> None:
    cloud, _ = marked_cloud()
    _, rgba, depth, facts = make(cloud, view_along_line(40, 50), tmp_path, 0.01)
    assert ((rgba[..., 3] > 0) == np.isfinite(depth)).all()
    row, column = np.nonzero(np.isfinite(depth))
    pixels = np.column_stack([column + 0.5, row + 0.5, depth[row, column], np.ones(len(row))])
    p = (pixels @ np.array(facts["pixel_to_world"]).T)[:, :3] - UTM
    inside = (np.abs(p[:, :2]) < SPAN / 2 - 0.05).all(axis=1)
    off = np.abs(p[inside, 2] - height(*p[inside, :2].T))
    assert np.median(off) < 0.002
    assert np.quantile(off, 0.99) < 0.03


def test_a_mesh_pixel_with_its_depth_is_a_point_of_the_mesh(tmp_path: Path) -> None:
    tilted = UTM + np.array([(0, 0, 0), (3, 0, 1), (3, 2, 2), (0, 2, 1)])  # z = x / 3 + y / 2
    _, rgba, depth, facts = make(quad(tilted), view_along_line(70, 40), tmp_path, 0.01)
    assert ((rgba[..., 3] > 0) == np.isfinite(depth)).all()
    row, column = np.nonzero(rgba[..., 3] == 255)
    pixels = np.column_stack([column + 0.5, row + 0.5, depth[row, column], np.ones(len(row))])
    p = (pixels @ np.array(facts["pixel_to_world"]).T)[:, :3] - UTM
    assert np.abs(p[:, 2] - p[:, 0] / 3 - p[:, 1] / 2).max() < 1e-5
    assert facts["reference_point"] == pytest.approx((UTM + (1.5, 1, 1)).tolist())


def test_nearest_surface_is_visible_and_depth_increases_with_distance(tmp_path: Path) -> None:
    square = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], float)
    low, high = quad(square), quad(square * (0.5, 1, 1) + (0, 0, 2))
    both = Mesh(
        np.concatenate([low.vertices, high.vertices]),
        np.concatenate([low.faces, high.faces + 4]),
        colors=np.repeat(np.array([[200, 0, 0], [0, 200, 0]], np.uint8), 4, axis=0),
    )
    _, rgba, depth, _ = make(both, view_along_line(0, 90), tmp_path, 0.1)
    assert rgba.shape == (10, 10, 4)
    assert (rgba[:, :4, 1] == 200).all()
    assert (rgba[:, 6:, 0] == 200).all()
    assert depth[5, 1] == pytest.approx(-1.0)
    assert depth[5, 8] == pytest.approx(1.0)


# Sides ----------------------------------------------------------------------------------------


def test_flipping_mirrors_left_and_right(tmp_path: Path) -> None:
    # Seen edge to edge a sheet shows the same texture from both sides.
    mesh, _ = marked_mesh(tmp_path)
    flat = replace(mesh, vertices=mesh.vertices * (1, 1, 0) + (0, 0, 100))
    for trend, plunge in ((0, 90), (30, 50)):
        view = view_along_line(trend, plunge)
        _, one, near, _ = make(flat, view, tmp_path, 0.013)
        _, other, far, facts = make(flat, view.flipped(), tmp_path, 0.013)
        assert np.abs(one.astype(int) - other[:, ::-1].astype(int)).max() <= 1
        whole = one[..., 3] == 255  # of a pixel that is partly covered, depth is the nearest part's
        assert near[whole] == pytest.approx(-far[:, ::-1][whole], abs=1e-5)
        assert facts["sense"] == view_directions.REVERSED
        assert facts["plunge_deg"] == -plunge


def test_vertical_plane_is_viewed_toward_dip_direction_plus_180() -> None:
    view = view_against_plane(Plane(120.0, 90.0))
    assert view.trend_deg == pytest.approx(300.0)
    assert view.plunge_deg == pytest.approx(0.0)
    assert view.frame.direction == pytest.approx(-Plane(120.0, 90.0).normal())
    steep = view_against_plane(Plane(120.0, 60.0))
    assert (steep.trend_deg, steep.plunge_deg) == (pytest.approx(300), pytest.approx(30))
    assert view_against_plane(Plane(0.0, 0.0)).frame.right == pytest.approx((1, 0, 0))


def test_a_plane_seen_along_its_normal_keeps_its_true_shape(tmp_path: Path) -> None:
    plane = Plane(120.0, 60.0)
    frame = view_against_plane(plane).frame
    corners = UTM + np.array([(0, 0), (3, 0), (3, 2), (0, 2)]) @ np.stack([frame.right, frame.down])
    output, rgba, depth, _ = make(quad(corners), view_against_plane(plane), tmp_path, 0.01)
    assert rgba.shape[:2] == (200, 300)
    assert output.coverage == 1.0
    assert np.abs(depth).max() < 1e-6


def gutter(inside_out: bool) -> Mesh:
    """A cliff dipping 70 toward South, its outside to the South."""
    top = np.array([(0, 0, 10), (20, 0, 10)], float)
    foot = top + (0, -10 / np.tan(np.radians(70)), -10)
    corners = UTM + np.array([foot[0], foot[1], top[1], top[0]])
    mesh = quad(corners)
    return replace(mesh, faces=mesh.faces[:, ::-1].copy()) if inside_out else mesh


def test_axis_is_viewed_from_the_exposed_side() -> None:
    cliff = gutter(False)
    toward = view_along_axis(0.0, 10.0, cliff, SAME)  # North, down: the cliff faces the viewer
    assert (toward.sense, toward.trend_deg, toward.plunge_deg) == ("down-plunge", 0.0, 10.0)
    behind = view_along_axis(180.0, 10.0, cliff, SAME)  # from within the rock
    assert behind.sense == "up-plunge"
    assert behind.trend_deg % 360 == pytest.approx(0.0)
    assert behind.plunge_deg == pytest.approx(-10.0)
    assert behind.reason.code == "view.up-plunge"
    assert behind.reason.values["share_percent"] == pytest.approx(100.0)
    assert view_along_axis(180.0, 10.0, gutter(True), SAME).sense == "down-plunge"
    assert behind.flipped().sense == "down-plunge"


def test_the_exposed_side_of_a_cloud_is_found_with_and_without_normals() -> None:
    rng = np.random.default_rng(5)
    cliff = gutter(False).vertices
    t = rng.uniform(size=(4000, 2))
    points = cliff[0] + t[:, :1] * (cliff[1] - cliff[0]) + t[:, 1:] * (cliff[3] - cliff[0])
    bare = PointCloud(points)
    guessed = view_along_axis(180.0, 10.0, bare, SAME)
    assert guessed.sense == "up-plunge"
    assert guessed.reason.code == "view.up-plunge-estimated"
    outward = np.array([0, -np.sin(np.radians(70)), np.cos(np.radians(70))], np.float32)
    known = replace(bare, normals=np.tile(outward, (len(points), 1)))
    assert view_along_axis(180.0, 10.0, known, SAME).sense == "up-plunge"
    turned = replace(bare, normals=np.tile(-outward, (len(points), 1)))
    assert view_along_axis(180.0, 10.0, turned, SAME).sense == "down-plunge"
    assert view_along_axis(0.0, 10.0, bare, SAME).sense == "down-plunge"


@pytest.mark.parametrize("kind", ["mesh", "cloud"])
def test_rotating_world_and_view_together_changes_nothing(tmp_path: Path, kind: str) -> None:
    data = marked_mesh(tmp_path)[0] if kind == "mesh" else marked_cloud(40_000)[0]
    c, s = np.cos(np.radians(30)), np.sin(np.radians(30))
    turn = np.array([(c, -s, 0), (s, c, 0), (0, 0, 1)])  # anticlockwise: azimuths fall by 30
    if isinstance(data, Mesh):
        turned: Any = replace(data, vertices=(data.vertices - UTM) @ turn.T + UTM)
    else:
        turned = replace(data, points=(data.points - UTM) @ turn.T + UTM)
    _, one, _, _ = make(data, view_along_line(75, 40), tmp_path, 0.02)
    _, other, _, _ = make(turned, view_along_line(45, 40), tmp_path, 0.02)
    assert one.shape == other.shape
    assert (np.abs(one.astype(int) - other.astype(int)).max(axis=2) <= 2).mean() > 0.999


# Surfaces -------------------------------------------------------------------------------------


def test_a_fine_texture_is_averaged_over_the_pixel(tmp_path: Path) -> None:
    from PIL import Image

    board = (np.indices((512, 512)).sum(axis=0) % 2 * 255).astype(np.uint8)
    Image.fromarray(board).convert("RGB").save(tmp_path / "board.png")
    mesh = quad(
        [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], None, Material("m", tmp_path / "board.png")
    )
    for trend, plunge in ((0, 90), (0, 8)):
        _, rgba, _, _ = make(mesh, view_along_line(trend, plunge), tmp_path, 0.017)
        inner = rgba[2:-2, 2:-2]
        assert np.abs(inner[..., :3].astype(int) - 127).max() < 8


def test_a_steep_face_stays_sharp_across_its_slope(tmp_path: Path) -> None:
    from PIL import Image

    stripes = np.repeat((np.arange(256) // 8 % 2 * 255).astype(np.uint8)[None], 256, axis=0)
    Image.fromarray(stripes).convert("RGB").save(tmp_path / "stripes.png")
    mesh = quad(
        [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], None, Material("m", tmp_path / "stripes.png")
    )
    _, rgba, _, _ = make(mesh, view_along_line(0, 8), tmp_path, 1 / 128)
    row = rgba[rgba.shape[0] // 2, 4:-4, 0]
    assert row.min() < 40
    assert row.max() > 215


def test_vertex_colours_blend_and_untextured_materials_show_their_colour(tmp_path: Path) -> None:
    square = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    west, east = (0, 0, 0), (200, 100, 0)
    _, rgba, _, _ = make(
        quad(square, [west, east, east, west]), view_along_line(0, 90), tmp_path, 0.01
    )
    assert rgba[50, 50, :3].tolist() == pytest.approx([101, 51, 0], abs=1)
    red = Material("red", None, (0.8, 0.2, 0.0))
    _, rgba, _, _ = make(quad(square, None, red), view_along_line(0, 90), tmp_path, 0.01)
    assert (rgba[..., :3] == (204, 51, 0)).all()


def test_unreadable_texture_is_reported_and_the_rest_is_drawn(tmp_path: Path) -> None:
    (tmp_path / "bad.jpg").write_bytes(b"not a picture")
    mesh = quad(
        [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], None, Material("m", tmp_path / "bad.jpg")
    )
    output, rgba, _, _ = make(mesh, view_along_line(0, 90), tmp_path, 0.1)
    assert by_code(output.warnings)["texture.not-drawn"]["file"].endswith("bad.jpg")
    assert (rgba[..., 3] == 255).all()


@pytest.mark.full
def test_edges_are_smoothed_and_tiles_match_the_whole_picture(
    tmp_path: Path, monkeypatch: Any
) -> None:
    mesh, _ = marked_mesh(tmp_path)
    cloud, _ = marked_cloud(40_000)
    for data, tolerance in ((mesh, 0), (cloud, 1)):
        view = view_along_line(20, 30)
        _, whole, depth, _ = make(data, view, tmp_path, 0.02)
        for module in (tiles, orthophoto, *_sources()):
            if hasattr(module, "TILE"):
                monkeypatch.setattr(module, "TILE", 64)
        _, pieces, depth2, _ = make(data, view, tmp_path, 0.02)
        monkeypatch.undo()
        assert np.abs(whole.astype(int) - pieces.astype(int)).max() <= tolerance
        assert depth == pytest.approx(depth2, abs=1e-5, nan_ok=True)
    partly = (whole[..., 3] > 0) & (whole[..., 3] < 255)
    assert not partly.any()  # discs are whole or absent
    _, rgba, _, _ = make(mesh, view_along_line(20, 30), tmp_path, 0.02)
    assert ((rgba[..., 3] > 0) & (rgba[..., 3] < 255)).any()


def _sources() -> tuple[Any, Any]:
    from vomstudio.products.ortho import cloud_picture, mesh_picture

    return mesh_picture, cloud_picture


def test_small_holes_of_a_cloud_are_closed_and_large_ones_stay_open(tmp_path: Path) -> None:
    g = np.arange(0, 2, 0.02)
    x, y = (k.ravel() for k in np.meshgrid(g, g))
    small = np.hypot(x - 0.5, y - 0.5) < 0.035
    large = np.hypot(x - 1.4, y - 1.4) < 0.25
    points = np.column_stack([x, y, np.zeros(len(x))])[~small & ~large]
    output, rgba, _, facts = make(PointCloud(points), view_along_line(0, 90), tmp_path, 0.005)
    assert facts["holes_filled_up_to_m"] == pytest.approx(0.08)
    height_px = rgba.shape[0]

    def alpha(px: float, py: float) -> int:
        return int(rgba[height_px - 1 - int(py / 0.005), int(px / 0.005), 3])

    assert alpha(0.5, 0.5) == 255
    assert alpha(1.4, 1.4) == 0
    assert facts["holes_filled_px"] > 0
    assert output.coverage == pytest.approx(1 - np.pi * 0.24**2 / 1.98**2, abs=0.02)


# Files ----------------------------------------------------------------------------------------


def test_map_has_the_crs_of_the_project_and_a_world_file(tmp_path: Path) -> None:
    mesh, places = marked_mesh(tmp_path)
    planned = plan(mesh, view_along_line(0, 90), to_world=SAME, gsd=0.01)
    output = write_orthophoto(mesh, planned, tmp_path / "m.tif", crs="EPSG:32615")
    assert output.world_file == tmp_path / "m.tfw"
    numbers = [float(line) for line in output.world_file.read_text().split()]
    low, high = mesh.bounds
    for path in (output.image, output.depth):
        with rasterio.open(path) as file:
            assert file.crs.to_epsg() == 32615
            x, y = file.transform.c, file.transform.f
            assert (x, y) == (pytest.approx(low[0], abs=0.01), pytest.approx(high[1], abs=0.01))
            assert (file.transform.a, file.transform.e) == (0.01, -0.01)
            assert file.xy(0, 0) == pytest.approx((numbers[4], numbers[5]), abs=1e-6)
            assert file.profile["compress"] == "deflate"
            assert file.profile["tiled"]
    with rasterio.open(output.image) as file:
        row, column = file.index(*places[5, :2])
        assert file.read(1)[row, column] > 150
        assert file.colorinterp[3].name == "alpha"


def test_oblique_picture_has_no_map_crs(tmp_path: Path) -> None:
    mesh, _ = marked_mesh(tmp_path)
    make(mesh, view_along_line(0, 90), tmp_path, 0.05)
    assert (tmp_path / "o.tfw").exists()
    output, _, _, facts = make(mesh, view_along_line(40, 35), tmp_path, 0.05, crs="EPSG:32615")
    # In metres of its own plane, not that of the picture before.
    numbers = [float(line) for line in output.world_file.read_text().split()]
    assert numbers[0] == -numbers[3] == 0.05
    assert max(map(abs, numbers)) < 10
    assert (facts["world_crs"], facts["north"]) == ("EPSG:32615", WORLD_NORTHS["crs"])
    assert not list(tmp_path.glob("*.xml"))
    for path in (output.image, output.depth):
        with rasterio.open(path) as file:
            assert file.crs is None or not (file.crs.is_projected or file.crs.is_geographic)
            assert "view plane" in file.crs.to_wkt()
            a, e = file.transform.a, file.transform.e
            assert (a, e) == (0.05, -0.05)
            # The reference point is the origin of the picture's own plane.
            inverse = np.linalg.inv(np.array(facts["pixel_to_world"]))
            column, row, depth, _ = inverse @ [*facts["reference_point"], 1]
            assert depth == pytest.approx(0.0, abs=1e-6)
            assert file.transform.c + a * column == pytest.approx(0.0, abs=1e-6)
            assert file.transform.f + e * row == pytest.approx(0.0, abs=1e-6)
            assert "as given" in file.tags()["VOMSTUDIO_SENSE"]


def test_other_axes_and_units_are_converted_to_world_first(tmp_path: Path) -> None:
    square = quad(np.array([(0, 0, 0), (1, 0, 0), (1, 0, -2), (0, 0, -2)]) * 1000.0)
    millimetres_y_up = 0.001 * np.array([(1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1e3)])
    planned = plan(square, view_along_line(0, 90), to_world=millimetres_y_up, gsd=0.1)
    assert (planned.grid.width, planned.grid.height) == (10, 20)
    assert planned.reference == pytest.approx((0.5, 1.0, 0.0))


def test_default_pixel_size_matches_the_model_resolution(tmp_path: Path) -> None:
    mesh, _ = marked_mesh(tmp_path)
    planned = plan(mesh, view_along_line(0, 90), to_world=SAME)
    assert planned.grid.gsd == pytest.approx(SPAN / 800, rel=0.15)
    assert planned.notes[0].code == "gsd.texture"
    g = np.arange(0, 2, 0.02)
    x, y = (k.ravel() for k in np.meshgrid(g, g))
    cloud = PointCloud(np.column_stack([x, y, x * 0]))
    planned = plan(cloud, view_along_line(0, 90), to_world=SAME)
    assert planned.grid.gsd == pytest.approx(0.02)
    assert planned.notes[0].code == "gsd.spacing"


def test_too_large_picture_is_rejected_with_a_suitable_pixel_size(tmp_path: Path) -> None:
    mesh, _ = marked_mesh(tmp_path)
    view = view_along_line(40, 35)
    with refused("gsd.too-many-pixels", UsageError) as caught:
        plan(mesh, view, to_world=SAME, gsd=1e-5)
    least = float(f"{caught.value.values['least_m']:g}")
    grid = plan(mesh, view, to_world=SAME, gsd=least).grid
    assert 0.8 * planning.MAX_PIXELS < grid.width * grid.height <= planning.MAX_PIXELS


def test_models_without_a_surface_are_refused() -> None:
    bare = Mesh(np.zeros((3, 3)), np.zeros((0, 3), np.int32))
    for data in (bare, PointCloud(np.zeros((0, 3)))):
        with pytest.raises(InputError):
            plan(data, view_along_line(0, 90), to_world=SAME, gsd=1.0)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_few_points_make_a_picture(tmp_path: Path, n: int) -> None:
    cloud = PointCloud(UTM + np.arange(3 * n).reshape(n, 3))
    output, rgba, _, _ = make(cloud, view_along_line(0, 45), tmp_path, None)
    assert rgba[..., 3].any()
    assert output.coverage > 0


def test_an_existing_file_is_kept_unless_forced(tmp_path: Path) -> None:
    mesh, _ = marked_mesh(tmp_path)
    planned = plan(mesh, view_along_line(0, 90), to_world=SAME, gsd=0.1)
    for name in ("x_depth.tif", "x.json", "x.tfw", "x.tif"):
        (tmp_path / name).write_text("mine")
        with pytest.raises(TargetError, match="force"):
            write_orthophoto(mesh, planned, tmp_path / "x.tif")
        assert (tmp_path / name).read_text() == "mine"
        assert [p.name for p in tmp_path.glob("x*")] == [name]
        (tmp_path / name).unlink()


def test_cancelled_or_failed_orthophoto_leaves_no_files(tmp_path: Path, monkeypatch: Any) -> None:
    mesh, _ = marked_mesh(tmp_path)
    before = sorted(tmp_path.iterdir())
    planned = plan(mesh, view_along_line(0, 90), to_world=SAME, gsd=0.1)
    token = CancelToken()

    class StopAtFirst(SilentProgress):
        def step(self, done: int) -> None:
            if done:
                token.cancel()
            super().step(done)

    with pytest.raises(Cancelled):
        write_orthophoto(mesh, planned, tmp_path / "x.tif", progress=StopAtFirst(token))
    assert sorted(tmp_path.iterdir()) == before

    def broken(self: object, tile: object) -> None:
        raise RuntimeError("broken")

    monkeypatch.setattr(_sources()[0].MeshSource, "draw", broken)
    with pytest.raises(RuntimeError):
        write_orthophoto(mesh, planned, tmp_path / "x.tif")
    assert sorted(tmp_path.iterdir()) == before


# Sheets ---------------------------------------------------------------------------------------


def test_view_without_north_and_scale_names_no_compass_points_or_metres(
    tmp_path: Path,
) -> None:
    from vomstudio.products.ortho.view_description import end_labels

    known = view_along_line(90, 0)
    unknown = replace(known, is_north_known=False, is_metric=False)
    assert end_labels(known) == ("N (000)", "S (180)", "up")
    assert end_labels(unknown) == ("000, local", "180, local", "up")
    units = [
        view_directions.cost_of_direction(2.0, 3.0, is_metric=metric).values["unit"]
        for metric in (True, False)
    ]
    assert units == ["m", "units"]
    mesh, _ = marked_mesh(tmp_path)
    output, *_ = make(mesh, unknown, tmp_path, 0.01, sheet=tmp_path / "s.png")
    facts = json.loads(output.sidecar.read_text())
    assert "metre" not in facts["depth_means"] + facts["unit"]
    assert facts["north"].startswith("not known")


@pytest.mark.full
def test_sheet_shows_directions_and_the_length_of_a_metre(tmp_path: Path) -> None:
    from PIL import Image

    from vomstudio.products.ortho.vector_drawing import paper_scale
    from vomstudio.products.ortho.view_description import end_labels

    assert end_labels(view_along_line(0, 20)) == ("W (270)", "E (090)", "up")
    assert end_labels(view_along_line(0, 20).flipped()) == ("E (090)", "W (270)", "up")
    assert end_labels(view_along_line(45, 0)) == ("NW (315)", "SE (135)", "up")
    assert end_labels(view_along_line(45, 90)) == ("W (270)", "E (090)", "N")
    mesh, _ = marked_mesh(tmp_path)
    sheets = []
    for view in (view_along_line(0, 90), view_along_line(0, 90).flipped()):
        for ending in ("png", "pdf"):
            output, rgba, _, _ = make(mesh, view, tmp_path, 0.005, sheet=tmp_path / f"s.{ending}")
            assert output.sheet is not None
            assert output.sheet.stat().st_size > 1000
        picture = Image.open(tmp_path / "s.png").convert("RGB")
        sheets.append(np.asarray(picture))
    # The scale bar and its words stand on both as they should be read.
    size = 0.005 * np.array(rgba.shape[:2])
    tall = 1000.0 * size[0] / paper_scale(np.array([[0.0, 0.0], size])) / 25.4 * 300.0
    bar = slice(round(tall + 189) + 150, round(tall + 189) + 200)
    first, second = (sheet[bar].astype(float) for sheet in sheets)
    assert (first != 255).any()
    # Letters may start within another fraction of a pixel, as the heights of the sheets differ.
    assert np.abs(first - second).mean() < 0.1 * np.abs(first - second[:, ::-1]).mean()
    assert not (sheets[0][:190] == sheets[1][:190]).all()  # East and West have changed sides


# A part of the view ---------------------------------------------------------------------------


@pytest.mark.parametrize("kind", first_in_default_tier(["mesh", "cloud"]))
@pytest.mark.parametrize(("trend", "plunge"), first_in_default_tier([(0, 90), (305, 62)]))
def test_region_shows_the_same_as_the_whole_picture(tmp_path, kind, trend, plunge) -> None:  # type: ignore[no-untyped-def]
    """The same dots at the same places of the world, from a part of the grid only."""
    data, places = marked_mesh(tmp_path) if kind == "mesh" else marked_cloud()
    view, gsd = view_along_line(trend, plunge), 0.0093
    middle = places[len(places) // 2]
    region = planning.ViewRegion(tuple(middle.tolist()), 1.2, 0.9)
    planned = plan(data, view, to_world=SAME, gsd=gsd, region=region)
    assert planned.grid.width <= 1.2 / gsd + 2
    assert planned.grid.height <= 0.9 / gsd + 2
    output = write_orthophoto(data, planned, tmp_path / "part.tif")
    with rasterio.open(output.image) as file:
        rgba = np.moveaxis(file.read(), 0, 2)
    matrix = planned.pixel_to_world
    at = np.linalg.inv(matrix) @ np.append(middle, 1.0)
    assert 0 <= at[0] < planned.grid.width
    assert 0 <= at[1] < planned.grid.height
    radius = round(0.06 / gsd)
    inside = np.linalg.inv(matrix) @ np.column_stack([places, np.ones(len(places))]).T
    room = radius + 3
    here = (
        (inside[0] > room)
        & (inside[0] < planned.grid.width - room)
        & (inside[1] > room)
        & (inside[1] < planned.grid.height - room)
    )
    assert here.any()
    expected, measured = found_dots(rgba, matrix, places[here], radius=radius)
    # A single dot of a cloud is known to the spacing of its points only.
    limit = 0.1 if kind == "mesh" else 0.5
    assert np.hypot(*(measured - expected).T).mean() < limit


def test_a_region_beside_the_model_is_refused(tmp_path) -> None:  # type: ignore[no-untyped-def]
    mesh, places = marked_mesh(tmp_path)
    region = planning.ViewRegion(tuple((places[0] + 1000.0).tolist()), 1.0, 1.0)
    with refused("view.part-empty"):
        plan(mesh, view_along_line(0, 90), to_world=SAME, gsd=0.01, region=region)


@pytest.mark.parametrize("trend", [359.96, 360.0 - 1e-9, -1e-20, 360.0, 0.0, -0.04, 720.0])
def test_northward_view_has_trend_0_and_never_360(tmp_path: Path, trend: float) -> None:
    view = view_directions.view_along_line(trend, 30.0)
    assert 0.0 <= view.trend_deg < 360.0
    assert 0.0 <= view.flipped().flipped().trend_deg < 360.0
    words = direction_text(view)
    assert "000.0/30.0" in words
    assert figures(words)[:2] == [0.0, 30.0]
    south = view_directions.view_along_line(trend + 180.0, -30.0)
    assert 0.0 <= south.flipped().trend_deg < 360.0
    both = {"trend_deg": trend % 360.0, "plunge_deg": 7.0}
    checked = Check("", both, both, 1.0, None, None)
    assert "000.0/07.0" in format_text([checked], [])


@pytest.mark.parametrize("hair", [1e-9, 4e-5])
def test_view_slightly_west_of_north_is_not_written_as_360(tmp_path: Path, hair: float) -> None:
    upright = quad([(0, 0, 0), (4, 0, 0), (4, 0, 4), (0, 0, 4)], [(200, 10, 10)] * 4)
    output, *_ = make(upright, view_directions.view_along_line(360.0 - hair, 0.0), tmp_path, 0.5)
    with rasterio.open(output.image) as picture:
        assert re.findall(r"[\d.]+", picture.tags()["VOMSTUDIO_VIEW"]) == ["0.0000", "0.0000"]


@pytest.mark.parametrize(
    ("width", "height", "factor"), [(2400, 10, 1), (2401, 10, 2), (10, 9700, 8), (3001, 2050, 2)]
)
def test_sheet_picture_is_the_mean_of_the_visible_pixels(
    width: int, height: int, factor: int
) -> None:
    """Colours count by their coverage; pieces come in tiles."""
    rng = np.random.default_rng(0)
    whole = rng.integers(0, 256, (height, width, 4), np.uint8)
    whole[::3, :, 3] = 0
    reduced = orthophoto._ReducedPicture(tiles.Grid(0.0, 0.0, 0.1, width, height))
    assert reduced.factor == factor
    for row in range(0, height, tiles.TILE):
        for column in range(0, width, tiles.TILE):
            part = whole[row : row + tiles.TILE, column : column + tiles.TILE]
            reduced.add(column, row, part)
    result = reduced.out
    assert result.shape == (-(-height // factor), -(-width // factor), 4)
    for i, j in rng.integers(0, [height // factor, width // factor], (200, 2)):
        cell = whole[i * factor : (i + 1) * factor, j * factor : (j + 1) * factor]
        cover = cell[..., 3].astype(float) / 255
        assert abs(result[i, j, 3] - 255 * cover.mean()) <= 0.6
        if cover.sum() > 0:
            colour = (cell[..., :3] * cover[..., None]).sum(axis=(0, 1)) / cover.sum()
            assert np.abs(result[i, j, :3] - colour).max() <= 0.6
        else:
            assert not result[i, j].any()


@pytest.mark.full
@pytest.mark.parametrize("side", [40, 64, 90])
def test_holes_of_a_cloud_are_closed_across_the_edges_of_tiles(
    tmp_path: Path, monkeypatch: Any, side: int
) -> None:
    """A tile that knew nothing of the points beside it would leave its edge open, a seam of holes
    every thousand pixels."""
    rng = np.random.default_rng(3)
    points = np.column_stack([rng.uniform(0.0, 4.0, (2500, 2)), np.zeros(2500)])
    colors = rng.integers(0, 256, (2500, 3), np.uint8)
    cloud = PointCloud(points, colors)
    view = view_along_line(0, 90)
    _, whole, depth, facts = make(cloud, view, tmp_path, 0.02)
    assert facts["holes_filled_px"] > 100
    for module in (tiles, orthophoto, *_sources()):
        if hasattr(module, "TILE"):
            monkeypatch.setattr(module, "TILE", side)
    _, pieces, depth2, facts2 = make(cloud, view, tmp_path, 0.02)
    assert np.array_equal(whole[..., 3], pieces[..., 3])
    assert facts2["holes_filled_px"] == facts["holes_filled_px"]
    assert np.abs(whole.astype(int) - pieces.astype(int)).max() <= 1
    assert depth == pytest.approx(depth2, abs=1e-5, nan_ok=True)


def test_tilted_material_is_darker_and_never_brighter_than_white(
    tmp_path: Path,
) -> None:
    """Some programs write colours over 1: they are white, not black again."""
    for tilt in (0.0, 40.0, 75.0):
        a = np.radians(tilt)
        corners = [(0, 0, 0), (1, 0, 0), (1, np.cos(a), np.sin(a)), (0, np.cos(a), np.sin(a))]
        sheet = quad(corners, None, Material("m", None, (0.8, 0.2, 1.3)))
        _, rgba, _, _ = make(sheet, view_along_line(0, 90), tmp_path, 0.02)
        light = 0.35 + 0.65 * np.cos(a)
        expected = np.minimum(255.0 * light * np.array([0.8, 0.2, 1.3]), 255.0)
        middle = rgba[rgba.shape[0] // 2, 20, :3].astype(float)
        assert np.abs(middle - expected).max() <= 0.51
    _, rgba, _, _ = make(quad(corners), view_along_line(0, 90), tmp_path, 0.02)
    assert np.abs(rgba[rgba.shape[0] // 2, 20, :3] - 200.0 * light).max() <= 0.51


def test_default_pixel_size_without_resolution_is_a_thousandth_of_the_extent() -> None:
    alone = PointCloud(np.repeat(UTM[None], 5, axis=0))
    for extent, gsd in ((0.0, 0.001), (0.5, 0.001), (40.0, 0.04)):
        result, code = planning.default_gsd(alone, SAME, extent)
        assert result == pytest.approx(gsd)
        assert code == "gsd.size"
    doubled = np.diag([3.0, 3.0, 3.0, 1.0])
    g = np.arange(0.0, 2.0, 0.1)
    x, y = (k.ravel() for k in np.meshgrid(g, g))
    grid = PointCloud(np.column_stack([x, y, 0 * x]))
    assert planning.default_gsd(grid, SAME, 2.0) == (0.1, "gsd.spacing")
    assert planning.default_gsd(grid, doubled, 6.0)[0] == pytest.approx(0.3)


@pytest.mark.parametrize("extent", [(1.0, 1.0), (0.3, 900.0), (5e4, 2e3), (1.0, 0.0), (1e-4, 1e-4)])
def test_finest_suggested_pixel_size_gives_an_accepted_picture(
    extent: tuple[float, float],
) -> None:
    """Two digits, and a finer one of as many digits would not do."""
    gsd = planning._min_gsd(np.array(extent))

    def pixels(size: float) -> float:
        return float(np.prod([np.ceil(v / size) + 1 for v in extent]))

    assert pixels(gsd) <= planning.MAX_PIXELS * (1 + 1e-6) + 1e5
    step = 10.0 ** (np.floor(np.log10(gsd)) - 1)
    finer = np.prod([np.ceil(v / (gsd - step) + 1) for v in extent])
    assert finer > planning.MAX_PIXELS or gsd - step < max(extent) / planning.MAX_PIXELS
