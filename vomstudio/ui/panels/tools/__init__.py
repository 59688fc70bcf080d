"""Discovery of the tool panels and tool commands in the modules of this package.

A module with the name of a tool defines `PANEL`, a widget class that is called with the studio and
the actions, or `SHARES`, the name of the tool whose panel is shared. `COMMANDS` is optional: it is
a function that is called with the studio and returns further commands of the tool, which the menu
lists after the common commands. No registration is needed.
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
    """Create the panels of the tools, by tool name."""
    panels = {
        name: module.PANEL(studio, actions)
        for name, module in _MODULES.items()
        if hasattr(module, "PANEL")
    }
    shared_names = {name: getattr(module, "SHARES", "") for name, module in _MODULES.items()}
    return panels | {name: panels[owner] for name, owner in shared_names.items() if owner}


def commands(studio: Studio) -> dict[str, list[Command]]:
    """Create the additional commands of the tools, by tool name."""
    factories = {name: getattr(module, "COMMANDS", None) for name, module in _MODULES.items()}
    return {name: factory(studio) for name, factory in factories.items() if factory is not None}
