"""The panels of the tools. A module of this package that has the name of a tool holds its `PANEL`,
a widget made with the studio and the actions, or `SHARES`, the name of the tool whose panel it
shares. `COMMANDS`, where there are any, takes the studio and
gives what else the tool can do; they stand in the menu behind what all tools can do. Nothing has to
be entered anywhere.
"""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec

from PySide6.QtGui import QAction
from PySide6.QtWidgets import QWidget

from vomstudio.studio.tools.registry import TOOLS
from vomstudio.ui.base.actions import Command
from vomstudio.ui.base.studio import Studio

_MODULES = {
    entry.name: import_module(f"{__name__}.{entry.name}")
    for entry in TOOLS
    if find_spec(f"{__name__}.{entry.name}") is not None
}


def make_panels(studio: Studio, actions: dict[str, QAction]) -> dict[str, QWidget]:
    """The panels by the names of their tools."""
    made = {
        name: module.PANEL(studio, actions)
        for name, module in _MODULES.items()
        if hasattr(module, "PANEL")
    }
    shared = {name: getattr(module, "SHARES", "") for name, module in _MODULES.items()}
    return made | {name: made[other] for name, other in shared.items() if other}


def commands(studio: Studio) -> dict[str, list[Command]]:
    """The commands of each tool that has any, by its name."""
    found = {name: getattr(module, "COMMANDS", None) for name, module in _MODULES.items()}
    return {name: make(studio) for name, make in found.items() if make is not None}
