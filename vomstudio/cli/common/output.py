"""Output of a command: a JSON object or text on stdout, all other output on stderr.

Libraries print to stdout, from C as well as from Python. Therefore descriptor 1 is redirected to 2
while a command runs, and its result is written to the saved descriptor. Nothing is written until
the command has finished: a failure produces a single message and no partial result.
"""

from __future__ import annotations

import contextlib
import errno
import json
import math
import os
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import PurePath
from typing import Any, TextIO

from vomstudio.core.errors import TargetError
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr


class Output:
    """Output of a command, which is collected until it is complete."""

    def __init__(self, *, writes_json: bool, json_events: bool = False) -> None:
        self.writes_json = writes_json
        self.writes_events = json_events
        """Whether stderr contains only JSON lines, so that programs can parse the progress."""
        self.quiet = False
        """Whether to omit notes and warnings; errors are always shown."""
        self.shows_codes = False
        """Whether notes contain the codes of findings."""
        self.has_failed = False
        """Whether the exit code indicates an error despite a result (`info` of several files)."""
        self._result: Mapping[str, Any] | None = None
        self._text: list[str] = []
        self._notes: list[str] = []
        self._errors: list[str] = []

    def result(self, value: Mapping[str, Any]) -> None:
        """Store the JSON object of the command."""
        self._result = value

    def text(self, text: str) -> None:
        """Add human-readable text to the result."""
        self._text.append(text)

    def note(self, text: str) -> None:
        """Add a human-readable note, which is not part of the result."""
        self._notes.append(text)

    def error(self, text: str) -> None:
        """Report an item that failed while others succeeded (exit code 2; shown even if quiet)."""
        self.has_failed = True
        self._errors.append(text)
        self._notes.append(text)

    def warn(self, warnings: Sequence[Finding]) -> None:
        """Store findings as notes for the user, each with its severity as a word."""
        for finding in warnings:
            message = f"[{finding.code}] {finding}" if self.shows_codes else finding
            self.note(tr(_SEVERITY_TEXTS[finding.severity], message=message))

    def stdout_text(self) -> str:
        if self.writes_json:
            return "" if self._result is None else to_json(self._result) + "\n"
        return escape_for_terminal("".join(f"{text}\n" for text in self._text))

    def stderr_text(self) -> str:
        lines = self._notes + (self._text if self.writes_json else [])
        if self.quiet:
            lines = self._errors
        return "".join(f"{self.format_stderr_line(text)}\n" for text in lines)

    def format_stderr_line(self, text: str, **extra: object) -> str:
        if self.writes_events:
            return to_json({"event": "text", "text": text, **extra})
        return escape_for_terminal(text)


_SEVERITY_TEXTS = {
    "info": to_translate("note: {message}"),
    "warning": to_translate("warning: {message}"),
    "error": to_translate("error: {message}"),
}


def escape_for_terminal(text: str) -> str:
    """Escape control characters and characters that change the direction of text.

    Names in files from unknown sources must not control the terminal.
    """
    return CONTROL_CHARACTERS.sub(_escape_character, text)


def to_json(value: object) -> str:
    """Return one line of strict JSON; undefined and infinite values become null."""
    text = json.dumps(_to_plain_value(value), ensure_ascii=False, allow_nan=False)
    return escape_for_terminal(text)


def _to_plain_value(value: object) -> object:
    """Convert NumPy values, paths, findings and collections for JSON. Raises TypeError."""
    if isinstance(value, Mapping):
        return {str(key): _to_plain_value(item) for key, item in value.items()}
    if isinstance(value, Finding):
        return _to_plain_value(value.to_dict())
    if isinstance(value, str | PurePath):
        return str(value)
    if value is None or isinstance(value, bool | int):
        return value
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if hasattr(value, "tolist"):
        return _to_plain_value(value.tolist())
    if isinstance(value, Sequence | set | frozenset):
        return [_to_plain_value(item) for item in value]
    raise TypeError(f"{type(value).__name__} has no place in JSON")


CONTROL_CHARACTERS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
"""Control characters except tab and line feed, and characters that set the text direction."""


def _escape_character(match: re.Match[str]) -> str:
    return f"\\u{ord(match[0]):04x}"


class Channel:
    """Original standard output, encoded as UTF-8 for any locale."""

    def __init__(self, descriptor: int | None, stream: TextIO | None) -> None:
        self._descriptor = descriptor
        self._stream = stream

    def write(self, text: str) -> None:
        """Write all text. Raises `BrokenPipeError` if the pipe is closed, or `TargetError`."""
        try:
            if self._descriptor is not None:
                data = memoryview(text.encode("utf-8", "replace"))
                while data:
                    data = data[os.write(self._descriptor, data) :]
            elif self._stream is not None:
                self._stream.write(text)
                self._stream.flush()
        except BrokenPipeError:
            raise
        except OSError as error:
            disk_finding = Finding("disk.full")
            output_finding = Finding("output.unwritable", reason=error.strerror)
            finding = disk_finding if error.errno == errno.ENOSPC else output_finding
            raise TargetError(finding, file="<stdout>") from error


@contextlib.contextmanager
def preserve_stdout() -> Iterator[Channel]:
    """Yield the original stdout; everything printed in the meantime goes to stderr."""
    stream = sys.stdout
    try:
        is_process_stdout = stream is not None and stream.fileno() == 1
        if is_process_stdout:
            stream.flush()
        saved_descriptor = os.dup(1) if is_process_stdout else None
    except (OSError, ValueError):  # closed, or an object instead of a file
        saved_descriptor = None
    if saved_descriptor is None:
        with contextlib.suppress(OSError):
            if stream is None and not _is_open(1):
                # Closed by the caller; otherwise the first file to be opened would get descriptor
                # 1.
                _redirect_stdout()
        with contextlib.redirect_stdout(sys.stderr):
            yield Channel(None, stream)
        return
    try:
        _redirect_stdout()
        with contextlib.redirect_stdout(sys.stderr):
            yield Channel(saved_descriptor, None)
    finally:
        with contextlib.suppress(OSError, ValueError):
            stream.flush()
        os.dup2(saved_descriptor, 1)
        os.close(saved_descriptor)


def _is_open(descriptor: int) -> bool:
    try:
        os.fstat(descriptor)
    except OSError:
        return False
    return True


def _redirect_stdout() -> None:
    try:
        os.dup2(2, 1)
    except OSError:  # stderr is closed
        null_device = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null_device, 1)
        os.close(null_device)


@contextlib.contextmanager
def silence_output() -> Iterator[None]:
    """Discard all output to stdout and stderr in the block, from both C and Python."""
    saved_descriptors = {number: os.dup(number) for number in (1, 2) if _is_open(number)}
    try:
        with (
            open(os.devnull, "w", encoding="utf-8") as null_device,
            contextlib.redirect_stdout(null_device),
            contextlib.redirect_stderr(null_device),
        ):
            for number in saved_descriptors:
                os.dup2(null_device.fileno(), number)
            yield
    finally:
        for number, copy in saved_descriptors.items():
            os.dup2(copy, number)
            os.close(copy)
