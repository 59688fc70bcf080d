"""Which reader takes which file.

A new format is one module in `vomstudio/io/models/formats` that defines `READER`, or a package of
someone else that names a `Reader` in the entry point group `vomstudio.readers`.
"""

from __future__ import annotations

import functools
import importlib
from pathlib import Path

from vomstudio.errors import InputError
from vomstudio.files.regular import open_regular
from vomstudio.io.models.reader import HEAD_BYTES, Reader
from vomstudio.io.plugins import Found, find_plugins
from vomstudio.words import tr

GROUP = "vomstudio.readers"


@functools.cache
def find_readers() -> Found[Reader]:
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
    return ", ".join(f"{tr(r.name)} ({', '.join(r.extensions)})" for r in find_readers().all)


def read_head(path: Path) -> bytes:
    """The first bytes of a file. Raises InputError when it is not a file that can be read."""
    try:
        if path.is_dir():
            raise InputError(tr("This is a folder. Name a model file in it."), file=path)
        with open_regular(path) as file:
            return file.read(HEAD_BYTES)
    except FileNotFoundError:
        raise InputError(tr("There is no such file. Check its name."), file=path) from None
    except PermissionError:
        raise InputError(
            tr("There is no permission to read this file. Change its permissions."), file=path
        ) from None
    except (OSError, ValueError) as error:
        raise InputError(
            tr("The file cannot be opened ({error}).", error=error), file=str(path)
        ) from None


def choose_reader(path: Path, head: bytes) -> Reader:
    """The reader for a file: by its content where that is certain, else by its extension.

    Raises InputError that lists what can be read.
    """
    if not head:
        raise InputError(tr("The file is empty. Export or copy it again."), file=path)
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
    sentence = (
        tr(
            "Files of type '{suffix}' cannot be read. Supported: {formats}.",
            suffix=path.suffix,
            formats=what_can_be_read(),
        )
        if path.suffix
        else tr(
            "A file without an extension cannot be read. Supported: {formats}.",
            formats=what_can_be_read(),
        )
    )
    if found.broken:
        sentence += f" ({'; '.join(found.broken)})"
    raise InputError(sentence, file=path)
