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
