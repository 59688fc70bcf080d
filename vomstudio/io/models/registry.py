"""Which reader takes which file.

A new format is one module in `vomstudio/io/models/formats` that defines `READER`, or a package of
someone else that names a `Reader` in the entry point group `vomstudio.readers`.
"""

from __future__ import annotations

import functools
import importlib
import pkgutil
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import entry_points
from pathlib import Path
from typing import Literal

from vomstudio.errors import InputError
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.progress import Progress

GROUP = "vomstudio.readers"
HEAD_BYTES = 4096


@dataclass(frozen=True, eq=False)
class LoadedModel:
    """What a file held.

    data : in the file's own frame
    kind : "mesh" or "cloud"
    crs : "EPSG:n", a WKT text, or None where the file names none
    warnings : one sentence for each thing that was wrong, left out or guessed
    path : the file
    content_hash : sha256 of the file itself in hex (of an OBJ: without its MTL and images); a
        reader may leave it empty, `read_model` fills it
    turned_about : where the format says that Y is up and the reader has therefore turned the model
        upright, the point of `data`'s frame about which it did; else None
    resolution : as `vomstudio.io.models.opening.resolution` tells it, where it is known; else None
    """

    data: Mesh | PointCloud
    kind: Literal["mesh", "cloud"]
    crs: str | None
    warnings: tuple[str, ...]
    path: Path
    content_hash: str = ""
    turned_about: tuple[float, float, float] | None = None
    resolution: float | None = None


@dataclass(frozen=True)
class Reader:
    """One format.

    name : as a person says it
    extensions : lower case, with the dot
    matches : from the path and the file's first bytes (at most `HEAD_BYTES`), whether the *content*
        is surely of this format, whatever the extension says
    read : raises InputError for what cannot be read, Cancelled when `progress` says so
    """

    name: str
    extensions: tuple[str, ...]
    matches: Callable[[Path, bytes], bool]
    read: Callable[[Path, Progress], LoadedModel]


@dataclass(frozen=True)
class Found:
    """All readers, and why some could not be loaded."""

    readers: tuple[Reader, ...]
    broken: tuple[str, ...]


@functools.cache
def find_readers() -> Found:
    """Our own formats first, then those of installed packages, each in the order of their names.

    A package whose reader cannot be loaded is named in `broken` and never stops the others.
    """
    from vomstudio.io.models import formats

    readers: list[Reader] = []
    broken: list[str] = []
    for module in sorted(pkgutil.iter_modules(formats.__path__), key=lambda m: m.name):
        if module.name.startswith("_"):
            continue
        found = getattr(
            importlib.import_module(f"{formats.__name__}.{module.name}"), "READER", None
        )
        if isinstance(found, Reader):
            readers.append(found)
        else:
            broken.append(f"vomstudio.io.models.formats.{module.name} defines no READER")
    for point in sorted(entry_points(group=GROUP), key=lambda p: p.name):
        try:
            found = point.load()
        except Exception as error:  # noqa: BLE001  someone else's code must not stop ours
            broken.append(f"the reader '{point.name}' ({point.value}) does not load: {error}")
            continue
        if isinstance(found, Reader):
            readers.append(found)
        else:
            broken.append(f"the reader '{point.name}' ({point.value}) is not a Reader")
    return Found(tuple(readers), tuple(broken))


def extensions() -> tuple[str, ...]:
    """Every extension that can be read, for file dialogs."""
    return tuple(dict.fromkeys(e for r in find_readers().readers for e in r.extensions))


def what_can_be_read() -> str:
    """For sentences: 'LAS/LAZ point cloud (.las, .laz), ...'."""
    return ", ".join(f"{r.name} ({', '.join(r.extensions)})" for r in find_readers().readers)


def read_head(path: Path) -> bytes:
    """The first bytes of a file. Raises InputError when it is not a file that can be read."""
    try:
        if path.is_dir():
            raise InputError("This is a folder; name a model file in it.", file=path)
        with open(path, "rb") as file:
            return file.read(HEAD_BYTES)
    except FileNotFoundError:
        raise InputError("There is no such file; check its name.", file=path) from None
    except PermissionError:
        raise InputError("You may not read this file; change its permissions.", file=path) from None
    except (OSError, ValueError) as error:
        raise InputError(f"The file cannot be opened ({error}).", file=str(path)) from None


def choose_reader(path: Path, head: bytes) -> Reader:
    """The reader for a file: by its content where that is certain, else by its extension.

    Raises InputError that lists what can be read.
    """
    if not head:
        raise InputError("The file is empty; export or copy it again.", file=path)
    found = find_readers()
    extension = path.suffix.lower()
    by_extension = [r for r in found.readers if extension in r.extensions]
    for reader in by_extension:
        if reader.matches(path, head):
            return reader
    for reader in found.readers:
        if reader.matches(path, head):
            return reader
    if by_extension:
        return by_extension[0]
    what = f"a file of type '{path.suffix}'" if path.suffix else "a file without an extension"
    sentence = f"No reader for {what}; what can be read: {what_can_be_read()}."
    if found.broken:
        sentence += f" ({'; '.join(found.broken)})"
    raise InputError(sentence, file=path)
