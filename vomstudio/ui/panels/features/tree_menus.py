"""Context menus of the project tree: of a record, a feature type or a group."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from PySide6.QtCore import QObject
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu, QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project import edits
from vomstudio.project.kinds import GROUPS, group_of
from vomstudio.project.records import FeatureType, Record, Typed
from vomstudio.ui.base import theme
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.features.symbol_names import SYMBOL_NAMES

GROUP_IDS = ("models", *(group.id for group in GROUPS))


class TreeMenus(QObject):
    """`actions` gives the actions for a record, `edit_type` opens the dialog of feature types at
    one of them ("" for the present one), `change_type` gives features another type."""

    def __init__(
        self,
        studio: Studio,
        parent: QWidget,
        actions: Callable[[Record], list[QAction]],
        edit_type: Callable[[str], object],
        change_type: Callable[[tuple[str, ...], str], None],
    ) -> None:
        super().__init__(parent)
        self._studio = studio
        self._parent = parent
        self._menu_actions = actions
        self._edit_type = edit_type
        self._change_type = change_type

    def menu_for(self, id_: str) -> QMenu:
        """The context menu of a record or group; of the tree where `id_` is empty."""
        menu = QMenu(self._parent)
        menu.setToolTipsVisible(True)
        record = self._studio.records.get(id_)
        if isinstance(record, FeatureType):
            self._fill_type_menu(menu, record)
        elif record is not None:
            menu.addActions(self._menu_actions(record))
            if isinstance(record, Typed):
                self._add_types(menu, record.type_id)
        elif id_ in GROUP_IDS:
            self._add_eye(menu, id_)
        else:
            menu.addAction(tr("Feature types…"), lambda: self._edit_type(""))
        return menu

    def _add_types(self, menu: QMenu, present: str) -> None:
        types = menu.addMenu(tr("Change &type to"))
        for kind in self._studio.session.of(FeatureType):
            action = types.addAction(theme.type_icon(kind.color, kind.symbol), kind.name)
            action.setCheckable(True)
            action.setChecked(kind.id == present)
            action.triggered.connect(
                lambda _=False, id_=kind.id: self._change_type(self._studio.selection.ids, id_)
            )

    def _add_eye(self, menu: QMenu, id_: str) -> None:
        visible = self._studio.visible(id_)
        menu.addAction(
            theme.icon("eye-off-outline" if visible else "eye-outline"),
            tr("Hide") if visible else tr("Show"),
            lambda: self._studio.set_visible([id_], not visible),
        )

    def _fill_type_menu(self, menu: QMenu, kind: FeatureType) -> None:
        studio = self._studio
        own = [f.id for f in studio.session.features() if group_of(f) == kind.id]
        chosen = menu.addAction(
            tr("Use for &next features"),
            lambda: studio.set_next(kind.id, studio.next_set),
        )
        chosen.setCheckable(True)
        chosen.setChecked(kind.id == studio.next_type_id)
        every = menu.addAction(tr("&Select its features"), lambda: studio.selection.set(own))
        none = tr("Not now: {reason}", reason=Finding("action.type-unused"))
        every.setEnabled(bool(own))
        every.setToolTip("" if own else none)
        menu.addSeparator()
        self._add_eye(menu, kind.id)
        only = menu.addAction(tr("Show &only these"), lambda: studio.show_only(own))
        only.setEnabled(bool(own))
        only.setToolTip("" if own else none)
        menu.addSeparator()
        menu.addAction(tr("&Rename…"), lambda: self._edit_type(kind.id))
        colors = menu.addMenu(tr("&Colour"))
        for name, color in theme.COLORS:
            action = colors.addAction(theme.swatch(color), tr(name))
            action.setCheckable(True)
            action.setChecked(color == kind.color)
            action.triggered.connect(partial(self._change_kind, kind, "color", color))
        colors.addSeparator()
        colors.addAction(tr("Other…"), lambda: self._edit_type(kind.id))
        symbols = menu.addMenu(tr("S&ymbol"))
        for symbol in theme.SYMBOLS:
            action = symbols.addAction(
                theme.type_icon(kind.color, symbol), tr(SYMBOL_NAMES[symbol])
            )
            action.setCheckable(True)
            action.setChecked(symbol == kind.symbol)
            action.triggered.connect(partial(self._change_kind, kind, "symbol", symbol))
        menu.addAction(
            theme.icon("delete-outline"),
            tr("Re&move type"),
            lambda: studio.attempt(edits.remove_type, kind.id),
        )
        menu.addSeparator()
        menu.addAction(
            theme.icon("shape-outline"), tr("Feature &types…"), lambda: self._edit_type(kind.id)
        )

    def _change_kind(self, kind: FeatureType, field: str, value: str, *_: object) -> None:
        if getattr(kind, field) != value:
            # The fields' literal types are those of the menu's entries.
            changed = replace(kind, **{field: value})  # type: ignore[arg-type]
            self._studio.attempt(edits.change_type, changed)
