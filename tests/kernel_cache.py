"""Compiled kernels are shared between tests and with the program."""

from __future__ import annotations

import os

from vomstudio.core.paths import user_cache


def share_kernel_cache() -> None:
    """Keep the kernels of this user in use after XDG_CACHE_HOME changes, here and in processes.

    A test with a cache folder of its own would otherwise compile them, which takes a minute.
    """
    os.environ.setdefault("NUMBA_CACHE_DIR", str(user_cache("kernels")))
