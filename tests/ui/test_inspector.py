"""The inspector shows one number, one reason and one action; the rest is folded."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest

from tests import driver
from tests.tiers import first_in_default_tier
from tests.ui.conftest import add_bed, add_cliff
from vomstudio.geology.notation import format_attitude
from vomstudio.project import edits
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.kinds.reading import Reading
from vomstudio.ui.base import theme
from vomstudio.ui.panels.tools.line import LinePanel
from vomstudio.ui.panels.tools.trace import TracePanel

CTRL = Qt.KeyboardModifier.ControlModifier
_NOISE = np.random.default_rng(0).normal(0.0, 0.02, (12, 3))
STRAIGHT = tuple(map(tuple, (np.outer(np.arange(12), [0.4, 0.0, 0.3]) + _NOISE).tolist()))


@pytest.fixture
def poor(window, studio):
    add_cliff(studio)
    trace = add_bed(studio, "t1", vertices=STRAIGHT)
    window.docks.bring_forward("properties")
    studio.selection.set([trace.id])
    driver.pause(20)
    return studio.measured([trace.id])[trace.id]


# --- one number --------------------------------------------------------------------------------
def test_plane_is_shown_by_attitude_error_and_verdict_mark(window, studio, poor):
    fit = window.properties._fit
    assert fit._plane.text() == format_attitude(poor.plane, poor.total95_deg)
    assert fit._verdict.text() == poor.verdict.quality == "poor"
    assert not fit._badge.pixmap().isNull()


def test_details_are_folded_by_default_and_stay_unfolded(window, studio, poor):
    fit = window.properties._fit
    assert not any(value.isVisible() for value in fit._values)
    QTest.mouseClick(fit.details, Qt.MouseButton.LeftButton)
    shown = [title.text() for title in fit._titles if title.isVisible()]
    assert {"95 % error", "M / K", "Copl. / coll.", "Extent / RMS"} <= set(shown)
    add_bed(studio, "t2", dip=1.0)
    studio.selection.set(["t2"])
    assert any(value.isVisible() for value in fit._values)
    QTest.mouseClick(fit.details, Qt.MouseButton.LeftButton)
    assert not any(value.isVisible() for value in fit._values)


@pytest.mark.full
@pytest.mark.parametrize("name", ["light", "dark"])
def test_the_buttons_that_unfold_are_readable_in_both_themes(window, studio, poor, name):
    try:
        theme.use(name)
        driver.pause(100)
        for button in (window.properties._fit.details, window.properties._fit.more):
            picture = button.grab().toImage()
            levels = [
                picture.pixelColor(x, y).lightness()
                for x in range(picture.width())
                for y in range(picture.height())
            ]
            assert max(levels) - min(levels) > 120
    finally:
        theme.use("system")


def test_first_reason_has_a_button_for_its_remedy(window, studio, poor):
    fit = window.properties._fit
    first = poor.verdict.reasons[0]
    assert first.code == "plane.too-straight"
    assert fit._reason.isVisible()
    assert len(fit._reason.text()) < len(first.message)
    assert fit._reason.toolTip() == first.message
    assert fit.remedy.isVisible()
    QTest.mouseClick(fit.remedy, Qt.MouseButton.LeftButton)
    assert studio.tool_name == "trace"
    assert studio.open_tool.is_continued
    # The action cannot run while the trace is open.
    driver.wait(lambda: not fit.remedy.isVisible(), "the button to go")


def test_further_reasons_unfold_in_place(window, studio):
    add_cliff(studio)
    trace = add_bed(studio, "t1", vertices=STRAIGHT)
    studio.attempt(edits.change_feature, trace.replace_fields(resolution=0.8))
    studio.selection.set(["t1"])
    window.docks.bring_forward("properties")
    reasons = studio.measured(["t1"])["t1"].verdict.reasons
    assert len(reasons) > 1
    fit = window.properties._fit
    assert str(len(reasons) - 1) in fit.more.text()
    assert not fit._reasons.isVisible()
    QTest.mouseClick(fit.more, Qt.MouseButton.LeftButton)
    assert fit._reasons.isVisible()
    assert all(reason.message in fit._reasons.text() for reason in reasons)


def test_good_plane_shows_no_reason(window, studio):
    add_cliff(studio)
    points = tuple((float(x), float(y), 0.4 * x) for x in range(4) for y in range(4))
    add_bed(studio, "t1", vertices=points)
    studio.selection.set(["t1"])
    fit = window.properties._fit
    assert fit._verdict.text() == "good"
    assert fit._reason.isHidden()
    assert fit.more.isHidden()
    assert fit.remedy.isHidden()


def test_reasons_unfold_in_the_panel_of_a_tool(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1", vertices=STRAIGHT)
    studio.selection.set(["t1"])
    window.actions_table.run("edit_feature")
    fit = driver.tool_panel(window, TracePanel).fit_view
    assert fit._reason.text()
    assert fit.remedy.isHidden()
    fit.more.click()
    assert not fit._reasons.isHidden()


# --- names, notes, sets ------------------------------------------------------------------------
def test_a_changed_type_offers_the_next_name_of_the_type(window, studio):
    add_cliff(studio)
    add_bed(studio, "j1", type_id="joint")
    vein = add_bed(studio, "v1", type_id="vein")
    assert vein.name == "V01"
    studio.selection.set(["v1"])
    rename = window.properties.rename
    assert rename.isHidden()
    studio.attempt(edits.set_attributes, ["v1"], type_id="joint")
    assert not rename.isHidden()
    assert "J02" in rename.text()
    rename.click()
    assert studio.records["v1"].name == "J02"
    assert rename.isHidden()
    studio.undo()
    assert studio.records["v1"].name == "V01"


@pytest.mark.parametrize("name", first_in_default_tier(["Main fault", "Q07", "J01", "V1a"]))
def test_no_rename_is_offered_for_a_user_defined_name(window, studio, name):
    add_cliff(studio)
    add_bed(studio, "v1", name, type_id="joint")
    studio.selection.set(["v1"])
    assert window.properties.rename.isHidden()


def test_several_features_are_renamed_in_one_step(window, studio):
    add_cliff(studio)
    for number in range(3):
        add_bed(studio, f"v{number}", dip=0.2 + number, type_id="vein")
    studio.selection.set(["v0", "v1", "v2"])
    studio.attempt(edits.set_attributes, ["v0", "v1", "v2"], type_id="joint")
    window.properties.rename.click()
    assert [studio.records[f"v{n}"].name for n in range(3)] == ["J01", "J02", "J03"]


def test_notes_can_have_several_lines(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1")
    studio.selection.set(["t1"])
    window.docks.bring_forward("properties")
    notes = window.properties.fields["notes"]
    notes.setFocus()
    QTest.keyClicks(notes, "base of the bed")
    QTest.keyClick(notes, Qt.Key.Key_Return)
    QTest.keyClicks(notes, "below the scree")
    QTest.keyClick(notes, Qt.Key.Key_Return, CTRL)
    assert studio.records["t1"].notes == "base of the bed\nbelow the scree"
    studio.undo()
    assert notes.text() == ""


def test_a_typed_set_is_remembered_for_its_type(window, studio):
    panel = driver.tool_panel(window, TracePanel)
    add_cliff(studio)
    studio.activate("trace")

    def choose(type_id: str) -> str:
        panel.type_box.setCurrentIndex(panel.type_box.findData(type_id))
        return panel.set_name_edit.text()

    choose("bedding")
    panel.set_name_edit.setFocus()
    QTest.keyClicks(panel.set_name_edit, "east")
    QTest.keyClick(panel.set_name_edit, Qt.Key.Key_Return)
    assert studio.next_set == "east"
    assert choose("joint") == ""
    QTest.keyClicks(panel.set_name_edit, "J1")
    QTest.keyClick(panel.set_name_edit, Qt.Key.Key_Return)
    assert choose("bedding") == "east"
    assert choose("joint") == "J1"
    studio.new_project()
    assert studio.next_set == ""


def test_line_tool_remembers_the_set_of_each_type(window, studio):
    panel = driver.tool_panel(window, LinePanel)
    add_cliff(studio)
    tool = panel._tool
    tool.choose(type_id="lineation", set_name="L1")
    tool.choose(type_id="fold_axis", set_name="L1")
    assert tool.next_line.set_name == ""
    tool.choose(type_id="lineation", set_name="")
    assert tool.next_line.set_name == "L1"


def test_plane_list_of_a_line_starts_with_the_nearest_fault(window, studio):
    add_cliff(studio)
    for id_, type_id, x in (
        ("b1", "bedding", 0.0),
        ("f1", "fault", 30.0),
        ("f2", "fault", 5.0),
        ("j1", "joint", 1.0),
    ):
        corners = ((0, 0, 0), (1, 0, 0.3), (0, 1, 0.4), (1, 1, 0.8))
        points = tuple((a + x, float(b), float(c)) for a, b, c in corners)
        add_bed(studio, id_, type_id=type_id, vertices=points)
    line = Lineation("l1", "L01", "lineation", "m1", "0" * 64, ((0.0, 0, 0), (1.0, 0, 0.3)))
    assert studio.attempt(edits.add_features, [line])
    studio.selection.set(["l1"])
    box = window.properties.fields["plane_id"]
    assert box._sorted_planes() == ["f2", "f1", "b1", "j1"]
    box.showPopup()
    ids = [box.itemData(i) for i in range(box.count())]
    box.hidePopup()
    assert ids[-4:] == ["f2", "f1", "b1", "j1"]


# --- selection ---------------------------------------------------------------------------------
def test_select_all_in_a_filtered_table_takes_visible_rows_only(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1")
    add_bed(studio, "j1", type_id="joint", dip=1.0)
    assert studio.attempt(
        edits.add_features, [Reading("r1", "R1", "joint", "plane", 10.0, 20.0, station="KB-17")]
    )
    window.docks.bring_forward("table")
    window.table._filter.setText("type:joint")
    window.table.view.setFocus()
    driver.wait(window.table.view.hasFocus, "the focus of the table")
    QTest.keyClick(window.table.view, Qt.Key.Key_A, CTRL)
    assert set(studio.selection.ids) == {"j1", "r1"}
    window.table._filter.setText("station:kb")
    window.actions_table.run("select_all")
    assert studio.selection.ids == ("r1",)
    window.table._filter.setText("")
    window.actions_table.run("select_all")
    assert set(studio.selection.ids) == {"t1", "j1", "r1"}


def test_a_filter_finds_the_domain(window, studio):
    add_cliff(studio)
    add_bed(studio, "t1")
    studio.attempt(edits.set_attributes, ["t1"], domain="footwall")
    window.table._filter.setText("domain:foot")
    assert window.table._sorted_rows.rowCount() == 1
    window.table._filter.setText("domain:hanging")
    assert window.table._sorted_rows.rowCount() == 0
