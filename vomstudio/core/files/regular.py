"""Safe access to files found by name: only regular files of a plausible size.

The names of files next to a photo or a model come from an unknown source. A pipe may block
forever, a device has no end, and a file with the expected name may have any size.
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

MAX_SIDECAR_BYTES = 16 << 20
"""Maximum size of a sidecar file of a model or a photo."""
MAX_JSON_BYTES = 1 << 30
"""Maximum size of a JSON file, larger than a reconstruction of thousands of photos."""
_MAX_JSON_VALUES = 8_000_000


def is_regular_file(path: str | Path) -> bool:
    """Return whether the path, after following links, is a regular file; never blocks."""
    try:
        return stat.S_ISREG(os.stat(path).st_mode)
    except (OSError, ValueError):
        return False


def folder_finding(path: Path) -> Finding:
    """Return the finding that a folder was given instead of a file.

    Parameters
    ----------
    path : Path

    Returns
    -------
    Finding
    """
    return Finding("file.is-project" if path.suffix == ".vom" else "file.is-folder")


def is_folder(path: str | Path) -> bool:
    """Return whether the path is a folder; return False if `Path.is_dir` would raise an error."""
    try:
        return stat.S_ISDIR(os.stat(path).st_mode)
    except (OSError, ValueError):
        return False


def path_exists(path: str | Path) -> bool:
    """Return whether a path exists; return False if `Path.exists` would raise an error."""
    try:
        os.stat(path)
    except (OSError, ValueError):
        return False
    return True


def require_regular_file(path: str | Path) -> None:
    """Raise InputError for a folder, device, pipe or socket, but not for a missing file."""
    try:
        mode = os.stat(path).st_mode
    except (OSError, ValueError):
        return
    if not stat.S_ISREG(mode):
        raise InputError(Finding("file.not-regular"), file=path)


def require_regular_siblings(path: str | Path) -> None:
    """Raise InputError if a device, pipe or socket in the folder is named like the file.

    A name counts if it starts with the stem of the file, regardless of case. Use this check for
    libraries that also open files next to the given one: they would block on a pipe.
    """
    shown_path = Path(path)
    stem = shown_path.stem.casefold()
    try:
        with os.scandir(shown_path.parent) as entries:
            names = [entry.name for entry in entries if entry.name.casefold().startswith(stem)]
    except (OSError, ValueError):
        return
    for name in sorted(names):
        sibling = shown_path.parent / name
        try:
            mode = os.stat(sibling).st_mode
        except OSError:
            continue
        if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
            raise InputError(Finding("file.device-in-folder"), file=sibling)


def open_regular_file(path: str | Path) -> BufferedReader:
    """Open a file for reading without blocking.

    Raises
    ------
    InputError
        If the path is not a regular file.
    OSError
        If the file cannot be opened.
    """
    return os.fdopen(_descriptor(path), "rb")


def open_unbuffered(path: str | Path) -> FileIO:
    """Open a file in the same way as `open_regular_file`, to read into an existing buffer."""
    return os.fdopen(_descriptor(path), "rb", buffering=0)


def _descriptor(path: str | Path) -> int:
    require_regular_file(path)
    try:
        # Open without blocking, in case a pipe has replaced the file since the check.
        return os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | _BINARY_FLAG)
    except ValueError as error:
        # The name contains a zero byte.
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), str(path)) from error


def read_whole_file(path: str | Path) -> bytes:
    """Read a file of any size. Raises the same errors as `open_regular_file`."""
    with open_regular_file(path) as file:
        return file.read()


def read_pipe(path: str | Path, limit: int) -> bytes:
    """Read the content of a pipe.

    Parameters
    ----------
    path : str or Path
    limit : int
        Maximum number of bytes.

    Raises
    ------
    InputError
        If nothing is written within a few seconds, or if the pipe contains more than `limit`
        bytes.
    OSError
    """
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
    parts: list[bytes] = []
    total_bytes, start_time_s = 0, time.monotonic()
    try:
        while True:
            try:
                part = os.read(descriptor, 1 << 20)
            except BlockingIOError:
                # A writer has opened the pipe, so wait for it without a time limit.
                select.select([descriptor], [], [], 1.0)
                continue
            parts.append(part)
            total_bytes += len(part)
            if total_bytes > limit:
                raise InputError(Finding("file.too-large", limit_mb=limit >> 20), file=path)
            if not part and total_bytes:
                return b"".join(parts)
            if not part and time.monotonic() - start_time_s > _MAX_SILENCE_S:
                raise InputError(Finding("file.silent-pipe"), file=path)
            if not part:
                time.sleep(0.02)
    finally:
        os.close(descriptor)


_MAX_SILENCE_S = 3.0


def read_small_file(path: str | Path, limit: int = MAX_SIDECAR_BYTES) -> bytes:
    """Read a file with a maximum size of `limit` bytes.

    Raises
    ------
    InputError
        If the file is larger or not a regular file.
    OSError
        If the file cannot be read.
    """
    with open_regular_file(path) as file:
        # `read` allocates the requested size, so request the size of the file, or nothing if the
        # file is too large.
        size = os.fstat(file.fileno()).st_size
        data = file.read(size + 1) if size <= limit else b""
    if max(size, len(data)) > limit:
        raise InputError(Finding("file.too-large", limit_mb=limit >> 20), file=path)
    return data


def read_json(path: str | Path, limit: int = MAX_JSON_BYTES) -> Any:
    """Read a JSON file from an unknown source with a maximum size of `limit` bytes.

    Raises
    ------
    ValueError
        If the file is too large, has too many values, or is not a regular file, not JSON or nested
        too deeply; the message states the reason.
    OSError
        If the file cannot be read.
    """
    try:
        data = read_small_file(path, limit)
        # A value takes about 60 bytes in memory but only 2 bytes in the file.
        if sum(data.count(sign) for sign in (b",", b"[", b"{")) > _MAX_JSON_VALUES:
            raise ValueError(tr("more than {limit} values", limit=_MAX_JSON_VALUES))
        return json.loads(data)
    except InputError as error:
        raise ValueError(error.message) from error
    except RecursionError as error:
        raise ValueError(tr("endlessly nested values")) from error


def read_small_text(path: str | Path, limit: int = MAX_SIDECAR_BYTES) -> str:
    """Read a UTF-8 file in the same way as `read_small_file`. Also raises UnicodeDecodeError."""
    return read_small_file(path, limit).decode("utf-8")


_BINARY_FLAG = getattr(os, "O_BINARY", 0)
