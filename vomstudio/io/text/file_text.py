"""Reading of text files: encoding detection, and rejection of other kinds or sizes."""

from __future__ import annotations

import stat
from collections.abc import Collection
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.files.file_kinds import refuse_other_kind, require_text
from vomstudio.core.files.regular import folder_finding, is_regular_file, read_pipe, read_whole_file
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr

MAX_FILE_BYTES = 4 << 30
MAX_LINES = 2_000_000
"""Maximum number of lines of a numerical table; a line takes about 200 bytes of memory."""
MAX_OBJECTS = 300_000
"""Maximum for tables of features, photos or marks, each of which takes up to 1.5 kB of memory."""
_MIN_LONG_TEXT_LENGTH = 20_000_000
_MIN_LINE_LENGTH = 4  # average number of characters in a long file: "0,0" and a line feed


def require_file(path: Path) -> int:
    """Return the size of a file in bytes, or 0 for a pipe. Raises `InputError`."""
    try:
        status = path.stat()
    except (FileNotFoundError, NotADirectoryError) as error:
        raise InputError(Finding("file.missing"), file=path) from error
    except (OSError, ValueError) as error:
        raise _reading_error(path, error) from error
    if stat.S_ISDIR(status.st_mode):
        raise InputError(folder_finding(path), file=path)
    if not (stat.S_ISREG(status.st_mode) or stat.S_ISFIFO(status.st_mode)):
        raise InputError(Finding("file.not-regular"), file=path)
    return status.st_size


def read_bytes(path: Path) -> bytes:
    """Read a file or pipe. Raises `InputError` with the reason."""
    size = require_file(path)
    if size > MAX_FILE_BYTES:
        raise InputError(Finding("table.too-large", size_gib=size / 2**30), file=path)
    try:
        if not is_regular_file(path):
            return read_pipe(path, MAX_FILE_BYTES)
        return read_whole_file(path)
    except PermissionError as error:
        raise InputError(Finding("file.no-permission"), file=path) from error
    except OSError as error:
        raise _reading_error(path, error) from error


def _reading_error(path: Path, error: OSError | ValueError) -> InputError:
    reason = getattr(error, "strerror", None) or error
    return InputError(Finding("file.unreadable", reason=reason), file=path)


def read_text(
    path: Path, max_lines: int = MAX_LINES, accepted_names: Collection[str] = ()
) -> tuple[str, list[Finding]]:
    """Read a text file with line feeds as line ends; return findings about its encoding.

    Parameters
    ----------
    path : Path
    max_lines : int
        Maximum number of lines.
    accepted_names : collection of str
        Kinds of `vomstudio.core.files.file_kinds` that the caller can read; others are rejected.

    Raises
    ------
    InputError
        If the file cannot be read, is empty or not text, is of another kind (``file.other-kind``),
        or has too many lines.
    """
    refuse_other_kind(path, accepted_names)
    raw_bytes = read_bytes(path)
    notes: list[Finding] = []
    if not raw_bytes or raw_bytes.isspace():
        raise InputError(Finding("file.empty"), file=path)
    if raw_bytes[:2] in (b"\xff\xfe", b"\xfe\xff"):
        try:
            text = raw_bytes.decode("utf-16")
        except UnicodeDecodeError as error:
            raise InputError(
                Finding(
                    "file.damaged",
                    format="UTF-16",
                    reason=tr("some bytes are not valid characters"),
                ),
                file=path,
            ) from error
        require_text(path, text.encode("utf-8", "replace"), accepted_names)
        notes.append(Finding("file.encoding", "info", encoding="UTF-16"))
    else:
        require_text(path, raw_bytes, accepted_names)
        try:
            text = raw_bytes.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = raw_bytes.decode("cp1252", errors="replace")
            notes.append(Finding("file.encoding", encoding="Windows-1252"))
    if "\r" in text:
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    line_count = text.count("\n")
    if len(text) > _MIN_LONG_TEXT_LENGTH and line_count * _MIN_LINE_LENGTH > len(text):
        raise InputError(Finding("file.inflated"), file=path)
    refuse_many_lines(path, line_count, max_lines)
    return text, notes


def refuse_many_lines(path: Path, lines: int, max_lines: int) -> None:
    """Raise InputError if there are more than `max_lines` lines."""
    if lines > max_lines:
        raise InputError(Finding("table.too-many-rows", count=lines, limit=max_lines), file=path)
