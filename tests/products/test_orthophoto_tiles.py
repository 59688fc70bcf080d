"""Tiles are drawn by several threads, a few at a time, and each arrives once."""

from __future__ import annotations

import json
import threading
import time
from pathlib import Path

import numpy as np
import pytest
import rasterio

from tests.marked import UTM
from vomstudio.core.progress import SilentProgress
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.products.ortho import orthophoto, tiles
from vomstudio.products.ortho.drawn_tiles import draw_tiles
from vomstudio.products.ortho.orthophoto import write_orthophoto
from vomstudio.products.ortho.planning import plan
from vomstudio.products.ortho.tiles import TILE, Grid, Tile, TilePicture
from vomstudio.products.ortho.view_directions import view_along_line

SAME = np.eye(4)


class Numbers:
    """Draws the number of each tile into its only pixel."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.drawn: list[int] = []
        self.at_once = self.most = 0

    def draw(self, tile: Tile) -> TilePicture:
        with self.lock:
            self.at_once += 1
            self.most = max(self.most, self.at_once)
            self.drawn.append(tile.number)
        time.sleep(0.002)
        with self.lock:
            self.at_once -= 1
        rgba = np.full((1, 1, 4), tile.number, np.uint8)
        return TilePicture(rgba, np.full((1, 1), tile.number, np.float32))

    def warnings(self) -> list[str]:
        return []


class Told(SilentProgress):
    def __init__(self) -> None:
        super().__init__()
        self.stages: list[tuple[str, int | None]] = []
        self.steps: list[int] = []

    def stage(self, name: str, total: int | None = None) -> None:
        self.stages.append((name, total))
        super().stage(name, total)

    def step(self, done: int) -> None:
        self.steps.append(done)
        super().step(done)


@pytest.mark.parametrize("threads", [1, 2, 3, 100, None])
@pytest.mark.parametrize("columns", [1, 2, 30])
def test_every_tile_is_drawn_once_and_counted_in_the_progress(
    threads: int | None, columns: int
) -> None:
    source, report = Numbers(), Told()
    grid = Grid(0.0, 0.0, 1.0, columns * TILE, TILE)
    result = [(tile, picture) for tile, picture in draw_tiles(source, grid, report, threads)]
    assert sorted(tile.number for tile, _ in result) == list(range(columns))
    assert sorted(source.drawn) == list(range(columns))
    for tile, picture in result:
        assert picture.rgba[0, 0, 0] == tile.number
    assert report.stages == [("Casting rays", columns)]
    assert report.steps == list(range(columns + 1))
    assert source.most <= min(threads or 8, 8, columns)


def test_tiles_wait_until_earlier_ones_are_consumed() -> None:
    """Pictures of a large grid would fill the memory; and where one gives up, the rest stops."""
    source = Numbers()
    coming = draw_tiles(source, Grid(0.0, 0.0, 1.0, 60 * TILE, TILE), SilentProgress(), 2)
    for _ in range(3):
        next(coming)
    time.sleep(0.1)
    assert len(source.drawn) <= 3 + 3
    coming.close()
    time.sleep(0.05)
    assert len(source.drawn) <= 3 + 3


def test_coverage_of_a_picture_is_counted_over_its_tiles(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A level right triangle, in its square: a half, and the pixels on its edge."""
    for module in (tiles, orthophoto):
        monkeypatch.setattr(module, "TILE", 32)
    corners = UTM + np.array([(0, 0, 0), (10, 0, 0), (0, 10, 0)], float)
    mesh = Mesh(corners, np.array([[0, 1, 2]], np.int32))
    planned = plan(mesh, view_along_line(0, 90), to_world=SAME, gsd=0.1)
    output = write_orthophoto(mesh, planned, tmp_path / "a.tif", model="Größe <1>")
    with rasterio.open(output.depth) as file:
        seen = np.isfinite(file.read(1))
    assert output.coverage == seen.sum() / seen.size == output.metadata["coverage"]
    assert output.coverage == pytest.approx(0.5, abs=0.02)
    text = output.sidecar.read_text("utf-8")
    assert "Größe <1>" in text
    stated = {name: v for name, v in output.metadata.items() if name != "crs" or v is not None}
    assert json.loads(text) == stated
    assert output.metadata["holes_filled_px"] == 0


@pytest.mark.parametrize("trend", [12.34567, 0.00004, 123.45674])
def test_picture_states_its_direction_to_four_decimals(tmp_path: Path, trend: float) -> None:
    corners = UTM + np.array([(0, 0, 0), (4, 0, 0), (4, 0, 4)], float)
    mesh = Mesh(corners, np.array([[0, 1, 2]], np.int32))
    planned = plan(mesh, view_along_line(trend, 20), to_world=SAME, gsd=0.5)
    output = write_orthophoto(mesh, planned, tmp_path / "a.tif")
    with rasterio.open(output.image) as file:
        words = file.tags()["VOMSTUDIO_VIEW"].split()
    assert float(words[1]) == pytest.approx(trend, abs=0.51e-4)
    assert len(words[1].split(".")[1]) == 4


def test_coincident_points_make_a_picture(tmp_path: Path) -> None:
    """They have no spacing: a pixel is taken for it."""
    cloud = PointCloud(np.repeat(UTM[None], 5, axis=0))
    planned = plan(cloud, view_along_line(0, 90), to_world=SAME, gsd=0.25)
    output = write_orthophoto(cloud, planned, tmp_path / "a.tif")
    assert output.coverage > 0
    assert output.metadata["holes_filled_up_to_m"] == pytest.approx(4 * 0.25)
