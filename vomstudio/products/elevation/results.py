"""Figures and files of an elevation model."""

from __future__ import annotations

from dataclasses import dataclass, field

from vomstudio.core.arrays import FloatArray
from vomstudio.core.findings import Finding
from vomstudio.core.results import FLAT, Result


@dataclass(frozen=True, eq=False)
class ElevationFigures(Result):
    """What is said of an elevation model.

    width, height : cells; gsd_m : side of a cell; coverage : share of cells with a height
    reference_point : (3,) World, the centre of the model's bounds; heights are Z over the
        horizontal, else above the plane through it
    dip_direction_deg, dip_deg : of the plane of reference
    right, down, normal : (3,) unit vectors of World along the columns, the rows and the heights
    lowest_m, highest_m : heights; interpolation_limit_m : longest side of triangles between the
        points of a cloud, None for a mesh
    cell_to_world : 4 x 4, (column, row, height, 1) to World
    crs : of a map; None over any other plane, and where it is not known
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
    """raster, sidecar, hillshade, slope, aspect, contours : files that were written, None for those
    that were not; figures : of the model; warnings : sentences"""

    raster: str
    figures: ElevationFigures = field(metadata=FLAT)
    sidecar: str
    hillshade: str | None
    slope: str | None
    aspect: str | None
    contours: str | None
    warnings: tuple[Finding, ...]
