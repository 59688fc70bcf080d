"""The patch panel and the commands of the brush, without a viewport."""

from __future__ import annotations

import numpy as np
import pytest
from PySide6.QtTest import QTest
from vomstudio.studio.tools.plane import PlaneTool
from vomstudio.ui.panels.tools.plane import PlanePanel

from tests import driver
from tests.geometry.test_brush import centre_of, grid
from tests.messages import shown_codes
from tests.ui.conftest import add_bed, add_open_cliff
from vomstudio.project.kinds.patch import Patch
from vomstudio.studio.tools.interaction_types import Button, Hit, Pointer, PointerEvent
from vomstudio.studio.tools.trace import TraceTool
from vomstudio.ui.panels.tools.trace import TracePanel

MESH = grid(41, 4.0, rough=0.01)


@pytest.fixture
def painting(window, studio):
    """A model that is open, and the brush in hand."""
    add_open_cliff(studio, MESH)
    studio.activate("plane")
    studio.tool_of(PlaneTool).set_radius(0.3)
    return studio


def event(kind: Pointer, face: int) -> PointerEvent:
    return PointerEvent(
        kind, 0, 0, Button.LEFT, hit=Hit("m1", "face", face, tuple(centre_of(MESH, face)))
    )


def dab(studio, face: int) -> None:
    studio.pointer(event(Pointer.CLICK, face))


def patches(studio) -> list[Patch]:
    return studio.session.of(Patch)


@pytest.mark.full
def test_the_dock_comes_forward_with_its_tool_and_the_left_button_paints(window, painting):
    assert window.docks["tool"].windowTitle() == "Patch"
    assert not driver.tool_panel(window, PlanePanel).visibleRegion().isEmpty()
    assert window.actions_table.all["plane"].isChecked()


def test_the_radius_is_typed_shown_and_changed_by_its_commands(window, painting):
    panel, tool = driver.tool_panel(window, PlanePanel), painting.tool_of(PlaneTool)
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


def test_the_panel_shows_the_fit_while_the_stroke_is_made(window, painting):
    panel = driver.tool_panel(window, PlanePanel)
    assert not panel.fit_view.isVisibleTo(panel)
    painting.pointer(event(Pointer.DRAG_START, 900))
    QTest.qWait(50)
    painting.pointer(event(Pointer.DRAG_MOVE, 910))
    assert panel.fit_view.isVisibleTo(panel)
    live = panel.fit_view._plane.text()
    assert live != "–"
    painting.pointer(event(Pointer.DRAG_END, 920))
    assert "95 % error" in [label.text() for label in panel.fit_view._titles]
    assert panel.fit_view._reasons.text()
    assert panel._name.text() == "<b>B01</b>"


def test_type_and_set_of_what_is_made_next(window, painting):
    panel = driver.tool_panel(window, PlanePanel)
    panel.type_box.setCurrentIndex(panel.type_box.findData("joint"))
    panel.set_edit.setText("J1")
    panel.set_edit.editingFinished.emit()
    dab(painting, 900)
    (patch,) = patches(painting)
    assert (patch.name, patch.type_id, patch.set_name) == ("J01", "joint", "J1")
    assert driver.tool_panel(window, TracePanel).type_box.currentData() == "joint"


def test_finish_cancel_and_continue_are_offered_when_they_can_be_done(window, painting):
    actions = window.actions_table.all
    window.actions_table.refresh()
    for name in ("finish", "cancel", "edit_feature"):
        assert not actions[name].isEnabled(), name
    dab(painting, 900)
    assert actions["finish"].isEnabled()
    assert actions["cancel"].isEnabled()
    window.actions_table.run("finish")
    assert painting.tool_of(PlaneTool).current is None
    assert painting.selection.ids == (patches(painting)[0].id,)
    window.actions_table.run("edit_feature")
    assert painting.tool_of(PlaneTool).continued
    dab(painting, 910)
    window.actions_table.run("cancel")
    assert len(patches(painting)) == 1
    assert painting.tool_of(PlaneTool).current is None


def test_undo_and_redo_take_strokes(window, painting):
    dab(painting, 900)
    one = patches(painting)
    dab(painting, 930)
    two = patches(painting)
    window.actions_table.run("undo")
    assert patches(painting) == one
    window.actions_table.run("undo")
    assert patches(painting) == []
    assert not driver.tool_panel(window, PlanePanel)._name.isVisibleTo(
        driver.tool_panel(window, PlanePanel)
    )
    window.actions_table.run("redo")
    window.actions_table.run("redo")
    assert patches(painting) == two
    assert painting.tool_of(PlaneTool).current == two[0]


def test_another_tool_can_be_chosen_between_strokes(window, painting):
    dab(painting, 900)
    painting.activate("trace")
    assert painting.tool_name == "trace"
    assert painting.tool_of(PlaneTool).current is None
    painting.activate("plane")
    dab(painting, 930)
    assert len(patches(painting)) == 2


def test_the_brush_waits_while_a_trace_is_open(window, painting):
    painting.activate("trace")
    painting.pointer(event(Pointer.CLICK, 900))
    painting.activate("plane")
    assert painting.tool_name == "trace"
    painting.tool_of(TraceTool).cancel()


def test_only_a_patch_is_continued_by_the_brush(window, painting):
    bed = add_bed(painting, "t1")
    painting.selection.set([bed.id])
    window.actions_table.refresh()
    assert not window.actions_table.all["edit_feature"].isEnabled()
    dab(painting, 900)
    painting.finish_tool()
    assert window.actions_table.all["edit_feature"].isEnabled()
    del painting.models["m1"]
    window.actions_table.refresh()
    tip = window.actions_table.all["edit_feature"].toolTip()
    assert "model.not-open" in shown_codes(tip)


def test_the_table_and_the_tree_have_the_patch(window, painting):
    dab(painting, 900)
    (patch,) = patches(painting)
    measured = painting.measured([patch.id])[patch.id]
    assert measured.fit.n == patch.n
    assert np.isfinite(measured.area_m2)
    assert window.table.model.rowCount() == 1
