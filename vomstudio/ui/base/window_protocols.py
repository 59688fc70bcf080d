"""What commands may ask of the window that they are part of, and no more."""

from __future__ import annotations

from typing import Protocol


class Docks(Protocol):
    """The panels around the outcrop, each under the name of its dock."""

    def bring_forward(self, name: str) -> None:
        """Show a panel, in front of those that share its place."""

    def make_room(self, name: str, height: int) -> None:
        """Let a panel that is docked in the window be at least so high, in pixels."""


class WorkspaceSwitcher(Protocol):
    def switch(self, name: str) -> None:
        """Go to a workspace."""
