"""Models in the World frame, as stated by the file, the user or a project."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.options import given_options
from vomstudio.core.progress import Progress, SilentProgress
from vomstudio.core.words import tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.model_transform import transform_model
from vomstudio.geometry.registration_frames import change_file_frame
from vomstudio.geometry.registrations import Registration
from vomstudio.geometry.units import Axes
from vomstudio.io.gate.frame_options import DEFAULT_FRAME, FrameOptions
from vomstudio.io.gis.crs import world_crs
from vomstudio.io.models.frames import establish_frame
from vomstudio.io.models.opening import read_model
from vomstudio.io.models.reader import LoadedModel
from vomstudio.io.photos.cameras_file import has_known_scale
from vomstudio.project.records import Model


@dataclass(frozen=True, eq=False)
class WorldModel:
    """Model in the World frame.

    Parameters
    ----------
    data : Mesh or PointCloud
        Data in the World frame, metres.
    crs : str or None
        CRS of the World frame, or None for a local frame.
    is_metric : bool
        Whether the length unit of the model is known.
    warnings : tuple of Finding
        Warnings about the file and its frame.
    loaded : LoadedModel
        Model as read from the file.
    to_world : (4, 4) float64
        Matrix from the file frame to the World frame.
    project_model : Model, optional
        Record that defines the placement in a project. If None, the file defines it.
    registration : Registration, optional
        Registration stored in the project or beside the file.
    """

    data: Mesh | PointCloud
    crs: str | None
    is_metric: bool
    warnings: tuple[Finding, ...]
    loaded: LoadedModel
    to_world: FloatArray
    project_model: Model | None = None
    registration: Registration | None = None

    @property
    def is_placed(self) -> bool:
        """Whether the axes of the model are aligned with true north and up.

        This is not the case for a model from photos without control points or GPS.
        """
        if self.project_model is not None:
            return self.project_model.frame.has_north
        if self.registration is not None:
            return self.registration.frame.has_north
        return self.crs is not None or has_known_scale(self.loaded.path) is not False

    @property
    def has_metric_unit(self) -> bool:
        """Whether lengths are in metres.

        Files that state no unit are assumed to be in metres, except photo models without scale.
        """
        return self.is_metric or (self.project_model is None and self.is_placed)

    @property
    def registration_in_world(self) -> Registration | None:
        """Registration for a file that stores the coordinates of `data`, or None."""
        if self.registration is None:
            return None
        return change_file_frame(self.registration, self.to_world)

    @property
    def axes(self) -> Axes:
        """Properties of the World axes for files and labels: metric unit and known north."""
        return Axes(self.has_metric_unit, self.is_placed)


def read_in_world(
    path: str | Path,
    progress: Progress | None = None,
    options: FrameOptions = DEFAULT_FRAME,
    project: str | Path | None = None,
) -> WorldModel:
    """Read a model and transform it to the World frame.

    A file that states no frame is assumed to have local coordinates in metres, with z up.

    Parameters
    ----------
    path : str or Path
    progress : Progress, optional
    options : FrameOptions, optional
    project : str or Path, optional
        Folder of a project that defines the placement of the model.

    Raises
    ------
    InputError, UsageError, Cancelled
    """
    check_frame_source(options, project)
    progress = progress or SilentProgress()
    # Readers start their own stage after importing the libraries of the format.
    progress.stage(tr("Reading {file}", file=Path(path).name))
    loaded_model = read_model(path, progress, options)
    progress.stage(tr("Preparing the model"))
    if project is not None:
        return place_as_in_project(loaded_model, find_project_model(project, loaded_model))
    established = establish_frame(loaded_model, options)
    frame = established.frame
    crs = None if frame.crs is None else world_crs(frame.crs, frame.unit_m)
    registration = established.registration
    is_metric = loaded_model.unit_m is not None or frame.crs is not None or options.unit is not None
    if registration is not None:
        is_metric = frame.has_metres
    matrix = np.asarray(established.to_world(), np.float64)
    data = transform_model(loaded_model.data, matrix)
    warnings = (*loaded_model.warnings, *established.findings)
    return WorldModel(
        data, crs, is_metric, warnings, loaded_model, matrix, registration=registration
    )


def read_comparison_model(
    path: str | Path,
    progress: Progress | None = None,
    project: str | Path | None = None,
    options: FrameOptions = DEFAULT_FRAME,
) -> WorldModel:
    """Read a model for a comparison, preferably with its placement in a project.

    Raises the errors of `read_in_world`.
    """
    if project is None:
        return read_in_world(path, progress, options)
    progress = progress or SilentProgress()
    progress.stage(tr("Reading {file}", file=Path(path).name))
    loaded_model = read_model(path, progress)
    progress.stage(tr("Preparing the model"))
    models = _read_models(project)
    if any(model.content_hash == loaded_model.content_hash for model in models):
        return place_as_in_project(loaded_model, find_project_model(project, loaded_model))
    return read_in_world(path, progress)


def check_frame_source(options: FrameOptions, project: str | Path | None) -> None:
    """Raise UsageError if both a project and options define the frame of a model."""
    if project is None or not options.is_given:
        return
    option_names = [name.replace("_", "-") for name in given_options(options)]
    raise UsageError(
        Finding("option.not-with-project"),
        field=f"--{option_names[0]}",
    )


def find_project_model(project: str | Path, loaded_model: LoadedModel) -> Model:
    """Return the record of a loaded model in a project, which may be open in a window.

    Raises
    ------
    InputError
        If the folder is not a project.
    UsageError
        If the project does not contain the model.
    """
    models = _read_models(project)
    models_of_file = [model for model in models if model.content_hash == loaded_model.content_hash]
    if not models_of_file:
        names = [f"{model.name} ({model.path})" for model in models]
        raise UsageError(
            Finding("project.other-model", models=names or None),
            file=Path(project),
            field="--project",
        )
    named_models = [
        model for model in models_of_file if Path(model.path).name == loaded_model.path.name
    ]
    return (named_models or models_of_file)[0]


def _read_models(project: str | Path) -> list[Model]:
    from vomstudio.project.folder import project_folder
    from vomstudio.project.journal.database import read_replay

    records = read_replay(project_folder(Path(project))).records
    return [record for record in records.values() if isinstance(record, Model)]


def place_as_in_project(loaded_model: LoadedModel, model: Model) -> WorldModel:
    """Transform a loaded model to the World frame with the placement of its record."""
    frame = model.frame
    crs = None if frame.crs is None else world_crs(frame.crs, frame.unit_m)
    matrix = np.asarray(model.to_world, np.float64)
    data = transform_model(loaded_model.data, matrix)
    return WorldModel(
        data,
        crs,
        frame.has_metres,
        loaded_model.warnings,
        loaded_model,
        matrix,
        model,
        model.registration,
    )
