"""Panels of the line and measure tools, and how planes lie to each other."""

from __future__ import annotations

import re

import numpy as np
import pytest
from PySide6.QtCore import Qt
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QApplication

from tests import driver
from tests.messages import figures, shown_codes
from tests.studio.tools.fakes import event
from tests.ui.conftest import add_bed, add_cliff
from vomstudio.geology.notation import format_error_deg
from vomstudio.geometry.frames import Frame
from vomstudio.project import edits
from vomstudio.project.kinds.dimension import Dimension
from vomstudio.project.kinds.intersection import Intersection
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.studio.tools.line import LineTool
from vomstudio.studio.tools.measure import MeasureTool
from vomstudio.ui.panels.features.plane_relations import IntersectionDialog
from vomstudio.ui.panels.features.table_panel import COLUMNS
from vomstudio.ui.panels.tools.line import LinePanel
from vomstudio.ui.panels.tools.measure import MeasurePanel
from vomstudio.ui.widgets.plane_box import SELECTED

FACE = ((0.0, 0.0, 0.0), (1.0, 2.0, 0.2), (0.4, 4.0, 0.1), (2.0, 5.0, 1.0), (3.0, 1.0, 2.0))


def choose(box, data) -> None:
    """As a person does: the popup, then an entry."""
    box.showPopup()
    box.setCurrentIndex(box.findData(data))
    box.activated.emit(box.currentIndex())
    box.hidePopup()


def click(studio, *points) -> None:
    for point in points:
        studio.pointer(event(at=point))


@pytest.fixture
def planes(window, studio):
    add_cliff(studio)
    add_bed(studio, "b1", "B01", dip=0.3)
    add_bed(studio, "b2", "B02", dip=0.4, set_name="upper")
    add_bed(studio, "f1", "F01", dip=2.5, type_id="fault", vertices=FACE)
    # The window's commands ask for a model whose data are there; the tools do not.
    return studio


# --- line ----------------------------------------------------------------------------------------
def test_line_panel_offers_only_line_types(window, planes):
    box = driver.tool_panel(window, LinePanel).type_box
    names = [box.itemText(i) for i in range(box.count())]
    assert names == ["Fold axis", "Lineation"]
    assert box.currentText() == "Lineation"
    planes.set_next_type("joint", "J1")
    assert box.currentText() == "Lineation"


@pytest.mark.full
def test_slip_is_disabled_with_a_reason_until_a_plane_is_selected(window, planes):
    panel = driver.tool_panel(window, LinePanel)
    assert not panel.slip_box.isEnabled()
    assert "slip.no-plane" in shown_codes(panel.slip_box.toolTip())
    choose(panel.plane_box, "f1")
    assert panel.slip_box.isEnabled()
    choose(panel.slip_box, "normal")
    planes.activate("line")
    click(planes, (0, 0, 0), (1, 0.5, 1.0), (2, 1.1, 2.0))
    assert panel.fit_view._plane.text() != "–"
    assert "Rake" in panel.fit_view._details.text()
    planes.finish_tool()
    (made,) = planes.session.of(Lineation)
    assert (made.plane_id, made.slip) == ("f1", "normal")
    assert planes.selection.ids == (made.id,)
    column = next(i for i, c in enumerate(COLUMNS) if c.title == "Slip rake")
    model = window.table._sorted_rows
    rows = {
        model.index(r, 0).data(): model.index(r, column).data() for r in range(model.rowCount())
    }
    assert rows[made.name].startswith("-")
    assert rows["B01"] == "–"
    choose(panel.plane_box, "")
    assert not panel.slip_box.isEnabled()
    assert planes.get_tool(LineTool).next_line.slip == ""


@pytest.mark.full
def test_line_plane_follows_the_selection_and_stays_after_finishing(window, planes):
    panel = driver.tool_panel(window, LinePanel)
    planes.selection.set(["f1"])
    assert planes.get_tool(LineTool).next_line.plane_id == "", "not before it is asked for"
    choose(panel.plane_box, SELECTED)
    assert planes.get_tool(LineTool).next_line.plane_id == "f1"
    planes.selection.set(["b2"])
    assert planes.get_tool(LineTool).next_line.plane_id == "b2"
    assert "B02" in panel.plane_box.currentText()
    planes.activate("line")
    click(planes, (0, 0, 0), (1, 0.5, 1.0))
    planes.finish_tool()
    assert planes.get_tool(LineTool).next_line.plane_id == "b2", (
        "the made line is selected, the plane stays"
    )
    choose(panel.plane_box, "f1")
    planes.selection.set(["b1"])
    assert planes.get_tool(LineTool).next_line.plane_id == "f1", (
        "chosen by name: the selection does not matter"
    )
    choose(panel.plane_box, SELECTED)
    assert planes.get_tool(LineTool).next_line.plane_id == "b1"
    planes.selection.set(["b1"])
    planes.attempt(edits.delete, ["b1"])
    assert planes.get_tool(LineTool).next_line.plane_id == ""


