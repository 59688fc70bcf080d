"""Models with their placement, as input of jobs."""

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
class PlacedModel:
    """Model with its placement in World.

    Parameters
    ----------
    cache : Path
        Folder below which the model is cached.
    to_world : Matrix
        Matrix from the frame of the file to World.
    crs : str or None
        CRS of World, None for a local frame.
    registration : Registration, optional
        Registration that places the model; None for a declared frame.
    """

    name: str
    path: Path
    cache: Path
    to_world: Matrix
    crs: str | None
    registration: Registration | None = None


def read_in_file_frame(model: PlacedModel, progress: Progress) -> LoadedModel:
    """Return the model in the frame of its file."""
    from vomstudio.io.models import model_cache

    return model_cache.load(model.path, model_cache.folder_of(model.path, model.cache), progress)


def load_in_world(model: PlacedModel, progress: Progress) -> Mesh | PointCloud:
    """Return the model in World, metres."""
    from vomstudio.geometry.model_transform import transform_model

    return transform_model(read_in_file_frame(model, progress).data, model.to_world)
