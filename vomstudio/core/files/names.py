"""File names for libraries that accept only valid UTF-8."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path


def decode_name(name: str) -> str:
    """Decode a name that is not UTF-8 as cp1252; other names are not changed."""
    try:
        name.encode("utf-8")
    except UnicodeEncodeError:
        return os.fsencode(name).decode("cp1252", "replace")
    return name


def replace_surrogates(text: str) -> str:
    """Replace each lone surrogate by a question mark, for output as UTF-8.

    A file name that is not valid UTF-8 contains lone surrogates.
    """
    return text.encode("utf-8", "replace").decode()


@contextlib.contextmanager
def utf8_name(path: Path) -> Iterator[Path]:
    """Yield a UTF-8 path of an existing file: its own path or that of a temporary link.

    On Linux, a file name is any sequence of bytes, but GDAL, FFmpeg and libE57 accept only UTF-8.
    Other files in the same folder cannot be found through the link.

    Raises
    ------
    OSError
        If the link cannot be created.
    """
    try:
        os.fspath(path).encode("utf-8")
    except UnicodeEncodeError:
        suffix = path.suffix if path.suffix.isascii() else ""
        with tempfile.TemporaryDirectory(prefix="vomstudio-") as folder:
            link = Path(folder) / f"file{suffix}"
            link.symlink_to(path.absolute())
            yield link
    else:
        yield path
