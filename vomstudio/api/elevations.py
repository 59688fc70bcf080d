"""Elevation models over horizontal, vertical and inclined planes."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vomstudio.api.checking import check_flag, to_path, warn
from vomstudio.api.declared_options import name_arguments_in_errors, options_from_arguments
from vomstudio.api.models import Mesh, PointCloud, to_model
from vomstudio.api.planes import plane_text
from vomstudio.api.reporting import ProgressArgument, to_progress
from vomstudio.core.arrays import ByteArray, Float32Array
from vomstudio.core.findings import Finding
from vomstudio.core.reprs import html_table, text_table
from vomstudio.core.results import HIDDEN_IN_JSON
from vomstudio.geology.notation import format_azimuth
from vomstudio.products.elevation.dem_options import DemFiles, DemOptions
from vomstudio.products.elevation.heights import compute_heights
from vomstudio.products.elevation.planning import HeightPlan, parse_reference_plane, plan_heights
from vomstudio.products.elevation.results import ElevationFigures, WrittenElevation
from vomstudio.products.elevation.shading import compute_dips, hillshade
from vomstudio.products.elevation.writing import elevation_figures, write_elevation

if TYPE_CHECKING:
    from vomstudio.api.argument_types import ModelArgument, PlaneArgument


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class ElevationModel(ElevationFigures):
    """Heights of a surface above a reference plane.

    Attributes
    ----------
    heights
        (h, w) float32 heights along the upward normal of the plane, metres: World Z for a
        horizontal plane, otherwise height above ``reference_point``; NaN if there is no
        surface. Rows run down the dip of the plane, or from north to south if it is
        horizontal.
    width, height
        Size of the grid, cells.
    gsd_m
        Side length of a cell, metres.
    coverage
        Share of the cells that have a height.
    reference_point
        (3,) centre of the bounding box of the model in the World frame.
    dip_direction_deg, dip_deg
        Attitude of the reference plane.
    right, down, normal
        (3,) unit vectors in the World frame along the column, row and height axes.
    lowest_m, highest_m
        Minimum and maximum heights, metres.
    interpolation_limit_m
        Maximum side length of triangles between the points of a cloud, or None for a mesh.
    cell_to_world
        (4, 4) matrix that transforms (column, row, height, 1) to the World frame. (0, 0) is
        the outer corner of the top-left cell, and (0.5, 0.5) is its centre.
    crs
        CRS if the reference plane is horizontal, otherwise None.
    warnings
        Findings about the model and the heights.

    Examples
    --------
    >>> import vomstudio as vs
    >>> model = vs.dem(vs.sample("sample.obj"), gsd_m=0.5)
    >>> column, row = 10, 12
    >>> x, y, z, _ = model.cell_to_world @ [column + 0.5, row + 0.5, model.heights[row, column], 1]
    >>> bool(z == model.heights[row, column])
    True
    """

    heights: Float32Array = field(metadata=HIDDEN_IN_JSON)
    warnings: tuple[Finding, ...]
    _model: Mesh | PointCloud = field(metadata=HIDDEN_IN_JSON)
    _plan: HeightPlan = field(metadata=HIDDEN_IN_JSON)

    def slope(self) -> Float32Array:
        """Return the dip (h, w) of the surface from the World horizontal, degrees.

        Gradients follow Horn's method with eight neighbours; NaN if a neighbour is missing.
        """
        return compute_dips(self.heights, self.gsd_m, self._plan.frame)[0]

    def aspect(self) -> Float32Array:
        """Return the dip direction (h, w) of the surface, degrees; NaN if level or unknown."""
        return compute_dips(self.heights, self.gsd_m, self._plan.frame)[1]

    def hillshade(self) -> ByteArray:
        """Return the hillshade (h, w) as values from 1 to 255, or 0 if unknown.

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
        """Write NAME.tif, NAME.json and the requested additional files.

        The additional files are NAME_hillshade.tif, NAME_slope.tif, NAME_aspect.tif and
        NAME_contours.gpkg (lines at intervals of `contours_m`).

        Parameters
        ----------
        path : str or Path
            Path of NAME.tif.
        hillshade, slope, aspect : bool, optional
            Whether to write these files.
        contours_m : float, optional
            Interval of the contours, metres. If None, no contours are written.
        force : bool, optional
            Whether to replace existing files.

        Returns
        -------
        WrittenElevation
            Result as the command prints it.

        Raises
        ------
        vs.errors.UsageError
            If the suffix is not .tif or the interval is invalid.
        vs.errors.TargetError
            If a file exists or cannot be written.
        """
        file = to_path(path, "path")
        files = options_from_arguments(DemFiles, locals())
        source = self._model._source
        return write_elevation(
            self.heights,
            self._plan,
            self,
            file,
            files=files,
            world=source.world_crs,
            is_north_known=source.is_placed,
            model=str(source.path),
            content_hash=source.content_hash,
            warnings=self.warnings,
            force=check_flag(force, "force"),
        )

    def _repr_values(self) -> dict[str, Any]:
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
        return text_table("ElevationModel", self._repr_values())

    def _repr_html_(self) -> str:
        return html_table("ElevationModel", self._repr_values())


def dem(
    model: ModelArgument,
    *,
    gsd_m: float | None = None,
    plane: PlaneArgument | None = None,
    limit_m: float | None = None,
    progress: ProgressArgument = None,
) -> ElevationModel:
    """Compute the heights of a model above a reference plane.

    Parameters
    ----------
    model : Mesh, PointCloud, model of a project, path, or (n, 3) array
        Model in the World frame, metres.
    gsd_m : float, optional
        Side length of a cell, metres; by default the mean edge length of a mesh or the mean
        spacing of a cloud.
    plane : str, (float, float) or PlaneFit, optional
        Reference plane, "DD/D", (dip direction, dip) or a PlaneFit; by default horizontal.
    limit_m : float, optional
        Maximum side length of triangles between the points of a cloud, metres; by default
        five times the square root of the mean area per point.
    progress : callable or Progress, optional
        Called with (stage, completed steps, total steps or None).

    Returns
    -------
    ElevationModel
        ``heights``, ``cell_to_world``, ``coverage`` and the other figures of the command;
        ``.save(path)`` writes its files.

    Raises
    ------
    vs.errors.UsageError
        If a limit is given for a mesh, or the grid is too large.
    vs.errors.InputError
        If the model has no surface over this plane.

    Notes
    -----
    Each cell contains the height of the surface at its centre, or the maximum height along the
    normal if there are several surfaces. A cloud is triangulated over the plane (Delaunay).

    Examples
    --------
    >>> import vomstudio as vs
    >>> model = vs.dem(vs.sample("sample.obj"), plane="200/80", gsd_m=0.5)
    >>> model.heights.shape == (model.height, model.width)
    True
    """
    options = options_from_arguments(DemOptions, locals(), plane=plane_text(plane))
    report = to_progress(progress)
    data = to_model(model)
    source = data._source
    with name_arguments_in_errors(DemOptions):
        plan = plan_heights(
            data._data,
            parse_reference_plane(options.plane),
            to_world=np.eye(4),
            gsd=options.gsd_m,
            is_metric=source.is_metric or source.is_placed,
        )
        heights, limit = compute_heights(data._data, plan, options.limit_m, report)
    figures = elevation_figures(heights, plan, limit, source.world_crs)
    warn(plan.notes)
    return ElevationModel(
        **vars(figures), heights=heights, warnings=plan.notes, _model=data, _plan=plan
    )
