"""Page of the plane tool: mode, type and set of the next plane, and the live fit."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker
from PySide6.QtGui import QAction, QShowEvent
from PySide6.QtWidgets import QDoubleSpinBox, QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project.measurement_cache import Measurement
from vomstudio.studio.tools.growth import MAX_ANGLE_DEG, MAX_DISTANCE_M, MIN_ANGLE_DEG
from vomstudio.studio.tools.plane import MAX_RADIUS_M, MIN_RADIUS_M, PlaneTool
from vomstudio.ui.base.controls import (
    DoubleSpinBox,
    action_buttons,
    narrow_form,
    rich_label,
    rich_lines,
    set_enabled,
)
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools import plane_commands
from vomstudio.ui.panels.tools.common import (
    END_COMMANDS,
    create_set_field,
    hint_label,
    narrow_column,
)
from vomstudio.ui.widgets.fit_view import FitView
from vomstudio.ui.widgets.more_section import ModeBar, MoreSection
from vomstudio.ui.widgets.type_box import TypeBox

_MODES = ("shape_pick", "shape_lasso", "shape_polygon", "shape_rectangle")
_COMBINATION_COMMANDS = ("select_new", "select_add", "select_subtract", "select_intersect")
_CHANGE_COMMANDS = (
    "select_wider",
    "select_narrower",
    "select_through",
    "select_patch",
    "plane_to_selection",
    "edit_feature",
)


class PlanePanel(QWidget):
    """Page that shows the state of the plane tool and sets its mode, type and set."""

    def __init__(self, studio: Studio, actions: dict[str, QAction]) -> None:
        super().__init__()
        set_help_topic(self, "window.md#measure-a-plane")
        self._studio = studio
        self._tool = studio.get_tool(PlaneTool)
        self._measurement: Measurement | None = None
        self.type_box = TypeBox(studio, geometry="plane")
        self.type_box.setObjectName("plane_type")
        self.type_box.currentIndexChanged.connect(self._apply_fields)
        self.set_name_edit = create_set_field(self._apply_fields)
        form = narrow_form()
        form.addRow(tr("Type"), self.type_box)
        form.addRow(tr("Set"), self.set_name_edit)
        self._name = rich_label()
        self.fit_view = FitView(actions)
        self._hint = hint_label(
            tr("Click a surface, or paint it inside its edges. The right button orbits.")
        )
        layout = narrow_column(self)
        layout.addWidget(ModeBar([actions[name] for name in _MODES]))
        layout.addLayout(form)
        layout.addWidget(self._name)
        layout.addWidget(self.fit_view)
        layout.addLayout(action_buttons([actions[name] for name in END_COMMANDS]))
        layout.addWidget(self._hint)
        layout.addWidget(
            MoreSection(
                self._create_settings(),
                ModeBar([actions[name] for name in _COMBINATION_COMMANDS]),
                action_buttons([actions[name] for name in _CHANGE_COMMANDS]),
            )
        )
        layout.addStretch(1)
        # The box must be updated first, so it is connected first.
        studio.project_opened.connect(self.refresh)
        studio.edited.connect(self.refresh)
        studio.tool_changed_signal.connect(self.refresh)
        studio.settings_changed.connect(self.refresh)
        studio.next_type_changed.connect(self.refresh)
        # Live figures change during a stroke, all others at its end.
        studio.preview.connect(self._follow_preview)

    def _create_settings(self) -> QWidget:
        """Create the widgets for the brush and the tolerances of growth."""
        tool = self._tool
        self.radius, self.angle, self.distance = DoubleSpinBox(), DoubleSpinBox(), DoubleSpinBox()
        self.radius.setObjectName("brush_radius")
        self.radius.setDecimals(3)
        self.radius.setRange(MIN_RADIUS_M, MAX_RADIUS_M)
        self.radius.setToolTip(tr("Radius of the brush ([ and ] in the viewport)."))
        self.radius.valueChanged.connect(tool.set_radius)
        self.angle.setObjectName("grow_angle")
        self.angle.setRange(MIN_ANGLE_DEG, MAX_ANGLE_DEG)
        self.angle.setDecimals(0)
        self.angle.setSuffix("°")
        self.angle.setToolTip(tr("Maximum angle between surface and plane normals (Ctrl+wheel)."))
        self.angle.valueChanged.connect(lambda value: tool.set_tolerance(angle_deg=value))
        self.distance.setObjectName("grow_distance")
        self.distance.setRange(0.0, MAX_DISTANCE_M)
        self.distance.setDecimals(4)
        self.distance.setSpecialValueText(tr("automatic"))
        self.distance.setToolTip(tr("Maximum distance from the plane (Shift+wheel)."))
        self.distance.valueChanged.connect(lambda value: tool.set_tolerance(distance=value))
        for box in (self.radius, self.distance):
            box.setStepType(QDoubleSpinBox.StepType.AdaptiveDecimalStepType)
        page = QWidget()
        rows = narrow_form()
        page.setLayout(rows)
        for title, box in (
            (tr("Brush"), self.radius),
            (tr("Angle"), self.angle),
            (tr("Distance"), self.distance),
        ):
            box.setMinimumWidth(76)
            box.setKeyboardTracking(False)
            rows.addRow(title, box)
        return page

    def _apply_fields(self) -> None:
        self.set_name_edit.setModified(False)
        self._studio.set_next_type(
            str(self.type_box.currentData()), self.set_name_edit.text().strip()
        )

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 - Qt's name
        super().showEvent(event)
        # Activating the tool does not emit its change signal.
        self.refresh()

    def refresh(self, *_: object) -> None:
        """Show the current state of the tool."""
        tool, studio = self._tool, self._studio
        suffix = " m" if studio.are_metres_known() else tr(" units")
        for box, value in (
            (self.radius, tool.radius),
            (self.angle, tool.growth.angle_deg),
            (self.distance, tool.growth.distance or 0.0),
        ):
            with QSignalBlocker(box):
                box.setValue(value)
            box.setSuffix("°" if box is self.angle else suffix)
        plane = tool.continued_plane
        self.type_box.select_type(plane.type_id if plane else studio.next_type_id)
        if not self.set_name_edit.isModified():
            self.set_name_edit.setText(plane.set_name if plane else studio.next_set)
        for widget in (self.type_box, self.set_name_edit):
            set_enabled(widget, Finding("feature.continued") if tool.is_continued else None)
        self._name.setText(rich_lines([plane.name], [plane.name]) if plane else "")
        self._name.setVisible(plane is not None)
        self._show_fit()

    def _follow_preview(self, preview: object) -> None:
        if self._tool.is_painting and self._tool.measurement is not self._measurement:
            self._show_fit()

    def _show_fit(self) -> None:
        self._measurement = measurement = self._tool.measurement
        self.fit_view.show_measurement(
            measurement, self._studio.settings.notation, is_local=not self._studio.is_north_known()
        )
        self.fit_view.setVisible(measurement is not None)
        self._hint.setVisible(measurement is None)


PANEL = PlanePanel
COMMANDS = plane_commands.commands
