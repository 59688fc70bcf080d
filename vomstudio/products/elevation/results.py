"""Figures and files of an elevation model."""

from __future__ import annotations

from dataclasses import dataclass, field

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.results import FLATTENED_IN_JSON, Result


@dataclass(frozen=True, eq=False)
class ElevationFigures(Result):
    """Figures of an elevation model.

    Parameters
    ----------
    width, height : int
        Number of columns and rows of cells.
    gsd_m : float
        Cell size.
    coverage : float
        Share of the cells that have a height.
    reference_point : (3,) array
        Centre of the model's bounds in the World frame. Heights are Z over a horizontal plane,
        otherwise they are measured from the plane through this point.
    dip_direction_deg, dip_deg : float
        Orientation of the reference plane.
    right, down, normal : (3,) arrays
        Unit vectors along rows, columns and heights, in the World frame.
    lowest_m, highest_m : float
        Minimum and maximum height.
    interpolation_limit_m : float or None
        Maximum side of the triangles between points of a cloud; None for a mesh.
    cell_to_world : (4, 4) array
        Matrix from (column, row, height, 1) to the World frame.
    crs : str or None
        CRS if the model is a map; None over other planes, or if unknown.
    """

    width: int
    height: int
    gsd_m: float
    coverage: float
    reference_point: FloatArray
    dip_direction_deg: float
    dip_deg: float
    right: FloatArray
    down: FloatArray
    normal: FloatArray
    lowest_m: float
    highest_m: float
    interpolation_limit_m: float | None
    cell_to_world: FloatArray
    crs: str | None


@dataclass(frozen=True)
class WrittenElevation(Result):
    """Files of an elevation model (None if not requested), with its figures and warnings."""

    raster: str
    figures: ElevationFigures = field(metadata=FLATTENED_IN_JSON)
    sidecar: str
    hillshade: str | None
    slope: str | None
    aspect: str | None
    contours: str | None
    warnings: tuple[Finding, ...]
