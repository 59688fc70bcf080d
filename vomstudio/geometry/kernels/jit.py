"""Compiled kernels: written in Python, compiled by numba once, and loaded without it afterwards.

`import numba` takes longer than most of what a small command does. So nothing here imports it
before something must be compiled: a kernel's machine code is kept on the disk and put into a later
process by llvmlite alone (`machine_code`), or where that cannot be by numba's own cache.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import AnyArray
from vomstudio.geometry.kernels.sources import COMPILING, Part, Source, linked


class Kernel:
    """A function of arrays and numbers, compiled for one signature when it is first called.

    It does not hold the GIL. What it is given must be exactly of its signature, else TypeError.
    """

    def __init__(self, function: Callable[..., Any], signature: str, fastmath: bool) -> None:
        self.source = Source(function, signature, fastmath)
        self.__name__, self.__doc__ = function.__name__, function.__doc__
        self._run: Callable[..., Any] | None = None

    def __call__(self, *args: Any) -> Any:
        return (self._run or self.ready())(*args)

    def ready(self) -> Callable[..., Any]:
        """Load it, or compile and keep it, which takes seconds; at once afterwards."""
        from vomstudio.geometry.kernels import machine_code

        with COMPILING:
            if self._run is None:
                self._run = machine_code.entry(self.source, self.by_numba) or self.by_numba()
            return self._run

    def by_numba(self) -> Callable[..., Any]:
        """Compile by numba, or load from numba's cache.

        If no cache folder can be written, the kernel is compiled anew in each process.
        """
        from vomstudio.geometry.kernels import machine_code

        options: dict[str, Any] = {"nogil": True, "fastmath": self.source.fastmath}
        with COMPILING:
            function = linked(self.source.function)
            folder = machine_code.numba_cache_folder(self.source)
            if folder is not None:
                try:
                    with _numba_cache(folder):
                        return _decorated(function, self.source, cache=True, **options)
                except (RuntimeError, OSError):
                    pass
            return _decorated(function, self.source, **options)


def _decorated(function: Callable[..., Any], source: Source, **options: Any) -> Callable[..., Any]:
    import numba

    compiled: Callable[..., Any] = numba.njit(source.signature, **options)(function)
    return compiled


@contextlib.contextmanager
def _numba_cache(folder: Path) -> Iterator[None]:
    """Make numba use this cache folder for the functions that are compiled inside the block."""
    import numba

    config: Any = numba.config
    previous = config.CACHE_DIR
    config.CACHE_DIR = str(folder)
    try:
        yield
    finally:
        # Functions of other packages keep the cache that they have.
        config.CACHE_DIR = previous


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


def for_kernels(array: npt.ArrayLike, dtype: npt.DTypeLike) -> AnyArray:
    """The array as a kernel's signature wants it: contiguous, of this type, and writable; copied
    only where it is not (one mapped from a file is read-only)."""
    return np.require(array, dtype, ["C_CONTIGUOUS", "WRITEABLE"])


class _Borrowed:
    """Memory of an array under another flag, for as long as the array is needed."""

    def __init__(self, array: AnyArray) -> None:
        self.array = array
        self.__array_interface__ = {
            **array.__array_interface__,
            "data": (array.__array_interface__["data"][0], False),
        }


def for_reading(array: npt.ArrayLike, dtype: npt.DTypeLike) -> AnyArray:
    """As `for_kernels`, for kernels that do not write to it: an array that is merely read-only, as
    one mapped from a file, is not copied. To write to the result ends the process."""
    wanted = np.require(array, dtype, ["C_CONTIGUOUS", "ALIGNED"])
    if wanted.flags.writeable or not wanted.size:
        return for_kernels(wanted, dtype)
    return np.asarray(_Borrowed(wanted))
