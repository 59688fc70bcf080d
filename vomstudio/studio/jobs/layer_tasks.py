"""Job that writes the GIS layers of a project after edits in the window."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from vomstudio.core.progress import Progress
from vomstudio.studio.jobs.job import Job, Lane, NoArguments


@dataclass(frozen=True)
class LayersRequest:
    """Request to write the GIS layers of the project in `folder` to its `project.gpkg`."""

    folder: Path


def _write_layers(request: LayersRequest, progress: Progress) -> NoArguments:
    from vomstudio.project.exports.export import export_project

    export_project(
        request.folder, "gpkg", request.folder / "project.gpkg", writes_map=False, force=True
    )
    return NoArguments()


WRITE_LAYERS = Job("write_layers", Lane.FILES, LayersRequest, NoArguments, _write_layers)

JOBS = (WRITE_LAYERS,)