def test_plane_and_slip_of_a_line_are_edited_in_its_properties(window, planes):
    planes.activate("line")
    click(planes, (0, 0, 0), (1, 0.5, 1.0))
    planes.finish_tool()
    (made,) = planes.session.of(Lineation)
    panel = window.properties
    assert not panel._form.isRowVisible(panel.fields["slip"])
    choose(panel.fields["plane_id"], "f1")
    assert planes.records[made.id].plane_id == "f1"
    assert panel._form.isRowVisible(panel.fields["slip"])
    choose(panel.fields["slip"], "reverse")
    assert planes.records[made.id].slip == "reverse"
    choose(panel.fields["plane_id"], "")
    assert (planes.records[made.id].plane_id, planes.records[made.id].slip) == ("", "")
    planes.undo()
    assert (planes.records[made.id].plane_id, planes.records[made.id].slip) == ("f1", "reverse")
    planes.selection.set(["b1"])
    assert not panel._form.isRowVisible(panel.fields["plane_id"])


# --- measure -----------------------------------------------------------------------------------
def test_tree_shows_measurements_with_their_value(window, planes):
    planes.activate("measure")
    click(planes, (0, 0, 0), (0, 3, 4))
    (made,) = planes.session.of(Dimension)
    item = window.tree._items[made.id]
    assert item.parent() is window.tree._items["dimensions"]
    assert item.parent().text(0) == "Measurements"
    assert item.text(1) == "5.00 m"
    assert window.properties._fit._plane.text() == "Distance 5.00 m"
    assert "5.00" not in window.properties._fit._details.text()
    planes.undo()
    assert made.id not in window.tree._items
    planes.redo()
    planes.selection.set([made.id])
    planes.delete_selected()
    assert planes.session.of(Dimension) == []


def test_a_thickness_is_measured_across_the_selected_plane(window, planes):
    panel = driver.tool_panel(window, MeasurePanel)
    assert not panel.form.isRowVisible(panel.plane_box)
    choose(panel.kind_box, "thickness")
    assert panel.form.isRowVisible(panel.plane_box)
    planes.selection.set(["b1"])
    planes.activate("measure")
    click(planes, (0, 0, 0), (0, 0, 2))
    (made,) = planes.session.of(Dimension)
    assert made.plane_id == "b1"
    assert "±" in window.tree._items[made.id].text(1)
    label = window.properties._form.labelForField(window.properties.fields["plane_id"])
    assert label.text() == "Across"


def test_typed_vertex_coordinates_move_the_vertex(window, planes):
    planes.activate("measure")
    choose(driver.tool_panel(window, MeasurePanel).kind_box, "polyline")
    click(planes, (0, 0, 0), (0, 3, 4))
    table = driver.tool_panel(window, MeasurePanel).table
    table.item(1, 2).setText("0,5")
    assert planes.get_tool(MeasureTool).vertices[1] == (0.0, 3.0, 0.5)
    assert "3.04 m" in driver.tool_panel(window, MeasurePanel).figures.text()
    planes.cancel_tool()
    assert not table.isVisible()


# --- relations -----------------------------------------------------------------------------------
def test_two_selected_planes_show_their_relation_and_add_their_intersection(window, planes):
    panel, action = window.properties, window.actions_table.all["keep_intersection"]
    planes.selection.set(["b1"])
    assert panel._relation_label.isHidden()
    assert not action.isEnabled()
    assert "selection.not-two-planes" in shown_codes(action.toolTip())
    planes.selection.set(["b1", "f1"])
    assert not panel._relation_label.isHidden()
    assert "B01 and F01" in panel._relation_label.text()
    relation = panel._relation_label.text()
    QTest.mouseClick(panel._keep_button, Qt.MouseButton.LeftButton)
    (made,) = planes.session.of(Intersection)
    assert (made.first.feature_id, made.second.feature_id) == ("b1", "f1")
    assert made.type_id == "lineation"
    assert planes.selection.ids == (made.id,)
    assert panel._relation_label.isHidden()
    found = planes.measured([made.id])[made.id]
    assert window.tree._items[made.id].text(1) != "–"
    assert found.max_confidence95_deg > 0.0
    assert format_error_deg(found.angle_deg) in relation
    planes.attempt(edits.delete, ["f1"])
    assert window.tree._items[made.id].text(1) == "–", "one of its planes is gone"
    planes.undo()
    assert window.tree._items[made.id].text(1) != "–"
    planes.undo()
    assert planes.session.of(Intersection) == []


# A long trace round a corner of the rock, in the plane z = 0.3 x, uneven by a millimetre or two.
_CORNER = [(0.1 * i, 0.0) for i in range(31)] + [(3.0, 0.1 * i) for i in range(1, 31)]


def corner(up: float, shift: float = 0.0, seed: int = 0, dip: float = 0.3):
    rough = np.random.default_rng(seed).normal(0.0, 0.0015, len(_CORNER))
    # Across the plane, not up: a bed as thick as `up` lies higher by more.
    higher = up * np.sqrt(1.0 + dip**2)
    return tuple(
        (x + shift, y + shift, dip * (x + shift) + higher + e)
        for (x, y), e in zip(_CORNER, rough, strict=True)
    )


