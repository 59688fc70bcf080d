"""Models of files in World: as the file says, as the user does, or as they stand in a project."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import UsageError
from vomstudio.core.findings import Finding
from vomstudio.core.options import given_options
from vomstudio.core.progress import Progress, Silent
from vomstudio.core.words import tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.model_transform import moved
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
    """data : in World, metres; crs : of World, None for a local frame
    metric : its unit is known; warnings : of its reader
    to_world : (4, 4) from the frame of its file
    in_project : the record by which it stands in a project; None where it stands as its file says
    registration : by which it stands in World, of the project or beside its file; None for none
    """

    data: Mesh | PointCloud
    crs: str | None
    metric: bool
    warnings: tuple[Finding, ...]
    loaded: LoadedModel
    to_world: FloatArray
    in_project: Model | None = None
    registration: Registration | None = None

    @property
    def placed(self) -> bool:
        """Whether north and Up are those of the Earth: not of a model that was made of photos
        without control points or GPS."""
        if self.in_project is not None:
            return self.in_project.frame.has_north
        if self.registration is not None:
            return self.registration.frame.has_north
        return self.crs is not None or has_known_scale(self.loaded.path) is not False

    @property
    def in_metres(self) -> bool:
        """Whether lengths may be called metres: a file that says nothing is taken to be in them, a
        model that was made of photos without scale is not."""
        return self.metric or (self.in_project is None and self.placed)

    @property
    def registration_in_world(self) -> Registration | None:
        """The registration of a file that has `data` as its coordinates."""
        if self.registration is None:
            return None
        return change_file_frame(self.registration, self.to_world)

    @property
    def axes(self) -> Axes:
        """What files and labels say of World's axes."""
        return Axes(self.in_metres, self.placed)


def read_in_world(
    path: str | Path,
    progress: Progress | None = None,
    options: FrameOptions = DEFAULT_FRAME,
    project: str | Path | None = None,
) -> WorldModel:
    """The model in a file, as its file says that it stands; one that says nothing as declared, else
    as local, in metres, z up. project : a folder; the model then stands as it does there. Raises
    InputError, UsageError, Cancelled."""
    check_place(options, project)
    progress = progress or Silent()
    # Readers begin a stage of their own once the libraries of the format are imported.
    progress.stage(tr("Reading {file}", file=Path(path).name))
    loaded = read_model(path, progress, options)
    progress.stage(tr("Preparing the model"))
    if project is not None:
        return as_in_project(loaded, model_in(project, loaded))
    established = establish_frame(loaded, options)
    frame = established.frame
    crs = None if frame.crs is None else world_crs(frame.crs, frame.unit_m)
    registration = established.registration
    metric = loaded.unit_m is not None or frame.crs is not None or options.unit is not None
    if registration is not None:
        metric = frame.has_metres
    matrix = np.asarray(established.to_world(), np.float64)
    data = moved(loaded.data, matrix)
    warnings = (*loaded.warnings, *established.findings)
    return WorldModel(data, crs, metric, warnings, loaded, matrix, registration=registration)


def read_beside(
    path: str | Path,
    progress: Progress | None = None,
    project: str | Path | None = None,
    options: FrameOptions = DEFAULT_FRAME,
) -> WorldModel:
    """The model that another one is held against: as it stands in the project where that has it,
    else as its file says. Raises as `read_in_world`."""
    if project is None:
        return read_in_world(path, progress, options)
    progress = progress or Silent()
    progress.stage(tr("Reading {file}", file=Path(path).name))
    loaded = read_model(path, progress)
    progress.stage(tr("Preparing the model"))
    models = _models_of(project)
    if any(model.content_hash == loaded.content_hash for model in models):
        return as_in_project(loaded, model_in(project, loaded))
    return read_in_world(path, progress)


def check_place(options: FrameOptions, project: str | Path | None) -> None:
    """Raise UsageError if both a project and options define the frame of a model."""
    if project is None or not options.is_given:
        return
    given = [name.replace("_", "-") for name in given_options(options)]
    raise UsageError(
        Finding("option.not-with-project"),
        field=f"--{given[0]}",
    )


def model_in(project: str | Path, loaded: LoadedModel) -> Model:
    """The record of a file's model in a project, which may be open in a window. Raises InputError
    for what is no project, UsageError where it does not have this model."""
    models = _models_of(project)
    same = [model for model in models if model.content_hash == loaded.content_hash]
    if not same:
        names = [f"{model.name} ({model.path})" for model in models]
        raise UsageError(
            Finding("project.other-model", models=names or None),
            file=Path(project),
            field="--project",
        )
    named = [model for model in same if Path(model.path).name == loaded.path.name]
    return (named or same)[0]


def _models_of(project: str | Path) -> list[Model]:
    from vomstudio.project.folder import project_folder
    from vomstudio.project.journal.database import read_replay

    records = read_replay(project_folder(Path(project))).records
    return [record for record in records.values() if isinstance(record, Model)]


def as_in_project(loaded: LoadedModel, model: Model) -> WorldModel:
    """A model that was read, by its record."""
    frame = model.frame
    crs = None if frame.crs is None else world_crs(frame.crs, frame.unit_m)
    matrix = np.asarray(model.to_world, np.float64)
    data = moved(loaded.data, matrix)
    return WorldModel(
        data, crs, frame.has_metres, loaded.warnings, loaded, matrix, model, model.registration
    )
