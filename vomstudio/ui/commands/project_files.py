"""Dialogs of the File and Model menus: open, save, export, locate and close."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

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
from vomstudio.project.journal.failures import is_lost
from vomstudio.project.measurement_cache import Measurements
from vomstudio.project.paths import PROJECT_SUFFIX, is_project
from vomstudio.project.records import Model
from vomstudio.studio.discarded_work import list_discarded_work
from vomstudio.studio.jobs.events import Failed
from vomstudio.studio.jobs.model_tasks import EXPORT_MODEL, ExportedModel, ModelExport
from vomstudio.ui.base import file_filters
from vomstudio.ui.base.command_targets import (
    ask_for_file,
    ask_for_target,
    current_model,
    remember_target,
    results_folder,
    start_folder,
)
from vomstudio.ui.base.controls import escape_markup
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.window_fitting import fit_to_screen
from vomstudio.ui.dialogs.frame_dialog import FrameDialog
from vomstudio.ui.panels.photos.photo_survey import PhotoSurvey
from vomstudio.ui.widgets.copied_command import CommandArguments, copy_command

if TYPE_CHECKING:
    from vomstudio.products.report.project import ProjectReport

_EXPORT_TITLES = {
    "csv": to_translate("Orientation table"),
    "gpkg": to_translate("GeoPackage"),
    "shp": to_translate("Shapefiles"),
    "dxf": to_translate("DXF"),
}

TITLES = {
    "written": to_translate("{project}{unsaved} – VOM Studio"),
    "unwritable": to_translate("{project}{unsaved} (cannot be written) – VOM Studio"),
    "in-memory": to_translate("{project}{unsaved} (in memory only) – VOM Studio"),
}
"""Titles of the window, by the state of the project on disk."""

_PROGRAM_FORMATS = {
    "geojson": (to_translate("GeoJSON (*.geojson)"), ".geojson"),
    "kml": (to_translate("KML for Google Earth (*.kml)"), ".kml"),
    "stereonet": (to_translate("Stereonet: planes and lines (*.txt)"), "_stereonet.txt"),
    "orient": (to_translate("Orient (*.tsv)"), "_orient.tsv"),
    "faultkin": (to_translate("FaultKin: fault slips (*.txt)"), "_faultkin.txt"),
    "wintensor": (to_translate("Win-Tensor: fault slips (*.txt)"), "_wintensor.txt"),
    "gempy": (to_translate("GemPy: orientations and surface points (*.csv)"), "_gempy.csv"),
    "loopstructural": (to_translate("LoopStructural (*.csv)"), "_loopstructural.csv"),
    "gems": (to_translate("GeMS OrientationPoints (*.csv)"), "_gems.csv"),
}
"""File filter of the dialog and suffix of the file name, by program format."""


REPORT = "report"
"""Value used instead of an export format by the command that writes a report."""


class Files(QObject):
    """Actions that open, save and export projects and models through dialogs of `parent`."""

    opened = Signal()
    """Emitted when the user has opened a model or a project."""
    choice_started = Signal()
    """Emitted before the user is asked for a model or a project."""

    def __init__(self, parent: QWidget, studio: Studio, survey: PhotoSurvey) -> None:
        super().__init__(parent)
        self._parent, self._studio, self._survey = parent, studio, survey
        self._frame_dialog: FrameDialog | None = None
        self._pending_ids: list[str] = []
        self._last_export: tuple[str, Path] | None = None
        self._background = QtBackground(self)
        studio.project_opened.connect(self._begin_project)

    def _begin_project(self) -> None:
        self._last_export = None

    def project_name(self) -> str:
        """Return the name of the open project as used in titles, or "untitled"."""
        project = self._studio.project
        return tr("untitled") if project.is_untitled else project.name

    def window_title(self) -> str:
        """Return the window title, which shows whether the project is saved and writable."""
        values = {
            "project": self.project_name(),
            "unsaved": "*" if self._studio.session.dirty else "",
        }
        projects = self._studio.workspace.projects
        state = "written" if projects.is_written else "unwritable"
        return tr(TITLES[state if projects.is_complete_on_disk else "in-memory"], **values)

    def open_path(self, path: Path) -> None:
        """Open a model or a project; before a project is opened, offer to save the current one."""
        if is_project(path) and not self.ask_to_save():
            return
        self._studio.open_path(path)
        self.opened.emit()

    def choose_model(self) -> None:
        """Ask for model files and open them."""
        self.choice_started.emit()
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
        self.choice_started.emit()
        name = QFileDialog.getExistingDirectory(
            self._parent, tr("Open project (a folder NAME.vom)"), start_folder(self._studio)
        )
        if name:
            self.open_path(Path(name))

    def new_project(self) -> None:
        """Open an untitled project after offering to save the current one."""
        if self.ask_to_save():
            self.attempt(self._studio.new_project)

    def save(self) -> bool:
        """Save the project, and return whether it was saved.

        The user is asked for a folder if the project is untitled or its folder no longer exists.
        """
        project = self._studio.project
        failure = project.write_failure
        if project.is_untitled or (failure is not None and is_lost(failure)):
            return self.save_as()
        return self.attempt(self._studio.save)

    def save_as(self) -> bool:
        """Ask for a folder, save the project there, and return whether it was saved."""
        project = self._studio.project
        return self._save_to_selected_folder(
            tr("Save project as"), "outcrop" if project.is_untitled else project.name
        )

    def choose_project_folder(self, photos: str) -> bool:
        """Ask for the folder of an untitled project before a model is created in it.

        Parameters
        ----------
        photos : str
            Name of the photo folder, which is the proposed project name.

        Returns
        -------
        bool
            False if the user cancelled or the project could not be saved in the folder.
        """
        if not self._studio.project.is_untitled:
            return True
        title = tr("Save the project for the model of {photos}", photos=photos)
        return self._save_to_selected_folder(title, photos)

    def _save_to_selected_folder(self, title: str, stem: str) -> bool:
        """Ask for a folder and save the project there; an unused name is proposed."""
        name, _ = QFileDialog.getSaveFileName(
            self._parent,
            title,
            str(_unused_folder(results_folder(self._studio), stem)),
            tr("VOM Studio project (*{suffix})", suffix=PROJECT_SUFFIX),
        )
        if not name:
            return False
        folder = Path(name if name.endswith(PROJECT_SUFFIX) else name + PROJECT_SUFFIX)
        self._survey.stop_before_move()
        return self.attempt(lambda: self._studio.save_as(folder))

    def export(self, format_: str) -> None:
        """Ask for a file and export the features in a format such as "csv"."""
        path = ask_for_target(
            self._parent,
            self._studio,
            tr("Export"),
            f"{self._file_stem()}.{format_}",
            {format_: tr(_EXPORT_TITLES[format_])},
        )
        if path is not None:
            self.export_features(format_, path)

    def _file_stem(self) -> str:
        project = self._studio.project
        return "orientations" if project.is_untitled else project.name

    def export_for_program(self) -> None:
        """Ask for a program and a file, and export the features in the format of the program."""
        formats = {tr(pattern): format_ for format_, (pattern, _) in _PROGRAM_FORMATS.items()}
        answer = ask_for_file(
            self._parent,
            tr("Export to program"),
            results_folder(self._studio) / self._file_stem(),
            {pattern: _PROGRAM_FORMATS[format_][1] for pattern, format_ in formats.items()},
        )
        if answer is not None:
            path, selected_pattern = answer
            remember_target(self._studio, path)
            self.export_features(formats[selected_pattern], path)

    def export_features(self, format_: str, path: Path) -> None:
        """Export the features to `path`, replacing an existing file."""

        def write() -> None:
            from vomstudio.project.exports.export import export_records

            result = export_records(
                self._studio.records,
                format_,
                path,
                force=True,
                thresholds=self._studio.settings.thresholds,
            )
            files = ", ".join(str(file) for file in result.files)
            self._last_export = format_, path
            self._studio.written(result.files[0], Finding("export.written", file=files))
            for finding in result.warnings:
                self._studio.warn(finding)

        self.attempt(write)

    def write_report(self) -> None:
        """Ask for a file, and write the report of the project to it in the background."""
        studio = self._studio
        path = ask_for_target(
            self._parent,
            studio,
            tr("Write report"),
            f"{'report' if studio.project.is_untitled else studio.project.name}.html",
            {"html": tr("Report")},
        )
        if path is None:
            return
        records, title = dict(studio.records), self.project_name()
        thresholds = studio.settings.thresholds

        def compute() -> ProjectReport:
            from vomstudio.products.report.project import write_project_report

            measurements = Measurements(thresholds)
            return write_project_report(path, records, measurements, title=title, force=True)

        def finish(_: ProjectReport) -> None:
            self._last_export = REPORT, path
            studio.written(path)

        self._background.run(compute, finish, studio.fail)

    def missing_export_finding(self) -> Finding | None:
        """Return a finding if nothing has been exported yet, otherwise None."""
        return Finding("action.nothing-exported") if self._last_export is None else None

    def copy_export_command(self) -> None:
        """Copy to the clipboard the command that repeats the last export."""
        if self._last_export is not None:
            format_, path = self._last_export
            folder = self._studio.project.folder
            arguments: CommandArguments = ["export", folder, ("--to", format_)]
            if format_ == REPORT:
                arguments = ["project", folder, REPORT]
            copy_command(self._studio, [*arguments, ("-o", path), "--force"])

    def export_model(self) -> None:
        """Ask for a file and start a job that exports the current model in the World frame."""
        from vomstudio.io.models.writing import find_writers

        model = current_model(self._studio)
        path = self._studio.project.find_model(model) if model is not None else None
        if model is None or path is None:
            return
        formats = {
            extension.removeprefix("."): tr(writer.name)
            for writer in find_writers()
            for extension in writer.extensions
        }
        suffix = path.suffix.lower().removeprefix(".")
        output_path = ask_for_target(
            self._parent,
            self._studio,
            tr("Export {model} as", model=model.name),
            f"{model.name}_export.{suffix if suffix in formats else 'ply'}",
            formats,
        )
        if output_path is None:
            return

        def handle_result(result: ExportedModel) -> None:
            self._studio.written(output_path)
            for warning in result.warnings:
                self._studio.warn(warning)

        def handle_failure(event: Failed) -> None:
            if not event.cancelled:
                self._studio.warn(event.to_error(), "error")

        self._studio.jobs.submit(
            EXPORT_MODEL,
            ModelExport(
                path=path,
                cache=self._studio.project.cache,
                to_world=model.to_world,
                crs=world_crs(model.frame.crs, model.frame.unit_m),
                out=output_path,
                axes=model.frame.axes,
                registration=model.registration,
            ),
            title=tr("Exporting {model}", model=model.name),
            on_done=handle_result,
            on_failed=handle_failure,
        )

    def attempt(self, action: Callable[[], None]) -> bool:
        """Call an action and show its error if it fails; return whether it succeeded."""
        try:
            action()
        except VomError as error:
            self._studio.fail(error)
            return False
        return True

    def ask_to_save(self) -> bool:
        """Offer to save before the project is closed, and return whether it may be closed.

        This is not the case if the user cancels, or if the project could not be saved.
        """
        studio = self._studio
        if studio.has_work_to_save:
            box = QMessageBox(self._parent)
            box.setIcon(QMessageBox.Icon.Question)
            project = escape_markup(self.project_name())
            box.setText(Finding("project.save-changes", project=project).message)
            failure = studio.project.write_failure
            box.setInformativeText(
                tr("Discarded changes stay in the project's history and can be restored with Undo.")
                if failure is None
                else Finding("project.memory-lost", failure=escape_markup(failure.message)).message
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
        # If this cannot be written, the changes remain in the journal. A full disk must not prevent
        # the window from closing.
        self.attempt(studio.discard)
        return True

    # --- models ------------------------------------------------------------------------------
    def declare_frame(self, model_id: str | None = None) -> None:
        """Show the frame dialog for a model, by default the current one.

        The dialog stays beside the window, because the user finds the up axis by rotating the
        model. Models that are opened in the meantime are queued.
        """
        open_dialog = self._frame_dialog
        if (
            model_id is not None
            and open_dialog is not None
            and isValid(open_dialog)
            and open_dialog.isVisible()
        ):
            self._pending_ids.append(model_id)
            return
        model = self._studio.records.get(model_id) if model_id else current_model(self._studio)
        if not isinstance(model, Model):
            return
        if self._frame_dialog is not None and isValid(self._frame_dialog):
            self._frame_dialog.close()
        open_model = self._studio.models.get(model.id)
        dialog = FrameDialog(self._parent, model, open_model, self._studio.crs_codes())
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.accepted.connect(lambda: self._apply_frame(model.id, dialog.frame))
        dialog.finished.connect(self._declare_next_frame)
        self._studio.project_opened.connect(dialog.close)
        fit_to_screen(dialog)
        self._frame_dialog = dialog
        dialog.show()

    def _declare_next_frame(self, answer: int) -> None:
        """Show the frame dialog for the next model in the queue, unless the last was cancelled."""
        pending_ids = [
            i for i in self._pending_ids if isinstance(self._studio.records.get(i), Model)
        ]
        self._pending_ids = pending_ids[1:] if answer == QDialog.DialogCode.Accepted else []
        if not pending_ids:
            return
        if answer == QDialog.DialogCode.Accepted:
            QTimer.singleShot(0, self, partial(self.declare_frame, pending_ids[0]))
            return
        self._studio.warn(Finding("frame.undeclared", count=len(pending_ids)))

    def _apply_frame(self, model_id: str, frame: Frame) -> None:
        """Declare a frame for the model; ask first if this would replace a registration."""
        model = self._studio.records.get(model_id)
        if not isinstance(model, Model) or frame == model.frame:
            return
        open_model = self._studio.models.get(model_id)
        try:
            findings = () if open_model is None else check_frame(frame, open_model.data.bounds)
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
                    model=escape_markup(model.name),
                    registration=escape_markup(registration.name),
                ),
            )
            if answer != QMessageBox.StandardButton.Yes:
                return
        self._studio.attempt(
            edits.declare_frame, model.id, frame, replaces_registration=registration is not None
        )

    def locate_model(self) -> None:
        """Ask for the file of the current model and open the file."""
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
        """Remove the current model from the project but not from the disk."""
        model = current_model(self._studio)
        if model is not None:
            self._studio.attempt(edits.remove_model, model.id)

    def fill_recent_menu(self, menu: QMenu) -> None:
        """Fill the menu of recent projects and models, in which missing files are disabled."""
        menu.clear()
        for text in self._studio.settings.recent:
            action = menu.addAction(text)
            action.setEnabled(path_exists(text))
            action.triggered.connect(lambda _=False, p=text: self.open_path(Path(p)))
        if menu.isEmpty():
            menu.addAction(tr("No recent files")).setEnabled(False)

    def fill_discarded_menu(self, menu: QMenu) -> None:
        """Fill the menu of untitled projects that were closed without saving, at most 20."""
        menu.clear()
        for project in list_discarded_work():
            action = menu.addAction(project.describe())
            action.setToolTip(tr("Open the project; Undo restores the discarded work."))
            action.triggered.connect(lambda _=False, p=project.folder: self.open_path(p))
        if menu.isEmpty():
            menu.addAction(tr("No discarded work")).setEnabled(False)


def _unused_folder(folder: Path, stem: str) -> Path:
    """Return the path of a project folder that does not exist, adding a number if needed."""
    suffixes = ("", *(f"-{number}" for number in range(2, 1000)))
    folders = [folder / f"{stem}{suffix}{PROJECT_SUFFIX}" for suffix in suffixes]
    return next((candidate for candidate in folders if not candidate.exists()), folders[0])