def p_value(said: str) -> float:
    """Return the p-value that a line about two traces shows, 0 if it is smaller than shown."""
    relation, value = re.search(r"p (=|&lt;) (\d[\d.e-]*)", said).groups()
    return float(value) if relation == "=" else 0.0


def test_selected_traces_show_same_bed_probability_and_thickness(window, studio):
    add_cliff(studio, Frame("local"))
    add_bed(studio, "a", "Base", vertices=corner(0.0, seed=1))
    add_bed(studio, "b", "Again", vertices=corner(0.0, shift=0.5, seed=2))
    add_bed(studio, "c", "Top", vertices=corner(1.25, seed=3))
    add_bed(studio, "d", "Limb", vertices=corner(0.0, seed=4, dip=-0.6))

    def said(*ids: str) -> str:
        studio.selection.set(ids)
        QApplication.processEvents()
        panel = window.properties._relation_label
        return panel.text() if not panel.isHidden() else ""

    assert p_value(said("a", "b")) > 0.05
    apart = said("a", "c")
    assert p_value(apart) < 0.001
    thick = re.search(
        r"From Base up to Top: perpendicular distance ([\d.]+) m ± ([\d.]+) (mm|cm)", apart
    )
    assert thick is not None, apart
    assert float(thick[1]) == pytest.approx(1.25, abs=0.004)
    three = said("a", "b", "c")
    assert "parallel planes" in three
    values = [p_value(line) for line in three.split("<br>") if "p &lt; " in line or "p = " in line]
    assert [p > 0.05 for p in values] == [True, False]
    assert "270.00/16.70 ± " in three
    # Limbs of a fold are no parallel beds.
    assert "Fitted together" not in said("a", "d")
    assert said("a", "b", "d") == ""
    studio.selection.set(["a"])
    assert window.properties._relation_label.isHidden()


def test_intersection_of_parallel_planes_cannot_be_added(window, planes):
    add_bed(planes, "b3", "B03", dip=0.3)
    planes.selection.set(["b1", "b3"])
    assert "parallel" in window.properties._relation_label.text()
    assert not window.properties._keep_button.isEnabled()
    assert not window.actions_table.all["keep_intersection"].isEnabled()


@pytest.mark.full
def test_intersection_dialog_preselects_bedding_and_fault(window, planes):
    action = window.actions_table.all["intersection_of_sets"]
    assert action.isEnabled()
    action.trigger()
    (dialog,) = window.findChildren(IntersectionDialog)
    assert dialog.first.currentText() == "Bedding (2 planes)"
    assert dialog.second.currentText() == "Fault (1 plane)"
    groups = [dialog.first.itemText(i) for i in range(dialog.first.count())]
    names = ["Bedding", "Bedding, upper", "Fault"]
    assert [text.partition(" (")[0] for text in groups] == names
    assert [figures(text) for text in groups] == [[2.0], [1.0], [1.0]]
    assert "Intersection: " in dialog.result_text.text()
    dialog.second.setCurrentIndex(0)
    assert not dialog.keep_button.isEnabled()
    assert "action.same-groups" in shown_codes(dialog.result_text.text())
    dialog.first.setCurrentIndex(1)
    dialog.second.setCurrentIndex(2)
    name = "upper on fault"
    QTest.keyClicks(dialog.name, name)
    QTest.mouseClick(dialog.keep_button, Qt.MouseButton.LeftButton)
    assert not dialog.isVisible()
    (made,) = planes.session.of(Intersection)
    assert made.name == name
    assert (made.first.type_id, made.first.set_name) == ("bedding", "upper")
    assert planes.selection.ids == (made.id,)


def test_view_looks_along_the_selected_line(window, planes):
    seen = []
    window.view_panel._look_along = lambda trend, plunge: seen.append((trend, plunge))
    planes.selection.set(["b1", "f1"])
    window.actions_table.all["keep_intersection"].trigger()
    (made,) = planes.session.of(Intersection)
    line = planes.measured([made.id])[made.id].line
    window.view_panel._buttons["line"].click()
    assert seen == [(line.trend_deg, line.plunge_deg)]
    planes.selection.set(["b1"])
    assert not window.view_panel._buttons["line"].isEnabled()
    tip = window.view_panel._buttons["line"].toolTip()
    assert "selection.no-line" in shown_codes(tip)


def test_net_shows_an_intersection_with_its_confidence_region(window, planes, qtbot):
    window._add_stereonet()
    planes.selection.set(["b1", "f1"])
    window.actions_table.all["keep_intersection"].trigger()
    (made,) = planes.session.of(Intersection)
    contents = window.net.contents()
    (crossing,) = [s for s in contents.sets if s.ids == (made.id,)]
    assert crossing.kind == "line"
    (ellipse,) = contents.ellipses
    found = planes.measured([made.id])[made.id]
    assert ellipse.line == found.line
    assert ellipse.max_angle_deg == found.max_confidence95_deg
    assert sum(len(part) for part in ellipse.outline()) > 20
    window.net.redraw()
    planes.selection.set(["b1"])
    planes.selection.set([made.id])
    window.net.redraw()
