"""Panel that makes an elevation model above a reference plane in a worker process."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from PySide6.QtWidgets import (
    QPushButton,
    QWidget,
)

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding, cause_finding
from vomstudio.core.options import option_words
from vomstudio.core.words import tr
from vomstudio.geology.notation import format_plane
from vomstudio.geology.orientation import Plane
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.units import Axes
from vomstudio.io.gis.crs import world_crs
from vomstudio.products.elevation.dem_options import DemFiles, DemOptions
from vomstudio.products.elevation.picture import ElevationPicture
from vomstudio.products.elevation.results import WrittenElevation
from vomstudio.project.records import Model
from vomstudio.studio.jobs.events import Failed
from vomstudio.studio.jobs.product_tasks import ELEVATION, ElevationRequest
from vomstudio.studio.running_jobs import RunningJob
from vomstudio.ui.base import theme
from vomstudio.ui.base.command_targets import (
    ask_for_target,
    confirm_replacement,
    remember_target,
    results_folder,
)
from vomstudio.ui.base.controls import button_row, file_field, narrow_form, set_enabled
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.qt_owner import connect_until_deleted
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
    """Panel that makes elevation models.

    Attributes
    ----------
    result : WrittenElevation or None
        The most recently written elevation model, or None if there is none.
    """

    def __init__(self, studio: Studio, view: ViewDirection) -> None:
        super().__init__()
        set_help_topic(self, "window.md#elevation-model")
        self._studio = studio
        self._background = QtBackground(self)
        self._job: RunningJob | None = None
        self.result: WrittenElevation | None = None
        self._result_model_id = ""
        self.model = ModelBox(studio)
        self.model.setObjectName("elevation_model")
        self.plane = PlaneField(studio, "elevation_plane", tr("horizontal"), view)
        self.plane.changed.connect(self._check)
        self.grid = OptionFields(DemOptions, "elevation")
        self.file_options = OptionFields(DemFiles, "elevation", DemFiles(hillshade=True))
        follow_axes(self, studio, self._show_axes)
        self.target, self._file = file_field("elevation_target", tr("Choose…"), self._browse)
        self.start = QPushButton(theme.icon("image-filter-hdr"), tr("Create"))
        self.start.clicked.connect(lambda _=False: self._start_or_stop())
        self.copy = CopyCommandButton(self.copy_command, tr("the command for this elevation model"))
        self.message = hint_label()
        self.message.setObjectName("elevation_said")
        self.figures = hint_label()
        self.figures.setObjectName("elevation_figures")
        self.cursor_label = hint_label()
        self.picture = ElevationView()
        self.picture.cursor_text_changed.connect(self.cursor_label.setText)
        self._arrange_widgets()
        self.model.currentIndexChanged.connect(self._follow_model)
        for fields in (self.grid, self.file_options):
            fields.changed.connect(self._check)
        self.target.textChanged.connect(self._check)
        studio.edited.connect(self.refresh)
        studio.model_loaded.connect(self.refresh)
        studio.jobs_changed.connect(self._show_progress)
        connect_until_deleted(self, studio.jobs.closed, self._background.stop)
        # A model may already be open.
        self.refresh()

    def _arrange_widgets(self) -> None:
        form = narrow_form()
        form.addRow(tr("Model"), self.model)
        form.addRow(tr("Over"), self.plane)
        boxes = button_row(*map(self.file_options.place, ("hillshade", "slope", "aspect")))
        self.grid.add_rows(form)
        self.file_options.add_rows(form)
        form.addRow(tr("Also"), boxes)
        form.addRow(tr("File"), self._file)
        buttons = button_row(self.start, self.copy)
        lines = (self.message, self.figures, self.cursor_label)
        FormWithPicture.fill(self, form, buttons, *lines, picture=self.picture)

    # --- request -----------------------------------------------------------------------------
    def refresh(self, *_: object) -> None:
        """List the models of the project, and remove the result of a removed model."""
        if self._studio.has_project:
            self.model.list_models()
            if self.result is not None and self._result_model_id not in self._studio.records:
                self._clear()
        self._follow_model()

    def _follow_model(self, *_: object) -> None:
        model = self.model.selected_model()
        is_cloud = model is not None and self._is_cloud(model)
        set_enabled(
            self.grid.fields["limit_m"], None if is_cloud else Finding("action.clouds-only")
        )
        if not self.target.isModified() and model is not None:
            folder = results_folder(self._studio)
            self.target.setText(str(folder / f"{Path(model.name).stem}_dem.tif"))
            self.target.setModified(False)
        self._check()

    def _is_cloud(self, model: Model) -> bool:
        return isinstance(self._studio.models[model.id].data, PointCloud)

    def _show_axes(self, axes: Axes) -> None:
        for fields in (self.grid, self.file_options):
            fields.show_unit(length_unit(axes))

    def disabled_reason(self) -> Finding | None:
        """Return why no elevation model can be made now, or None if one can be made."""
        model = self.model.selected_model()
        if model is None:
            return Finding("action.no-model")
        if self._studio.project.find_model(model) is None:
            return Finding("model.file-missing", model=model.name)
        try:
            self.plane.plane()
        except VomError as error:
            return cause_finding(error)
        if not self.target.text().strip().lower().endswith((".tif", ".tiff")):
            return Finding("export.not-tif")
        return None

    def _check(self, *_: object) -> None:
        reason = self.disabled_reason()
        is_busy = self._job is not None
        self.start.setText(tr("Stop") if is_busy else tr("Create"))
        set_enabled(self.start, None if is_busy else reason)
        self.copy.set_enabled(reason)
        if not is_busy and self.result is None:
            self.message.setText("" if reason is None else tr("Not now: {reason}", reason=reason))

    def _browse(self) -> None:
        proposed_text, formats = self.target.text(), {"tif": "GeoTIFF", "tiff": "GeoTIFF"}
        path = ask_for_target(self, self._studio, tr("Elevation model"), proposed_text, formats)
        if path is not None:
            self.target.setText(str(path))
            self.target.setModified(True)

    def build_request(self) -> ElevationRequest | None:
        """Return the request defined by the form, or None if no elevation model can be made."""
        model = self.model.selected_model()
        if model is None or self.disabled_reason() is not None:
            return None
        path = self._studio.project.find_model(model)
        assert path is not None
        plane = self.plane.plane()
        overrides: dict[str, Any] = {"plane": None if plane is None else plane_text(plane)}
        if not self.grid.fields["limit_m"].isEnabled():
            overrides["limit_m"] = None
        frame = model.frame
        return ElevationRequest(
            path=path,
            cache=self._studio.project.cache,
            to_world=model.to_world,
            crs=world_crs(frame.crs, frame.unit_m),
            is_metric=frame.has_metres,
            is_north_known=frame.has_north,
            options=self.grid.options(**overrides),
            files=self.file_options.options(),
            out=Path(self.target.text()).expanduser(),
        )

    # --- job ---------------------------------------------------------------------------------
    def _start_or_stop(self) -> None:
        if self._job is not None:
            self._studio.jobs.cancel(self._job)
            return
        request, model = self.build_request(), self.model.selected_model()
        if request is None or model is None:
            return
        from vomstudio.products.elevation.writing import elevation_outputs

        existing = [
            p.name for p in elevation_outputs(request.out, request.files).values() if p.exists()
        ]
        if existing and not confirm_replacement(self, existing):
            return
        remember_target(self._studio, request.out)
        self.result = None
        self.figures.setText("")
        self._job = self._studio.jobs.submit(
            ELEVATION,
            request,
            title=tr("Elevation model {file}", file=request.out.name),
            on_done=partial(
                _report, self._studio, self._background.guard(partial(self._show_result, model))
            ),
            on_failed=self._background.guard(self._show_failure),
        )
        self._check()

    def _show_progress(self) -> None:
        if self._job is not None and not self._job.outcome:
            self.message.setText(self._job.status())

    def _show_result(self, model: Model, result: WrittenElevation) -> None:
        self._job, self.result, self._result_model_id = None, result, model.id
        finding = Finding("export.written", file=result.raster)
        if model.id not in self._studio.records:
            # The model was removed, or another project opened, in the meantime.
            self._clear()
            self._check()
            return
        is_metric = model.frame.has_metres
        unit = "m" if is_metric else tr("units")
        self.figures.setText(result_text(result, self._studio.settings.notation, unit))
        self.message.setText("\n".join(map(str, (finding, *result.warnings))))
        from vomstudio.products.elevation.picture import read_picture

        self._background.run(
            lambda: read_picture(Path(result.raster)),
            lambda picture: self._show_picture(result, picture, is_metric),
            lambda error: self.message.setText(error.message),
        )
        self._check()

    def _show_failure(self, event: Failed) -> None:
        self._job = None
        self._check()
        self.message.setText(str(Finding("job.stopped")) if event.cancelled else event.message)

    def _show_picture(
        self, result: WrittenElevation, picture: ElevationPicture, is_metric: bool
    ) -> None:
        if result is self.result:
            self.picture.show_picture(picture, is_metric=is_metric)

    def _clear(self) -> None:
        """Remove the result."""
        self.result = None
        self.figures.setText("")
        self.cursor_label.setText("")
        self.picture.show_picture(None)

    # --- command -----------------------------------------------------------------------------
    def copy_command(self) -> None:
        """Copy the command that makes the same elevation model."""
        command = self.command()
        if command is not None:
            copy_command(self._studio, command)

    def command(self) -> CommandArguments | None:
        """Return the command for the form, or None if no elevation model can be made."""
        request, model = self.build_request(), self.model.selected_model()
        model_arguments = None if model is None else find_model_arguments(self._studio, model)
        if request is None or model_arguments is None:
            return None
        options = [*option_words(request.options), *option_words(request.files)]
        return ["dem", *model_arguments, ("-o", request.out), *options, "--force"]


def _report(
    studio: Studio, show: Callable[[WrittenElevation], object], result: WrittenElevation
) -> None:
    """Show the result and report its file, even if another project is open now."""
    studio.written(result.raster)
    show(result)


def result_text(elevation: WrittenElevation, notation: str, unit: str) -> str:
    """Format the figures of an elevation model as lines of text."""
    f = elevation.figures
    plane = Plane(f.dip_direction_deg, f.dip_deg)
    plane_name = tr("a horizontal plane") if plane.undefined else format_plane(plane, notation, 1)
    lines = [
        tr(
            "{width:,} × {height:,} cells of {gsd:g} {unit}, heights above {plane}",
            width=f.width,
            height=f.height,
            gsd=f.gsd_m,
            unit=unit,
            plane=plane_name,
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
                "interpolated between points up to {limit:.3g} {unit} apart",
                limit=f.interpolation_limit_m,
                unit=unit,
            )
        )
    return "\n".join(lines)
