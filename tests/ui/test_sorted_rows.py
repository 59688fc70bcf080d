"""Order and filter of the orientation table, against sorting and filtering by hand."""

import pytest
from PySide6.QtCore import QModelIndex, Qt
from PySide6.QtTest import QAbstractItemModelTester

from tests.tiers import first_in_default_tier
from tests.ui.conftest import add_bed, add_cliff
from vomstudio.io.settings import DETAIL_COLUMNS
from vomstudio.project import edits
from vomstudio.ui.panels.features.feature_filter import parse_filter
from vomstudio.ui.panels.features.table_model import COLUMNS

pytestmark = pytest.mark.full

ASCENDING, DESCENDING = Qt.SortOrder.AscendingOrder, Qt.SortOrder.DescendingOrder
THREE = ((0, 0, 0), (1, 0, 0.2), (0, 1, 0.5))
DIP = next(i for i, c in enumerate(COLUMNS) if c.title == "± dip")


@pytest.fixture
def table(window, studio):
    add_cliff(studio)
    for i in range(12):
        more = {"vertices": THREE} if i % 5 == 4 else {"dip": 0.1 + 0.3 * (i * 7 % 12)}
        add_bed(studio, f"t{i}", f"B{i % 4}", type_id=("bedding", "joint")[i % 2], **more)
    return window.table


def by_hand(table, column: int, order, test=None) -> list[str]:
    rows = [table.model.row(i) for i in range(table.model.rowCount())]
    rows = [r for r in rows if test is None or test(r)]
    keys = {r.feature.id: COLUMNS[column].value(r) for r in rows}
    known = [r.feature.id for r in rows if keys[r.feature.id] is not None]
    known.sort(key=keys.__getitem__, reverse=order == DESCENDING)
    return known + [r.feature.id for r in rows if keys[r.feature.id] is None]


def seen(table) -> list[str]:
    rows = table._sorted_rows
    places = (rows.mapToSource(rows.index(i, 0)).row() for i in range(rows.rowCount()))
    return [table.model.id_at(place) for place in places]


def chosen(table) -> set[str]:
    rows = table._sorted_rows
    found = table.view.selectionModel().selectedRows()
    return {table.model.id_at(rows.mapToSource(i).row()) for i in found}


@pytest.mark.parametrize("order", first_in_default_tier([ASCENDING, DESCENDING], 1))
@pytest.mark.parametrize("column", first_in_default_tier([0, DIP], 1))
def test_order_and_filter_are_preserved_by_every_kind_of_edit(table, studio, column, order):
    tester = QAbstractItemModelTester(
        table._sorted_rows, QAbstractItemModelTester.FailureReportingMode.Fatal
    )
    table.view.sortByColumn(column, order)
    for text in ("", "type:joint", "dip>30", "no such word", "B1", ""):
        table._filter.setText(text)
        test = parse_filter(text) if text else None
        assert seen(table) == by_hand(table, column, order, test)
        studio.attempt(edits.set_attributes, ["t3", "t6"], type_id="joint", name="B9")
        assert seen(table) == by_hand(table, column, order, test)
        studio.attempt(edits.delete, ["t0", "t7", "t11"])
        assert seen(table) == by_hand(table, column, order, test)
        studio.undo()
        assert seen(table) == by_hand(table, column, order, test)
        studio.undo()
        assert seen(table) == by_hand(table, column, order, test)
    assert len(seen(table)) == 12
    assert tester.model() is table._sorted_rows


def test_a_feature_that_moves_in_the_order_stays_selected(table, studio):
    table.view.sortByColumn(0, ASCENDING)
    studio.selection.set(["t2", "t4"])
    studio.attempt(edits.set_attributes, ["t2"], name="Z1")
    assert seen(table)[-1] == "t2"
    assert chosen(table) == {"t2", "t4"}


def test_row_positions_map_both_ways_and_hidden_rows_have_no_position(table, studio):
    table._filter.setText("type:joint")
    rows = table._sorted_rows
    for place in range(table.model.rowCount()):
        index = rows.mapFromSource(table.model.index(place, 3))
        if table.model.row(place).type.id == "joint":
            assert (rows.mapToSource(index).row(), index.column()) == (place, 3)
        else:
            assert not index.isValid()
    assert not rows.mapToSource(QModelIndex()).isValid()


def test_small_changes_do_not_reset_the_table(table, studio):
    """A view that begins anew forgets where it was scrolled to."""
    resets = []
    table._sorted_rows.modelReset.connect(lambda: resets.append(1))
    studio.attempt(edits.delete, ["t5"])
    studio.undo()
    studio.attempt(edits.set_attributes, ["t5"], set_name="J1")
    add_bed(studio, "t99")
    assert not resets


def test_initially_hidden_columns_exist() -> None:
    assert set(DETAIL_COLUMNS) <= {column.title for column in COLUMNS}


def test_default_columns_show_one_error_column_and_end_with_the_widest(table) -> None:
    view = table.view
    shown = [i for i in range(len(COLUMNS)) if not view.isColumnHidden(i)]
    assert "95 % error" not in [COLUMNS[i].title for i in shown]
    widths = [view.columnWidth(i) for i in shown]
    assert widths[-1] == max(widths)
    assert sum(widths) < 1400
