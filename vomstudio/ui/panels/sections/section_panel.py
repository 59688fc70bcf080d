"""Panel for sections through a model along a plane or line, with projected features."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from PySide6.QtWidgets import (
    QCheckBox,
    QLineEdit,
    QPushButton,
)

from vomstudio.core.arrays import FloatArray
from vomstudio.core.errors import InputError
from vomstudio.core.files.atomic import write_bytes
from vomstudio.core.findings import Finding
from vomstudio.core.options import option_words
from vomstudio.core.words import tr, tr_n
from vomstudio.geology.orientation import Line
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.units import Axes
from vomstudio.io.gis.crs import world_crs
from vomstudio.products.section.section_lines import Curtain
from vomstudio.products.section.section_options import DOMAINS, SectionFeatures, SectionOptions
from vomstudio.project.domains import domain_names
from vomstudio.project.records import Feature, Model, PickedFeature
from vomstudio.ui.base import theme
from vomstudio.ui.base.command_targets import (
    current_feature,
    current_line,
    results_folder,
)
from vomstudio.ui.base.controls import (
    ComboBox,
    button_row,
    create_row,
    icon_button,
    narrow_form,
    set_enabled,
)
from vomstudio.ui.base.numbers import parse_numbers
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.analysis_panel import AnalysisPanel
from vomstudio.ui.panels.sections.analysis import (
    SectionRequest,
    SectionResult,
    build_curtain,
    compute_section,
    write,
)
from vomstudio.ui.widgets.axis_titles import follow_axes, length_unit
from vomstudio.ui.widgets.copied_command import (
    CommandArguments,
    CopyCommandButton,
    copy_command,
    copy_with_file,
    find_model_arguments,
    format_numbers,
)
from vomstudio.ui.widgets.drawing_view import DrawingView
from vomstudio.ui.widgets.drawn_line import DrawnLine
from vomstudio.ui.widgets.form_with_picture import FormWithPicture
from vomstudio.ui.widgets.line_field import LineField
from vomstudio.ui.widgets.model_box import ModelBox
from vomstudio.ui.widgets.options_form import OptionFields
from vomstudio.ui.widgets.plane_field import PlaneField, ViewDirection, plane_text

_MIN_FACING = 0.05
"""Sine of the angle between view and section above which a side faces the viewer."""
_FORMATS = {"svg": "SVG", "dxf": "DXF", "csv": "CSV"}


class SectionPanel(AnalysisPanel[SectionRequest, SectionResult]):
    """Panel for a section along a plane, or along a line on the outcrop.

    Attributes
    ----------
    line : (n, 3) float64 or None
        Vertices of the line on the outcrop in the World frame; None until a line is selected.
    """

    def __init__(self, studio: Studio, view: ViewDirection) -> None:
        super().__init__(studio, "section", "window.md#section", tr("Cutting…"))
        self.line: FloatArray | None = None
        self._line_name = ""
        self._view = view
        self._drawn_line = DrawnLine(self, studio)
        self.model = ModelBox(studio)
        self.model.setObjectName("section_model")
        self.path_kind = ComboBox()
        self.path_kind.setObjectName("section_along_what")
        self.path_kind.addItem(tr("a plane"), "plane")
        self.path_kind.addItem(tr("a line"), "line")
        self.plane = PlaneField(studio, "section_plane", view=view)
        self.through = QLineEdit()
        self.through.setObjectName("section_through")
        self.through.setPlaceholderText(tr("centre of the model"))
        self.use_point_button = icon_button(
            "cursor-default-click-outline", tr("Use the selected feature")
        )
        self.use_line_button = QPushButton(tr("Use selected"))
        self.use_line_button.setToolTip(
            tr("Draw a vertical section along the selected trace or polyline.")
        )
        self.draw_line = QPushButton(theme.icon("vector-polyline"), tr("Draw…"))
        self.direction = LineField(studio, "section_direction", tr("perpendicular"))
        self.features = QCheckBox(tr("Features"))
        self.features.setChecked(True)
        self.domain_axes = QCheckBox(tr("Domains separately"))
        self.domain_axes.setObjectName("section_by_domain")
        self.section_options = OptionFields(
            SectionOptions, "section", SectionOptions(section_line="")
        )
        self.feature_options = OptionFields(SectionFeatures, "section")
        follow_axes(self, studio, self._show_axes)
        self.write = QPushButton(theme.icon("export"), tr("Write…"))
        self.write.setToolTip(tr("Save the section as SVG, DXF or CSV."))
        self.copy = CopyCommandButton(self.copy_command, tr("the command for this section"))
        self.picture = DrawingView(tr("The section will be drawn here."))
        self.picture.setAccessibleName(tr("Section"))
        self._arrange_widgets()
        self._connect_signals()

    def _arrange_widgets(self) -> None:
        self._form_rows = form = narrow_form()
        form.addRow(tr("Model"), self.model)
        form.addRow(tr("Along"), self.path_kind)
        form.addRow(tr("Plane"), self.plane)
        self._through_row = create_row(self.through, self.use_point_button)
        form.addRow(tr("Through"), self._through_row)
        self._line_row = create_row(self.use_line_button, self.draw_line)
        form.addRow(tr("Line"), self._line_row)
        form.addRow("", self.section_options.place("flip"))
        form.addRow(tr("Project"), self.direction)
        form.addRow("", self.domain_axes)
        form.addRow("", self.features)
        self.feature_options.add_rows(form)
        self.section_options.add_rows(form)
        buttons = button_row(self.write, self.copy)
        FormWithPicture.fill(self, form, buttons, self.message, picture=self.picture)
        self.through.setToolTip(tr("Point on the plane (x, y, z), the origin of distances."))
        self.direction.line.setToolTip(
            tr("Projection direction of features (trend/plunge), such as the fold axis.")
        )
        self.draw_line.setToolTip(
            tr("Click along the outcrop, then press Enter for a vertical section.")
        )

    def _connect_signals(self) -> None:
        studio, schedule_refresh = self._studio, self._schedule_refresh
        for box in (self.model, self.path_kind):
            box.currentIndexChanged.connect(schedule_refresh)
        self.path_kind.currentIndexChanged.connect(self._show_rows)
        for signal in (
            self.through.textChanged,
            self.section_options.changed,
            self.feature_options.changed,
            self.plane.changed,
            self.direction.changed,
            self.features.toggled,
            self.domain_axes.toggled,
        ):
            signal.connect(schedule_refresh)
        self.plane.take_button.clicked.connect(lambda _=False: self._use_feature_centre())
        self.use_point_button.clicked.connect(lambda _=False: self._use_feature_centre())
        self.use_line_button.clicked.connect(
            lambda _=False: self._use_line(current_line(studio, PickedFeature))
        )
        self.draw_line.clicked.connect(lambda _=False: self._draw_line())
        self._drawn_line.finished.connect(self._use_line)
        title = tr("Write the section")
        self.write.clicked.connect(
            lambda _=False: self._ask_for_file(title, "section.svg", _FORMATS)
        )
        studio.edited.connect(self._follow_edit)
        studio.model_loaded.connect(schedule_refresh)
        studio.selection_changed.connect(self._refresh)
        self._show_rows()

    def _show_rows(self, *_: object) -> None:
        is_plane = self.path_kind.currentData() == "plane"
        for widget, is_visible in (
            (self.plane, is_plane),
            (self._through_row, is_plane),
            (self._line_row, not is_plane),
        ):
            self._form_rows.setRowVisible(widget, is_visible)
        self._refresh()

    # --- line and point -------------------------------------------------------------------------
    def _use_line(self, feature: Feature | None) -> None:
        if feature is None:
            return
        self.line = self._studio.measured([feature.id])[feature.id].points
        self._line_name = feature.name or tr("the drawn line")
        self.path_kind.setCurrentIndex(self.path_kind.findData("line"))
        self._schedule_refresh()

    def _draw_line(self) -> None:
        self._drawn_line.begin()
        self.message.setText(tr("Click along the outcrop, then press Enter."))

    def _use_feature_centre(self) -> None:
        feature = current_feature(self._studio)
        if feature is None:
            return
        points = self._studio.measured([feature.id])[feature.id].points
        if len(points):
            self.through.setText(", ".join(f"{v:.3f}" for v in points.mean(axis=0).tolist()))

    def _passing_point(self, model: Model) -> FloatArray:
        """Return the point (3,) on the plane in the World frame. Raises InputError if invalid.

        If no point was typed, it is the centre of the model.
        """
        text = self.through.text().strip()
        if not text:
            from vomstudio.geometry import transform

            low, high = self._studio.models[model.id].data.bounds
            corners = np.array(
                [[(low, high)[k][a] for a, k in enumerate(ijk)] for ijk in np.ndindex(2, 2, 2)]
            )
            world = transform.apply(model.to_world, corners)
            centre: FloatArray = np.round((world.min(axis=0) + world.max(axis=0)) / 2, 3)
            return centre
        values = parse_numbers(text)
        if values is None or len(values) != 3:
            raise InputError(Finding("section.not-a-point", text=text))
        return np.array(values, np.float64)

    def _show_axes(self, axes: Axes) -> None:
        for fields in (self.section_options, self.feature_options):
            fields.show_unit(length_unit(axes))

    # --- input ----------------------------------------------------------------------------------
    def _list_choices(self) -> None:
        self.model.list_models()

    def _compute_result(self, request: SectionRequest) -> SectionResult:
        return compute_section(request)

    def _create_request(self) -> SectionRequest:
        studio, model = self._studio, self.model.selected_model()
        if model is None:
            raise InputError(Finding("action.no-model"))
        path = studio.project.find_model(model)
        if path is None:
            raise InputError(Finding("model.file-missing", model=model.name))
        is_line = self.path_kind.currentData() == "line"
        if is_line and self.line is None:
            raise InputError(Finding("section.line-missing"))
        plane, direction = self.plane.plane(), self.direction.direction()
        if not is_line and plane is None:
            raise InputError(Finding("field.plane-missing"))
        passing_point = None if is_line else self._passing_point(model)
        curtain = build_curtain(plane, passing_point, self.line if is_line else None)
        # The switch mirrors the side that faces the view of the outcrop.
        flip = self._is_seen_from_behind(curtain) != self.section_options.options().flip
        curtain = curtain.flipped() if flip else curtain
        data, frame = studio.models[model.id].data, model.frame
        options = self.section_options.options(
            plane=None if plane is None or is_line else plane_text(plane),
            through=None if passing_point is None else format_numbers(passing_point.tolist()),
            section_line=self._line_name if is_line else None,
            flip=flip,
            **{} if isinstance(data, PointCloud) else {"slab_m": None},
        )
        uses_domain_axes = self.domain_axes.isChecked() and bool(
            domain_names(studio.session.records)
        )
        direction_text = (
            None if direction is None else f"{direction.trend_deg:.10g}/{direction.plunge_deg:.10g}"
        )
        features = SectionFeatures()
        if self.features.isChecked():
            features = self.feature_options.options(
                features=str(studio.project.folder),
                along=DOMAINS if uses_domain_axes else direction_text,
            )
        return SectionRequest(
            data=data,
            to_world=model.to_world,
            path=path,
            crs=world_crs(frame.crs, frame.unit_m),
            is_metric=frame.has_metres,
            is_north_known=frame.has_north,
            curtain=curtain,
            options=options,
            features=features,
            records=dict(studio.records) if self.features.isChecked() else None,
            direction=None if direction is None or uses_domain_axes else direction.vector(),
        )

    def _is_seen_from_behind(self, curtain: Curtain) -> bool:
        """Return whether the viewer of the outcrop is behind the section."""
        direction = self._view()
        if direction is None:
            return False
        facing = float(curtain.normal @ Line(*direction).vector())
        return facing > _MIN_FACING

    # --- result ---------------------------------------------------------------------------------
    def _result_text(self, result: SectionResult) -> str:
        f = result.figures
        unit = "m" if result.request.is_metric else tr("units")
        texts = [
            tr_n(
                "{count} line, {length:.3f} {unit} in total",
                "{count} lines, {length:.3f} {unit} in total",
                f.polylines,
                length=f.length_m,
                unit=unit,
            )
        ]
        if f.slab_m is not None:
            texts.append(
                tr(
                    "{count:,} points in a slab {slab:.3g} {unit} thick",
                    count=f.points,
                    slab=f.slab_m,
                    unit=unit,
                )
            )
        if result.request.records is not None:
            texts.append(
                tr(
                    "{count} features projected, {left_out} left out",
                    count=f.features,
                    left_out=f.left_out,
                )
            )
        if result.request.curtain.plane is None:
            texts.append(tr("along {name}", name=self._line_name))
        texts += [domain.words for domain in f.domains or ()]
        return "; ".join([*texts, *map(str, result.warnings)])

    def _draw(self) -> None:
        drawing = None if self.result is None else self.result.drawing
        self.picture.show_drawing(drawing)

    def _refresh(self) -> None:
        has_domains = self._studio.has_project and bool(domain_names(self._studio.session.records))
        self._form_rows.setRowVisible(self.domain_axes, has_domains)
        uses_domain_axes = has_domains and self.domain_axes.isChecked()
        set_enabled(
            self.direction, Finding("action.direction-by-domain") if uses_domain_axes else None
        )
        reason = None
        if self._requests.is_waiting:
            reason = Finding("action.busy")
        elif self.result is None:
            reason = Finding("action.no-result")
        set_enabled(self.write, reason)
        self.copy.set_enabled(reason)
        line, feature = current_line(self._studio, PickedFeature), current_feature(self._studio)
        set_enabled(self.use_line_button, None if line is not None else Finding("action.no-line"))
        set_enabled(
            self.use_point_button, None if feature is not None else Finding("action.no-feature")
        )
        model = self.model.selected_model() if self._studio.has_project else None
        is_cloud = model is not None and isinstance(self._studio.models[model.id].data, PointCloud)
        slab = self.section_options.fields["slab_m"]
        set_enabled(slab, None if is_cloud else Finding("action.clouds-only"))

    # --- export ---------------------------------------------------------------------------------
    def write_result(self, path: Path) -> None:
        if self.result is not None:
            self._write(write, self.result, path)

    def copy_command(self) -> None:
        """Copy the command; if the section follows a line, ask for the file of that line."""
        result = self.result
        if result is None:
            return
        if result.request.curtain.plane is not None and self.profile_line is None:
            command = self.command(None)
            if command is not None:
                copy_command(self._studio, command)
            return
        line = self.profile_line
        assert line is not None

        def write_line(path: Path) -> None:
            rows = ["x,y", *(format_numbers(point) for point in line[:, :2].tolist())]
            write_bytes(path, ("\n".join(rows) + "\n").encode(), force=True)

        copy_with_file(
            self, self._studio, "profile.csv", write_line, lambda path: self.command(path) or []
        )

    @property
    def profile_line(self) -> FloatArray | None:
        """Line of the section, or None for a section along a plane."""
        return self.line if self.path_kind.currentData() == "line" else None

    def command(self, profile: Path | None) -> CommandArguments | None:
        """Return the command that makes the section, or None if it cannot be reproduced.

        `profile` is the file of the section line, or None for a section along a plane.
        """
        model, result = self.model.selected_model(), self.result
        model_arguments = None if model is None else find_model_arguments(self._studio, model)
        if model_arguments is None or result is None:
            return None
        request = result.request
        options = request.options
        if profile is not None:
            options = replace(options, section_line=str(profile))
        features = request.features if self._studio.session.features() else SectionFeatures()
        out = results_folder(self._studio) / "section.svg"
        return [
            "section",
            *model_arguments,
            *option_words(options),
            *option_words(features),
            ("-o", out),
        ]
