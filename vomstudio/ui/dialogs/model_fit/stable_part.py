"""The choice of what has stayed where it was, by which alone one model is fitted to another."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QFileDialog, QHBoxLayout, QVBoxLayout, QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.studio.jobs.registration_tasks import HomologousPoint, StablePart
from vomstudio.ui.base.command_targets import start_folder
from vomstudio.ui.base.controls import ComboBox, DoubleSpinBox
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.widgets.other_model_box import OtherModelBox

_ALL, _NEAR, _BOX, _POLYGONS, _MODEL = range(5)


class StablePartBox(QWidget):
    """changed : another part was chosen; said : what is being done"""

    changed = Signal()
    said = Signal(str)

    def __init__(self, studio: Studio, besides: str) -> None:
        """besides : the id of the model that is fitted"""
        super().__init__()
        self._studio = studio
        self._polygons: Path | None = None
        self.which = ComboBox()
        self.which.setObjectName("stable_part")
        for text, tip in (
            (tr("All of it"), tr("Nothing has moved or fallen since.")),
            (tr("Near the clicked points"), tr("Only what is within this distance of a point.")),
            (tr("Inside the clipping box"), tr("The box of the outcrop's view (World).")),
            (tr("Inside polygons…"), tr("Of a layer, seen from above (GeoJSON, GeoPackage…).")),
            (tr("Near a cloud or mesh"), tr("Within 3 of its spacings, in the same frame.")),
        ):
            self.which.addItem(text)
            self.which.setItemData(self.which.count() - 1, tip, 3)
        self.which.activated.connect(self._chosen)
        self.metres = DoubleSpinBox()
        self.metres.setRange(0.01, 100_000.0)
        self.metres.setValue(5.0)
        self.metres.setSuffix(" m")
        self.metres.valueChanged.connect(lambda _: self.changed.emit())
        self.metres.hide()
        self.stable_model = OtherModelBox(studio, besides)
        self.stable_model.models.setObjectName("stable_model")
        self.stable_model.model_changed.connect(lambda _: self.changed.emit())
        self.stable_model.status_changed.connect(self.said)
        self.stable_model.hide()
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        row = QHBoxLayout()
        row.addWidget(self.which, 1)
        row.addWidget(self.metres)
        column.addLayout(row)
        column.addWidget(self.stable_model)

    def _chosen(self, row: int) -> None:
        if row == _POLYGONS:
            name, _ = QFileDialog.getOpenFileName(
                self,
                tr("Polygons around what has not moved"),
                start_folder(self._studio),
                tr("Polygons (*.geojson *.json *.gpkg *.shp *.kml)"),
            )
            if name:
                self._polygons = Path(name)
                self.which.setItemText(row, tr("Inside {file}", file=self._polygons.name))
            elif self._polygons is None:
                self.which.setCurrentIndex(_ALL)
        self.metres.setVisible(self.which.currentIndex() == _NEAR)
        self.stable_model.setVisible(self.which.currentIndex() == _MODEL)
        self.changed.emit()

    def why_not(self, pairs: Sequence[HomologousPoint]) -> Finding | None:
        """Why the part that was chosen is none; None where it is one."""
        which = self.which.currentIndex()
        if which == _NEAR and not pairs:
            return Finding("stable.no-points")
        if which == _BOX and self._studio.display.box is None:
            return Finding("stable.no-box")
        if which == _MODEL and self.stable_model.current() is None:
            return Finding("stable.no-model")
        return None

    def part(self, pairs: Sequence[HomologousPoint]) -> StablePart | None:
        """What was chosen; None for all of the reference."""
        which, box = self.which.currentIndex(), self._studio.display.box
        if which == _NEAR:
            return StablePart(self.metres.value(), tuple(pair.there for pair in pairs))
        if which == _BOX and box is not None:
            return StablePart(box=(box.low, box.high))
        mask = self.stable_model.current()
        if which == _MODEL and mask is not None:
            return StablePart(model=mask.to_placed_model(self._studio.project.cache))
        return StablePart(polygons=self._polygons) if which == _POLYGONS else None

    def mask_file(self) -> Path | None:
        """The file of what was chosen; None for all of the reference."""
        mask = self.stable_model.current()
        if self.which.currentIndex() == _MODEL and mask is not None:
            return mask.path
        return self._polygons if self.which.currentIndex() == _POLYGONS else None

    def why_no_mask(self) -> Finding | None:
        """Return that the stable part is not in a file for a command; None if it is."""
        if self.which.currentIndex() in (_NEAR, _BOX):
            return Finding("action.stable-part-without-file")
        return None

    def close_reading(self) -> None:
        """Nothing is handed over any more."""
        self.stable_model.close_reading()
