"""Protocol of the viewport widget for its helpers."""

from __future__ import annotations

from typing import Protocol

Extent = tuple[float, float]
"""Width and height in logical pixels, at least 1 each."""


class Pane(Protocol):
    """Widget that shows the scene. Pixels are logical, from its upper-left corner."""

    def extent(self) -> Extent: ...

    def update(self) -> None:
        """Schedule a paint."""


class Redrawable(Protocol):
    """Picture of the scene that can be drawn again."""

    def begin_motion(self) -> None:
        """Draw once in the next paint because the camera has moved, and refine after a delay."""

    def redraw_once(self) -> None:
        """Draw the models once, while refinement at rest continues."""
