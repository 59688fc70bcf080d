"""Texture pyramids: means of means, and which of them are kept."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from vomstudio.products.ortho import textures
from vomstudio.products.ortho.textures import Pyramid, TextureStore, load_pyramid


def picture(path: Path, width: int, height: int, seed: int = 0) -> np.ndarray:
    """A smooth one, so that rounding at each level is all that is lost."""
    y, x = np.mgrid[0:height, 0:width]
    waves = [x / width, y / height, (x + y) / (width + height)]
    rgb = np.stack([250 * wave + seed for wave in waves], axis=-1).astype(np.uint8)
    Image.fromarray(rgb).save(path)
    return rgb.astype(float)


def level(pyramid: Pyramid, k: int) -> np.ndarray:
    width, height = pyramid.sizes[k]
    start = pyramid.offsets[k]
    return pyramid.texels[start : start + width * height * 3].reshape(height, width, 3)


@pytest.mark.parametrize(("width", "height"), [(8, 8), (16, 4), (13, 7), (1, 1)])
def test_every_level_is_the_mean_of_four_texels_of_the_previous_level(
    tmp_path: Path, width: int, height: int
) -> None:
    rgb = picture(tmp_path / "a.png", width, height)
    pyramid = load_pyramid(tmp_path / "a.png", 0)
    assert pyramid is not None
    assert np.array_equal(level(pyramid, 0), rgb)
    assert pyramid.size == (width, height)
    for k in range(1, len(pyramid.sizes)):
        above, below = level(pyramid, k), level(pyramid, k - 1).astype(float)
        assert above.shape[:2] == (-(-below.shape[0] // 2), -(-below.shape[1] // 2))
        for i, j in np.ndindex(above.shape[:2]):
            part = below[2 * i : 2 * i + 2, 2 * j : 2 * j + 2].mean(axis=(0, 1))
            assert np.abs(above[i, j] - part).max() <= 1.0
    assert tuple(pyramid.sizes[-1]) == (1, 1)
    end = pyramid.offsets[-1] + 3
    assert len(pyramid.texels) == end


def test_unneeded_fine_levels_are_not_loaded(tmp_path: Path) -> None:
    picture(tmp_path / "a.png", 32, 16)
    whole, part = (load_pyramid(tmp_path / "a.png", k) for k in (0, 2))
    assert whole is not None
    assert part is not None
    assert tuple(part.sizes[0]) == (8, 4)
    assert part.size == (8.0, 4.0)
    assert np.abs(level(part, 0).astype(float) - level(whole, 2)).max() <= 2.0


def test_recently_used_textures_are_kept_within_the_memory_limit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    paths = [tmp_path / f"{k}.png" for k in range(3)]
    for k, path in enumerate(paths):
        picture(path, 16, 16, k)
    one = load_pyramid(paths[0], 0)
    assert one is not None
    monkeypatch.setattr(textures, "MEMORY_BYTES", int(2.5 * one.texels.nbytes))
    store = TextureStore({})
    first, second = store.get(paths[0]), store.get(paths[1])
    assert store.get(paths[0]) is first  # used again: the other one is the older now
    store.get(paths[2])
    assert store.get(paths[0]) is first
    assert store.get(paths[1]) is not second
    monkeypatch.setattr(textures, "MEMORY_BYTES", 1)
    alone = store.get(paths[2])
    assert store.get(paths[2]) is alone


def test_unreadable_picture_is_tried_once_and_reported(tmp_path: Path) -> None:
    broken = tmp_path / "broken.png"
    broken.write_bytes(b"no picture")
    store = TextureStore({})
    assert store.get(broken) is None
    assert store.unreadable_paths == {broken}
    picture(broken, 4, 4)
    assert store.get(broken) is None
