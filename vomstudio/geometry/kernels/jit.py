"""Compiled kernels that are kept between runs where the disk allows it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba
import numpy as np
import numpy.typing as npt


def kernel(
    signature: str, *, fastmath: bool = False
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """numba.njit, without the GIL, compiled for one signature and cached on disk.

    fastmath : sums may be reordered and NaN are not expected; for kernels of pictures

    numba refuses to decorate when neither the package nor the user's cache folder can be written;
    then the kernel is compiled anew in each process.
    """

    def wrap(function: Callable[..., Any]) -> Callable[..., Any]:
        try:
            return numba.njit(signature, nogil=True, fastmath=fastmath, cache=True)(function)
        except RuntimeError:
            return numba.njit(signature, nogil=True, fastmath=fastmath)(function)

    return wrap


def part(function: Callable[..., Any]) -> Callable[..., Any]:
    """A piece of kernels. Compiled with the first one that calls it, and not loaded afterwards,
    since it lies within the cached kernels."""
    return numba.njit(nogil=True)(function)


def step(function: Callable[..., Any]) -> Callable[..., Any]:
    """A step of one kernel, put into it as if it was written there: as fast, and with fastmath its
    sums are in the same order. For what is called in one or two places, since each call is a copy.
    """
    return numba.njit(nogil=True, inline="always")(function)


def fast_part(function: Callable[..., Any]) -> Callable[..., Any]:
    """As `part`, for kernels with fastmath."""
    return numba.njit(nogil=True, fastmath=True)(function)


def for_kernels(array: npt.ArrayLike, dtype: npt.DTypeLike) -> npt.NDArray[Any]:
    """The array as a kernel's signature wants it: contiguous, of this type, and writable; copied
    only where it is not (one mapped from a file is read-only)."""
    return np.require(array, dtype, ["C_CONTIGUOUS", "WRITEABLE"])
