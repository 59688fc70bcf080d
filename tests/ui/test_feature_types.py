"""Feature types: the dialog, the tree's menus and drags, and what follows from them."""

from __future__ import annotations

import pytest
from PySide6.QtCore import QMimeData, QPoint, QPointF, Qt
from PySide6.QtGui import QDragEnterEvent, QDragMoveEvent, QDropEvent
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tests import appearance, driver
from tests.driver import click
from tests.messages import shown_codes, shown_values
from tests.ui.conftest import add_bed, add_cliff
from vomstudio.project import edits
from vomstudio.project.records import DEFAULT_TYPES, FeatureType
from vomstudio.ui.base import theme
from vomstudio.ui.dialogs.feature_types_dialog import TypesDialog
from vomstudio.ui.panels.tools.line import LinePanel
from vomstudio.ui.panels.tools.plane import PlanePanel
from vomstudio.ui.panels.tools.trace import TracePanel

LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def dialog(window, studio):
    add_cliff(studio)
    window.actions_table.run("feature_types")
    (made,) = [d for d in window.findChildren(TypesDialog) if d.isVisible()]
    QApplication.processEvents()
    yield made
    made.close()


def press(button) -> None:
    click(button, button.rect().center())
    QApplication.processEvents()


def type_name(dialog, text: str) -> None:
    dialog.name.setFocus()
    dialog.name.selectAll()
    QTest.keyClicks(dialog.name, text)
    QTest.keyClick(dialog.name, Qt.Key.Key_Return)
    QApplication.processEvents()


def kinds(studio) -> dict[str, FeatureType]:
    return {kind.name: kind for kind in studio.session.of(FeatureType)}


def combos(window) -> list[list[str]]:
    return [
        [box.itemText(i) for i in range(box.count())]
        for box in (
            driver.tool_panel(window, TracePanel).type_box,
            driver.tool_panel(window, PlanePanel).type_box,
            window.properties.fields["type_id"],
        )
    ]


# --- the dialog ----------------------------------------------------------------------------------
def test_type_can_be_added_named_coloured_used_and_undone(window, studio, dialog):
    before = len(kinds(studio))
    press(dialog.add_button)
    type_name(dialog, "Shear zone")
    press(dialog.colors["#e69f00"])
    dialog.symbol.setCurrentIndex(dialog.symbol.findData("diamond"))
    dialog.symbol.activated.emit(dialog.symbol.currentIndex())
    made = kinds(studio)["Shear zone"]
    assert (made.color, made.symbol, made.geometry) == ("#e69f00", "diamond", "plane")
    assert all("Shear zone" in names for names in combos(window))
    assert dialog.list.currentItem().text() == "Shear zone"
    for _ in range(4):
        studio.undo()
    assert len(kinds(studio)) == before
    assert not any("Shear zone" in names for names in combos(window))


def test_return_in_the_name_does_not_close_the_dialog_or_press_a_button(studio, dialog):
    before = len(kinds(studio))
    type_name(dialog, "Strata")
    assert dialog.isVisible()
    assert len(kinds(studio)) == before
    assert "Strata" in kinds(studio)


def test_type_in_use_cannot_be_removed(studio, dialog):
    add_bed(studio, "t1", type_id="fault")
    dialog.select("fault")
    press(dialog.remove_button)
    assert "Fault" in kinds(studio)
    assert shown_values(dialog.message.text(), "type.in-use") == {"count": "1", "type": "Fault"}
    studio.attempt(edits.set_attributes, ["t1"], type_id="joint")
    dialog.select("fault")
    press(dialog.remove_button)
    assert "Fault" not in kinds(studio)


@pytest.mark.full
def test_existing_type_name_is_rejected_and_the_old_name_kept(studio, dialog):
    dialog.select("joint")
    type_name(dialog, "fault")
    assert "name.taken" in shown_codes(dialog.message.text())
    assert dialog.name.text() == "Joint"
    assert "Joint" in kinds(studio)


