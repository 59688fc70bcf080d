"""Sensors of common cameras: the table in resources/cameras, and a search by name."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from functools import cache

from vomstudio.core.files.regular import read_small_text
from vomstudio.core.paths import resource

_DRONE_MAKES = ("DJI", "Autel Robotics", "Parrot")
_DRONE_PREFIXES = ("L1D-", "L2D-")
"""Beginnings of the EXIF names of drone cameras that bear the name of another maker."""


@dataclass(frozen=True)
class CameraModel:
    """Camera model.

    Attributes
    ----------
    names : tuple of str
        Names of the model; the first is that used in EXIF.
    width_mm, height_mm : float
        Size of the imaging area of the sensor.
    width_px, height_px : int
        Size of the largest photos without enlargement.
    focal_mm : float or None
        Focal length of a built-in lens without zoom.
    f_number : float or None
        Fixed aperture.
    """

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

    @property
    def common_label(self) -> str:
        """Name under which the camera is sold, with the make."""
        return camera_label(self.make, self.names[-1]) or self.names[-1]

    @property
    def is_drone(self) -> bool:
        """Whether the camera is that of a drone."""
        return self.make in _DRONE_MAKES or self.names[0].startswith(_DRONE_PREFIXES)


def camera_label(make: str | None, model: str | None) -> str | None:
    """Return make and model as one name, or the make if the model is unknown.

    Only the first word of the make is used; it is omitted if the model begins with it.
    """
    if not model:
        return make
    make_words = (make or "").split()
    if not make_words or _normalize(model).startswith(_normalize(make_words[0])):
        return model
    return f"{make_words[0]} {model}"


@cache
def camera_models() -> tuple[CameraModel, ...]:
    """Return all models in the table. Raises InputError if the installation is damaged."""
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
def _models_by_name() -> dict[str, CameraModel]:
    models: dict[str, CameraModel] = {}
    for model in camera_models():
        for name in model.names:
            models.setdefault(_normalize(name), model)
            models.setdefault(_normalize(camera_label(model.make, name) or name), model)
    return models


def find_camera(name: str | None) -> CameraModel | None:
    """Return a model by name, with or without make, or None.

    Names are compared by their letters and digits, ignoring case.
    """
    return _models_by_name().get(_normalize(name)) if name else None


def search_cameras(text: str) -> list[CameraModel]:
    """Return the models whose names contain every word of a text, shorter names first.

    Parameters
    ----------
    text : str
        All models match an empty text.
    """
    search_words = text.casefold().split()
    matches = [
        model
        for model in camera_models()
        if all(word in " ".join((model.make, *model.names)).casefold() for word in search_words)
    ]
    if search_words:
        return sorted(matches, key=lambda model: (len(model.common_label), model.common_label))
    return sorted(matches, key=lambda model: model.common_label.casefold())


def similar_cameras(name: str, limit: int = 5) -> list[str]:
    """Return names from the table that contain the words of a name, or else are similar to it."""
    import difflib

    normalized_name = _normalize(name)
    names = {
        _normalize(name): camera_label(camera_model.make, name) or name
        for camera_model in camera_models()
        for name in camera_model.names
    }
    containing_names = [names[key] for key in names if normalized_name and normalized_name in key]
    containing_names += [model.common_label for model in search_cameras(name) if normalized_name]
    close_names = [
        names[key] for key in difflib.get_close_matches(normalized_name, names, limit, 0.6)
    ]
    return list(dict.fromkeys(containing_names + close_names))[:limit]


def _normalize(name: str) -> str:
    return re.sub(r"[^a-z0-9]+", "", name.casefold())
