"""Sensors of common cameras: the table in resources/cameras, and names looked up in it."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from functools import cache

from vomstudio.core.files.regular import read_small_text
from vomstudio.core.paths import resource


@dataclass(frozen=True)
class CameraModel:
    """width_mm, height_mm: imaging area of the sensor. width_px, height_px: of its largest photos
    that are not enlarged. focal_mm: of a lens that is built in and does not zoom. f_number: of an
    aperture that cannot be set. names: the first as EXIF has it."""

    make: str
    names: tuple[str, ...]
    width_mm: float
    height_mm: float
    width_px: int
    height_px: int
    focal_mm: float | None
    f_number: float | None = None

    @property
    def label(self) -> str:
        return camera_label(self.make, self.names[0]) or self.names[0]


def camera_label(make: str | None, model: str | None) -> str | None:
    """Make and model as one name: 'NIKON CORPORATION', 'NIKON D90' becomes 'NIKON D90'."""
    if not model:
        return make
    first = (make or "").split()
    if not first or _plain(model).startswith(_plain(first[0])):
        return model
    return f"{first[0]} {model}"


@cache
def camera_models() -> tuple[CameraModel, ...]:
    """All of the table. Raises InputError where the installation is damaged."""
    lines = read_small_text(resource("cameras", "sensors.csv")).splitlines()
    rows = csv.DictReader(line for line in lines if not line.startswith("#"))
    return tuple(
        CameraModel(
            row["make"],
            tuple(name.strip() for name in row["model"].split(" / ")),
            float(row["width_mm"]),
            float(row["height_mm"]),
            int(row["width_px"]),
            int(row["height_px"]),
            float(row["focal_mm"]) if row["focal_mm"] else None,
            float(row["f_number"]) if row["f_number"] else None,
        )
        for row in rows
    )


@cache
def _by_name() -> dict[str, CameraModel]:
    found: dict[str, CameraModel] = {}
    for model in camera_models():
        for name in model.names:
            found.setdefault(_plain(name), model)
            found.setdefault(_plain(camera_label(model.make, name) or name), model)
    return found


def find_camera(name: str | None) -> CameraModel | None:
    """By its name, with or without the make; case, spaces and hyphens do not count."""
    return _by_name().get(_plain(name)) if name else None


def similar_cameras(name: str, most: int = 5) -> list[str]:
    """Names in the table that are like this one, to offer in its place."""
    import difflib

    plain = _plain(name)
    names = {_plain(n): camera_label(m.make, n) or n for m in camera_models() for n in m.names}
    inside = [names[key] for key in names if plain and plain in key]
    close = [names[key] for key in difflib.get_close_matches(plain, names, most, 0.6)]
    return list(dict.fromkeys(inside + close))[:most]


def _plain(name: str) -> str:
    return re.sub(r"[^a-z0-9]+", "", name.casefold())
