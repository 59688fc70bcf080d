"""Files and models as the window's menus deal with them: open, save, export, locate, leave."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from PySide6.QtCore import QObject, Qt
from PySide6.QtWidgets import QFileDialog, QMenu, QMessageBox, QWidget

from vomstudio.document import edits
from vomstudio.document.records import Frame, Model
from vomstudio.errors import VomError
from vomstudio.io.models.registry import extensions
from vomstudio.io.project.export import export_records
from vomstudio.io.project.folder import SUFFIX, is_project, untitled_projects
from vomstudio.jobs.events import Failed
from vomstudio.jobs.model_tasks import EXPORT_MODEL, ExportedModel, ModelExport
from vomstudio.ui.common.command_targets import current_model, start_folder
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.photos.photo_survey import PhotoSurvey
from vomstudio.ui.shell.frame_dialog import FrameDialog
from vomstudio.words import tr

_EXPORTS = {
    "csv": "Orientation table (*.csv)",
    "gpkg": "GeoPackage (*.gpkg)",
    "shp": "Shapefiles (*.shp)",
    "dxf": "DXF (*.dxf)",
}


class Files(QObject):
    """Dialogs belong to `parent`; what they decide is done by the studio."""

    def __init__(self, parent: QWidget, studio: Studio, survey: PhotoSurvey) -> None:
        super().__init__(parent)
        self._parent, self._studio, self._survey = parent, studio, survey

    def project_name(self) -> str:
        project = self._studio.project
        return tr("untitled") if project.untitled else project.name

    def open_path(self, path: Path) -> None:
        if is_project(path) and not self.ask_to_keep():
            return
        self._studio.open_path(path)

    def choose_model(self) -> None:
        patterns = " ".join(f"*{e} *{e.upper()}" for e in extensions())
        names, _ = QFileDialog.getOpenFileNames(
            self._parent,
            tr("Open a model"),
            start_folder(self._studio),
            f"Models ({patterns});;All files (*)",
        )
        for name in names:
            self.open_path(Path(name))

    def choose_project(self) -> None:
        name = QFileDialog.getExistingDirectory(
            self._parent, tr("Open a project (a folder NAME.vom)"), start_folder(self._studio)
        )
        if name:
            self.open_path(Path(name))

    def new_project(self) -> None:
        if self.ask_to_keep():
            self.attempt(self._studio.new_project)

    def save(self) -> bool:
        if self._studio.project.untitled:
            return self.save_as()
        return self.attempt(self._studio.save)

    def save_as(self) -> bool:
        name, _ = QFileDialog.getSaveFileName(
            self._parent,
            tr("Save the project as"),
            str(Path(start_folder(self._studio)) / f"outcrop{SUFFIX}"),
            f"VOM Studio project (*{SUFFIX})",
        )
        if not name:
            return False
        folder = Path(name if name.endswith(SUFFIX) else name + SUFFIX)
        self._survey.stop_to_move()
        return self.attempt(lambda: self._studio.save_as(folder))

    def export(self, format_: str) -> None:
        pattern = _EXPORTS[format_]
        stem = "orientations" if self._studio.project.untitled else self._studio.project.name
        name, _ = QFileDialog.getSaveFileName(
            self._parent,
            tr("Export"),
            str(Path(start_folder(self._studio)) / f"{stem}.{format_}"),
            pattern,
        )
        if name:
            path = Path(name if name.endswith(f".{format_}") else f"{name}.{format_}")
            self.export_to(format_, path)

    def export_to(self, format_: str, path: Path) -> None:
        def write() -> None:
            made = export_records(self._studio.records, format_, path, force=True,
                                  thresholds=self._studio.settings.thresholds)  # fmt: skip
            self._studio.info(f"Written: {', '.join(str(file) for file in made.files)}")

        self.attempt(write)

    def export_model(self) -> None:
        """The current model in World, in any format that is written, by a worker."""
        from vomstudio.io.models.writing import find_writers

        model = current_model(self._studio)
        path = self._studio.project.find_model(model) if model is not None else None
        if model is None or path is None:
            return
        patterns = [f"{w.name} ({' '.join(f'*{e}' for e in w.extensions)})" for w in find_writers()]
        name, _ = QFileDialog.getSaveFileName(
            self._parent,
            tr("Export {model} as", model=model.name),
            str(Path(start_folder(self._studio)) / f"{model.name}_export"),
            ";;".join(patterns),
        )
        if not name:
            return

        def done(made: ExportedModel) -> None:
            self._studio.info(" ".join([f"Written: {name}.", *made.warnings]))

        def failed(event: Failed) -> None:
            if not event.cancelled:
                self._studio.warn(event.message, "error")

        self._studio.jobs.submit(
            EXPORT_MODEL,
            ModelExport(
                path, self._studio.project.cache, model.to_world, model.frame.crs, Path(name)
            ),
            title=tr("Exporting {model}", model=model.name),
            on_done=done,
            on_failed=failed,
        )

    def attempt(self, do: Callable[[], None]) -> bool:
        try:
            do()
        except VomError as error:
            self._studio.fail(error)
            return False
        return True

    def ask_to_keep(self) -> bool:
        """Before the project is left: save, leave without saving, or stay (False)."""
        studio = self._studio
        if studio.worth_asking:
            box = QMessageBox(self._parent)
            box.setIcon(QMessageBox.Icon.Question)
            box.setText(tr("Save the changes to {project_name}?", project_name=self.project_name()))
            box.setInformativeText(
                tr("What is not saved now is kept in the project's history and can be "
                        "brought back with Undo.")
            )  # fmt: skip
            box.setStandardButtons(
                QMessageBox.StandardButton.Save
                | QMessageBox.StandardButton.Discard
                | QMessageBox.StandardButton.Cancel
            )
            answer = box.exec()
            if answer == QMessageBox.StandardButton.Cancel:
                return False
            if answer == QMessageBox.StandardButton.Save:
                return self.save()
        # Where even this cannot be written the work stays in the journal; a full disk must not
        # hold the window open.
        self.attempt(studio.discard)
        return True

    # --- models ------------------------------------------------------------------------------
    def declare_frame(self, model_id: str | None = None) -> None:
        model = self._studio.records.get(model_id) if model_id else current_model(self._studio)
        if not isinstance(model, Model):
            return
        dialog = FrameDialog(self._parent, model, self._studio.models.get(model.id))
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.accepted.connect(lambda: self._declare(model, dialog.frame))
        dialog.open()

    def _declare(self, model: Model, frame: Frame) -> None:
        """A registration is given up only when the user says so."""
        registration = model.registration
        if registration is not None:
            answer = QMessageBox.question(
                self._parent,
                tr("Give up the registration?"),
                tr(
                    "{model} is placed by its registration ({registration}). Declaring a frame "
                    "gives that up; undoing brings it back.",
                    model=model.name,
                    registration=registration.name,
                ),
            )
            if answer != QMessageBox.StandardButton.Yes:
                return
        self._studio.attempt(
            edits.declare_frame, model.id, frame, instead_of_registration=registration is not None
        )

    def locate_model(self) -> None:
        model = current_model(self._studio)
        if model is None:
            return
        name, _ = QFileDialog.getOpenFileName(
            self._parent, tr("Where is {model}?", model=model.name), start_folder(self._studio)
        )
        if name:
            self._studio.locate_model(model.id, Path(name))

    def remove_model(self) -> None:
        model = current_model(self._studio)
        if model is not None:
            self._studio.attempt(edits.remove_model, model.id)

    def fill_recent(self, menu: QMenu) -> None:
        menu.clear()
        for text in self._studio.settings.recent:
            action = menu.addAction(text)
            action.setEnabled(Path(text).exists())
            action.triggered.connect(lambda _=False, p=text: self.open_path(Path(p)))
        if menu.isEmpty():
            menu.addAction(tr("Nothing yet")).setEnabled(False)

    def fill_discarded(self, menu: QMenu) -> None:
        menu.clear()
        for folder in untitled_projects(finished=True)[:20]:
            action = menu.addAction(folder.stem)
            action.setToolTip(tr("Opens as it was left; Undo brings the discarded work back"))
            action.triggered.connect(lambda _=False, p=folder: self.open_path(p))
        if menu.isEmpty():
            menu.addAction(tr("Nothing was discarded")).setEnabled(False)