def test_new_types_differ_from_existing_ones_in_colour_and_symbol(studio, dialog):
    for _ in range(4):
        press(dialog.add_button)
    looks = [(kind.color, kind.symbol) for kind in studio.session.of(FeatureType)]
    assert len(set(looks)) == len(looks)


def test_the_dialog_opens_once(window, studio, dialog):
    window.actions_table.run("feature_types")
    assert len([d for d in window.findChildren(TypesDialog) if d.isVisible()]) == 1


# --- old projects --------------------------------------------------------------------------------
def test_project_without_line_types_opens_and_can_add_them(window, studio, tmp_path):
    add_cliff(studio)
    add_bed(studio, "t1")
    for type_id in ("fold_axis", "lineation"):
        assert studio.attempt(edits.remove_type, type_id)
    studio.set_next_type("lineation", "")
    studio.save_as(tmp_path / "old.vom")
    studio.new_project()
    studio.open_project(tmp_path / "old.vom")
    assert "Lineation" not in kinds(studio)
    assert studio.next_type_id in studio.records
    assert window.tree._items["bedding"].text(0) == "Bedding (1)"
    lineation = next(kind for kind in DEFAULT_TYPES if kind.id == "lineation")
    assert studio.attempt(edits.add_type, lineation)
    lines = driver.tool_panel(window, LinePanel).type_box
    assert lines.findText("Lineation") >= 0


def test_removing_the_next_type_selects_another(studio):
    add_cliff(studio)
    studio.set_next_type("vein", "")
    assert studio.attempt(edits.remove_type, "vein")
    assert studio.next_type_id in studio.records


