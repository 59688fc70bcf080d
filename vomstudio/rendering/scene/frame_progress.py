"""Progress of the picture for a camera at rest."""

from __future__ import annotations

from collections.abc import Iterable

from vomstudio.rendering.scene.model_scene import ModelScene, Part

Entry = tuple[ModelScene, Part]


class FrameProgress:
    """Progress of a frame that is drawn incrementally.

    Attributes
    ----------
    pending_parts : list or None
        Parts that remain to be drawn, or None if no frame is being drawn.
    is_first : bool
        Whether no part of the frame has been drawn yet.
    bands : list or None
        First and end rows of the bands that remain to be shaded, or None before shading.
    is_complete : bool
        Whether the last picture is complete.
    """

    def __init__(self) -> None:
        self.pending_parts: list[Entry] | None = None
        self.is_first = False
        self.bands: list[tuple[int, int]] | None = None
        self.is_complete = False
        self._is_outdated = False

    def begin(self, parts: list[Entry]) -> None:
        self.pending_parts, self.bands = parts, None
        self.is_first = True
        self._is_outdated = False

    def end(self) -> None:
        """Mark the frame as complete."""
        self.pending_parts = None
        self.is_complete = not self._is_outdated

    def abandon(self) -> None:
        """Discard the frame, and mark the last picture as incomplete."""
        self.pending_parts = None
        self.is_complete = False

    def mark_outdated(self) -> None:
        """Mark the frame and the last picture as incomplete because content has been added."""
        self.is_complete = False
        self._is_outdated = True

    def add_part(self, model: ModelScene, part: Part) -> bool:
        """Add a part to the frame. Return False if it is too late to add it."""
        if self.pending_parts is None or self.bands is not None:
            return False
        self.pending_parts.append((model, part))
        return True

    def remove_parts(self, parts: Iterable[Part]) -> None:
        """Remove parts that no longer exist."""
        dropped_ids = {id(part) for part in parts}
        if self.pending_parts is not None and dropped_ids:
            self.pending_parts = [
                entry for entry in self.pending_parts if id(entry[1]) not in dropped_ids
            ]
