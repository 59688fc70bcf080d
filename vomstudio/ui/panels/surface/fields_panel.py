"""Panel for surface fields: orientation, curvature and planarity of the outcrop."""

from __future__ import annotations

from dataclasses import replace

from PySide6.QtCore import QSignalBlocker
from PySide6.QtWidgets import (
    QCheckBox,
    QDoubleSpinBox,
    QHBoxLayout,
    QPushButton,
)

from vomstudio.core.findings import Finding
from vomstudio.core.words import to_translate, tr
from vomstudio.extraction.surface_fields import KINDS
from vomstudio.project.kinds import get_kind
from vomstudio.project.records import Model, get_feature
from vomstudio.studio.display import default_appearance
from vomstudio.studio.surfaces.measurable_planes import EXPECTED, MEASURABLE, set_names
from vomstudio.studio.surfaces.surface_fields import (
    MODEL_DISTANCE,
    PLANE_DISTANCE,
    FieldRequest,
    field_values,
    statistics,
)
from vomstudio.ui.base.controls import ComboBox, DoubleSpinBox, narrow_form, set_enabled
from vomstudio.ui.base.qt_owner import connect_until_deleted
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.surface.direction_wheel import DirectionWheel
from vomstudio.ui.panels.surface.measurable_plane import MeasurablePlane
from vomstudio.ui.panels.surface.model_panel import ModelPanel
from vomstudio.ui.panels.tools.common import hint_label, narrow_column

_HUE_MAP, _COLOR_BLIND_MAP = "hsv", "twilight"
_PLANE_KINDS = {
    PLANE_DISTANCE: (
        to_translate("Distance to a plane"),
        to_translate(
            "Distance from the extended plane of the selected feature, positive above it."
        ),
    ),
    MODEL_DISTANCE: (
        to_translate("Distance to another model"),
        to_translate("Signed distance to the nearest point of another model."),
    ),
    MEASURABLE: (
        to_translate("Plane measurability"),
        to_translate("Expected quality (good, doubtful, poor) of a plane of this attitude."),
    ),
    EXPECTED: (
        to_translate("Expected plane error"),
        to_translate("Expected 95 % error of a plane of this attitude, in degrees."),
    ),
}


