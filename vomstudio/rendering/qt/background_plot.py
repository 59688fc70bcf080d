"""A window of PyVista's beside a program that runs Qt already."""

from __future__ import annotations

from typing import Any


def window_plotter(app: Any) -> Any:
    """app : the running QApplication. It draws when something changes, and not by a clock."""
    import pyvistaqt

    plotter: Any = pyvistaqt.BackgroundPlotter(app=app, auto_update=False)
    plotter.set_background("white")
    return plotter
