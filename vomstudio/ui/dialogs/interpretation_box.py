"""What of the interpretation is drawn on an orthophoto: traces, patches, symbols, and their key."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QCheckBox, QHBoxLayout, QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.products.ortho.interpretation import LEGEND, PARTS
from vomstudio.project.records import Feature
from vomstudio.ui.base.controls import allow
from vomstudio.ui.base.studio import Studio


class InterpretationBox(QWidget):
    """changed : another choice"""

    changed = Signal()

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        shown = {
            "traces": (tr("Traces"), tr("Everything that is a line, in the colour of its type.")),
            "patches": (tr("Patches"), tr("Outlines of patches, and areas of rock.")),
            "symbols": (
                tr("Symbols"),
                tr("Planes with their names and apparent dips, lines, stations and samples."),
            ),
            LEGEND: (tr("Legend"), tr("On the sheet: what the colours and symbols mean.")),
        }
        self.boxes: dict[str, QCheckBox] = {}
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        for part in PARTS:
            title, tip = shown[part]
            box = self.boxes[part] = QCheckBox(title)
            box.setObjectName(f"ortho_{part}")
            box.setToolTip(tip)
            box.setChecked(True)
            box.toggled.connect(lambda _: self._changed())
            row.addWidget(box)
        row.addStretch()
        self._features = any(isinstance(r, Feature) for r in studio.records.values())
        self._sheet = True
        self._refresh()

    @property
    def drawn(self) -> tuple[str, ...]:
        """The chosen parts of PARTS; none where nothing is drawn."""
        chosen = tuple(part for part in PARTS if self.boxes[part].isChecked())
        return chosen if self._features and set(chosen) - {LEGEND} else ()

    def show_sheet(self, written: bool) -> None:
        """Only a sheet has a legend."""
        self._sheet = written
        self._refresh()

    def _changed(self) -> None:
        self._refresh()
        self.changed.emit()

    def _refresh(self) -> None:
        for part, box in self.boxes.items():
            why = None
            if not self._features:
                why = Finding("export.no-features")
            elif part == LEGEND and not self._sheet:
                why = Finding("action.no-sheet")
            elif part == LEGEND and not self.drawn:
                why = Finding("interpretation.legend-alone")
            allow(box, why)
