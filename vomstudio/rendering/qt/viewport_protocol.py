"""What those who work for the viewport may ask of the widget itself."""

from __future__ import annotations

from typing import Protocol

Extent = tuple[float, float]
"""Width and height in logical pixels, at least 1 each."""


class Pane(Protocol):
    """A widget on which the scene is shown. Pixels are logical, from its top left corner."""

    def extent(self) -> Extent: ...

    def update(self) -> None:
        """Paint anew, soon."""
