"""Errors that a user may encounter, each with one sentence that states the remedy."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Protocol, Self

NON_FINITE_TEXTS = ("inf", "-inf", "nan")
"""Numbers that JSON cannot represent; they are stored as text."""


def to_json_values(values: Mapping[str, object]) -> dict[str, object]:
    """Return the values with tuples converted to lists and non-finite numbers to text."""
    return {name: _to_json_value(value) for name, value in values.items()}


def _to_json_value(value: object) -> object:
    if isinstance(value, tuple):
        return [_to_json_value(item) for item in value]
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value


def from_json_values(values: Mapping[str, object]) -> dict[str, object]:
    """Return the original values from the output of `to_json_values`."""
    return {name: _from_json_value(value) for name, value in values.items()}


def _from_json_value(value: object) -> object:
    if isinstance(value, list):
        return [_from_json_value(item) for item in value]
    return float(value) if isinstance(value, str) and value in NON_FINITE_TEXTS else value


def location_text(
    file: str | None = None, line: int | None = None, field: str | None = None
) -> str:
    """Return the text for a location in a file, or an empty text if the location is unknown."""
    parts = (file, None if line is None else f"line {line}", field)
    return ", ".join(item for item in parts if item)


class _Finding(Protocol):
    """Part of `vomstudio.core.findings.Finding` that an error uses."""

    @property
    def code(self) -> str: ...

    @property
    def message(self) -> str: ...

    @property
    def values(self) -> Mapping[str, object]: ...


class VomError(Exception):
    """Base class of all expected errors.

    Parameters
    ----------
    cause : Finding or str
        Finding that provides the code, the values and the sentence. A plain sentence gets the code
        of the class.
    file, line, field : optional
        Location of the cause; the line number is 1-based. `str(error)` joins location and
        sentence.
    """

    code = "error"
    exit_code = 2

    def __init__(
        self,
        cause: _Finding | str,
        *,
        file: str | Path | None = None,
        line: int | None = None,
        field: str | None = None,
    ) -> None:
        self.values: dict[str, object] = {}
        if isinstance(cause, str):
            self.message = cause
        else:
            self.message = cause.message
            self.code, self.values = cause.code, dict(cause.values)
        super().__init__(self.message)
        self.file = None if file is None else str(file)
        self.line = line
        self.field = field

    def __str__(self) -> str:
        if self.file is None and self.field is not None and self._mentions_argument(self.field):
            return self.message
        location = location_text(self.file, self.line, self.field)
        return f"{location}: {self.message}" if location else self.message

    def _mentions_argument(self, argument: str) -> bool:
        """Return whether the message contains the name of an argument."""
        return re.search(rf"(?<![\w-]){re.escape(argument)}(?![\w-])", self.message) is not None

    def to_dict(self) -> dict[str, object]:
        """Return the `error` object of the command-line JSON output."""
        return to_json_values(self.values) | {
            "code": self.code,
            "file": self.file,
            "line": self.line,
            "field": self.field,
            "message": self.message,
        }


class InputError(VomError):
    """An input is not valid, such as a file or table that cannot be read.

    The subclasses cover options, outputs, points and edits. A script that catches `InputError`
    catches every error that the user can correct.
    """

    code = "input"

    def with_file(self, file: str | Path) -> Self:
        """Return a copy with a file, or the error itself if it already has a file or field."""
        if self.file is not None or self.field is not None:
            return self
        copy = type(self)(self.message, file=file, line=self.line)
        copy.code, copy.values = self.code, self.values
        return copy


class UsageError(InputError):
    """The arguments of a command or the value of a setting are not valid."""

    code = "usage"


class TargetError(InputError):
    """An output cannot be written."""

    code = "target"


class GeometryError(InputError):
    """Points or orientations do not define the requested geometry."""

    code = "geometry"


class DocumentError(InputError):
    """An edit, a project or a journal is not valid."""

    code = "document"


class Cancelled(VomError):
    """The user stopped the work."""

    code = "cancelled"
    exit_code = 130

    def __init__(self, message: str = "Cancelled.") -> None:
        super().__init__(message)


class WorkerError(VomError):
    """A worker process died or broke the protocol, which is a defect of the program."""

    code = "worker"
    exit_code = 1


class VomWarning(UserWarning):
    """Python warning about a problem that does not stop the work.

    Parameters
    ----------
    message : str
    code : str
        Stable code of the finding, such as ``frame.assumed``, or ``uncoded`` if the finding has no
        code.
    values : dict, optional
        The values of the finding by name.
    """

    def __init__(
        self, message: str, code: str = "uncoded", values: Mapping[str, object] | None = None
    ) -> None:
        super().__init__(message)
        self.code = code
        self.values = dict(values or {})


def from_dict(error: dict[str, object], exit_code: int) -> VomError:
    """Return the error that another process reported with `to_dict()`."""

    def text(name: str) -> str | None:
        value = error.get(name)
        return None if value is None else str(value)

    line = error.get("line")
    result = VomError(
        str(error.get("message", "")),
        file=text("file"),
        line=line if isinstance(line, int) else None,
        field=text("field"),
    )
    if error.get("code") == Cancelled.code:
        return Cancelled(result.message)
    result.code, result.exit_code = str(error.get("code", result.code)), exit_code
    reserved_keys = ("code", "file", "line", "field", "message")
    result.values = from_json_values(
        {name: value for name, value in error.items() if name not in reserved_keys}
    )
    return result
