"""Panel of the patch tool: brush, type and set of the next patch, and the live fit."""

from __future__ import annotations

from PySide6.QtCore import QSignalBlocker, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import (
    QDoubleSpinBox,
    QGridLayout,
    QHBoxLayout,
    QSizePolicy,
    QToolButton,
    QWidget,
)

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project.measurement_cache import Measurement
from vomstudio.studio.tools.patch import MAX_RADIUS_M, MIN_RADIUS_M, PatchTool
from vomstudio.ui.base.controls import DoubleSpinBox, allow, narrow_form, rich_label, rich_lines
from vomstudio.ui.base.help_links import explain
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools import patch_commands
from vomstudio.ui.panels.tools.common import (
    create_set_field,
    hint_label,
    narrow_column,
)
from vomstudio.ui.widgets.fit_view import FitView
from vomstudio.ui.widgets.type_box import TypeBox


class PatchPanel(QWidget):
    """Panel that shows the state of the patch tool and sets the brush, type and set."""

    def __init__(self, studio: Studio, actions: dict[str, QAction]) -> None:
        super().__init__()
        explain(self, "window.md#paint-a-patch")
        self._studio = studio
        self._tool = studio.tool_of(PatchTool)
        self._measurement: Measurement | None = None
        self.radius = DoubleSpinBox()
        self.radius.setObjectName("brush_radius")
        self.radius.setDecimals(3)
        self.radius.setRange(MIN_RADIUS_M, MAX_RADIUS_M)
        self.radius.setStepType(QDoubleSpinBox.StepType.AdaptiveDecimalStepType)
        self.radius.setKeyboardTracking(False)
        self.radius.setToolTip(tr("Radius of the brush ([ and ] in the viewport)."))
        self.radius.valueChanged.connect(self._tool.set_radius)
        brush = QHBoxLayout()
        brush.addWidget(self.radius, 1)
        brush.addWidget(_button(actions["brush_removes"], tr("Erase")))
        self.type_box = TypeBox(studio)
        self.type_box.setObjectName("patch_type")
        self.type_box.currentIndexChanged.connect(self._apply_fields)
        self.set_edit = create_set_field(self._apply_fields)
        form = narrow_form()
        form.addRow(tr("Brush"), brush)
        form.addRow(tr("Type"), self.type_box)
        form.addRow(tr("Set"), self.set_edit)

        self._name = rich_label()
        self.fit_view = FitView(actions)
        self._hint = hint_label(
            tr(
                "Paint over one surface of the outcrop, away from its edges. Ctrl erases; the "
                "right button orbits."
            )
        )
        buttons = QGridLayout()
        buttons.setSpacing(4)
        for i, name in enumerate(("finish", "cancel", "continue_patch")):
            text = tr("Continue") if name == "continue_patch" else ""
            button = _button(actions[name], text)
            button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
            buttons.addWidget(button, i // 2, i % 2)
        layout = narrow_column(self)
        layout.addLayout(form)
        layout.addWidget(self._name)
        layout.addWidget(self.fit_view)
        layout.addWidget(self._hint)
        layout.addStretch(1)
        layout.addLayout(buttons)
        # The box must be updated first, so it is connected first.
        studio.project_opened.connect(self.refresh)
        studio.edited.connect(self.refresh)
        studio.tool_changed_signal.connect(self.refresh)
        studio.settings_changed.connect(self.refresh)
        # Live figures change during a stroke, all others at its end.
        studio.preview.connect(self._follow_preview)

    def _apply_fields(self) -> None:
        self.set_edit.setModified(False)
        self._studio.set_next(str(self.type_box.currentData()), self.set_edit.text().strip())

    def refresh(self, *_: object) -> None:
        """Show the current state of the tool."""
        tool, studio = self._tool, self._studio
        patch = tool.current
        with QSignalBlocker(self.radius):
            self.radius.setValue(tool.radius)
        self.type_box.select_type(patch.type_id if patch else studio.next_type_id)
        if not self.set_edit.isModified():
            self.set_edit.setText(patch.set_name if patch else studio.next_set)
        for widget in (self.type_box, self.set_edit):
            allow(widget, Finding("feature.continued") if tool.continued else None)
        self._name.setText(rich_lines([patch.name], [patch.name]) if patch else "")
        self._name.setVisible(patch is not None)
        self._show_fit()

    def _follow_preview(self, preview: object) -> None:
        if self._tool.open and self._tool.measurement is not self._measurement:
            self._show_fit()

    def _show_fit(self) -> None:
        self.radius.setSuffix(" m" if self._studio.metres_known() else tr(" units"))
        self._measurement = measurement = self._tool.measurement
        self.fit_view.show_measurement(
            measurement, self._studio.settings.notation, local=not self._studio.north_known()
        )
        self.fit_view.setVisible(measurement is not None)
        self._hint.setVisible(measurement is None)


def _button(action: QAction, text: str) -> QToolButton:
    button = QToolButton()
    if text:
        action.setIconText(text)
    button.setDefaultAction(action)
    button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
    return button


PANEL = PatchPanel
COMMANDS = patch_commands.commands
