"""Registry of all tools: the modules of this package that define `TOOL`."""

from __future__ import annotations

import pkgutil
from importlib import import_module

from vomstudio.studio import tools
from vomstudio.studio.tools.tool_entry import ToolEntry

__all__ = ["TOOLS"]


def _discover_tools() -> list[ToolEntry]:
    names = sorted(module.name for module in pkgutil.iter_modules(tools.__path__))
    # Skipped, because this module itself is being imported.
    modules = [import_module(f"{tools.__name__}.{name}") for name in names if name != "registry"]
    entries = [module.TOOL for module in modules if hasattr(module, "TOOL")]
    return sorted(entries, key=lambda entry: (entry.order, entry.name))


TOOLS: tuple[ToolEntry, ...] = tuple(_discover_tools())
"""Tools in the order of their buttons."""
