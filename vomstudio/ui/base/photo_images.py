"""Reading of photos and their thumbnails in worker threads."""

from __future__ import annotations

import contextlib
from collections import OrderedDict
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from PySide6.QtCore import QObject, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QImage, QImageIOHandler, QImageReader, QPainter, QTransform

from vomstudio.core.arrays import ByteArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import open_regular_file
from vomstudio.core.files.untrusted.heif import is_heif
from vomstudio.core.files.untrusted.pictures import check_picture
from vomstudio.core.findings import Finding
from vomstudio.io.photos.exif import read_exif
from vomstudio.io.photos.pixels import open_photo, thumbnail
from vomstudio.studio.background import Request
from vomstudio.ui.base.qt_background import QtBackground

THUMBNAIL_SIZE = QSize(102, 68)
_PREVIEW_SIZE_PX = 1600  # long side of the reduced image of a large photo
_MAX_IMAGE_MB = 4096  # 100 megapixels need 400 MB
_MAX_CACHE_BYTES = 700_000_000
_BAND_ROWS = 128
_PICTURE_KEY = "picture"
MAX_WAIT_S = 5.0
"""Maximum time to wait for a photo being decoded when a window closes."""
_Transformation = QImageIOHandler.Transformation


@dataclass(frozen=True, eq=False)
class PhotoPyramid:
    """Image pyramid of a photo in its stored orientation.

    Attributes
    ----------
    width, height : int
        Size of the stored photo, in pixels.
    to_upright : QTransform
        Transform from stored to upright pixels, from the orientation tag of the photo.
    is_complete : bool
        Whether the full resolution has been read; False while only a downsampled image is
        available.
    """

    levels: tuple[QImage, ...]
    width: int
    height: int
    to_upright: QTransform
    is_complete: bool = True

    @property
    def size_bytes(self) -> int:
        return sum(level.sizeInBytes() for level in self.levels)


def orientation_transform(
    orientation: QImageIOHandler.Transformation, width: int, height: int
) -> QTransform:
    """Return the transform from stored to upright pixels, with (0, 0) at a pixel corner."""
    w, h = float(width), float(height)
    # x' = m11 x + m21 y + dx, y' = m12 x + m22 y + dy
    rows = {
        _Transformation.TransformationNone: (1, 0, 0, 1, 0, 0),
        _Transformation.TransformationMirror: (-1, 0, 0, 1, w, 0),
        _Transformation.TransformationFlip: (1, 0, 0, -1, 0, h),
        _Transformation.TransformationRotate180: (-1, 0, 0, -1, w, h),
        _Transformation.TransformationRotate90: (0, 1, -1, 0, h, 0),
        _Transformation.TransformationMirrorAndRotate90: (0, -1, -1, 0, h, w),
        _Transformation.TransformationFlipAndRotate90: (0, 1, 1, 0, 0, 0),
        _Transformation.TransformationRotate270: (0, -1, 1, 0, 0, w),
    }
    return QTransform(*(float(v) for v in rows[orientation]))


class PhotoImages(QObject):
    """Cache of photos and thumbnails, read in the background.

    Attributes
    ----------
    picture_loaded : Signal
        Emitted with the path and a `PhotoPyramid` (for a large photo, first a downsampled one)
        or the text of an error.
    thumbnail_loaded : Signal
        Emitted with the path and an upright `QImage`, which is null if the photo cannot be read.
    """

    picture_loaded = Signal(str, object)
    thumbnail_loaded = Signal(str, object)

    def __init__(self) -> None:
        super().__init__()
        QImageReader.setAllocationLimit(_MAX_IMAGE_MB)
        self._pictures: OrderedDict[str, PhotoPyramid] = OrderedDict()
        self._thumbnails: dict[str, QImage] = {}
        self._requested_key: str | None = None
        self._background = QtBackground(self, "photos", threads=1)

    def picture(self, path: Path) -> PhotoPyramid | None:
        """Return a photo if it is cached; otherwise request it with priority and return None."""
        key = str(path)
        cached_picture = self._pictures.get(key)
        if cached_picture is not None:
            self._pictures.move_to_end(key)
            return cached_picture
        if self._requested_key != key or not self._background.is_waiting(_PICTURE_KEY):
            self._requested_key = key
            self._background.run_request(
                partial(_read_pyramid, path),
                partial(self._store_picture, key),
                lambda error: self.picture_loaded.emit(key, error.message),
                key=_PICTURE_KEY,
                is_first=True,
            )
        return None

    def thumbnail(self, path: Path) -> QImage | None:
        """Return a thumbnail if it is cached; otherwise request it and return None."""
        key = str(path)
        cached_thumbnail = self._thumbnails.get(key)
        if cached_thumbnail is None and not self._background.is_waiting(key):
            self._background.run(
                partial(_read_thumbnail, path),
                partial(self._store_thumbnail, key),
                lambda _: self._store_thumbnail(key, QImage()),
                key=key,
            )
        return cached_thumbnail

    def close(self) -> None:
        self._background.stop(wait_s=MAX_WAIT_S)

    def _store_picture(self, key: str, picture: PhotoPyramid) -> None:
        if picture.is_complete:
            self._pictures[key] = picture
            self._pictures.move_to_end(key)
            while (
                len(self._pictures) > 1
                and sum(p.size_bytes for p in self._pictures.values()) > _MAX_CACHE_BYTES
            ):
                self._pictures.popitem(last=False)
        self.picture_loaded.emit(key, picture)

    def _store_thumbnail(self, key: str, image: QImage) -> None:
        self._thumbnails[key] = image
        self.thumbnail_loaded.emit(key, image)


