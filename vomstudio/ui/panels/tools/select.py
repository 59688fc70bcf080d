"""Page of the selection tool."""

from __future__ import annotations

from PySide6.QtGui import QAction, QShowEvent
from PySide6.QtWidgets import QWidget

from vomstudio.core.words import tr
from vomstudio.studio.tools.select import SelectTool
from vomstudio.ui.base.controls import Label, action_buttons
from vomstudio.ui.base.help_links import set_help_topic
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.tools import select_commands
from vomstudio.ui.panels.tools.common import hint_label, narrow_column
from vomstudio.ui.panels.tools.value_selection_box import ValueSelectionBox
from vomstudio.ui.widgets.more_section import ModeBar, MoreSection

_TARGETS = ("select_features", "select_surface")
_SHAPES = ("shape_rectangle", "shape_lasso", "shape_polygon")
_COMBINATION_COMMANDS = ("select_new", "select_add", "select_subtract", "select_intersect")
_USE_COMMANDS = ("selection_to_plane", "hide_elements", "cancel")
_CHANGE_COMMANDS = (
    "select_through",
    "select_wider",
    "select_narrower",
    "select_invert",
    "select_everything",
    "select_patch",
    "isolate_elements",
    "show_elements",
    "cut_out",
)


class SelectPanel(QWidget):
    """Page with the target and mode of the selection, and the commands that use it."""

    def __init__(self, studio: Studio, actions: dict[str, QAction]) -> None:
        super().__init__()
        set_help_topic(self, "window.md#select")
        self._studio = studio
        self._tool = studio.get_tool(SelectTool)
        self.count = Label()
        self.count.setObjectName("selected_count")
        self._hint = hint_label()
        self.value_box = ValueSelectionBox(studio)
        layout = narrow_column(self)
        layout.addWidget(
            ModeBar([actions[name] for name in _TARGETS], [tr("Features"), tr("Surface")])
        )
        layout.addWidget(ModeBar([actions[name] for name in _SHAPES]))
        layout.addWidget(self.count)
        self._use_buttons = QWidget()
        uses = action_buttons([actions[name] for name in _USE_COMMANDS])
        uses.setContentsMargins(0, 0, 0, 0)
        self._use_buttons.setLayout(uses)
        layout.addWidget(self._use_buttons)
        layout.addWidget(self._hint)
        self.more_section = MoreSection(
            ModeBar([actions[name] for name in _COMBINATION_COMMANDS]),
            self.value_box,
            action_buttons([actions[name] for name in _CHANGE_COMMANDS]),
        )
        layout.addWidget(self.more_section)
        layout.addStretch(1)
        studio.project_opened.connect(self.refresh)
        studio.edited.connect(self.refresh)
        studio.tool_changed_signal.connect(self.refresh)
        studio.settings_changed.connect(self.refresh)
        studio.selection_changed.connect(self.refresh)

    def showEvent(self, event: QShowEvent) -> None:  # noqa: N802 - Qt's name
        super().showEvent(event)
        # Activating the tool does not emit its change signal.
        self.refresh()

    def refresh(self, *_: object) -> None:
        """Show the current state of the tool."""
        if self._studio.tool_name != self._tool.name:
            return
        tool, studio = self._tool, self._studio
        is_surface = tool.target == "surface"
        self._use_buttons.setVisible(is_surface)
        self.more_section.setVisible(is_surface)
        if is_surface:
            self.value_box.refresh()
        selection = tool.selection
        model = None if selection is None else studio.records.get(selection.model_id)
        if not is_surface:
            count = len(studio.selection.ids)
            self.count.setText(tr("{count:,} selected", count=count))
        elif selection is not None and model is not None:
            self.count.setText(
                tr(
                    "{count:,} of {all:,} of {model}",
                    count=selection.count,
                    all=len(selection.mask),
                    model=model.name,
                )
            )
        else:
            self.count.setText(tr("Nothing selected"))
        self._hint.setText(
            tr("Draw around a part of the surface. Shift adds, Alt removes.")
            if is_surface
            else tr("Click features or draw around them. Shift adds, Alt removes.")
        )


PANEL = SelectPanel
COMMANDS = select_commands.commands