class FieldsPanel(ModelPanel):
    """Panel that computes a surface field and shows its statistics."""

    def __init__(self, studio: Studio) -> None:
        super().__init__(
            studio,
            studio.fields,
            "field",
            "conventions.md#fields-of-the-surface",
            tr("Show"),
            "palette-outline",
        )
        self._fields = studio.fields
        self._form_model_id = ""
        self._form_field: object = None
        self._plane_id = ""
        self._create_widgets()
        self._arrange_widgets()
        connect_until_deleted(self, studio.display.changed, self._follow_display)
        self._follow()

    def _create_widgets(self) -> None:
        self.kind = ComboBox()
        self.kind.setObjectName("field_kind")
        for key, field_kind in KINDS.items():
            self.kind.addItem(tr(field_kind.title), key)
        for key, (title, _) in _PLANE_KINDS.items():
            self.kind.addItem(tr(title), key)
        self.kind.keep_narrow()
        self.kind.activated.connect(self._change_kind)
        self.radius = DoubleSpinBox()
        self.radius.setObjectName("field_radius")
        self.radius.setDecimals(3)
        self.radius.setRange(0.001, 10_000.0)
        self.radius.setStepType(QDoubleSpinBox.StepType.AdaptiveDecimalStepType)
        self.radius.setKeyboardTracking(False)
        self.radius.setToolTip(tr("Radius around each point: the scale of the analysis."))
        self.radius.valueChanged.connect(lambda _: self._refresh_buttons())
        self.plane = hint_label()
        self.plane.setObjectName("field_plane")
        self.other_model = ComboBox()
        self.other_model.setObjectName("field_other")
        self.other_model.keep_narrow()
        self.other_model.activated.connect(lambda _: self._refresh_buttons())
        self.measurable = MeasurablePlane()
        self.measurable.changed.connect(self._refresh_buttons)
        self.color_blind_box = QCheckBox(tr("Colour-blind palette"))
        self.color_blind_box.setToolTip(
            tr("Use light, blue, dark and red for north, east, south, west.")
        )
        self.color_blind_box.clicked.connect(self._update_colors)
        self.wheel = DirectionWheel()
        self.reset_button = QPushButton()
        self.reset_button.setToolTip(tr("Show the previous colours; the field remains available."))
        self.reset_button.setObjectName("field_off")
        self.reset_button.clicked.connect(lambda _: self._studio.display.set_mode("textured"))
        self.progress.setTextVisible(True)
        self.description = hint_label()
        self.description.setObjectName("field_says")
        self.figures = hint_label()
        self.figures.setObjectName("field_figures")

    def _arrange_widgets(self) -> None:
        self._form = narrow_form()
        self._form.addRow(tr("Field"), self.kind)
        self._form.addRow(tr("Radius"), self.radius)
        self._form.addRow(tr("Plane"), self.plane)
        self._form.addRow(tr("Model"), self.other_model)
        self._form.addRow(self.measurable)
        buttons = QHBoxLayout()
        buttons.addWidget(self.start)
        buttons.addWidget(self.reset_button)
        wheel_row = QHBoxLayout()
        wheel_row.addStretch()
        wheel_row.addWidget(self.wheel)
        wheel_row.addStretch()
        column = narrow_column(self)
        column.addWidget(self.title)
        column.addLayout(self._form)
        column.addLayout(buttons)
        column.addWidget(self.progress)
        column.addWidget(self.figures)
        column.addWidget(self.color_blind_box)
        column.addLayout(wheel_row)
        column.addWidget(self.description)
        column.addStretch()

    # --- display -----------------------------------------------------------------------------
    def update_widgets(self) -> None:
        """Show the current model, selection and job."""
        super().update_widgets()
        studio, model = self._studio, self._model
        if model is not None and model.id in studio.models:
            # The field of an opened project is shown after its model.
            field = self._fields.shown_fields.get(model.id)
            if self._form_model_id != model.id or field is not self._form_field:
                self._set_model(model)
        is_metric = model is None or model.frame.has_metres
        unit = "m" if is_metric else tr("units")
        self.radius.setSuffix(f" {unit}")
        self.measurable.options.show_unit(unit)
        self._list_other_models()
        self._show_plane()
        self._show_rows()
        self._refresh_buttons()
        self._show_figures()

    def _set_model(self, model: Model) -> None:
        """Show the field of a model, or the default radius and length for that model."""
        self._form_model_id = model.id
        self._form_field = field = self._fields.shown_fields.get(model.id)
        radius = 0.0 if field is None else field.request.radius_m
        is_plane_field = field is not None and field.request.kind in (MEASURABLE, EXPECTED)
        with QSignalBlocker(self.radius):
            self.radius.setValue(
                radius if radius and not is_plane_field else self._fields.suggest_radius(model.id)
            )
        self.measurable.show_request("", self._fields.suggest_length(model.id))
        if field is not None and is_plane_field:
            self.measurable.show_request(field.request.of, radius)
        if field is not None:
            self.kind.setCurrentIndex(self.kind.findData(field.request.kind))

    def _list_other_models(self) -> None:
        model_id = "" if self._model is None else self._model.id
        other_models = [
            (m.name, m.id)
            for m in (self._studio.session.of(Model) if self._studio.has_project else [])
            if m.id != model_id and m.id in self._studio.models
        ]
        items = [
            (self.other_model.itemText(i), self.other_model.itemData(i))
            for i in range(self.other_model.count())
        ]
        if items == other_models:
            return
        previous = self.other_model.currentData()
        self.other_model.clear()
        for name, id_ in other_models:
            self.other_model.addItem(name, id_)
        self.other_model.setCurrentIndex(max(self.other_model.findData(previous), 0))

    def _show_plane(self) -> None:
        """Show the plane of the most recently selected feature, even after it is deselected."""
        studio = self._studio
        if not studio.has_project:
            return
        for id_ in reversed(studio.selection.ids):
            feature = get_feature(studio.records, id_)
            if feature is not None and get_kind(feature).plane is not None:
                self._plane_id = id_
                break
        feature = get_feature(studio.records, self._plane_id)
        if feature is None:
            self._plane_id = ""
        self.plane.setText(
            tr("Select a trace or patch.")
            if feature is None
            else tr("of {name}", name=feature.name)
        )
        self.measurable.list_sources(
            set_names(studio.records), self._plane_id, "" if feature is None else feature.name
        )

    def _field_request(self) -> FieldRequest | None:
        field_name = str(self.kind.currentData())
        if field_name == PLANE_DISTANCE:
            return FieldRequest(field_name, of=self._plane_id) if self._plane_id else None
        if field_name == MODEL_DISTANCE:
            other_model = self.other_model.currentData()
            return FieldRequest(field_name, of=str(other_model)) if other_model else None
        if field_name in (MEASURABLE, EXPECTED):
            length_m = self.measurable.options.value("length_m")
            if length_m is None and self._model is not None:
                length_m = self._fields.suggest_length(self._model.id)
            request = FieldRequest(field_name, length_m or 0.0, self.measurable.plane_source())
            return (
                request if request.of and self._fields.resolve_plane(request) is not None else None
            )
        return FieldRequest(field_name, self.radius.value())

    def _show_rows(self) -> None:
        field_name = str(self.kind.currentData())
        self._form.setRowVisible(self.radius, field_name in KINDS)
        self._form.setRowVisible(self.plane, field_name == PLANE_DISTANCE)
        self._form.setRowVisible(self.other_model, field_name == MODEL_DISTANCE)
        self._form.setRowVisible(self.measurable, field_name in (MEASURABLE, EXPECTED))
        is_direction = field_name == "dip_direction"
        self.color_blind_box.setVisible(is_direction)
        self.wheel.setVisible(is_direction)
        if is_direction:
            model = self._model
            north = model is not None and model.frame.has_north
            name = _COLOR_BLIND_MAP if self.color_blind_box.isChecked() else _HUE_MAP
            self.wheel.show_map(name, is_north_known=north)
        description = (
            KINDS[field_name].description if field_name in KINDS else _PLANE_KINDS[field_name][1]
        )
        lines = [tr(description)]
        if is_direction and self._model is not None and not self._model.frame.has_north:
            lines.append(tr("North is unknown: directions are in the local frame of the model."))
        self.description.setText(" ".join(lines))

    def _refresh_buttons(self) -> None:
        super()._refresh_buttons()
        self._update_reset_button()

    def _follow_display(self, change: str) -> None:
        if change == "mode":
            self._update_reset_button()

    def _update_reset_button(self) -> None:
        """Enable the button that ends the field display, and name the mode to which it returns."""
        open_model = None if self._model is None else self._studio.models.get(self._model.id)
        self.reset_button.setText(
            default_appearance([] if open_model is None else [open_model.data])
        )
        is_shown = self._studio.display.mode == "field"
        set_enabled(self.reset_button, None if is_shown else Finding("action.no-field"))

    def _disabled_reason(self) -> Finding | None:
        reason = super()._disabled_reason()
        if reason is None and self._field_request() is None:
            if self.kind.currentData() == PLANE_DISTANCE:
                return Finding("selection.no-trace-or-patch")
            if self.kind.currentData() in (MEASURABLE, EXPECTED):
                return Finding("field.plane-missing")
            return Finding("model.no-other")
        return reason

    def _show_figures(self) -> None:
        lines = [" ".join(map(str, self._fields.findings))] if self._fields.findings else []
        model = self._model
        field = None if model is None else self._fields.shown_fields.get(model.id)
        open_model = None if model is None else self._studio.models.get(model.id)
        values = (
            None if field is None or open_model is None else field_values(open_model, field.name)
        )
        if (
            values is not None
            and field is not None
            and field.request.kind
            not in (
                "dip_direction",
                MEASURABLE,
            )
        ):
            figures = statistics(values)
            if figures is not None:
                unit = field.name.rpartition("[")[2].rstrip("]") if "[" in field.name else ""
                lines.append(
                    tr(
                        "{field}: median {median:.3g} {unit}, 90 % between {low:.3g} and"
                        " {high:.3g} {unit}.",
                        field=field.name.partition(" [")[0],
                        unit=unit,
                        **figures,
                    )
                    .replace(" ,", ",")
                    .replace(" .", ".")
                    .replace(" °", "°")
                )
        self.figures.setText("\n".join(lines))
        self.figures.setVisible(bool(lines))

    # --- actions -----------------------------------------------------------------------------
    def _change_kind(self, *_: object) -> None:
        """Show the selected field immediately if it has been computed."""
        self._show_rows()
        self._refresh_buttons()
        model, request = self._model, self._field_request()
        if model is None or request is None or self._fields.running is not None:
            return
        open_model, name = (
            self._studio.models.get(model.id),
            self._fields.get_name(model.id, request),
        )
        if (
            open_model is not None
            and name in open_model.data.fields
            and model.id in self._fields.shown_fields
        ):
            self._show_request(model, request)

    def _start(self, model: Model) -> None:
        if (request := self._field_request()) is not None:
            self._show_request(model, request)

    def _show_request(self, model: Model, request: FieldRequest) -> None:
        palette = _COLOR_BLIND_MAP if self.color_blind_box.isChecked() else _HUE_MAP
        self._fields.request_field(
            model.id, request, palette if request.kind == "dip_direction" else None
        )

    def _update_colors(self) -> None:
        """Apply the selected colour map to the displayed field of dip directions."""
        self._show_rows()
        model = self._model
        field = None if model is None else self._fields.shown_fields.get(model.id)
        if model is None or field is None or field.request.kind != "dip_direction":
            return
        style = self._studio.display.styles.get(model.id)
        if style is not None and style.name == field.name:
            self._studio.display.show_field(model.id, replace(style, palette=self.wheel.map_name))
