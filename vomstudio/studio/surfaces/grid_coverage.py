"""Coverage of the grids in a project, without a window."""

from __future__ import annotations

from dataclasses import dataclass, field

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding, to_finding
from vomstudio.core.results import FLATTENED_IN_JSON, Result
from vomstudio.geology.coverage.face_coverage import FaceCoverage
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.records import FaceGrid, Model, get
from vomstudio.studio.headless_project import HeadlessProject
from vomstudio.studio.surfaces.face_grids import (
    compute_coverage,
    compute_exposed_area,
    picked_lines,
)


@dataclass(frozen=True)
class GridShare(Result):
    """Coverage of a grid.

    Parameters
    ----------
    id, name : str
        Id and name of the grid.
    model : str
        Name of the model.
    coverage : FaceCoverage
        Coverage of the face by inspected cells.
    """

    id: str
    name: str
    model: str
    coverage: FaceCoverage = field(metadata=FLATTENED_IN_JSON)


def grid_shares(project: HeadlessProject) -> tuple[list[GridShare], list[Finding]]:
    """Return the coverage of each grid, and the reasons why grids are omitted.

    A grid is omitted if its model cannot be read.
    """
    records = dict(project.session.records)
    shares: list[GridShare] = []
    findings: list[Finding] = []
    measurements = Measurements()
    for grid in project.session.of(FaceGrid):
        model = get(records, grid.model_id, Model)
        if model is None:
            findings.append(Finding("grid.no-model", grid=grid.name))
            continue
        try:
            read_model = project.read_model(model)
        except VomError as error:
            findings.append(to_finding(error))
            continue
        exposure = compute_exposed_area(
            grid, read_model.data, read_model.resolution, includes_pieces=False
        )
        feature_ids = [
            f.id for f in project.session.features() if getattr(f, "model_id", "") == model.id
        ]
        lines = picked_lines(records, measurements.of(records, feature_ids), model.id)
        coverage = compute_coverage(grid, model, exposure, lines)
        shares.append(GridShare(grid.id, grid.name, model.name, coverage))
    return shares, findings
