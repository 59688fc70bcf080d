"""Photo set with its survey check and reconstruction, which run in worker processes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QTimer, Signal

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry import transform
from vomstudio.geometry.frames import Frame
from vomstudio.geometry.registrations import Registration
from vomstudio.io.control.control_files import find_control, find_program_control
from vomstudio.io.control.points import CONTROL, MARKS
from vomstudio.project.edit import Edit
from vomstudio.project.photo_edits import photo_set_name
from vomstudio.project.reconstructions import RECONSTRUCTIONS
from vomstudio.project.records import Model
from vomstudio.studio.jobs.events import Failed
from vomstudio.studio.jobs.job import Job, Lane, Request, Result
from vomstudio.studio.running_jobs import RunningJob
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.photos import reconstruction_folders
from vomstudio.ui.panels.photos.photo_document import PhotoDocument
from vomstudio.ui.panels.photos.photo_exports import PhotoExports
from vomstudio.ui.panels.photos.photo_findings import (
    control_findings,
    finished_reconstruction,
    placement_findings,
)
from vomstudio.ui.panels.photos.photo_import import PhotoImport
from vomstudio.ui.panels.photos.photo_row import PhotoRow, add_findings
from vomstudio.ui.panels.photos.reconstruction_settings import ReconstructionSettings

if TYPE_CHECKING:
    from vomstudio.core.findings import Finding
    from vomstudio.photogrammetry.survey.check_results import SurveyReport
    from vomstudio.studio.jobs.photo_tasks import PhotoListing
    from vomstudio.studio.jobs.reconstruct_options import Quality
    from vomstudio.studio.jobs.reconstruction_tasks import Reconstruction
    from vomstudio.studio.jobs.survey_tasks import ControlSummary, ReconstructionForecast

# Longer than the time after which a worker is killed.
_STOP_TIMEOUT_S = 10.0
# Marks are often placed in quick succession.
_TABLES_DELAY_MS = 1000

JobRequest = tuple[Job[Request, Result], Request]


class PhotoSurvey(QObject):
    """Photo set of the Photos panel, with its survey check and reconstruction.

    Attributes
    ----------
    changed : Signal
        Emitted when anything that the panel shows has changed.
    rows_changed : Signal
        Emitted when the photos have changed.
    masks_changed : Signal
        Emitted when masks of the photos have changed.
    marks_changed : Signal
        Emitted when tables of points or marks have been written.
    edited : Signal
        Emitted with each edit of the project.
    history_changed : Signal
        Emitted when the edit history of the project has changed.
    model_created : Signal
        Emitted when the model of a finished reconstruction has been added to the project.
    """

    changed = Signal()
    rows_changed = Signal()
    masks_changed = Signal()
    marks_changed = Signal()
    edited = Signal(object)
    history_changed = Signal()
    model_created = Signal()

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self.folder: Path | None = None
        self.rows: list[PhotoRow] = []
        self.findings: tuple[Finding, ...] = ()
        self.verdict = ""
        self.exclusions: list[Finding] = []
        self.problem = ""
        self.frame: Frame | None = None
        """Frame of the positions of the rows; None for GPS positions."""
        self.control_finding: Finding | None = None
        self.result: Reconstruction | None = None
        self._list_job: RunningJob | None = None
        self._check_job: RunningJob | None = None
        self._reconstruction_job: RunningJob | None = None
        self._is_restart_pending = False
        self.settings = ReconstructionSettings()
        self.forecast: ReconstructionForecast | None = None
        self._forecast_job: RunningJob | None = None
        self.document = PhotoDocument(studio)
        self.exports = PhotoExports(self.document)
        self.sidecar_import = PhotoImport(studio, self.document, self.exports)
        self.exports.tables_written.connect(self.marks_changed)
        self.document.masks_changed.connect(self._show_masks)
        studio.edited.connect(self.edited)
        studio.edited.connect(self._follow_edit)
        studio.model_loaded.connect(lambda *_: self.changed.emit())
        studio.history_changed.connect(self.history_changed)
        self._tables_timer = QTimer(self, singleShot=True, interval=_TABLES_DELAY_MS)
        self._tables_timer.timeout.connect(self.update_control)
        studio.jobs.closed.connect(self._tables_timer.stop)
        self.marks_changed.connect(self._tables_timer.start)
        # After the next project has been opened, the masks of this project cannot be found any
        # more.
        studio.workspace.projects.leaving.connect(self.exports.finish)
        studio.project_opened.connect(self._project_opened)
        studio.jobs_changed.connect(self.changed)

    # --- state -------------------------------------------------------------------------------
    @property
    def quality(self) -> str:
        return self.settings.options.quality

    @property
    def is_listing(self) -> bool:
        """Whether the photos or the files beside them are being read."""
        return self._list_job is not None

    @property
    def is_reading(self) -> bool:
        """Whether the photos are being read or checked."""
        return self._list_job is not None or self._check_job is not None

    def crs_codes(self) -> list[str]:
        """Return the CRS codes of the models of the project."""
        return self._studio.crs_codes()

    @property
    def reconstruction_job(self) -> RunningJob | None:
        """Running reconstruction job, or None if no reconstruction is running."""
        return self._reconstruction_job

    def reconstruction_problem(self) -> Finding | None:
        """Return why no reconstruction can be started, or None if one can be started."""
        if self._reconstruction_job is not None:
            return Finding("action.reconstruction-running")
        if self.folder is None:
            return Finding("action.no-photos")
        if self.is_listing:
            return Finding("photos.pending")
        if len(self.rows) < 2:
            return Finding("action.too-few-photos")
        if self._tables_timer.isActive():
            return Finding("control.pending")
        if self.settings.control is not None:
            if self._forecast_job is not None:
                return Finding("control.pending")
            facts = self.control_facts
            if facts is not None and (problem := facts.problem):
                return Finding("action.control-unusable", reason=problem)
        return None

    @property
    def control_facts(self) -> ControlSummary | None:
        """Facts about the control points, or None if there are none or they are unchecked."""
        return None if self.forecast is None else self.forecast.control

    def output_folder(self) -> Path | None:
        """Return the reconstruction folder for this quality, or None if no photos are open."""
        if self.folder is None:
            return None
        project = self._studio.project.folder
        return reconstruction_folders.reconstruction_folder(project, self.folder, self.quality)

    def set_quality(self, quality: Quality) -> None:
        options = replace(self.settings.options, quality=quality)
        self.apply_settings(replace(self.settings, options=options))

    def apply_settings(self, settings: ReconstructionSettings) -> None:
        """Apply the settings of the next reconstruction."""
        previous_settings, self.settings = self.settings, settings
        if self.reconstruction_job is None and not self.is_reading and self.rows:
            if previous_settings.options.quality != settings.options.quality:
                self._show_cameras()
                self.rows_changed.emit()
            self.update_forecast()
        self.changed.emit()

    @property
    def is_begun(self) -> bool:
        """Whether an earlier run has completed some but not all stages."""
        out = self.output_folder()
        return out is not None and reconstruction_folders.is_begun(out)

    # --- photos ------------------------------------------------------------------------------
    def open(self, folder: Path, settings: ReconstructionSettings | None = None) -> None:
        """List the photos in a folder, then check them.

        Parameters
        ----------
        folder : Path
        settings : ReconstructionSettings, optional
            By default, the previous settings with the control points found beside these photos.
        """
        from vomstudio.ui.panels.photos.survey_requests import list_request

        self._stop_reading()
        self.exports.end()
        self.folder, self.sidecar_import.user_control = folder, None
        self.document.set_folder(folder)
        self.settings = settings or self._add_tables(self.settings.adapt_to_photos(folder))
        self.forecast = None
        self.rows, self.findings, self.exclusions = [], (), []
        self.verdict, self.problem, self.result = "", "", None
        self.frame = None
        self.rows_changed.emit()
        request = list_request(folder, self._studio.project.cache)
        self._list_job = self._read_photos(request, tr("Reading photos"), self._show_photos)
        self.changed.emit()

    def _check(self) -> None:
        from vomstudio.ui.panels.photos.survey_requests import check_request

        assert self.folder is not None
        request = check_request(self.folder, self._studio.project.cache, self._masks())
        self._check_job = self._read_photos(request, tr("Checking the survey"), self._show_check)
        self.changed.emit()

    def _read_photos(
        self, request: JobRequest[Request, Result], title: str, callback: Callable[[Result], None]
    ) -> RunningJob:
        """Start a job whose result is used unless another folder is opened in the meantime."""

        def end() -> bool:
            if job is self._list_job:
                self._list_job = None
            elif job is self._check_job:
                self._check_job = None
            else:
                return False
            return True

        def handle_result(result: Result) -> None:
            if end():
                callback(result)
                self.changed.emit()

        def handle_failure(event: Failed) -> None:
            if end():
                if not event.cancelled:
                    self.problem = event.message
                self.changed.emit()

        job = self._studio.jobs.submit(
            *request, title=title, on_done=handle_result, on_failed=handle_failure
        )
        return job

    def _masks(self) -> dict[str, Path] | None:
        """Return the masks of the project by photo name, or None before the photos are imported."""
        if not self.document.is_imported:
            return None
        return {row.name: Path(row.mask) for row in self.rows if row.mask is not None}

    def _show_photos(self, photos: PhotoListing) -> None:
        self.rows = [PhotoRow(**vars(row), sidecar_mask=row.mask) for row in photos.rows]
        self.exclusions = list(photos.left_out)
        self.rows_changed.emit()
        self.update_forecast()
        self._import_sidecars()

    def _show_check(self, report: SurveyReport) -> None:
        self._apply_report(report)
        out = self.output_folder()
        if (
            out is not None
            and (newer_report := reconstruction_folders.read_survey_report(out)) is not None
        ):
            self._apply_report(newer_report)
        self._show_cameras()
        self.rows_changed.emit()

    @property
    def is_forecasting(self) -> bool:
        return self._forecast_job is not None

    def update_forecast(self) -> None:
        """Compute the forecast for these photos and settings, then emit `changed`."""
        from vomstudio.ui.panels.photos.survey_requests import forecast_request

        if self.folder is None:
            return
        settings = self.settings

        def handle_result(result: ReconstructionForecast) -> None:
            if self._forecast_job is not job:
                return
            self._forecast_job = None
            facts = result.control
            if settings.has_sidecar_control and facts is not None and facts.problem:
                # The user did not select these files, so they must not prevent a reconstruction.
                self.settings = settings.drop_control()
                self.control_finding = Finding(
                    "control.not-used",
                    table=Path(str(settings.control)).name,
                    reason=facts.problem,
                )
                result = replace(result, control=None)
            self.forecast = result
            self.rows_changed.emit()
            self.changed.emit()

        def handle_failure(event: Failed) -> None:
            if self._forecast_job is job:
                self._forecast_job = None
                if not event.cancelled:
                    self._studio.warn(event.to_error())
                self.changed.emit()

        self.control_finding = None
        job = self._studio.jobs.submit(
            *forecast_request(self.folder, self.rows, settings),
            title=tr("Checking control points and memory"),
            on_done=handle_result,
            on_failed=handle_failure,
            is_quiet=True,
        )
        self._forecast_job = job

    def update_control(self) -> None:
        """Use new control points and marks beside the photos if no others were selected."""
        self._tables_timer.stop()
        if self.folder is None:
            return
        if self.settings.has_sidecar_control or self.settings.control in (
            None,
            self.sidecar_import.user_control,
        ):
            self.settings = self._add_tables(self.settings)
        self.update_forecast()
        self.changed.emit()

    def control_findings(self) -> list[Finding]:
        """Return the findings about the control points."""
        return control_findings(self.control_facts, self.control_finding)

    def placed_models(self) -> list[Model]:
        """Return the models reconstructed at the current quality that have scale or north."""
        out = self.output_folder()
        if out is None:
            return []
        folder = (RECONSTRUCTIONS, out.name)
        return [
            model
            for model in self._studio.session.of(Model)
            if Path(model.path).parts[:-1] == folder
            and (model.frame.has_metres or model.frame.has_north)
        ]

    def placement_findings(self) -> list[Finding]:
        """Return the placement of each placed model, with the warnings of its registration."""
        models = self._studio.models
        return [
            finding
            for model in self.placed_models()
            for finding in placement_findings(
                model, models[model.id].resolution if model.id in models else None
            )
        ]

    def metres_per_unit(self) -> float | None:
        """Return the scale of a placed model of these photos, or None if no model has one."""
        scales = [
            transform.scale_factor(model.to_world)
            for model in self.placed_models()
            if model.frame.has_metres
        ]
        return scales[0] if scales else None

    def _follow_edit(self, edit: Edit) -> None:
        records = (*edit.before.values(), *edit.after.values())
        if any(isinstance(record, Model | Registration) for record in records):
            self._show_cameras()
            self.rows_changed.emit()
            self.changed.emit()

    def _apply_report(self, report: SurveyReport) -> None:
        """Show the findings of a survey check made before or after the alignment."""
        self.findings, self.verdict = report.findings, report.verdict
        add_findings(self.rows, report)

    def _stop_reading(self) -> None:
        self._forecast_job = None
        for job in (self._list_job, self._check_job):
            if job is not None:
                self._studio.jobs.cancel(job)
        self._list_job = self._check_job = None

    # --- masks and marks ---------------------------------------------------------------------
    def tables(self) -> tuple[Path | None, Path | None]:
        """Return the files of the control points and of the marks; a missing file is None.

        Files with standard names beside the photos take precedence over tables in the project, and
        these over files of other programs with other names.
        """
        if self.folder is None:
            return None, None
        if (sidecars := find_control(self.folder)) is not None:
            return sidecars
        control, marks = self.exports.table(CONTROL), self.exports.table(MARKS)
        if control is None and marks is None:
            return find_program_control(self.folder) or (None, None)
        return (None if marks is None else control), marks

    def import_sidecars(self) -> None:
        """Replace the records with the contents of the files beside the photos."""
        if self.folder is not None and not self.is_reading and self.reconstruction_job is None:
            self._import_sidecars(is_repeat=True)

    def _import_sidecars(self, *, is_repeat: bool = False) -> None:
        def handle_result(failure: Failed | None) -> None:
            self._list_job = None
            if failure is not None and not failure.cancelled:
                self.problem = failure.message
            elif failure is None:
                self._show_masks()
                self.rows_changed.emit()
                self._check()
            self.changed.emit()

        user_tables = self.settings.control, self.settings.marks
        is_running = self.sidecar_import.begin(
            self.rows, user_tables, handle_result, is_repeat=is_repeat
        )
        if is_running is not None:
            self._list_job = is_running
            self.changed.emit()

    def _show_masks(self, _: object = None) -> None:
        self.document.fill_mask_paths(self.rows)
        self.masks_changed.emit()

    def _add_tables(self, settings: ReconstructionSettings) -> ReconstructionSettings:
        control, marks = self.tables()
        return settings.replace_control(control, marks, is_sidecar=True)

    def alignment_folder(self) -> Path | None:
        """Return the folder of the reconstruction at this quality, or else of the newest one.

        The result is None if no reconstruction of these photos has cameras.
        """
        out = self.output_folder()
        if out is None or self.folder is None:
            return None
        return reconstruction_folders.find_alignment(out, self.folder)

    def repeat_check(self) -> None:
        """Repeat the survey check after masks have changed."""
        if not self.is_reading and self.reconstruction_job is None and self.rows:
            self._check()

    # --- reconstruction ----------------------------------------------------------------------
    def reconstruct(self) -> None:
        """Start a reconstruction, or continue a paused one."""
        from vomstudio.studio.jobs.reconstruction_tasks import RECONSTRUCT

        out, folder = self.output_folder(), self.folder
        if self.reconstruction_problem() is not None or out is None or folder is None:
            return
        request = self.settings.build_request(folder, out)
        if (facts := self.control_facts) is not None and facts.crs:
            # The reconstruction itself would interpret a missing CRS as a local frame.
            request = replace(request, crs=facts.crs)
        if self.settings.control is None:
            # Tie points connect the photos, whichever observations register the model.
            request = replace(request, marks=self.tables()[1])
        session, name = self._studio.session, photo_set_name(folder)
        self.result = None
        reconstruction_folders.store_failure(out, "")

        def handle_result(result: Reconstruction) -> None:
            self._reconstruction_job, self._is_restart_pending = None, False
            self._studio.info(finished_reconstruction(name, result))
            if self._studio.session is not session:
                self._studio.info(Finding("reconstruction.other-project", file=result.mesh))
                self.changed.emit()
                return
            self.result = result
            self._apply_report(result.survey)
            self._show_cameras()
            self.rows_changed.emit()
            for warning in result.warnings[:2]:
                self._studio.warn(warning, warning.severity)
            # The project may have been saved under another name in the meantime.
            target = self._studio.project.folder / RECONSTRUCTIONS / out.name
            if (photo_set := self.document.photo_set) is not None:
                reconstruction_folders.record_reconstruction(
                    self._studio, photo_set.id, target, name
                )
            self._studio.open_model(
                target / Path(result.mesh).name,
                name,
                finished_callback=lambda _: self.model_created.emit(),
            )

        def handle_failure(event: Failed) -> None:
            self._reconstruction_job = None
            if event.cancelled and self._is_restart_pending:
                self._is_restart_pending = False
                self.reconstruct()
            elif not event.cancelled:
                reconstruction_folders.report_failure(self._studio, out, event)
            self.changed.emit()

        self._reconstruction_job = self._studio.jobs.submit(
            RECONSTRUCT,
            replace(request, masks=self._masks()),
            title=tr("Reconstructing {name}", name=name),
            on_done=handle_result,
            on_failed=handle_failure,
            is_resumable=True,
        )
        self.changed.emit()

    def stop_before_move(self) -> None:
        """Stop the reconstruction before the project moves; it continues in the new folder."""
        if self._reconstruction_job is not None:
            self._is_restart_pending = True
            self.pause()
            self._studio.jobs.finish(Lane.RECONSTRUCTION, _STOP_TIMEOUT_S)

    def pause(self) -> None:
        """Pause the reconstruction; `reconstruct` resumes it after the completed stages."""
        if self._reconstruction_job is not None:
            self._studio.jobs.cancel(self._reconstruction_job)

    def _show_cameras(self) -> None:
        out = self.output_folder()
        if out is None:
            return
        model = next(iter(self.placed_models()), None)
        frame = reconstruction_folders.fill_camera_positions(out, self.rows, model)
        if frame is not None:
            self.frame = frame

    def _project_opened(self) -> None:
        self._stop_reading()
        self.exports.end()
        self.folder, self.rows, self.findings, self.result = None, [], (), None
        self.verdict, self.problem, self.control_finding = "", "", None
        self.forecast, self.frame, self.exclusions = None, None, []
        self.settings = ReconstructionSettings()
        self.document.set_folder(None)
        self.rows_changed.emit()
        # The newest reconstruction is the one the user worked on last.
        project = self._studio.project.folder
        if (newest := reconstruction_folders.find_newest(project)) is not None:
            self.open(*newest)
        elif (photos := self.document.last_folder()) is not None:
            self.open(photos)
