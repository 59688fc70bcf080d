"""Native libraries in the one order in which they get along.

pycolmap's wheels for Linux hold a zlib of their own and show all its names to the libraries that
they are loaded with. One of these, Fortran's, needs the system's libz. Where pycolmap brings that
in, the system's libz finds pycolmap's functions for its own ones, and everything that compresses
with it from then on (Pillow's PNG and TIFF, Python's zlib, gzip and zipfile) mixes the two: the
process aborts with "free(): invalid pointer", or hangs. Loaded before pycolmap, the system's libz
is bound to itself, in whatever order the rest comes.
"""

from __future__ import annotations

import importlib

_BEFORE_COLMAP = ("zlib", "PIL.Image")
"""Python's zlib may be built into the interpreter, and then only Pillow brings in the system's."""


def load_shared_libraries() -> None:
    """Import what must be there before pycolmap: 15 ms, and nothing where it was imported already.
    It cannot help where pycolmap itself was imported before."""
    for name in _BEFORE_COLMAP:
        importlib.import_module(name)
