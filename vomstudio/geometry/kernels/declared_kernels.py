"""Discovery of all kernels of the program."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Iterator
from pathlib import Path

from vomstudio.geometry.kernels.jit import Kernel

_PACKAGE = Path(__file__).resolve().parents[2]


def declared_kernels() -> Iterator[Kernel]:
    """Yield each kernel once, by importing the modules that declare kernels.

    These are all modules of this package, and the modules of other packages whose names end in
    `kernels`.
    """
    for module in pkgutil.walk_packages([str(_PACKAGE)], f"{_PACKAGE.name}."):
        if module.name.endswith("kernels") or ".kernels." in module.name:
            for value in vars(importlib.import_module(module.name)).values():
                if isinstance(value, Kernel) and value.source.function.__module__ == module.name:
                    yield value
