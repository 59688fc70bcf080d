"""Table of the beds in a log, youngest first, with editable lithology and notes."""

from __future__ import annotations

from PySide6.QtCore import QAbstractItemModel, QModelIndex, QPersistentModelIndex, Qt, Signal
from PySide6.QtGui import QResizeEvent
from PySide6.QtWidgets import (
    QAbstractItemView,
    QComboBox,
    QHeaderView,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableWidget,
    QTableWidgetItem,
    QWidget,
)

from vomstudio.core.words import tr
from vomstudio.geology.beds import lithologies
from vomstudio.products.section.decimals import format_with_error
from vomstudio.products.section.line_log import LogResult, RockDescription
from vomstudio.ui.base.controls import ComboBox

Index = QModelIndex | QPersistentModelIndex

THICKNESS, LITHOLOGY, NOTES = 3, 4, 5
_MIN_TABLE_HEIGHT_PX = 110
_MIN_EDITOR_WIDTH_PX = 110
_ROW_HEIGHT_PX = 24


class BedLogTable(QTableWidget):
    """Table of the beds in a log.

    `description_edited` is emitted with the key of a bed and its new description.
    """

    description_edited = Signal(str, object)

    def __init__(self) -> None:
        columns = (
            (tr("Bed"), tr("Number, counted from the oldest bed.")),
            (tr("From"), tr("Lower boundary of the bed.")),
            (tr("To"), tr("Upper boundary of the bed.")),
            ("", tr("True thickness across the bedding, with its 95 % error.")),
            (tr("Lithology"), tr("Lithology from the StraboSpot list; double-click to edit.")),
            (tr("Notes"), tr("Double-click to edit.")),
        )
        super().__init__(0, len(columns))
        self.setObjectName("log_table")
        self.setAccessibleName(tr("Beds of the log"))
        for column, (title, tooltip) in enumerate(columns):
            item = QTableWidgetItem(title)
            item.setToolTip(tooltip)
            self.setHorizontalHeaderItem(column, item)
        self.verticalHeader().hide()
        self.verticalHeader().setDefaultSectionSize(_ROW_HEIGHT_PX)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        self.setTabKeyNavigation(False)
        self.show_unit("m")
        header = self.horizontalHeader()
        header.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        # A stretched section would shrink to nothing in a narrow dock.
        header.setSectionResizeMode(NOTES, QHeaderView.ResizeMode.Fixed)
        header.setMinimumSectionSize(32)
        header.sectionResized.connect(
            lambda column, *_: self._widen_notes() if column != NOTES else None
        )
        self._lithology_editor = _LithologyEditor(self)
        self.setItemDelegateForColumn(LITHOLOGY, self._lithology_editor)
        self.setMinimumHeight(_MIN_TABLE_HEIGHT_PX)
        self._keys: list[str] = []
        self.itemChanged.connect(self._emit_description)

    def resizeEvent(self, event: QResizeEvent) -> None:  # noqa: N802
        super().resizeEvent(event)
        self._widen_notes()

    def _widen_notes(self) -> None:
        """Fit the notes column to the remaining width, but at least to its header."""
        header = self.horizontalHeader()
        used_width = sum(header.sectionSize(column) for column in range(NOTES))
        min_width = header.sectionSizeHint(NOTES)
        header.resizeSection(NOTES, max(self.viewport().width() - used_width, min_width))

    def show_unit(self, unit: str) -> None:
        """Set the unit in which thicknesses are shown."""
        header_item = self.horizontalHeaderItem(THICKNESS)
        assert header_item is not None
        header_item.setText(tr("Thickness ({unit})", unit=unit))

    def show_log(self, result: LogResult | None) -> None:
        """Show a log; cells are updated in place, so that an open editor stays open."""
        beds = [] if result is None else list(result.log.intervals)
        keys = [] if result is None else list(result.base_keys)
        was_blocked = self.blockSignals(True)
        self.setRowCount(len(beds))
        self._keys = keys[::-1]
        for row, bed in enumerate(reversed(beds)):
            thickness = bed.thickness_m
            texts = (
                str(bed.number),
                bed.base,
                bed.top,
                format_with_error(thickness.value, thickness.error95),
                bed.lithology,
                bed.notes,
            )
            for column, text in enumerate(texts):
                self._set_cell(row, column, text)
        self.blockSignals(was_blocked)
        self._widen_notes()

    def _set_cell(self, row: int, column: int, text: str) -> None:
        item = self.item(row, column)
        if item is None:
            item = QTableWidgetItem()
            if column not in (LITHOLOGY, NOTES):
                item.setFlags(item.flags() & ~Qt.ItemFlag.ItemIsEditable)
            if column in (0, 3):
                alignment = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
                item.setTextAlignment(alignment)
            self.setItem(row, column, item)
        item.setText(text)
        if column in (LITHOLOGY, NOTES):
            item.setToolTip(text or tr("Double-click to edit."))

    def _emit_description(self, item: QTableWidgetItem) -> None:
        row = item.row()
        if item.column() in (LITHOLOGY, NOTES) and row < len(self._keys):
            lithology, notes = (self.item(row, column) for column in (LITHOLOGY, NOTES))
            assert lithology is not None
            assert notes is not None
            description = RockDescription(
                " ".join(lithology.text().split()), " ".join(notes.text().split())
            )
            self.description_edited.emit(self._keys[row], description)


class _LithologyEditor(QStyledItemDelegate):
    """Editor that offers the lithologies of StraboSpot and accepts other texts."""

    def createEditor(  # noqa: N802
        self, parent: QWidget, option: QStyleOptionViewItem, index: Index
    ) -> QWidget:
        box = _LithologyBox()
        box.setParent(parent)
        box.setMinimumWidth(_MIN_EDITOR_WIDTH_PX)
        box.addItem("")
        box.addItems(lithologies.lithology_choices())
        box.activated.connect(lambda _: self._commit_choice(box))
        return box

    def _commit_choice(self, box: _LithologyBox) -> None:
        """Commit a choice from the list; typed text is committed with Enter, as in other cells."""
        if box.is_list_choice:
            self.commitData.emit(box)
            self.closeEditor.emit(box)

    def setEditorData(self, editor: QWidget, index: Index) -> None:  # noqa: N802
        assert isinstance(editor, ComboBox)
        editor.setEditText(str(index.data() or ""))

    def setModelData(  # noqa: N802
        self, editor: QWidget, model: QAbstractItemModel, index: Index
    ) -> None:
        assert isinstance(editor, ComboBox)
        model.setData(index, editor.currentText())


class _LithologyBox(ComboBox):
    """Combo box of lithologies.

    `is_list_choice` is True if no text has been typed since the list was last opened.
    """

    def __init__(self) -> None:
        super().__init__()
        self.is_list_choice = False
        self.setEditable(True)
        self.setInsertPolicy(QComboBox.InsertPolicy.NoInsert)
        line_edit = self.lineEdit()
        assert line_edit is not None
        line_edit.textEdited.connect(lambda _: self._reset_choice())

    def _reset_choice(self) -> None:
        self.is_list_choice = False

    def showPopup(self) -> None:  # noqa: N802
        self.is_list_choice = True
        super().showPopup()
