"""The dialogs of the menus File and Model: open, save, export, locate, close."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path

from PySide6.QtCore import QObject, Qt, QTimer, Signal
from PySide6.QtWidgets import QDialog, QFileDialog, QMenu, QMessageBox, QWidget
from shiboken6 import isValid

from vomstudio.core.errors import InputError, VomError
from vomstudio.core.files.regular import path_exists
from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.geometry.frames import Frame
from vomstudio.io.gis.crs import world_crs
from vomstudio.io.models.frames import check_frame
from vomstudio.project import edits
from vomstudio.project.exports.export import export_records
from vomstudio.project.folder import SUFFIX, is_project
from vomstudio.project.journal.failures import is_lost
from vomstudio.project.records import Model
from vomstudio.studio.discarded_work import list_discarded_works
from vomstudio.studio.jobs.events import Failed
from vomstudio.studio.jobs.model_tasks import EXPORT_MODEL, ExportedModel, ModelExport
from vomstudio.ui.base import file_filters
from vomstudio.ui.base.command_targets import (
    ask_for_file,
    ask_for_target,
    current_model,
    start_folder,
)
from vomstudio.ui.base.controls import as_words
from vomstudio.ui.base.long_boxes import fit_to_screen
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.dialogs.frame_dialog import FrameDialog
from vomstudio.ui.panels.photos.photo_survey import PhotoSurvey
from vomstudio.ui.widgets.copied_command import copy_command

_EXPORTS = {
    "csv": to_translate("Orientation table"),
    "gpkg": to_translate("GeoPackage"),
    "shp": to_translate("Shapefiles"),
    "dxf": to_translate("DXF"),
}

_PROGRAMS = {
    "geojson": to_translate("GeoJSON (*.geojson)"),
    "kml": to_translate("KML for Google Earth (*.kml)"),
    "stereonet": to_translate("Stereonet: planes and lines (*.txt)"),
    "orient": to_translate("Orient (*.tsv)"),
    "faultkin": to_translate("FaultKin: fault slips (*.txt)"),
    "wintensor": to_translate("Win-Tensor: fault slips (*.txt)"),
    "gempy": to_translate("GemPy: orientations and surface points (*.csv)"),
    "loopstructural": to_translate("LoopStructural (*.csv)"),
    "gems": to_translate("GeMS OrientationPoints (*.csv)"),
}
"""Formats of other programs, each with the words of the dialog."""


class Files(QObject):
    """Dialogs belong to `parent`; the studio does what they decide."""

    opened = Signal()
    """The user has had a model or a project opened."""

    def __init__(self, parent: QWidget, studio: Studio, survey: PhotoSurvey) -> None:
        super().__init__(parent)
        self._parent, self._studio, self._survey = parent, studio, survey
        self._frame_dialog: FrameDialog | None = None
        self._to_ask: list[str] = []
        self._exported: tuple[str, Path] | None = None

    def project_name(self) -> str:
        """Name of the open project for titles; "untitled" where it has none."""
        project = self._studio.project
        return tr("untitled") if project.untitled else project.name

    def window_title(self) -> str:
        """Says of the open project whether it is saved, and whether it is on the disk at all."""
        words = {
            "project": self.project_name(),
            "unsaved": "*" if self._studio.session.dirty else "",
        }
        projects = self._studio.workspace.projects
        if projects.is_written:
            return tr("{project}{unsaved} – VOM Studio", **words)
        if projects.whole_on_disk:
            return tr("{project}{unsaved} (cannot be written) – VOM Studio", **words)
        return tr("{project}{unsaved} (in memory only) – VOM Studio", **words)

    def open_path(self, path: Path) -> None:
        """Open a model or a project; before another project the user is asked to save."""
        if is_project(path) and not self.ask_to_keep():
            return
        self._studio.open_path(path)
        self.opened.emit()

    def choose_model(self) -> None:
        """Ask for files of models and open them."""
        names, _ = QFileDialog.getOpenFileNames(
            self._parent,
            tr("Open model"),
            start_folder(self._studio),
            file_filters.models(),
        )
        for name in names:
            self.open_path(Path(name))

    def choose_project(self) -> None:
        """Ask for a project folder and open it."""
        name = QFileDialog.getExistingDirectory(
            self._parent, tr("Open project (a folder NAME.vom)"), start_folder(self._studio)
        )
        if name:
            self.open_path(Path(name))

    def new_project(self) -> None:
        """Open an untitled project, after asking whether to save the present one."""
        if self.ask_to_keep():
            self.attempt(self._studio.new_project)

    def save(self) -> bool:
        """Save the project, an untitled one under a name that is asked for, as one that is no
        longer at its place; False where it is not saved."""
        project = self._studio.project
        failure = project.write_failure
        if project.untitled or (failure is not None and is_lost(failure)):
            return self.save_as()
        return self.attempt(self._studio.save)

    def save_as(self) -> bool:
        """Ask for a folder and save the project there; False where it is not saved."""
        project = self._studio.project
        return self._save_where(
            tr("Save project as"), "outcrop" if project.untitled else project.name
        )

    def place_for(self, photos: str) -> bool:
        """Ask where the project is to be, before a model of photos is made in one without a name:
        the model comes to lie in it. photos : the name of their folder, proposed for the project.
        False, with nothing changed, where the user has cancelled or it cannot be there."""
        if not self._studio.project.untitled:
            return True
        title = tr(
            "Choose where to save the project; the model of {photos} is made in it", photos=photos
        )
        return self._save_where(title, photos)

    def _save_where(self, title: str, stem: str) -> bool:
        """Ask under a title, and propose a name that is free."""
        name, _ = QFileDialog.getSaveFileName(
            self._parent,
            title,
            str(_free_place(Path(start_folder(self._studio)), stem)),
            tr("VOM Studio project (*{suffix})", suffix=SUFFIX),
        )
        if not name:
            return False
        folder = Path(name if name.endswith(SUFFIX) else name + SUFFIX)
        self._survey.stop_to_move()
        return self.attempt(lambda: self._studio.save_as(folder))

    def export(self, format_: str) -> None:
        """Ask for a file and export the features. format_ : a key of the known formats, as
        "csv"."""
        path = ask_for_target(
            self._parent,
            self._studio,
            tr("Export"),
            f"{self._stem()}.{format_}",
            {format_: tr(_EXPORTS[format_])},
        )
        if path is not None:
            self.export_to(format_, path)

    def _stem(self) -> str:
        project = self._studio.project
        return "orientations" if project.untitled else project.name

    def export_for_program(self) -> None:
        """Ask for a program and a file, and export what the program can take."""
        formats = {tr(pattern): format_ for format_, pattern in _PROGRAMS.items()}
        asked = ask_for_file(
            self._parent,
            tr("Export for another program"),
            Path(start_folder(self._studio)) / self._stem(),
            {pattern: pattern.rpartition("*")[2].rstrip(")") for pattern in formats},
        )
        if asked is not None:
            path, chosen = asked
            self.export_to(formats[chosen], path)

    def export_to(self, format_: str, path: Path) -> None:
        """Export the features to `path`, replacing what is there."""

        def write() -> None:
            made = export_records(
                self._studio.records,
                format_,
                path,
                force=True,
                thresholds=self._studio.settings.thresholds,
            )
            files = ", ".join(str(file) for file in made.files)
            self._exported = format_, path
            self._studio.info(Finding("export.written", file=files))

        self.attempt(write)

    def why_no_export(self) -> Finding | None:
        """Return that nothing was exported yet; None if something was."""
        return Finding("action.nothing-exported") if self._exported is None else None

    def copy_export(self) -> None:
        """Put the command that exports the same on the clipboard."""
        if self._exported is not None:
            format_, path = self._exported
            folder = self._studio.project.folder
            copy_command(
                self._studio, ["export", folder, ("--to", format_), ("-o", path), "--force"]
            )

    def export_model(self) -> None:
        """The current model in World coordinates, in any format that can be written, as a job."""
        from vomstudio.io.models.writing import find_writers

        model = current_model(self._studio)
        path = self._studio.project.find_model(model) if model is not None else None
        if model is None or path is None:
            return
        formats = {e.removeprefix("."): tr(w.name) for w in find_writers() for e in w.extensions}
        ending = path.suffix.lower().removeprefix(".")
        out = ask_for_target(
            self._parent,
            self._studio,
            tr("Export {model} as", model=model.name),
            f"{model.name}_export.{ending if ending in formats else 'ply'}",
            formats,
        )
        if out is None:
            return

        def done(made: ExportedModel) -> None:
            self._studio.info(Finding("export.written", file=out))
            for warning in made.warnings:
                self._studio.warn(warning)

        def failed(event: Failed) -> None:
            if not event.cancelled:
                self._studio.warn(event.to_error(), "error")

        self._studio.jobs.submit(
            EXPORT_MODEL,
            ModelExport(
                path,
                self._studio.project.cache,
                model.to_world,
                world_crs(model.frame.crs, model.frame.unit_m),
                out,
                model.frame.axes,
                model.registration,
            ),
            title=tr("Exporting {model}", model=model.name),
            on_done=done,
            on_failed=failed,
        )

    def attempt(self, do: Callable[[], None]) -> bool:
        """Call `do`; False, with the reason shown, where it fails."""
        try:
            do()
        except VomError as error:
            self._studio.fail(error)
            return False
        return True

    def ask_to_keep(self) -> bool:
        """Before the project is closed: save, close without saving, or stay (False)."""
        studio = self._studio
        if studio.has_work_to_save:
            box = QMessageBox(self._parent)
            box.setIcon(QMessageBox.Icon.Question)
            box.setText(tr("Save the changes to {project}?", project=as_words(self.project_name())))
            failure = studio.project.write_failure
            box.setInformativeText(
                tr("Discarded changes stay in the project's history and can be restored with Undo.")
                if failure is None
                else tr(
                    "{failure} What is in memory only is lost unless you save the project "
                    "elsewhere.",
                    failure=as_words(failure.message),
                )
            )
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
        """Show the frame dialog for a model; without an id for the current one.

        It stands beside the window, since which way is up is seen by turning the model. Models that
        come while one is asked about are asked about after it.
        """
        now = self._frame_dialog
        if model_id is not None and now is not None and isValid(now) and now.isVisible():
            self._to_ask.append(model_id)
            return
        model = self._studio.records.get(model_id) if model_id else current_model(self._studio)
        if not isinstance(model, Model):
            return
        if self._frame_dialog is not None and isValid(self._frame_dialog):
            self._frame_dialog.close()
        dialog = FrameDialog(self._parent, model, self._studio.models.get(model.id))
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.accepted.connect(lambda: self._declare(model.id, dialog.frame))
        dialog.finished.connect(self._ask_next)
        self._studio.project_opened.connect(dialog.close)
        fit_to_screen(dialog)
        self._frame_dialog = dialog
        dialog.show()

    def _ask_next(self, answer: int) -> None:
        """Who leaves one question unanswered is not asked the others."""
        waiting = [i for i in self._to_ask if isinstance(self._studio.records.get(i), Model)]
        self._to_ask = waiting[1:] if answer == QDialog.DialogCode.Accepted else []
        if not waiting:
            return
        if answer == QDialog.DialogCode.Accepted:
            QTimer.singleShot(0, self, partial(self.declare_frame, waiting[0]))
            return
        self._studio.warn(Finding("frame.undeclared", count=len(waiting)))

    def _declare(self, model_id: str, frame: Frame) -> None:
        """Apply a declared frame; a registration is replaced only with the user's consent."""
        model = self._studio.records.get(model_id)
        if not isinstance(model, Model):
            return
        opened = self._studio.models.get(model_id)
        try:
            findings = () if opened is None else check_frame(frame, opened.data.bounds)
        except InputError as error:
            self._studio.warn(error, "error")
            return
        for finding in findings:
            self._studio.warn(finding)
        registration = model.registration
        if registration is not None:
            answer = QMessageBox.question(
                self._parent,
                tr("Replace the registration?"),
                tr(
                    "{model} is placed by its registration ({registration}). The declared frame "
                    "replaces it. Undo restores the registration.",
                    model=as_words(model.name),
                    registration=as_words(registration.name),
                ),
            )
            if answer != QMessageBox.StandardButton.Yes:
                return
        self._studio.attempt(
            edits.declare_frame, model.id, frame, instead_of_registration=registration is not None
        )

    def locate_model(self) -> None:
        """Ask for the file of the current model and open it."""
        model = current_model(self._studio)
        if model is None:
            return
        name, _ = QFileDialog.getOpenFileName(
            self._parent,
            tr("Locate {model}", model=model.name),
            start_folder(self._studio),
            file_filters.models(),
        )
        if name:
            self._studio.locate_model(model.id, Path(name))

    def remove_model(self) -> None:
        """Remove the current model from the project; its file stays."""
        model = current_model(self._studio)
        if model is not None:
            self._studio.attempt(edits.remove_model, model.id)

    def fill_recent(self, menu: QMenu) -> None:
        """What was open lately; entries whose file is gone are disabled."""
        menu.clear()
        for text in self._studio.settings.recent:
            action = menu.addAction(text)
            action.setEnabled(path_exists(text))
            action.triggered.connect(lambda _=False, p=text: self.open_path(Path(p)))
        if menu.isEmpty():
            menu.addAction(tr("No recent projects or models")).setEnabled(False)

    def fill_discarded(self, menu: QMenu) -> None:
        """Untitled projects that were closed without saving, the newest 20."""
        menu.clear()
        for work in list_discarded_works():
            action = menu.addAction(work.describe())
            action.setToolTip(tr("Opens the project; Undo restores the discarded work."))
            action.triggered.connect(lambda _=False, p=work.folder: self.open_path(p))
        if menu.isEmpty():
            menu.addAction(tr("No discarded work")).setEnabled(False)


def _free_place(folder: Path, stem: str) -> Path:
    """A project of this name in a folder, numbered where there is one already."""
    ends = ("", *(f"-{number}" for number in range(2, 1000)))
    places = [folder / f"{stem}{end}{SUFFIX}" for end in ends]
    return next((place for place in places if not place.exists()), places[0])
