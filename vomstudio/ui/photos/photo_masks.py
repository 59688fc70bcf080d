"""The masks of a folder of photos while they are drawn; each change is soon on the disk."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from threading import Lock

import numpy as np
import numpy.typing as npt
from PySide6.QtCore import QObject, QTimer, Signal

from vomstudio.errors import VomError
from vomstudio.geometry.pixel_areas import Area, Change, changed_by, whole_area
from vomstudio.io.photos.drawn_masks import keep_mask, load_mask, mask_place, write_mask
from vomstudio.ui.common.background import Background
from vomstudio.ui.photos.edit_history import EditHistory, Step
from vomstudio.ui.photos.photo_survey import PhotoRow

Flags = npt.NDArray[np.bool_]
_SOON_MS = 500
_KEPT = 3


@dataclass(frozen=True, eq=False)
class Shape:
    """What was drawn last, and whether it hides."""

    areas: tuple[Area, ...]
    hides: bool
    photo: str


class _Saving:
    """One writing of a mask: who comes first does it, who comes later waits for what came of it."""

    def __init__(self, name: str, work: Callable[[], object]) -> None:
        self.name, self._work = name, work
        self._lock = Lock()
        self._made: object = None

    def made(self) -> object:
        with self._lock:
            if self._made is None:
                self._made = self._work()
            return self._made


class PhotoMasks(QObject):
    """drawn : a photo whose mask is there, or has changed. stored : a photo, and the file of its
    mask, or None where it has none any more. said : a sentence, and its level. busy_changed : many
    are drawn, or no longer."""

    drawn = Signal(str)
    stored = Signal(str, object)
    said = Signal(str, str)
    busy_changed = Signal()

    def __init__(self, rows: Sequence[PhotoRow], history: EditHistory) -> None:
        super().__init__()
        self.rows = {row.name: row for row in rows}
        self._history = history
        self._background = Background(self)
        self._masks: dict[str, Flags] = {}
        self._foreign = {row.name: row.mask for row in rows if row.mask}
        """Masks as they were found, whatever their names."""
        paths = [Path(row.path) for row in rows]
        self._places = {row.name: mask_place(Path(row.path), paths) for row in rows}
        self._dirty: dict[str, None] = {}
        self._saving: _Saving | None = None
        self._shown = ""
        self._stroke: list[Change] = []
        self._going_on = False
        self.problem = ""
        """Why masks are in this window only."""
        self.last: Shape | None = None
        self.busy = ""
        self._soon = QTimer(self)
        self._soon.setSingleShot(True)
        self._soon.setInterval(_SOON_MS)
        self._soon.timeout.connect(self._save_next)

    # --- looking -----------------------------------------------------------------------------
    def used(self, name: str) -> Flags | None:
        """(height, width), True where the photo is used; None before it has been read."""
        return self._masks.get(name)

    @property
    def unsaved(self) -> list[str]:
        saving = () if self._saving is None else (self._saving.name,)
        return list(dict.fromkeys([*self._dirty, *saving]))

    def open(self, name: str) -> None:
        """Have a photo's mask at hand; `drawn` tells when."""
        self._shown = name
        if name in self._masks:
            self.drawn.emit(name)
            return
        row = self.rows[name]
        self._forget()

        def arrived(made: object) -> None:
            if isinstance(made, VomError):
                self.said.emit(str(made), "warning")
                made = np.ones((row.height, row.width), np.bool_)
            self._masks.setdefault(name, made)  # type: ignore[arg-type]
            self.drawn.emit(name)

        self._background.run(lambda: _loaded(row, row.mask), arrived)

    @property
    def drawing(self) -> bool:
        """A stroke goes on."""
        return self._going_on

    # --- drawing -----------------------------------------------------------------------------
    def begin(self, name: str, hides: bool) -> None:
        """A shape of several areas begins."""
        self._stroke, self._going_on = [], True
        self.last = Shape((), hides, name)

    def draw(self, area: Area) -> None:
        shape = self.last
        assert shape is not None
        used = self._masks.get(shape.photo)
        if used is None:
            return
        self.last = Shape((*shape.areas, area), shape.hides, shape.photo)
        if (change := changed_by(used, area, shape.hides)) is not None:
            self._stroke.append(change)
            self.drawn.emit(shape.photo)

    def end(self) -> None:
        """The shape is done; it can be taken back as a whole."""
        changes, self._stroke = self._stroke, []
        self._going_on = False
        shape = self.last
        if shape is not None and changes:
            words = self.tr("Leave out") if shape.hides else self.tr("Keep")
            self._remember(words, shape.photo, {shape.photo: changes})
            self._changed(shape.photo)

    def draw_once(self, name: str, area: Area, hides: bool) -> None:
        self.begin(name, hides)
        self.draw(area)
        self.end()

    def invert(self, name: str) -> None:
        used = self._masks.get(name)
        if used is None:
            return
        area = whole_area(used.shape[1], used.shape[0])
        change = Change.of(area, area.inside)
        self._remember(self.tr("Invert the mask"), name, {name: [change]})
        change.do(used)
        self._changed(name)

    def _changed(self, name: str) -> None:
        self._dirty[name] = None
        self.drawn.emit(name)
        self._soon.start()

    def _remember(self, words: str, photo: str, changes: dict[str, list[Change]]) -> None:
        self._history.add(Step(words, photo, lambda: self._toggle(changes)))

    # --- the same in many photos -------------------------------------------------------------
    def why_not_repeat(self) -> str | None:
        shape = self.last
        if shape is None or not shape.areas:
            return self.tr("draw what is to be the same in all photos first")
        if self.busy:
            return self.busy
        if not self._like(shape.photo):
            return self.tr("no other photo has the size of this one")
        return None

    def _like(self, name: str) -> list[str]:
        size = self.rows[name].width, self.rows[name].height
        return [r.name for r in self.rows.values() if (r.width, r.height) == size
                and r.name != name]  # fmt: skip

    def repeat(self) -> None:
        """Draw the last shape into all other photos of its size."""
        shape = self.last
        if self.why_not_repeat() is not None or shape is None:
            return

        def draw(name: str, used: Flags) -> list[Change]:
            made = (changed_by(used, area, shape.hides) for area in shape.areas)
            return [change for change in made if change is not None]

        others = self._like(shape.photo)
        left = len(self.rows) - 1 - len(others)

        def done(changes: dict[str, list[Change]]) -> None:
            if changes:
                self._remember(self.tr("The same on all photos"), shape.photo, changes)
            said = self.tr("Drawn into {0} more photos").format(len(changes))
            if left:
                said += self.tr("; {0} of another size are as they were").format(left)
            self.said.emit(said, "info")

        self._in_many(others, draw, done)

    def _toggle(self, changes: dict[str, list[Change]]) -> None:
        """Take a step back, or do it again, wherever it was done."""
        far = []
        for name, own in changes.items():
            used = self._masks.get(name)
            if used is None:
                far.append(name)
                continue
            for change in own:
                change.do(used)
            self._changed(name)
        self._stroke, self.last = [], None
        if far:

            def again(name: str, used: Flags) -> list[Change]:
                for change in changes[name]:
                    change.do(used)
                return changes[name]

            self._in_many(far, again, lambda _: None)

    def _in_many(
        self,
        names: Sequence[str],
        draw: Callable[[str, Flags], list[Change]],
        done: Callable[[dict[str, list[Change]]], None],
    ) -> None:
        """Change the masks of photos one after the other, in a thread where they must be read."""
        changes: dict[str, list[Change]] = {}
        waiting = list(names)

        def apply(name: str, used: Flags) -> None:
            if own := draw(name, used):
                changes[name] = own
                self._masks[name] = used
                self._changed(name)

        def proceed() -> None:
            while waiting and waiting[0] in self._masks:
                name = waiting.pop(0)
                apply(name, self._masks[name])
            if not waiting:
                self._set_busy("")
                done(changes)
                return
            self._set_busy(
                self.tr("drawing: {0} of {1} photos").format(len(names) - len(waiting), len(names))
            )
            # Masks of a thousand photos do not fit into memory.
            if len(self._dirty) > 4 and not self.problem:
                self._save_next()
                QTimer.singleShot(20, proceed)
                return
            name = waiting.pop(0)
            row = self.rows[name]

            def arrived(made: object) -> None:
                if isinstance(made, VomError):
                    self.said.emit(str(made), "warning")
                else:
                    # The photo may have been opened, and drawn on, meanwhile.
                    held = self._masks.get(name)
                    apply(name, made if held is None else held)  # type: ignore[arg-type]
                proceed()

            self._background.run(lambda: _loaded(row, row.mask), arrived)

        proceed()

    def _set_busy(self, words: str) -> None:
        self.busy = words
        self.busy_changed.emit()

    # --- saving ------------------------------------------------------------------------------
    def _save_next(self) -> None:
        if self._saving is not None or not self._dirty:
            return
        name = next(iter(self._dirty))
        del self._dirty[name]
        used, place = self._masks[name].copy(), self._places[name]
        foreign = self._foreign.get(name)

        saving = self._saving = _Saving(name, lambda: _kept(place, used, foreign))

        def arrived(made: object) -> None:
            if self._saving is not saving:
                # It was waited for.
                return
            self._saving = None
            self._written(name, made)
            if self._dirty and not self.problem:
                self._save_next()

        self._background.run(saving.made, arrived)

    def _written(self, name: str, made: object) -> None:
        if isinstance(made, VomError):
            self._dirty.setdefault(name, None)
            self.problem = str(made)
            self.said.emit(self.problem, "error")
            return
        assert isinstance(made, tuple)
        path, kept = made
        self.problem = ""
        mask = self.rows[name].mask = None if path is None else str(path)
        if kept is not None:
            self.said.emit(
                self.tr("The mask that was there was put aside as {0}").format(kept.name), "info"
            )
        self.stored.emit(name, mask)
        self._forget()

    def _forget(self) -> None:
        """Masks that are on the disk need not be in memory."""
        busy = {*self.unsaved, self._shown}
        for name in [n for n in self._masks if n not in busy][:-_KEPT]:
            del self._masks[name]

    def save_now(self) -> bool:
        """Write what is not on the disk yet; whether it is there now."""
        self.end()
        self._soon.stop()
        if (saving := self._saving) is not None:
            # What it writes is older, and must not come last.
            made, self._saving = saving.made(), None
            self._written(saving.name, made)
        problem = ""
        for name in list(self._dirty):
            used, foreign = self._masks[name], self._foreign.get(name)
            del self._dirty[name]
            self._written(name, _kept(self._places[name], used, foreign))
            problem = problem or self.problem
        self.problem = problem
        return not self._dirty

    def save_elsewhere(self, folder: Path) -> list[Path]:
        """Write the masks that could not be written, into another folder. Raises TargetError."""
        written = []
        for name in list(self._dirty):
            path = folder / self._places[name].name
            write_mask(path, self._masks[name])
            written.append(path)
        return written

    def close(self) -> None:
        self._soon.stop()
        self._background.close()


def _loaded(row: PhotoRow, mask: str | None) -> Flags | VomError:
    if mask is None:
        return np.ones((row.height, row.width), np.bool_)
    try:
        # Of its own: what is read may not be written.
        return load_mask(Path(mask), row.width, row.height).copy()
    except VomError as error:
        return error


def _kept(
    place: Path, used: Flags, foreign: str | None
) -> tuple[Path | None, Path | None] | VomError:
    try:
        return keep_mask(place, used, None if foreign is None else Path(foreign))
    except VomError as error:
        return error
