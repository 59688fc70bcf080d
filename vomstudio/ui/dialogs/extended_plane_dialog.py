"""A plane carried on through its model: the band of its error in colours, and its traces as a
file."""

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
from vomstudio.ui.base.controls import Label, allow
from vomstudio.ui.base.help_links import explain
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.outcrop.extended_plane_drawings import ExtendedLines
from vomstudio.ui.widgets.axis_titles import axes_of, unit_of
from vomstudio.ui.widgets.options_form import OptionFields

FIELD = "extended_plane_m"
"""Of the model's points in the band: their distance from the plane."""


class ExtendDialog(QDialog):
    """Of the plane that was selected when it was opened. The work is done in a thread."""

    def __init__(self, parent: QWidget, studio: Studio, plane: Feature) -> None:
        super().__init__(parent)
        explain(self, "conventions.md#planes-carried-on")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(tr("Extend {name} through the model", name=plane.name))
        self.setMinimumWidth(520)
        self._studio, self._plane = studio, plane
        self._model_id: str = plane.model_id  # type: ignore[attr-defined]
        self.found: ExtendedPlane | None = None
        self.limits = OptionFields(ExtendOptions, "extend")
        self.limits.show_unit(unit_of(axes_of(studio)))
        form = QFormLayout()
        self.limits.add_rows(form)
        self.painted = QCheckBox(tr("Colour the band by the distance from the plane"))
        self.painted.setToolTip(
            tr(
                "Without colours the outcrop keeps its texture under the lines, so that the plane "
                "can be held against the beds."
            )
        )
        self.painted.setChecked(True)
        self.painted.toggled.connect(self._paint)
        form.addRow(self.painted)
        self.said = Label(
            tr(
                "Places on the outcrop that lie within the 95 % error of the plane are coloured by "
                "their distance from it. Lines show the plane and the edges of its band while this "
                "window is open."
            )
        )
        self.said.setWordWrap(True)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        role = QDialogButtonBox.ButtonRole.ActionRole
        self.show_button = buttons.addButton(tr("Show on the outcrop"), role)
        self.save_button = buttons.addButton(tr("Save its traces…"), role)
        self.show_button.clicked.connect(self.start)
        self.save_button.clicked.connect(self._ask_for_file)
        buttons.rejected.connect(self.reject)
        self.show_button.setDefault(True)
        layout = QVBoxLayout(self)
        layout.addLayout(form)
        layout.addWidget(self.said)
        layout.addStretch()
        layout.addWidget(buttons)
        self._background = QtBackground(self)
        self._busy = False
        self._mode_before = studio.display.mode
        self._style_before = studio.display.styles.get(self._model_id)
        self._reach: float | None = None
        self._refresh_buttons()

    def start(self) -> None:
        """Work it out with what is typed, and show it."""
        studio = self._studio
        model, opened = studio.records.get(self._model_id), studio.models.get(self._model_id)
        plane = studio.records.get(self._plane.id)
        fit = None if not isinstance(plane, Feature) else studio.measure(plane).fit
        if not isinstance(model, Model) or opened is None or fit is None:
            self.said.setText(Finding("field.feature-missing").message)
            return
        try:
            options = self.limits.options()
        except VomError as error:
            self.said.setText(error.message)
            return
        self._busy = True
        self.said.setText(tr("Carrying the plane on…"))
        self._refresh_buttons()
        self._background.run(
            partial(_carry_on, opened.data, model, fit, options),
            self._came,
            self._failed,
        )

    def _failed(self, error: VomError) -> None:
        self._busy = False
        self.said.setText(error.message)
        self._refresh_buttons()

    def _came(self, made: tuple[ExtendedPlane, tuple[list[np.ndarray], np.ndarray]]) -> None:
        self._busy = False
        self.found, lines = made
        self.said.setText(
            "\n".join(
                [
                    *_lines(self.found, metric=axes_of(self._studio).metric),
                    *map(str, self.found.warnings),
                ]
            )
        )
        self._refresh_buttons()
        self._studio.extension_shown.emit(ExtendedLines(self._model_id, *lines))
        opened, bands = self._studio.models.get(self._model_id), self.found.bands
        if opened is None or bands is None:
            return
        values = np.where(bands.inside, bands.distance_m, np.nan).astype(np.float32)
        if not opened.give_fields({FIELD: values}):
            self._studio.warn(Finding("model.fields-too-large"))
            return
        self._reach = float(np.nanmax(np.abs(values))) if np.isfinite(values).any() else 1.0
        self._paint()

    def _paint(self) -> None:
        """Colours of the band, or the outcrop as it was shown before."""
        display = self._studio.display
        if self._reach is None:
            return
        if self.painted.isChecked():
            style = FieldStyle(FIELD, -self._reach, self._reach, palette="PuOr_r")
            display.show_field(self._model_id, style)
        else:
            self._unpaint()

    def _unpaint(self) -> None:
        """The outcrop as it was before, unless another field is shown by now."""
        display = self._studio.display
        shown = display.styles.get(self._model_id)
        if shown is None or shown.name != FIELD:
            return
        if self._style_before is not None:
            display.show_field(self._model_id, self._style_before)
        else:
            display.show_no_field(self._model_id)
        if display.mode == "field":
            display.set_mode(self._mode_before)

    def done(self, result: int) -> None:
        """However it is closed: colours go with the lines, or a grey outcrop would stay."""
        try:
            self._studio.extension_shown.emit(None)
            self._unpaint()
        finally:
            super().done(result)

    def _refresh_buttons(self) -> None:
        busy = Finding("extension.pending") if self._busy else None
        allow(self.show_button, busy)
        allow(self.save_button, busy or (None if self.found else Finding("extension.missing")))

    def _ask_for_file(self) -> None:
        formats = {"gpkg": "GeoPackage", "csv": "CSV"}
        name = f"{self._plane.name}_extended.gpkg"
        path = ask_for_target(self, self._studio, tr("Save the traces"), name, formats)
        if path is not None:
            self.save_to(path)

    def save_to(self, path: Path) -> None:
        """Write the traces, in World."""
        model = self._studio.records.get(self._model_id)
        if self.found is None or not isinstance(model, Model):
            return
        frame = model.frame
        crs = None if frame.crs is None else world_crs(frame.crs, frame.unit_m)
        try:
            write_traces(path, self.found, crs=crs, model=model.name, force=True, axes=frame.axes)
        except VomError as error:
            self._studio.warn(error, "error")
            return
        self._studio.info(Finding("export.written", file=path))


