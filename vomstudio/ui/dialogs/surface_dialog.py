"""A patch as a surface: the map of its deviations, profiles, and what they say."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
from PySide6.QtCore import Qt
from PySide6.QtGui import QImage, QPixmap
from PySide6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.errors import VomError
from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry.cloud import PointCloud
from vomstudio.geometry.field_style import FieldStyle
from vomstudio.geometry.mesh import Mesh
from vomstudio.geometry.model_transform import transform_model
from vomstudio.geometry.patches import runs_to_ids
from vomstudio.io.gis.crs import world_crs
from vomstudio.products.surface.analysis import SurfaceFigures, analyse
from vomstudio.products.surface.figure import describe_figures, draw_surface
from vomstudio.products.surface.patch import extract_faces
from vomstudio.products.surface.surface_options import SurfaceOptions
from vomstudio.products.surface.writing import FIELDS, write_deviations
from vomstudio.project import edits
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.records import Model, Painted, get
from vomstudio.studio.tools.brush_stroke import record_figures
from vomstudio.ui.base.command_targets import ask_for_target
from vomstudio.ui.base.controls import Label, allow
from vomstudio.ui.base.help_links import explain
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.widgets.axis_titles import length_unit, project_axes
from vomstudio.ui.widgets.options_form import OptionFields

_SIZE = (760, 520)


class SurfaceDialog(QDialog):
    """Of the patch that was selected when it was opened. The work is done in a thread."""

    def __init__(self, parent: QWidget, studio: Studio, patch: Painted) -> None:
        super().__init__(parent)
        explain(self, "conventions.md#surfaces")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(tr("Patch {name} as a surface", name=patch.name))
        self._studio, self._patch = studio, patch
        self._part: Mesh | PointCloud | None = None
        self.found: SurfaceFigures | None = None
        self.picture = Label(tr("Looking at the patch…"))
        self.picture.setMinimumSize(*_SIZE)
        self.picture.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.limits = OptionFields(SurfaceOptions, "surface")
        self.limits.show_unit(length_unit(project_axes(studio)))
        self.limits.changed.connect(self.start)
        form = QFormLayout()
        self.limits.add_rows(form)
        self.said = Label()
        self.said.setWordWrap(True)
        self.said.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        role = QDialogButtonBox.ButtonRole.ActionRole
        self.show_button = buttons.addButton(tr("Show on the model"), role)
        self.trim_button = buttons.addButton(tr("Trim the patch"), role)
        self.save_button = buttons.addButton(tr("Save the map…"), role)
        self.show_button.clicked.connect(self.show_on_model)
        self.trim_button.setToolTip(tr("Leave out of the patch what departs from its plane."))
        self.trim_button.clicked.connect(self.trim)
        self.save_button.clicked.connect(self._ask_for_file)
        buttons.rejected.connect(self.reject)
        for button in buttons.buttons():
            # Return ends the typing of the noise.
            button.setAutoDefault(False)  # type: ignore[attr-defined]
        layout = QVBoxLayout(self)
        layout.addWidget(self.picture, 1)
        layout.addWidget(self.said)
        layout.addLayout(form)
        layout.addWidget(buttons)
        self._refresh_buttons()
        self._looked_at: SurfaceOptions | None = None
        self._background = QtBackground(self)
        self.start()

    def start(self) -> None:
        """Look at the patch, with the noise that is typed."""
        options = self.limits.options()
        if options == self._looked_at:
            return
        studio, patch = self._studio, self._patch
        model, opened = studio.records.get(patch.model_id), studio.models.get(patch.model_id)
        if not isinstance(model, Model) or opened is None:
            self.said.setText(Finding("model.not-open").message)
            return
        self._looked_at, self.found = options, None
        self._refresh_buttons()
        ratio = self.devicePixelRatioF()
        self._background.run(
            partial(_look, opened.data, model, patch, ratio, options), self._came, self._failed
        )

    def _failed(self, error: VomError) -> None:
        self.picture.setText(str(error))
        self._refresh_buttons()

    def _came(self, made: tuple[Mesh | PointCloud, SurfaceFigures, QImage]) -> None:
        self._part, self.found, image = made
        self.picture.setPixmap(QPixmap.fromImage(image))
        self.said.setText(
            "\n".join(describe_figures(self.found, metric=project_axes(self._studio).metric))
        )
        if self._looked_at == SurfaceOptions():
            self.limits.show_automatic("noise_m", self.found.noise_m)
        self._refresh_buttons()

    def _refresh_buttons(self) -> None:
        waiting = Finding("patch.pending") if self.found is None else None
        for button in (self.show_button, self.save_button):
            allow(button, waiting)
        fits = self.found is not None and not self.found.trim
        allow(self.trim_button, Finding("patch.plane-fits") if fits else waiting)

    # --- what it can do ----------------------------------------------------------------------
    def show_on_model(self) -> None:
        """Colour the patch on the model by its deviations."""
        found, opened = self.found, self._studio.models.get(self._patch.model_id)
        if found is None or opened is None:
            return
        data = opened.data
        count = len(data.vertices) if isinstance(data, Mesh) else len(data.points)
        values = np.full(count, np.nan, np.float32)
        values[_points_of(data, self._patch)] = found.at_points
        reach = float(np.percentile(np.abs(found.at_points), 98.0))
        if opened.give_fields({FIELDS[0]: values}):
            style = FieldStyle(FIELDS[0], -reach, reach)
            self._studio.display.show_field(self._patch.model_id, style)
        else:
            self._studio.warn(Finding("model.fields-too-large"))

    def trim(self) -> None:
        """Leave out of the patch what departs from its plane; an edit that can be taken back."""
        found, opened = self.found, self._studio.models.get(self._patch.model_id)
        patch = get(self._studio.records, self._patch.id, Patch)
        if found is None or opened is None or patch is None:
            return
        ids = runs_to_ids(self._patch.runs)
        holds = found.holds
        if isinstance(opened.data, Mesh):
            corners = opened.data.faces[ids]
            place = np.searchsorted(np.unique(corners), corners)
            holds = np.asarray(found.holds[place].all(axis=1))
        figures = record_figures(opened.surface, ids[holds])
        if self._studio.attempt(edits.change_feature, replace(patch, **figures), "Trim"):
            self.accept()

    def _ask_for_file(self) -> None:
        formats = {"tif": "GeoTIFF", "ply": "PLY", "csv": "CSV"}
        name = f"{self._patch.name}_deviations.tif"
        path = ask_for_target(self, self._studio, tr("Save the map of deviations"), name, formats)
        if path is not None:
            self.save_to(path)

    def save_to(self, path: Path) -> None:
        """Write the deviations, in World."""
        model = self._studio.records.get(self._patch.model_id)
        if self.found is None or self._part is None or not isinstance(model, Model):
            return
        frame = model.frame
        crs = None if frame.crs is None else world_crs(frame.crs, frame.unit_m)
        try:
            write_deviations(path, self.found, self._part, crs=crs, force=True, axes=frame.axes)
        except VomError as error:
            self._studio.warn(error, "error")
            return
        self._studio.info(Finding("export.written", file=path))


def _points_of(data: Mesh | PointCloud, patch: Painted) -> np.ndarray:
    """Rows of the model's points that the patch has, in ascending order."""
    ids = runs_to_ids(patch.runs)
    return np.unique(data.faces[ids]) if isinstance(data, Mesh) else ids


def _look(
    data: Mesh | PointCloud, model: Model, patch: Painted, ratio: float, options: SurfaceOptions
) -> tuple[Mesh | PointCloud, SurfaceFigures, QImage]:
    """Return the patch alone in World, its figures and their picture. Runs in a worker thread."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    ids = runs_to_ids(patch.runs)
    part = extract_faces(data, ids) if isinstance(data, Mesh) else data.of_rows(ids)
    part = transform_model(part, model.to_world)
    found = analyse(part, noise_m=options.noise_m, model=model.name)
    dpi = 100.0 * ratio
    figure = Figure(figsize=(_SIZE[0] / 100.0, _SIZE[1] / 100.0), dpi=dpi)
    canvas = FigureCanvasAgg(figure)
    draw_surface(figure, found, metric=model.frame.has_metres)
    canvas.draw()
    pixels = np.asarray(canvas.buffer_rgba())
    height, width = pixels.shape[:2]
    image = QImage(pixels.data, width, height, 4 * width, QImage.Format.Format_RGBA8888).copy()
    image.setDevicePixelRatio(ratio)
    return part, found, image
