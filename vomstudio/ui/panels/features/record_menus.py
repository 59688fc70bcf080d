"""Context menus of records, feature types and groups, the same in every view."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from typing import Protocol

from PySide6.QtCore import QObject, Qt
from PySide6.QtGui import QAction
from PySide6.QtWidgets import QMenu, QWidget

from vomstudio.core.findings import Finding
from vomstudio.core.words import tr
from vomstudio.project import edits
from vomstudio.project.kinds import GROUPS, get_kind, visibility_group
from vomstudio.project.records import Feature, FeatureType, Record, TypedFeature
from vomstudio.ui.base import theme
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.features.symbol_names import SYMBOL_NAMES

GROUP_IDS = ("models", *(group.id for group in GROUPS))
MAX_LISTED_SETS = 12
"""Maximum number of sets in a menu; any other set can be typed in the properties."""


class RecordActions(Protocol):
    """Function that returns the actions of a record in groups."""

    def __call__(self, record: Record, *, is_visible: bool) -> list[list[QAction]]: ...


class RecordMenus(QObject):
    """Factory of context menus, which change the selected records.

    Parameters
    ----------
    actions : callable
        Returns the actions of a record in groups.
    edit_type : callable
        Opens the dialog of feature types and selects the type with the given id, or the current
        type if the id is empty.
    """

    def __init__(
        self,
        studio: Studio,
        parent: QWidget,
        actions: RecordActions,
        edit_type: Callable[[str], object],
    ) -> None:
        super().__init__(parent)
        self._studio = studio
        self._parent = parent
        self._menu_actions = actions
        self._edit_type = edit_type

    def create_menu(self, id_: str) -> QMenu:
        """Create the menu of a record or group, or of the whole tree if `id_` is empty.

        A feature that is not selected becomes the selection.
        """
        menu = QMenu(self._parent)
        menu.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        menu.setToolTipsVisible(True)
        record = self._studio.records.get(id_)
        if isinstance(record, FeatureType):
            self._fill_type_menu(menu, record)
        elif isinstance(record, Feature):
            self.fill_feature_menu(menu, record)
        elif record is not None:
            self._add_groups(menu, self._groups(record))
        elif id_ in GROUP_IDS:
            self._add_visibility_action(menu, id_)
        else:
            menu.addAction(tr("Feature types…"), lambda: self._edit_type(""))
        return menu

    def fill_feature_menu(self, menu: QMenu, feature: Feature) -> None:
        """Add the commands for a feature, which act on all selected features."""
        if feature.id not in self._studio.selection.ids:
            self._studio.selection.set([feature.id])
        first_group, *other_groups = self._groups(feature)
        menu.addActions(first_group)
        if isinstance(feature, TypedFeature):
            self._add_type_menu(menu, feature)
            self._add_set_menu(menu, feature)
        self._add_groups(menu, other_groups)

    def _groups(self, record: Record) -> list[list[QAction]]:
        return self._menu_actions(record, is_visible=self._studio.visible(record.id))

    @staticmethod
    def _add_groups(menu: QMenu, groups: list[list[QAction]]) -> None:
        for group in groups:
            if not menu.isEmpty():
                menu.addSeparator()
            menu.addActions(group)

    def _add_type_menu(self, menu: QMenu, feature: TypedFeature) -> None:
        type_menu = menu.addMenu(tr("&Type"))
        geometry = get_kind(feature).type_geometry
        for feature_type in self._studio.session.of(FeatureType):
            if geometry in (None, feature_type.geometry) or feature_type.id == feature.type_id:
                action = type_menu.addAction(
                    theme.type_icon(feature_type.color, feature_type.symbol), feature_type.name
                )
                action.setCheckable(True)
                action.setChecked(feature_type.id == feature.type_id)
                action.triggered.connect(partial(self._change_selected_type, feature_type.id))

    def _change_selected_type(self, type_id: str, *_: object) -> None:
        self.change_type(self._studio.selection.ids, type_id)

    def change_type(self, ids: Iterable[str], type_id: str) -> None:
        """Change the type of features in one edit, skipping those that it does not suit."""
        records = self._studio.records
        feature_type = records.get(type_id)
        features = [
            feature
            for id_ in ids
            if isinstance(feature := records.get(id_), TypedFeature) and feature.type_id != type_id
        ]
        suitable_ids = [
            feature.id
            for feature in features
            if isinstance(feature_type, FeatureType)
            and get_kind(feature).type_geometry in (None, feature_type.geometry)
        ]
        if suitable_ids:
            self._studio.attempt(edits.set_attributes, suitable_ids, type_id=type_id)
        if len(suitable_ids) < len(features) and isinstance(feature_type, FeatureType):
            self._studio.hint(Finding("type.other-geometry", type=feature_type.name))

    def _add_set_menu(self, menu: QMenu, feature: TypedFeature) -> None:
        set_menu = menu.addMenu(tr("&Set"))
        features = self._studio.session.features()
        names = sorted({name for f in features if (name := getattr(f, "set_name", ""))})
        for name in ["", *names[:MAX_LISTED_SETS]]:
            action = set_menu.addAction(name.replace("&", "&&") or tr("none"))
            action.setCheckable(True)
            action.setChecked(name == feature.set_name)
            action.triggered.connect(partial(self._change_set, name))

    def _change_set(self, name: str, *_: object) -> None:
        records = self._studio.records
        ids = [
            id_ for id_ in self._studio.selection.ids if isinstance(records.get(id_), TypedFeature)
        ]
        if ids:
            self._studio.attempt(edits.set_attributes, ids, set_name=name)

    def _add_visibility_action(self, menu: QMenu, id_: str) -> None:
        is_visible = self._studio.visible(id_)
        menu.addAction(
            theme.icon("eye-off-outline" if is_visible else "eye-outline"),
            tr("Hide") if is_visible else tr("Show"),
            lambda: self._studio.set_visible([id_], not is_visible),
        )

    def _fill_type_menu(self, menu: QMenu, feature_type: FeatureType) -> None:
        studio = self._studio
        feature_ids = [
            f.id for f in studio.session.features() if visibility_group(f) == feature_type.id
        ]
        if feature_type.geometry == "plane":
            # The next type is that of planes; the Line tool has a type of its own.
            use_action = menu.addAction(
                tr("Use for &next"),
                lambda: studio.set_next_type(feature_type.id, studio.next_set),
            )
            use_action.setCheckable(True)
            use_action.setChecked(feature_type.id == studio.next_type_id)
        select_action = menu.addAction(
            tr("&Select its features"), lambda: studio.selection.set(feature_ids)
        )
        unused_text = tr("Not now: {reason}", reason=Finding("action.type-unused"))
        select_action.setEnabled(bool(feature_ids))
        select_action.setToolTip("" if feature_ids else unused_text)
        menu.addSeparator()
        self._add_visibility_action(menu, feature_type.id)
        show_only_action = menu.addAction(
            tr("Show &only selected"), lambda: studio.show_only(feature_ids)
        )
        show_only_action.setEnabled(bool(feature_ids))
        show_only_action.setToolTip("" if feature_ids else unused_text)
        menu.addSeparator()
        menu.addAction(tr("&Rename…"), lambda: self._edit_type(feature_type.id))
        color_menu = menu.addMenu(tr("&Colour"))
        for name, color in theme.COLORS:
            action = color_menu.addAction(theme.swatch(color), tr(name))
            action.setCheckable(True)
            action.setChecked(color == feature_type.color)
            action.triggered.connect(partial(self._change_type_field, feature_type, "color", color))
        color_menu.addSeparator()
        color_menu.addAction(tr("Other…"), lambda: self._edit_type(feature_type.id))
        symbol_menu = menu.addMenu(tr("S&ymbol"))
        for symbol in theme.SYMBOLS:
            action = symbol_menu.addAction(
                theme.type_icon(feature_type.color, symbol), tr(SYMBOL_NAMES[symbol])
            )
            action.setCheckable(True)
            action.setChecked(symbol == feature_type.symbol)
            action.triggered.connect(
                partial(self._change_type_field, feature_type, "symbol", symbol)
            )
        menu.addAction(
            theme.icon("delete-outline"),
            tr("Re&move type"),
            lambda: studio.attempt(edits.remove_type, feature_type.id),
        )
        menu.addSeparator()
        menu.addAction(
            theme.icon("shape-outline"),
            tr("Feature &types…"),
            lambda: self._edit_type(feature_type.id),
        )

    def _change_type_field(
        self, feature_type: FeatureType, field: str, value: str, *_: object
    ) -> None:
        if getattr(feature_type, field) != value:
            # The menu entries are valid values of the literal types.
            new_type = replace(feature_type, **{field: value})  # type: ignore[arg-type]
            self._studio.attempt(edits.change_type, new_type)
