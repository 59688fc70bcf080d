"""Photos of a textured wall from known cameras, for tests.

World x to the right along the wall, y up it, z away from it towards the cameras; metres.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from tests.io.photos import photo_maker

PIXELS_PER_M = 150.0
WIDTH_M, HEIGHT_M = 20.0, 8.0


@cache
def texture(seed: int = 3) -> np.ndarray:
    """Grey rock with detail of every size, down to the pixel."""
    rng = np.random.default_rng(seed)
    w, h = round(WIDTH_M * PIXELS_PER_M), round(HEIGHT_M * PIXELS_PER_M)
    image = np.zeros((h, w), np.float32)
    for k in range(8):
        size = 2**k
        noise = rng.normal(size=(h // size + 2, w // size + 2)).astype(np.float32)
        image += cv2.resize(noise, (w, h), interpolation=cv2.INTER_CUBIC) * size**0.6
    image = (image - image.mean()) / image.std() * 40 + 125
    return np.clip(image, 0, 255).astype(np.uint8)


def rotation_to(centre: Sequence[float], target: Sequence[float]) -> np.ndarray:
    """World to camera, the picture's x axis horizontal."""
    z = np.subtract(target, centre).astype(float)
    z /= np.linalg.norm(z)
    x = np.cross(z, [0.0, 1.0, 0.0])
    x /= np.linalg.norm(x)
    return np.array([x, np.cross(z, x), z])


def matrix(focal: float, size: tuple[int, int]) -> np.ndarray:
    return np.array([[focal, 0, size[0] / 2], [0, focal, size[1] / 2], [0, 0, 1.0]])


def render(
    centre: Sequence[float],
    target: Sequence[float],
    *,
    focal: float = 720.0,
    size: tuple[int, int] = (800, 600),
    seed: int = 3,
) -> np.ndarray:
    """What a camera at `centre` that looks at `target` sees of the wall, grey."""
    turn = rotation_to(centre, target)
    shift = -turn @ np.asarray(centre, float)
    # The wall is z = 0: its points (x, y, 1) go through the first two columns and the shift.
    from_wall = matrix(focal, size) @ np.column_stack([turn[:, 0], turn[:, 1], shift])
    to_wall_px = np.array(
        [
            [PIXELS_PER_M, 0, WIDTH_M / 2 * PIXELS_PER_M],
            [0, -PIXELS_PER_M, HEIGHT_M * PIXELS_PER_M],
            [0, 0, 1],
        ]
    )
    return cv2.warpPerspective(
        texture(seed),
        from_wall @ np.linalg.inv(to_wall_px),
        size,
        flags=cv2.INTER_AREA,
        borderMode=cv2.BORDER_REFLECT,
    )


def good_stations() -> list[tuple[tuple[float, float, float], tuple[float, float, float]]]:
    """(centre, target): twelve along the wall face on, six from either side by 30 degrees, at two
    heights."""
    found = []
    for y in (2.6, 4.6):
        for x in np.arange(-5.0, 5.1, 1.7):
            found.append(((x, y, 8.0), (x, y, 0.0)))
        for i, x in enumerate(np.arange(-4.2, 4.3, 2.8)):
            side = 4.0 if i % 2 else -4.0
            found.append(((x + side, y + 0.3, 7.0), (x, y, 0.0)))
    return found


LATITUDE, LONGITUDE = 46.0, 7.0


def gps_fields(centre: Sequence[float], accuracy_m: float | None = 0.05) -> dict[int, Any]:
    """EXIF of a camera's place: the wall strikes east, cameras stand south of it."""
    north = LATITUDE - centre[2] / 111_140.0
    east = LONGITUDE + centre[0] / (111_320.0 * math.cos(math.radians(LATITUDE)))
    fields = dict(photo_maker.at(north, east, 500.0 + centre[1]))
    if accuracy_m is not None:
        fields[0x1F] = photo_maker.rational(accuracy_m)
    return fields


def write_set(
    folder: Path,
    stations: Sequence[tuple[Sequence[float], Sequence[float]]],
    *,
    focal: float = 720.0,
    change: dict[int, Any] | None = None,
    gps: bool = True,
    accuracy_m: float | None = 0.05,
    exif: dict[int, Any] | None = None,
) -> Path:
    """change : function of the pixels, by number of the photo."""
    folder.mkdir(parents=True, exist_ok=True)
    for i, (centre, target) in enumerate(stations):
        pixels = render(centre, target, focal=focal)
        if change and i in change:
            pixels = change[i](pixels)
        photo_maker.write_photo(
            folder / f"w{i:02d}.jpg",
            pixels=pixels,
            main={0x010F: photo_maker.text("Acme"), 0x0110: photo_maker.text("Wall 1")},
            exif={
                0x920A: photo_maker.rational(20.0),
                0xA405: photo_maker.rational(focal / 800 * 36),
                0x829A: photo_maker.rational(1 / 200),
                0x829D: photo_maker.rational(8.0),
                0x8827: photo_maker.short(100),
                0x9003: photo_maker.text(f"2024:05:04 10:{i:02d}:00"),
                **(exif or {}),
            },
            gps=gps_fields(centre, accuracy_m) if gps else {},
        )
    return folder
