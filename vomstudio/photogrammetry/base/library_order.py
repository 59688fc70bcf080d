"""Load native libraries in a compatible order.

pycolmap's wheels for Linux contain a zlib and export its names to the libraries that are loaded
with it. One of these, Fortran's, needs the system's libz. If pycolmap loads it, the system's libz
resolves to pycolmap's functions, and everything that compresses with it (Pillow's PNG and TIFF,
Python's zlib, gzip and zipfile) mixes the two: the process aborts with "free(): invalid pointer",
or hangs. If it is loaded before pycolmap, the system's libz resolves to itself, in any later order.
"""

from __future__ import annotations

import importlib

_BEFORE_COLMAP = ("zlib", "PIL.Image")
"""Python's zlib may be built into the interpreter; then only Pillow loads the system's."""


def load_shared_libraries() -> None:
    """Import libraries that must precede pycolmap (15 ms); no effect after pycolmap."""
    for name in _BEFORE_COLMAP:
        importlib.import_module(name)
