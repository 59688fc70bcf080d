"""What a file says of the cameras of a model."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.cameras import Intrinsics, View
from vomstudio.geometry.coordinate_limits import no_places

# How far a matrix may be from a rotation: files round to six figures and more.
_ROUNDED = 1e-3


@dataclass(frozen=True, eq=False)
class OwnCameras:
    """views : by the names of their photos, in the frame of the model
    centres : (3,) of every photo, also where the file holds no more than that
    photos : the folder where they may be, None where the file does not say
    warnings : what is to be known of them
    """

    path: Path
    views: Mapping[str, View]
    centres: Mapping[str, FloatArray]
    photos: Path | None = None
    warnings: tuple[Finding, ...] = field(default=())


def of_views(
    path: Path,
    views: Iterable[View],
    photos: Path | None = None,
    warnings: Sequence[Finding] = (),
) -> OwnCameras:
    """Raises InputError where two views have one name, or there is none."""
    named: dict[str, View] = {}
    for view in views:
        if view.name in named:
            raise InputError(
                Finding("cameras.repeated-photo", photo=view.name), file=path, field=view.name
            )
        named[view.name] = view
    if not named:
        raise InputError(Finding("cameras.none-aligned"), file=path)
    centres = {name: view.centre for name, view in named.items()}
    return OwnCameras(path, named, centres, photos, tuple(warnings))


def posed(name: str, lens: Intrinsics, rotation: FloatArray, translation: FloatArray) -> View:
    """A view whose rotation is one. Raises ValueError where it is none, or is nowhere."""
    if not (np.isfinite(rotation).all() and np.isfinite(translation).all()):
        raise ValueError(tr("the pose is not finite"))
    if no_places(translation[None]).any():
        raise ValueError(tr("the position is nowhere on Earth"))
    if np.abs(rotation @ rotation.T - np.eye(3)).max() > _ROUNDED or np.linalg.det(rotation) < 0:
        raise ValueError(tr("the matrix of the pose is no rotation"))
    u, _, vt = np.linalg.svd(rotation)
    # What files round is made a rotation again, the camera staying where it is.
    better = np.asarray(u @ vt, np.float64)
    return View(name, lens, better, better @ rotation.T @ translation)


def from_centre(name: str, lens: Intrinsics, rotation: FloatArray, centre: FloatArray) -> View:
    """As `posed`, from the projection centre."""
    view = posed(name, lens, rotation, np.zeros(3))
    if not np.isfinite(centre).all() or no_places(centre[None]).any():
        raise ValueError(tr("the position is nowhere on Earth"))
    return View(name, lens, view.rotation, -view.rotation @ centre)


def straight(width: int, height: int, focal: float) -> Intrinsics:
    """A lens that draws straight lines, where that of the file is not known here."""
    return Intrinsics.pinhole(width, height, focal, width / 2, height / 2)


def unknown_lens(model: str, photos: int) -> Finding:
    return Finding("cameras.unknown-lens", model=model, photos=photos)
