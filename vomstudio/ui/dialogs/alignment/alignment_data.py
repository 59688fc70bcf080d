"""The data of the Alignment window, read by a worker and by threads."""

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
from vomstudio.core.files.regular import is_regular
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.io.photos.pixels import orientation_of, pixels_upright, read_stored, rotate_upright
from vomstudio.studio.jobs import job as jobs
from vomstudio.studio.jobs.events import Failed
from vomstudio.studio.jobs.inspection_tasks import (
    INSPECT_ALIGNMENT,
    INSPECT_DEPTHS,
    INSPECT_PAIR,
    INSPECT_RESIDUALS,
    NOTHING_ALIGNED,
    AlignedPhoto,
    AlignmentOverview,
    AlignmentRequest,
    DepthFacts,
    PairRequest,
    PhotoRequest,
)
from vomstudio.studio.jobs.job import Request, Result
from vomstudio.studio.running_jobs import RunningJob
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.widgets.picture_panes import Picture

LONG_SIDE = 3200
_KEPT = 4

Arrays = dict[str, AnyArray]


@dataclass(eq=False)
class ShownPhoto:
    """A photo as it is drawn: upright, while positions in it are given in pixels as stored.

    width, height, orientation : as stored, and as EXIF says. image : upright, None with a `problem`
    """

    name: str
    image: QImage | None
    width: int
    height: int
    orientation: int
    problem: str = ""

    def upright_points(self, pixels: npt.ArrayLike) -> FloatArray:
        """Pixels (n, 2) of the upright picture, from pixels (n, 2) as stored."""
        return pixels_upright(pixels, self.orientation, self.width, self.height)

    def upright_vectors(self, vectors: npt.ArrayLike) -> FloatArray:
        """Vectors (n, 2) as stored, turned with the picture."""
        zero = pixels_upright([[0.0, 0.0]], self.orientation, self.width, self.height)
        return self.upright_points(vectors) - zero

    @property
    def picture(self) -> Picture:
        """What a pane draws: the upright image and its size as the upright photo."""
        size = (self.width, self.height)
        if self.orientation in (5, 6, 7, 8):
            size = size[::-1]
        return Picture(self.name, self.image, size, self.problem)


def to_image(pixels: ByteArray) -> QImage:
    """A picture with its own memory of (h, w, 3) red, green and blue."""
    pixels = np.ascontiguousarray(pixels)
    height, width = pixels.shape[:2]
    shown = QImage(pixels.data, width, height, 3 * width, QImage.Format.Format_RGB888)
    return shown.convertToFormat(QImage.Format.Format_RGB32)


