"""What a format's writer is, and what it is given."""

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
class Outgoing:
    """What is to be written.

    data : in World, of whose x, y and z is known what `axes` says; crs : "EPSG:n", WKT, or None
    force : whether files that are there may be replaced, save `inputs`, which the model was read
        from
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
    """One format.

    extensions : lower case, with the dot
    write : everything whole or nothing at all; returns one sentence for each thing that the format
        cannot hold or that had to be changed. Raises TargetError, or Cancelled through the progress
    """

    name: str
    extensions: tuple[str, ...]
    write: Callable[[Outgoing], list[Finding]]
