"""Elevation models over horizontal, vertical and inclined planes."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from vomstudio.api.checking import check_flag, to_path
from vomstudio.api.declared_options import arguments_named, options_from_arguments
from vomstudio.api.models import Mesh, PointCloud, to_model
from vomstudio.api.planes import plane_text
from vomstudio.api.reporting import Reported, to_progress
from vomstudio.core.arrays import ByteArray, Float32Array
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import html_table, text_table
from vomstudio.core.results import HIDDEN
from vomstudio.geology.notation import format_azimuth
from vomstudio.products.elevation.dem_options import DemFiles, DemOptions
from vomstudio.products.elevation.heights import draw_heights
from vomstudio.products.elevation.planning import HeightPlan, plan_heights, reference_plane
from vomstudio.products.elevation.results import ElevationFigures, WrittenElevation
from vomstudio.products.elevation.shading import compute_dips, hillshade
from vomstudio.products.elevation.writing import figures_of, write_elevation


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class ElevationModel(ElevationFigures):
    """Heights of a surface above a reference plane.

    Attributes
    ----------
    heights
        (h, w) float32, metres along the plane's upward normal: Z of World over the
        horizontal, else above ``reference_point``; NaN if the surface is missing. Rows run
        down the plane's dip, from North to South over the horizontal.
    width, height
        Cells.
    gsd_m
        Side of a cell.
    coverage
        Share of cells with a height.
    reference_point
        (3,) World, the centre of the model's bounds.
    dip_direction_deg, dip_deg
        Attitude of the reference plane.
    right, down, normal
        (3,) unit vectors of World along the columns, the rows and the heights.
    lowest_m, highest_m
        Heights.
    interpolation_limit_m
        Longest side of triangles between the points of a cloud, None for a mesh.
    cell_to_world
        (4, 4), (column, row, height, 1) to World; (0, 0) is the outer corner of the top
        left cell, its centre (0.5, 0.5).
    crs
        CRS of heights above the horizontal; None above any other plane.
    warnings
        Findings.

    Examples
    --------
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
        """Return the dip of the surface from the horizontal of World, degrees, (h, w).

        Horn's gradients over eight neighbours, NaN if one is missing.
        """
        return compute_dips(self.heights, self.gsd_m, self._plan.frame)[0]

    def aspect(self) -> Float32Array:
        """Return the dip direction of the surface (h, w), degrees; NaN if level or unknown."""
        return compute_dips(self.heights, self.gsd_m, self._plan.frame)[1]

    def hillshade(self) -> ByteArray:
        """Return the hillshade (h, w), 1 to 255, 0 if unknown.

        The light comes from the upper left, 45 degrees above the plane.
        """
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
        """Write NAME.tif and NAME.json, and the requested additional files.

        These are NAME_hillshade.tif, NAME_slope.tif, NAME_aspect.tif and NAME_contours.gpkg
        (lines at intervals of `contours_m`).

        Returns
        -------
        WrittenElevation
            Result as the command prints it.

        Raises
        ------
        vs.errors.UsageError, vs.errors.TargetError
        """
        file = to_path(path, "path")
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
            force=check_flag(force, "force"),
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
    """Compute heights of a model above a reference plane.

    Parameters
    ----------
    model : Mesh, PointCloud, model of a project, path, or (n, 3) array
        Model in World, metres.
    gsd_m : float, optional
        Side of a cell; by default the mean edge of a mesh or the mean spacing of a cloud.
    plane : str, (float, float) or PlaneFit, optional
        Reference plane, "DD/D", (dip direction, dip) or a PlaneFit; by default horizontal.
    limit_m : float, optional
        For a cloud, the maximum side of triangles between its points; by default five times
        the root of the mean area per point.
    progress : callable or Progress, optional
        Called with (stage, steps done, all steps or None).

    Returns
    -------
    ElevationModel
        ``heights``, ``cell_to_world``, ``coverage`` and the figures of the command;
        ``.save(path)`` writes its files.

    Raises
    ------
    vs.errors.UsageError
        For a limit with a mesh, and for a grid that is too large.
    vs.errors.InputError
        If the model has no surface over this plane.

    Notes
    -----
    Each cell has the height of the surface at its centre, the farthest along the normal if
    there are several. A cloud is triangulated over the plane (Delaunay).

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
    report = to_progress(progress)
    data = to_model(model)
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
