"""The dock in which an elevation model is made: over a plane of reference, by a worker process."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

from PySide6.QtWidgets import (
    QFileDialog,
    QPushButton,
    QWidget,
)

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding, cause_of
from vomstudio.core.options import option_words
from vomstudio.core.words import tr
from vomstudio.geology.notation import format_plane
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.units import Axes
from vomstudio.io.gis.crs import world_crs
from vomstudio.products.elevation.dem_options import DemFiles, DemOptions
from vomstudio.products.elevation.results import WrittenElevation
from vomstudio.project.records import Model
from vomstudio.studio.jobs.events import Failed
from vomstudio.studio.jobs.product_tasks import ELEVATION, ElevationRequest
from vomstudio.studio.running_jobs import RunningJob
from vomstudio.ui.base import theme
from vomstudio.ui.base.command_targets import confirm_replacement, start_folder
from vomstudio.ui.base.controls import allow, button_row, file_field, narrow_form
from vomstudio.ui.base.help_links import explain
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.sections.elevation_view import ElevationView
from vomstudio.ui.panels.tools.common import hint_label
from vomstudio.ui.widgets.axis_titles import follow_axes, length_unit
from vomstudio.ui.widgets.copied_command import (
    CommandArguments,
    CopyCommandButton,
    copy_command,
    find_model_arguments,
)
from vomstudio.ui.widgets.form_with_picture import FormWithPicture
from vomstudio.ui.widgets.model_box import ModelBox
from vomstudio.ui.widgets.options_form import OptionFields
from vomstudio.ui.widgets.plane_field import PlaneField, ViewDirection, plane_text


class ElevationPanel(QWidget):
    """made : what was written last, None while there is nothing"""

    def __init__(self, studio: Studio, view: ViewDirection) -> None:
        super().__init__()
        explain(self, "window.md#elevation-model")
        self._studio = studio
        self._background = QtBackground(self)
        self._job: RunningJob | None = None
        self.made: WrittenElevation | None = None
        self.model = ModelBox(studio)
        self.model.setObjectName("elevation_model")
        self.plane = PlaneField(studio, "elevation_plane", tr("horizontal"), view)
        self.plane.changed.connect(self._check)
        self.grid = OptionFields(DemOptions, "elevation")
        self.also = OptionFields(DemFiles, "elevation", DemFiles(hillshade=True))
        follow_axes(studio, self._show_axes)
        self.target, self._file = file_field("elevation_target", tr("Choose…"), self._browse)
        self.start = QPushButton(theme.icon("image-filter-hdr"), tr("Make"))
        self.start.clicked.connect(lambda _=False: self._start_or_stop())
        self.copy = CopyCommandButton(
            self.copy_command, tr("the command that makes the same elevation model")
        )
        self.said = hint_label()
        self.said.setObjectName("elevation_said")
        self.figures = hint_label()
        self.figures.setObjectName("elevation_figures")
        self.pointed = hint_label()
        self.picture = ElevationView()
        self.picture.pointed.connect(self.pointed.setText)
        self._arrange()
        self.model.currentIndexChanged.connect(self._model_chosen)
        for fields in (self.grid, self.also):
            fields.changed.connect(self._check)
        self.target.textChanged.connect(self._check)
        for signal in (studio.project_opened, studio.edited, studio.model_loaded):
            signal.connect(self.refresh)
        studio.project_opened.connect(self._forget)
        studio.jobs_changed.connect(self._progress)
        studio.jobs.closed.connect(self._background.stop)
        # A model may be open already.
        self.refresh()

    def _arrange(self) -> None:
        form = narrow_form()
        form.addRow(tr("Model"), self.model)
        form.addRow(tr("Over"), self.plane)
        self.grid.add_rows(form)
        self.also.add_rows(form)
        boxes = button_row(*(self.also.fields[name] for name in ("hillshade", "slope", "aspect")))
        form.addRow(tr("Also"), boxes)
        form.addRow(tr("File"), self._file)
        buttons = button_row(self.start, self.copy)
        lines = (self.said, self.figures, self.pointed)
        FormWithPicture.fill(self, form, buttons, *lines, picture=self.picture)

    # --- what is asked -----------------------------------------------------------------------
    def refresh(self, *_: object) -> None:
        """The models that there are."""
        if self._studio.has_project:
            self.model.list_models()
        self._model_chosen()

    def _model_chosen(self, *_: object) -> None:
        model = self.model.selected_model()
        cloud = model is not None and self._is_cloud(model)
        allow(self.grid.fields["limit_m"], None if cloud else Finding("action.clouds-only"))
        if not self.target.isModified() and model is not None:
            project = self._studio.project
            folder = Path(start_folder(self._studio))
            if not project.untitled:
                folder = project.folder.parent
            self.target.setText(str(folder / f"{Path(model.name).stem}_dem.tif"))
            self.target.setModified(False)
        self._check()

    def _is_cloud(self, model: Model) -> bool:
        return isinstance(self._studio.models[model.id].data, PointCloud)

    def _show_axes(self, axes: Axes) -> None:
        for fields in (self.grid, self.also):
            fields.show_unit(length_unit(axes))

    def why_not(self) -> Finding | None:
        """Return why no elevation model can be made now; None if one can."""
        model = self.model.selected_model()
        if model is None:
            return Finding("action.no-model")
        if self._studio.project.find_model(model) is None:
            return Finding("model.file-missing", model=model.name)
        try:
            self.plane.plane()
        except VomError as error:
            return cause_of(error)
        if not self.target.text().strip().lower().endswith((".tif", ".tiff")):
            return Finding("export.not-tif")
        return None

    def _check(self, *_: object) -> None:
        why = self.why_not()
        busy = self._job is not None
        self.start.setText(tr("Stop") if busy else tr("Make"))
        allow(self.start, None if busy else why)
        self.copy.allow(why)
        if not busy and self.made is None:
            self.said.setText("" if why is None else tr("Not now: {reason}", reason=why))

    def _browse(self) -> None:
        name, _ = QFileDialog.getSaveFileName(
            self, tr("Elevation model"), self.target.text(), tr("GeoTIFF (*.tif)")
        )
        if name:
            if not name.lower().endswith((".tif", ".tiff")):
                name += ".tif"
            self.target.setText(name)
            self.target.setModified(True)

    def order(self) -> ElevationRequest | None:
        """None where it cannot be made."""
        model = self.model.selected_model()
        if model is None or self.why_not() is not None:
            return None
        path = self._studio.project.find_model(model)
        assert path is not None
        plane = self.plane.plane()
        others: dict[str, Any] = {"plane": None if plane is None else plane_text(plane)}
        if not self.grid.fields["limit_m"].isEnabled():
            others["limit_m"] = None
        frame = model.frame
        return ElevationRequest(
            path,
            self._studio.project.cache,
            model.to_world,
            world_crs(frame.crs, frame.unit_m),
            frame.has_metres,
            frame.has_north,
            self.grid.options(**others),
            self.also.options(),
            Path(self.target.text()).expanduser(),
        )

    # --- the job -----------------------------------------------------------------------------
    def _start_or_stop(self) -> None:
        if self._job is not None:
            self._studio.jobs.cancel(self._job)
            return
        asked, model = self.order(), self.model.selected_model()
        if asked is None or model is None:
            return
        from vomstudio.products.elevation.writing import elevation_outputs

        there = [p.name for p in elevation_outputs(asked.out, asked.files).values() if p.exists()]
        if there and not confirm_replacement(self, there):
            return
        self.made = None
        self.figures.setText("")
        self._job = self._studio.jobs.submit(
            ELEVATION,
            asked,
            title=tr("Elevation model {file}", file=asked.out.name),
            on_done=self._background.guard(partial(self._came, model.frame.has_metres)),
            on_failed=self._background.guard(self._failed),
        )
        self._check()

    def _progress(self) -> None:
        if self._job is not None and not self._job.outcome:
            self.said.setText(self._job.status())

    def _came(self, metric: bool, made: WrittenElevation) -> None:
        self._job, self.made = None, made
        unit = "m" if metric else tr("units")
        self.figures.setText(result_text(made, self._studio.settings.notation, unit))
        written = Finding("export.written", file=made.raster)
        self.said.setText("\n".join(map(str, (written, *made.warnings))))
        self._studio.info(written)
        from vomstudio.products.elevation.picture import read_picture

        self._background.run(
            lambda: read_picture(Path(made.raster)),
            lambda picture: self.picture.show_picture(picture, metric=metric),
            lambda error: self.said.setText(error.message),
        )
        self._check()

    def _failed(self, event: Failed) -> None:
        self._job = None
        self._check()
        self.said.setText(str(Finding("job.stopped")) if event.cancelled else event.message)

    def _forget(self) -> None:
        """Another project."""
        self.made = None
        self.figures.setText("")
        self.picture.show_picture(None)
        for fields in (self.grid, self.also):
            fields.reset()
        self.target.clear()
        self.target.setModified(False)
        self.refresh()

    # --- the command -------------------------------------------------------------------------
    def copy_command(self) -> None:
        """Put the command that makes the same on the clipboard."""
        words = self.words()
        if words is not None:
            copy_command(self._studio, words)

    def words(self) -> CommandArguments | None:
        asked, model = self.order(), self.model.selected_model()
        place = None if model is None else find_model_arguments(self._studio, model)
        if asked is None or place is None:
            return None
        options = [*option_words(asked.options), *option_words(asked.files)]
        return ["dem", *place, ("-o", asked.out), *options, "--force"]


def result_text(elevation: WrittenElevation, notation: str, unit: str) -> str:
    """The figures of the command, in lines."""
    f = elevation.figures
    plane = Plane(f.dip_direction_deg, f.dip_deg)
    over = tr("the horizontal") if plane.undefined else format_plane(plane, notation, 1)
    lines = [
        tr(
            "{width:,} × {height:,} cells of {gsd:g} {unit} over {plane}",
            width=f.width,
            height=f.height,
            gsd=f.gsd_m,
            unit=unit,
            plane=over,
        ),
        tr(
            "{coverage:.0f} % have a height, {low:.3f} to {high:.3f} {unit}",
            coverage=100 * f.coverage,
            low=f.lowest_m,
            high=f.highest_m,
            unit=unit,
        ),
    ]
    if f.interpolation_limit_m is not None:
        lines.append(
            tr(
                "between points no farther apart than {limit:.3g} {unit}",
                limit=f.interpolation_limit_m,
                unit=unit,
            )
        )
    return "\n".join(lines)
