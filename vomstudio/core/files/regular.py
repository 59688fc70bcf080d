"""Files that are found by name: only regular ones, of a size that their kind can have.

What lies beside a photo or a model is named by whoever made the folder. A pipe waits for ever, a
device has no end, and a file of the right name may be of any size.
"""

from __future__ import annotations

import errno
import json
import os
import select
import stat
import time
from io import BufferedReader, FileIO
from pathlib import Path
from typing import Any

from vomstudio.core.errors import InputError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr

SIDECAR_BYTES = 16 << 20
"""More than any description beside a model or a photo has."""
JSON_BYTES = 1 << 30
"""Cameras and points of a reconstruction of thousands of photos stay below it."""
_MOST_VALUES = 8_000_000


def is_regular(path: str | Path) -> bool:
    """Whether there is a file with content at the path, links followed; never waits for one."""
    try:
        return stat.S_ISREG(os.stat(path).st_mode)
    except (OSError, ValueError):
        return False


def is_folder(path: str | Path) -> bool:
    """As `Path.is_dir`, which raises where a drive has gone or a name is too long for one."""
    try:
        return stat.S_ISDIR(os.stat(path).st_mode)
    except (OSError, ValueError):
        return False


def is_there(path: str | Path) -> bool:
    """As `Path.exists`, which raises where a drive has gone or a name is too long for one."""
    try:
        os.stat(path)
    except (OSError, ValueError):
        return False
    return True


def require_regular(path: str | Path) -> None:
    """Raises InputError for a folder, device, pipe or socket; what is not there is left to the
    reader."""
    try:
        mode = os.stat(path).st_mode
    except (OSError, ValueError):
        return
    if not stat.S_ISREG(mode):
        raise InputError(Finding("file.not-regular"), file=path)


def require_regular_beside(path: str | Path) -> None:
    """For libraries that look for files beside one that they open: raises InputError for the first
    device, pipe or socket whose name begins as that of the file does, whatever it ends in. It would
    be waited for without end."""
    shown = Path(path)
    begins = shown.stem.casefold()
    try:
        with os.scandir(shown.parent) as entries:
            names = [e.name for e in entries if e.name.casefold().startswith(begins)]
    except (OSError, ValueError):
        return
    for name in sorted(names):
        beside = shown.parent / name
        try:
            mode = os.stat(beside).st_mode
        except OSError:
            continue
        if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
            raise InputError(Finding("file.device-in-folder"), file=beside)


def open_regular(path: str | Path) -> BufferedReader:
    """A file opened for reading, without waiting for it. Raises InputError where it is no regular
    file, and OSError where it cannot be opened."""
    return os.fdopen(_descriptor(path), "rb")


def open_unbuffered(path: str | Path) -> FileIO:
    """As `open_regular`, for what is read into memory that is there already."""
    return os.fdopen(_descriptor(path), "rb", buffering=0)


def _descriptor(path: str | Path) -> int:
    require_regular(path)
    try:
        # Without waiting, should a pipe have taken the place of the file since it was looked at.
        return os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | _BINARY)
    except ValueError as error:
        # A zero byte in a name.
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(path)) from error


def read_whole(path: str | Path) -> bytes:
    """All of a file that may be of any size. Raises as `open_regular`."""
    with open_regular(path) as file:
        return file.read()


def read_pipe(path: str | Path, limit: int) -> bytes:
    """What somebody writes into a pipe, at most `limit` bytes. Raises InputError where nobody does
    within some seconds, or where it is more, and OSError."""
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    parts: list[bytes] = []
    got, begun = 0, time.monotonic()
    try:
        while True:
            try:
                part = os.read(descriptor, 1 << 20)
            except BlockingIOError:
                # Somebody has it open: he is waited for, as long as he wants.
                select.select([descriptor], [], [], 1.0)
                continue
            parts.append(part)
            got += len(part)
            if got > limit:
                raise InputError(Finding("file.too-large", limit_mb=limit >> 20), file=path)
            if not part and got:
                return b"".join(parts)
            if not part and time.monotonic() - begun > _NOBODY_S:
                raise InputError(Finding("file.silent-pipe"), file=path)
            if not part:
                time.sleep(0.02)
    finally:
        os.close(descriptor)


_NOBODY_S = 3.0


def read_small(path: str | Path, limit: int = SIDECAR_BYTES) -> bytes:
    """The content of a file of at most `limit` bytes.

    Raises InputError where it is larger or no regular file, and OSError where it cannot be read.
    """
    with open_regular(path) as file:
        # Room is made for what is asked for: so for no more than there is, and for nothing of what
        # is too large.
        size = os.fstat(file.fileno()).st_size
        data = file.read(size + 1) if size <= limit else b""
    if max(size, len(data)) > limit:
        raise InputError(Finding("file.too-large", limit_mb=limit >> 20), file=path)
    return data


def read_json(path: str | Path, limit: int = JSON_BYTES) -> Any:
    """What a JSON file of at most `limit` bytes holds; named by whoever made its folder.

    Raises ValueError with the reason where it is larger, no regular file, no JSON or nested without
    end, and OSError where it cannot be read.
    """
    try:
        data = read_small(path, limit)
        # Each takes some sixty bytes of memory once read, and two of the file.
        if sum(data.count(sign) for sign in (b",", b"[", b"{")) > _MOST_VALUES:
            raise ValueError(tr("more than {limit} values", limit=_MOST_VALUES))
        return json.loads(data)
    except InputError as error:
        raise ValueError(error.message) from error
    except RecursionError as error:
        raise ValueError(tr("values nested without end")) from error


def read_small_text(path: str | Path, limit: int = SIDECAR_BYTES) -> str:
    """As `read_small`, in UTF-8. Raises UnicodeDecodeError, a ValueError, besides."""
    return read_small(path, limit).decode("utf-8")


_BINARY = getattr(os, "O_BINARY", 0)
