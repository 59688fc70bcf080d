"""Data of the Alignment window, which are read by a worker process and by threads."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import numpy.typing as npt
from PySide6.QtCore import QObject
from PySide6.QtGui import QImage

from vomstudio.core.arrays import AnyArray, ByteArray, FloatArray
from vomstudio.core.errors import InputError, VomError
from vomstudio.core.files.arrays import open_arrays
from vomstudio.core.files.regular import is_regular_file
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.io.photos.pixels import (
    read_orientation,
    read_stored_image,
    rotate_pixels_upright,
    rotate_upright,
)
from vomstudio.studio.jobs import job as jobs
from vomstudio.studio.jobs.events import Failed
from vomstudio.studio.jobs.inspection_tasks import (
    EMPTY_OVERVIEW,
    INSPECT_ALIGNMENT,
    INSPECT_DEPTHS,
    INSPECT_PAIR,
    INSPECT_RESIDUALS,
    AlignedPhoto,
    AlignmentOverview,
    AlignmentRequest,
    DepthSummary,
    PairRequest,
    PhotoRequest,
)
from vomstudio.studio.jobs.job import Request, Result
from vomstudio.studio.running_jobs import RunningJob
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.widgets.picture_panes import Picture

MAX_SIDE_PX = 3200
_MAX_CACHED_PHOTOS = 4

Arrays = dict[str, AnyArray]


@dataclass(eq=False)
class ShownPhoto:
    """Upright photo, which converts positions in pixels of the stored image.

    Attributes
    ----------
    image : QImage or None
        Upright image, or None if there is a `problem`.
    width, height : int
        Size of the stored image in pixels.
    orientation : int
        EXIF orientation.
    """

    name: str
    image: QImage | None
    width: int
    height: int
    orientation: int
    problem: str = ""

    def upright_points(self, pixels: npt.ArrayLike) -> FloatArray:
        """Convert pixels (n, 2) of the stored image to pixels of the upright image."""
        return rotate_pixels_upright(pixels, self.orientation, self.width, self.height)

    def upright_vectors(self, vectors: npt.ArrayLike) -> FloatArray:
        """Rotate vectors (n, 2) of the stored image to the upright image."""
        origin_pixel = rotate_pixels_upright(
            [[0.0, 0.0]], self.orientation, self.width, self.height
        )
        return self.upright_points(vectors) - origin_pixel

    @property
    def picture(self) -> Picture:
        """Upright image with its size, as drawn by a pane."""
        size = (self.width, self.height)
        if self.orientation in (5, 6, 7, 8):
            size = size[::-1]
        return Picture(self.name, self.image, size, self.problem)


def to_image(pixels: ByteArray) -> QImage:
    """Convert RGB values (h, w, 3) to an image that owns its memory."""
    pixels = np.ascontiguousarray(pixels)
    height, width = pixels.shape[:2]
    image = QImage(pixels.data, width, height, 3 * width, QImage.Format.Format_RGB888)
    return image.convertToFormat(QImage.Format.Format_RGB32)


class AlignmentData(QObject):
    """Reader for the data of a reconstruction. `read` sets `overview`."""

    def __init__(self, studio: Studio, folder: Path) -> None:
        super().__init__()
        self._studio, self.folder = studio, folder
        self._background = QtBackground(self)
        self._cached_photos: OrderedDict[str, ShownPhoto] = OrderedDict()
        self._requests: dict[str, tuple[object, RunningJob]] = {}
        self._is_closed = False
        self.overview = EMPTY_OVERVIEW

    def close(self) -> None:
        """Cancel all requests. No callback is called afterwards."""
        self._is_closed = True
        self._background.stop()
        for _, job in self._requests.values():
            self._studio.jobs.cancel(job)

    def read(self, callback: Callable[[], None], error_callback: Callable[[str], None]) -> None:
        """Read the overview, then call `callback`, or `error_callback` with a message."""

        def handle_result(result: AlignmentOverview, _: Arrays) -> None:
            self.overview = result
            callback()

        self._submit_job(
            INSPECT_ALIGNMENT,
            create_request=lambda _: AlignmentRequest(self.folder),
            callback=handle_result,
            error_callback=error_callback,
            prepare=None,
        )

    def read_pair(
        self,
        a: str,
        b: str,
        callback: Callable[[Arrays], None],
        error_callback: Callable[[str], None],
    ) -> None:
        """Read the matches of two photos, and pass their arrays to `callback`."""

        def create_request(array_path: Path) -> PairRequest:
            return PairRequest(self.folder, array_path, a, b)

        self._submit_job(
            INSPECT_PAIR,
            create_request=create_request,
            callback=lambda _, arrays: callback(arrays),
            error_callback=error_callback,
            prepare=_keep_orientation,
        )

    def read_residuals(
        self, name: str, callback: Callable[[Arrays], None], error_callback: Callable[[str], None]
    ) -> None:
        """Read the residuals of a photo, and pass their arrays to `callback`."""

        def create_request(array_path: Path) -> PhotoRequest:
            return PhotoRequest(self.folder, array_path, name)

        self._submit_job(
            INSPECT_RESIDUALS,
            create_request=create_request,
            callback=lambda _, arrays: callback(arrays),
            error_callback=error_callback,
            prepare=_keep_orientation,
        )

    def read_depths(
        self,
        name: str,
        callback: Callable[[DepthSummary, Arrays], None],
        error_callback: Callable[[str], None],
    ) -> None:
        """Read the depth map of a photo, rotate it upright, and pass it to `callback`."""
        photo_path = self._photo_path(name)

        def create_request(array_path: Path) -> PhotoRequest:
            return PhotoRequest(self.folder, array_path, name)

        self._submit_job(
            INSPECT_DEPTHS,
            create_request=create_request,
            callback=callback,
            error_callback=error_callback,
            prepare=lambda arrays: _rotate_arrays(arrays, photo_path),
        )

    def _submit_job(
        self,
        task: jobs.Job[Request, Result],
        create_request: Callable[[Path], Request],
        callback: Callable[[Result, Arrays], None],
        error_callback: Callable[[str], None],
        prepare: Callable[[Arrays], Arrays] | None,
    ) -> None:
        """Submit a job, which replaces an unfinished job of the same task.

        Parameters
        ----------
        create_request : callable
            Creates the request from the path of the array file.
        prepare : callable or None
            Converts the arrays in a thread, or None if the job writes no arrays.
        """
        task_name = task.name
        if task_name in self._requests:
            self._studio.jobs.cancel(self._requests[task_name][1])
        token = object()
        array_path: Path | None = None
        if prepare is not None:
            try:
                descriptor, name = tempfile.mkstemp(".npz", "vomstudio-")
            except OSError as error:
                error_callback(
                    tr(
                        "A temporary file cannot be written ({error}). Free some disk space.",
                        error=error,
                    )
                )
                return
            os.close(descriptor)
            array_path = Path(name)

        def is_current() -> bool:
            return not self._is_closed and self._requests.get(task_name, (None,))[0] is token

        def handle_result(result: Result) -> None:
            if array_path is None or prepare is None:
                finish(partial(callback, result, {}))
                return
            self._background.run(
                lambda: _read_temporary_arrays(array_path, prepare),
                lambda arrays: finish(partial(callback, result, arrays)),
                lambda error: finish(partial(error_callback, str(error))),
            )

        def finish(report: Callable[[], None]) -> None:
            if is_current():
                del self._requests[task_name]
                report()

        def handle_failure(event: Failed) -> None:
            if array_path is not None:
                array_path.unlink(missing_ok=True)
            if is_current():
                del self._requests[task_name]
                if not event.cancelled:
                    error_callback(event.message)

        job = self._studio.jobs.submit(
            task,
            create_request(array_path or Path()),
            title=tr("Reading the alignment"),
            on_done=handle_result,
            on_failed=handle_failure,
            is_quiet=True,
        )
        self._requests[task_name] = (token, job)

    def read_coverage(self, name: str, callback: Callable[[float | None], None]) -> None:
        """Pass the share of the usable pixels of a photo that have a depth to `callback`.

        The share is None if the photo has no depth map or the map cannot be read.
        """

        def compute() -> float | None:
            if self._is_closed:
                return None
            from vomstudio.photogrammetry.inspect.inspection import coverage

            return coverage(self.folder, name)

        self._background.run(compute, callback, lambda _: callback(None))

    # --- photos ------------------------------------------------------------------------------
    def find_photo(self, name: str) -> AlignedPhoto:
        return next(photo for photo in self.overview.photos if photo.name == name)

    def _photo_path(self, name: str) -> Path:
        """Find a photo in its original folder, or where that folder may have been moved."""
        original_folder = Path(self.overview.folder or ".")
        folders = (
            original_folder,
            self.folder.parent / original_folder.name,
            self.folder / "photos",
        )
        return next(
            (folder / name for folder in folders if is_regular_file(folder / name)),
            original_folder / name,
        )

    def load_photo(self, name: str, callback: Callable[[ShownPhoto], None]) -> None:
        """Pass a photo to `callback`. If it cannot be read, it contains a `problem`."""
        if name in self._cached_photos:
            self._cached_photos.move_to_end(name)
            callback(self._cached_photos[name])
            return
        aligned_photo = self.find_photo(name)
        width, height = aligned_photo.width, aligned_photo.height

        def handle_photo(photo: ShownPhoto) -> None:
            self._cached_photos[name] = photo
            while len(self._cached_photos) > _MAX_CACHED_PHOTOS:
                self._cached_photos.popitem(last=False)
            callback(photo)

        path = self._photo_path(name)
        self._background.run(lambda: _read_photo(name, path, width, height), handle_photo)


def _keep_orientation(arrays: Arrays) -> Arrays:
    return arrays


def _rotate_arrays(arrays: Arrays, photo: Path) -> Arrays:
    """Rotate arrays by the EXIF orientation of a photo, if the photo still exists."""
    try:
        orientation = read_orientation(photo)
    except VomError:
        return arrays
    return {name: rotate_upright(values, orientation) for name, values in arrays.items()}


def _read_temporary_arrays(path: Path, prepare: Callable[[Arrays], Arrays]) -> Arrays:
    """Read and prepare the arrays of a temporary file, and delete the file."""
    try:
        with open_arrays(path) as arrays:
            return prepare({name: arrays[name] for name in arrays.files})
    except (OSError, ValueError, EOFError) as error:
        raise InputError(Finding("alignment.damaged", reason=str(error))) from error
    finally:
        with contextlib.suppress(OSError):
            path.unlink()


def _read_photo(name: str, path: Path, width: int, height: int) -> ShownPhoto:
    try:
        pixels, size, orientation = read_stored_image(path, MAX_SIDE_PX)
    except VomError as error:
        return ShownPhoto(
            name=name, image=None, width=width, height=height, orientation=1, problem=str(error)
        )
    if size != (width, height):
        problem = tr(
            "{path} differs in size from the aligned photo. Restore the original photo.",
            path=path,
        )
        return ShownPhoto(
            name=name, image=None, width=width, height=height, orientation=1, problem=problem
        )
    return ShownPhoto(
        name=name,
        image=to_image(rotate_upright(pixels, orientation)),
        width=width,
        height=height,
        orientation=orientation,
    )
