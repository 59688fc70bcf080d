"""Dialog that extends a plane through its model, with an error band and traces."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtWidgets import (
    QCheckBox,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr, tr_n
from vomstudio.geology.beds.extended import plane_estimate_from_fit, repeat_planes
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.field_style import FieldStyle
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.model_transform import transform_model
from vomstudio.geometry.planes import FittedPlane
from vomstudio.geometry.units import length_text
from vomstudio.io.gis.crs import world_crs
from vomstudio.products.section.extend_options import ExtendOptions
from vomstudio.products.section.extension import ExtendedPlane, band_edges, extend, write_traces
from vomstudio.project.records import Feature, Model
from vomstudio.ui.base.command_targets import ask_for_target
from vomstudio.ui.base.controls import Label, set_enabled
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.outcrop.extended_plane_drawings import ExtendedLines
from vomstudio.ui.widgets.axis_titles import length_unit, project_axes
from vomstudio.ui.widgets.options_form import OptionFields

DISTANCE_FIELD = "extended_plane_m"
"""Scalar field with the distance from the plane, for points within the error band."""


class ExtendDialog(QDialog):
    """Dialog that extends a plane through its model. The computation runs in a thread."""

    def __init__(self, parent: QWidget, studio: Studio, plane: Feature) -> None:
        super().__init__(parent)
        set_help_topic(self, "conventions.md#extended-planes")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(tr("Extend {name}", name=plane.name))
        self.setMinimumWidth(520)
        self._studio, self._plane = studio, plane
        self._model_id: str = plane.model_id  # type: ignore[attr-defined]
        self.extension: ExtendedPlane | None = None
        self.limits = OptionFields(ExtendOptions, "extend")
        self.limits.show_unit(length_unit(project_axes(studio)))
        form = QFormLayout()
        self.limits.add_rows(form)
        self.color_box = QCheckBox(tr("Colour by distance"))
        self.color_box.setToolTip(tr("Turn off to compare the lines with the textured outcrop."))
        self.color_box.setChecked(True)
        self.color_box.toggled.connect(self._show_colors)
        form.addRow(self.color_box)
        self.summary = Label(
            tr(
                "Rock within the 95 % error of the plane is coloured by distance. Lines show the"
                " plane and the edges of its error band."
            )
        )
        self.summary.setWordWrap(True)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        role = QDialogButtonBox.ButtonRole.ActionRole
        self.show_button = buttons.addButton(tr("Show on outcrop"), role)
        self.save_button = buttons.addButton(tr("Save traces…"), role)
        self.show_button.clicked.connect(self.start)
        self.save_button.clicked.connect(self._ask_for_file)
        buttons.rejected.connect(self.reject)
        self.show_button.setDefault(True)
        layout = QVBoxLayout(self)
        layout.addLayout(form)
        layout.addWidget(self.summary)
        layout.addStretch()
        layout.addWidget(buttons)
        self._background = QtBackground(self)
        self._is_busy = False
        self._previous_mode = studio.display.mode
        self._previous_style = studio.display.styles.get(self._model_id)
        self._max_distance_m: float | None = None
        self._refresh_buttons()

    def start(self) -> None:
        """Extend the plane with the entered options, and show the result."""
        studio = self._studio
        model, open_model = studio.records.get(self._model_id), studio.models.get(self._model_id)
        plane = studio.records.get(self._plane.id)
        fit = None if not isinstance(plane, Feature) else studio.measure(plane).fit
        if not isinstance(model, Model) or open_model is None or fit is None:
            self.summary.setText(Finding("field.feature-missing").message)
            return
        try:
            options = self.limits.options()
        except VomError as error:
            self.summary.setText(error.message)
            return
        self._is_busy = True
        self.summary.setText(tr("Extending the plane…"))
        self._refresh_buttons()
        self._background.run(
            partial(_extend_plane, open_model.data, model, fit, options),
            self._show_result,
            self._handle_failure,
        )

    def _handle_failure(self, error: VomError) -> None:
        self._is_busy = False
        self.summary.setText(error.message)
        self._refresh_buttons()

    def _show_result(
        self, result: tuple[ExtendedPlane, tuple[list[np.ndarray], np.ndarray]]
    ) -> None:
        self._is_busy = False
        self.extension, lines = result
        self.summary.setText(
            "\n".join(
                [
                    *_describe_extension(
                        self.extension, is_metric=project_axes(self._studio).metric
                    ),
                    *map(str, self.extension.warnings),
                ]
            )
        )
        self._refresh_buttons()
        self._studio.extension_shown.emit(ExtendedLines(self._model_id, *lines))
        open_model, bands = self._studio.models.get(self._model_id), self.extension.bands
        if open_model is None or bands is None:
            return
        values = np.where(bands.is_in_band, bands.distance_m, np.nan).astype(np.float32)
        if not open_model.add_fields({DISTANCE_FIELD: values}):
            self._studio.warn(Finding("model.fields-too-large"))
            return
        self._max_distance_m = (
            float(np.nanmax(np.abs(values))) if np.isfinite(values).any() else 1.0
        )
        self._show_colors()

    def _show_colors(self) -> None:
        """Colour the error band, or restore the previous display."""
        display = self._studio.display
        if self._max_distance_m is None:
            return
        if self.color_box.isChecked():
            style = FieldStyle(
                DISTANCE_FIELD, -self._max_distance_m, self._max_distance_m, palette="PuOr_r"
            )
            display.show_field(self._model_id, style)
        else:
            self._restore_colors()

    def _restore_colors(self) -> None:
        display = self._studio.display
        style = display.styles.get(self._model_id)
        # Another field may have been selected in the meantime.
        if style is None or style.name != DISTANCE_FIELD:
            return
        if self._previous_style is not None:
            display.show_field(self._model_id, self._previous_style)
        else:
            display.hide_field(self._model_id)
        if display.mode == "field":
            display.set_mode(self._previous_mode)

    def done(self, result: int) -> None:
        """Close the dialog and remove its lines and colours."""
        try:
            self._studio.extension_shown.emit(None)
            self._restore_colors()
        finally:
            super().done(result)

    def _refresh_buttons(self) -> None:
        busy_finding = Finding("extension.pending") if self._is_busy else None
        set_enabled(self.show_button, busy_finding)
        set_enabled(
            self.save_button,
            busy_finding or (None if self.extension else Finding("extension.missing")),
        )

    def _ask_for_file(self) -> None:
        formats = {"gpkg": "GeoPackage", "csv": "CSV"}
        name = f"{self._plane.name}_extended.gpkg"
        path = ask_for_target(self, self._studio, tr("Save traces"), name, formats)
        if path is not None:
            self.save_traces(path)

    def save_traces(self, path: Path) -> None:
        """Write the traces in World coordinates to a file."""
        model = self._studio.records.get(self._model_id)
        if self.extension is None or not isinstance(model, Model):
            return
        frame = model.frame
        crs = None if frame.crs is None else world_crs(frame.crs, frame.unit_m)
        try:
            write_traces(
                path, self.extension, crs=crs, model=model.name, force=True, axes=frame.axes
            )
        except VomError as error:
            self._studio.warn(error, "error")
            return
        self._studio.written(path)


def _extend_plane(
    data: Mesh | PointCloud, model: Model, fit: FittedPlane, options: ExtendOptions
) -> tuple[ExtendedPlane, tuple[list[np.ndarray], np.ndarray]]:
    """Extend a plane through a model in the World frame. Runs in a worker thread."""
    world = transform_model(data, model.to_world)
    estimate = plane_estimate_from_fit(fit)
    extension = extend(world, estimate, options)
    edges = [np.zeros((0, 2, 3))]
    if isinstance(world, Mesh):
        planes = repeat_planes(
            estimate, world.vertices, options.thickness_m, options.thickness_error_m
        )
        for bed in extension.beds:
            edges += band_edges(world, estimate, planes, bed.bed)
    return extension, ([trace.points for trace in extension.traces], np.concatenate(edges))


def _describe_extension(extension: ExtendedPlane, *, is_metric: bool) -> list[str]:
    min_error_m = min(bed.least_error95_m for bed in extension.beds)
    max_error_m = max(bed.most_error95_m for bed in extension.beds)
    return [
        tr_n(
            "{count} plane intersects the model over {length}.",
            "{count} planes intersect the model over {length}.",
            len(extension.beds),
            length=length_text(extension.length_m, is_metric=is_metric),
        ),
        tr(
            "The 95 % position error ranges from {least} to {most} at the far end.",
            least=length_text(min_error_m, is_metric=is_metric),
            most=length_text(max_error_m, is_metric=is_metric),
        ),
        tr("This assumes that the structure continues as a plane."),
    ]
