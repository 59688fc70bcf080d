"""Import of laspy without its client for files on servers."""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import cast


def import_laspy() -> ModuleType:
    """Import laspy, but not requests, which takes longer to import than laspy itself.

    laspy requires requests only for files on servers, which the program does not read, and works
    without it.
    """
    if "laspy" not in sys.modules and "requests" not in sys.modules:
        modules = cast("dict[str, ModuleType | None]", sys.modules)
        modules["requests"] = None
        try:
            import_module("laspy")
        finally:
            del modules["requests"]
    return import_module("laspy")
