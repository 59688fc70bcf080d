"""Cameras of a model as read from a file."""

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
from vomstudio.geometry.coordinate_limits import find_invalid_points
from vomstudio.io.photos.cameras_file import Cameras

# Maximum deviation of a matrix from a rotation; files have at least six digits.
MAX_ROTATION_DEVIATION = 1e-3


@dataclass(frozen=True, eq=False)
class ModelCameras:
    """Cameras of a model.

    Attributes
    ----------
    views : mapping of str to View
        Views in the frame of the model by photo name.
    centres : mapping of str to (3,) float64
        Camera centre of every photo, even of those without a view.
    photos : Path or None
        Folder of the photos, if stated.
    warnings : tuple of Finding
    weak_names : frozenset of str
        Photos that are weakly connected to the others, if stated.
    """

    path: Path
    views: Mapping[str, View]
    centres: Mapping[str, FloatArray]
    photos: Path | None = None
    warnings: tuple[Finding, ...] = field(default=())
    weak_names: frozenset[str] = frozenset()


def cameras_from_views(
    path: Path,
    views: Iterable[View],
    photos: Path | None = None,
    warnings: Sequence[Finding] = (),
) -> ModelCameras:
    """Create the cameras of a model from its views.

    Raises
    ------
    InputError
        If a name is repeated, or there are no views.
    """
    views_by_name: dict[str, View] = {}
    for view in views:
        if view.name in views_by_name:
            raise InputError(
                Finding("cameras.repeated-photo", photo=view.name), file=path, field=view.name
            )
        views_by_name[view.name] = view
    if not views_by_name:
        raise InputError(Finding("cameras.none-aligned"), file=path)
    centres = {name: view.centre for name, view in views_by_name.items()}
    return ModelCameras(path, views_by_name, centres, photos, tuple(warnings))


def local_cameras(cameras: ModelCameras) -> Cameras:
    """Return the views relative to an origin near the cameras, to keep their precision.

    Raises
    ------
    InputError
        If the file contains no poses.
    """
    if not cameras.views:
        raise InputError(Finding("cameras.no-poses"), file=cameras.path)
    views = cameras.views.values()
    origin = np.floor(np.median([view.centre for view in views], axis=0))
    x, y, z = (int(value) for value in origin)
    local_views = tuple(view.moved(1.0, np.eye(3), -origin) for view in views)
    photos = cameras.photos or Path(".")
    return Cameras(local_views, photos, (x, y, z), weak_names=cameras.weak_names)


def view_from_pose(
    name: str, lens: Intrinsics, rotation: FloatArray, translation: FloatArray
) -> View:
    """Return a view from a pose, restoring the orthogonality of its rotation.

    Raises
    ------
    ValueError
        If the pose is not valid.
    """
    if not (np.isfinite(rotation).all() and np.isfinite(translation).all()):
        raise ValueError(tr("the pose is not finite"))
    if find_invalid_points(translation[None]).any():
        raise ValueError(tr("the position is not on Earth"))
    if (
        np.abs(rotation @ rotation.T - np.eye(3)).max() > MAX_ROTATION_DEVIATION
        or np.linalg.det(rotation) < 0
    ):
        raise ValueError(tr("the pose matrix is not a rotation"))
    u, _, vt = np.linalg.svd(rotation)
    # Restore the orthogonality lost by rounding while keeping the camera centre.
    exact_rotation = np.asarray(u @ vt, np.float64)
    return View(name, lens, exact_rotation, exact_rotation @ rotation.T @ translation)


def view_from_centre(name: str, lens: Intrinsics, rotation: FloatArray, centre: FloatArray) -> View:
    """Return the view of a photo from its rotation and projection centre.

    Raises ValueError if the pose is not valid.
    """
    view = view_from_pose(name, lens, rotation, np.zeros(3))
    if not np.isfinite(centre).all() or find_invalid_points(centre[None]).any():
        raise ValueError(tr("the position is not on Earth"))
    return View(name, lens, view.rotation, -view.rotation @ centre)


def pinhole_lens(width: int, height: int, focal: float) -> Intrinsics:
    """Return a lens without distortion, which replaces unsupported lens models."""
    return Intrinsics.pinhole(width, height, focal, width / 2, height / 2)


def missing_lens_findings(photos: Mapping[str, object]) -> tuple[Finding, ...]:
    """Return the finding about photos whose lens the file does not contain.

    Parameters
    ----------
    photos : mapping of str to object
        ID of the missing lens by photo name.
    """
    if not photos:
        return ()
    lenses = list(dict.fromkeys(str(lens) for lens in photos.values()))
    return (Finding("cameras.lenses-missing", lenses=lenses, photos=list(photos)),)


def unknown_lens_finding(model: str, photos: int) -> Finding:
    """Return the finding about photos with an unsupported lens model."""
    return Finding("cameras.unknown-lens", model=model, photos=photos)
