"""Interface of format writers, and their request."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.units import WORLD_AXES, Axes


@dataclass(frozen=True)
class WriteRequest:
    """Request to write a model.

    Attributes
    ----------
    data : Mesh or PointCloud
        Geometry in the World frame, or in model units if `axes` states so.
    crs : str or None
        "EPSG:n" or WKT, or None if there is no CRS.
    force : bool
        Whether existing files may be replaced, except `inputs`, from which the model was read.
    """

    data: Mesh | PointCloud
    crs: str | None
    path: Path
    force: bool
    progress: Progress
    inputs: tuple[Path, ...] = ()
    axes: Axes = WORLD_AXES


@dataclass(frozen=True)
class Writer:
    """Writer of one format.

    Attributes
    ----------
    extensions : tuple of str
        File extensions in lower case, including the dot.
    write : callable
        Function that writes either everything or nothing, and returns findings about data that the
        format cannot store or that were changed. Raises TargetError, or Cancelled through the
        progress.
    """

    name: str
    extensions: tuple[str, ...]
    write: Callable[[WriteRequest], list[Finding]]
