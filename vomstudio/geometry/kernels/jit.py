"""Compiled kernels: written in Python, compiled by numba once, and loaded without it afterwards.

`import numba` takes longer than most of what a small command does. So nothing here imports it
before something must be compiled: a kernel's machine code is kept on the disk and put into a later
process by llvmlite alone (`machine_code`), or where that cannot be by numba's own cache.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from types import CellType, CodeType, FunctionType, ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

_COMPILING = threading.RLock()


class Part:
    """A piece of kernels, which numba meets first where a kernel is compiled that calls it."""

    def __init__(self, function: Callable[..., Any], **options: Any) -> None:
        self.function = function
        self.options = {"nogil": True, **options}
        self._compiled: Any = None

    def compiled(self) -> Any:
        """As numba has it."""
        import numba

        with _COMPILING:
            if self._compiled is None:
                self._compiled = numba.njit(**self.options)(linked(self.function))
            return self._compiled


class Kernel:
    """A function of arrays and numbers, compiled for one signature when it is first called.

    It does not hold the GIL. What it is given must be exactly of its signature, else TypeError.
    """

    def __init__(self, function: Callable[..., Any], signature: str, fastmath: bool) -> None:
        self.function, self.signature, self.fastmath = function, signature, fastmath
        self.__name__, self.__doc__ = function.__name__, function.__doc__
        self._run: Callable[..., Any] | None = None

    def __call__(self, *args: Any) -> Any:
        return (self._run or self.ready())(*args)

    def ready(self) -> Callable[..., Any]:
        """Load it, or compile and keep it, which takes seconds; at once afterwards."""
        from vomstudio.geometry.kernels import machine_code

        with _COMPILING:
            if self._run is None:
                self._run = machine_code.entry(self) or self.by_numba()
            return self._run

    def by_numba(self) -> Callable[..., Any]:
        """Compiled by numba, or from its cache.

        numba refuses to decorate when neither the package nor the user's cache folder can be
        written; then the kernel is compiled anew in each process.
        """
        import numba

        options = {"nogil": True, "fastmath": self.fastmath}
        with _COMPILING:
            function = linked(self.function)
            try:
                done: Callable[..., Any] = numba.njit(self.signature, cache=True, **options)(
                    function
                )
            except RuntimeError:
                done = numba.njit(self.signature, **options)(function)
        return done


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


def kernel(signature: str, *, fastmath: bool = False) -> Callable[[Callable[..., Any]], Kernel]:
    """A kernel that does not hold the GIL, compiled for one signature and kept on the disk.

    fastmath : sums may be reordered and NaN are not expected; for kernels of pictures
    """
    return lambda function: Kernel(function, signature, fastmath)


def make_ready(*modules: ModuleType) -> None:
    """Load, or compile, the kernels of these modules now, so that nobody waits for them later."""
    for module in modules:
        for value in vars(module).values():
            if isinstance(value, Kernel):
                value.ready()


def part(function: Callable[..., Any]) -> Part:
    """A piece of kernels. Compiled with the first one that calls it, and not loaded afterwards,
    since it lies within the kept kernels."""
    return Part(function)


def step(function: Callable[..., Any]) -> Part:
    """A step of one kernel, put into it as if it was written there: as fast, and with fastmath its
    sums are in the same order. For what is called in one or two places, since each call is a copy.
    """
    return Part(function, inline="always")


def fast_part(function: Callable[..., Any]) -> Part:
    """As `part`, for kernels with fastmath."""
    return Part(function, fastmath=True)


def for_kernels(array: npt.ArrayLike, dtype: npt.DTypeLike) -> npt.NDArray[Any]:
    """The array as a kernel's signature wants it: contiguous, of this type, and writable; copied
    only where it is not (one mapped from a file is read-only)."""
    return np.require(array, dtype, ["C_CONTIGUOUS", "WRITEABLE"])
