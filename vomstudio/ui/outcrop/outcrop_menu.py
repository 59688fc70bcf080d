"""Context menu of the rock or feature under the cursor."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Protocol

from PySide6.QtCore import QEvent, QObject, QPoint, Qt
from PySide6.QtGui import QAction, QContextMenuEvent, QCursor, QGuiApplication
from PySide6.QtWidgets import QMenu

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project.records import Feature, get_feature
from vomstudio.rendering.qt.viewport import Viewport
from vomstudio.studio.tools.interaction_types import Button, Hit, Pointer, PointerEvent
from vomstudio.ui.base import theme
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.outcrop.outcrop_view import OutcropView

_FINISH_COMMANDS = ("finish", "undo_click", "cancel")
_VIEW_COMMANDS = ("home", "show_elements")
COORDINATE_DECIMALS = 3


class FeatureMenus(Protocol):
    """Factory of the menus of features, the same as in the tree and the table."""

    def fill_feature_menu(self, menu: QMenu, feature: Feature) -> None: ...


class OutcropMenu(QObject):
    """Menu that opens on a right click or with the menu key.

    While a feature is open, the menu contains the commands that finish it. Otherwise, it contains
    the commands of the feature at the cursor, and commands that begin a feature there.
    """

    def __init__(
        self,
        studio: Studio,
        viewport: Viewport,
        view: OutcropView,
        actions: Mapping[str, QAction],
        features: FeatureMenus,
    ) -> None:
        super().__init__(viewport)
        self._studio, self._viewport, self._view = studio, viewport, view
        self._actions, self._feature_menus = actions, features
        viewport.pointer.connect(self._open_menu)
        viewport.installEventFilter(self)
        view.set_edit_callback(self._edit_feature)

    def _edit_feature(self) -> None:
        if self._actions["edit_feature"].isEnabled():
            self._actions["edit_feature"].trigger()

    def eventFilter(self, watched: QObject, event: QEvent) -> bool:  # noqa: N802 - Qt's name
        """Open the menu at the cursor, or else at the centre, when the menu key is pressed."""
        keyboard_reason = QContextMenuEvent.Reason.Keyboard
        if not isinstance(event, QContextMenuEvent) or event.reason() != keyboard_reason:
            return False
        position, rect = self._viewport.mapFromGlobal(QCursor.pos()), self._viewport.rect()
        if not rect.contains(position):
            position = rect.center()
        hit = self._viewport.pick(position.x(), position.y())
        self._open_menu(
            PointerEvent(Pointer.CLICK, position.x(), position.y(), Button.RIGHT, hit=hit)
        )
        return True

    def _open_menu(self, event: PointerEvent) -> None:
        if event.kind is not Pointer.CLICK or event.button is not Button.RIGHT:
            return
        menu = self.create_menu(event)
        if not menu.isEmpty():
            menu.popup(self._viewport.mapToGlobal(QPoint(round(event.x), round(event.y))))

    def create_menu(self, event: PointerEvent) -> QMenu:
        """Create the menu for a position in the viewport."""
        menu = QMenu(self._viewport)
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        menu.setToolTipsVisible(True)
        is_open = self._studio.open_tool is not None
        feature_id = None if is_open else self._view.feature_at(event.x, event.y)
        feature = get_feature(self._studio.records, feature_id)
        if is_open:
            menu.addActions([self._actions[name] for name in _FINISH_COMMANDS])
        elif feature is not None:
            menu.addSection(feature.name.replace("&", "&&"))
            self._feature_menus.fill_feature_menu(menu, feature)
        if event.hit is not None:
            menu.addSeparator()
            rock_menu = menu if feature is None else menu.addMenu(tr("&Here"))
            if not is_open:
                self._add_tools(rock_menu, event)
            self._add_point_actions(rock_menu, event.hit)
        if feature is None:
            menu.addSeparator()
            menu.addActions(
                [a for name in _VIEW_COMMANDS if (a := self._actions[name]).isEnabled()]
            )
        return menu

    def _add_tools(self, menu: QMenu, event: PointerEvent) -> None:
        """Add the commands that begin a feature at this position."""
        for tool, text in (
            ("plane", tr("&Grow plane")),
            ("trace", tr("Start &trace")),
            ("line", tr("Start &line")),
            ("station", tr("Add &station")),
        ):
            icon = self._actions[tool].icon()
            menu.addAction(icon, text, partial(self._begin_feature, tool, event))
        menu.addSeparator()

    def _begin_feature(self, tool: str, event: PointerEvent) -> None:
        self._actions[f"{tool}_pick" if tool == "plane" else tool].trigger()
        if self._studio.tool_name == tool:
            click = replace(event, button=Button.LEFT, shift=False, ctrl=False, alt=False)
            self._studio.pointer(replace(click, handle=None))

    def _add_point_actions(self, menu: QMenu, hit: Hit) -> None:
        menu.addAction(
            theme.icon("rotate-orbit"),
            tr("Centre of &rotation"),
            lambda: self._viewport.moves.set_pivot(self._viewport.world_position(hit)),
        )
        menu.addAction(
            theme.icon("arrow-collapse-down"),
            tr("Look along &normal"),
            partial(self._look_along_normal, hit),
        )
        menu.addAction(
            theme.icon("content-copy"),
            tr("&Copy coordinates"),
            partial(self._copy_coordinates, hit),
        )

    def _look_along_normal(self, hit: Hit) -> None:
        if (problem := self._view.look_along_normal(hit)) is not None:
            self._studio.hint(problem)

    def _copy_coordinates(self, hit: Hit) -> None:
        """Copy the World coordinates in the form that a spreadsheet splits into columns."""
        position = self._viewport.world_position(hit)
        text = "\t".join(f"{value:.{COORDINATE_DECIMALS}f}" for value in position)
        QGuiApplication.clipboard().setText(text)
        self._studio.info(Finding("place.copied", place=text.replace("\t", ", ")))
