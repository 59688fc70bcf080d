"""Dialog for the surface analysis of a patch: deviations, profiles and figures."""

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
from vomstudio.project.records import Model, PaintedFeature, get
from vomstudio.studio.tools.brush_stroke import patch_fields
from vomstudio.ui.base.command_targets import ask_for_target
from vomstudio.ui.base.controls import Label, set_enabled
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.qt_background import QtBackground
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.widgets.axis_titles import length_unit, project_axes
from vomstudio.ui.widgets.options_form import OptionFields

_PICTURE_SIZE_PX = (760, 520)


class SurfaceDialog(QDialog):
    """Dialog for the surface analysis of a patch. The computation runs in a thread."""

    def __init__(self, parent: QWidget, studio: Studio, patch: PaintedFeature) -> None:
        super().__init__(parent)
        set_help_topic(self, "conventions.md#surfaces")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(tr("Surface of patch {name}", name=patch.name))
        self._studio, self._patch = studio, patch
        self._patch_data: Mesh | PointCloud | None = None
        self.figures: SurfaceFigures | None = None
        self.picture = Label(tr("Analysing the patch…"))
        self.picture.setMinimumSize(*_PICTURE_SIZE_PX)
        self.picture.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.limits = OptionFields(SurfaceOptions, "surface")
        self.limits.show_unit(length_unit(project_axes(studio)))
        self.limits.changed.connect(self.start)
        form = QFormLayout()
        self.limits.add_rows(form)
        self.summary = Label()
        self.summary.setWordWrap(True)
        self.summary.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        role = QDialogButtonBox.ButtonRole.ActionRole
        self.show_button = buttons.addButton(tr("Show on model"), role)
        self.trim_button = buttons.addButton(tr("Trim patch"), role)
        self.save_button = buttons.addButton(tr("Save map…"), role)
        self.show_button.clicked.connect(self.show_on_model)
        self.trim_button.setToolTip(
            tr("Remove the part of the patch that deviates from its plane.")
        )
        self.trim_button.clicked.connect(self.trim)
        self.save_button.clicked.connect(self._ask_for_file)
        buttons.rejected.connect(self.reject)
        for button in buttons.buttons():
            # Enter in the noise field must not press a button.
            button.setAutoDefault(False)  # type: ignore[attr-defined]
        layout = QVBoxLayout(self)
        layout.addWidget(self.picture, 1)
        layout.addWidget(self.summary)
        layout.addLayout(form)
        layout.addWidget(buttons)
        self._refresh_buttons()
        self._analysed_options: SurfaceOptions | None = None
        self._background = QtBackground(self)
        self.start()

    def start(self) -> None:
        """Analyse the patch with the entered noise level."""
        options = self.limits.options()
        if options == self._analysed_options:
            return
        studio, patch = self._studio, self._patch
        model, open_model = studio.records.get(patch.model_id), studio.models.get(patch.model_id)
        if not isinstance(model, Model) or open_model is None:
            self.summary.setText(Finding("model.not-open").message)
            return
        self._analysed_options, self.figures = options, None
        self._refresh_buttons()
        pixel_ratio = self.devicePixelRatioF()
        self._background.run(
            partial(_analyse_patch, open_model.data, model, patch, pixel_ratio, options),
            self._show_result,
            self._handle_failure,
        )

    def _handle_failure(self, error: VomError) -> None:
        self.picture.setText(str(error))
        self._refresh_buttons()

    def _show_result(self, result: tuple[Mesh | PointCloud, SurfaceFigures, QImage]) -> None:
        self._patch_data, self.figures, image = result
        self.picture.setPixmap(QPixmap.fromImage(image))
        self.summary.setText(
            "\n".join(describe_figures(self.figures, is_metric=project_axes(self._studio).metric))
        )
        if self._analysed_options == SurfaceOptions():
            self.limits.show_automatic("noise_m", self.figures.noise_m)
        self._refresh_buttons()

    def _refresh_buttons(self) -> None:
        busy_finding = Finding("patch.pending") if self.figures is None else None
        for button in (self.show_button, self.save_button):
            set_enabled(button, busy_finding)
        is_planar = self.figures is not None and not self.figures.trim
        set_enabled(self.trim_button, Finding("patch.plane-fits") if is_planar else busy_finding)

    # --- actions -----------------------------------------------------------------------------
    def show_on_model(self) -> None:
        """Colour the patch on the model by its deviations."""
        figures, open_model = self.figures, self._studio.models.get(self._patch.model_id)
        if figures is None or open_model is None:
            return
        data = open_model.data
        count = len(data.vertices) if isinstance(data, Mesh) else len(data.points)
        values = np.full(count, np.nan, np.float32)
        values[_patch_points(data, self._patch)] = figures.point_deviations
        max_deviation_m = float(np.percentile(np.abs(figures.point_deviations), 98.0))
        if open_model.add_fields({FIELDS[0]: values}):
            style = FieldStyle(FIELDS[0], -max_deviation_m, max_deviation_m)
            self._studio.display.show_field(self._patch.model_id, style)
        else:
            self._studio.warn(Finding("model.fields-too-large"))

    def trim(self) -> None:
        """Remove the parts of the patch that deviate from its plane in one edit."""
        figures, open_model = self.figures, self._studio.models.get(self._patch.model_id)
        patch = get(self._studio.records, self._patch.id, Patch)
        if figures is None or open_model is None or patch is None:
            return
        ids = runs_to_ids(self._patch.runs)
        is_on_plane = figures.holds
        if isinstance(open_model.data, Mesh):
            corners = open_model.data.faces[ids]
            rows = np.searchsorted(np.unique(corners), corners)
            is_on_plane = np.asarray(figures.holds[rows].all(axis=1))
        patch_figures = patch_fields(open_model.surface, ids[is_on_plane])
        if self._studio.attempt(edits.change_feature, replace(patch, **patch_figures), "Trim"):
            self.accept()

    def _ask_for_file(self) -> None:
        formats = {"tif": "GeoTIFF", "ply": "PLY", "csv": "CSV"}
        name = f"{self._patch.name}_deviations.tif"
        path = ask_for_target(self, self._studio, tr("Save the map of deviations"), name, formats)
        if path is not None:
            self.save_deviations(path)

    def save_deviations(self, path: Path) -> None:
        """Write the deviations in World coordinates to a file."""
        model = self._studio.records.get(self._patch.model_id)
        if self.figures is None or self._patch_data is None or not isinstance(model, Model):
            return
        frame = model.frame
        crs = None if frame.crs is None else world_crs(frame.crs, frame.unit_m)
        try:
            write_deviations(
                path, self.figures, self._patch_data, crs=crs, force=True, axes=frame.axes
            )
        except VomError as error:
            self._studio.warn(error, "error")
            return
        self._studio.written(path)


