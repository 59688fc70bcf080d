"""Registry of model writers by file format.

A new format is either a module in `vomstudio/io/models/writers` that defines `WRITER`, or a
third-party package that declares a `Writer` in the entry point group `vomstudio.writers`.
"""

from __future__ import annotations

import functools
import importlib
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from vomstudio.core.errors import GeometryError, UsageError
from vomstudio.core.files.atomic import check_target
from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.registrations import Registration
from vomstudio.geometry.units import WORLD_AXES, Axes
from vomstudio.io.models.registration_file import (
    check_registration_target,
    registration_path,
    write_registration,
)
from vomstudio.io.models.writer import Writer, WriteRequest
from vomstudio.io.plugins import LoadedPlugins, find_plugins

GROUP = "vomstudio.writers"


@functools.cache
def find_writer_plugins() -> LoadedPlugins[Writer]:
    """Return the model writers, including plugins, and the plugins that failed to load."""
    from vomstudio.io.models import writers

    return find_plugins(writers, "WRITER", Writer, GROUP)


def find_writers() -> tuple[Writer, ...]:
    """Return the writers of models, including plugins."""
    return find_writer_plugins().all


def choose_writer(path: Path) -> Writer:
    """Return the writer for a suffix. Raises UsageError with a list of supported formats."""
    from vomstudio.io.models import writers

    suffix = path.suffix.lower()
    if suffix in writers.MODULES_BY_SUFFIX:
        module = importlib.import_module(f"{writers.__name__}.{writers.MODULES_BY_SUFFIX[suffix]}")
        assert isinstance(module.WRITER, Writer)
        return module.WRITER
    for writer in find_writers():
        if suffix in writer.extensions:
            return writer
    endings = (extension for writer in find_writers() for extension in writer.extensions)
    formats = ", ".join([*endings, *map(str, find_writer_plugins().problems)])
    raise UsageError(Finding("output.unknown-format", suffix=suffix, formats=formats), file=path)


def write_model(
    data: Mesh | PointCloud,
    crs: str | None,
    path: str | Path,
    *,
    force: bool = False,
    inputs: Iterable[Path] = (),
    progress: Progress | None = None,
    axes: Axes = WORLD_AXES,
    registration: Registration | None = None,
) -> list[Finding]:
    """Write a model in the format of the suffix, completely or not at all.

    Parameters
    ----------
    data : Mesh or PointCloud
    crs : str or None
        CRS of x, y and z.
    path : str or Path
    force : bool, optional
        Whether to replace existing files.
    inputs : iterable of Path, optional
        Files that must not be overwritten.
    progress : Progress, optional
    axes : Axes
        Properties of x, y and z to be stated in the file.
    registration : Registration or None
        Registration to be written next to the model as `NAME.registration.json`; its matrix
        transforms these coordinates to World coordinates.

    Returns
    -------
    list of Finding
        Findings about data that the format cannot store.

    Raises
    ------
    UsageError
        If the suffix is not supported.
    GeometryError
        If coordinates are not finite.
    TargetError
        If a file cannot be written, or exists and must not be replaced.
    Cancelled
    """
    path = Path(path)
    writer = choose_writer(path)
    input_paths = tuple(inputs)
    check_target(path, force=force, inputs=input_paths)
    _require_finite(data, path)
    sidecar = registration_path(path)
    is_replacing = force and not any(
        Path(input_path).resolve() == sidecar.resolve() for input_path in input_paths
    )
    check_registration_target(path, registration, force=is_replacing)
    findings = writer.write(
        WriteRequest(data, crs, path, force, progress or SilentProgress(), input_paths, axes)
    )
    if registration is not None:
        write_registration(registration, [path], force=is_replacing)
    return findings


def _require_finite(data: Mesh | PointCloud, path: Path) -> None:
    points = data.vertices if isinstance(data, Mesh) else data.points
    # Processed by column, which is many times faster than processing rows of three values.
    invalid_rows = np.flatnonzero(
        ~np.logical_and.reduce([np.isfinite(column) for column in points.T])
    )
    if len(invalid_rows):
        raise GeometryError(
            Finding("model.not-finite", count=len(invalid_rows), first_row=invalid_rows[0]),
            file=path,
        )
