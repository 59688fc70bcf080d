"""Table of facets and their coverage, the result of `vomstudio facets` and `vs.facets`."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from vomstudio.core.arrays import Int32Array
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.results import HIDDEN_IN_JSON
from vomstudio.extraction.facet_options import FacetOptions
from vomstudio.extraction.facets import FacetSegmentation
from vomstudio.geology.sets.discontinuities import Discontinuity
from vomstudio.geology.sets.proposals import DescribedSet
from vomstudio.io.text.set_columns import DISCONTINUITY
from vomstudio.project.tables.orientation_table import Row, plane_row

WKT_COLUMN = "wkt"
"""Column for the boundary, placed after the columns of the orientation table."""


@dataclass(frozen=True, eq=False, repr=False)
class FacetTable(PrintableResult):
    """Facets of a model, and the share of the model that they cover.

    Parameters
    ----------
    facets : int
        Number of facets.
    rows : list of dict
        Rows of the orientation table with the boundary in the World frame (`wkt`); `id` is the
        label of the facet.
    coverage : float or None
        Share of the area of the model that belongs to facets.
    near_planar_share : float or None
        Share of the exposed rock (without vegetation and debris) in facets that are large relative
        to the resolution.
    level_share : float or None
        Share of the exposed rock in large facets that dip less than 10 degrees and may be level
        ground.
    sets, discontinuities : tuple
        Sets and discontinuities as in `vomstudio sets`, if requested.
    facet, set_of : (points,) int32 arrays
        Facet and set of each point or vertex of the model; -1 for none.
    area_m2, vegetation_share, debris_share : float
        Area and shares of the whole model.
    angle_deg, max_distance_m, min_points, min_area_m2
        Thresholds that were used; the distance is a median.
    warnings : tuple of Finding
    """

    facets: int
    rows: list[Row] = field(metadata=HIDDEN_IN_JSON)
    coverage: float | None
    near_planar_share: float | None
    level_share: float | None
    sets: tuple[DescribedSet, ...]
    discontinuities: tuple[Discontinuity, ...]
    facet: Int32Array = field(metadata=HIDDEN_IN_JSON)
    set_of: Int32Array = field(metadata=HIDDEN_IN_JSON)
    area_m2: float
    vegetation_share: float
    debris_share: float
    angle_deg: float
    max_distance_m: float
    min_points: int
    min_area_m2: float | None
    warnings: tuple[Finding, ...]

    @property
    def more(self) -> tuple[str, ...]:
        """Columns of the rows in addition to those of the orientation table."""
        return (DISCONTINUITY, WKT_COLUMN) if self.sets else (WKT_COLUMN,)

    @property
    def labels(self) -> dict[str, Int32Array]:
        """Fields `facet` and `set` for the points of the model; -1 for none."""
        return {"facet": self.facet, "set": self.set_of}


def tabulate_facets(
    facets: FacetSegmentation, options: FacetOptions, *, model: str, frame: str
) -> FacetTable:
    """Convert facets to a table.

    Parameters
    ----------
    facets : FacetSegmentation
    options : FacetOptions
    model : str
        Name of the model.
    frame : str
        Reference direction of azimuths, as in the orientation table.

    Returns
    -------
    FacetTable
    """
    rows = [
        {
            **plane_row(
                facet.fit,
                facet.verdict,
                id=str(number),
                area_m2=facet.area,
                resolution_m=facet.resolution,
                verdict_kind="patch",
                bend_deg=facet.bend_deg,
                model=model,
                frame=frame,
            ),
            WKT_COLUMN: facet.border,
        }
        for number, facet in enumerate(facets.facets)
    ]
    exposure = facets.exposure
    return FacetTable(
        facets=len(rows),
        rows=rows,
        coverage=exposure.coverage,
        near_planar_share=exposure.near_planar_share,
        level_share=exposure.level_share,
        sets=(),
        discontinuities=(),
        facet=facets.labels,
        set_of=np.full(len(facets.labels), -1, np.int32),
        area_m2=exposure.area_m2,
        vegetation_share=exposure.vegetation_share,
        debris_share=exposure.debris_share,
        angle_deg=options.used_angle_deg,
        max_distance_m=facets.max_distance,
        min_points=facets.min_points,
        min_area_m2=options.min_area_m2,
        warnings=facets.warnings,
    )
