"""Names of files as libraries take them."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path


def in_unicode(name: str) -> str:
    """A name that is not UTF-8 as Windows Latin, as it was most likely meant; others as they
    are."""
    try:
        name.encode("utf-8")
    except UnicodeEncodeError:
        return os.fsencode(name).decode("cp1252", "replace")
    return name


def writable(text: str) -> str:
    """For files and databases that take only what UTF-8 can write: a question mark in place of
    each half of a character, as in the name of a file whose bytes are no UTF-8."""
    return text.encode("utf-8", "replace").decode()


@contextlib.contextmanager
def utf8_name(path: Path) -> Iterator[Path]:
    """A name of an existing file in UTF-8: its own, or that of a link where it is none. A name on
    Linux is any bytes, of which GDAL, FFmpeg and libE57 take only UTF-8. Files beside it are not
    found through the link. Raises OSError where no link can be made."""
    try:
        os.fspath(path).encode("utf-8")
    except UnicodeEncodeError:
        ending = path.suffix if path.suffix.isascii() else ""
        with tempfile.TemporaryDirectory(prefix="vomstudio-") as folder:
            link = Path(folder) / f"file{ending}"
            link.symlink_to(path.absolute())
            yield link
    else:
        yield path
