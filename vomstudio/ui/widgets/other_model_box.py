"""Choice of another model of the same rock, from the project or from a file."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from PySide6.QtCore import QSignalBlocker, Signal
from PySide6.QtWidgets import QFileDialog, QHBoxLayout, QPushButton, QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.matrices import Matrix
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.registrations import Registration
from vomstudio.io.gis.crs import world_crs
from vomstudio.project.records import Model
from vomstudio.studio.jobs.events import Failed
from vomstudio.studio.jobs.model_tasks import LOAD_MODEL, CachedModel, ModelFile
from vomstudio.studio.jobs.placed_model import PlacedModel
from vomstudio.studio.running_jobs import RunningJob
from vomstudio.ui.base import file_filters
from vomstudio.ui.base.command_targets import start_folder
from vomstudio.ui.base.controls import ComboBox
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.studio import Studio


@dataclass(frozen=True, eq=False)
class OtherModel:
    """Model with its data in the file frame.

    Attributes
    ----------
    id : str
        Id of its record, or "" for a model that was read from a file.
    """

    name: str
    path: Path
    data: Mesh | PointCloud
    to_world: Matrix
    frame: Frame
    id: str = ""
    registration: Registration | None = None

    @property
    def placement(self) -> Frame | Registration:
        """Registration of the model, or else its frame."""
        return self.registration or self.frame

    def to_placed_model(self, cache: Path) -> PlacedModel:
        """Return the model as input for a job.

        Parameters
        ----------
        cache : Path
            Cache folder of the project.
        """
        crs = world_crs(self.frame.crs, self.frame.unit_m) if self.frame.crs else None
        return PlacedModel(self.name, self.path, cache, self.to_world, crs, self.registration)


def project_model(studio: Studio, model: Model) -> OtherModel | None:
    """Return a model of the project, or None if its file is not open."""
    open_model, path = studio.models.get(model.id), studio.project.find_model(model)
    if open_model is None or path is None:
        return None
    return OtherModel(
        model.name, path, open_model.data, model.to_world, model.frame, model.id, model.registration
    )


class OtherModelBox(QWidget):
    """List of other models, with a button to read a model from a file.

    Parameters
    ----------
    excluded_id : str
        Id of the model that is excluded from the list.

    Attributes
    ----------
    model_changed : Signal
        Emitted with the selected `OtherModel`, or None.
    status_changed : Signal
        Emitted with the text of the current operation or error.
    """

    model_changed = Signal(object)
    status_changed = Signal(str)

    def __init__(self, studio: Studio, excluded_id: str) -> None:
        super().__init__()
        self._studio, self._excluded_id = studio, excluded_id
        self._background = QtBackground(self)
        self._job: RunningJob | None = None
        self._files: dict[str, OtherModel] = {}
        self.models = ComboBox()
        self.models.setObjectName("other_model")
        self.browse = QPushButton(tr("File…"))
        self.browse.setToolTip(tr("Choose a model or point cloud outside the project."))
        self.browse.clicked.connect(self._browse)
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        row.addWidget(self.models, 1)
        row.addWidget(self.browse)
        self._list_other_models()
        self.models.currentIndexChanged.connect(self._handle_choice)

    def current(self) -> OtherModel | None:
        """Return the selected model, or None if no model is selected."""
        key = str(self.models.currentData() or "")
        if key in self._files:
            return self._files[key]
        record = self._studio.records.get(key)
        return project_model(self._studio, record) if isinstance(record, Model) else None

    def cancel_reading(self) -> None:
        """Stop reading, and deliver no further models."""
        self._background.stop()
        if self._job is not None:
            self._studio.jobs.cancel(self._job)

    def list_models_except(self, excluded_id: str) -> None:
        """List the models of the project except one, and the models read from files.

        The selected model stays selected if possible.
        """
        previous = self.models.currentData()
        open_ids = {m.id for m in self._studio.session.of(Model) if m.id in self._studio.models}
        listed_ids = {self.models.itemData(row) for row in range(self.models.count())} - {""}
        if listed_ids == (open_ids - {excluded_id}) | set(self._files):
            return
        self._excluded_id = excluded_id
        with QSignalBlocker(self.models):
            self.models.clear()
            self._list_other_models()
            index = self.models.findData(previous) if previous else -1
            self.models.setCurrentIndex(max(index, 0))
        if self.models.currentData() != previous:
            self._handle_choice()

    def _list_other_models(self) -> None:
        for model in self._studio.session.of(Model):
            if model.id != self._excluded_id and model.id in self._studio.models:
                self.models.addItem(model.name, model.id)
        for key, other_model in self._files.items():
            self.models.addItem(other_model.name, key)
        if not self.models.count():
            self.models.addItem(tr("Choose a file"), "")

    def _handle_choice(self, *_: object) -> None:
        self.model_changed.emit(self.current())

    def _browse(self) -> None:
        name, _ = QFileDialog.getOpenFileName(
            self,
            tr("Another model of the same rock"),
            start_folder(self._studio),
            file_filters.models(),
        )
        if name:
            self.load_file(Path(name))

    def load_file(self, path: Path) -> None:
        """Read the model of a file and select it."""
        studio = self._studio
        self.browse.setEnabled(False)
        self.status_changed.emit(tr("Reading {file}…", file=path.name))

        def read(cached_model: CachedModel) -> None:
            self._background.run(
                lambda: _fetch_model(path, cached_model),
                receive_model,
                lambda error: report_failure(str(error)),
            )

        def receive_model(other_model: OtherModel) -> None:
            self._job = None
            self.browse.setEnabled(True)
            self._add(other_model)

        def report_failure(reason: str) -> None:
            self._job = None
            self.browse.setEnabled(True)
            self.status_changed.emit(reason)

        def handle_failure(event: Failed) -> None:
            report_failure(str(Finding("job.stopped")) if event.cancelled else event.message)

        self._job = studio.jobs.submit(
            LOAD_MODEL,
            ModelFile(path, studio.project.cache),
            title=tr("Opening {file}", file=path.name),
            on_done=self._background.guard(read),
            on_failed=self._background.guard(handle_failure),
        )

    def _add(self, other_model: OtherModel) -> None:
        key = str(other_model.path)
        is_listed = key in self._files
        self._files[key] = other_model
        if not self.models.currentData() and self.models.count() == 1:
            self.models.setItemText(0, other_model.name)
            self.models.setItemData(0, key)
            self._handle_choice()
            return
        if not is_listed:
            self.models.addItem(other_model.name, key)
        self.models.setCurrentIndex(self.models.findData(key))


def _fetch_model(path: Path, cached_model: CachedModel) -> OtherModel:
    """Read the model from the cache. Runs in a worker thread."""
    from vomstudio.io.models import model_cache
    from vomstudio.io.models.frames import establish_frame

    loaded_model = model_cache.open_cache_folder(cached_model.folder)
    established = establish_frame(replace(loaded_model, path=path))
    return OtherModel(
        path.name,
        path,
        loaded_model.data,
        established.to_world(),
        established.frame,
        registration=established.registration,
    )
