"""Protocols of the window for its commands."""

from __future__ import annotations

from typing import Protocol


class Docks(Protocol):
    """The panels around the outcrop, by the name of their dock."""

    def bring_forward(self, name: str) -> None:
        """Show a panel in front of the panels of the same tab bar."""

    def ensure_height(self, name: str, height: int) -> None:
        """Make a docked panel at least as high as `height` pixels."""


class WorkspaceSwitcher(Protocol):
    def switch(self, name: str) -> None:
        """Switch to a workspace."""
