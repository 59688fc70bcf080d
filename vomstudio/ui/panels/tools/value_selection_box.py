"""The box that chooses faces and points by a field or by their colour."""

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
from vomstudio.ui.base.controls import ComboBox, DoubleSpinBox, Label, allow
from vomstudio.ui.base.studio import Studio

_COLOUR = ""
_FIRST_TOLERANCE = 10.0
_MOST = 1e9
_NARROW = 76


class ByValue(QWidget):
    """A field with a range, or the colour of what is chosen with a tolerance."""

    def __init__(self, studio: Studio) -> None:
        super().__init__()
        self._studio = studio
        self._tool = studio.tool_of(SelectTool)
        self._of: object = None
        self.what = ComboBox()
        self.what.setObjectName("by_value_of")
        self.what.setMinimumWidth(_NARROW)
        self.what.currentIndexChanged.connect(self._show_range)
        self.low, self.high = DoubleSpinBox(), DoubleSpinBox()
        self.low.setObjectName("by_value_low")
        self.high.setObjectName("by_value_high")
        for box in (self.low, self.high):
            box.setRange(-_MOST, _MOST)
            box.setDecimals(3)
            # Or the dock would have room for a thousand million.
            box.setMinimumWidth(_NARROW)
            box.setStepType(QDoubleSpinBox.StepType.AdaptiveDecimalStepType)
        self._to = Label(tr("to"))
        self.take = QPushButton(tr("Choose"))
        self.take.setObjectName("by_value_take")
        self.take.setToolTip(tr("What has such a value, as New, Add, Subtract and Intersect say."))
        self.take.clicked.connect(self._take)
        first, second = QHBoxLayout(), QHBoxLayout()
        first.addWidget(self.what, 1)
        first.addWidget(self.take)
        second.addWidget(self.low, 1)
        second.addWidget(self._to)
        second.addWidget(self.high, 1)
        column = QVBoxLayout(self)
        column.setContentsMargins(0, 0, 0, 0)
        column.setSpacing(3)
        column.addLayout(first)
        column.addLayout(second)

    def refresh(self) -> None:
        """The fields of the model that is meant now."""
        from vomstudio.extraction.selection.field_values import selectable_fields

        changes = self._tool.changes
        data = changes.data()
        lacks_color = not self.what.currentData() and not self._tool.count
        allow(self.take, Finding("action.no-elements") if data is None or lacks_color else None)
        names = () if data is None else selectable_fields(data)
        if (data, names) == self._of:
            return
        self._of = (data, names)
        with QSignalBlocker(self.what):
            self.what.clear()
            self.what.addItem(tr("Colour as chosen"), _COLOUR)
            for name in names:
                self.what.addItem(name, name)
        self._show_range()

    def _show_range(self) -> None:
        from vomstudio.extraction.selection.field_values import field_range

        name = self.what.currentData() or _COLOUR
        self._to.setVisible(name != _COLOUR)
        self.high.setVisible(name != _COLOUR)
        if name == _COLOUR:
            self.low.setPrefix(tr("within "))
            self.low.setSuffix(" ΔE")
            self.low.setDecimals(1)
            self.low.setValue(_FIRST_TOLERANCE)
            self.low.setToolTip(
                tr("Difference in CIE L*a*b*, lightness by half: 2 is just seen, 30 another rock.")
            )
        else:
            self.low.setPrefix("")
            unit = name.rpartition("[")[2].removesuffix("]") if name.endswith("]") else ""
            for box in (self.low, self.high):
                box.setSuffix(unit if unit in ("", "°") else f" {unit}")
                box.setDecimals(3)
            self.low.setToolTip(tr("Where the first is above the second, what lies outside."))
            model_id, data = self._tool.changes.model_id(), self._tool.changes.data()
            model = get(self._studio.records, model_id, Model)
            if data is not None and model is not None:
                low, high = field_range(data, transform.matrix(model.to_world), name)
                self.low.setValue(low if math.isfinite(low) else 0.0)
                self.high.setValue(high if math.isfinite(high) else 0.0)
        self._studio.tool_changed()

    def _take(self) -> None:
        name = self.what.currentData()
        if not name:
            self._tool.changes.select_by_colour(self.low.value())
        else:
            self._tool.changes.select_by_field(name, self.low.value(), self.high.value())
