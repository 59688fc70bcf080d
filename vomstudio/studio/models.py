"""Models of the open project: their data, and adding, locating and copying them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Literal

import numpy as np

from vomstudio.core.errors import InputError, VomError
from vomstudio.core.files.regular import is_folder, path_exists
from vomstudio.core.findings import Finding
from vomstudio.core.identifiers import new_id
from vomstudio.core.signals import Signal
from vomstudio.core.words import tr
from vomstudio.geometry.brush import SelectableSurface
from vomstudio.geometry.frames import Frame, crs_label
from vomstudio.geometry.registrations import Registration
from vomstudio.io.gis.crs import unit_in_metres, world_crs
from vomstudio.io.models.frames import (
    check_frame,
    file_frame,
    find_matching_registration,
    world_bounds,
)
from vomstudio.io.photos import cameras_file
from vomstudio.io.photos.cameras_file import has_known_scale
from vomstudio.project import edits
from vomstudio.project.paths import is_project
from vomstudio.project.photo_edits import find_reconstruction, reconstruction_registration
from vomstudio.project.reconstructions import RECONSTRUCTIONS
from vomstudio.project.records import Model, Record
from vomstudio.project.registration_import import registration_in_project
from vomstudio.studio.editing import Editing
from vomstudio.studio.jobs.model_tasks import (
    CONVERT_MODEL,
    COPY_MODEL,
    ConvertedModel,
    CopiedModel,
    ModelConversion,
    ModelCopy,
)
from vomstudio.studio.jobs.placed_model import PlacedModel
from vomstudio.studio.model_loading import ModelLoader, OpenModel
from vomstudio.studio.notices import CONVERT, DECLARE_FRAME, Notice, Notices
from vomstudio.studio.preferences import Preferences
from vomstudio.studio.projects import Projects
from vomstudio.studio.running_jobs import Jobs

MAX_DISTANCE_M = 10_000.0
"""Maximum distance from a model of the project whose frame a new model uses by default."""


class Models:
    """Models of the open project.

    Attributes
    ----------
    open_models : dict of str to OpenModel
        Data of the loaded models, keyed by id.
    loaded : Signal
        Emitted when a model has been read.
    frame_needed : Signal
        Emitted when a model has been added whose frame is not known from its file, its
        reconstruction or the project.
    """

    def __init__(
        self,
        projects: Projects,
        editing: Editing,
        loader: ModelLoader,
        jobs: Jobs,
        preferences: Preferences,
        notices: Notices,
    ) -> None:
        self.loaded: Signal[str] = Signal()
        self.frame_needed: Signal[str] = Signal()
        self.open_models: dict[str, OpenModel] = {}
        self.conversion_available: tuple[Path, str] | None = None
        """File of the model rejected last because it is not metric, and a suitable CRS for it."""
        self._projects, self._editing, self._loader = projects, editing, loader
        self._jobs, self._preferences, self._notices = jobs, preferences, notices
        loader.conversion_available.connect(self._offer_conversion)

    def surface(self, model_id: str) -> SelectableSurface | None:
        """Return the surface of a model, or None while the model is not loaded."""
        open_model = self.open_models.get(model_id)
        return open_model.surface if open_model else None

    def open_path(self, path: Path) -> None:
        """Open a project folder or a model file, or show why that is not possible."""
        path = path.expanduser()
        if not path_exists(path):
            self._notices.warn(Finding("file.missing", file=path), "error")
        elif is_project(path) or (is_folder(path) and path.suffix == ".vom"):
            try:
                self._projects.open(path)
            except VomError as error:
                self._notices.fail(error)
        else:
            self.open_model(path)

    def open_model(
        self,
        path: Path,
        name: str | None = None,
        reference_id: str | None = None,
        finished_callback: Callable[[str], None] = lambda _: None,
        label: str = "",
    ) -> None:
        """Open a model and add it to the project.

        Parameters
        ----------
        path : Path
        name : str, optional
            Name of the record, by default the name of the file.
        reference_id : str, optional
            Id of a model whose frame the new model shares.
        finished_callback : callable
            Called with the id of the model after it has been added.
        label : str
            Label of the edit; "" selects the default label.
        """
        path = path.resolve()
        self._loader.load(
            str(path),
            path,
            self._projects.project.cache,
            lambda opened: self._add(
                path, opened, name or get_name(path), reference_id, finished_callback, label
            ),
        )

    def load(self, model: Model) -> None:
        """Read the data of a model of the project."""
        path = self._projects.project.find_model(model)
        if path is None:
            finding = Finding("model.file-missing", model=model.name, file=model.path)
            self._notices.post(Notice(finding, "warning", "locate"))
            return

        def add_read_model(opened_model: OpenModel) -> None:
            if model.id not in self._projects.records:
                return
            if opened_model.content_hash != model.content_hash:
                self._notices.warn(Finding("model.changed", file=path, model=model.name))
                return
            self._attach(model.id, path, opened_model)

        self._loader.load(model.id, path, self._projects.project.cache, add_read_model)

    def locate(self, model_id: str, path: Path) -> None:
        """Read a model from the file that the user selected after the original file was moved."""

        def add_read_model(opened_model: OpenModel) -> None:
            stored_model_path = self._projects.project.model_path(path)
            if self._editing.attempt(
                edits.relocate_model, model_id, stored_model_path, opened_model.content_hash
            ):
                self._attach(model_id, path, opened_model)

        self._loader.load(model_id, path, self._projects.project.cache, add_read_model)

    def copy(
        self,
        model_id: str,
        cameras: Path | None = None,
        photos: bool = False,
        finished_callback: Callable[[], None] = lambda: None,
    ) -> None:
        """Copy a model's files into the project's folder.

        Parameters
        ----------
        model_id : str
        cameras : Path, optional
            File of the model's cameras, by default the one beside the model.
        photos : bool
            Whether to copy the photos.
        finished_callback : callable
            Called before the record refers to the copy.
        """
        project = self._projects.project
        model = self._projects.records.get(model_id)
        path = project.find_model(model) if isinstance(model, Model) else None
        if path is None or not isinstance(model, Model):
            return

        def add_read_model(copied_model: CopiedModel) -> None:
            if self._projects.project is not project:
                return
            finished_callback()
            stored_model_path = project.model_path(copied_model.path)
            if self._editing.attempt(
                edits.relocate_model, model_id, stored_model_path, model.content_hash
            ):
                self._notices.info(Finding("model.copied", model=model.name))

        self._jobs.submit(
            COPY_MODEL,
            ModelCopy(path, project.folder / "models", cameras, photos, model.registration),
            title=tr("Copying {model}", model=model.name),
            on_done=add_read_model,
            on_failed=lambda event: self._notices.warn(event.to_error(), "error"),
        )

    def _offer_conversion(self, path: Path, crs: str, error: VomError) -> None:
        """Report that a model is not metric, and offer to convert it."""
        self.conversion_available = path, crs
        self._notices.post(Notice(error, "error", CONVERT))

    def convert(self) -> None:
        """Convert the most recently rejected model to a metric CRS, and open the copy."""
        if self.conversion_available is None:
            return
        (path, crs), project = self.conversion_available, self._projects.project

        finding = Finding("model.converted", file=path.name, crs=crs)

        def show_converted(converted_model: ConvertedModel) -> None:
            if self._projects.project is project:
                self.conversion_available = None
                self.open_model(
                    converted_model.path,
                    path.stem,
                    finished_callback=lambda _: self._notices.info(finding),
                )

        self._jobs.submit(
            CONVERT_MODEL,
            ModelConversion(path, project.folder / "models", crs),
            title=tr("Converting {file} to {crs}", file=path.name, crs=crs),
            on_done=show_converted,
            on_failed=lambda event: self._notices.warn(event.to_error(), "error"),
        )

    def _add(
        self,
        path: Path,
        opened_model: OpenModel,
        name: str,
        reference_id: str | None,
        finished_callback: Callable[[str], None],
        label: str,
    ) -> None:
        models = self._projects.of(Model)
        same_file = [m for m in models if m.content_hash == opened_model.content_hash]
        if same_file:
            if same_file[0].id not in self.open_models:
                self._attach(same_file[0].id, path, opened_model)
            self._notices.info(Finding("model.already-open", file=path.name))
            return
        stored_model_path = self._projects.project.model_path(path)
        reference_model = self._projects.records.get(reference_id or "")
        findings: tuple[Finding, ...] = ()
        try:
            if isinstance(reference_model, Model):
                placement = reference_model.placement
            else:
                placement, findings = self._placement(path, stored_model_path, opened_model)
        except InputError as error:
            if crs := error.values.get("suggested_crs"):
                self._offer_conversion(path, str(crs), error)
            else:
                self._notices.fail(error)
            return
        is_frame_known = placement != Frame() or has_known_scale(path) is not None
        if not is_frame_known and (frame := self._project_frame(opened_model)) is not None:
            placement, is_frame_known = frame, True
            finding = Finding("frame.of-project", crs=crs_label(frame.crs or ""))
            self._notices.post(Notice(finding.with_file(path.name), action=DECLARE_FRAME))
        self._post_findings(path, findings)
        model = new_model(
            name, stored_model_path, opened_model.kind, opened_model.content_hash, placement
        )
        # Store the data first, because an edit that adds a model without data would read the
        # file again.
        self.open_models[model.id] = opened_model
        if not self._editing.attempt(edits.add_model, model, label):
            del self.open_models[model.id]
            return
        self._preferences.remember(path)
        self._attach(model.id, path, opened_model)
        if not is_frame_known and not isinstance(reference_model, Model):
            self.frame_needed.emit(model.id)
        finished_callback(model.id)

    def _placement(
        self, path: Path, stored_text: str, opened_model: OpenModel
    ) -> tuple[Frame | Registration, tuple[Finding, ...]]:
        """Return the placement of a file that is added to the project.

        This is the registration of the reconstruction that contains the file, the registration
        beside the file, or the frame stated in the file, in this order. Raises InputError.
        """
        records, bounds = self._projects.records, opened_model.data.bounds
        file_registration = find_file_registration(records, stored_text)
        if file_registration is not None:
            return file_registration, check_frame(
                file_registration.frame,
                world_bounds(bounds, file_registration.matrix),
                file=path.name,
            )
        stored_registration = find_matching_registration(
            path, opened_model.content_hash, opened_model.crs
        )
        if stored_registration.registration is not None:
            registration = registration_in_project(records, stored_registration.registration)
            placed_world_bounds = world_bounds(bounds, registration.matrix)
            return registration, check_frame(
                registration.frame, placed_world_bounds, file=path.name
            )
        frame = file_frame(path, opened_model.crs)
        return frame, (*stored_registration.findings, *check_frame(frame, bounds, file=path.name))

    def _project_frame(self, opened_model: OpenModel) -> Frame | None:
        """Return the frame of a project model near the coordinates of a new file, or None.

        Only loaded models with a CRS are considered, the last one first.
        """
        low, high = opened_model.data.bounds
        for model in reversed(self._projects.of(Model)):
            other_model = self.open_models.get(model.id)
            if model.frame.crs is None or other_model is None:
                continue
            unit_m = unit_in_metres(model.frame.crs)
            other_low, other_high = world_bounds(other_model.data.bounds, model.to_world) / unit_m
            margin = MAX_DISTANCE_M / unit_m
            if np.all(low <= other_high + margin) and np.all(high >= other_low - margin):
                return Frame("crs", model.frame.crs, unit_m)
        return None

    def _attach(self, model_id: str, path: Path, opened_model: OpenModel) -> None:
        self.open_models[model_id] = opened_model
        self._post_findings(path, opened_model.warnings)
        self.loaded.emit(model_id)

    def _post_findings(self, path: Path, findings: Sequence[Finding]) -> None:
        """Show the findings about a file in one notice."""
        if findings:
            first_finding, *other_findings = (finding.with_file(path.name) for finding in findings)
            self._notices.post(Notice(first_finding, "warning", more=tuple(other_findings)))


def new_model(
    name: str,
    stored_text: str,
    kind: Literal["mesh", "cloud"],
    content_hash: str,
    placement: Frame | Registration,
) -> Model:
    """Create the record of a new model; `stored_text` is its path as stored in the project."""
    return Model(new_id("model"), name, stored_text, kind, content_hash, placement)


def find_placed_model(projects: Projects, model_id: str) -> PlacedModel | None:
    """Return a model as input for jobs, or None if the model or its file is missing."""
    record = projects.records.get(model_id)
    path = projects.project.find_model(record) if isinstance(record, Model) else None
    if path is None or not isinstance(record, Model):
        return None
    return placed_model(record, path, projects.project.cache)


def placed_model(record: Model, path: Path, cache: Path) -> PlacedModel:
    """Return a model of a project, whose file is `path`, as input for jobs.

    Parameters
    ----------
    record : Model
    path : Path
    cache : Path

    Returns
    -------
    PlacedModel
    """
    crs = world_crs(record.frame.crs, record.frame.unit_m) if record.frame.crs else None
    return PlacedModel(record.name, path, cache, record.to_world, crs, record.registration)


def find_file_registration(records: Mapping[str, Record], stored_text: str) -> Registration | None:
    """Return the registration of the reconstruction that contains a model, or None."""
    parts = Path(stored_text).parts
    if len(parts) != 3 or parts[0] != RECONSTRUCTIONS:
        return None
    reconstruction = find_reconstruction(records, parts[1])
    return (
        None if reconstruction is None else reconstruction_registration(records, reconstruction.id)
    )


def get_name(path: Path) -> str:
    """Return the name of a model from its file, or from its folder in a reconstruction."""
    folder = path.parent.name
    if not path.with_name(cameras_file.FILE_NAME).is_file() or path.stem == folder:
        return path.stem
    return folder if path.stem == "model" else f"{folder} {path.stem}"
