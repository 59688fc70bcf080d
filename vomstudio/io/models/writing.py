"""Which writer makes which file.

A new format is one module in `vomstudio/io/models/writers` that defines `WRITER`, or a package of
someone else that names a `Writer` in the entry point group `vomstudio.writers`.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.files.atomic import check_target
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, Silent
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.registrations import Registration
from vomstudio.geometry.units import WORLD, Axes
from vomstudio.io.models.registration_file import (
    check_registration_target,
    registration_path,
    write_registration,
)
from vomstudio.io.models.writer import Outgoing, Writer
from vomstudio.io.plugins import LoadedPlugins, find_plugins

GROUP = "vomstudio.writers"


@functools.cache
def find_all() -> LoadedPlugins[Writer]:
    from vomstudio.io.models import writers

    return find_plugins(writers, "WRITER", Writer, GROUP)


def find_writers() -> tuple[Writer, ...]:
    return find_all().all


def choose_writer(path: Path) -> Writer:
    """By the ending. Raises UsageError that lists what can be written."""
    ending = path.suffix.lower()
    for writer in find_writers():
        if ending in writer.extensions:
            return writer
    endings = (each for writer in find_writers() for each in writer.extensions)
    known = ", ".join([*endings, *map(str, find_all().broken)])
    raise UsageError(Finding("output.unknown-format", suffix=ending, formats=known), file=path)


def write_model(
    data: Mesh | PointCloud,
    crs: str | None,
    path: str | Path,
    *,
    force: bool = False,
    inputs: Iterable[Path] = (),
    progress: Progress | None = None,
    axes: Axes = WORLD,
    registration: Registration | None = None,
) -> list[Finding]:
    """Write a model in World by the ending of `path`, whole or not at all.

    axes : what is known of x, y and z, which the file says
    registration : written beside the model as `NAME.registration.json`; its matrix leads from
        these coordinates to World

    Returns one sentence for each thing that the format cannot hold. Raises UsageError for an
    unknown ending, GeometryError for coordinates that are not finite, TargetError, or Cancelled.
    """
    path = Path(path)
    writer = choose_writer(path)
    given = tuple(inputs)
    check_target(path, force=force, inputs=given)
    _require_places(data, path)
    sidecar = registration_path(path)
    replaces = force and not any(Path(each).resolve() == sidecar.resolve() for each in given)
    check_registration_target(path, registration, force=replaces)
    messages = writer.write(Outgoing(data, crs, path, force, progress or Silent(), given, axes))
    if registration is not None:
        write_registration(registration, [path], force=replaces)
    return messages


def _require_places(data: Mesh | PointCloud, path: Path) -> None:
    points = data.vertices if isinstance(data, Mesh) else data.points
    # By columns, which is many times faster than along rows of three.
    bad = np.flatnonzero(~np.logical_and.reduce([np.isfinite(column) for column in points.T]))
    if len(bad):
        raise GeometryError(
            Finding("model.not-finite", count=len(bad), first_row=bad[0]), file=path
        )
