"""Undo and redo name what they took back or brought, and Esc is a step among the others."""

from __future__ import annotations

import pytest
from PySide6.QtWidgets import QApplication

from tests.geometry.test_brush import centre_of, grid
from tests.messages import figures, shown_codes, shown_values
from tests.samples import ZIGZAG
from tests.tiers import first_in_default_tier
from tests.ui.conftest import add_bed, add_open_cliff
from vomstudio.core.findings import Finding
from vomstudio.project.kinds.patch import Patch
from vomstudio.project.kinds.trace import Trace
from vomstudio.studio.tools.interaction_types import Button, Hit, Pointer, PointerEvent
from vomstudio.studio.tools.plane import PlaneTool

MESH = grid(41, 4.0, rough=0.01)


@pytest.fixture
def cliff(window, studio):
    """A model that is open, and all that is said."""
    add_open_cliff(studio, MESH)
    return studio


def click(studio, point, **more) -> None:
    hit = Hit("m1", "face", 0, tuple(map(float, point)))
    studio.pointer(PointerEvent(Pointer.CLICK, 0, 0, Button.LEFT, hit=hit, **more))


def stroke(studio, face: int, kind: Pointer, **keys) -> None:
    hit = Hit("m1", "face", face, tuple(centre_of(MESH, face)))
    studio.pointer(PointerEvent(kind, 0, 0, Button.LEFT, hit=hit, **keys))


def dab(studio, face: int, **keys) -> None:
    for kind in (Pointer.DRAG_START, Pointer.DRAG_END):
        stroke(studio, face, kind, **keys)


def run(window, name: str) -> tuple[str, str]:
    """Run a command as its key does; the code and the step in the status line afterwards."""
    window.actions_table.run(name)
    QApplication.processEvents()
    text = window.statusBar().currentMessage()
    code = next((c for c in ("edit.undone", "edit.redone") if c in shown_codes(text)), "")
    return code, shown_values(text, code)["edit"] if code else ""


def steps(window) -> tuple[str, str]:
    """What Undo and Redo of the menu would take back and bring; "" if nothing."""
    actions = window.actions_table.all
    undo, redo = actions["undo"].text(), actions["redo"].text()
    assert (undo[:5], redo[:5]) == ("&Undo", "&Redo")
    return undo[5:].strip(), redo[5:].strip()


# --- what is said ----------------------------------------------------------------------------
def test_undo_and_redo_name_the_edit_in_menu_and_status_line(window, cliff):
    opened, nothing = steps(window)
    assert (bool(opened), nothing) == (True, "")
    add_bed(cliff, "t1")
    assert steps(window) == ("Bedding trace B01", "")
    assert run(window, "undo") == ("edit.undone", "Bedding trace B01")
    assert steps(window) == (opened, "Bedding trace B01")
    assert run(window, "redo") == ("edit.redone", "Bedding trace B01")
    cliff.selection.set(["t1"])
    cliff.delete_selected()
    assert steps(window)[0] == "Delete B01"
    assert run(window, "undo") == ("edit.undone", "Delete B01")
    assert Finding("edit.undone", edit="Delete B01") in [each.message for each in cliff.notices]


@pytest.mark.full
def test_undo_names_a_measurement_by_its_kind(window, cliff):
    cliff.activate("measure")
    for point in ZIGZAG[:2]:
        click(cliff, point)
    assert run(window, "undo") == ("edit.undone", "Distance D01")
    assert steps(window)[1] == "Distance D01"


def test_ampersand_in_a_name_is_escaped_in_the_menu(window, cliff):
    add_bed(cliff, "t1", name="Smith & Sons")
    action = window.actions_table.all["undo"]
    assert steps(window)[0].endswith("Smith && Sons")
    assert action.text().count("&") == 3
    assert "Smith & Sons" in action.toolTip()