# --- combos follow -------------------------------------------------------------------------------
def test_names_and_colours_of_types_change_everywhere_at_once(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1")
    studio.set_next_type("fault", "")
    studio.selection.set(["t1"])
    kind = studio.records["bedding"]
    from dataclasses import replace

    assert studio.attempt(edits.change_type, replace(kind, name="Strata", color="#123456"))
    assert all("Strata" in names and "Bedding" not in names for names in combos(window))
    assert driver.tool_panel(window, TracePanel).type_box.currentData() == "fault"
    assert window.properties.fields["type_id"].currentData() == "bedding"
    assert window.tree._items["bedding"].text(0) == "Strata (1)"
    model = window.table.model
    texts = [model.index(0, c).data() for c in range(model.columnCount())]
    assert "Strata" in texts


# --- the tree ------------------------------------------------------------------------------------
def drop(tree, ids: list[str], onto: str) -> bool:
    """The events of a drag of the selected rows."""
    view = tree.tree
    data = QMimeData()
    data.setData("application/x-vomstudio-features", b"")
    at = view.visualItemRect(tree._items[onto]).center()
    move, none = Qt.DropAction.CopyAction, Qt.KeyboardModifier.NoModifier
    enter = QDragEnterEvent(at, move, data, LEFT, none)
    QApplication.sendEvent(view.viewport(), enter)
    over = QDragMoveEvent(at, move, data, LEFT, none)
    QApplication.sendEvent(view.viewport(), over)
    taken = over.isAccepted()
    if taken:
        QApplication.sendEvent(view.viewport(), QDropEvent(QPointF(at), move, data, LEFT, none))
    return taken


def test_features_dropped_onto_another_type_change_in_one_edit(window, studio):
    add_cliff(studio)
    for i in range(3):
        add_bed(studio, f"t{i}")
    add_bed(studio, "f1", type_id="fault")
    tree = window.tree
    studio.selection.set(["t0", "t2"])
    assert drop(tree, ["t0", "t2"], "fault")
    assert [studio.records[f"t{i}"].type_id for i in range(3)] == ["fault", "bedding", "fault"]
    assert tree._items["t0"].parent() is tree._items["fault"]
    assert studio.selection.ids == ("t0", "t2")
    studio.undo()
    assert studio.records["t0"].type_id == studio.records["t2"].type_id == "bedding"
    # A feature stands for its type.
    studio.selection.set(["t1"])
    assert drop(tree, ["t1"], "f1")
    assert studio.records["t1"].type_id == "fault"
    assert not drop(tree, ["t1"], "m1")


def test_empty_types_are_shown_on_demand_and_can_become_the_next_type(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1")
    tree = window.tree
    assert tree._items["vein"].isHidden()
    click(tree.empty_types_button, tree.empty_types_button.rect().center())
    assert not tree._items["vein"].isHidden()
    menu = tree.create_menu("vein")
    next(a for a in menu.actions() if a.text() == "Use for &next").trigger()
    assert studio.next_type_id == "vein"
    assert driver.tool_panel(window, TracePanel).type_box.currentData() == "vein"
    assert tree._items["vein"].font(0).bold()
    assert not tree._items["bedding"].font(0).bold()


def test_the_menu_of_a_type_changes_its_colour_and_refuses_to_remove_it(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1")
    menu = window.tree.create_menu("bedding")
    by_text = {a.text(): a for a in menu.actions()}
    colors = {a.text(): a for a in by_text["&Colour"].menu().actions()}
    colors["Orange"].trigger()
    assert studio.records["bedding"].color == "#e69f00"
    by_text["Re&move type"].trigger()
    assert studio.notices[-1].code == "type.in-use"
    by_text["&Select its features"].trigger()
    assert studio.selection.ids == ("t1",)


def test_hide_show_only_and_show_all_commands_set_visibility(window, studio):
    add_cliff(studio)
    for i in range(3):
        add_bed(studio, f"t{i}")
    add_bed(studio, "f1", type_id="fault")
    studio.set_visible(["fault"], False)
    studio.selection.set(["t0", "f1"])
    window.actions_table.run("show_only")
    assert {i for i in ("t0", "t1", "t2", "f1", "fault") if studio.visible(i)} == {
        "t0",
        "f1",
        "fault",
    }
    assert window.tree._items["t1"].checkState(0) == Qt.CheckState.Unchecked
    assert window.tree._items["fault"].checkState(0) == Qt.CheckState.Checked
    window.actions_table.run("hide_chosen")
    assert not studio.visible("t0")
    window.actions_table.run("show_all")
    assert all(studio.visible(i) for i in ("t0", "t1", "t2", "f1", "fault"))


def test_tree_shows_sets_overturned_beds_and_notes(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1", "plain")
    assert window.tree.tree.isColumnHidden(2)
    add_bed(studio, "t2", "upper", set_name="limb A", notes="covered by scree", overturned=True)
    item = window.tree._items["t2"]
    assert not window.tree.tree.isColumnHidden(2)
    assert item.text(2) == "limb A"
    assert studio.records["t2"].notes in item.toolTip(0)
    assert "Overturned" in item.toolTip(1)
    verdict = studio.measured(["t2"])["t2"].verdict
    findings = {each.code for each in (*verdict.reasons, *verdict.notes)}
    assert findings
    assert shown_codes(item.toolTip(1)) == findings
    assert item.text(1) != window.tree._items["t1"].text(1)
    item.setText(2, "limb B")
    assert studio.records["t2"].set_name == "limb B"


def test_names_are_not_truncated_by_sets_in_a_narrow_inspector(window, studio):
    window.resize(960, 540)
    add_cliff(studio)
    add_bed(studio, "t1", "upper bed")
    driver.pause(200)
    assert appearance.cut_off(window.tree) == []
    add_bed(studio, "t2", "lower bed", set_name="limb A")
    driver.pause(0)
    assert appearance.cut_off(window.tree) == []


def test_every_symbol_looks_different(window):
    pictures = {
        theme.type_icon("#0072b2", symbol).pixmap(32, 32).toImage().constBits().tobytes()
        for symbol in theme.SYMBOLS
    }
    assert len(pictures) == len(theme.SYMBOLS)


# --- the table -----------------------------------------------------------------------------------
def test_selected_rows_are_copied_in_displayed_order(window, studio):
    add_cliff(studio)
    for name in ("c", "a", "b"):
        add_bed(studio, name, name, set_name="limb\tA")
    window.docks.bring_forward("table")
    table = window.table
    studio.selection.set(["c", "a"])
    table.view.setFocus()
    QTest.keyClick(table.view, Qt.Key.Key_C, Qt.KeyboardModifier.ControlModifier)
    lines = QApplication.clipboard().text().splitlines()
    rows = [line.split("\t") for line in lines]
    assert rows[0][:3] == ["Name", "Type", "Set"]
    assert [row[0] for row in rows[1:]] == ["a", "c"]
    assert rows[1][2] == "limb A"
    assert len({len(row) for row in rows}) == 1


def test_copied_cells_are_plain_numbers_with_two_columns_for_attitudes(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1", "a")
    table = window.table
    studio.selection.set(["t1"])
    fit = studio.measured(["t1"])["t1"].fit
    wanted = {
        "dipdir/dip": ("Dip direction (°)", fit.dip_direction_deg),
        "strike/dip": ("Strike (°)", (fit.dip_direction_deg - 90.0) % 360.0),
    }
    for notation, (title, azimuth) in wanted.items():
        studio.settings.notation = notation
        studio.keep_settings()
        studio.selection.set(["t1"])
        table.copy_rows()
        head, cells = (x.split("\t") for x in QApplication.clipboard().text().splitlines())
        found = dict(zip(head, cells, strict=True))
        assert float(found[title]) == pytest.approx(azimuth, abs=0.006)
        assert float(found["Dip (°)"]) == pytest.approx(fit.dip_deg, abs=0.006)
        assert float(found["Extent (m)"]) == pytest.approx(fit.extent, rel=1e-5)
        assert float(found["Fit max (°)"]) == pytest.approx(fit.max_confidence95_deg, abs=0.006)
        assert found["RMS (m)"] == f"{fit.rms:.6g}"
        assert "Orientation" not in found


def test_hidden_columns_stay_hidden_and_are_not_copied(window, studio):
    from vomstudio.io.settings import DETAIL_COLUMNS, read_settings
    from vomstudio.ui.panels.features.table_panel import COLUMNS

    add_cliff(studio)
    add_bed(studio, "t1", "a")
    menu = window.table.create_column_menu()
    next(a for a in menu.actions() if a.text() == "Set").trigger()
    place = next(i for i, c in enumerate(COLUMNS) if c.title == "Set")
    assert window.table.view.isColumnHidden(place)
    assert read_settings()[0].hidden_columns == [*DETAIL_COLUMNS, "Set"]
    studio.selection.set(["t1"])
    window.table.copy_rows()
    assert "Set" not in QApplication.clipboard().text().splitlines()[0].split("\t")
    window.table.create_column_menu().actions()[-1].trigger()
    assert not window.table.view.isColumnHidden(place)


def test_overturned_flag_is_edited_in_the_table(window, studio):
    from vomstudio.ui.panels.features.table_panel import COLUMNS

    add_cliff(studio)
    add_bed(studio, "t1", "a")
    view = window.table.view
    place = next(i for i, c in enumerate(COLUMNS) if c.title == "Overturned")
    index = window.table._sorted_rows.index(0, place)
    view.scrollTo(index)
    QApplication.processEvents()
    box = view.visualRect(index)
    click(view.viewport(), QPoint(box.left() + 10, box.center().y()))
    assert studio.records["t1"].overturned
    assert index.data(Qt.ItemDataRole.CheckStateRole) == Qt.CheckState.Checked
    studio.undo()
    assert not studio.records["t1"].overturned