def _carry_on(
    data: Mesh | PointCloud, model: Model, fit: FittedPlane, options: ExtendOptions
) -> tuple[ExtendedPlane, tuple[list[np.ndarray], np.ndarray]]:
    """Carry a plane on through the model, in World. Runs in a worker thread."""
    world = transform_model(data, model.to_world)
    belief = plane_estimate_from_fit(fit)
    found = extend(world, belief, options)
    edges = [np.zeros((0, 2, 3))]
    if isinstance(world, Mesh):
        beds = repeat_planes(belief, world.vertices, options.thickness_m, options.thickness_error_m)
        for bed in found.beds:
            edges += band_edges(world, belief, beds, bed.bed)
    return found, ([trace.points for trace in found.traces], np.concatenate(edges))


def _lines(found: ExtendedPlane, *, metric: bool) -> list[str]:
    least = min(bed.least_error95_m for bed in found.beds)
    most = max(bed.most_error95_m for bed in found.beds)
    return [
        tr_n(
            "{count} plane meets the model, over {length}.",
            "{count} planes meet the model, over {length}.",
            len(found.beds),
            length=length_text(found.length_m, metric=metric),
        ),
        tr(
            "Its place is known to {least} where it is known best, and to {most} at the far end "
            "(95 %).",
            least=length_text(least, metric=metric),
            most=length_text(most, metric=metric),
        ),
        tr("This is where it is if it goes on as a plane."),
    ]
