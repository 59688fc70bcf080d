"""Dialog for the names, colours and symbols of the feature types."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

from PySide6.QtCore import QSignalBlocker, QSize, Qt
from PySide6.QtGui import QColor
from PySide6.QtWidgets import (
    QColorDialog,
    QDialog,
    QDialogButtonBox,
    QFormLayout,
    QHBoxLayout,
    QLineEdit,
    QListWidget,
    QListWidgetItem,
    QMenu,
    QPushButton,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from vomstudio.core.errors import VomError
from vomstudio.core.identifiers import new_id
from vomstudio.core.words import tr, tr_n
from vomstudio.project import edits
from vomstudio.project.edit import Edit
from vomstudio.project.records import DEFAULT_TYPES, FeatureType, TypedFeature
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import ComboBox, Label
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.features.symbol_names import SYMBOL_NAMES

_ID = Qt.ItemDataRole.UserRole


class TypesDialog(QDialog):
    """Editor of the feature types. Every change is a separate edit that can be undone."""

    def __init__(self, parent: QWidget, studio: Studio, type_id: str = "") -> None:
        super().__init__(parent)
        self._studio = studio
        self.setWindowTitle(tr("Feature types"))
        self.setMinimumSize(560, 360)
        self.list = QListWidget()
        self.list.setObjectName("types_list")
        self.list.setIconSize(QSize(18, 18))
        self.list.currentItemChanged.connect(self._show_selected_type)
        self.name = QLineEdit()
        self.name.setObjectName("type_name")
        self.name.editingFinished.connect(self._apply_name)
        self.colors: dict[str, QToolButton] = {}
        self.symbol = ComboBox()
        self.symbol.setObjectName("type_symbol")
        self.symbol.activated.connect(lambda _: self._change(symbol=self.symbol.currentData()))
        self.geometry_box = ComboBox()
        self.geometry_box.setObjectName("type_nature")
        self.geometry_box.addItem(tr("Planes (beds, faults, joints)"), "plane")
        self.geometry_box.addItem(tr("Lines (axes, striations)"), "line")
        self.geometry_box.activated.connect(
            lambda _: self._change(geometry=self.geometry_box.currentData())
        )
        self.usage = Label()
        self.usage.setWordWrap(True)
        self.message = Label()
        self.message.setWordWrap(True)
        self.add_button = QPushButton(theme.icon("plus"), tr("Add"))
        self.add_button.setObjectName("type_add")
        self.add_button.clicked.connect(self._add)
        self.remove_button = QPushButton(theme.icon("delete-outline"), tr("Remove"))
        self.remove_button.setObjectName("type_remove")
        self.remove_button.clicked.connect(self._remove)
        # Enter in the name field must not close the dialog.
        for button in (self.add_button, self.remove_button):
            button.setAutoDefault(False)
        self._arrange_widgets()
        studio.edited.connect(self._handle_edit)
        self._fill(type_id or studio.next_type_id)

    def _arrange_widgets(self) -> None:
        color_row = QWidget()
        row = QHBoxLayout(color_row)
        row.setContentsMargins(0, 0, 0, 0)
        row.setSpacing(2)
        for name, color in theme.COLORS:
            button = QToolButton()
            button.setIcon(theme.swatch(color))
            button.setToolTip(f"{tr(name)} ({color})")
            button.setAccessibleName(tr(name))
            button.setCheckable(True)
            theme.highlight_toggles(button)
            button.clicked.connect(partial(self._change_color, color))
            self.colors[color] = button
            row.addWidget(button)
        self.other_color = QToolButton()
        self.other_color.setText(tr("Other…"))
        self.other_color.setToolTip(
            tr("Choose another colour; the eight suggested ones suit colour-blind readers.")
        )
        self.other_color.setCheckable(True)
        theme.highlight_toggles(self.other_color)
        self.other_color.clicked.connect(self._choose_color)
        row.addWidget(self.other_color)
        row.addStretch()
        form = QFormLayout()
        form.addRow(tr("Name"), self.name)
        form.addRow(tr("Colour"), color_row)
        form.addRow(tr("Symbol"), self.symbol)
        form.addRow(tr("Features"), self.geometry_box)
        form.addRow("", self.usage)
        right_column = QVBoxLayout()
        right_column.addLayout(form)
        right_column.addStretch()
        right_column.addWidget(self.message)
        buttons = QHBoxLayout()
        buttons.addWidget(self.add_button)
        buttons.addWidget(self.remove_button)
        left_column = QVBoxLayout()
        left_column.addWidget(self.list)
        left_column.addLayout(buttons)
        columns = QHBoxLayout()
        columns.addLayout(left_column, 2)
        columns.addLayout(right_column, 3)
        close_box = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        close_box.button(QDialogButtonBox.StandardButton.Close).setAutoDefault(False)
        close_box.rejected.connect(self.close)
        layout = QVBoxLayout(self)
        layout.addLayout(columns)
        layout.addWidget(close_box)

    # --- display -----------------------------------------------------------------------------
    @property
    def type_id(self) -> str:
        """ID of the selected type, or "" if none is selected."""
        item = self.list.currentItem()
        return str(item.data(_ID)) if item else ""

    def select(self, type_id: str) -> None:
        """Select a type, and select the text of its name for renaming."""
        self._fill(type_id)
        self.name.setFocus()
        self.name.selectAll()

    def _fill(self, selected_id: str) -> None:
        with QSignalBlocker(self.list):
            self.list.clear()
            for feature_type in self._studio.session.of(FeatureType):
                item = QListWidgetItem(
                    theme.type_icon(feature_type.color, feature_type.symbol), feature_type.name
                )
                item.setData(_ID, feature_type.id)
                self.list.addItem(item)
                if feature_type.id == selected_id:
                    self.list.setCurrentItem(item)
            if self.list.currentItem() is None:
                self.list.setCurrentRow(0)
        self._show_selected_type()

    def _show_selected_type(self, *_: object) -> None:
        feature_type = self._studio.records.get(self.type_id)
        if not isinstance(feature_type, FeatureType):
            return
        self.message.clear()
        self.name.setText(feature_type.name)
        self.name.setModified(False)
        for color, button in self.colors.items():
            button.setChecked(color == feature_type.color)
        is_custom = feature_type.color not in self.colors
        self.other_color.setChecked(is_custom)
        self.other_color.setText(feature_type.color if is_custom else tr("Other…"))
        self.symbol.clear()
        for symbol in theme.SYMBOLS:
            self.symbol.addItem(
                theme.type_icon(feature_type.color, symbol), tr(SYMBOL_NAMES[symbol]), symbol
            )
        self.symbol.setCurrentIndex(max(0, self.symbol.findData(feature_type.symbol)))
        self.geometry_box.setCurrentIndex(self.geometry_box.findData(feature_type.geometry))
        count = sum(
            isinstance(f, TypedFeature) and f.type_id == feature_type.id
            for f in self._studio.session.features()
        )
        self.usage.setText(
            tr_n("{count} feature is of this type.", "{count} features are of this type.", count)
            if count
            else tr("No feature is of this type yet.")
        )

    def _handle_edit(self, edit: Edit) -> None:
        changed_ids = [i for i, r in edit.after.items() if isinstance(r, FeatureType)]
        added_ids = [i for i in changed_ids if edit.before[i] is None]
        # Keep an unfinished name when another edit is applied.
        pending_name = self.name.text() if self.name.isModified() else None
        previous_id = self.type_id
        self._fill(added_ids[0] if added_ids else previous_id)
        if (
            pending_name is not None
            and self.type_id == previous_id
            and previous_id not in changed_ids
        ):
            self.name.setText(pending_name)
            self.name.setModified(True)

    # --- edits -------------------------------------------------------------------------------
    def _apply_name(self) -> None:
        if self.name.isModified():
            self.name.setModified(False)
            self._change(name=self.name.text().strip())

    def _change_color(self, color: str) -> None:
        self._change(color=color)

    def _choose_color(self) -> None:
        feature_type = self._studio.records.get(self.type_id)
        assert isinstance(feature_type, FeatureType)
        color = QColorDialog.getColor(QColor(feature_type.color), self, tr("Colour of the type"))
        if color.isValid():
            self._change(color=color.name())
        else:
            self._show_selected_type()

    def _change(self, **values: str) -> None:
        feature_type = self._studio.records.get(self.type_id)
        if isinstance(feature_type, FeatureType) and any(
            getattr(feature_type, k) != v for k, v in values.items()
        ):
            # The boxes only contain values of the literal types.
            self._apply(edits.change_type, replace(feature_type, **values))  # type: ignore[arg-type]
        else:
            self._show_selected_type()

    def _add(self) -> None:
        """Offer the missing default types and a custom type.

        If no default type is missing, add a custom type.
        """
        present_ids = {feature_type.id for feature_type in self._studio.session.of(FeatureType)}
        missing_types = [
            feature_type for feature_type in DEFAULT_TYPES if feature_type.id not in present_ids
        ]
        if not missing_types:
            self._add_custom_type()
            return
        menu = QMenu(self)
        for feature_type in missing_types:
            action = menu.addAction(
                theme.type_icon(feature_type.color, feature_type.symbol), feature_type.name
            )
            action.triggered.connect(partial(self._apply, edits.add_type, feature_type))
        menu.addSeparator()
        menu.addAction(tr("Custom type"), self._add_custom_type)
        menu.exec(self.add_button.mapToGlobal(self.add_button.rect().bottomLeft()))

    def _add_custom_type(self) -> None:
        feature_type = create_custom_type(self._studio)
        if self._apply(edits.add_type, feature_type):
            self.select(feature_type.id)

    def _remove(self) -> None:
        self._apply(edits.remove_type, self.type_id)

    def _apply(self, create_edit: object, *args: object) -> bool:
        """Apply an edit, show the error if it is rejected, and return whether it succeeded."""
        assert callable(create_edit)
        try:
            self._studio.session.apply(create_edit(self._studio.records, *args))
        except VomError as error:
            self._show_selected_type()
            self.message.setText(error.message)
            return False
        return True


def create_custom_type(studio: Studio) -> FeatureType:
    """Create a custom type with an unused name and the least used colour.

    Its symbol is not used with this colour yet, or is a circle if all symbols are used.
    """
    feature_types = studio.session.of(FeatureType)
    names = {feature_type.name.casefold() for feature_type in feature_types}
    name = next(n for i in range(1, 1000) if (n := f"Type {i}").casefold() not in names)
    styles = [(feature_type.color, feature_type.symbol) for feature_type in feature_types]
    used_colors = [color for color, _ in styles]
    color = min((c for _, c in theme.COLORS), key=used_colors.count)
    symbol = next((s for s in theme.SYMBOLS if (color, s) not in styles), "circle")
    return FeatureType(new_id("type"), name, color, symbol)
