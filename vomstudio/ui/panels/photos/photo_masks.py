"""Masks of the photos in a folder during editing; each shape is one edit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QObject, Signal

from vomstudio.core.arrays import BoolArray, ByteArray
from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.pixel_areas import PixelArea, draw_area
from vomstudio.io.photos.drawn_masks import load_mask, mask_png
from vomstudio.project.records import Asset
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.panels.photos.photo_document import PhotoDocument
from vomstudio.ui.panels.photos.photo_row import PhotoRow

_MAX_MASKS = 3
_MAX_STATES = 32


class _MaskCache:
    """Cache of recent masks by file, so that undo does not read from the disk."""

    def __init__(self) -> None:
        self._packed_masks: dict[str, tuple[ByteArray, tuple[int, int]]] = {}

    def store(self, file: Asset, is_used: BoolArray) -> None:
        """Store the values (height, width) of a mask file."""
        self._packed_masks.pop(file.path, None)
        self._packed_masks[file.path] = np.packbits(is_used), (is_used.shape[0], is_used.shape[1])
        for path in list(self._packed_masks)[:-_MAX_STATES]:
            del self._packed_masks[path]

    def find(self, file: Asset | None, size: tuple[int, int]) -> BoolArray | None:
        """Return a copy (height, width) of a mask, or None if it must be read from its file.

        If `file` is None, all pixels are used.
        """
        if file is None:
            return np.ones(size, np.bool_)
        if file.path not in self._packed_masks:
            return None
        packed_mask, shape = self._packed_masks[file.path]
        flags = np.unpackbits(packed_mask, count=shape[0] * shape[1]).view(np.bool_).reshape(shape)
        return flags if shape == size else None


@dataclass(frozen=True, eq=False)
class Shape:
    """Shape that was drawn last, and whether it masks or unmasks pixels."""

    areas: tuple[PixelArea, ...]
    is_masking: bool
    photo: str


class PhotoMasks(QObject):
    """Masks as arrays during editing; they are True at used pixels.

    Attributes
    ----------
    mask_changed : Signal
        Emitted with the name of a photo whose mask has been read or has changed.
    message : Signal
        Emitted with a message for the user and its level.
    busy_changed : Signal
        Emitted when drawing in many photos has begun, continued or ended.
    busy_reason : Finding or None
        Reason why no further mask can be drawn, or None if one can be drawn.
    """

    mask_changed = Signal(str)
    message = Signal(object, str)
    busy_changed = Signal()

    def __init__(self, rows: Sequence[PhotoRow], document: PhotoDocument) -> None:
        super().__init__()
        self.rows = {row.name: row for row in rows}
        self._document = document
        self._background = QtBackground(self)
        self._masks: dict[str, BoolArray] = {}
        self._current_photo = ""
        self._cache = _MaskCache()
        self._has_changed = False
        self._is_drawing = False
        self._pending_names: frozenset[str] = frozenset()
        """Names of photos whose masks in memory already include the edit in progress."""
        self.last_shape: Shape | None = None
        self.busy_reason: Finding | None = None
        document.masks_changed.connect(self._reload)

    # --- state -------------------------------------------------------------------------------
    def used(self, name: str) -> BoolArray | None:
        """Return the mask (height, width), True at used pixels, or None before it has been read."""
        return self._masks.get(name)

    def open(self, name: str) -> None:
        """Read the mask of a photo, then emit `mask_changed`."""
        self._current_photo = name
        if name in self._masks:
            self.mask_changed.emit(name)
            return
        row = self.rows[name]
        self._trim()

        def deliver(mask: BoolArray) -> None:
            self._masks.setdefault(name, mask)
            self.mask_changed.emit(name)

        def handle_failure(error: VomError) -> None:
            self.message.emit(error, "warning")
            deliver(np.ones((row.height, row.width), np.bool_))

        self._background.run(lambda: self._load(row), deliver, handle_failure)

    def _load(self, row: PhotoRow) -> BoolArray:
        mask = self._document.mask_path(row.name)
        if mask is None:
            return np.ones((row.height, row.width), np.bool_)
        # Copied, since the array that was read is read-only.
        return load_mask(mask, row.width, row.height).copy()

    def _reload(self, names: frozenset[str]) -> None:
        """Reload masks after undo or redo."""
        files = self._document.masks()
        for name in names - self._pending_names:
            if name not in self._masks:
                continue
            row = self.rows[name]
            mask = self._cache.find(files.get(name), (row.height, row.width))
            if mask is None:
                del self._masks[name]
                if name == self._current_photo:
                    self.open(name)
            else:
                self._masks[name] = mask
                self.mask_changed.emit(name)

    @property
    def is_drawing(self) -> bool:
        """Whether a stroke is in progress."""
        return self._is_drawing

    # --- drawing -----------------------------------------------------------------------------
    def begin(self, name: str, is_masking: bool) -> None:
        """Begin a shape that consists of one or more areas."""
        self._has_changed, self._is_drawing = False, True
        self.last_shape = Shape((), is_masking, name)

    def draw(self, area: PixelArea) -> None:
        """Add an area to the current shape."""
        shape = self.last_shape
        assert shape is not None
        used_mask = self._masks.get(shape.photo)
        if used_mask is None:
            return
        self.last_shape = Shape((*shape.areas, area), shape.is_masking, shape.photo)
        if draw_area(used_mask, area, shape.is_masking) is not None:
            self._has_changed = True
            self.mask_changed.emit(shape.photo)

    def end(self) -> None:
        """Finish the current shape as one edit."""
        has_changed, self._has_changed = self._has_changed, False
        self._is_drawing = False
        shape = self.last_shape
        if shape is not None and has_changed:
            title = tr("Mask") if shape.is_masking else tr("Unmask")
            self._store(title, shape.photo)

    def draw_single_shape(self, name: str, area: PixelArea, is_masking: bool) -> None:
        self.begin(name, is_masking)
        self.draw(area)
        self.end()

    def invert(self, name: str) -> None:
        """Invert the mask of a photo."""
        used_mask = self._masks.get(name)
        if used_mask is not None:
            np.logical_not(used_mask, out=used_mask)
            self._store(tr("Invert mask"), name)

    def _store(self, title: str, name: str) -> None:
        """Store the current mask as a record; if this fails, restore the previous mask."""
        try:
            file = self._store_file(self._masks[name])
        except VomError as error:
            self.message.emit(error, "error")
        else:
            if self._apply(title, {name: file}):
                self.mask_changed.emit(name)
                return
        self._masks.pop(name, None)
        self.open(name)

    def _store_file(self, is_used: BoolArray) -> Asset | None:
        if is_used.all():
            return None
        file = self._document.store_mask(mask_png(is_used))
        self._cache.store(file, is_used)
        return file

    def _apply(self, title: str, masks: dict[str, Asset | None]) -> bool:
        self._pending_names = frozenset(masks)
        try:
            return self._document.set_masks(title, masks)
        finally:
            self._pending_names = frozenset()

    # --- repetition --------------------------------------------------------------------------
    def repeat_problem(self) -> Finding | None:
        """Return why the last shape cannot be drawn in other photos, or None if it can."""
        shape = self.last_shape
        if shape is None or not shape.areas:
            return Finding("action.no-shape")
        if self.busy_reason is not None:
            return self.busy_reason
        if not self._same_size_photos(shape.photo):
            return Finding("action.no-similar-photo")
        return None

    def _same_size_photos(self, name: str) -> list[str]:
        size = self.rows[name].width, self.rows[name].height
        return [
            r.name for r in self.rows.values() if (r.width, r.height) == size and r.name != name
        ]

    def repeat(self) -> None:
        """Draw the last shape in all other photos of the same size."""
        shape = self.last_shape
        if self.repeat_problem() is not None or shape is None:
            return

        other_photos = self._same_size_photos(shape.photo)
        other_size_count = len(self.rows) - 1 - len(other_photos)
        new_masks: dict[str, Asset | None] = {}
        previous_masks: dict[str, Asset | None] = {}
        queue = list(other_photos)

        def draw(name: str) -> dict[str, Asset | None]:
            used_pixels = self._load(self.rows[name])
            changes = [draw_area(used_pixels, area, shape.is_masking) for area in shape.areas]
            return (
                {name: self._store_file(used_pixels)} if any(c is not None for c in changes) else {}
            )

        def collect(masks: dict[str, Asset | None]) -> None:
            new_masks.update(masks)
            proceed()

        def handle_failure(error: VomError) -> None:
            self.message.emit(error, "error")
            proceed()

        def proceed() -> None:
            if not queue:
                finish()
                return
            count = len(other_photos) - len(queue)
            self._set_busy(Finding("mask.repeating", done=count, count=len(other_photos)))
            name = queue.pop(0)
            previous_masks[name] = self._document.masks().get(name)
            self._background.run(lambda: draw(name), collect, handle_failure)

        def finish() -> None:
            current_masks = self._document.masks()
            if stale_photos := [
                name for name in previous_masks if current_masks.get(name) != previous_masks[name]
            ]:
                # The user has drawn on these photos in the meantime.
                for name in stale_photos:
                    new_masks.pop(name, None)
                    previous_masks.pop(name)
                queue.extend(stale_photos)
                proceed()
                return
            self._set_busy(None)
            if new_masks and self._document.set_masks(tr("Mask all photos"), new_masks):
                self._trim()
            self.message.emit(Finding("mask.repeated", count=len(new_masks)), "info")
            if other_size_count:
                self.message.emit(Finding("mask.size-differs", count=other_size_count), "hint")

        proceed()

    def _set_busy(self, reason: Finding | None) -> None:
        self.busy_reason = reason
        self.busy_changed.emit()

    def _trim(self) -> None:
        """Remove the oldest masks, because those of a thousand photos do not fit in memory."""
        for name in [n for n in self._masks if n != self._current_photo][:-_MAX_MASKS]:
            del self._masks[name]

    def close(self) -> None:
        self.end()
        self._document.masks_changed.disconnect(self._reload)
        self._background.stop()
