"""Elevation models over horizontal, vertical and slanting planes."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.api.checking import flag, path_of
from vomstudio.api.declared_options import arguments_named, options_from_arguments
from vomstudio.api.models import Mesh, PointCloud, model_of
from vomstudio.api.planes import plane_text
from vomstudio.api.reporting import Reported, told
from vomstudio.core.arrays import ByteArray, Float32Array
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import html_table, text_table
from vomstudio.core.results import HIDDEN
from vomstudio.geology.notation import format_azimuth
from vomstudio.products.elevation.dem_options import DemFiles, DemOptions
from vomstudio.products.elevation.heights import draw_heights
from vomstudio.products.elevation.planning import HeightPlan, plan_heights, reference_plane
from vomstudio.products.elevation.results import ElevationFigures, WrittenElevation
from vomstudio.products.elevation.shading import dips_of, hillshade
from vomstudio.products.elevation.writing import figures_of, write_elevation


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class ElevationModel(ElevationFigures):
    """Heights of a surface above a reference plane.

    heights : (h, w) float32, metres along the plane's upward normal: Z of World over the
        horizontal, else above ``reference_point``; NaN where the surface is missing. Rows run down
        the plane's dip, from North to South over the horizontal
    width, height : cells; gsd_m : side of a cell; coverage : share of cells with a height
    reference_point : (3,) World, the centre of the model's bounds
    dip_direction_deg, dip_deg : attitude of the reference plane
    right, down, normal : (3,) unit vectors of World along the columns, the rows and the heights
    lowest_m, highest_m : heights; interpolation_limit_m : longest side of triangles between the
        points of a cloud, None for a mesh
    cell_to_world : (4, 4), (column, row, height, 1) to World; (0, 0) is the outer corner of the
        top left cell, its centre (0.5, 0.5)
    crs : CRS of heights above the horizontal; None above any other plane
    warnings : findings

    >>> import vomstudio as vs
    >>> model = vs.dem(vs.sample("sample.obj"), gsd_m=0.5)
    >>> column, row = 10, 12
    >>> x, y, z, _ = model.cell_to_world @ [column + 0.5, row + 0.5, model.heights[row, column], 1]
    >>> bool(z == model.heights[row, column])
    True
    """

    heights: Float32Array = field(metadata=HIDDEN)
    warnings: tuple[Finding, ...]
    _model: Mesh | PointCloud = field(metadata=HIDDEN)
    _plan: HeightPlan = field(metadata=HIDDEN)

    def slope(self) -> Float32Array:
        """(h, w) dip of the surface from the horizontal of World, degrees; Horn's gradients over
        eight neighbours, NaN where one is missing."""
        return dips_of(self.heights, self.gsd_m, self._plan.frame)[0]

    def aspect(self) -> Float32Array:
        """(h, w) dip direction of the surface, degrees; NaN where it is level or unknown."""
        return dips_of(self.heights, self.gsd_m, self._plan.frame)[1]

    def hillshade(self) -> ByteArray:
        """(h, w) from 1 to 255, 0 where it is not known; light from the upper left, 45 degrees
        above the plane."""
        return hillshade(self.heights, self.gsd_m)

    def save(
        self,
        path: str | Path,
        *,
        hillshade: bool = False,
        slope: bool = False,
        aspect: bool = False,
        contours_m: float | None = None,
        force: bool = False,
    ) -> WrittenElevation:
        """Write NAME.tif and NAME.json, and beside them NAME_hillshade.tif, NAME_slope.tif,
        NAME_aspect.tif, NAME_contours.gpkg (lines every so many metres) where they are wanted.

        Returns what the command prints. Raises vs.errors.UsageError, vs.errors.TargetError.
        """
        file = path_of(path, "path")
        files = options_from_arguments(
            DemFiles, hillshade=hillshade, slope=slope, aspect=aspect, contours_m=contours_m
        )
        source = self._model._source
        return write_elevation(
            self.heights,
            self._plan,
            self,
            file,
            files=files,
            world=source.world_crs,
            north_known=source.placed,
            model=str(source.path),
            content_hash=source.content_hash,
            warnings=self.warnings,
            force=flag(force, "force"),
        )

    def _named(self) -> dict[str, Any]:
        azimuth = format_azimuth(self.dip_direction_deg, 1)
        return {
            "cells": f"{self.width} x {self.height} of {self.gsd_m:g} m",
            "plane": f"{azimuth}/{self.dip_deg:.1f} dip direction/dip",
            "heights": f"{self.lowest_m:.3f} to {self.highest_m:.3f} m",
            "coverage": f"{100 * self.coverage:.0f} %",
            "crs": self.crs,
            "warnings": self.warnings or None,
        }

    def __repr__(self) -> str:
        return text_table("ElevationModel", self._named())

    def _repr_html_(self) -> str:
        return html_table("ElevationModel", self._named())


def dem(
    model: Any,
    *,
    gsd_m: float | None = None,
    plane: Any = None,
    limit_m: float | None = None,
    progress: Reported = None,
) -> ElevationModel:
    """Heights of a model over a plane of reference.

    Parameters
    ----------
    model : Mesh, PointCloud, a model of a project, or the path of a file
    gsd_m : side of a cell; None takes the mean edge of a mesh, the mean spacing of a cloud
    plane : of reference: "DD/D", (dip direction, dip) or a PlaneFit; None is the horizontal
    limit_m : of a cloud: the longest side of triangles between its points; None takes five times
        the root of the area that a point has to itself
    progress : called with (stage, steps done, all steps or None), or a Progress

    Returns
    -------
    ElevationModel: ``heights``, ``cell_to_world``, ``coverage`` and the figures of the command;
    ``.save(path)`` writes its files.

    Raises
    ------
    vs.errors.UsageError for a limit with a mesh and a grid that is too large;
    vs.errors.InputError for a model without a surface over this plane.

    Each cell has the height of the surface at its centre; of several sheets the farthest along the
    normal wins. A cloud is triangulated over the plane (Delaunay).

    Examples
    --------
    >>> import vomstudio as vs
    >>> model = vs.dem(vs.sample("sample.obj"), plane="200/80", gsd_m=0.5)
    >>> model.heights.shape == (model.height, model.width)
    True
    """
    options = options_from_arguments(
        DemOptions, gsd_m=gsd_m, plane=plane_text(plane), limit_m=limit_m
    )
    report = told(progress)
    data = model_of(model)
    source = data._source
    with arguments_named(DemOptions):
        plan = plan_heights(
            data._data,
            reference_plane(options.plane),
            to_world=np.eye(4),
            gsd=options.gsd_m,
            metric=source.metric or source.placed,
        )
        heights, limit = draw_heights(data._data, plan, options.limit_m, report)
    figures = figures_of(heights, plan, limit, source.world_crs)
    return ElevationModel(
        **vars(figures), heights=heights, warnings=plan.notes, _model=data, _plan=plan
    )
