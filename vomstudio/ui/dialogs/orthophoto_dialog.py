"""Dialog for an orthophoto along the current view."""

from __future__ import annotations

import math
from dataclasses import replace
from html import escape
from pathlib import Path

import numpy as np
from PySide6.QtCore import Qt, QTimer
from PySide6.QtWidgets import (
    QCheckBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QHBoxLayout,
    QLineEdit,
    QRadioButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding, to_finding
from vomstudio.core.options import option_words
from vomstudio.core.words import tr
from vomstudio.geology.notation import format_line
from vomstudio.geology.orientation import Line
from vomstudio.geometry import transform
from vomstudio.geometry.units import length_text as length
from vomstudio.geometry.vectors import wrap360
from vomstudio.io.gis.crs import world_crs
from vomstudio.products.ortho import interpretation, orthophoto, planning, view_directions
from vomstudio.products.ortho.drawn_features import drawing_targets
from vomstudio.products.ortho.ortho_options import OrthoDrawing, OrthoOptions
from vomstudio.project.domains import domain_names
from vomstudio.project.records import Model
from vomstudio.rendering.qt.viewport import Viewport
from vomstudio.studio.jobs.events import Failed
from vomstudio.studio.jobs.product_tasks import ORTHOPHOTO, OrthophotoOutput, OrthophotoRequest
from vomstudio.ui.base.command_targets import (
    ask_for_target,
    confirm_replacement,
    current_model,
    remember_target,
    results_folder,
)
from vomstudio.ui.base.controls import ComboBox, Label, file_field, rich_label, set_enabled
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.numbers import parse_number
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.base.window_fitting import fit_height_to_text
from vomstudio.ui.dialogs.interpretation_box import InterpretationBox
from vomstudio.ui.panels.view.view_panel import ViewPanel
from vomstudio.ui.widgets.copied_command import (
    CopyCommandButton,
    copy_command,
    find_model_arguments,
    format_numbers,
)
from vomstudio.ui.widgets.options_form import OptionFields


class OrthoDialog(QDialog):
    """Dialog that starts a job for an orthophoto. The window remains usable."""

    def __init__(
        self, parent: QWidget, studio: Studio, viewport: Viewport, directions: ViewPanel
    ) -> None:
        super().__init__(parent)
        set_help_topic(self, "conventions.md#orthophotos")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(tr("Orthophoto of view"))
        self.setMinimumWidth(640)
        self._studio = studio
        trend, plunge = viewport.moves.view_direction()
        self._direction = Line(wrap360(trend), plunge)
        centre, width, height = viewport.moves.view_extent()
        x, y, z = (float(v) for v in centre)
        self._visible_region = planning.ViewRegion((x, y, z), width, height)
        self._direction_source, self._error_deg = directions.find_direction_origin(self._direction)
        form = self._make_form()
        self._buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Cancel)
        self._start_button = self._buttons.addButton(
            tr("Make orthophoto"), QDialogButtonBox.ButtonRole.AcceptRole
        )
        self.copy_button = CopyCommandButton(
            self.copy_command, tr("the command for this orthophoto")
        )
        self.copy_button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        self._buttons.addButton(self.copy_button, QDialogButtonBox.ButtonRole.ActionRole)
        self._buttons.accepted.connect(self.accept)
        self._buttons.rejected.connect(self.reject)
        layout = QVBoxLayout(self)
        layout.addLayout(form)
        layout.addWidget(self._buttons)
        self.model.currentIndexChanged.connect(self._propose_pixel_size)
        for signal in (self.whole_model.toggled, self.gsd.textChanged, self.target.textChanged):
            signal.connect(self._check)
        stem = f"ortho_{round(trend) % 360:03d}_{plunge:+03.0f}"
        self.target.setText(str(results_folder(studio) / f"{stem}.tif"))
        # Read the resolution of the texture after the dialog has been shown.
        self._size.setText(tr("Reading the resolution of the model…"))
        QTimer.singleShot(0, self._propose_pixel_size)

    # --- widgets -----------------------------------------------------------------------------
    def _make_form(self) -> QFormLayout:
        self.model = ComboBox()
        for record in self._studio.session.of(Model):
            if record.id in self._studio.models:
                self.model.addItem(record.name, record.id)
        initial_model = current_model(self._studio)
        if initial_model is not None:
            self.model.setCurrentIndex(max(0, self.model.findData(initial_model.id)))
        direction_text = (
            f"<b>{format_line(self._direction, 1)}</b>  {escape(self._direction_source)}"
        )
        direction_label = rich_label(direction_text)
        direction_label.setWordWrap(True)
        self._error_effect = Label()
        self._error_effect.setWordWrap(True)
        self.options = OptionFields(OrthoOptions, "ortho")
        self.target, file_row = file_field("ortho_target", tr("Choose…"), self._browse)
        form = QFormLayout()
        form.setVerticalSpacing(8)
        form.addRow(tr("Model"), self.model)
        form.addRow(tr("View direction"), direction_label)
        self.options.add_rows(form)
        form.addRow(tr("Error effect"), self._error_effect)
        form.addRow(tr("Area"), self._make_area_row())
        form.addRow(tr("Pixel size"), self._make_pixel_size_row())
        form.addRow(tr("Sheet"), self._make_sheet_row())
        self.interpretation = InterpretationBox(self._studio)
        self.sheet.toggled.connect(self.interpretation.enable_legend)
        form.addRow(tr("Interpretation"), self.interpretation)
        self.domain = ComboBox()
        self.domain.setObjectName("ortho_domain")
        self.domain.addItem(tr("Whole outcrop"), None)
        for name in domain_names(self._studio.session.records):
            self.domain.addItem(tr("{domain}, the rest grey", domain=name), name)
        self.domain.setToolTip(tr("Show one domain, along its own fold axis."))
        form.addRow(tr("Show"), self.domain)
        form.setRowVisible(self.domain, self.domain.count() > 1)
        form.addRow(tr("File"), file_row)
        return form

    def _make_area_row(self) -> QHBoxLayout:
        self.whole_model = QRadioButton(tr("Whole model"))
        self.visible_area = QRadioButton(tr("Visible area"))
        self.whole_model.setChecked(True)
        row = QHBoxLayout()
        row.addWidget(self.whole_model)
        row.addWidget(self.visible_area)
        row.addStretch()
        return row

    def _make_pixel_size_row(self) -> QHBoxLayout:
        self.gsd = QLineEdit()
        self.gsd.setObjectName("ortho_gsd")
        self.gsd.setFixedWidth(90)
        self._size = Label()
        self._size.setWordWrap(True)
        row = QHBoxLayout()
        row.addWidget(self.gsd)
        self._unit = Label()
        row.addWidget(self._unit)
        row.addSpacing(8)
        row.addWidget(self._size, 1)
        return row

    def _make_sheet_row(self) -> QHBoxLayout:
        self.sheet = QCheckBox(tr("Write scaled sheet"))
        self.sheet_format = ComboBox()
        for name in ("png", "pdf"):
            self.sheet_format.addItem(name.upper(), name)
        self.sheet.setChecked(True)
        row = QHBoxLayout()
        row.addWidget(self.sheet)
        row.addWidget(self.sheet_format)
        row.addStretch()
        return row

    # --- preview ------------------------------------------------------------------------------
    def _selected_model(self) -> Model:
        record = self._studio.records[str(self.model.currentData())]
        assert isinstance(record, Model)
        return record

    def _view_corners(self) -> np.ndarray:
        """Return the corners (8, 3) of the model's bounding box in the frame of the picture.

        The axes point right, down and along the view, from the centre of the visible region.
        """
        model = self._selected_model()
        minimum, maximum = self._studio.models[model.id].data.bounds
        grid = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
        corners = transform.apply(model.to_world, np.where(grid == 1, maximum, minimum))
        view = view_directions.view_along_line(
            self._direction.trend_deg, self._direction.plunge_deg
        )
        return view.frame.to_view(corners, np.asarray(self._visible_region.centre))

    def _picture_extent(self) -> tuple[float, float]:
        """Return the maximum width and height of the area, in units of the World frame."""
        corners = self._view_corners()
        minimum, maximum = corners.min(axis=0), corners.max(axis=0)
        if self.visible_area.isChecked():
            half_size = 0.5 * np.array([self._visible_region.width, self._visible_region.height])
            minimum[:2], maximum[:2] = (
                np.maximum(minimum[:2], -half_size),
                np.minimum(maximum[:2], half_size),
            )
        width, height = np.maximum(maximum - minimum, 0.0)[:2].tolist()
        return width, height

    def _propose_pixel_size(self) -> None:
        model = self._selected_model()
        data = self._studio.models[model.id].data
        gsd, code = planning.default_gsd(data, model.to_world, max(self._picture_extent()))
        unit = "m" if model.frame.has_metres else tr("units")
        self._proposal = Finding(code, gsd=gsd, unit=unit)
        self.gsd.setText(f"{gsd:g}")
        corners = self._view_corners()
        depth = float(np.ptp(corners[:, 2]))
        is_metric = model.frame.has_metres
        self._unit.setText(unit)
        direction_cost = view_directions.cost_of_direction(
            self._error_deg, depth, is_metric=is_metric
        )
        self._error_effect.setText(direction_cost.message)
        self._check()
        # Labels with several lines have received their text only now.
        fit_height_to_text(self)

    def _check(self, *_: object) -> None:
        text = self.gsd.text().strip()
        gsd = parse_number(text)
        width, height = self._picture_extent()
        problem = None
        if gsd is None or gsd <= 0:
            problem = Finding("number.not-a-length", text=text)
        elif not (width and height):
            problem = Finding("view.part-empty")
        else:
            pixels = (width / gsd) * (height / gsd)
            size = [
                length(v, is_metric=self._selected_model().frame.has_metres)
                for v in (width, height)
            ]
            self._size.setText(
                tr(
                    "At most {width:,.0f} × {height:,.0f} pixels, {size}\n{proposal}",
                    width=width / gsd,
                    height=height / gsd,
                    size=" × ".join(size),
                    proposal=self._proposal,
                )
            )
            if pixels > planning.MAX_PIXELS:
                problem = Finding(
                    "gsd.too-many-pixels",
                    gsd_m=gsd,
                    megapixels=pixels / 1_000_000,
                    limit=planning.MAX_PIXELS // 1_000_000,
                    least_m=math.sqrt(width * height / planning.MAX_PIXELS),
                )
        if problem is None and not self.target.text().lower().endswith((".tif", ".tiff")):
            problem = Finding("export.not-tif")
        if problem is not None and text:
            self._size.setText(problem.message)
        set_enabled(self._start_button, problem)
        self.copy_button.set_enabled(problem)

    def _browse(self) -> None:
        default_name, formats = self.target.text(), {"tif": "GeoTIFF", "tiff": "GeoTIFF"}
        path = ask_for_target(self, self._studio, tr("Orthophoto file"), default_name, formats)
        if path is not None:
            self.target.setText(str(path))

    def copy_command(self) -> None:
        """Copy to the clipboard the command that creates the same orthophoto."""
        model_arguments = find_model_arguments(self._studio, self._selected_model())
        gsd = parse_number(self.gsd.text())
        if model_arguments is None or gsd is None:
            self._studio.warn(Finding("model.file-missing", model=self._selected_model().name))
            return
        output_path = Path(self.target.text()).expanduser()
        direction, region = self._direction, self._visible_region
        parts, domain = self.interpretation.selected_parts, self.domain.currentData()
        options = self.options.options(
            trend_deg=direction.trend_deg, plunge_deg=direction.plunge_deg, gsd_m=gsd
        )
        sheet = self._sheet_path(output_path)
        drawing = OrthoDrawing(
            sheet=None if sheet is None else str(sheet),
            draw=str(self._studio.project.folder) if parts or domain is not None else None,
            show=",".join(parts) if parts and parts != interpretation.PARTS else None,
            domain=domain,
            around=format_numbers([*region.centre, region.width, region.height])
            if self.visible_area.isChecked()
            else None,
        )
        arguments = [*option_words(options), *option_words(drawing)]
        copy_command(
            self._studio, ["ortho", *model_arguments, ("-o", output_path), *arguments, "--force"]
        )

    def _sheet_path(self, output_path: Path) -> Path | None:
        suffix = str(self.sheet_format.currentData())
        return (
            output_path.with_name(f"{output_path.stem}_sheet.{suffix}")
            if self.sheet.isChecked()
            else None
        )

    # --- the job ------------------------------------------------------------------------------
    def accept(self) -> None:
        """Start the job. Ask before existing files are replaced."""
        model, studio = self._selected_model(), self._studio
        path = studio.project.find_model(model)
        if path is None:
            studio.warn(Finding("model.file-missing", model=model.name))
            return
        output_path = Path(self.target.text()).expanduser()
        view = view_directions.ViewDirection(
            self._direction.trend_deg,
            self._direction.plunge_deg,
            view_directions.AS_GIVEN,
            Finding("view.chosen", description=self._direction_source),
        )
        if self.options.value("flip"):
            view = view.flipped()
        region = self._visible_region if self.visible_area.isChecked() else None
        sheet = self._sheet_path(output_path)
        try:
            outputs = [*orthophoto.orthophoto_outputs(output_path), *([sheet] if sheet else [])]
        except VomError as error:
            studio.fail(error)
            return
        parts = self.interpretation.selected_parts
        if parts:
            outputs += drawing_targets(output_path).values()
        domain = self.domain.currentData()
        existing_names = [p.name for p in (output_path, *outputs) if p.exists()]
        if existing_names and not confirm_replacement(self, existing_names):
            return
        remember_target(studio, output_path)
        studio.jobs.submit(
            ORTHOPHOTO,
            OrthophotoRequest(
                path=path,
                cache=studio.project.cache,
                view=replace(
                    view, is_north_known=model.frame.has_north, is_metric=model.frame.has_metres
                ),
                to_world=model.to_world,
                crs=world_crs(model.frame.crs, model.frame.unit_m),
                gsd=parse_number(self.gsd.text()),
                region=region,
                out=output_path,
                sheet=sheet,
                draw=studio.project.folder if parts else None,
                parts=parts,
                domain=None if domain is None else (studio.project.folder, domain),
            ),
            title=tr("Orthophoto {file}", file=output_path.name),
            on_done=lambda result: _show_result(studio, result),
            on_failed=lambda event: _show_failure(studio, event),
        )
        super().accept()


def _show_result(studio: Studio, result: OrthophotoOutput) -> None:
    extra_files = [file for file in (result.sheet, *result.drawing) if file]
    main_finding = Finding(
        "ortho.written",
        file=result.image,
        width=result.width,
        height=result.height,
        gsd=result.gsd_m,
        unit=result.unit,
        coverage_percent=100 * result.coverage,
    )
    for file in extra_files:
        studio.info(Finding("export.written", file=file))
    studio.written(result.sheet or result.image, main_finding)
    for finding in result.warnings:
        studio.info(finding)


def _show_failure(studio: Studio, event: Failed) -> None:
    if not event.cancelled:
        studio.warn(to_finding(event.to_error()), "error")
