"""Table, tree and properties: what they show, and what typing into them does."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QLocale, Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication, QLineEdit

from tests import driver
from tests.tiers import first_in_default_tier
from tests.ui.conftest import add_bed, add_cliff
from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding
from vomstudio.project import edits
from vomstudio.project.kinds.trace import Trace
from vomstudio.studio.tools.trace import TraceTool
from vomstudio.ui.base.numbers import parse_number
from vomstudio.ui.panels.features.table_panel import COLUMNS
from vomstudio.ui.panels.tools.trace import TracePanel

ASCENDING, DESCENDING = Qt.SortOrder.AscendingOrder, Qt.SortOrder.DescendingOrder


def column(title: str) -> int:
    return next(i for i, c in enumerate(COLUMNS) if c.title == title)


def shown(window, title: str = "Name") -> list[str]:
    model = window.table._sorted_rows
    return [model.index(r, column(title)).data() for r in range(model.rowCount())]


def rows_chosen(window) -> list[str]:
    panel = window.table
    return [
        panel.model.id_at(panel._sorted_rows.mapToSource(i).row())
        for i in panel.view.selectionModel().selectedRows()
    ]


def type_into(editor: QLineEdit, text: str) -> None:
    editor.setFocus()
    editor.selectAll()
    QTest.keyClicks(editor, text)
    QTest.keyClick(editor, Qt.Key.Key_Return)
    # An editor in a table hands its text over in the next round of the event loop.
    QApplication.processEvents()


# --- table ---------------------------------------------------------------------------------
def test_undefined_values_are_sorted_last_in_both_orders(window, studio):
    add_cliff(studio)
    # Three points have no redundancy, so their confidence is undefined.
    add_bed(studio, "t1", "three", vertices=((0, 0, 0), (1, 0, 0.2), (0, 1, 0.5)))
    add_bed(studio, "t2", "flat", dip=0.2)
    add_bed(studio, "t3", "steep", dip=2.0)
    for title in ("95 % error", "± dip", "Ext./res."):
        for order in (ASCENDING, DESCENDING):
            window.table.view.sortByColumn(column(title), order)
            values = shown(window, title)
            defined = [v for v in values if v != "–"]
            assert values == defined + ["–"] * (len(values) - len(defined))
    window.table.view.sortByColumn(column("± dip"), DESCENDING)
    assert shown(window)[-1] == "three"


def test_names_are_sorted_in_natural_order(window, studio):
    add_cliff(studio)
    for name in ("B10", "B2", "B1"):
        add_bed(studio, name, name)
    window.table.view.sortByColumn(0, ASCENDING)
    assert shown(window) == ["B1", "B2", "B10"]
    assert [window.tree._items["bedding"].child(i).text(0) for i in range(3)] == [
        "B1",
        "B2",
        "B10",
    ]


def test_filter_matches_any_column_and_keeps_the_selection(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1", "upper", set_name="limb A")
    add_bed(studio, "t2", "lower", set_name="limb B", notes="covered")
    add_bed(studio, "t3", "other", type_id="fault")
    studio.selection.set(["t1", "t2"])
    for words, expected in (
        ("limb", ["lower", "upper"]),
        ("LIMB cover", ["lower"]),
        ("fault", ["other"]),
        ("nothing of it", []),
        ("", ["lower", "other", "upper"]),
    ):
        window.table._filter.setText(words)
        assert sorted(shown(window)) == expected
        assert studio.selection.ids == ("t1", "t2"), words
    assert "features" in window.table._count_label.text()
    assert sorted(rows_chosen(window)) == ["t1", "t2"]


@pytest.mark.parametrize(
    ("title", "field"),
    first_in_default_tier([("Name", "name"), ("Set", "set_name"), ("Notes", "notes")]),
)
def test_names_sets_and_notes_are_edited_in_place(window, studio, title, field):
    add_cliff(studio)
    add_bed(studio, "t1", "first")
    view = window.table.view
    index = window.table._sorted_rows.index(0, column(title))
    view.scrollTo(index)
    view.edit(index)
    editor = view.findChild(QLineEdit)
    type_into(editor, "  marl 3 ")
    assert getattr(studio.records["t1"], field) == "marl 3"
    studio.undo()
    assert getattr(studio.records["t1"], field) == ("first" if field == "name" else "")


def test_empty_name_is_rejected_and_the_old_name_kept(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1", "first")
    model = window.table.model
    assert not model.setData(model.index(0, 0), "   ")
    assert studio.notices[-1].code == "name.empty"
    assert shown(window) == ["first"]
    window.tree._items["t1"].setText(0, " ")
    assert window.tree._items["t1"].text(0) == "first"
    studio.selection.set(["t1"])
    type_into(window.properties.fields["name"], " ")
    assert window.properties.fields["name"].text() == "first"


def test_measured_columns_are_read_only(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1")
    model = window.table.model
    for i, each in enumerate(COLUMNS):
        editable = bool(model.flags(model.index(0, i)) & Qt.ItemFlag.ItemIsEditable)
        assert editable == (each.title in ("Name", "Set", "Station", "Notes"))


def test_table_columns_grow_with_later_planes(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1", "a", vertices=((0, 0, 0), (1, 0, 0.2), (0, 1, 0.5)))
    add_bed(studio, "t2", "a much longer name of a bed", set_name="upper limb of the fold")
    for i in range(6):
        assert window.table.view.columnWidth(i) >= window.table.view.sizeHintForColumn(i)


# --- tree ----------------------------------------------------------------------------------
def test_hiding_a_group_or_plane_in_the_tree_is_not_an_edit(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1")
    before = studio.session.top
    for id_ in ("t1", "bedding", "m1", "models"):
        item = window.tree._items[id_]
        item.setCheckState(0, Qt.CheckState.Unchecked)
        assert not studio.visible(id_)
        item.setCheckState(0, Qt.CheckState.Checked)
        assert studio.visible(id_)
    assert studio.session.top == before


def test_hidden_features_stay_hidden_after_reopening(window, studio, tmp_path):
    add_cliff(studio)
    add_bed(studio, "t1")
    studio.set_visible(["t1"], False)
    studio.save_as(tmp_path / "p.vom")
    folder = studio.project.folder
    studio.new_project()
    assert studio.visible("t1")
    studio.open_project(folder)
    assert not studio.visible("t1")
    assert window.tree._items["t1"].checkState(0) == Qt.CheckState.Unchecked


def test_tree_follows_edits_and_undo(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1", "first")
    assert window.tree._items["bedding"].text(0) == "Bedding (1)"
    studio.attempt(edits.set_attributes, ["t1"], type_id="fault", name="main")
    assert window.tree._items["t1"].parent() is window.tree._items["fault"]
    assert window.tree._items["bedding"].isHidden()
    studio.undo()
    assert window.tree._items["t1"].parent() is window.tree._items["bedding"]
    studio.attempt(edits.delete, ["t1"])
    assert "t1" not in window.tree._items
    studio.undo()
    assert window.tree._items["t1"].text(0) == "first"


# --- selection -----------------------------------------------------------------------------
def test_selection_is_shared_by_all_panels(window, studio):
    add_cliff(studio)
    for i in range(3):
        add_bed(studio, f"t{i}")
    window.table.view.selectRow(1)
    (id_,) = rows_chosen(window)
    assert studio.selection.ids == (id_,)
    assert window.tree._items[id_].isSelected()
    assert window.properties.fields["name"].text() == studio.records[id_].name
    window.tree.tree.setCurrentItem(window.tree._items["t2"])
    assert studio.selection.ids == ("t2",)
    assert rows_chosen(window) == ["t2"]
    studio.attempt(edits.delete, ["t2"])
    assert studio.selection.ids == ()
    assert rows_chosen(window) == []


def test_plane_actions_are_disabled_without_a_selection(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1")
    table = window.actions_table.all
    assert not table["delete"].isEnabled()
    studio.selection.set(["t1"])
    assert table["delete"].isEnabled()
    assert table["rename"].isEnabled()


# --- properties ----------------------------------------------------------------------------
def test_changing_the_selection_edits_nothing(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1", "a", set_name="limb", notes="rough")
    add_bed(studio, "t2", "b", set_name="crest", notes="smooth")
    before = dict(studio.records)
    said: list[str] = []
    studio.notice.connect(lambda notice: said.append(notice.text))
    for ids in (["t1", "t2"], ["t1"], ["t2", "t1"], [], ["t2"]):
        studio.selection.set(ids)
        QApplication.processEvents()
    assert dict(studio.records) == before
    assert not said
    assert not studio.redo_label


def test_properties_edit_all_selected_features_except_their_names(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1", "a")
    add_bed(studio, "t2", "b")
    studio.selection.set(["t1", "t2"])
    panel = window.properties
    type_into(panel.fields["set_name"], "limb")
    assert {studio.records[i].set_name for i in ("t1", "t2")} == {"limb"}
    assert not panel.fields["name"].isEnabled()
    assert "one feature" in panel.fields["name"].toolTip()
    assert (studio.records["t1"].name, studio.records["t2"].name) == ("a", "b")
    panel.fields["overturned"].click()
    assert studio.records["t1"].overturned
    assert studio.records["t2"].overturned
    panel.fields["type_id"].setCurrentIndex(panel.fields["type_id"].findData("fault"))
    panel.fields["type_id"].activated.emit(panel.fields["type_id"].currentIndex())
    assert {studio.records[i].type_id for i in ("t1", "t2")} == {"fault"}
    panel.fields["method"].setCurrentIndex(panel.fields["method"].findData("regression"))
    panel.fields["method"].activated.emit(panel.fields["method"].currentIndex())
    assert studio.records["t1"].method == "regression"
    for _ in range(5):
        studio.undo()
    assert studio.records["t1"] == studio.session.of(Trace)[0]
    assert not studio.records["t1"].overturned


def test_typed_name_applies_to_its_plane_after_the_selection_changes(window, studio):
    """Leaving the field by a click on another row ends the typing after the selection moved."""
    add_cliff(studio)
    add_bed(studio, "t1", "a")
    add_bed(studio, "t2", "b")
    studio.selection.set(["t1"])
    field = window.properties.fields["name"]
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, "typed")
    studio.selection.set(["t2"])
    window.table.view.setFocus()
    assert studio.records["t2"].name == "b"
    assert studio.records["t1"].name == "typed"


# --- notation ------------------------------------------------------------------------------
def test_notation_applies_to_all_views(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1", dip=1.0)
    studio.selection.set(["t1"])

    def places() -> set[str]:
        return {
            shown(window, "Orientation")[0],
            window.tree._items["t1"].text(1),
            window.properties._fit._plane.text(),
        }

    found = {}
    for name in ("notation_strike", "notation_quadrant", "notation_dipdir"):
        window.actions_table.all[name].trigger()
        assert window.actions_table.all[name].isChecked()
        (found[name],) = places()
    assert len(set(found.values())) == 3
    assert found["notation_quadrant"][0] in "NS"
    assert window.actions_table.all["notation_strike"].isChecked() is False


# --- typed numbers -----------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1.5", 1.5),
        ("1,5", 1.5),
        (" 1 234,5 ", 1234.5),
        ("372 410,115", 372410.115),
        ("372\N{NARROW NO-BREAK SPACE}410.115", 372410.115),
        ("1,234.5", 1234.5),
        ("1.234,5", 1234.5),
        ("372.410,115", 372410.115),
        ("4.709.820,240", 4709820.24),
        ("4,709,820.240", 4709820.24),
        ("4’709’820.24", 4709820.24),
        ("-0,5", -0.5),
        ("−0,5", -0.5),
        ("1e3", 1000.0),
        ("", None),
        ("abc", None),
        ("nan", None),
        ("inf", None),
        ("1,2,3", None),
        ("1.2.3", None),
        ("--1", None),
    ],
)
def test_numbers_are_read_with_either_decimal_mark(text, value):
    assert parse_number(text) == value


@pytest.mark.parametrize(
    "language", first_in_default_tier(["de_DE", "en_US", "fr_FR", "de_CH", "C"])
)
def test_vertex_coordinates_are_read_back_in_any_locale(window, studio, language):
    add_cliff(studio)
    trace = add_bed(
        studio,
        "t1",
        vertices=tuple(
            (372410.115 + x, 4709820.24 + y, x + 0.3 * y)
            for x, y in ((0, 0), (1, 2), (3, 1), (4, 4))
        ),
    )
    before = QLocale()
    QLocale.setDefault(QLocale(language))
    try:
        studio.activate("trace")
        studio.get_tool(TraceTool).continue_feature("t1")
        table = driver.tool_panel(window, TracePanel).table
        for row in range(4):
            for col in range(3):
                assert parse_number(table.item(row, col).text()) == pytest.approx(
                    trace.vertices[row][col], abs=5e-4
                )
        table.item(1, 0).setText(table.item(1, 0).text()[:-1] + "9")
        assert studio.get_tool(TraceTool).vertices[1][0] == pytest.approx(372411.119, abs=1e-6)
        table.item(1, 0).setText("here")
        assert "not a number" in studio.notices[-1].text
        assert studio.get_tool(TraceTool).vertices[1][0] == pytest.approx(372411.119, abs=1e-6)
    finally:
        QLocale.setDefault(before)


# --- the journal comes first ---------------------------------------------------------------------
def test_failed_journal_write_leaves_all_views_unchanged(window, studio, monkeypatch):
    add_cliff(studio)
    add_bed(studio, "t1", "first")
    studio.selection.set(["t1"])

    def look() -> tuple:
        return (
            shown(window),
            shown(window, "Set"),
            window.tree._items["t1"].text(0),
            window.properties.fields["name"].text(),
            window.windowTitle(),
            dict(studio.records),
            window.table.model.rowCount(),
        )

    before = look()
    real = studio.project.journal.append

    def full(*args, **values):
        raise DocumentError(Finding("journal.not-written", reason="disk full"))

    monkeypatch.setattr(studio.project.journal, "append", full)
    model = window.table.model
    for do in (
        lambda: model.setData(model.index(0, 0), "other"),
        lambda: type_into(window.properties.fields["name"], "other"),
        lambda: window.tree._items["t1"].setText(0, "other"),
        lambda: window.actions_table.run("delete"),
        studio.undo,
        lambda: window.files.save() if not studio.project.is_untitled else studio.session,
    ):
        studio.notices.clear()
        do()
        assert look() == before
    assert window.message_bar.notice.code == "journal.not-written"
    monkeypatch.setattr(studio.project.journal, "append", real)
    window.actions_table.run("delete")
    assert window.table.model.rowCount() == 0


def test_edit_is_journalled_before_the_views_are_notified(window, studio):
    add_cliff(studio)
    rows_at_signal = []

    def note(edit) -> None:
        row = list(studio.project.journal.rows())[-1]
        rows_at_signal.append((row.kind, row.label == edit.label))

    studio.edited.connect(note)
    add_bed(studio, "t1", "first")
    studio.attempt(edits.delete, ["t1"])
    studio.undo()
    assert rows_at_signal == [("do", True), ("do", True), ("undo", True)]


# --- trace panel ---------------------------------------------------------------------------------
def test_the_trace_panel_shows_the_type_and_set_of_the_open_trace(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1", "main", type_id="fault", set_name="F")
    panel = driver.tool_panel(window, TracePanel)
    assert panel.type_box.currentData() == "bedding"
    studio.activate("trace")
    studio.get_tool(TraceTool).continue_feature("t1")
    assert panel.type_box.currentData() == "fault"
    assert panel.set_name_edit.text() == "F"
    assert not panel.type_box.isEnabled()
    assert "Not now" in panel.type_box.toolTip()
    studio.get_tool(TraceTool).cancel()
    assert panel.type_box.currentData() == "bedding"
    assert panel.set_name_edit.text() == ""
    assert panel.type_box.isEnabled()


def test_typing_a_set_for_a_restored_trace_keeps_its_type(window, studio, tmp_path):
    """The panel must speak of the trace that is back, not of what was chosen before."""
    from tests.samples import ZIGZAG
    from tests.studio.tools.fakes import event

    add_cliff(studio)
    studio.activate("trace")
    studio.set_next_type("fault", "F")
    for point in ZIGZAG[:3]:
        studio.pointer(event(at=point))
    studio.save_as(tmp_path / "p.vom")
    studio.new_project()
    studio.set_next_type("bedding", "")
    studio.open_project(tmp_path / "p.vom")
    assert studio.get_tool(TraceTool).trace.type_id == "fault"
    assert driver.tool_panel(window, TracePanel).type_box.currentData() == "fault"
    type_into(driver.tool_panel(window, TracePanel).set_name_edit, "G")
    assert (
        studio.get_tool(TraceTool).trace.type_id,
        studio.get_tool(TraceTool).trace.set_name,
    ) == (
        "fault",
        "G",
    )


def test_unreadable_draft_is_reported(window, studio, tmp_path):
    add_cliff(studio)
    studio.session.set_draft({"tool": "trace", "vertices": "nonsense"})
    studio.save_as(tmp_path / "p.vom")
    studio.new_project()
    studio.open_project(tmp_path / "p.vom")
    assert "tool.draft-unreadable" in [notice.code for notice in studio.notices]
    assert not studio.get_tool(TraceTool).is_open


def test_long_text_in_the_status_line_does_not_widen_the_window(window) -> None:
    before = window.width()
    window.status_line._job.setText("Orthophoto of a long name: casting rays, 6 of 6 " * 4)
    window.status_line._job.show()
    window.status_line._hint.setText("what the next click does, at length " * 10)
    QApplication.processEvents()
    assert window.width() == before
    assert window.minimumSizeHint().width() <= before


def test_long_status_message_does_not_overlap_the_other_status_fields(window) -> None:
    line = window.status_line
    line._position.setText("E 372 419.990  N 4 709 815.817  Z 613.642 m")
    words = "The orthophoto was written to /a/folder/with/a/long/name" * 6 + "/view.tif."
    window.resize(1000, 700)
    line.showMessage(words)
    QApplication.processEvents()
    assert line.currentMessage() == line.toolTip() == words
    room = line._message_area()
    assert room.right() < line._position.x()
    picture = line.grab().toImage()
    blank = picture.pixelColor(room.right() + 4, line.height() // 2)
    scale = picture.devicePixelRatio()
    for x in range(int((room.right() + 2) * scale), int((line._position.x() - 1) * scale)):
        for y in range(4, picture.height() - 4):
            assert picture.pixelColor(x, y) == blank, (x, y)
    line.clearMessage()
    assert line.toolTip() == ""


def test_other_tool_pages_do_not_make_the_tool_list_scroll(window):
    panel = window.tool_panel
    choice = panel.currentWidget()
    high = max(page.minimumSizeHint().height() for page in panel.panels.values())
    assert panel.sizeHint().height() < high
    assert panel.minimumSizeHint().height() <= choice.minimumSizeHint().height()
