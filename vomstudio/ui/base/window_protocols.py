"""Protocols of the window that its commands use."""

from __future__ import annotations

from typing import Protocol

from PySide6.QtWidgets import QWidget


class Docks(Protocol):
    """Pages of the window, identified by name."""

    def bring_forward(self, name: str) -> None:
        """Show a page."""

    def close_page(self, name: str) -> None:
        """Hide a page."""

    def toggle_center(self, name: str) -> None:
        """Move a page to the centre of the window, or back."""

    def ensure_height(self, name: str, height: int) -> None:
        """Ensure that a docked page is at least `height` pixels high."""

    def find_page_widget(self, name: str) -> QWidget | None:
        """Return the visible widget around a page, or None if the page is hidden."""

    def titles(self) -> dict[str, str]:
        """Return the titles of all pages by name."""


class WorkspaceSwitcher(Protocol):
    def switch(self, name: str) -> None:
        """Switch to a workspace."""
