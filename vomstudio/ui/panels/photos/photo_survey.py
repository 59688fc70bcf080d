"""A folder of photos and its reconstruction: workers list, check and reconstruct the photos."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QTimer, Signal

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry import transform
from vomstudio.geometry.registrations import Registration
from vomstudio.io.control.control_files import find_control
from vomstudio.io.control.points import CONTROL, MARKS
from vomstudio.project.edit import Edit
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
    placement_text,
)
from vomstudio.ui.panels.photos.photo_import import PhotoImport
from vomstudio.ui.panels.photos.photo_row import PhotoRow, add_findings
from vomstudio.ui.panels.photos.reconstruction_settings import ReconstructionSettings

if TYPE_CHECKING:
    from vomstudio.core.findings import Finding
    from vomstudio.photogrammetry.survey.check_results import SurveyReport
    from vomstudio.studio.jobs.photo_tasks import PhotoListing
    from vomstudio.studio.jobs.reconstruction_tasks import Reconstruction
    from vomstudio.studio.jobs.survey_tasks import ControlFacts, ReconstructionForecast

# What does not listen is stopped the hard way before that.
_STOPPING_S = 10.0
# Marks come one soon after the other.
_TABLES_MS = 1000

Asked = tuple[Job[Request, Result], Request]


class PhotoSurvey(QObject):
    """The folder of photos that the Photos panel shows.

    changed: anything that is shown; rows_changed: the photos themselves
    """

    changed = Signal()
    rows_changed = Signal()
    drawn_changed = Signal()
    """Masks of the photos."""
    marks_changed = Signal()
    edited = Signal(object)
    """Edit, of whatever in the project."""
    history_changed = Signal()

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self.folder: Path | None = None
        self.rows: list[PhotoRow] = []
        self.findings: tuple[Finding, ...] = ()
        self.verdict = ""
        self.left_out: list[Finding] = []
        self.problem = ""
        self.has_north = True
        self.control_note: Finding | None = None
        self.result: Reconstruction | None = None
        self._reading: RunningJob | None = None
        self._making: RunningJob | None = None
        self._goes_on = False
        self.settings = ReconstructionSettings()
        self.forecast: ReconstructionForecast | None = None
        self._forecasting: RunningJob | None = None
        self.document = PhotoDocument(studio)
        self.exports = PhotoExports(self.document)
        self.intake = PhotoImport(studio, self.document, self.exports)
        self.exports.tables_written.connect(self.marks_changed)
        self.document.masks_changed.connect(self._show_masks)
        studio.edited.connect(self.edited)
        studio.edited.connect(self._edited)
        studio.model_loaded.connect(lambda *_: self.changed.emit())
        studio.history_changed.connect(self.history_changed)
        self._tables_soon = QTimer(self)
        self._tables_soon.setSingleShot(True)
        self._tables_soon.setInterval(_TABLES_MS)
        self._tables_soon.timeout.connect(self.control_written)
        studio.jobs.closed.connect(self._tables_soon.stop)
        self.marks_changed.connect(self._tables_soon.start)
        # Once the next project is open, the masks of this one are not to be found any more.
        studio.workspace.projects.leaving.connect(self.exports.finish)
        studio.project_opened.connect(self._project_opened)
        studio.jobs_changed.connect(self.changed)

    # --- state -------------------------------------------------------------------------------
    @property
    def quality(self) -> str:
        return self.settings.quality

    @property
    def reading(self) -> bool:
        return self._reading is not None

    @property
    def making(self) -> RunningJob | None:
        """The running reconstruction."""
        return self._making

    def why_not_make(self) -> Finding | None:
        """Return why no reconstruction can be started; None if one can."""
        if self._making is not None:
            return Finding("action.reconstruction-running")
        if self.folder is None:
            return Finding("action.no-photos")
        if self.reading:
            return Finding("photos.pending")
        if len(self.rows) < 2:
            return Finding("action.too-few-photos")
        if self._tables_soon.isActive():
            return Finding("control.pending")
        if self.settings.control is not None:
            if self._forecasting is not None:
                return Finding("control.pending")
            facts = self.control_facts
            if facts is not None and (problem := facts.problem):
                return Finding("action.control-unusable", reason=problem)
        return None

    @property
    def control_facts(self) -> ControlFacts | None:
        """None where no control is chosen or it has not been looked at."""
        return None if self.forecast is None else self.forecast.control

    def out(self) -> Path | None:
        """Where the model of these photos in this quality is made, or was begun."""
        if self.folder is None:
            return None
        project = self._studio.project.folder
        return reconstruction_folders.folder_for(project, self.folder, self.quality)

    def choose_quality(self, quality: str) -> None:
        self.choose(replace(self.settings, quality=quality))

    def choose(self, settings: ReconstructionSettings) -> None:
        """Make the next model like this."""
        before, self.settings = self.settings, settings
        if self.making is None and not self.reading and self.rows:
            if before.quality != settings.quality:
                self._show_cameras()
                self.rows_changed.emit()
            self.update_forecast()
        self.changed.emit()

    @property
    def begun(self) -> bool:
        """An earlier run has finished some stages and no more."""
        out = self.out()
        return out is not None and reconstruction_folders.is_begun(out)

    # --- photos ------------------------------------------------------------------------------
    def open(self, folder: Path, settings: ReconstructionSettings | None = None) -> None:
        """List the photos of a folder, then check them. settings: None for those of before, with
        the control that lies beside these photos."""
        from vomstudio.ui.panels.photos.survey_requests import listing

        self._stop_reading()
        self.exports.end()
        self.folder, self.intake.given_from = folder, None
        self.document.look_at(folder)
        self.settings = settings or self._with_tables(self.settings.for_photos(folder))
        self.forecast = None
        self.rows, self.findings, self.left_out = [], (), []
        self.verdict, self.problem, self.result = "", "", None
        self.has_north = True
        self.rows_changed.emit()
        asked = listing(folder, self._studio.project.cache)
        self._read(asked, tr("Reading photos"), self._listed)

    def _check(self) -> None:
        from vomstudio.ui.panels.photos.survey_requests import check

        assert self.folder is not None
        asked = check(self.folder, self._studio.project.cache, self._masks())
        self._read(asked, tr("Checking the survey"), self._checked)

    def _read(
        self, asked: Asked[Request, Result], title: str, then: Callable[[Result], None]
    ) -> None:
        def done(result: Result) -> None:
            self._reading = None
            then(result)
            self.changed.emit()

        def failed(event: Failed) -> None:
            self._reading = None
            if not event.cancelled:
                self.problem = event.message
            self.changed.emit()

        self._reading = self._studio.jobs.submit(
            *asked, title=title, on_done=done, on_failed=failed
        )
        self.changed.emit()

    def _masks(self) -> dict[str, Path] | None:
        """Those of the project, once the photos are taken in."""
        if not self.document.taken_in:
            return None
        return {row.name: Path(row.mask) for row in self.rows if row.mask is not None}

    def _listed(self, listed: PhotoListing) -> None:
        self.rows = [PhotoRow(**vars(row), found_mask=row.mask) for row in listed.rows]
        self.left_out = list(listed.left_out)
        self.rows_changed.emit()
        self.update_forecast()
        self._take_in()

    def _checked(self, report: SurveyReport) -> None:
        self._take(report)
        out = self.out()
        if out is not None and (after := reconstruction_folders.earlier_survey(out)) is not None:
            self._take(after)
        self._show_cameras()
        self.rows_changed.emit()

    @property
    def forecasting(self) -> bool:
        return self._forecasting is not None

    def update_forecast(self) -> None:
        """Ask a worker what the settings mean for these photos; `changed` tells when it has."""
        from vomstudio.ui.panels.photos.survey_requests import forecast

        if self.folder is None:
            return
        settings = self.settings

        def done(found: ReconstructionForecast) -> None:
            if self._forecasting is not job:
                return
            self._forecasting = None
            facts = found.control
            if settings.found and facts is not None and facts.problem:
                # Nobody asked for these files: they are in the way of no model.
                self.settings = settings.without_control()
                self.control_note = Finding(
                    "control.not-used",
                    table=Path(str(settings.control)).name,
                    reason=facts.problem,
                )
                found = replace(found, control=None)
            self.forecast = found
            self.rows_changed.emit()
            self.changed.emit()

        def failed(event: Failed) -> None:
            if self._forecasting is job:
                self._forecasting = None
                if not event.cancelled:
                    self._studio.warn(event.to_error())
                self.changed.emit()

        self.control_note = None
        job = self._studio.jobs.submit(
            *forecast(self.folder, self.rows, settings),
            title=tr("Checking control points and memory"),
            on_done=done,
            on_failed=failed,
            quiet=True,
        )
        self._forecasting = job

    def control_written(self) -> None:
        """Control points or marks beside the photos are new: they are taken unless other files were
        chosen that are not in them, and looked at again."""
        self._tables_soon.stop()
        if self.folder is None:
            return
        if self.settings.found or self.settings.control in (None, self.intake.given_from):
            self.settings = self._with_tables(self.settings)
        self.update_forecast()
        self.changed.emit()

    def control_findings(self) -> list[Finding]:
        """Return what the control points allow."""
        return control_findings(self.control_facts, self.control_note)

    def placed_models(self) -> list[Model]:
        """Return the models made of these photos in this quality that have scale or north."""
        out = self.out()
        if out is None:
            return []
        folder = (RECONSTRUCTIONS, out.name)
        return [
            model
            for model in self._studio.session.of(Model)
            if Path(model.path).parts[:-1] == folder
            and (model.frame.has_metres or model.frame.has_north)
        ]

    def placement_findings(self) -> list[str]:
        """Return a sentence on the scale, north and resolution of each of these models."""
        opened = self._studio.models
        return [
            placement_text(model, opened[model.id].resolution if model.id in opened else None)
            for model in self.placed_models()
        ]

    def metres_per_unit(self) -> float | None:
        """Return the scale by which a model of these photos was placed, None if it has none."""
        scales = [
            transform.scale_of(model.to_world)
            for model in self.placed_models()
            if model.frame.has_metres
        ]
        return scales[0] if scales else None

    def _edited(self, edit: Edit) -> None:
        records = (*edit.before.values(), *edit.after.values())
        if any(isinstance(each, Model | Registration) for each in records):
            self.changed.emit()

    def _take(self, report: SurveyReport) -> None:
        """The findings of a survey check, before or after the alignment."""
        self.findings, self.verdict = report.findings, report.verdict
        add_findings(self.rows, report)

    def _stop_reading(self) -> None:
        self._forecasting = None
        if self._reading is not None:
            self._studio.jobs.cancel(self._reading)
            self._reading = None

    # --- masks and marks ---------------------------------------------------------------------
    def tables(self) -> tuple[Path | None, Path | None]:
        """The control points, with their marks, and the tie points that nobody has to name."""
        if self.folder is None:
            return None, None
        if (found := find_control(self.folder)) is not None:
            return found
        control, marks = self.exports.table(CONTROL), self.exports.table(MARKS)
        return (None if marks is None else control), marks

    def take_in_beside(self) -> None:
        """What lies beside the photos now, in place of what the project holds."""
        if self.folder is not None and not self.reading and self.making is None:
            self._take_in(again=True)

    def _take_in(self, *, again: bool = False) -> None:
        def done(failed: Failed | None) -> None:
            self._reading = None
            if failed is not None and not failed.cancelled:
                self.problem = failed.message
            elif failed is None:
                self._show_masks()
                self.rows_changed.emit()
                self._check()
            self.changed.emit()

        given = self.settings.control, self.settings.marks
        running = self.intake.begin(self.rows, given, done, again=again)
        if running is not None:
            self._reading = running
            self.changed.emit()

    def _show_masks(self, _: object = None) -> None:
        self.document.give_masks(self.rows)
        self.drawn_changed.emit()

    def _with_tables(self, settings: ReconstructionSettings) -> ReconstructionSettings:
        control, marks = self.tables()
        if control is None:
            return settings.without_control()
        return replace(settings, control=control, marks=marks, found=True)

    def aligned_folder(self) -> Path | None:
        """A reconstruction of these photos with cameras: in this quality, else the newest one."""
        out = self.out()
        if out is None or self.folder is None:
            return None
        return reconstruction_folders.aligned(out, self.folder)

    def check_again(self) -> None:
        """Masks have changed what the photos are worth."""
        if not self.reading and self.making is None and self.rows:
            self._check()

    # --- the model ---------------------------------------------------------------------------
    def make(self) -> None:
        """Reconstruct as the settings say, or continue an earlier run that was stopped."""
        from vomstudio.studio.jobs.reconstruction_tasks import RECONSTRUCT

        out, folder = self.out(), self.folder
        if self.why_not_make() is not None or out is None or folder is None:
            return
        order = self.settings.order(folder, out)
        if (facts := self.control_facts) is not None and facts.crs:
            # Shown before; the reconstruction itself would take no CRS for a local one.
            order = replace(order, crs=facts.crs)
        if self.settings.control is None:
            # Tie points join photos whatever places the model.
            order = replace(order, marks=self.tables()[1])
        session, name = self._studio.session, folder.name
        self.result = None
        reconstruction_folders.keep_failure(out, "")

        def done(result: Reconstruction) -> None:
            self._making, self._goes_on = None, False
            self._studio.info(finished_reconstruction(name, result))
            if self._studio.session is not session:
                self._studio.info(Finding("reconstruction.other-project", file=result.mesh))
                self.changed.emit()
                return
            self.result = result
            self._take(result.survey)
            self._show_cameras()
            self.rows_changed.emit()
            for warning in result.warnings[:2]:
                self._studio.warn(warning, warning.severity)
            # The project may have been saved under another name meanwhile.
            place = self._studio.project.folder / RECONSTRUCTIONS / out.name
            if (photo_set := self.document.photo_set) is not None:
                reconstruction_folders.record(self._studio, photo_set.id, place, name)
            self._studio.open_model(place / Path(result.mesh).name, name)

        def failed(event: Failed) -> None:
            self._making = None
            if event.cancelled and self._goes_on:
                self._goes_on = False
                self.make()
            elif not event.cancelled:
                reconstruction_folders.tell_failure(self._studio, out, event)
            self.changed.emit()

        self._making = self._studio.jobs.submit(
            RECONSTRUCT,
            replace(order, masks=self._masks()),
            title=tr("Reconstructing {name}", name=name),
            on_done=done,
            on_failed=failed,
            resumable=True,
        )
        self.changed.emit()

    def stop_to_move(self) -> None:
        """The project's folder is about to be moved: stop the work, which then goes on there."""
        if self._making is not None:
            self._goes_on = True
            self.pause()
            self._studio.jobs.finish(Lane.RECONSTRUCTION, _STOPPING_S)

    def pause(self) -> None:
        """Stop the work; finished stages are kept, and `make` continues after them."""
        if self._making is not None:
            self._studio.jobs.cancel(self._making)

    def _show_cameras(self) -> None:
        out = self.out()
        known = None if out is None else reconstruction_folders.enter_cameras(out, self.rows)
        if known is not None:
            self.has_north = known

    def _project_opened(self) -> None:
        self._stop_reading()
        self.exports.end()
        self.folder, self.rows, self.findings, self.result = None, [], (), None
        self.verdict, self.problem, self.control_note = "", "", None
        self.forecast = None
        self.document.look_at(None)
        self.rows_changed.emit()
        # The newest is the one that the user was at.
        project = self._studio.project.folder
        if (made := reconstruction_folders.newest(project)) is not None:
            self.open(*made)
        elif (photos := self.document.last_folder()) is not None:
            self.open(photos)
