"""PyVista plotter window for a program that already runs Qt."""

from __future__ import annotations

from typing import Any


def create_plotter(app: Any) -> Any:
    """Return a plotter for the running QApplication that draws only when something changes."""
    import pyvistaqt

    plotter: Any = pyvistaqt.BackgroundPlotter(app=app, auto_update=False)
    plotter.set_background("white")
    return plotter
