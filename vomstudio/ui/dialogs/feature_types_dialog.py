"""Dialog of the feature types with name, colour and symbol. Every change is an edit of its own and
can be undone."""

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
from vomstudio.project.records import DEFAULT_TYPES, FeatureType, Typed
from vomstudio.ui.base import theme
from vomstudio.ui.base.controls import ComboBox, Label
from vomstudio.ui.base.studio import Studio
from vomstudio.ui.panels.features.symbol_names import SYMBOL_NAMES

_ID = Qt.ItemDataRole.UserRole


class TypesDialog(QDialog):
    """Opens at the type with `type_id`, or at that of the next feature."""

    def __init__(self, parent: QWidget, studio: Studio, type_id: str = "") -> None:
        super().__init__(parent)
        self._studio = studio
        self.setWindowTitle(tr("Feature types"))
        self.setMinimumSize(560, 360)
        self.list = QListWidget()
        self.list.setObjectName("types_list")
        self.list.setIconSize(QSize(18, 18))
        self.list.currentItemChanged.connect(self._show)
        self.name = QLineEdit()
        self.name.setObjectName("type_name")
        self.name.editingFinished.connect(self._named)
        self.colors: dict[str, QToolButton] = {}
        self.symbol = ComboBox()
        self.symbol.setObjectName("type_symbol")
        self.symbol.activated.connect(lambda _: self._change(symbol=self.symbol.currentData()))
        self.nature = ComboBox()
        self.nature.setObjectName("type_nature")
        self.nature.addItem(tr("Planes (beds, faults, joints)"), "plane")
        self.nature.addItem(tr("Lines (axes, striations)"), "line")
        self.nature.activated.connect(lambda _: self._change(geometry=self.nature.currentData()))
        self.used = Label()
        self.used.setWordWrap(True)
        self.says = Label()
        self.says.setWordWrap(True)
        self.add_button = QPushButton(theme.icon("plus"), tr("Add"))
        self.add_button.setObjectName("type_add")
        self.add_button.clicked.connect(self._add)
        self.remove_button = QPushButton(theme.icon("delete-outline"), tr("Remove"))
        self.remove_button.setObjectName("type_remove")
        self.remove_button.clicked.connect(self._remove)
        # Enter in the name ends the typing, not the dialog.
        for button in (self.add_button, self.remove_button):
            button.setAutoDefault(False)
        self._arrange()
        studio.edited.connect(self._edited)
        studio.project_opened.connect(self.close)
        self._fill(type_id or studio.next_type_id)

    def _arrange(self) -> None:
        colors = QWidget()
        row = QHBoxLayout(colors)
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
            tr("The eight colours beside can be distinguished by colour-blind readers.")
        )
        self.other_color.setCheckable(True)
        theme.highlight_toggles(self.other_color)
        self.other_color.clicked.connect(self._choose_color)
        row.addWidget(self.other_color)
        row.addStretch()
        form = QFormLayout()
        form.addRow(tr("Name"), self.name)
        form.addRow(tr("Colour"), colors)
        form.addRow(tr("Symbol"), self.symbol)
        form.addRow(tr("Features"), self.nature)
        form.addRow("", self.used)
        right = QVBoxLayout()
        right.addLayout(form)
        right.addStretch()
        right.addWidget(self.says)
        buttons = QHBoxLayout()
        buttons.addWidget(self.add_button)
        buttons.addWidget(self.remove_button)
        left = QVBoxLayout()
        left.addWidget(self.list)
        left.addLayout(buttons)
        both = QHBoxLayout()
        both.addLayout(left, 2)
        both.addLayout(right, 3)
        box = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
        box.button(QDialogButtonBox.StandardButton.Close).setAutoDefault(False)
        box.rejected.connect(self.close)
        layout = QVBoxLayout(self)
        layout.addLayout(both)
        layout.addWidget(box)

    # --- what is shown -----------------------------------------------------------------------
    @property
    def type_id(self) -> str:
        """Id of the type that is shown; empty where there is none."""
        item = self.list.currentItem()
        return str(item.data(_ID)) if item else ""

    def select(self, type_id: str) -> None:
        """Show a type, ready to be renamed."""
        self._fill(type_id)
        self.name.setFocus()
        self.name.selectAll()

    def _fill(self, chosen: str) -> None:
        with QSignalBlocker(self.list):
            self.list.clear()
            for kind in self._studio.session.of(FeatureType):
                item = QListWidgetItem(theme.type_icon(kind.color, kind.symbol), kind.name)
                item.setData(_ID, kind.id)
                self.list.addItem(item)
                if kind.id == chosen:
                    self.list.setCurrentItem(item)
            if self.list.currentItem() is None:
                self.list.setCurrentRow(0)
        self._show()

    def _show(self, *_: object) -> None:
        kind = self._studio.records.get(self.type_id)
        if not isinstance(kind, FeatureType):
            return
        self.says.clear()
        self.name.setText(kind.name)
        self.name.setModified(False)
        for color, button in self.colors.items():
            button.setChecked(color == kind.color)
        own = kind.color not in self.colors
        self.other_color.setChecked(own)
        self.other_color.setText(kind.color if own else tr("Other…"))
        self.symbol.clear()
        for symbol in theme.SYMBOLS:
            self.symbol.addItem(
                theme.type_icon(kind.color, symbol), tr(SYMBOL_NAMES[symbol]), symbol
            )
        self.symbol.setCurrentIndex(max(0, self.symbol.findData(kind.symbol)))
        self.nature.setCurrentIndex(self.nature.findData(kind.geometry))
        count = sum(
            isinstance(f, Typed) and f.type_id == kind.id for f in self._studio.session.features()
        )
        self.used.setText(
            tr_n("{count} feature is of this type.", "{count} features are of this type.", count)
            if count
            else tr("No feature is of this type yet.")
        )

    def _edited(self, edit: Edit) -> None:
        new = [i for i, r in edit.after.items() if isinstance(r, FeatureType)]
        added = [i for i in new if edit.before[i] is None]
        # What is being typed survives an edit made elsewhere.
        typed = self.name.text() if self.name.isModified() else None
        before = self.type_id
        self._fill(added[0] if added else before)
        if typed is not None and self.type_id == before and before not in new:
            self.name.setText(typed)
            self.name.setModified(True)

    # --- what is done ------------------------------------------------------------------------
    def _named(self) -> None:
        if self.name.isModified():
            self.name.setModified(False)
            self._change(name=self.name.text().strip())

    def _change_color(self, color: str) -> None:
        self._change(color=color)

    def _choose_color(self) -> None:
        kind = self._studio.records.get(self.type_id)
        assert isinstance(kind, FeatureType)
        chosen = QColorDialog.getColor(QColor(kind.color), self, tr("Colour of the type"))
        if chosen.isValid():
            self._change(color=chosen.name())
        else:
            self._show()

    def _change(self, **values: str) -> None:
        kind = self._studio.records.get(self.type_id)
        if isinstance(kind, FeatureType) and any(getattr(kind, k) != v for k, v in values.items()):
            # The literal types of the record's fields are those of the boxes' entries.
            self._do(edits.change_type, replace(kind, **values))  # type: ignore[arg-type]
        else:
            self._show()

    def _add(self) -> None:
        """Offer the default types that are missing, and a type of the user's own."""
        present = {kind.id for kind in self._studio.session.of(FeatureType)}
        missing = [kind for kind in DEFAULT_TYPES if kind.id not in present]
        if not missing:
            self._add_own()
            return
        menu = QMenu(self)
        for kind in missing:
            action = menu.addAction(theme.type_icon(kind.color, kind.symbol), kind.name)
            action.triggered.connect(partial(self._do, edits.add_type, kind))
        menu.addSeparator()
        menu.addAction(tr("Own type"), self._add_own)
        menu.exec(self.add_button.mapToGlobal(self.add_button.rect().bottomLeft()))

    def _add_own(self) -> None:
        kind = new_type(self._studio)
        if self._do(edits.add_type, kind):
            self.select(kind.id)

    def _remove(self) -> None:
        self._do(edits.remove_type, self.type_id)

    def _do(self, make: object, *args: object) -> bool:
        """Make an edit; False, with the reason shown in the dialog, where it is refused."""
        assert callable(make)
        try:
            self._studio.session.apply(make(self._studio.records, *args))
        except VomError as error:
            self._show()
            self.says.setText(error.message)
            return False
        return True


def new_type(studio: Studio) -> FeatureType:
    """A type of the user's own, with a name, colour and symbol that are free."""
    kinds = studio.session.of(FeatureType)
    names = {kind.name.casefold() for kind in kinds}
    name = next(n for i in range(1, 1000) if (n := f"Type {i}").casefold() not in names)
    looks = [(kind.color, kind.symbol) for kind in kinds]
    used = [color for color, _ in looks]
    color = min((c for _, c in theme.COLORS), key=used.count)
    symbol = next((s for s in theme.SYMBOLS if (color, s) not in looks), "circle")
    return FeatureType(new_id("type"), name, color, symbol)
