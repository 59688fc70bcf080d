"""What was looked at in a project, without a window."""

from __future__ import annotations

from dataclasses import dataclass, field

from vomstudio.core.findings import Finding, finding_of
from vomstudio.core.results import FLAT, Result
from vomstudio.document.measurement_cache import Measurements
from vomstudio.document.records import FaceGrid, Model, get
from vomstudio.errors import VomError
from vomstudio.geology.looked_at.shares import LookedAt
from vomstudio.workspace.headless_project import HeadlessProject
from vomstudio.workspace.surfaces.face_grids import exposed_of, lines_on, share_of


@dataclass(frozen=True)
class GridShare(Result):
    """id, name : of the grid; model : name; found : what was looked at"""

    id: str
    name: str
    model: str
    found: LookedAt = field(metadata=FLAT)


def shares_of(desk: HeadlessProject) -> tuple[list[GridShare], list[Finding]]:
    """Of each grid of the project, and why others are left out: their models cannot be read."""
    records = dict(desk.session.records)
    found: list[GridShare] = []
    said: list[Finding] = []
    measurements = Measurements()
    for grid in desk.session.of(FaceGrid):
        model = get(records, grid.model_id, Model)
        if model is None:
            said.append(Finding("grid.no-model", grid=grid.name))
            continue
        try:
            read = desk.read_model(model)
        except VomError as error:
            said.append(finding_of(error))
            continue
        exposed = exposed_of(grid, read.data, read.resolution, pieces=False)
        own = [f.id for f in desk.session.features() if getattr(f, "model_id", "") == model.id]
        lines = lines_on(records, measurements.of(records, own), model.id)
        share = share_of(grid, model, exposed, lines)
        found.append(GridShare(grid.id, grid.name, model.name, share))
    return found, said
