"""What kernels are written as, before anything is compiled."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from types import CellType, CodeType, FunctionType
from typing import Any

COMPILING = threading.RLock()
"""Held while anything is compiled or loaded: two threads that need the same must not both do it."""


@dataclass(frozen=True, eq=False)
class Source:
    """A kernel's function, its signature as numba writes it, and whether sums may be reordered."""

    function: Callable[..., Any]
    signature: str
    fastmath: bool


class Part:
    """A piece of kernels, which numba meets first where a kernel is compiled that calls it."""

    def __init__(self, function: Callable[..., Any], **options: Any) -> None:
        self.function = function
        self.options = {"nogil": True, **options}
        self._compiled: Any = None

    def compiled(self) -> Any:
        """As numba has it."""
        import numba

        with COMPILING:
            if self._compiled is None:
                self._compiled = numba.njit(**self.options)(linked(self.function))
            return self._compiled

    def __call__(self, *args: Any) -> Any:
        return self.compiled()(*args)


def all_code(function: FunctionType) -> list[CodeType]:
    """Of the function and of what is written inside of it."""
    codes = [function.__code__]
    for code in codes:
        codes += [c for c in code.co_consts if isinstance(c, CodeType)]
    return codes


def linked(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function with its parts as numba knows them."""
    assert isinstance(function, FunctionType)

    def resolved(value: Any) -> Any:
        return value.compiled() if isinstance(value, Part) else value

    used = {n for code in all_code(function) for n in code.co_names}
    names = {n: resolved(v) if n in used else v for n, v in function.__globals__.items()}
    cells = tuple(CellType(resolved(cell.cell_contents)) for cell in function.__closure__ or ())
    new = FunctionType(
        function.__code__, names, function.__name__, function.__defaults__, cells or None
    )
    new.__module__, new.__qualname__ = function.__module__, function.__qualname__
    return new
