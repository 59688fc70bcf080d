"""A model and how it stands in World, as jobs are told of it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from vomstudio.core.progress import Progress
from vomstudio.geometry.registrations import Registration
from vomstudio.studio.jobs.model_tasks import Matrix

if TYPE_CHECKING:
    from vomstudio.geometry.cloud import PointCloud
    from vomstudio.geometry.mesh import Mesh
    from vomstudio.io.models.reader import LoadedModel


@dataclass(frozen=True)
class StandingModel:
    """A model `path`, called `name`, kept at hand under `cache`, and how it stands in World, `crs`,
    None for a local frame. registration : by which it stands there, None for a stated frame."""

    name: str
    path: Path
    cache: Path
    to_world: Matrix
    crs: str | None
    registration: Registration | None = None


def read_standing(one: StandingModel, progress: Progress) -> LoadedModel:
    """Its data in its own frame."""
    from vomstudio.io.models import model_cache

    return model_cache.load(one.path, model_cache.folder_of(one.path, one.cache), progress)


def in_world(one: StandingModel, progress: Progress) -> Mesh | PointCloud:
    """Its data as it stands in World, m."""
    from vomstudio.geometry.model_transform import moved

    return moved(read_standing(one, progress).data, one.to_world)
