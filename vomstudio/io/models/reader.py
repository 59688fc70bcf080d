"""What a format's reader is, and what it gives."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.gis.axis_units import UNKNOWN, Units

HEAD_BYTES = 4096
"""Of a file's beginning, by which its format is told."""


@dataclass(frozen=True, eq=False)
class LoadedModel:
    """What a file held.

    data : in the file's own frame
    kind : "mesh" or "cloud"
    crs : "EPSG:n", a WKT text, or None where the file names none; a reader gives what the file
        says, `read_model` what the model can be kept in
    warnings : one sentence for each thing that was wrong, left out or guessed
    path : the file
    content_hash : sha256 of the file itself in hex (of an OBJ: without its MTL and images); a
        reader may leave it empty, `read_model` fills it
    turned_about : where the format says that Y is up and the reader has therefore turned the model
        upright, the point of `data`'s frame about which it did; else None
    resolution : as `vomstudio.io.models.opening.resolution` tells it, where it is known; else None
    height_unit : what the file says of its heights beside the CRS, a name of
        `vomstudio.geometry.units.METRES`; else None
    units : of x, y and z as the file states them; `read_model` fills it, and a reader only where
        its format lays them down
    unit_m : metres in a unit of `data`, in all three axes; None where it is unknown
    """

    data: Mesh | PointCloud
    kind: Literal["mesh", "cloud"]
    crs: str | None
    warnings: tuple[Finding, ...]
    path: Path
    content_hash: str = ""
    turned_about: tuple[float, float, float] | None = None
    resolution: float | None = None
    height_unit: str | None = None
    units: Units = UNKNOWN
    unit_m: float | None = None


@dataclass(frozen=True)
class Reference:
    """What a file says of its coordinates, beside its points.

    text : of the CRS, as it stands there or as its keys are named; height_unit : as LoadedModel's
    """

    text: str | None = None
    height_unit: str | None = None
    warnings: tuple[Finding, ...] = ()


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
