"""Kernels in Python, compiled by numba once and loaded without it afterwards.

`import numba` takes longer than most small commands. This module imports it only when a kernel must
be compiled: the machine code is cached on disk and loaded into a later process by llvmlite alone
(`machine_code`), or else by numba's own cache.
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
from vomstudio.geometry.kernels.sources import (
    COMPILATION_LOCK,
    KernelPart,
    KernelSource,
    link_parts,
)


class Kernel:
    """Function of arrays and numbers, compiled for one signature on its first call.

    The kernel releases the GIL. Arguments must match its signature exactly; otherwise TypeError is
    raised.
    """

    def __init__(self, function: Callable[..., Any], signature: str, fastmath: bool) -> None:
        self.source = KernelSource(function, signature, fastmath)
        self.__name__, self.__doc__ = function.__name__, function.__doc__
        self._run: Callable[..., Any] | None = None

    def __call__(self, *args: Any) -> Any:
        return (self._run or self.load())(*args)

    def load(self) -> Callable[..., Any]:
        """Load the kernel, or compile and cache it, which takes seconds once."""
        from vomstudio.geometry.kernels import machine_code

        with COMPILATION_LOCK:
            if self._run is None:
                self._run = (
                    machine_code.entry(self.source, self.compile_with_numba)
                    or self.compile_with_numba()
                )
            return self._run

    def compile_for_this_processor(self) -> None:
        """Compile and cache the kernel, unless the cache contains it."""
        from vomstudio.geometry.kernels import machine_code

        with COMPILATION_LOCK:
            if not machine_code.compile_for_this_processor(self.source):
                self.compile_with_numba()

    def compile_with_numba(self) -> Callable[..., Any]:
        """Compile with numba, or load from numba's cache.

        If no cache folder can be written, the kernel is compiled anew in each process.
        """
        from vomstudio.geometry.kernels import machine_code

        options: dict[str, Any] = {"nogil": True, "fastmath": self.source.fastmath}
        with COMPILATION_LOCK:
            function = link_parts(self.source.function)
            folder = machine_code.numba_cache_folder(self.source)
            if folder is not None:
                try:
                    with _numba_cache(folder):
                        return _decorate(function, self.source, cache=True, **options)
                except (RuntimeError, OSError):
                    pass
            return _decorate(function, self.source, **options)


def _decorate(
    function: Callable[..., Any], source: KernelSource, **options: Any
) -> Callable[..., Any]:
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
    """Declare a kernel that releases the GIL, compiled for one signature.

    Its code is cached on disk.

    Parameters
    ----------
    signature : str
        In numba's notation.
    fastmath : bool, optional
        Whether sums may be reordered and NaN is excluded, for kernels that process pictures.

    Returns
    -------
    callable
        Decorator.
    """
    return lambda function: Kernel(function, signature, fastmath)


def prepare_kernels(*modules: ModuleType) -> None:
    """Load or compile the kernels of these modules now, to avoid delays later.

    Parameters
    ----------
    *modules : ModuleType
        Modules that define kernels.
    """
    for module in modules:
        for value in vars(module).values():
            if isinstance(value, Kernel):
                value.load()


def part(function: Callable[..., Any]) -> KernelPart:
    """Declare a function that kernels call.

    It is compiled with the first kernel that calls it, and is included in the code of that kernel.

    Parameters
    ----------
    function : callable

    Returns
    -------
    KernelPart
    """
    return KernelPart(function)


def step(function: Callable[..., Any]) -> KernelPart:
    """Declare a step of one kernel, inlined into it.

    It is as fast as inline code, and with fastmath its sums have the same order. Use it for one or
    two calls only, because each call inserts a copy.

    Parameters
    ----------
    function : callable

    Returns
    -------
    KernelPart
    """
    return KernelPart(function, inline="always")


def fastmath_part(function: Callable[..., Any]) -> KernelPart:
    """Declare a `part` for kernels with fastmath.

    Parameters
    ----------
    function : callable

    Returns
    -------
    KernelPart
    """
    return KernelPart(function, fastmath=True)


def to_kernel_array(array: npt.ArrayLike, dtype: npt.DTypeLike) -> AnyArray:
    """Convert an array to the form that kernels require: contiguous, typed and writable.

    The array is copied only if necessary.

    Parameters
    ----------
    array : array_like
    dtype : dtype

    Returns
    -------
    ndarray
    """
    return np.require(array, dtype, ["C_CONTIGUOUS", "WRITEABLE"])


class _BorrowedMemory:
    """Memory of an array with another writable flag, which keeps the array alive."""

    def __init__(self, array: AnyArray) -> None:
        self.array = array
        self.__array_interface__ = {
            **array.__array_interface__,
            "data": (array.__array_interface__["data"][0], False),
        }


def to_read_only_array(array: npt.ArrayLike, dtype: npt.DTypeLike) -> AnyArray:
    """Convert an array for kernels that only read it, without copying read-only memory.

    Writing to the result terminates the process.

    Parameters
    ----------
    array : array_like
    dtype : dtype

    Returns
    -------
    ndarray
    """
    aligned_array = np.require(array, dtype, ["C_CONTIGUOUS", "ALIGNED"])
    if aligned_array.flags.writeable or not aligned_array.size:
        return to_kernel_array(aligned_array, dtype)
    return np.asarray(_BorrowedMemory(aligned_array))
