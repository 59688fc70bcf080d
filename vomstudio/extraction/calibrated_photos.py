"""The photos of a model with their cameras, opened beside it: in World, with their pixels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import ByteArray, FloatArray
from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.geometry import transform
from vomstudio.geometry.cameras import View
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh

if TYPE_CHECKING:
    from vomstudio.photogrammetry.inspect.photo_views import PhotoViews


# Of a cloud a line of sight meets points within so many times their usual spacing.
_REACH_SPACINGS = 1.0
# Sides of a photo and of its camera may differ by rounding when it was made smaller.
_SAME_SHAPE = 0.005
_WHOLE = 1 << 30


@dataclass(frozen=True, eq=False)
class CalibratedPhotos:
    """views : what the photos see of the model, World
    chosen : the row of the view that was asked for
    files : of the views' photos by row, as far as they were found
    """

    views: PhotoViews
    chosen: int
    files: Mapping[int, Path]
    cameras: Path
    warnings: tuple[Finding, ...] = ()

    @property
    def name(self) -> str:
        """Of the photo that was chosen."""
        return self.views.views[self.chosen].name

    def pixels(self, view: int) -> ByteArray:
        """(height, width, 3) as stored, of the size that the camera has. Raises InputError."""
        from vomstudio.io.photos.pixels import read_stored

        picture, _, _ = read_stored(self.files[view], _WHOLE)
        lens = self.views.views[view].intrinsics
        height, width = picture.shape[:2]
        if (width, height) != (lens.width, lens.height):
            raise InputError(
                Finding(
                    "photo.other-size",
                    width=width,
                    height=height,
                    aligned_width=lens.width,
                    aligned_height=lens.height,
                ),
                file=self.files[view],
            )
        return picture


def open_photos(
    data: Mesh | PointCloud,
    resolution: float,
    photo: str | Path,
    cameras: str | Path,
    to_world: npt.ArrayLike | None = None,
) -> CalibratedPhotos:
    """The photos that `cameras` knows, one of them chosen.

    data : the model, World; resolution : of it, m
    photo : a file, or the name of a photo whose file lies where the cameras say or beside them
    to_world : (4, 4) from the frame of the model's file, in which the cameras stand
    Raises InputError and UsageError that name the file.
    """
    from vomstudio.geometry.rays.raytree import RayTree
    from vomstudio.io.photos.cameras_file import Cameras
    from vomstudio.io.photos.own_cameras.reading import read_own_cameras
    from vomstudio.photogrammetry.inspect.photo_views import PhotoViews

    matrix = np.eye(4) if to_world is None else np.asarray(to_world, np.float64)
    own = read_own_cameras(cameras, _bounds_in_file(data, matrix))
    if not own.views:
        raise InputError(
            Finding("cameras.no-poses"),
            file=cameras,
        )
    names = list(own.views)
    chosen, files = _files(names, own, Path(photo))
    scale = transform.scale_of(matrix)
    moved = [own.views[n].moved(scale, matrix[:3, :3] / scale, matrix[:3, 3]) for n in names]
    origin = np.floor(np.median([view.centre for view in moved], axis=0))
    near = tuple(
        scaled(view, files.get(i)).moved(1.0, np.eye(3), -origin) for i, view in enumerate(moved)
    )
    x, y, z = (int(value) for value in origin)
    tree = RayTree(data, _REACH_SPACINGS * resolution)
    views = PhotoViews(Cameras(near, Path("."), (x, y, z)), tree, None, resolution)
    return CalibratedPhotos(views, chosen, files, Path(cameras), own.warnings)


def _files(names: list[str], own: object, photo: Path) -> tuple[int, dict[int, Path]]:
    """The row of the photo that is meant, and the files of all that are found: beside it, else
    where the cameras say."""
    from vomstudio.io.photos.own_cameras.photos import find_camera_photos
    from vomstudio.io.photos.own_cameras.result import OwnCameras
    from vomstudio.io.photos.photo_names import photo_finder

    assert isinstance(own, OwnCameras)
    row = photo_finder(names)(photo.as_posix())
    if row is None:
        raise UsageError(
            Finding("photo.no-camera", photo=photo.name, cameras=own.path.name, photos=names),
            field="--photo",
        )
    found = dict[str, Path]()
    if photo.is_file():
        found = find_camera_photos(own, photo.parent)
    else:
        found = find_camera_photos(own)
        if names[row] not in found:
            raise InputError(Finding("file.missing"), file=photo)
    files = {i: found[name] for i, name in enumerate(names) if name in found}
    if photo.is_file():
        files[row] = photo
    return row, files


def scaled(view: View, file: Path | None) -> View:
    """The view for its photo as it lies there, which may have been made smaller."""
    from vomstudio.io.photos.pixels import open_photo

    if file is None:
        return view
    lens = view.intrinsics
    try:
        with open_photo(file) as image:
            width, height = image.width, image.height
    except InputError:
        return view
    if (width, height) == (lens.width, lens.height):
        return view
    if abs(width * lens.height / (height * lens.width) - 1.0) > _SAME_SHAPE:
        return view
    return View(view.name, lens.scaled(width, height), view.rotation, view.translation)


def _bounds_in_file(data: Mesh | PointCloud, matrix: FloatArray) -> FloatArray:
    """(2, 3) box around the model in the frame of its file."""
    low, high = np.asarray(data.bounds, np.float64)
    grid = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    corners = transform.apply(transform.invert(matrix), np.where(grid == 1, high, low))
    return np.stack([corners.min(axis=0), corners.max(axis=0)])
