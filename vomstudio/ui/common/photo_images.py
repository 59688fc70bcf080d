"""Photos and their thumbnails, read in a thread of their own."""

from __future__ import annotations

import contextlib
from collections import OrderedDict
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, QRectF, QSize, Qt, Signal
from PySide6.QtGui import QImage, QImageIOHandler, QImageReader, QPainter, QTransform

from vomstudio.errors import InputError
from vomstudio.files.regular import open_regular
from vomstudio.files.untrusted.pictures import check_picture
from vomstudio.ui.common.worker_thread import Work, WorkerThread

THUMBNAIL = QSize(102, 68)
_FIRST_LOOK = 1600  # pixels along the long side, of large photos
_MOST_MB = 4096  # of one picture: 100 megapixels take 400
_KEPT_BYTES = 700_000_000
_BAND = 128  # rows
_Turn = QImageIOHandler.Transformation


@dataclass(frozen=True, eq=False)
class Picture:
    """A photo as it is stored, in sizes halved again and again.

    width, height : as stored; turn : from its pixels to those of the picture as it is looked at,
    by the orientation that the photo states
    whole : False while only a smaller one has been read
    """

    levels: tuple[QImage, ...]
    width: int
    height: int
    turn: QTransform
    whole: bool = True

    @property
    def bytes(self) -> int:
        return sum(level.sizeInBytes() for level in self.levels)


def upright(orientation: QImageIOHandler.Transformation, width: int, height: int) -> QTransform:
    """From stored pixels to upright ones; both count from the outer corner of the first."""
    w, h = float(width), float(height)
    # x' = m11 x + m21 y + dx, y' = m12 x + m22 y + dy
    rows = {
        _Turn.TransformationNone: (1, 0, 0, 1, 0, 0),
        _Turn.TransformationMirror: (-1, 0, 0, 1, w, 0),
        _Turn.TransformationFlip: (1, 0, 0, -1, 0, h),
        _Turn.TransformationRotate180: (-1, 0, 0, -1, w, h),
        _Turn.TransformationRotate90: (0, 1, -1, 0, h, 0),
        _Turn.TransformationMirrorAndRotate90: (0, -1, -1, 0, h, w),
        _Turn.TransformationFlipAndRotate90: (0, 1, 1, 0, 0, 0),
        _Turn.TransformationRotate270: (0, -1, 1, 0, 0, w),
    }
    return QTransform(*(float(v) for v in rows[orientation]))


