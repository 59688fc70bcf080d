"""The panel of the tool that chooses faces and points."""

from __future__ import annotations

from PySide6.QtCore import Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QGridLayout, QLabel, QSizePolicy, QToolButton, QWidget

from vomstudio.document.measurement_cache import Measurement
from vomstudio.tools.select import LIVE, SelectTool
from vomstudio.ui.common.explained import explain
from vomstudio.ui.common.fit_view import FitView
from vomstudio.ui.common.studio import Studio
from vomstudio.ui.common.type_box import TypeBox
from vomstudio.ui.common.widgets import narrow_form
from vomstudio.ui.interpret.tool_panels import select_commands
from vomstudio.ui.interpret.tool_panels.common import hint_label, narrow_column, set_field
from vomstudio.words import tr

_WAYS = ("select_grow", "select_rectangle", "select_lasso", "select_polygon")
_COMBINE = ("select_new", "select_add", "select_subtract", "select_intersect")


class SelectPanel(QWidget):
    """Shows what is chosen and its plane, and sets how it is chosen."""

    def __init__(self, studio: Studio, actions: dict[str, QAction]) -> None:
        super().__init__()
        explain(self, "window.md#select-on-the-surface")
        self._studio = studio
        self._tool = studio.tool_of(SelectTool)
        self._shown: Measurement | None = None
        self.type_box = TypeBox(studio)
        self.type_box.setObjectName("selected_type")
        self.type_box.currentIndexChanged.connect(self._next_changed)
        self.set_edit = set_field(self._next_changed)
        form = narrow_form()
        form.addRow(tr("Type"), self.type_box)
        form.addRow(tr("Set"), self.set_edit)
        self.count = QLabel()
        self.count.setObjectName("selected_count")
        self.fit_view = FitView()
        self._hint = hint_label()
        layout = narrow_column(self)
        layout.addLayout(_buttons(actions, _WAYS))
        layout.addLayout(_buttons(actions, (*_COMBINE, "select_through")))
        layout.addWidget(self.count)
        layout.addWidget(self.fit_view)
        layout.addWidget(self._hint)
        layout.addLayout(form)
        layout.addStretch(1)
        layout.addLayout(_buttons(actions, ("finish", "cancel")))
        studio.project_opened.connect(self.refresh)
        studio.edited.connect(self.refresh)
        studio.tool_changed_signal.connect(self.refresh)
        studio.settings_changed.connect(self.refresh)

    def _next_changed(self) -> None:
        self.set_edit.setModified(False)
        self._studio.set_next(str(self.type_box.currentData()), self.set_edit.text().strip())

    def refresh(self, *_: object) -> None:
        """Show the tool as it is now."""
        if self._studio.tool_name != self._tool.name:
            return
        tool, studio = self._tool, self._studio
        self.type_box.choose(studio.next_type_id)
        if not self.set_edit.isModified():
            self.set_edit.setText(studio.next_set)
        chosen = tool.chosen
        model = None if chosen is None else studio.records.get(chosen.model_id)
        self.count.setVisible(chosen is not None)
        if chosen is not None and model is not None:
            self.count.setText(
                tr("{count:,} of {all:,} of {model}", count=chosen.count, all=len(chosen.mask),
                   model=model.name)
            )  # fmt: skip
        measured = tool.measurement
        self.fit_view.show_measurement(
            measured, studio.settings.notation, local=not studio.north_known()
        )
        self.fit_view.setVisible(measured is not None)
        self._hint.setVisible(measured is None)
        self._hint.setText(
            tr("Draw around a piece of the outcrop, or click it. The right button orbits.")
            if chosen is None
            else tr("Of more than {most:,} the plane is shown once they are a patch.", most=LIVE)
        )


def _buttons(actions: dict[str, QAction], names: tuple[str, ...]) -> QGridLayout:
    """Two in a row, with their keys."""
    grid = QGridLayout()
    grid.setSpacing(3)
    for i, name in enumerate(names):
        button = QToolButton()
        button.setDefaultAction(actions[name])
        button.setToolButtonStyle(Qt.ToolButtonStyle.ToolButtonTextBesideIcon)
        button.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        grid.addWidget(button, i // 2, i % 2)
    return grid


PANEL = SelectPanel
COMMANDS = select_commands.commands
