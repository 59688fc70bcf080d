"""What the dock of what was looked at asks, worked out in a thread."""

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

_PROPOSED = 8.0
"""Cells along the longer side of a face, of the side that is proposed."""


@dataclass(frozen=True, eq=False)
class NewGrid:
    """points : (n, 3) that it lies over, model file frame or, where `world`, World; plane : of the
    face, None for the one that faces the view, trend and plunge; cell_m : None for the proposed"""

    model: Model
    points: FloatArray
    world: bool
    plane: Plane | None
    view: tuple[float, float]
    cell_m: float | None


def lay(asked: NewGrid) -> FaceGrid:
    """Create a sampling grid on the face. Runs in a worker thread."""
    rows = transform.matrix(asked.model.to_world)
    direction = Line(*asked.view).vector() if asked.plane is None else -asked.plane.normal()
    frame = ViewFrame.looking(direction)
    points = asked.points if asked.world else transform.apply(rows, asked.points)
    points = points[np.isfinite(points).all(axis=1)]
    middle = points.mean(axis=0) if len(points) else np.zeros(3)
    cell = asked.cell_m or proposed_cell(points, frame)
    grid = create_grid(points - middle, frame.right, -frame.down, cell)
    back = transform.invert(rows)
    scale = transform.scale_of(rows)
    origin = transform.apply(back, [grid.origin + middle])[0]
    turn = rows[:3, :3].T / scale
    model = asked.model
    return FaceGrid(
        new_id("grid"),
        "",
        model.id,
        model.content_hash,
        _tuple(origin),
        _tuple(turn @ grid.right),
        _tuple(turn @ grid.up),
        grid.cell / scale,
        grid.columns,
        grid.rows,
    )


def proposed_cell(points: FloatArray, frame: ViewFrame) -> float:
    """A round number of metres: 1, 2 or 5 times a power of ten."""
    if not len(points):
        return 1.0
    across = points @ np.stack([frame.right, frame.down], axis=1)
    wanted = float(np.ptp(across, axis=0).max()) / _PROPOSED
    if not wanted > 0.0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(wanted))
    return float(
        min((1.0, 2.0, 5.0, 10.0), key=lambda k: abs(math.log(k * power / wanted))) * power
    )


def _tuple(vector: FloatArray) -> tuple[float, float, float]:
    x, y, z = vector.tolist()
    return x, y, z


@dataclass(frozen=True, eq=False)
class ShareQuestion:
    grid: FaceGrid
    model: Model | None
    exposed: ExposedArea
    lines: list[FloatArray]


def answer(question: ShareQuestion) -> FaceCoverage:
    """In a thread."""
    return compute_coverage(question.grid, question.model, question.exposed, question.lines)


def figures_html(found: FaceCoverage, unit: str) -> str:
    """unit : of lengths, "m" where they are metres"""
    rows = [
        (tr("Looked at"), _percent(found.looked_at_share)),
        *(
            (
                name,
                tr_n(
                    "{count} cell, {area} {unit}², {share}",
                    "{count} cells, {area} {unit}², {share}",
                    part.cells,
                    area=f"{part.covered_m2:.4g}",
                    unit=unit,
                    share=_percent(part.share),
                ),
            )
            for name, part in (
                (tr("Done"), found.done),
                (tr("Empty"), found.empty),
                (tr("Unmeasurable"), found.unmeasurable),
                (tr("Not looked at"), found.not_looked_at),
            )
        ),
        (
            tr("Counted over"),
            tr("{area} {unit}² (done and empty)", area=f"{found.counted_m2:.4g}", unit=unit),
        ),
        (tr("Features there"), str(found.features)),
        (tr("Density"), _per(found.density_1_per_m2, f"1/{unit}²")),
        (tr("P21"), _per(found.P21_1_per_m, f"1/{unit}")),
    ]
    cells = "".join(
        f"<tr><td style='padding:1px 8px 1px 4px'>{escape(name)}</td>"
        f"<td style='padding:1px 2px'>{escape(said)}</td></tr>"
        for name, said in rows
    )
    notes = "".join(f"<p>{escape(reason.message)}</p>" for reason in found.reasons)
    return f"<table width='100%'>{cells}</table>{notes}"


def _percent(share: float | None) -> str:
    return "–" if share is None else f"{100.0 * share:.0f} %"


def _per(value: float | None, unit: str) -> str:
    return "–" if value is None else f"{value:.3g} {unit}"
