"""The strip of workspaces, and a bar of tools that drops texts where there is no room for them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from PySide6.QtCore import QSize, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QToolBar, QToolButton, QWidget

from vomstudio.core.words import tr
from vomstudio.ui.base import theme
from vomstudio.ui.base.actions import Command
from vomstudio.ui.shell.workspace_table import WORKSPACES
from vomstudio.ui.shell.workspaces import Workspaces
from vomstudio.ui.widgets.collapsing_texts import CollapsingTexts

_ARROW = 16
_TEXT = Qt.ToolButtonStyle.ToolButtonTextOnly


def commands(workspaces: Workspaces) -> list[Command]:
    """One command for each workspace, and that which arranges its panels anew."""

    def show(name: str) -> Command:
        workspace = next(each for each in WORKSPACES if each.name == name)
        number = WORKSPACES.index(workspace) + 1
        return Command(
            f"workspace_{name}",
            tr("Workspace {number}: {name}", number=f"&{number}", name=tr(workspace.title)),
            lambda: workspaces.switch(name),
            workspace.icon,
            f"Ctrl+{number}",
            tr(workspace.purpose),
            is_checked=lambda: workspaces.shown is workspace,
        )

    return [
        *(show(workspace.name) for workspace in WORKSPACES),
        Command(
            "reset_panels",
            tr("&Reset panels"),
            workspaces.reset,
            "view-dashboard-outline",
            (),
            tr("Arrange the panels of this workspace as they are at first."),
        ),
    ]


def command_names() -> list[str]:
    """The names of the commands that show workspaces, in their order."""
    return [f"workspace_{workspace.name}" for workspace in WORKSPACES]


class FittingBar(QToolBar):
    """A toolbar that shows as many texts as it has room for, the first to go first."""

    def __init__(self, title: str, name: str) -> None:
        super().__init__(title)
        self.setObjectName(name)
        self.setMovable(False)
        self.toggleViewAction().setVisible(False)
        self.setIconSize(QSize(18, 18))
        theme.highlight_toggles(self)
        self._texts = CollapsingTexts(self, self._needed)
        self.drop_texts = self._texts.add_group

    def _needed(self) -> int:
        layout = self.layout()
        assert layout is not None
        layout.invalidate()
        # Qt keeps some of it for the arrow at the end.
        return layout.sizeHint().width() + _ARROW

    def minimumSizeHint(self) -> QSize:  # noqa: N802
        # It must not hold the window wide: what does not fit is behind the arrow at its end.
        return QSize(200, super().minimumSizeHint().height())


def buttons_of(bar: QToolBar, actions: Iterable[QAction]) -> list[QToolButton]:
    """The buttons of a toolbar for these actions."""
    widgets: Sequence[QWidget] = [bar.widgetForAction(action) for action in actions]
    return [widget for widget in widgets if isinstance(widget, QToolButton)]


def make_strip(actions: Mapping[str, QAction]) -> QToolBar:
    """The strip of workspaces: one button for each, that of the one that is shown pressed."""
    bar = FittingBar(tr("Workspaces"), "workspaces")
    own = [actions[name] for name in command_names()]
    for workspace, action in zip(WORKSPACES, own, strict=True):
        # The strip says by itself what the names are.
        action.setIconText(tr(workspace.title))
        bar.addAction(action)
    bar.drop_texts(buttons_of(bar, own), _TEXT)
    return bar
