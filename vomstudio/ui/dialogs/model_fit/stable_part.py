"""Selection of the stable part of a model, which alone determines the fit."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QFileDialog, QHBoxLayout, QVBoxLayout, QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.studio.jobs.registration_tasks import HomologousPoint, StableArea
from vomstudio.ui.base.command_targets import start_folder
from vomstudio.ui.base.controls import ComboBox, DoubleSpinBox
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.widgets.other_model_box import OtherModelBox

_WHOLE_REFERENCE, _NEAR_POINTS, _CLIPPING_BOX, _POLYGONS, _NEAR_MODEL = range(5)


class StablePartBox(QWidget):
    """Selection of the stable part.

    `changed` is emitted when the selection changes, and `message` with texts about the progress.
    """

    changed = Signal()
    message = Signal(str)

    def __init__(self, studio: Studio, fitted_model_id: str) -> None:
        """Create the choices. `fitted_model_id` is the id of the fitted model."""
        super().__init__()
        self._studio = studio
        self._polygons: Path | None = None
        self.part_box = ComboBox()
        self.part_box.setObjectName("stable_part")
        for text, tooltip in (
            (tr("Whole reference"), tr("The whole rock face is stable.")),
            (tr("Near clicked points"), tr("Use only rock within this distance of a point.")),
            (tr("Inside clipping box"), tr("Use the clipping box of the outcrop (World).")),
            (
                tr("Inside polygons…"),
                tr("Use polygons of a layer, seen from above (GeoJSON, GeoPackage…)."),
            ),
            (tr("Near another model"), tr("Use rock within 3 point spacings of a model.")),
        ):
            self.part_box.addItem(text)
            self.part_box.setItemData(self.part_box.count() - 1, tooltip, 3)
        self.part_box.activated.connect(self._choose_part)
        self.distance_box = DoubleSpinBox()
        self.distance_box.setRange(0.01, 100_000.0)
        self.distance_box.setValue(5.0)
        self.distance_box.setSuffix(" m")
        self.distance_box.valueChanged.connect(lambda _: self.changed.emit())
        self.distance_box.hide()
        self.stable_model = OtherModelBox(studio, fitted_model_id)
        self.stable_model.models.setObjectName("stable_model")
        self.stable_model.model_changed.connect(lambda _: self.changed.emit())
        self.stable_model.status_changed.connect(self.message)
        self.stable_model.hide()
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        row = QHBoxLayout()
        row.addWidget(self.part_box, 1)
        row.addWidget(self.distance_box)
        layout.addLayout(row)
        layout.addWidget(self.stable_model)

    def _choose_part(self, row: int) -> None:
        if row == _POLYGONS:
            name, _ = QFileDialog.getOpenFileName(
                self,
                tr("Polygons around the stable part"),
                start_folder(self._studio),
                tr("Polygons (*.geojson *.json *.gpkg *.shp *.kml)"),
            )
            if name:
                self._polygons = Path(name)
                self.part_box.setItemText(row, tr("Inside {file}", file=self._polygons.name))
            elif self._polygons is None:
                self.part_box.setCurrentIndex(_WHOLE_REFERENCE)
        self.distance_box.setVisible(self.part_box.currentIndex() == _NEAR_POINTS)
        self.stable_model.setVisible(self.part_box.currentIndex() == _NEAR_MODEL)
        self.changed.emit()

    def disabled_reason(self, pairs: Sequence[HomologousPoint]) -> Finding | None:
        """Return why the selected part cannot be used, or None if it can."""
        index = self.part_box.currentIndex()
        if index == _NEAR_POINTS and not pairs:
            return Finding("stable.no-points")
        if index == _CLIPPING_BOX and self._studio.display.box is None:
            return Finding("stable.no-box")
        if index == _NEAR_MODEL and self.stable_model.current() is None:
            return Finding("stable.no-model")
        return None

    def selected_part(self, pairs: Sequence[HomologousPoint]) -> StableArea | None:
        """Return the selected part, or None for the whole reference or a missing selection."""
        index, box = self.part_box.currentIndex(), self._studio.display.box
        if index == _NEAR_POINTS:
            return StableArea(
                self.distance_box.value(), tuple(pair.reference_point for pair in pairs)
            )
        if index == _CLIPPING_BOX and box is not None:
            return StableArea(box=(box.low, box.high))
        mask = self.stable_model.current()
        if index == _NEAR_MODEL and mask is not None:
            return StableArea(model=mask.to_placed_model(self._studio.project.cache))
        return StableArea(polygons=self._polygons) if index == _POLYGONS else None

    def mask_file(self) -> Path | None:
        """Return the file that defines the selected part, or None if it is not in a file."""
        mask = self.stable_model.current()
        if self.part_box.currentIndex() == _NEAR_MODEL and mask is not None:
            return mask.path
        return self._polygons if self.part_box.currentIndex() == _POLYGONS else None

    def mask_problem(self) -> Finding | None:
        """Return a finding if the stable part is not in a file, as a command requires, or None."""
        if self.part_box.currentIndex() in (_NEAR_POINTS, _CLIPPING_BOX):
            return Finding("action.stable-part-without-file")
        return None

    def cancel_reading(self) -> None:
        """Stop reading a model; no model is reported afterwards."""
        self.stable_model.cancel_reading()