@pytest.mark.full
def test_undo_names_the_points_of_an_open_trace(window, cliff):
    cliff.activate("trace")
    for point in ZIGZAG[:4]:
        click(cliff, point)
    tool = cliff.open_tool
    assert run(window, "undo") == ("edit.undone", "Point 4")
    tool.move_vertex(0, (0.1, 0.0, 0.0))
    assert run(window, "undo") == ("edit.undone", "Move a point")
    tool.delete_vertex(1)
    assert run(window, "undo") == ("edit.undone", "Delete a point")
    assert tool.vertices == ZIGZAG[:3]


def test_undo_without_a_step_shows_no_message(window, studio):
    said = []
    studio.notice.connect(said.append)
    studio.undo()
    studio.redo()
    assert said == []
    assert steps(window) == ("", "")


# --- Esc is a step ---------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("name", "noun"),
    first_in_default_tier(
        [
            ("trace", "trace"),
            ("line", "line"),
            ("measure", "measurement"),
            ("contact", "contact line"),
            ("lithology", "rock area"),
        ]
    ),
)
def test_undo_after_esc_restores_the_open_picks(window, cliff, name, noun):
    cliff.activate(name)
    if name == "measure":
        cliff.tool.choose(kind="polyline")
    for point in ZIGZAG[:5]:
        click(cliff, point)
    tool, draft = cliff.tool, cliff.session.draft.state
    run(window, "cancel")
    assert not tool.is_open
    assert cliff.session.draft is None
    step = f"Discard the open {noun}"
    assert steps(window)[0] == step
    assert run(window, "undo") == ("edit.undone", step)
    assert tool.is_open
    assert tool.vertices == ZIGZAG[:5]
    assert cliff.session.draft.state == draft, "a crash now would lose the picks"
    # Forth and back as often as one likes, and each point is still a step of its own.
    assert run(window, "redo") == ("edit.redone", step)
    assert not tool.is_open
    run(window, "undo")
    run(window, "undo")
    assert tool.vertices == ZIGZAG[:4]
    assert steps(window)[1] == "Point 5"
    run(window, "finish")
    assert cliff.session.features()[-1].vertices == ZIGZAG[:4]


@pytest.mark.full
def test_discarded_trace_is_an_undo_step_between_edits(window, cliff):
    add_bed(cliff, "t1")
    cliff.activate("trace")
    for point in ZIGZAG[:3]:
        click(cliff, point)
    run(window, "cancel")
    discarded, _ = steps(window)
    add_bed(cliff, "t2")
    assert run(window, "undo") == ("edit.undone", "Bedding trace B02")
    assert run(window, "undo") == ("edit.undone", discarded)
    assert cliff.tool.vertices == ZIGZAG[:3]
    for left in (2, 1, 0):
        run(window, "undo")
        assert len(cliff.tool.vertices) == left
    assert run(window, "undo") == ("edit.undone", "Bedding trace B01")
    assert not cliff.session.of(Trace)


@pytest.mark.full
def test_undoing_the_only_point_does_not_restore_it(window, cliff):
    opened, _ = steps(window)
    cliff.activate("trace")
    click(cliff, ZIGZAG[0])
    assert run(window, "undo") == ("edit.undone", "Point 1")
    assert steps(window) == (opened, "Point 1")
    assert run(window, "redo") == ("edit.redone", "Point 1")
    assert cliff.tool.vertices == ZIGZAG[:1]
    assert steps(window) == ("Point 1", "")


def test_undo_restores_the_only_point_after_its_deletion(window, cliff):
    cliff.activate("trace")
    click(cliff, ZIGZAG[0])
    cliff.tool.delete_vertex(0)
    run(window, "undo")
    assert cliff.tool.vertices == ZIGZAG[:1]


