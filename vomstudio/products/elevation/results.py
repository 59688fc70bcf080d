"""Figures and files of an elevation model."""

from __future__ import annotations

from dataclasses import dataclass, field

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.results import FLAT, Result


@dataclass(frozen=True, eq=False)
class ElevationFigures(Result):
    """Figures of an elevation model.

    Parameters
    ----------
    width, height : int
        Numbers of cells.
    gsd_m : float
        Side of a cell.
    coverage : float
        Share of cells with a height.
    reference_point : (3,) array
        Centre of the model's bounds, World. Heights are Z over the horizontal, else above the plane
        through this point.
    dip_direction_deg, dip_deg : float
        Plane of reference.
    right, down, normal : (3,) arrays
        Unit vectors along columns, rows and heights, World.
    lowest_m, highest_m : float
    interpolation_limit_m : float or None
        Maximum side of triangles between points of a cloud; None for a mesh.
    cell_to_world : (4, 4) array
        From (column, row, height, 1) to World.
    crs : str or None
        CRS of a map; None over other planes, and if unknown.
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
    """Written files of an elevation model (None if not requested), its figures and warnings."""

    raster: str
    figures: ElevationFigures = field(metadata=FLAT)
    sidecar: str
    hillshade: str | None
    slope: str | None
    aspect: str | None
    contours: str | None
    warnings: tuple[Finding, ...]
