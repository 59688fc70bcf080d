"""Photos from all around an object, of which the mapper makes parts that share photos."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from vomstudio.cli import main

pytestmark = pytest.mark.slow

SIZE = np.array([2.0, 1.6, 1.0])
"""Box of which all sides but the bottom are textured."""
WIDTH, HEIGHT, VIEW_ANGLE_DEG, DISTANCE = 900, 700, 40.0, 3.6
LOOK_AT = np.array([0.0, 0.0, 0.45])


def texture(seed: int) -> np.ndarray:
    """Noise of all scales, 512 x 512."""
    rng = np.random.default_rng(seed)
    grey = sum(
        np.kron(rng.random((k, k)), np.ones((512 // k, 512 // k))) / k**0.35
        for k in (4, 8, 16, 32, 64, 128, 256)
    )
    grey = (grey - grey.min()) / np.ptp(grey)
    return (np.stack([grey, grey**1.2 * 0.9, grey**1.5 * 0.8], -1) * 255).astype(np.uint8)


def eyes(count: int) -> np.ndarray:
    """Positions (n, 3) of the cameras, alternately higher and lower."""
    angle = 2 * np.pi * np.arange(count) / count
    heights = 1.9 + 0.3 * (np.arange(count) % 2)
    return np.column_stack([DISTANCE * np.cos(angle), DISTANCE * np.sin(angle), heights])


def photograph(folder: Path, count: int) -> Path:
    import pyvista

    folder.mkdir()
    plotter = pyvista.Plotter(off_screen=True, window_size=(WIDTH, HEIGHT))
    plotter.set_background((0.75, 0.8, 0.9))
    x, y, z = SIZE / 2
    sides = [
        [(x, -y, 0), (x, y, 0), (x, y, 2 * z), (x, -y, 2 * z)],
        [(-x, y, 0), (-x, -y, 0), (-x, -y, 2 * z), (-x, y, 2 * z)],
        [(x, y, 0), (-x, y, 0), (-x, y, 2 * z), (x, y, 2 * z)],
        [(-x, -y, 0), (x, -y, 0), (x, -y, 2 * z), (-x, -y, 2 * z)],
        [(-x, -y, 2 * z), (x, -y, 2 * z), (x, y, 2 * z), (-x, y, 2 * z)],
    ]
    for seed, corners in enumerate(sides):
        side = pyvista.PolyData(np.array(corners, float), np.array([4, 0, 1, 2, 3]))
        side.active_texture_coordinates = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], np.float32)
        plotter.add_mesh(side, texture=pyvista.Texture(texture(seed)), lighting=False)
    plotter.camera.view_angle = VIEW_ANGLE_DEG
    plotter.show(auto_close=False)
    for number, eye in enumerate(eyes(count)):
        plotter.camera.position = eye
        plotter.camera.focal_point = LOOK_AT
        plotter.camera.up = (0, 0, 1)
        plotter.renderer.ResetCameraClippingRange()
        plotter.render()
        pixels = plotter.screenshot(return_img=True)
        Image.fromarray(pixels).save(folder / f"p{number:02d}.jpg", quality=95)
    plotter.close()
    return folder


def reconstruct(capsys: pytest.CaptureFixture[str], *words: object) -> dict:
    code = main(["reconstruct", *map(str, words), "--quality", "preview", "--json"])
    answer = json.loads(capsys.readouterr().out)
    assert code == 0, answer
    return answer


def test_components_that_share_photos_give_a_model(tmp_path: Path, capsys) -> None:
    answer = reconstruct(capsys, photograph(tmp_path / "photos", 18), "-o", tmp_path / "model")
    # The largest part; the others are listed beside it.
    assert answer["registered"] >= 3
