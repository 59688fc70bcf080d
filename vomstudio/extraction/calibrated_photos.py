"""Calibrated photos of a model in the World frame, with their pixels."""

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


# Distance within which a line of sight hits a point of a cloud, in typical point spacings.
_SIGHT_RADIUS_SPACINGS = 1.0
# Tolerance for the aspect ratio of a reduced photo relative to its camera.
_ASPECT_TOLERANCE = 0.005
_MAX_SIZE_PX = 1 << 30


@dataclass(frozen=True, eq=False)
class CalibratedPhotos:
    """Photos of a model with their calibrated cameras.

    Parameters
    ----------
    views : PhotoViews
        Views of the model in the World frame.
    view_row : int
        Row of the requested view.
    files : mapping of int to Path
        Existing photo files, by row of the view.
    cameras : Path
    warnings : tuple of Finding
    """

    views: PhotoViews
    view_row: int
    files: Mapping[int, Path]
    cameras: Path
    warnings: tuple[Finding, ...] = ()

    @property
    def name(self) -> str:
        """Name of the requested photo."""
        return self.views.views[self.view_row].name

    def pixels(self, view: int) -> ByteArray:
        """Read the pixels of a photo in their stored orientation, at the size of its camera.

        Parameters
        ----------
        view : int
            Row of the view.

        Returns
        -------
        (height, width, 3) uint8 array

        Raises
        ------
        InputError
            If the photo cannot be read, or if its size does not match.
        """
        from vomstudio.io.photos.pixels import read_stored_image

        picture, _, _ = read_stored_image(self.files[view], _MAX_SIZE_PX)
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
    """Open the photos of a camera file, one of which is the requested photo.

    Parameters
    ----------
    data : Mesh or PointCloud
        Model in the World frame, m.
    resolution : float
        Resolution of the model, m.
    photo : str or Path
        File, or name of a photo that is at the location given in the camera file or beside it.
    cameras : str or Path
        Poses and lenses in the frame of the model file.
    to_world : (4, 4) array_like, optional
        Transform from the frame of the model file to the World frame.

    Returns
    -------
    CalibratedPhotos

    Raises
    ------
    InputError, UsageError
        If the photo or the camera file cannot be used; the error names the file.
    """
    from vomstudio.geometry.rays.raytree import RayTree
    from vomstudio.io.photos.cameras_file import Cameras
    from vomstudio.io.photos.own_cameras.reading import read_camera_file
    from vomstudio.photogrammetry.inspect.photo_views import PhotoViews

    matrix = np.eye(4) if to_world is None else np.asarray(to_world, np.float64)
    file_cameras = read_camera_file(cameras, _file_bounds(data, matrix))
    if not file_cameras.views:
        raise InputError(
            Finding("cameras.no-poses"),
            file=cameras,
        )
    names = list(file_cameras.views)
    row, files = _files(names, file_cameras, Path(photo))
    scale = transform.scale_factor(matrix)
    world_views = [
        file_cameras.views[n].moved(scale, matrix[:3, :3] / scale, matrix[:3, 3]) for n in names
    ]
    origin = np.floor(np.median([view.centre for view in world_views], axis=0))
    local_views = tuple(
        scale_view(view, files.get(i)).moved(1.0, np.eye(3), -origin)
        for i, view in enumerate(world_views)
    )
    x, y, z = (int(value) for value in origin)
    tree = RayTree(data, _SIGHT_RADIUS_SPACINGS * resolution)
    views = PhotoViews(Cameras(local_views, Path("."), (x, y, z)), tree, None, resolution)
    return CalibratedPhotos(views, row, files, Path(cameras), file_cameras.warnings)


def _files(names: list[str], file_cameras: object, photo: Path) -> tuple[int, dict[int, Path]]:
    """Return the row of the requested photo, and the files of all existing photos.

    Photos are searched for beside the requested photo if it is a file, otherwise at the locations
    given in the camera file.

    Raises
    ------
    UsageError
        If the photo has no camera.
    InputError
        If the requested photo is missing.
    """
    from vomstudio.io.photos.own_cameras.photos import find_camera_photos
    from vomstudio.io.photos.own_cameras.result import ModelCameras
    from vomstudio.io.photos.photo_names import photo_finder

    assert isinstance(file_cameras, ModelCameras)
    row = photo_finder(names)(photo.as_posix())
    if row is None:
        raise UsageError(
            Finding(
                "photo.no-camera", photo=photo.name, cameras=file_cameras.path.name, photos=names
            ),
            field="--photo",
        )
    paths = dict[str, Path]()
    if photo.is_file():
        paths = find_camera_photos(file_cameras, photo.parent)
    else:
        paths = find_camera_photos(file_cameras)
        if names[row] not in paths:
            raise InputError(Finding("file.missing"), file=photo)
    files = {i: paths[name] for i, name in enumerate(names) if name in paths}
    if photo.is_file():
        files[row] = photo
    return row, files


def scale_view(view: View, file: Path | None) -> View:
    """Return a view scaled to the size of its photo file.

    The view is returned unchanged if the file is None or unreadable, or has another aspect ratio.

    Parameters
    ----------
    view : View
    file : Path or None
        File of the photo, which may be a reduced copy.

    Returns
    -------
    View
    """
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
    if abs(width * lens.height / (height * lens.width) - 1.0) > _ASPECT_TOLERANCE:
        return view
    return View(view.name, lens.scaled(width, height), view.rotation, view.translation)


def _file_bounds(data: Mesh | PointCloud, matrix: FloatArray) -> FloatArray:
    """Return the bounding box (2, 3) of the model in the frame of its file."""
    low, high = np.asarray(data.bounds, np.float64)
    grid = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    corners = transform.apply(transform.invert(matrix), np.where(grid == 1, high, low))
    return np.stack([corners.min(axis=0), corners.max(axis=0)])
