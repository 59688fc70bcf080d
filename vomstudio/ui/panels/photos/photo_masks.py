"""The masks of a folder of photos while they are drawn; each shape is a step of the history."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from PySide6.QtCore import QObject, Signal

from vomstudio.core.arrays import BoolArray, ByteArray
from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.pixel_areas import PixelArea, changed_by
from vomstudio.io.photos.drawn_masks import load_mask, mask_png
from vomstudio.project.records import Asset
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.panels.photos.photo_document import PhotoDocument
from vomstudio.ui.panels.photos.photo_row import PhotoRow

_KEPT = 3
_STATES = 32


class _States:
    """What masks were lately, by their files: taking a step back waits for no disk."""

    def __init__(self) -> None:
        self._packed: dict[str, tuple[ByteArray, tuple[int, int]]] = {}

    def keep(self, file: Asset, used: BoolArray) -> None:
        """Remember the values (height, width) of a mask file."""
        self._packed.pop(file.path, None)
        self._packed[file.path] = np.packbits(used), (used.shape[0], used.shape[1])
        for path in list(self._packed)[:-_STATES]:
            del self._packed[path]

    def find(self, file: Asset | None, size: tuple[int, int]) -> BoolArray | None:
        """(height, width) of its own; None where it must be read."""
        if file is None:
            return np.ones(size, np.bool_)
        if file.path not in self._packed:
            return None
        packed, own = self._packed[file.path]
        flags = np.unpackbits(packed, count=own[0] * own[1]).view(np.bool_).reshape(own)
        return flags if own == size else None


@dataclass(frozen=True, eq=False)
class Shape:
    """What was drawn last, and whether it hides."""

    areas: tuple[PixelArea, ...]
    hides: bool
    photo: str


class PhotoMasks(QObject):
    """Masks as arrays while they are edited. True in an array means that the pixel is used.

    drawn : the name of a photo whose mask has been read or has changed. message : a message
    for the user, and its level. busy_changed : drawing on many photos has begun, gone on or ended
    """

    drawn = Signal(str)
    message = Signal(object, str)
    busy_changed = Signal()

    def __init__(self, rows: Sequence[PhotoRow], document: PhotoDocument) -> None:
        super().__init__()
        self.rows = {row.name: row for row in rows}
        self._document = document
        self._background = QtBackground(self)
        self._masks: dict[str, BoolArray] = {}
        self._shown = ""
        self._states = _States()
        self._stroke = False
        self._going_on = False
        self._making: frozenset[str] = frozenset()
        """Photos whose masks are already as the edit that is being made will have them."""
        self.last: Shape | None = None
        self.busy: Finding | None = None
        document.masks_changed.connect(self._changed_elsewhere)

    # --- looking -----------------------------------------------------------------------------
    def used(self, name: str) -> BoolArray | None:
        """(height, width), True where the photo is used; None before it has been read."""
        return self._masks.get(name)

    def open(self, name: str) -> None:
        """Have a photo's mask at hand; `drawn` tells when."""
        self._shown = name
        if name in self._masks:
            self.drawn.emit(name)
            return
        row = self.rows[name]
        self._forget()

        def arrived(mask: BoolArray) -> None:
            self._masks.setdefault(name, mask)
            self.drawn.emit(name)

        def failed(error: VomError) -> None:
            self.message.emit(error, "warning")
            arrived(np.ones((row.height, row.width), np.bool_))

        self._background.run(lambda: self._loaded(row), arrived, failed)

    def _loaded(self, row: PhotoRow) -> BoolArray:
        mask = self._document.mask_path(row.name)
        if mask is None:
            return np.ones((row.height, row.width), np.bool_)
        # Of its own: what is read may not be written.
        return load_mask(mask, row.width, row.height).copy()

    def _changed_elsewhere(self, names: frozenset[str]) -> None:
        """A step was taken back or done again: the masks are read anew."""
        files = self._document.masks()
        for name in names - self._making:
            if name not in self._masks:
                continue
            row = self.rows[name]
            found = self._states.find(files.get(name), (row.height, row.width))
            if found is None:
                del self._masks[name]
                if name == self._shown:
                    self.open(name)
            else:
                self._masks[name] = found
                self.drawn.emit(name)

    @property
    def drawing(self) -> bool:
        """A stroke goes on."""
        return self._going_on

    # --- drawing -----------------------------------------------------------------------------
    def begin(self, name: str, hides: bool) -> None:
        """A shape of several areas begins."""
        self._stroke, self._going_on = False, True
        self.last = Shape((), hides, name)

    def draw(self, area: PixelArea) -> None:
        """Add an area to the shape that was begun."""
        shape = self.last
        assert shape is not None
        used = self._masks.get(shape.photo)
        if used is None:
            return
        self.last = Shape((*shape.areas, area), shape.hides, shape.photo)
        if changed_by(used, area, shape.hides) is not None:
            self._stroke = True
            self.drawn.emit(shape.photo)

    def end(self) -> None:
        """The shape is done; it can be taken back as a whole."""
        changed, self._stroke = self._stroke, False
        self._going_on = False
        shape = self.last
        if shape is not None and changed:
            words = tr("Mask") if shape.hides else tr("Unmask")
            self._keep(words, shape.photo)

    def draw_once(self, name: str, area: PixelArea, hides: bool) -> None:
        self.begin(name, hides)
        self.draw(area)
        self.end()

    def invert(self, name: str) -> None:
        """Swap what is masked and what is not in this photo."""
        used = self._masks.get(name)
        if used is not None:
            np.logical_not(used, out=used)
            self._keep(tr("Invert mask"), name)

    def _keep(self, words: str, name: str) -> None:
        """The mask as it is now becomes a record; where it cannot be written it is as before."""
        try:
            made = self._kept(self._masks[name])
        except VomError as error:
            self.message.emit(error, "error")
        else:
            if self._apply(words, {name: made}):
                self.drawn.emit(name)
                return
        self._masks.pop(name, None)
        self.open(name)

    def _kept(self, used: BoolArray) -> Asset | None:
        if used.all():
            return None
        file = self._document.store_mask(mask_png(used))
        self._states.keep(file, used)
        return file

    def _apply(self, words: str, masks: dict[str, Asset | None]) -> bool:
        self._making = frozenset(masks)
        try:
            return self._document.set_masks(words, masks)
        finally:
            self._making = frozenset()

    # --- the same in many photos -------------------------------------------------------------
    def why_not_repeat(self) -> Finding | None:
        """Return why the last shape cannot be drawn in other photos; None if it can."""
        shape = self.last
        if shape is None or not shape.areas:
            return Finding("action.no-shape")
        if self.busy is not None:
            return self.busy
        if not self._like(shape.photo):
            return Finding("action.no-similar-photo")
        return None

    def _like(self, name: str) -> list[str]:
        size = self.rows[name].width, self.rows[name].height
        return [
            r.name for r in self.rows.values() if (r.width, r.height) == size and r.name != name
        ]

    def repeat(self) -> None:
        """Draw the last shape into all other photos of its size."""
        shape = self.last
        if self.why_not_repeat() is not None or shape is None:
            return

        others = self._like(shape.photo)
        left = len(self.rows) - 1 - len(others)
        made: dict[str, Asset | None] = {}
        drawn_on: dict[str, Asset | None] = {}
        waiting = list(others)

        def draw(name: str) -> dict[str, Asset | None]:
            used = self._loaded(self.rows[name])
            changes = [changed_by(used, area, shape.hides) for area in shape.areas]
            return {name: self._kept(used)} if any(c is not None for c in changes) else {}

        def arrived(drawn: dict[str, Asset | None]) -> None:
            made.update(drawn)
            proceed()

        def failed(error: VomError) -> None:
            self.message.emit(error, "error")
            proceed()

        def proceed() -> None:
            if not waiting:
                done()
                return
            count = len(others) - len(waiting)
            self._set_busy(Finding("mask.repeating", done=count, count=len(others)))
            name = waiting.pop(0)
            drawn_on[name] = self._document.masks().get(name)
            self._background.run(lambda: draw(name), arrived, failed)

        def done() -> None:
            now = self._document.masks()
            if stale := [name for name in drawn_on if now.get(name) != drawn_on[name]]:
                # Somebody has drawn on these photos meanwhile.
                for name in stale:
                    made.pop(name, None)
                    drawn_on.pop(name)
                waiting.extend(stale)
                proceed()
                return
            self._set_busy(None)
            if made and self._document.set_masks(tr("Mask all photos"), made):
                self._forget()
            self.message.emit(Finding("mask.repeated", count=len(made)), "info")
            if left:
                self.message.emit(Finding("mask.size-differs", count=left), "hint")

        proceed()

    def _set_busy(self, reason: Finding | None) -> None:
        self.busy = reason
        self.busy_changed.emit()

    def _forget(self) -> None:
        """Masks of a thousand photos do not fit into memory."""
        for name in [n for n in self._masks if n != self._shown][:-_KEPT]:
            del self._masks[name]

    def close(self) -> None:
        self.end()
        self._document.masks_changed.disconnect(self._changed_elsewhere)
        self._background.stop()
