"""The job that writes the GIS layers of a project. The window submits it after every edit."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from vomstudio.core.progress import Progress
from vomstudio.studio.jobs.job import Job, Lane, Nothing


@dataclass(frozen=True)
class LayersOrder:
    """The GIS layers of the project in `folder` go to its `project.gpkg`."""

    folder: Path


def _write_layers(asked: LayersOrder, progress: Progress) -> Nothing:
    from vomstudio.project.exports.export import export_project

    export_project(asked.folder, "gpkg", asked.folder / "project.gpkg", with_map=False, force=True)
    return Nothing()


WRITE_LAYERS = Job("write_layers", Lane.FILES, LayersOrder, Nothing, _write_layers)

JOBS = (WRITE_LAYERS,)