class AlignmentData(QObject):
    """What is known of one reconstruction. overview : see `inspection.overview`; set by `read`."""

    def __init__(self, studio: Studio, folder: Path) -> None:
        super().__init__()
        self._studio, self.folder = studio, folder
        self._background = QtBackground(self)
        self._photos: OrderedDict[str, ShownPhoto] = OrderedDict()
        self._asked: dict[str, tuple[object, RunningJob]] = {}
        self._closed = False
        self.overview = NOTHING_ALIGNED

    def close(self) -> None:
        """Cancel what is being read; nothing is passed on any more."""
        self._closed = True
        self._background.stop()
        for _, job in self._asked.values():
            self._studio.jobs.cancel(job)

    def read(self, then: Callable[[], None], failed: Callable[[str], None]) -> None:
        """Read the overview, then call `then`, or `failed` with a sentence."""

        def arrived(result: AlignmentOverview, _: Arrays) -> None:
            self.overview = result
            then()

        self._ask(INSPECT_ALIGNMENT, lambda _: AlignmentRequest(self.folder), arrived, failed, None)

    def pair(
        self, a: str, b: str, then: Callable[[Arrays], None], failed: Callable[[str], None]
    ) -> None:
        """Read the matches of two photos: pass the arrays of `inspection.pair` to `then`, or a
        sentence to `failed`."""

        def asked(into: Path) -> PairRequest:
            return PairRequest(self.folder, into, a, b)

        self._ask(INSPECT_PAIR, asked, lambda _, arrays: then(arrays), failed, _as_read)

    def residuals(
        self, name: str, then: Callable[[Arrays], None], failed: Callable[[str], None]
    ) -> None:
        """Read the residuals of a photo, as `pair` does."""

        def asked(into: Path) -> PhotoRequest:
            return PhotoRequest(self.folder, into, name)

        self._ask(INSPECT_RESIDUALS, asked, lambda _, arrays: then(arrays), failed, _as_read)

    def depths(
        self,
        name: str,
        then: Callable[[DepthFacts, Arrays], None],
        failed: Callable[[str], None],
    ) -> None:
        """Read the depth map of a photo; pictures and depths are turned upright."""
        path = self._path(name)

        def asked(into: Path) -> PhotoRequest:
            return PhotoRequest(self.folder, into, name)

        self._ask(INSPECT_DEPTHS, asked, then, failed, lambda arrays: _turn(arrays, path))

    def _ask(
        self,
        task: jobs.Job[Request, Result],
        asked: Callable[[Path], Request],
        then: Callable[[Result, Arrays], None],
        failed: Callable[[str], None],
        prepare: Callable[[Arrays], Arrays] | None,
    ) -> None:
        """Have a worker read something; of several wishes of one kind only the last is heard.

        asked : of the file for the arrays; prepare : of the arrays that come, None for a job that
        answers without arrays
        """
        kind = task.name
        if kind in self._asked:
            self._studio.jobs.cancel(self._asked[kind][1])
        mark = object()
        into: Path | None = None
        if prepare is not None:
            try:
                descriptor, name = tempfile.mkstemp(".npz", "vomstudio-")
            except OSError as error:
                failed(tr("A temporary file cannot be written ({error}).", error=error))
                return
            os.close(descriptor)
            into = Path(name)

        def current() -> bool:
            return not self._closed and self._asked.get(kind, (None,))[0] is mark

        def arrived(result: Result) -> None:
            if into is None or prepare is None:
                end(partial(then, result, {}))
                return
            self._background.run(
                lambda: _take(into, prepare),
                lambda arrays: end(partial(then, result, arrays)),
                lambda error: end(partial(failed, str(error))),
            )

        def end(call: Callable[[], None]) -> None:
            if current():
                del self._asked[kind]
                call()

        def failing(event: Failed) -> None:
            if into is not None:
                into.unlink(missing_ok=True)
            if current():
                del self._asked[kind]
                if not event.cancelled:
                    failed(event.message)

        job = self._studio.jobs.submit(
            task,
            asked(into or Path()),
            title=tr("Reading the alignment"),
            on_done=arrived,
            on_failed=failing,
            quiet=True,
        )
        self._asked[kind] = (mark, job)

    def coverage(self, name: str, then: Callable[[float | None], None]) -> None:
        """Pass to `then` the share of a photo's pixels that have a depth, None without a map."""

        def work() -> float | None:
            if self._closed:
                return None
            from vomstudio.photogrammetry.inspect.inspection import coverage

            return coverage(self.folder, name)

        self._background.run(work, then, lambda _: then(None))

    # --- photos ------------------------------------------------------------------------------
    def row(self, name: str) -> AlignedPhoto:
        return next(photo for photo in self.overview.photos if photo.name == name)

    def _path(self, name: str) -> Path:
        """Where the photos were, or where they are once the folder was moved along with them."""
        were = Path(self.overview.folder or ".")
        places = (were, self.folder.parent / were.name, self.folder / "photos")
        return next((p / name for p in places if is_regular(p / name)), were / name)

    def photo(self, name: str, then: Callable[[ShownPhoto], None]) -> None:
        """Call `then` with a photo; one that cannot be read says why in its place."""
        if name in self._photos:
            self._photos.move_to_end(name)
            then(self._photos[name])
            return
        row = self.row(name)
        width, height = row.width, row.height

        def arrived(made: ShownPhoto) -> None:
            self._photos[name] = made
            while len(self._photos) > _KEPT:
                self._photos.popitem(last=False)
            then(made)

        path = self._path(name)
        self._background.run(lambda: _read_photo(name, path, width, height), arrived)


def _as_read(arrays: Arrays) -> Arrays:
    return arrays


def _turn(arrays: Arrays, photo: Path) -> Arrays:
    """As the photo's EXIF says; as stored where the photo is gone."""
    try:
        turn = orientation_of(photo)
    except VomError:
        return arrays
    return {name: rotate_upright(values, turn) for name, values in arrays.items()}


def _take(path: Path, prepare: Callable[[Arrays], Arrays]) -> Arrays:
    """The arrays of a file that is for this one reader."""
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
        pixels, size, orientation = read_stored(path, LONG_SIDE)
    except VomError as error:
        return ShownPhoto(name, None, width, height, 1, str(error))
    if size != (width, height):
        problem = tr(
            "{path} has another size than the photo that was aligned. Put the original photo "
            "there.",
            path=path,
        )
        return ShownPhoto(name, None, width, height, 1, problem)
    return ShownPhoto(
        name, to_image(rotate_upright(pixels, orientation)), width, height, orientation
    )
