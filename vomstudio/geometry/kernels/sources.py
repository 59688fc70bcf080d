"""Sources of kernels before compilation."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass
from types import CellType, CodeType, FunctionType
from typing import Any

COMPILATION_LOCK = threading.RLock()
"""Lock held while a kernel is compiled or loaded, so that two threads do not repeat the work."""


@dataclass(frozen=True, eq=False)
class KernelSource:
    """Function of a kernel with its signature in numba's notation.

    `fastmath` allows sums to be reordered.
    """

    function: Callable[..., Any]
    signature: str
    fastmath: bool


class KernelPart:
    """Function called by kernels, which numba compiles with the first kernel that calls it."""

    def __init__(self, function: Callable[..., Any], **options: Any) -> None:
        self.function = function
        self.options = {"nogil": True, **options}
        self._compiled: Any = None

    def compiled_function(self) -> Any:
        """Return the function compiled by numba."""
        import numba

        with COMPILATION_LOCK:
            if self._compiled is None:
                self._compiled = numba.njit(**self.options)(link_parts(self.function))
            return self._compiled

    def __call__(self, *args: Any) -> Any:
        return self.compiled_function()(*args)


def all_code_objects(function: FunctionType) -> list[CodeType]:
    """Return the code of a function and of the functions inside it.

    Parameters
    ----------
    function : FunctionType

    Returns
    -------
    list of CodeType
    """
    codes = [function.__code__]
    for code in codes:
        codes += [co_const for co_const in code.co_consts if isinstance(co_const, CodeType)]
    return codes


def link_parts(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return the function with its parts compiled by numba.

    Parameters
    ----------
    function : callable
        Function that calls parts.

    Returns
    -------
    callable
    """
    assert isinstance(function, FunctionType)

    def resolve_parts(value: Any) -> Any:
        return value.compiled_function() if isinstance(value, KernelPart) else value

    used_names = {co_name for code in all_code_objects(function) for co_name in code.co_names}
    names = {n: resolve_parts(v) if n in used_names else v for n, v in function.__globals__.items()}
    cells = tuple(
        CellType(resolve_parts(cell.cell_contents)) for cell in function.__closure__ or ()
    )
    linked_function = FunctionType(
        function.__code__, names, function.__name__, function.__defaults__, cells or None
    )
    linked_function.__module__, linked_function.__qualname__ = (
        function.__module__,
        function.__qualname__,
    )
    return linked_function
