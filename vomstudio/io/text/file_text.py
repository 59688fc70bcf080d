"""From a file to its text: the encoding is told, what is no file, no text or too large refused."""

from __future__ import annotations

import stat
from collections.abc import Collection
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.files.file_kinds import refuse_other_kind, require_text
from vomstudio.core.files.regular import is_regular, read_pipe, read_whole
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr

LARGEST_FILE = 4 << 30
MOST_LINES = 2_000_000
"""Of a table of numbers: a line of text takes some 200 bytes of memory."""
MOST_OBJECTS = 300_000
"""Lines of a table whose rows become features, photos or marks: up to 1.5 kB each."""
_LONG = 20_000_000
_SHORTEST_LINE = 4  # characters, on average, of a long file: "0,0" and its end


def require_file(path: Path) -> int:
    """The size in bytes of a file (0 of a pipe). Raises `InputError` for all that is none."""
    try:
        about = path.stat()
    except (FileNotFoundError, NotADirectoryError) as error:
        raise InputError(Finding("file.missing"), file=path) from error
    except (OSError, ValueError) as error:
        raise _unreadable(path, error) from error
    if stat.S_ISDIR(about.st_mode):
        raise InputError(Finding("file.is-folder"), file=path)
    if not (stat.S_ISREG(about.st_mode) or stat.S_ISFIFO(about.st_mode)):
        raise InputError(Finding("file.not-regular"), file=path)
    return about.st_size


def read_bytes(path: Path) -> bytes:
    """The bytes of a file or pipe; why a file cannot be read is an `InputError`."""
    size = require_file(path)
    if size > LARGEST_FILE:
        raise InputError(Finding("table.too-large", size_gib=size / 2**30), file=path)
    try:
        if not is_regular(path):
            return read_pipe(path, LARGEST_FILE)
        return read_whole(path)
    except PermissionError as error:
        raise InputError(Finding("file.no-permission"), file=path) from error
    except OSError as error:
        raise _unreadable(path, error) from error


def _unreadable(path: Path, error: OSError | ValueError) -> InputError:
    reason = getattr(error, "strerror", None) or error
    return InputError(Finding("file.unreadable", reason=reason), file=path)


def read_text(
    path: Path, most_lines: int = MOST_LINES, accepted: Collection[str] = ()
) -> tuple[str, list[Finding]]:
    """Read a text file, with line feeds at the ends of lines, and what was remarkable about it.

    Parameters
    ----------
    path : Path
    most_lines : int
        Maximum number of lines.
    accepted : collection of str
        Kinds of `vomstudio.core.files.file_kinds` that the caller reads; others are refused.

    Raises
    ------
    InputError
        If the file is not text, is of another kind (``file.other-kind``), or has more lines.
    """
    refuse_other_kind(path, accepted)
    raw = read_bytes(path)
    notes: list[Finding] = []
    if not raw.strip():
        raise InputError(Finding("file.empty"), file=path)
    if raw[:2] in (b"\xff\xfe", b"\xfe\xff"):
        try:
            text = raw.decode("utf-16")
        except UnicodeDecodeError as error:
            raise InputError(
                Finding("file.damaged", format="UTF-16", reason=tr("some bytes are no characters")),
                file=path,
            ) from error
        require_text(path, text.encode("utf-8", "replace"), accepted)
        notes.append(Finding("file.encoding", "info", encoding="UTF-16"))
    else:
        require_text(path, raw, accepted)
        try:
            text = raw.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = raw.decode("cp1252", errors="replace")
            notes.append(Finding("file.encoding", encoding="Windows-1252"))
    if "\r" in text:
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    if len(text) > _LONG and text.count("\n") * _SHORTEST_LINE > len(text):
        raise InputError(Finding("file.inflated"), file=path)
    refuse_too_many(path, text.count("\n"), most_lines)
    return text, notes


def refuse_too_many(path: Path, lines: int, most: int) -> None:
    if lines > most:
        raise InputError(Finding("table.too-many-rows", count=lines, limit=most), file=path)
