"""Interface of format readers, and the model that they return."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from vomstudio.core.findings import Finding
from vomstudio.core.progress import Progress
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.io.gis.axis_units import UNKNOWN_UNITS, Units

HEAD_BYTES = 4096
"""Number of bytes at the beginning of a file with which its format is detected."""


@dataclass(frozen=True, eq=False)
class LoadedModel:
    """Content of a model file.

    Attributes
    ----------
    data : Mesh or PointCloud
        Geometry in the frame of the file.
    kind : str
        "mesh" or "cloud".
    crs : str or None
        "EPSG:n" or WKT; None if the file does not state a CRS. A reader returns the CRS that the
        file states, and `read_model` a CRS in which the model can be used.
    warnings : tuple of Finding
        Findings about data that were wrong, skipped or guessed.
    path : Path
    content_hash : str
        SHA-256 of the file in hex (for an OBJ file, without its MTL and images). A reader may leave
        it empty because `read_model` sets it.
    turned_about : tuple of float or None
        For formats with y up, the point in the frame of `data` about which the reader has rotated
        the model upright.
    resolution : float or None
        Result of `vomstudio.io.models.opening.resolution`, if known.
    height_unit : str or None
        Unit of heights that the file states separately from the CRS, as a key of
        `vomstudio.geometry.units.METRES_PER_UNIT`.
    units : tuple of str
        Units of x, y and z stated by the file. `read_model` sets them; a reader does so only if its
        format defines them.
    unit_m : float or None
        Metres per unit of `data` on all three axes; None if unknown.
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
    units: Units = UNKNOWN_UNITS
    unit_m: float | None = None


@dataclass(frozen=True)
class Reference:
    """Coordinate reference that a file stores apart from its points.

    `text` is the CRS as written in the file or as named by its keys; `height_unit` as for
    LoadedModel.
    """

    text: str | None = None
    height_unit: str | None = None
    warnings: tuple[Finding, ...] = ()


@dataclass(frozen=True)
class Reader:
    """Reader of one format.

    Attributes
    ----------
    name : str
        Display name.
    extensions : tuple of str
        File extensions in lower case, including the dot.
    matches : callable
        Function of the path and the first bytes (up to `HEAD_BYTES`) that returns whether the
        *content* is certainly of this format, regardless of the extension.
    read : callable
        Function that reads a file; raises InputError if it is unreadable, and Cancelled through the
        progress.
    """

    name: str
    extensions: tuple[str, ...]
    matches: Callable[[Path, bytes], bool]
    read: Callable[[Path, Progress], LoadedModel]
