"""Numbers know no file: what they do not define is said with the name of their file."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from vomstudio.errors import GeometryError


@contextmanager
def numbers_of(file: str) -> Iterator[None]:
    """A GeometryError from here names the file, where it names neither file nor field."""
    try:
        yield
    except GeometryError as error:
        if error.file is None and error.field is None:
            raise type(error)(error.message, file=file) from error
        raise
