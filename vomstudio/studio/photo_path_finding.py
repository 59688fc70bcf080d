"""Paths in the pixels of photos, projected onto open models."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError
from vomstudio.core.files.regular import is_regular_file
from vomstudio.core.findings import Finding
from vomstudio.geometry import transform
from vomstudio.studio.photos import ModelPhotos
from vomstudio.studio.tools.followed_line import FollowedPath

if TYPE_CHECKING:
    from vomstudio.extraction.calibrated_photos import CalibratedPhotos
    from vomstudio.extraction.photo_following import PhotoFollower


class PhotoPaths:
    """Path finder for use in a single thread, with a cache of the last photos used."""

    def __init__(self) -> None:
        self._photos: ModelPhotos | None = None
        self._opened: CalibratedPhotos | None = None
        self._follower: PhotoFollower | None = None

    def clear_state(self) -> None:
        """Discard the cached pictures."""
        self._photos = self._opened = self._follower = None

    def find_path(
        self, photos: ModelPhotos, photo: str, cost: str, ends: FloatArray, *, is_live: bool
    ) -> FollowedPath:
        """Find the path between two points (2, 3) on a model.

        Parameters
        ----------
        photos : ModelPhotos
        photo : str
            Name of the photo.
        cost : str
            Name of the cost.
        ends : (2, 3) ndarray
            End points of the path, in the file frame of the model.
        is_live : bool
            Whether to skip the check against other photos.

        Raises
        ------
        GeometryError
            If the photo does not show both points.
        InputError, UsageError
        """
        follower = self._open_follower(photos, photo, cost)
        views, row = follower.photos.views, follower.photos.view_row
        world = transform.apply(views.to_world, ends)
        # Points that are hidden by a small amount lie at the edge that was clicked.
        if not views.shows(row, world, 4.0 * views.resolution).all():
            raise GeometryError(Finding("photo.not-showing", photo=photo.rpartition("/")[2]))
        path = follower.follow(views.pixels(row, world), is_alone=is_live)
        points = transform.apply(transform.invert(views.to_world), path.points)
        return FollowedPath(
            points,
            photo,
            path.voters,
            path.judged_count,
            path.confirmed_count,
            () if is_live else path.warnings,
            is_final=not is_live,
            costs=path.costs,
        )

    def _open_follower(self, photos: ModelPhotos, photo: str, cost: str) -> PhotoFollower:
        from vomstudio.extraction.photo_following import PhotoFollower

        if photos is not self._photos or self._opened is None:
            self.clear_state()
            self._opened, self._photos = _open_photos(photos), photos
        follower, row = self._follower, photos.views.row(photo)
        if follower is None or follower.photos.view_row != row:
            self._follower = None
            if row not in self._opened.files:
                raise GeometryError(Finding("photo.file-missing", photo=photo))
            follower = PhotoFollower(replace(self._opened, view_row=row), cost)
            self._follower = follower
        return follower.with_cost(cost)


def _open_photos(photos: ModelPhotos) -> CalibratedPhotos:
    """Return the cameras, scaled to the photos in the folder, which may be downsized."""
    from vomstudio.extraction.calibrated_photos import CalibratedPhotos, scale_view
    from vomstudio.io.photos.cameras_file import FILE_NAME
    from vomstudio.photogrammetry.inspect.photo_views import PhotoViews

    views = photos.views
    paths = {row: photos.path(row) for row in range(len(views.views))}
    files = {row: path for row, path in paths.items() if path is not None and is_regular_file(path)}
    scaled_views = tuple(scale_view(view, files.get(row)) for row, view in enumerate(views.views))
    cameras = replace(views.cameras, views=scaled_views)
    views_of_files = PhotoViews(cameras, views.tree, views.to_world, views.resolution)
    return CalibratedPhotos(views_of_files, 0, files, views.cameras.photos / FILE_NAME)
