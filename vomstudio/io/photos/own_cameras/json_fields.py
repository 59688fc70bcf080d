"""Fields of JSON files of cameras, with errors that name the field."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import GeometryError, InputError
from vomstudio.core.files.regular import read_json
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr

ResultType = TypeVar("ResultType")


@dataclass(frozen=True)
class JsonFields:
    """Reader of the fields of a JSON file.

    Attributes
    ----------
    path : Path
    format : str
        Name of the program, for error messages.
    """

    path: Path
    format: str

    def damage_error(self, field: str, reason: str) -> InputError:
        """Return the error about a field that is not valid."""
        finding = Finding("file.damaged", reason=reason.rstrip("."), format=self.format)
        return InputError(finding, file=self.path, field=field)

    def get(self, field: str, row: Any, key: str) -> Any:
        """Return a value of an object. Raises InputError if it is missing."""
        if not isinstance(row, Mapping) or key not in row:
            raise self.damage_error(f"{field}/{key}", tr("the field is missing"))
        return row[key]

    def numbers(self, field: str, row: Any, key: str, *shape: int) -> FloatArray:
        """Return an array of numbers, which may be written as text. Raises InputError."""
        try:
            values = np.array(self.get(field, row, key), np.float64)
        except (TypeError, ValueError):
            values = np.array([np.nan])
        if values.shape != shape or not np.isfinite(values).all():
            count = int(np.prod(shape))
            reason = tr("{count} numbers are needed", count=count)
            raise self.damage_error(f"{field}/{key}", reason)
        return values

    def call(self, field: str, function: Callable[..., ResultType], *arguments: Any) -> ResultType:
        """Call a function, and convert its errors to errors about a field."""
        try:
            return function(*arguments)
        except (KeyError, TypeError, ValueError, AttributeError, GeometryError) as error:
            reason = str(error)
            if isinstance(error, KeyError):
                reason = tr("{name} is missing", name=error.args[0])
            raise self.damage_error(field, reason) from error


def load_json(path: Path) -> Any:
    """Read a JSON file.

    Raises
    ------
    InputError
        If the file cannot be read, or is not JSON.
    """
    try:
        return read_json(path)
    except OSError as error:
        raise InputError(Finding("file.unreadable", reason=error.strerror), file=path) from error
    except ValueError as error:
        raise InputError(Finding("file.damaged", reason=error, format="JSON"), file=path) from error
