"""Checkboxes for the interpretation that is drawn on an orthophoto."""

from __future__ import annotations

from PySide6.QtCore import Signal
from PySide6.QtWidgets import QCheckBox, QHBoxLayout, QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.products.ortho.interpretation import LEGEND, PARTS
from vomstudio.project.records import Feature
from vomstudio.ui.base.controls import set_enabled
from vomstudio.ui.base.studio import Studio


class InterpretationBox(QWidget):
    """Checkboxes that select the parts of the interpretation.

    `changed` is emitted when a checkbox is toggled.
    """

    changed = Signal()

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        labels = {
            "traces": (tr("Traces"), tr("Draw lines in the colour of their type.")),
            "patches": (tr("Patches"), tr("Draw outlines of patches and rock areas.")),
            "symbols": (
                tr("Symbols"),
                tr("Draw lines, stations, samples, and planes with their apparent dips."),
            ),
            LEGEND: (tr("Legend"), tr("Add a legend to the sheet.")),
        }
        self.boxes: dict[str, QCheckBox] = {}
        row = QHBoxLayout(self)
        row.setContentsMargins(0, 0, 0, 0)
        for part in PARTS:
            title, tooltip = labels[part]
            box = self.boxes[part] = QCheckBox(title)
            box.setObjectName(f"ortho_{part}")
            box.setToolTip(tooltip)
            box.setChecked(True)
            box.toggled.connect(lambda _: self._handle_change())
            row.addWidget(box)
        row.addStretch()
        self._has_features = any(isinstance(r, Feature) for r in studio.records.values())
        self._has_sheet = True
        self._refresh()

    @property
    def selected_parts(self) -> tuple[str, ...]:
        """Selected parts, a subset of PARTS; empty if nothing is to be drawn."""
        parts = tuple(part for part in PARTS if self.boxes[part].isChecked())
        return parts if self._has_features and set(parts) - {LEGEND} else ()

    def enable_legend(self, has_sheet: bool) -> None:
        """Enable the option for the legend, which is only available on a sheet."""
        self._has_sheet = has_sheet
        self._refresh()

    def _handle_change(self) -> None:
        self._refresh()
        self.changed.emit()

    def _refresh(self) -> None:
        for part, box in self.boxes.items():
            reason = None
            if not self._has_features:
                reason = Finding("export.no-features")
            elif part == LEGEND and not self._has_sheet:
                reason = Finding("action.no-sheet")
            elif part == LEGEND and not self.selected_parts:
                reason = Finding("interpretation.legend-alone")
            set_enabled(box, reason)
