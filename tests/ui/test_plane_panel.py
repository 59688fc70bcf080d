"""The page of the plane tool and its commands, without a viewport."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtTest import QTest

from tests import driver
from tests.geometry.test_brush import centre_of, grid
from tests.messages import shown_codes
from tests.ui.conftest import add_bed, add_open_cliff
from vomstudio.project.kinds.patch import Patch
from vomstudio.studio.tools.interaction_types import Button, Hit, Pointer, PointerEvent
from vomstudio.studio.tools.plane import PlaneTool
from vomstudio.studio.tools.select import SelectTool
from vomstudio.studio.tools.trace import TraceTool
from vomstudio.ui.panels.tools.plane import PlanePanel
from vomstudio.ui.panels.tools.select import SelectPanel

MESH = grid(41, 4.0, rough=0.01)


@pytest.fixture
def painting(window, studio):
    """A model that is open, and the brush in hand."""
    add_open_cliff(studio, MESH)
    studio.activate("plane")
    studio.get_tool(PlaneTool).set_radius(0.3)
    return studio


def event(kind: Pointer, face: int, **keys) -> PointerEvent:
    hit = Hit("m1", "face", face, tuple(centre_of(MESH, face)))
    return PointerEvent(kind, 0, 0, Button.LEFT, hit=hit, **keys)


def dab(studio, face: int, **keys) -> None:
    for kind in (Pointer.DRAG_START, Pointer.DRAG_END):
        studio.pointer(event(kind, face, **keys))


def patches(studio) -> list[Patch]:
    return studio.session.of(Patch)


@pytest.mark.full
def test_page_is_raised_with_its_tool(window, painting):
    assert window.docks["tool"].windowTitle() == "Plane"
    assert not driver.tool_panel(window, PlanePanel).visibleRegion().isEmpty()
    assert window.actions_table.all["plane"].isChecked()


@pytest.mark.full
def test_brush_radius_is_set_by_typing_and_by_commands(window, painting):
    panel, tool = driver.tool_panel(window, PlanePanel), painting.get_tool(PlaneTool)
    panel.radius.setValue(0.8)
    assert tool.radius == pytest.approx(0.8)
    window.actions_table.run("brush_larger")
    assert panel.radius.value() == pytest.approx(1.0)
    window.actions_table.run("brush_smaller")
    assert panel.radius.value() == pytest.approx(0.8)
    for _ in range(200):
        window.actions_table.run("brush_smaller")
    assert panel.radius.value() == pytest.approx(panel.radius.minimum())
    for _ in range(200):
        window.actions_table.run("brush_larger")
    assert panel.radius.value() == pytest.approx(panel.radius.maximum())


def test_page_shows_the_fit_during_a_stroke(window, painting):
    panel = driver.tool_panel(window, PlanePanel)
    assert not panel.fit_view.isVisibleTo(panel)
    painting.pointer(event(Pointer.DRAG_START, 900))
    QTest.qWait(50)
    painting.pointer(event(Pointer.DRAG_MOVE, 910))
    assert panel.fit_view.isVisibleTo(panel)
    live = panel.fit_view._plane.text()
    assert live != "–"
    painting.pointer(event(Pointer.DRAG_END, 920))
    assert panel.fit_view.isVisibleTo(panel)
    assert panel.fit_view._reasons.text()


@pytest.mark.full
def test_new_plane_gets_the_type_and_set_of_the_panel(window, painting):
    panel = driver.tool_panel(window, PlanePanel)
    panel.type_box.setCurrentIndex(panel.type_box.findData("joint"))
    panel.set_name_edit.setText("J1")
    panel.set_name_edit.editingFinished.emit()
    dab(painting, 900)
    painting.finish_tool()
    (patch,) = patches(painting)
    assert (patch.name, patch.type_id, patch.set_name) == ("J01", "joint", "J1")


def test_plane_panel_offers_only_plane_types(window, painting):
    box = driver.tool_panel(window, PlanePanel).type_box
    offered = {box.itemData(row) for row in range(box.count())}
    assert {"bedding", "fault", "joint"} < offered
    assert not offered & {"fold_axis", "lineation"}
    box.select_type("lineation")
    assert box.currentData() == "lineation"


def test_finish_cancel_and_edit_are_enabled_only_when_possible(window, painting):
    actions = window.actions_table.all
    window.actions_table.refresh()
    for name in ("finish", "cancel", "edit_feature"):
        assert not actions[name].isEnabled(), name
    dab(painting, 900)
    assert actions["finish"].isEnabled()
    assert actions["cancel"].isEnabled()
    window.actions_table.run("finish")
    assert not painting.get_tool(PlaneTool).is_open
    (patch,) = patches(painting)
    assert painting.selection.ids == (patch.id,)
    window.actions_table.run("edit_feature")
    assert painting.get_tool(PlaneTool).is_continued
    panel = driver.tool_panel(window, PlanePanel)
    assert panel._name.text() == "<b>B01</b>"
    assert not panel.type_box.isEnabled()
    dab(painting, 910, shift=True)
    window.actions_table.run("cancel")
    assert patches(painting) == [patch]


def test_undo_and_redo_apply_to_strokes_and_then_to_the_plane(window, painting):
    tool, run = painting.get_tool(PlaneTool), window.actions_table.run
    dab(painting, 900)
    one = tool.selection.mask
    dab(painting, 930, shift=True)
    two = tool.selection.mask
    run("undo")
    assert np.array_equal(tool.selection.mask, one)
    run("redo")
    assert np.array_equal(tool.selection.mask, two)
    run("finish")
    assert len(patches(painting)) == 1
    run("undo")
    assert patches(painting) == []
    run("redo")
    assert len(patches(painting)) == 1


def test_switching_tools_adds_the_unfinished_plane(window, painting):
    dab(painting, 900)
    painting.activate("trace")
    assert painting.tool_name == "trace"
    assert len(patches(painting)) == 1
    assert not painting.get_tool(PlaneTool).is_open
    painting.undo()
    assert patches(painting) == []


def test_an_incomplete_trace_is_discarded_for_the_plane_and_undo_restores_it(window, painting):
    painting.activate("trace")
    trace = painting.get_tool(TraceTool)
    painting.pointer(event(Pointer.CLICK, 900))
    painting.pointer(event(Pointer.CLICK, 950))
    painting.activate("plane")
    assert painting.tool_name == "plane"
    assert not trace.is_open
    painting.undo()
    assert painting.tool_name == "trace"
    assert len(trace.vertices) == 2
    trace.cancel()


@pytest.mark.full
def test_plane_can_be_edited_only_if_its_model_is_open(window, painting):
    bed = add_bed(painting, "t1")
    dab(painting, 900)
    painting.finish_tool()
    edit = window.actions_table.all["edit_feature"]
    assert edit.isEnabled()
    del painting.models["m1"]
    window.actions_table.refresh()
    assert "model.not-open" in shown_codes(edit.toolTip())
    painting.selection.set([bed.id])
    assert edit.isEnabled()


@pytest.mark.full
def test_area_can_be_moved_to_the_selection_and_back(window, painting):
    plane, select = painting.get_tool(PlaneTool), painting.get_tool(SelectTool)
    dab(painting, 900)
    mask = plane.selection.mask
    window.actions_table.run("plane_to_selection")
    assert painting.tool_name == "select"
    assert not plane.is_open
    assert np.array_equal(select.selection.mask, mask)
    assert patches(painting) == []
    assert driver.tool_panel(window, SelectPanel).more_section.isVisibleTo(
        driver.tool_panel(window, SelectPanel)
    )
    window.actions_table.run("selection_to_plane")
    assert painting.tool_name == "plane"
    assert not select.is_open
    assert np.array_equal(plane.selection.mask, mask)
    painting.finish_tool()
    assert len(patches(painting)) == 1


def test_plane_mode_command_activates_the_tool(window, painting):
    painting.activate("navigate")
    window.actions_table.run("plane_lasso")
    assert painting.tool_name == "plane"
    assert painting.get_tool(PlaneTool).mode == "lasso"
    assert window.actions_table.all["shape_lasso"].isChecked()
    window.actions_table.run("shape_pick")
    assert painting.get_tool(PlaneTool).mode == "pick"


@pytest.mark.full
def test_adding_a_plane_of_a_hidden_type_shows_the_type(window, painting):
    painting.set_visible(["bedding"], False)
    dab(painting, 900)
    said = []
    painting.notice.connect(lambda notice: said.append(notice.message.code))
    painting.finish_tool()
    assert painting.visible("bedding")
    assert "type.shown-again" in said


@pytest.mark.full
def test_finished_plane_is_listed_in_the_table(window, painting):
    dab(painting, 900)
    painting.finish_tool()
    (patch,) = patches(painting)
    measured = painting.measured([patch.id])[patch.id]
    assert measured.fit.n == patch.n
    assert np.isfinite(measured.area_m2)
    assert window.table.model.rowCount() == 1
