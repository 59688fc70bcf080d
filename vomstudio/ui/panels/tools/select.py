"""Panel of the selection tool for faces and points."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtGui import QAction, QKeySequence, QShowEvent
from PySide6.QtWidgets import (
    QDoubleSpinBox,
    QFormLayout,
    QGridLayout,
    QHBoxLayout,
    QSizePolicy,
    QToolButton,
    QWidget,
)

from vomstudio.core.words import tr
from vomstudio.project.measurement_cache import Measurement
from vomstudio.studio.tools.growth import MAX_ANGLE_DEG, MAX_DISTANCE_M, MIN_ANGLE_DEG
from vomstudio.studio.tools.select import SelectTool
from vomstudio.studio.tools.select_preview import MAX_LIVE_ELEMENTS
from vomstudio.ui.base import theme
from vomstudio.ui.base.actions import strip_mnemonic
from vomstudio.ui.base.controls import DoubleSpinBox, Label, narrow_form
from vomstudio.ui.base.help_links import explain
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools import select_commands
from vomstudio.ui.panels.tools.common import create_set_field, hint_label, narrow_column
from vomstudio.ui.panels.tools.value_selection_box import ValueSelectionBox
from vomstudio.ui.widgets.fit_view import FitView
from vomstudio.ui.widgets.type_box import TypeBox

_MODES = ("select_grow", "select_rectangle", "select_lasso", "select_polygon")
_SELECTION_CHANGES = (
    "select_wider",
    "select_narrower",
    "select_invert",
    "select_everything",
    "select_patch",
)
_VISIBILITY = ("hide_elements", "isolate_elements", "show_elements", "cut_out")
_SHARED = ("finish", "cancel")
"""Commands shared by the panels of all tools."""
_COMBINATIONS = ("select_new", "select_add", "select_subtract", "select_intersect")


class SelectPanel(QWidget):
    """Panel that shows the selection and its plane, and sets the selection mode."""

    def __init__(self, studio: Studio, actions: dict[str, QAction]) -> None:
        super().__init__()
        explain(self, "window.md#select-on-the-surface")
        self._studio = studio
        self._tool = studio.tool_of(SelectTool)
        self._measurement: Measurement | None = None
        self.type_box = TypeBox(studio)
        self.type_box.setObjectName("selected_type")
        self.type_box.currentIndexChanged.connect(self._apply_fields)
        self.set_edit = create_set_field(self._apply_fields)
        form = narrow_form()
        form.addRow(tr("Type"), self.type_box)
        form.addRow(tr("Set"), self.set_edit)
        self.count = Label()
        self.count.setObjectName("selected_count")
        self.fit_view = FitView(actions)
        self._hint = hint_label()
        layout = narrow_column(self)
        layout.addLayout(_buttons(actions, _MODES))
        self._tolerances = self._create_tolerances(studio)
        layout.addWidget(self._tolerances)
        layout.addLayout(_icons(actions, (*_COMBINATIONS, "select_through")))
        self.value_box = ValueSelectionBox(studio)
        layout.addWidget(self.value_box)
        layout.addLayout(_buttons(actions, _SELECTION_CHANGES))
        layout.addLayout(_buttons(actions, _VISIBILITY))
        layout.addWidget(self.count)
        layout.addLayout(form)
        layout.addLayout(_buttons(actions, _SHARED))
        layout.addWidget(self.fit_view)
        layout.addWidget(self._hint)
        layout.addStretch(1)
        studio.project_opened.connect(self.refresh)
        studio.edited.connect(self.refresh)
        studio.tool_changed_signal.connect(self.refresh)
        studio.settings_changed.connect(self.refresh)

    def _create_tolerances(self, studio: Studio) -> QWidget:
        """Create the widgets for the tolerances with which a selection grows from a click."""
        growth, tool = self._tool.growth, self._tool
        self.angle, self.distance = DoubleSpinBox(), DoubleSpinBox()
        self.angle.setObjectName("grow_angle")
        self.angle.setRange(MIN_ANGLE_DEG, MAX_ANGLE_DEG)
        self.angle.setDecimals(0)
        self.angle.setSuffix("°")
        self.angle.setValue(growth.angle_deg)
        self.angle.setToolTip(
            tr("By so much normals may be off the plane of the piece (Ctrl+wheel).")
        )
        self.angle.valueChanged.connect(lambda value: tool.set_tolerance(angle_deg=value))
        self.distance.setObjectName("grow_distance")
        self.distance.setRange(0.0, MAX_DISTANCE_M)
        self.distance.setDecimals(4)
        self.distance.setSpecialValueText(tr("by the model"))
        self.distance.setStepType(QDoubleSpinBox.StepType.AdaptiveDecimalStepType)
        self.distance.setToolTip(
            tr("By so much places may be off the plane of the piece (Shift+wheel).")
        )
        self.distance.valueChanged.connect(lambda value: tool.set_tolerance(distance=value))
        for box in (self.angle, self.distance):
            box.setMinimumWidth(76)
            box.setKeyboardTracking(False)
        page = QWidget()
        rows = QFormLayout(page)
        rows.setContentsMargins(0, 0, 0, 0)
        rows.addRow(tr("Angle"), self.angle)
        rows.addRow(tr("Distance"), self.distance)
        return page

    def _apply_fields(self) -> None:
        self.set_edit.setModified(False)
        self._studio.set_next(str(self.type_box.currentData()), self.set_edit.text().strip())

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 - Qt's name
        super().showEvent(event)
        # Activating the tool does not emit its change signal.
        self.refresh()

    def refresh(self, *_: object) -> None:
        """Show the current state of the tool."""
        if self._studio.tool_name != self._tool.name:
            return
        tool, studio = self._tool, self._studio
        self.type_box.select_type(studio.next_type_id)
        self._tolerances.setVisible(tool.mode == "grow")
        with QSignalBlocker(self.angle), QSignalBlocker(self.distance):
            self.angle.setValue(tool.growth.angle_deg)
            self.distance.setValue(tool.growth.distance or 0.0)
        self.distance.setSuffix(" m" if studio.metres_known() else tr(" units"))
        self.value_box.refresh()
        if not self.set_edit.isModified():
            self.set_edit.setText(studio.next_set)
        selection = tool.selection
        model = None if selection is None else studio.records.get(selection.model_id)
        self.count.setVisible(selection is not None)
        if selection is not None and model is not None:
            self.count.setText(
                tr(
                    "{count:,} of {all:,} of {model}",
                    count=selection.count,
                    all=len(selection.mask),
                    model=model.name,
                )
            )
        measurement = tool.measurement
        self.fit_view.show_measurement(
            measurement, studio.settings.notation, local=not studio.north_known()
        )
        self.fit_view.setVisible(measurement is not None)
        self._hint.setVisible(measurement is None)
        self._hint.setText(
            tr("Draw around a piece of the outcrop, or click it. The right button orbits.")
            if selection is None
            else tr(
                "Of more than {most:,} the plane is shown once they are a patch.",
                most=MAX_LIVE_ELEMENTS,
            )
        )


def _buttons(actions: dict[str, QAction], names: tuple[str, ...]) -> QGridLayout:
    """Lay out the buttons in two columns and show their shortcuts."""
    grid = QGridLayout()
    grid.setSpacing(3)
    for i, name in enumerate(names):
        button = QToolButton()
        button.setDefaultAction(actions[name])
        theme.highlight_toggles(button)
        keys = actions[name].shortcuts()
        if keys and name not in _SHARED:
            shortcut = keys[0].toString(QKeySequence.SequenceFormat.NativeText)
            text = strip_mnemonic(actions[name].text()).partition(" ")[0]
            actions[name].setIconText(f"{text} ({shortcut})")
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        grid.addWidget(button, i // 2, i % 2)
    return grid


def _icons(actions: dict[str, QAction], names: tuple[str, ...]) -> QHBoxLayout:
    """Lay out icon buttons in one row, with their names in the tooltips."""
    row = QHBoxLayout()
    row.setSpacing(3)
    for name in names:
        button = QToolButton()
        button.setDefaultAction(actions[name])
        theme.highlight_toggles(button)
        button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        row.addWidget(button)
    return row


PANEL = SelectPanel
COMMANDS = select_commands.commands
