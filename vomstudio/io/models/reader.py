"""Interface of a format's reader, and the model that it returns."""

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
"""Bytes at a file's beginning by which its format is detected."""


@dataclass(frozen=True, eq=False)
class LoadedModel:
    """Content of a model file.

    Attributes
    ----------
    data : Mesh or PointCloud
        In the file's frame.
    kind : str
        "mesh" or "cloud".
    crs : str or None
        "EPSG:n" or WKT; None if the file does not state one. A reader returns what the file states,
        `read_model` a CRS in which the model can be used.
    warnings : tuple of Finding
        What was wrong, skipped or guessed.
    path : Path
    content_hash : str
        SHA-256 of the file in hex (of an OBJ without its MTL and images). A reader may leave it
        empty; `read_model` sets it.
    turned_about : tuple of float or None
        For formats with y up, the point of `data`'s frame about which the reader has rotated the
        model upright.
    resolution : float or None
        Result of `vomstudio.io.models.opening.resolution`, if known.
    height_unit : str or None
        Unit of heights that the file states apart from the CRS, a name of
        `vomstudio.geometry.units.METRES`.
    units : tuple of str
        Units of x, y and z that the file states. `read_model` sets it, a reader only if its format
        defines them.
    unit_m : float or None
        Metres per unit of `data`, in all three axes; None if unknown.
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
    """Reference of the coordinates that a file states apart from its points.

    `text` is the CRS as written there or as its keys are named; `height_unit` as in LoadedModel.
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
        Name for the user.
    extensions : tuple of str
        Lower case, with the dot.
    matches : callable
        Returns, from the path and at most `HEAD_BYTES` first bytes, whether the *content* is
        certainly of this format, whatever the extension is.
    read : callable
        Raises InputError for unreadable files, and Cancelled through the progress.
    """

    name: str
    extensions: tuple[str, ...]
    matches: Callable[[Path, bytes], bool]
    read: Callable[[Path, Progress], LoadedModel]
