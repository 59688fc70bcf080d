"""Requests and results of the coverage panel, computed in a worker thread."""

from __future__ import annotations

import math
from dataclasses import dataclass
from html import escape

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.identifiers import new_id
from vomstudio.core.words import tr, tr_n
from vomstudio.geology.coverage.cells import ExposedArea, create_grid
from vomstudio.geology.coverage.face_coverage import FaceCoverage
from vomstudio.geology.orientation import Line, Plane
from vomstudio.geometry import transform
from vomstudio.geometry.view_frame import ViewFrame
from vomstudio.project.records import FaceGrid, Model
from vomstudio.studio.surfaces.face_grids import compute_coverage

_CELLS_PER_SIDE = 8.0
"""Number of proposed cells along the longer side of a face."""


@dataclass(frozen=True, eq=False)
class GridRequest:
    """Request for a sampling grid.

    Attributes
    ----------
    points : (n, 3) array
        Points to be covered, in the frame of the model file, or in the World frame if `world` is
        True.
    plane : Plane or None
        Plane of the face, or None for a plane perpendicular to the view direction.
    view : (float, float)
        Trend and plunge of the view direction in degrees.
    cell_m : float or None
        Side length of a cell in metres, or None for the result of `proposed_cell_m`.
    """

    model: Model
    points: FloatArray
    world: bool
    plane: Plane | None
    view: tuple[float, float]
    cell_m: float | None


def create_face_grid(request: GridRequest) -> FaceGrid:
    """Create a sampling grid on the face. Runs in a worker thread."""
    world_from_file = transform.matrix(request.model.to_world)
    direction = Line(*request.view).vector() if request.plane is None else -request.plane.normal()
    frame = ViewFrame.from_direction(direction)
    points = request.points if request.world else transform.apply(world_from_file, request.points)
    points = points[np.isfinite(points).all(axis=1)]
    centre = points.mean(axis=0) if len(points) else np.zeros(3)
    cell_m = request.cell_m or proposed_cell_m(points, frame)
    grid = create_grid(points - centre, frame.right, -frame.down, cell_m)
    file_from_world = transform.invert(world_from_file)
    scale = transform.scale_factor(world_from_file)
    origin = transform.apply(file_from_world, [grid.origin + centre])[0]
    rotation = world_from_file[:3, :3].T / scale
    model = request.model
    return FaceGrid(
        id=new_id("grid"),
        name="",
        model_id=model.id,
        model_hash=model.content_hash,
        origin=_to_tuple(origin),
        right=_to_tuple(rotation @ grid.right),
        up=_to_tuple(rotation @ grid.up),
        cell=grid.cell / scale,
        columns=grid.columns,
        rows=grid.rows,
    )


def proposed_cell_m(points: FloatArray, frame: ViewFrame) -> float:
    """Return the proposed side length of a cell: 1, 2 or 5 times a power of ten, in metres.

    The longer side of the points in the view frame has about eight cells.
    """
    if not len(points):
        return 1.0
    projection = points @ np.stack([frame.right, frame.down], axis=1)
    target_m = float(np.ptp(projection, axis=0).max()) / _CELLS_PER_SIDE
    if not target_m > 0.0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(target_m))
    return float(
        min((1.0, 2.0, 5.0, 10.0), key=lambda k: abs(math.log(k * power / target_m))) * power
    )


def _to_tuple(vector: FloatArray) -> tuple[float, float, float]:
    x, y, z = vector.tolist()
    return x, y, z


@dataclass(frozen=True, eq=False)
class CoverageRequest:
    grid: FaceGrid
    model: Model | None
    exposed_area: ExposedArea
    lines: list[FloatArray]


def compute_grid_coverage(request: CoverageRequest) -> FaceCoverage:
    """Compute the coverage of a grid. Runs in a worker thread."""
    return compute_coverage(request.grid, request.model, request.exposed_area, request.lines)


def figures_html(coverage: FaceCoverage, unit: str) -> str:
    """Format the figures of a coverage as HTML; `unit` is the unit of length in the text."""
    rows = [
        (tr("Coverage"), _percent_text(coverage.looked_at_share)),
        *(
            (
                name,
                tr_n(
                    "{count} cell, {area} {unit}², {share}",
                    "{count} cells, {area} {unit}², {share}",
                    category.cells,
                    area=f"{category.covered_m2:.4g}",
                    unit=unit,
                    share=_percent_text(category.share),
                ),
            )
            for name, category in (
                (tr("Done"), coverage.done),
                (tr("Empty"), coverage.empty),
                (tr("Unmeasurable"), coverage.unmeasurable),
                (tr("Not inspected"), coverage.not_looked_at),
            )
        ),
        (
            tr("Reference area"),
            tr("{area} {unit}² (done and empty)", area=f"{coverage.counted_m2:.4g}", unit=unit),
        ),
        (tr("Features inside"), str(coverage.features)),
        (tr("Density"), _rate_text(coverage.density_1_per_m2, f"1/{unit}²")),
        (tr("P21"), _rate_text(coverage.P21_1_per_m, f"1/{unit}")),
    ]
    cells = "".join(
        f"<tr><td style='padding:1px 8px 1px 4px'>{escape(name)}</td>"
        f"<td style='padding:1px 2px'>{escape(value)}</td></tr>"
        for name, value in rows
    )
    notes = "".join(f"<p>{escape(reason.message)}</p>" for reason in coverage.reasons)
    return f"<table width='100%'>{cells}</table>{notes}"


def _percent_text(share: float | None) -> str:
    return "–" if share is None else f"{100.0 * share:.0f} %"


def _rate_text(value: float | None, unit: str) -> str:
    return "–" if value is None else f"{value:.3g} {unit}"
