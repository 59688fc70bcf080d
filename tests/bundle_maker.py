"""The maker of bundles, for tests: it lives in packaging/."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from types import ModuleType

PACKAGING = Path(__file__).resolve().parents[1] / "packaging"


def bundling(module: str) -> ModuleType:
    """Import one module of packaging/bundling."""
    if str(PACKAGING) not in sys.path:
        sys.path.insert(0, str(PACKAGING))
    return importlib.import_module(f"bundling.{module}")