class PhotoImages(QObject):
    """pictured: path and a Picture, or a sentence that says why there is none; first a smaller one
    of a large photo. thumbnailed: path and an upright QImage."""

    pictured = Signal(str, object)
    thumbnailed = Signal(str, object)

    def __init__(self) -> None:
        super().__init__()
        QImageReader.setAllocationLimit(_MOST_MB)
        self._kept: OrderedDict[str, Picture] = OrderedDict()
        self._thumbnails: dict[str, QImage] = {}
        self._picture: str | None = None
        self._waiting: list[str] = []
        self._worker = WorkerThread("photos", self._take)
        self.pictured.connect(self._keep, Qt.ConnectionType.QueuedConnection)
        self.thumbnailed.connect(self._keep_thumbnail, Qt.ConnectionType.QueuedConnection)

    def picture(self, path: Path) -> Picture | None:
        """The photo if it is at hand; else it is read, and no other one before it."""
        key = str(path)
        kept = self._kept.get(key)
        if kept is not None:
            self._kept.move_to_end(key)
            return kept
        with self._worker.lock:
            self._picture = key
        self._worker.wake()
        return None

    def thumbnail(self, path: Path) -> QImage | None:
        """The thumbnail if it is at hand; else it is made."""
        key = str(path)
        kept = self._thumbnails.get(key)
        if kept is None:
            with self._worker.lock:
                if key not in self._waiting:
                    self._waiting.append(key)
            self._worker.wake()
        return kept

    def close(self) -> None:
        self._worker.close()

    # --- in the thread -----------------------------------------------------------------------
    def _take(self) -> Work | None:
        picture, self._picture = self._picture, None
        if picture is not None:
            return partial(self._read, picture)
        return partial(self._read_thumbnail, self._waiting.pop(0)) if self._waiting else None

    def _read(self, key: str) -> None:
        if (problem := _problem(key)) is not None:
            self.pictured.emit(key, problem)
            return
        reader = _reader(key)
        reader.setAutoTransform(False)
        size, orientation = reader.size(), reader.transformation()
        orientation = _Turn(orientation.value) if hasattr(orientation, "value") else orientation
        width, height = size.width(), size.height()
        if max(width, height) > 2 * _FIRST_LOOK:
            quick = _reader(key)
            quick.setAutoTransform(False)
            quick.setScaledSize(size.scaled(QSize(_FIRST_LOOK, _FIRST_LOOK), _KEEP))
            image = quick.read()
            if not image.isNull():
                turn = upright(orientation, width, height)
                self.pictured.emit(key, Picture((_drawable(image),), width, height, turn, False))
            with self._worker.lock:
                if self._worker.closed or (self._picture not in (None, key)):
                    return
        image = reader.read()
        if image.isNull():
            self.pictured.emit(key, reader.errorString())
            return
        width, height = image.width(), image.height()
        levels = [_drawable(image)]
        while max(levels[-1].width(), levels[-1].height()) > 1200:
            levels.append(_halved(levels[-1]))
        turn = upright(orientation, width, height)
        self.pictured.emit(key, Picture(tuple(levels), width, height, turn))

    def _read_thumbnail(self, key: str) -> None:
        if _problem(key) is not None:
            self.thumbnailed.emit(key, QImage())
            return
        reader = _reader(key)
        reader.setAutoTransform(True)
        size = reader.size()
        if size.isValid():
            reader.setScaledSize(size.scaled(THUMBNAIL * 2, _KEEP))
        self.thumbnailed.emit(key, _drawable(reader.read()))

    # --- in the window's thread --------------------------------------------------------------
    def _keep(self, key: str, picture: Picture | str) -> None:
        if not isinstance(picture, Picture) or not picture.whole:
            return
        self._kept[key] = picture
        self._kept.move_to_end(key)
        while len(self._kept) > 1 and sum(p.bytes for p in self._kept.values()) > _KEPT_BYTES:
            self._kept.popitem(last=False)

    def _keep_thumbnail(self, key: str, image: QImage) -> None:
        self._thumbnails[key] = image


def _problem(path: str) -> str | None:
    """Return why a photo is not decoded; None if it may be."""
    try:
        check_picture(path)
    except InputError as error:
        return error.message
    except OSError as error:
        return error.strerror or str(error)
    return None


def _reader(path: str) -> QImageReader:
    """For what photos may be, and nothing else that Qt has a plugin for."""
    kind = b""
    with contextlib.suppress(OSError, InputError), open_regular(path) as file:
        head = file.read(4)
        kind = next((name for mark, name in _KINDS.items() if head.startswith(mark)), b"")
    reader = QImageReader(path if kind else "", kind)
    reader.setAutoDetectImageFormat(False)
    return reader


_KINDS = {b"\xff\xd8": b"jpeg", b"\x89PNG": b"png", b"II*\0": b"tiff", b"MM\0*": b"tiff"}
_KEEP = Qt.AspectRatioMode.KeepAspectRatio


def _halved(image: QImage) -> QImage:
    """Half as wide and high, band by band: each call of Qt keeps the window's thread waiting."""
    half = (image.size() / 2).expandedTo(QSize(1, 1))
    made = QImage(half, QImage.Format.Format_RGB32)
    painter = QPainter(made)
    painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform)
    step = image.height() / half.height()
    for top in range(0, half.height(), _BAND):
        rows = min(_BAND, half.height() - top)
        source = QRectF(0, top * step, image.width(), rows * step)
        painter.drawImage(QRectF(0, top, half.width(), rows), image, source)
    painter.end()
    return made


def _drawable(image: QImage) -> QImage:
    """In the format that is drawn soonest."""
    return image if image.isNull() else image.convertToFormat(QImage.Format.Format_RGB32)
