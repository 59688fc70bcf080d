"""Protocols of the window that its commands use."""

from __future__ import annotations

from typing import Protocol


class Docks(Protocol):
    """Panels around the outcrop, identified by the name of their dock."""

    def bring_forward(self, name: str) -> None:
        """Show a panel in front of the others in the same tab bar."""

    def ensure_height(self, name: str, height: int) -> None:
        """Ensure that a docked panel is at least `height` pixels high."""


class WorkspaceSwitcher(Protocol):
    def switch(self, name: str) -> None:
        """Switch to a workspace."""
