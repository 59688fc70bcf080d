"""Addition of the input file and the option to errors from computations."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from vomstudio.core.errors import GeometryError


@contextmanager
def name_input_in_errors(file: str, option: str | None = None) -> Iterator[None]:
    """Add the file and the option to a GeometryError that names neither file nor field."""
    try:
        yield
    except GeometryError as error:
        if error.file is None and error.field is None:
            error.file, error.field = file, option
        raise