def _patch_points(data: Mesh | PointCloud, patch: PaintedFeature) -> np.ndarray:
    """Return the indices of the model points in the patch, in ascending order."""
    ids = runs_to_ids(patch.runs)
    return np.unique(data.faces[ids]) if isinstance(data, Mesh) else ids


def _analyse_patch(
    data: Mesh | PointCloud,
    model: Model,
    patch: PaintedFeature,
    pixel_ratio: float,
    options: SurfaceOptions,
) -> tuple[Mesh | PointCloud, SurfaceFigures, QImage]:
    """Return a patch in the World frame, its figures and a picture. Runs in a thread."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    ids = runs_to_ids(patch.runs)
    patch_data = extract_faces(data, ids) if isinstance(data, Mesh) else data.select_rows(ids)
    patch_data = transform_model(patch_data, model.to_world)
    figures = analyse(patch_data, noise_m=options.noise_m, model=model.name)
    dpi = 100.0 * pixel_ratio
    figure = Figure(figsize=(_PICTURE_SIZE_PX[0] / 100.0, _PICTURE_SIZE_PX[1] / 100.0), dpi=dpi)
    canvas = FigureCanvasAgg(figure)
    draw_surface(figure, figures, is_metric=model.frame.has_metres)
    canvas.draw()
    pixels = np.asarray(canvas.buffer_rgba())
    height, width = pixels.shape[:2]
    image = QImage(pixels.data, width, height, 4 * width, QImage.Format.Format_RGBA8888).copy()
    image.setDevicePixelRatio(pixel_ratio)
    return patch_data, figures, image
