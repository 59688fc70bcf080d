"""Requests for and results of orthophotos, as in `vomstudio ortho`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError, UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.results import FLATTENED_IN_JSON, Result
from vomstudio.core.words import tr
from vomstudio.geology.domains import ProjectionAxis
from vomstudio.geology.fold_planes import ExcludedRows
from vomstudio.geology.folding.figures import BetaFigures
from vomstudio.geology.notation import parse_plane_option
from vomstudio.geology.table_folds import TableFold
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.products.ortho.domain_axes import compute_domain_axes
from vomstudio.products.ortho.interpretation import Item
from vomstudio.products.ortho.ortho_options import OrthoOptions
from vomstudio.products.ortho.orthophoto import OrthophotoFiles
from vomstudio.products.ortho.planning import OrthophotoPlan, ViewRegion, plan
from vomstudio.products.ortho.view_directions import (
    ViewDirection,
    cost_of_direction,
    is_costly,
    view_against_plane,
    view_along_axis,
    view_along_line,
)


@dataclass(frozen=True)
class Direction:
    """Viewing direction along a line, against a plane, or along a fold or domain axis."""

    view: ViewDirection | None
    fold: TableFold | None = None
    axis: ProjectionAxis | None = None


@dataclass(frozen=True)
class FoldView:
    """Fold axis along which a picture is viewed; the figures are those of `TableFold`.

    Attributes
    ----------
    cost : Finding
        Effect of a direction error, also reported as a warning unless negligible (`is_costly`).
    """

    beta: BetaFigures
    valid: str
    verdict: str
    reasons: tuple[Finding, ...]
    used: int
    not_good: int | None
    left_out: tuple[ExcludedRows, ...]
    cost: Finding


@dataclass(frozen=True, eq=False)
class PlannedPicture:
    """Planned picture with its fold axis and warnings."""

    plan: OrthophotoPlan
    fold: FoldView | None
    warnings: tuple[Finding, ...]


def parse_region(text: str) -> ViewRegion:
    """Parse the region of a view given as "x,y,z,width,height".

    Raises
    ------
    UsageError
    """
    try:
        x, y, z, width, height = (float(word) for word in text.split(","))
    except ValueError:
        x = y = z = width = height = math.nan
    if not (math.isfinite(x + y + z) and 0 < width < math.inf and 0 < height < math.inf):
        raise UsageError(Finding("view.not-a-part", text=text), field="--around")
    return ViewRegion((x, y, z), width, height)


def domain_axis_direction(items: Sequence[Item], name: str) -> Direction:
    """Return the direction along the axis of a domain.

    Raises
    ------
    UsageError
        If the domain has no axis.
    """
    axis = compute_domain_axes(items, "--domain").get(name)
    if axis is None or axis.line is None:
        reason = tr("it has no planes") if axis is None else axis.description
        raise UsageError(Finding("domain.no-axis", domain=name, reason=reason), field="--domain")
    return Direction(None, None, axis)


def direction_from_options(options: OrthoOptions, fold: TableFold | None) -> Direction:
    """Return the viewing direction.

    `fold` is the fold axis of the table `options.fold`.

    Raises
    ------
    UsageError
        If no direction or an invalid direction is given.
    """
    options.check_direction()
    if fold is not None:
        return Direction(None, fold)
    if options.plane is not None:
        return Direction(view_against_plane(parse_plane_option(options.plane)))
    assert options.trend_deg is not None
    assert options.plunge_deg is not None
    return Direction(view_along_line(options.trend_deg, options.plunge_deg))


def plan_picture(
    data: Mesh | PointCloud,
    direction: Direction,
    *,
    to_world: npt.ArrayLike,
    path: Path,
    gsd_m: float | None = None,
    flip: bool = False,
    is_placed: bool = True,
    is_metric: bool = True,
    region: ViewRegion | None = None,
) -> PlannedPicture:
    """Plan a picture of a model.

    Parameters
    ----------
    data : Mesh or PointCloud
    direction : Direction
    to_world : (4, 4) array_like
    path : Path
        File of the model, for error messages.
    gsd_m : float, optional
    flip : bool
        Whether to view the model from the opposite side.
    is_placed, is_metric : bool
        Whether north and the unit of length are known.
    region : ViewRegion, optional
        Part of the view plane to draw.

    Raises
    ------
    InputError, UsageError
    """
    view, fold, warnings = direction.view, direction.fold, list[Finding]()
    if fold is not None:
        warnings += fold.warnings
        warnings += _validity_findings(fold.valid, fold.verdict)
        view = view_along_axis(fold.beta.trend_deg, fold.beta.plunge_deg, data, to_world)
    axis = direction.axis
    if axis is not None and axis.line is not None:
        warnings += _validity_findings(axis.valid, axis.description)
        view = view_along_axis(axis.line.trend_deg, axis.line.plunge_deg, data, to_world)
    assert view is not None
    if flip:
        view = view.flipped()
    if not is_placed:
        view = replace(view, is_north_known=False, is_metric=is_metric)
    try:
        orthophoto_plan = plan(data, view, to_world=to_world, gsd=gsd_m, region=region)
    except InputError as error:
        raise error.with_file(path) from error
    fold_view = None
    if fold is not None:
        fold_view = _fold_view(fold, orthophoto_plan)
        if fold.valid != "yes" or is_costly(fold.beta.total95_deg, *_view_size(orthophoto_plan)):
            warnings.append(fold_view.cost)
    if axis is not None and is_costly(axis.error95_deg, *_view_size(orthophoto_plan)):
        depth_m, _ = _view_size(orthophoto_plan)
        warnings.append(
            cost_of_direction(axis.error95_deg, depth_m, is_metric=orthophoto_plan.view.is_metric)
        )
    if not is_placed:
        warnings.append(Finding("view.not-placed"))
    return PlannedPicture(orthophoto_plan, fold_view, tuple(warnings))


def _validity_findings(valid_text: str | None, verdict: str) -> list[Finding]:
    if valid_text in (None, "yes"):
        return []
    if valid_text == "conditional":
        return [Finding("view.axis-conditional", verdict=verdict)]
    return [Finding("view.axis-not-valid", verdict=verdict)]


def _view_size(orthophoto_plan: OrthophotoPlan) -> tuple[float, float]:
    """Return the depth of the view and the longer side of the picture."""
    grid = orthophoto_plan.grid
    return float(np.ptp(orthophoto_plan.points[:, 2])), max(grid.width, grid.height) * grid.gsd


def _fold_view(fold: TableFold, orthophoto_plan: OrthophotoPlan) -> FoldView:
    depth_m, _ = _view_size(orthophoto_plan)
    error_deg = fold.beta.total95_deg
    cost = cost_of_direction(error_deg, depth_m, is_metric=orthophoto_plan.view.is_metric)
    return FoldView(
        fold.beta,
        fold.valid,
        fold.verdict,
        fold.reasons,
        fold.used,
        fold.not_good,
        fold.left_out,
        cost,
    )


@dataclass(frozen=True, eq=False)
class OrthophotoFigures(Result):
    """Geometry and coverage of a picture.

    Parameters
    ----------
    width, height : int
        Size in pixels.
    gsd_m : float
        Side of a pixel.
    trend_deg, plunge_deg : float
        Viewing direction.
    right, down, direction : (3,) arrays
        Unit vectors of the picture in the World frame.
    sense : str
        Sense of the view, i.e. which of the two opposite views it is.
    sense_reason : Finding
    coverage : float
        Share of the pixels that show the model.
    reference_point : (3,) array
        Point in the World frame at which the depth is 0.
    pixel_to_world : (4, 4) array
        Matrix from (column, row, depth, 1) to the World frame.
    crs : str or None
        CRS of the picture if it is a map; otherwise None.
    holes_filled_px : int
    holes_filled_up_to_m : float or None
        Maximum width of the holes that were filled in a cloud.
    """

    width: int
    height: int
    gsd_m: float
    trend_deg: float
    plunge_deg: float
    right: FloatArray
    down: FloatArray
    direction: FloatArray
    sense: str
    sense_reason: Finding
    coverage: float
    reference_point: FloatArray
    pixel_to_world: FloatArray
    crs: str | None
    holes_filled_px: int
    holes_filled_up_to_m: float | None


@dataclass(frozen=True)
class WrittenOrthophoto(Result):
    """Orthophoto and the files that were written with it.

    Parameters
    ----------
    image, sidecar, depth, world_file : str
    sheet : str or None
    drawing : dict or None
        Drawing files by format.
    figures : OrthophotoFigures
    fold : FoldView or None
        Fold axis along which the picture is viewed.
    warnings : tuple of Finding
    """

    image: str
    sidecar: str
    depth: str
    world_file: str
    sheet: str | None
    drawing: dict[str, str] | None
    figures: OrthophotoFigures = field(metadata=FLATTENED_IN_JSON)
    fold: FoldView | None
    warnings: tuple[Finding, ...]


def collect_result(
    files: OrthophotoFiles,
    planned_picture: PlannedPicture,
    image: str,
    sheet: str | None,
    warnings: Sequence[Finding] = (),
) -> WrittenOrthophoto:
    """Return the result of a drawn picture; `warnings` on the model precede all others."""
    return WrittenOrthophoto(
        image,
        str(files.sidecar),
        str(files.depth),
        str(files.world_file),
        sheet,
        {format_: str(path) for format_, path in files.drawing.items()} or None,
        figures_from_metadata(files.metadata),
        planned_picture.fold,
        (*warnings, *planned_picture.warnings, *files.warnings),
    )


def figures_from_metadata(metadata: Mapping[str, Any]) -> OrthophotoFigures:
    """Extract the figures from the metadata in the sidecar of a picture."""
    return OrthophotoFigures(
        metadata["width"],
        metadata["height"],
        metadata["gsd_m"],
        metadata["trend_deg"],
        metadata["plunge_deg"],
        np.array(metadata["right"]),
        np.array(metadata["down"]),
        np.array(metadata["direction"]),
        metadata["sense"],
        Finding.from_dict(metadata["sense_reason"]),
        metadata["coverage"],
        np.array(metadata["reference_point"]),
        np.array(metadata["pixel_to_world"]),
        metadata["crs"],
        metadata["holes_filled_px"],
        metadata["holes_filled_up_to_m"],
    )