def _read_pyramid(path: Path, request: Request[PhotoPyramid]) -> PhotoPyramid:
    if _is_heif(path):
        with open_photo(path) as photo:
            pixels, orientation = np.asarray(photo), _TRANSFORMATIONS[read_exif(photo).orientation]
        return _create_pyramid(_to_image(pixels), orientation)
    _check_photo_file(path)
    reader = _create_reader(path)
    reader.setAutoTransform(False)
    size, orientation = reader.size(), reader.transformation()
    orientation = (
        _Transformation(orientation.value) if hasattr(orientation, "value") else orientation
    )
    width, height = size.width(), size.height()
    if max(width, height) > 2 * _PREVIEW_SIZE_PX:
        preview_reader = _create_reader(path)
        preview_reader.setAutoTransform(False)
        preview_reader.setScaledSize(
            size.scaled(QSize(_PREVIEW_SIZE_PX, _PREVIEW_SIZE_PX), _KEEP_ASPECT_RATIO)
        )
        image = preview_reader.read()
        if not image.isNull():
            to_upright = orientation_transform(orientation, width, height)
            request.emit(
                PhotoPyramid((_convert_for_drawing(image),), width, height, to_upright, False)
            )
        request.check()
    image = reader.read()
    if image.isNull():
        raise InputError(Finding("photo.unreadable", reason=reader.errorString()))
    return _create_pyramid(image, orientation)


def _create_pyramid(image: QImage, orientation: _Transformation) -> PhotoPyramid:
    width, height = image.width(), image.height()
    levels = [_convert_for_drawing(image)]
    while max(levels[-1].width(), levels[-1].height()) > 1200:
        levels.append(_halve_size(levels[-1]))
    return PhotoPyramid(
        tuple(levels), width, height, orientation_transform(orientation, width, height)
    )


def _read_thumbnail(path: Path) -> QImage:
    if _is_heif(path):
        side = 2 * max(THUMBNAIL_SIZE.width(), THUMBNAIL_SIZE.height())
        return _convert_for_drawing(_to_image(thumbnail(path, side)))
    _check_photo_file(path)
    reader = _create_reader(path)
    reader.setAutoTransform(True)
    size = reader.size()
    if size.isValid():
        reader.setScaledSize(size.scaled(THUMBNAIL_SIZE * 2, _KEEP_ASPECT_RATIO))
    return _convert_for_drawing(reader.read())


def _is_heif(path: Path) -> bool:
    with contextlib.suppress(OSError, InputError), open_regular_file(path) as file:
        return is_heif(file.read(12))
    return False


def _to_image(pixels: ByteArray) -> QImage:
    """Convert RGB pixels (h, w, 3) to an image with its own memory."""
    pixels = np.ascontiguousarray(pixels)
    height, width = pixels.shape[:2]
    return QImage(pixels.data, width, height, 3 * width, QImage.Format.Format_RGB888).copy()


def _check_photo_file(path: Path) -> None:
    try:
        check_picture(path)
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(Finding("file.unreadable", reason=reason)) from error


def _create_reader(path: Path) -> QImageReader:
    """Return a reader limited to the formats of photos, whatever plugins Qt has."""
    format_name = b""
    with contextlib.suppress(OSError, InputError), open_regular_file(path) as file:
        header = file.read(4)
        format_name = next(
            (
                name
                for signature, name in _FORMATS_BY_SIGNATURE.items()
                if header.startswith(signature)
            ),
            b"",
        )
    reader = QImageReader(str(path) if format_name else "", format_name)
    reader.setAutoDetectImageFormat(False)
    return reader


_FORMATS_BY_SIGNATURE = {
    b"\xff\xd8": b"jpeg",
    b"\x89PNG": b"png",
    b"II*\0": b"tiff",
    b"MM\0*": b"tiff",
}
_TRANSFORMATIONS = {
    1: _Transformation.TransformationNone,
    2: _Transformation.TransformationMirror,
    3: _Transformation.TransformationRotate180,
    4: _Transformation.TransformationFlip,
    5: _Transformation.TransformationFlipAndRotate90,
    6: _Transformation.TransformationRotate90,
    7: _Transformation.TransformationMirrorAndRotate90,
    8: _Transformation.TransformationRotate270,
}
"""Qt's transformation for each EXIF orientation."""
_KEEP_ASPECT_RATIO = Qt.AspectRatioMode.KeepAspectRatio


def _halve_size(image: QImage) -> QImage:
    """Halve the size of an image in bands, because each Qt call blocks the window."""
    half_size = (image.size() / 2).expandedTo(QSize(1, 1))
    result = QImage(half_size, QImage.Format.Format_RGB32)
    painter = QPainter(result)
    painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
    step = image.height() / half_size.height()
    for top in range(0, half_size.height(), _BAND_ROWS):
        rows = min(_BAND_ROWS, half_size.height() - top)
        source = QRectF(0, top * step, image.width(), rows * step)
        painter.drawImage(QRectF(0, top, half_size.width(), rows), image, source)
    painter.end()
    return result


def _convert_for_drawing(image: QImage) -> QImage:
    """Return an image in the format that Qt draws fastest."""
    return image if image.isNull() else image.convertToFormat(QImage.Format.Format_RGB32)
