"""Box that selects faces and points by field value or colour."""

from __future__ import annotations

import math

from PySide6.QtCore import QSignalBlocker
from PySide6.QtWidgets import (
    QDoubleSpinBox,
    QHBoxLayout,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.geometry import transform
from vomstudio.project.records import Model, get
from vomstudio.studio.tools.select import SelectTool
from vomstudio.ui.base.controls import ComboBox, DoubleSpinBox, Label, set_enabled
from vomstudio.ui.base.studio import Studio

_COLOR_KEY = ""
DEFAULT_TOLERANCE = 10.0
MAX_VALUE = 1e9
_MIN_WIDTH_PX = 76


class ValueSelectionBox(QWidget):
    """Box that selects by the range of a field, or by similarity to the selected colour."""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self._tool = studio.get_tool(SelectTool)
        self._field_source: object = None
        self.field_box = ComboBox()
        self.field_box.setObjectName("by_value_of")
        self.field_box.setMinimumWidth(_MIN_WIDTH_PX)
        self.field_box.currentIndexChanged.connect(self._show_range)
        self.low, self.high = DoubleSpinBox(), DoubleSpinBox()
        self.low.setObjectName("by_value_low")
        self.high.setObjectName("by_value_high")
        for box in (self.low, self.high):
            box.setRange(-MAX_VALUE, MAX_VALUE)
            box.setDecimals(3)
            # The size hint would fit the largest value and widen the dock.
            box.setMinimumWidth(_MIN_WIDTH_PX)
            box.setStepType(QDoubleSpinBox.StepType.AdaptiveDecimalStepType)
        self._to_label = Label(tr("to"))
        self.take_button = QPushButton(tr("Select"))
        self.take_button.setObjectName("by_value_take")
        self.take_button.setToolTip(tr("Select elements within this range, using the active mode."))
        self.take_button.clicked.connect(self._select)
        first_row, second_row = QHBoxLayout(), QHBoxLayout()
        first_row.addWidget(self.field_box, 1)
        first_row.addWidget(self.take_button)
        second_row.addWidget(self.low, 1)
        second_row.addWidget(self._to_label)
        second_row.addWidget(self.high, 1)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(3)
        column.addLayout(first_row)
        column.addLayout(second_row)

    def refresh(self) -> None:
        """List the fields of the current model."""
        from vomstudio.extraction.selection.field_values import selectable_fields

        changes = self._tool.changes
        data = changes.data()
        has_no_color = not self.field_box.currentData() and not self._tool.count
        set_enabled(
            self.take_button,
            Finding("action.no-elements") if data is None or has_no_color else None,
        )
        names = () if data is None else selectable_fields(data)
        if (data, names) == self._field_source:
            return
        self._field_source = (data, names)
        with QSignalBlocker(self.field_box):
            self.field_box.clear()
            self.field_box.addItem(tr("Similar colour"), _COLOR_KEY)
            for name in names:
                self.field_box.addItem(name, name)
        self._show_range()

    def _show_range(self) -> None:
        from vomstudio.extraction.selection.field_values import field_range

        name = self.field_box.currentData() or _COLOR_KEY
        self._to_label.setVisible(name != _COLOR_KEY)
        self.high.setVisible(name != _COLOR_KEY)
        if name == _COLOR_KEY:
            self.low.setPrefix(tr("within "))
            self.low.setSuffix(" ΔE")
            self.low.setDecimals(1)
            self.low.setValue(DEFAULT_TOLERANCE)
            self.low.setToolTip(
                tr("Colour tolerance (ΔE): 2 is barely visible, 30 clearly different.")
            )
        else:
            self.low.setPrefix("")
            unit = name.rpartition("[")[2].removesuffix("]") if name.endswith("]") else ""
            for box in (self.low, self.high):
                box.setSuffix(unit if unit in ("", "°") else f" {unit}")
                box.setDecimals(3)
            self.low.setToolTip(tr("If the first value is larger, values outside are selected."))
            model_id, data = self._tool.changes.model_id(), self._tool.changes.data()
            model = get(self._studio.records, model_id, Model)
            if data is not None and model is not None:
                low, high = field_range(data, transform.matrix(model.to_world), name)
                self.low.setValue(low if math.isfinite(low) else 0.0)
                self.high.setValue(high if math.isfinite(high) else 0.0)
        self._studio.tool_changed()

    def _select(self) -> None:
        name = self.field_box.currentData()
        if not name:
            self._tool.changes.select_by_colour(self.low.value())
        else:
            self._tool.changes.select_by_field(name, self.low.value(), self.high.value())
