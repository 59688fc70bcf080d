"""Loading of native libraries in a compatible order.

pycolmap's wheels for Linux contain their own zlib and export its symbols to the libraries that are
loaded with it. One of these, the Fortran library, needs the system's libz. If pycolmap is the first
to load libz, the system's libz resolves to pycolmap's functions, and everything that compresses
with it (Pillow's PNG and TIFF, Python's zlib, gzip and zipfile) mixes the two. The process then
aborts with "free(): invalid pointer", or hangs. If the system's libz is loaded before pycolmap, it
resolves to itself, and the order of later imports does not matter.
"""

from __future__ import annotations

import importlib

_PRELOADED_MODULES = ("zlib", "PIL.Image")
"""Modules to import first. If zlib is built into the interpreter, only Pillow loads libz."""


def load_shared_libraries() -> None:
    """Import the libraries that must precede pycolmap (15 ms); no effect after pycolmap."""
    for name in _PRELOADED_MODULES:
        importlib.import_module(name)
