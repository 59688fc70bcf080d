"""Stand-ins for the photos of the textbook's exercises 1 to 4: a rock face whose place is known,
photographed as the book did, with the files that it lays beside its photos."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image

from tests.io.photos.photo_maker import exif_bytes, rational, short, text
from tests.photogrammetry import rock_face
from vomstudio.geometry.cameras import Intrinsics, View

Array = npt.NDArray[np.float64]
FACE = {"width": 9.0, "height": 6.0, "step": 0.03, "relief": 0.35, "ledge": 0.3}


def face() -> rock_face.Face:
    """9 m wide, 6 m high, upright, looking south, with ledges."""
    return rock_face.rough_face(**FACE)


def row_of_views(
    count: int, size: tuple[int, int], height_m: float, seed: int, distance: float = 6.0
) -> list[View]:
    """Side by side at one height, turned in somewhat."""
    rng = np.random.default_rng(seed)
    focal = 1.0 * size[0]
    lens = Intrinsics.pinhole(*size, focal, size[0] / 2, size[1] / 2)
    places = [
        np.array([x, -distance, height_m]) + rng.normal(0.0, 0.08, 3)
        for x in np.linspace(-2.2, 2.2, count)
    ]
    return [
        rock_face.looking("", lens, place, (0.6 * place[0], 0.0, 0.5 * place[2]))
        for place in places
    ]


def write_photos(
    folder: Path,
    rock: rock_face.Face,
    views: list[View],
    *,
    maker: str = "Maker",
    start: int = 1,
    gps: list[dict[int, Any]] | None = None,
) -> list[str]:
    """JPEG photos with maker and focal length in their EXIF; their names."""
    folder.mkdir(parents=True, exist_ok=True)
    names = []
    for number, view in enumerate(views, start=start):
        lens = view.intrinsics
        said = exif_bytes(
            {0x010F: text(maker), 0x0110: text(f"{maker} {lens.width}")},
            {0x920A: rational(36.0), 0xA405: short(36)},
            gps[number - start] if gps is not None else {},
        )
        names.append(f"{maker}_{number:04d}.jpg")
        picture = rock_face.photograph(rock, view, seed=number)
        Image.fromarray(picture).save(folder / names[-1], quality=95, exif=said)
    return names


def pixels_of(view: View, points: Array) -> Array:
    """(n, 2), by the pinhole: these lenses have no distortion."""
    seen = points @ view.rotation.T + view.translation
    lens = view.intrinsics
    return seen[:, :2] / seen[:, 2:] * lens.params[0] + np.array([lens.width, lens.height]) / 2


def turned_by_deg(poses: Path, views: dict[str, View], to_world: Array, placement: Array) -> float:
    """By how much a model is turned against the true one.

    poses : `cameras.json` beside the model; views : the true ones by the photos' names, in a frame
    that `to_world` (3, 3) turns into World; placement : (3, 3) turns the model's file into World
    """
    to_file, _, _ = file_of_truth(poses, views)
    left = placement @ to_file @ to_world.T
    return float(np.degrees(np.arccos(np.clip((np.trace(left) - 1.0) / 2.0, -1.0, 1.0))))


def file_of_truth(poses: Path, views: dict[str, View]) -> tuple[Array, float, Array]:
    """Rotation (3, 3), scale and shift (3,) from the true frame to that of the model's file, by how
    its cameras are turned, and where they stand."""
    found = json.loads(poses.read_text(encoding="utf-8"))
    total, there, true = np.zeros((3, 3)), [], []
    for camera in found["views"]:
        view, own = views[camera["name"]], np.array(camera["rotation"], float).reshape(3, 3)
        total += own.T @ view.rotation
        there.append(np.array(found["origin"]) - own.T @ np.array(camera["translation"]))
        true.append(view.centre)
    u, _, vt = np.linalg.svd(total)
    turned, file = np.array(true) @ (u @ vt).T, np.array(there)
    spread = turned - turned.mean(axis=0)
    scale = float((spread * (file - file.mean(axis=0))).sum() / (spread**2).sum())
    return u @ vt, scale, file.mean(axis=0) - scale * turned.mean(axis=0)
