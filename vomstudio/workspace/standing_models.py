"""The models of a project as jobs are told of them."""

from __future__ import annotations

from vomstudio.document.records import Model
from vomstudio.io.gis.crs import world_crs
from vomstudio.jobs.registration_tasks import StandingModel
from vomstudio.workspace.projects import Projects


def standing_model(projects: Projects, model_id: str) -> StandingModel | None:
    """None where the model or its file is not there."""
    record = projects.records.get(model_id)
    path = projects.project.find_model(record) if isinstance(record, Model) else None
    if path is None or not isinstance(record, Model):
        return None
    crs = world_crs(record.frame.crs, record.frame.unit_m) if record.frame.crs else None
    return StandingModel(record.name, path, projects.project.cache, record.to_world, crs)
