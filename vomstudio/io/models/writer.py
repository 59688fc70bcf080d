"""Interface of a format's writer, and its request."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.units import WORLD, Axes


@dataclass(frozen=True)
class WriteRequest:
    """Request to write a model.

    Attributes
    ----------
    data : Mesh or PointCloud
        In World, with the properties of `axes`.
    crs : str or None
        "EPSG:n", WKT, or None.
    force : bool
        Whether existing files may be replaced, except `inputs`, from which the model was read.
    """

    data: Mesh | PointCloud
    crs: str | None
    path: Path
    force: bool
    progress: Progress
    inputs: tuple[Path, ...] = ()
    axes: Axes = WORLD


@dataclass(frozen=True)
class Writer:
    """Writer of one format.

    Attributes
    ----------
    extensions : tuple of str
        Lower case, with the dot.
    write : callable
        Writes everything or nothing, and returns findings about what the format cannot store or
        what was changed. Raises TargetError, or Cancelled through the progress.
    """

    name: str
    extensions: tuple[str, ...]
    write: Callable[[WriteRequest], list[Finding]]
