"""Compiled kernels that are kept between runs where the disk allows it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba


def kernel(signature: str | None = None) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """numba.njit, without the GIL, compiled for one signature and cached on disk.

    numba refuses to decorate when neither the package nor the user's cache folder can be written;
    then the kernel is compiled anew in each process.
    """
    args = () if signature is None else (signature,)

    def wrap(function: Callable[..., Any]) -> Callable[..., Any]:
        try:
            return numba.njit(*args, nogil=True, cache=True)(function)
        except RuntimeError:
            return numba.njit(*args, nogil=True)(function)

    return wrap
