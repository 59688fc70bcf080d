"""What `vomstudio facets` and `vs.facets` tell of a model's facets."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from vomstudio.core.arrays import Int32Array
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import PrintableResult
from vomstudio.core.results import HIDDEN
from vomstudio.extraction.facet_options import FacetOptions
from vomstudio.extraction.facets import Facets
from vomstudio.geology.sets.discontinuities import Discontinuity
from vomstudio.geology.sets.proposals import DescribedSet
from vomstudio.io.text.set_columns import DISCONTINUITY
from vomstudio.project.tables.orientation_table import Row, plane_row

WKT = "wkt"
"""The column of the border, behind those of the orientation table."""


@dataclass(frozen=True, eq=False, repr=False)
class FacetTable(PrintableResult):
    """Facets of a model and what of it they cover.

    facets : how many; rows : of the orientation table with `wkt`, the border in World; the id of a
        row is the facet's label
    coverage : share of the model's area that lies in facets; near_planar_share : of the exposed
        rock's, without vegetation and debris; level_share : of it in facets that dip by less than
        10 degrees, which may be ground; None where there is none
    sets, discontinuities : as `vomstudio sets` tells them, where they were asked for
    facet, set_of : (points,) int32 of each point or vertex of the model, -1 for none
    area_m2, vegetation_share, debris_share : of the whole model
    angle_deg, max_distance_m (median), min_points, min_area_m2 : by which they were found
    """

    facets: int
    rows: list[Row] = field(metadata=HIDDEN)
    coverage: float | None
    near_planar_share: float | None
    level_share: float | None
    sets: tuple[DescribedSet, ...]
    discontinuities: tuple[Discontinuity, ...]
    facet: Int32Array = field(metadata=HIDDEN)
    set_of: Int32Array = field(metadata=HIDDEN)
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
        """Columns of the rows beyond those of the orientation table."""
        return (DISCONTINUITY, WKT) if self.sets else (WKT,)

    @property
    def labels(self) -> dict[str, Int32Array]:
        """Fields of the model's points: `facet` and `set`, -1 for none."""
        return {"facet": self.facet, "set": self.set_of}


def facet_table(found: Facets, options: FacetOptions, *, model: str, frame: str) -> FacetTable:
    """model : its name; frame : what azimuths count from, as the table says it"""
    rows = [
        {
            **plane_row(
                facet.fit,
                facet.verdict,
                id=str(number),
                area_m2=facet.area,
                resolution_m=facet.resolution,
                judged_as="patch",
                bend_deg=facet.bend_deg,
                model=model,
                frame=frame,
            ),
            WKT: facet.border,
        }
        for number, facet in enumerate(found.facets)
    ]
    seen = found.exposure
    return FacetTable(
        facets=len(rows),
        rows=rows,
        coverage=seen.coverage,
        near_planar_share=seen.near_planar_share,
        level_share=seen.level_share,
        sets=(),
        discontinuities=(),
        facet=found.labels,
        set_of=np.full(len(found.labels), -1, np.int32),
        area_m2=seen.area_m2,
        vegetation_share=seen.vegetation_share,
        debris_share=seen.debris_share,
        angle_deg=options.used_angle_deg,
        max_distance_m=found.reach,
        min_points=found.min_points,
        min_area_m2=options.min_area_m2,
        warnings=found.warnings,
    )
