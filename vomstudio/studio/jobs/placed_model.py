"""Models with their placement, as input for jobs."""

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
    """Model with its placement in the World frame.

    Parameters
    ----------
    cache : Path
        Folder below which the model is cached.
    to_world : Matrix
        Matrix from the file frame to the World frame.
    crs : str or None
        CRS of the World frame, or None for a local frame.
    registration : Registration, optional
        Registration that defines the placement. If None, the frame was declared.
    """

    name: str
    path: Path
    cache: Path
    to_world: Matrix
    crs: str | None
    registration: Registration | None = None


def read_in_file_frame(model: PlacedModel, progress: Progress) -> LoadedModel:
    """Read a model in its file frame."""
    from vomstudio.io.models import model_cache

    return model_cache.load(model.path, model_cache.cache_folder(model.path, model.cache), progress)


def load_in_world(model: PlacedModel, progress: Progress) -> Mesh | PointCloud:
    """Load a model and transform it to the World frame, metres."""
    from vomstudio.geometry.model_transform import transform_model

    return transform_model(read_in_file_frame(model, progress).data, model.to_world)
