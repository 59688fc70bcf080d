"""How far the picture of a camera at rest has come."""

from __future__ import annotations

from collections.abc import Iterable

from vomstudio.rendering.scene.model_scene import ModelScene, Part

Entry = tuple[ModelScene, Part]


class Frame:
    """pending : the parts that the frame in the making still lacks, None where none is being made
    first : none of its parts has been drawn yet; bands : rows of it, first and one past the last,
        that are still to be shaded, None before that is begun
    complete : the picture that was drawn last is whole, and shows everything that is there
    """

    def __init__(self) -> None:
        self.pending: list[Entry] | None = None
        self.first = False
        self.bands: list[tuple[int, int]] | None = None
        self.complete = False
        self._outdated = False

    def begin(self, parts: list[Entry]) -> None:
        self.pending, self.bands = parts, None
        self.first = True
        self._outdated = False

    def end(self) -> None:
        """The frame in the making is whole."""
        self.pending = None
        self.complete = not self._outdated

    def abandon(self) -> None:
        """Forget the frame in the making, and that the last one was whole."""
        self.pending = None
        self.complete = False

    def outdate(self) -> None:
        """Something has come that neither the last frame nor that in the making shows."""
        self.complete = False
        self._outdated = True

    def admit(self, model: ModelScene, part: Part) -> bool:
        """Make what has come a part of the frame in the making; False where it is too late."""
        if self.pending is None or self.bands is not None:
            return False
        self.pending.append((model, part))
        return True

    def dismiss(self, parts: Iterable[Part]) -> None:
        """Leave parts out that are there no more."""
        gone = {id(part) for part in parts}
        if self.pending is not None and gone:
            self.pending = [entry for entry in self.pending if id(entry[1]) not in gone]