def test_discarded_continued_trace_is_restored_as_continued(window, cliff):
    bed = add_bed(cliff, "t1")
    cliff.activate("trace")
    cliff.tool.continue_feature("t1")
    assert steps(window)[0] == "Continue B01"
    click(cliff, (6.0, 0.0, 3.0))
    run(window, "cancel")
    run(window, "undo")
    assert cliff.tool.is_continued
    assert cliff.tool.vertices == (*bed.vertices, (6.0, 0.0, 3.0))
    run(window, "finish")
    assert cliff.records["t1"].vertices == (*bed.vertices, (6.0, 0.0, 3.0))
    assert len(cliff.session.of(Trace)) == 1


def test_undo_ends_continuing_before_it_reaches_the_feature_itself(window, cliff):
    add_bed(cliff, "t1")
    cliff.activate("trace")
    cliff.tool.continue_feature("t1")
    assert run(window, "undo") == ("edit.undone", "Continue B01")
    assert not cliff.tool.is_open
    assert "t1" in cliff.records


@pytest.mark.full
def test_esc_on_an_unchanged_continued_trace_adds_no_undo_step(window, cliff):
    add_bed(cliff, "t1")
    cliff.activate("trace")
    cliff.tool.continue_feature("t1")
    run(window, "cancel")
    assert run(window, "undo") == ("edit.undone", "Bedding trace B01")


@pytest.mark.full
def test_undo_restores_the_tool_with_its_feature(window, cliff):
    cliff.activate("line")
    for point in ZIGZAG[:2]:
        click(cliff, point)
    run(window, "cancel")
    cliff.activate("navigate")
    run(window, "undo")
    assert cliff.tool_name == "line"
    assert cliff.tool.vertices == ZIGZAG[:2]


@pytest.mark.full
def test_new_project_clears_discarded_features(window, cliff):
    cliff.activate("trace")
    click(cliff, ZIGZAG[0])
    run(window, "cancel")
    cliff.new_project()
    assert steps(window) == ("", "")
    cliff.undo()
    assert cliff.open_tool is None


# --- planes ----------------------------------------------------------------------------------
@pytest.mark.full
def test_undo_after_esc_restores_the_painted_plane(window, cliff):
    cliff.activate("plane")
    tool = cliff.get_tool(PlaneTool)
    tool.set_radius(0.3)
    dab(cliff, 900)
    dab(cliff, 960, shift=True)
    painted = tool.count
    run(window, "cancel")
    assert not tool.is_open
    assert run(window, "undo") == ("edit.undone", "Discard the plane")
    assert tool.count == painted
    dab(cliff, 1000, shift=True)
    assert tool.count > painted, "the next stroke goes on with it"
    run(window, "finish")
    (patch,) = cliff.session.of(Patch)
    assert run(window, "undo") == ("edit.undone", f"Patch {patch.name}")


def test_undo_restores_a_stroke_discarded_by_esc(window, cliff):
    cliff.activate("plane")
    tool = cliff.get_tool(PlaneTool)
    tool.set_radius(0.3)
    stroke(cliff, 900, Pointer.DRAG_START)
    stroke(cliff, 960, Pointer.DRAG_MOVE)
    assert not window.actions_table.all["undo"].isEnabled(), "a stroke is let go or kept first"
    run(window, "cancel")
    assert not tool.is_open
    discarded, _ = steps(window)
    assert run(window, "undo") == ("edit.undone", discarded)
    assert tool.count > 0
    run(window, "undo")
    assert not tool.is_open


@pytest.mark.full
def test_undo_message_gives_way_to_the_tool_hint(window, cliff):
    add_bed(cliff)
    assert run(window, "undo")[0] == "edit.undone"
    cliff.activate("trace")
    assert window.statusBar().currentMessage() == ""
    assert window.status_line._hint.text() == cliff.tool.hint()
    assert run(window, "redo")[0] == "edit.redone"
    click(cliff, ZIGZAG[0])
    assert window.statusBar().currentMessage() == ""
    assert figures(cliff.tool.hint())[:2] == [1, 3]
    assert window.status_line._hint.text() == cliff.tool.hint()
