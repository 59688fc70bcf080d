"""Which writer makes which file.

A new format is one module in `vomstudio/io/models/writers` that defines `WRITER`, or a package of
someone else that names a `Writer` in the entry point group `vomstudio.writers`.
"""

from __future__ import annotations

import functools
import importlib
import pkgutil
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib.metadata import entry_points
from pathlib import Path

from vomstudio.errors import UsageError
from vomstudio.files.atomic import check_target
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.progress import Progress, Silent

GROUP = "vomstudio.writers"


@dataclass(frozen=True)
class Outgoing:
    """What is to be written. data : in World (x East, y North, z Up, metres); crs : "EPSG:n", WKT,
    or None; force : whether files that are there may be replaced, save `inputs`, which the model
    was read from."""

    data: Mesh | PointCloud
    crs: str | None
    path: Path
    force: bool
    progress: Progress
    inputs: tuple[Path, ...] = ()


@dataclass(frozen=True)
class Writer:
    """One format.

    extensions : lower case, with the dot
    write : everything whole or nothing at all; returns one sentence for each thing that the format
        cannot hold or that had to be changed. Raises TargetError, or Cancelled through the progress
    """

    name: str
    extensions: tuple[str, ...]
    write: Callable[[Outgoing], list[str]]


@functools.cache
def find_writers() -> tuple[Writer, ...]:
    """Our own formats first. A package whose writer cannot be loaded is passed over."""
    from vomstudio.io.models import writers

    found: list[object] = [
        importlib.import_module(f"{writers.__name__}.{module.name}").WRITER
        for module in sorted(pkgutil.iter_modules(writers.__path__), key=lambda m: m.name)
        if not module.name.startswith("_")
    ]
    for point in sorted(entry_points(group=GROUP), key=lambda p: p.name):
        try:
            found.append(point.load())
        except Exception:  # noqa: BLE001  someone else's code must not stop ours
            continue
    return tuple(writer for writer in found if isinstance(writer, Writer))


def choose_writer(path: Path) -> Writer:
    """By the ending. Raises UsageError that lists what can be written."""
    ending = path.suffix.lower()
    for writer in find_writers():
        if ending in writer.extensions:
            return writer
    known = ", ".join(e for w in find_writers() for e in w.extensions)
    raise UsageError(
        f"the ending says what to write, and '{ending}' is not one of {known}.", file=path
    )


def write_model(
    data: Mesh | PointCloud,
    crs: str | None,
    path: str | Path,
    *,
    force: bool = False,
    inputs: Iterable[Path] = (),
    progress: Progress | None = None,
) -> list[str]:
    """Write a model in World by the ending of `path`, whole or not at all.

    Returns one sentence for each thing that the format cannot hold. Raises UsageError for an
    unknown ending, TargetError, or Cancelled.
    """
    path = Path(path)
    writer = choose_writer(path)
    given = tuple(inputs)
    check_target(path, force=force, inputs=given)
    return writer.write(Outgoing(data, crs, path, force, progress or Silent(), given))
