"""Place, size and docks of the window, as text in the settings."""

from __future__ import annotations

import base64
from collections.abc import Mapping

from PySide6.QtCore import QByteArray
from PySide6.QtGui import QGuiApplication
from PySide6.QtWidgets import QMainWindow

_GEOMETRY, _DOCKS = "geometry", "docks"


def restore_geometry(window: QMainWindow, kept: Mapping[str, str]) -> None:
    """Give a window the place and size that were kept, where a screen shows that place."""
    if _GEOMETRY in kept:
        window.restoreGeometry(_bytes(kept[_GEOMETRY]))
        # A screen that is gone must not take the window with it.
        if not any(
            screen.geometry().intersects(window.frameGeometry())
            for screen in QGuiApplication.screens()
        ):
            window.move(40, 40)


def docks_of(kept: Mapping[str, str]) -> QByteArray | None:
    """The state of the docks that was kept; None where there is none."""
    text = kept.get(_DOCKS)
    return None if text is None else _bytes(text)


def to_keep(window: QMainWindow, docks: QByteArray) -> dict[str, str]:
    """Place, size and docks of a window for the settings."""
    return {_GEOMETRY: _text(window.saveGeometry()), _DOCKS: _text(docks)}


def _text(data: QByteArray) -> str:
    return base64.b64encode(data.data()).decode("ascii")


def _bytes(text: str) -> QByteArray:
    return QByteArray(base64.b64decode(text))
