"""Registry of model readers by file format.

A new format is either a module in `vomstudio/io/models/formats` that defines `READER`, or a
third-party package that declares a `Reader` in the entry point group `vomstudio.readers`.
"""

from __future__ import annotations

import functools
import importlib
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import folder_finding, open_regular_file
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.io.models.reader import HEAD_BYTES, Reader
from vomstudio.io.plugins import LoadedPlugins, find_plugins

GROUP = "vomstudio.readers"


@functools.cache
def find_readers() -> LoadedPlugins[Reader]:
    """Return the readers of models, including plugins."""
    from vomstudio.io.models import formats

    return find_plugins(formats, "READER", Reader, GROUP)


def default_reader(extension: str) -> Reader | None:
    """Return the built-in reader that is tried first for an extension, or None.

    The other readers are not imported.
    """
    from vomstudio.io.models import formats

    name = formats.MODULES_BY_SUFFIX.get(extension)
    if name is None:
        return None
    reader = importlib.import_module(f"{formats.__name__}.{name}").READER
    assert isinstance(reader, Reader)
    return reader


def extensions() -> tuple[str, ...]:
    """Return all extensions that can be read, for file dialogs."""
    return tuple(
        dict.fromkeys(extension for reader in find_readers().all for extension in reader.extensions)
    )


def supported_formats() -> str:
    """Return the supported formats as text, such as 'LAS/LAZ point cloud (.las, .laz)'."""
    readers = find_readers()
    formats = [f"{tr(reader.name)} ({', '.join(reader.extensions)})" for reader in readers.all]
    return ", ".join([*formats, *map(str, readers.problems)])


def read_head(path: Path) -> bytes:
    """Return the first bytes of a file. Raises InputError if the file is not readable."""
    try:
        if path.is_dir():
            raise InputError(folder_finding(path), file=path)
        with open_regular_file(path) as file:
            return file.read(HEAD_BYTES)
    except FileNotFoundError:
        raise InputError(Finding("file.missing"), file=path) from None
    except PermissionError:
        raise InputError(Finding("file.no-permission"), file=path) from None
    except (OSError, ValueError) as error:
        raise InputError(Finding("file.unreadable", reason=error), file=str(path)) from None


def choose_reader(path: Path, head: bytes) -> Reader:
    """Choose the reader for a file by its content, or by its extension if inconclusive.

    Raises InputError with a list of the supported formats.
    """
    if not head:
        raise InputError(Finding("file.empty"), file=path)
    extension = path.suffix.lower()
    default = default_reader(extension)
    if default is not None and default.matches(path, head):
        return default
    readers = find_readers()
    candidates = [reader for reader in readers.all if extension in reader.extensions]
    for reader in candidates:
        if reader.matches(path, head):
            return reader
    for reader in readers.all:
        if reader.matches(path, head):
            return reader
    if candidates:
        return candidates[0]
    finding = Finding("file.unknown-type", suffix=path.suffix, formats=supported_formats())
    raise InputError(finding, file=path)
