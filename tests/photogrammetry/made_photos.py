"""Photos that need no pixels: points on a made rock face, and the features that cameras at known
places would find of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.core.progress import Progress
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.photogrammetry.align.features import ExtractionTask, Features

Array = npt.NDArray[np.float64]

LENS = Intrinsics("SIMPLE_RADIAL", 1600, 1200, (1500.0, 800.0, 600.0, -0.05))


@dataclass(frozen=True)
class MadePhoto:
    path: Path
    name: str
    width: int = 1600
    height: int = 1200
    camera_key: tuple[object, ...] = ("camera",)
    focal_px: float | None = 1500.0
    latitude_deg: float | None = None
    longitude_deg: float | None = None
    altitude_m: float | None = None
    altitude_reference: str | None = None
    gps_accuracy_m: float | None = None
    taken_at: datetime | None = None
    mask: Path | None = None


@dataclass(frozen=True, eq=False)
class Made:
    """photos, features, views : of the same photos; points : (n, 3) of the face"""

    photos: list[MadePhoto]
    features: list[Features]
    views: list[View]
    points: Array

    def with_gps(self, noise_m: float, *, seed: int = 1, stated: float | None = None) -> list:
        """The photos with positions near 46 N, 11 E, for a world whose x, y, z are metres east,
        north and up of (500000, 5094000, 300) in EPSG:32632 there."""
        from pyproj import Transformer

        back = Transformer.from_crs("EPSG:32632", "EPSG:4326", always_xy=True)
        rng = np.random.default_rng(seed)
        photos = []
        for photo, view in zip(self.photos, self.views, strict=True):
            x, y, z = view.centre + ORIGIN + rng.normal(0, noise_m, 3)
            longitude, latitude = back.transform(x, y)
            photos.append(
                replace(
                    photo,
                    longitude_deg=longitude,
                    latitude_deg=latitude,
                    altitude_m=z,
                    gps_accuracy_m=stated,
                )
            )
        return photos


ORIGIN = np.array([660_000.0, 5_094_000.0, 300.0])


def looking(centre: Sequence[float], at: Sequence[float], lens: Intrinsics, name: str) -> View:
    """A camera at `centre` that looks at a point, upright; x east, y north, z up."""
    c, forward = np.array(centre, np.float64), np.subtract(at, centre)
    z = forward / np.linalg.norm(forward)
    up = np.array([0.0, 0.0, 1.0]) if abs(z[2]) < 0.9 else np.array([0.0, 1.0, 0.0])
    x = np.cross(z, up)
    x /= np.linalg.norm(x)
    rotation = np.array([x, np.cross(z, x), z])
    return View(name, lens, rotation, -rotation @ c)


def around(count: int = 8, lens: Intrinsics = LENS) -> list[View]:
    """Cameras in an arc of 100 degrees about a face, at two heights."""
    angles = np.radians(np.linspace(-50, 50, count))
    return [
        looking(
            (12 * np.sin(a), -12 * np.cos(a), 1.0 + 3.0 * (i % 2)),
            (0, 0, 2),
            lens,
            f"photo {i:02d}.jpg",
        )
        for i, a in enumerate(angles)
    ]


def abreast(count: int = 8, lens: Intrinsics = LENS) -> list[View]:
    """Cameras that all look north, in two rows."""
    return [
        looking((x, -12, 1 + 2.0 * (i % 2)), (x, 0, 1 + 2.0 * (i % 2)), lens, f"photo {i:02d}.jpg")
        for i, x in enumerate(np.linspace(-5, 5, count))
    ]


def face(count: int = 900, *, relief: float = 0.8, seed: int = 0, x: float = 0.0) -> Array:
    """(n, 3) points of a wall along east, 12 m by 6 m."""
    rng = np.random.default_rng(seed)
    across, up = rng.uniform(-6, 6, count), rng.uniform(-1, 5, count)
    depth = relief * np.sin(across * 1.3) * np.cos(up * 0.9) + rng.normal(0, 0.1, count)
    return np.column_stack([across + x, depth, up])


def make(
    folder: Path,
    views: Sequence[View],
    points: Array,
    *,
    noise_px: float = 0.3,
    seed: int = 0,
    **of_photos: Any,
) -> Made:
    """Files that stand for photos, and what would be found in them."""
    rng = np.random.default_rng(seed)
    # Of the points' own place, so that the same points look the same in other calls.
    descriptors = np.array(
        [
            np.random.default_rng(abs(hash(tuple(p.tolist())))).integers(0, 90, 128)
            for p in np.round(points, 9)
        ],
        np.uint8,
    )
    photos, features = [], []
    folder.mkdir(parents=True, exist_ok=True)
    for view in views:
        pixels = view.project(points) + rng.normal(0, noise_px, (len(points), 2))
        with np.errstate(invalid="ignore"):
            seen = np.flatnonzero(np.isfinite(pixels).all(axis=1) & view.contains(pixels))
        keypoints = np.zeros((len(seen), 6), np.float32)
        keypoints[:, :2] = pixels[seen]
        keypoints[:, [2, 5]] = 2.0
        path = folder / view.name
        path.write_bytes(view.name.encode())
        lens = view.intrinsics
        photos.append(MadePhoto(path, view.name, lens.width, lens.height, **of_photos))
        wobble = rng.integers(-2, 3, (len(seen), 128))
        features.append(
            Features(
                keypoints,
                np.clip(descriptors[seen].astype(int) + wobble, 0, 255).astype(np.uint8),
                np.tile(np.array([[200, 150, 100]], np.uint8), (len(seen), 1)),
                lens.width,
                lens.height,
            )
        )
    return Made(photos, features, list(views), points)


@dataclass
class Finder:
    """An Executor that hands out made features in place of those of the photo it is given."""

    made: Sequence[Made]
    asked: list[str] = field(default_factory=list)
    problems: dict[str, str] = field(default_factory=dict)

    def map(
        self,
        work: Callable[[ExtractionTask], Features],
        items: Iterable[ExtractionTask],
        progress: Progress,
        needed: int = 0,
    ) -> Iterator[tuple[int, Features]]:
        known = {
            photo.name: found
            for made in self.made
            for photo, found in zip(made.photos, made.features, strict=True)
        }
        for number, task in enumerate(items):
            progress.step(number)
            name = task.photo.decode()
            self.asked.append(name)
            found = known[name]
            if name in self.problems:
                found = Features.empty(found.width, found.height, self.problems[name])
            yield number, found
