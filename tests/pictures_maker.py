"""The maker of the documents' pictures, for tests: it lives in packaging/."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from types import ModuleType

PACKAGING = Path(__file__).resolve().parents[1] / "packaging"


def maker(module: str) -> ModuleType:
    """One module of packaging/pictures."""
    if str(PACKAGING) not in sys.path:
        sys.path.insert(0, str(PACKAGING))
    return importlib.import_module(f"pictures.{module}")
