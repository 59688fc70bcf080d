"""Which reader takes which file.

A new format is one module in `vomstudio/io/models/formats` that defines `READER`, or a package of
someone else that names a `Reader` in the entry point group `vomstudio.readers`.
"""

from __future__ import annotations

import functools
import importlib
from pathlib import Path

from vomstudio.core.errors import InputError
from vomstudio.core.files.regular import open_regular
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.io.models.reader import HEAD_BYTES, Reader
from vomstudio.io.plugins import LoadedPlugins, find_plugins

GROUP = "vomstudio.readers"


@functools.cache
def find_readers() -> LoadedPlugins[Reader]:
    from vomstudio.io.models import formats

    return find_plugins(formats, "READER", Reader, GROUP)


def usual_reader(extension: str) -> Reader | None:
    """The first of our readers that name an extension. The others are not imported for it."""
    from vomstudio.io.models import formats

    name = formats.USUAL.get(extension)
    if name is None:
        return None
    reader = importlib.import_module(f"{formats.__name__}.{name}").READER
    assert isinstance(reader, Reader)
    return reader


def extensions() -> tuple[str, ...]:
    """Every extension that can be read, for file dialogs."""
    return tuple(dict.fromkeys(e for r in find_readers().all for e in r.extensions))


def what_can_be_read() -> str:
    """For sentences: 'LAS/LAZ point cloud (.las, .laz), ...'."""
    readers = find_readers()
    formats = [f"{tr(r.name)} ({', '.join(r.extensions)})" for r in readers.all]
    return ", ".join([*formats, *map(str, readers.broken)])


def read_head(path: Path) -> bytes:
    """The first bytes of a file. Raises InputError when it is not a file that can be read."""
    try:
        if path.is_dir():
            raise InputError(Finding("file.is-folder"), file=path)
        with open_regular(path) as file:
            return file.read(HEAD_BYTES)
    except FileNotFoundError:
        raise InputError(Finding("file.missing"), file=path) from None
    except PermissionError:
        raise InputError(Finding("file.no-permission"), file=path) from None
    except (OSError, ValueError) as error:
        raise InputError(Finding("file.unreadable", reason=error), file=str(path)) from None


def choose_reader(path: Path, head: bytes) -> Reader:
    """The reader for a file: by its content where that is certain, else by its extension.

    Raises InputError that lists what can be read.
    """
    if not head:
        raise InputError(Finding("file.empty"), file=path)
    extension = path.suffix.lower()
    usual = usual_reader(extension)
    if usual is not None and usual.matches(path, head):
        return usual
    found = find_readers()
    by_extension = [r for r in found.all if extension in r.extensions]
    for reader in by_extension:
        if reader.matches(path, head):
            return reader
    for reader in found.all:
        if reader.matches(path, head):
            return reader
    if by_extension:
        return by_extension[0]
    finding = Finding("file.unknown-type", suffix=path.suffix, formats=what_can_be_read())
    raise InputError(finding, file=path)
