"""The line and the measure tool: clicks, planes, slip, kinds, drafts, undo."""

from __future__ import annotations

import copy
import math
from dataclasses import replace

import pytest

from tests.messages import refused, shown_codes
from tests.project.conftest import MODEL, MemoryJournal
from tests.samples import bed
from tests.studio.tools.fakes import Context, event
from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding
from vomstudio.project import edits
from vomstudio.project.journal.replay import replay
from vomstudio.project.kinds.dimension import Dimension
from vomstudio.project.kinds.lineation import Lineation
from vomstudio.project.session import Session
from vomstudio.studio.tools.interaction_types import Button, Pointer
from vomstudio.studio.tools.line import LineTool, NextLine
from vomstudio.studio.tools.measure import MeasureTool
from vomstudio.studio.tools.trace import TraceTool

STRIA = ((0.0, 0.0, 0.5), (1.0, 0.02, 0.98), (2.0, -0.01, 1.51), (3.0, 0.0, 2.0))


@pytest.fixture
def context() -> Context:
    journal = MemoryJournal()
    session = Session(journal)
    session.apply(edits.add_model(session.records, MODEL))
    session.apply(edits.add_model(session.records, replace(MODEL, id="m2")))
    session.apply(edits.add_trace(session.records, replace(bed("f1"), type_id="fault")))
    return Context(session, journal)


@pytest.fixture
def line(context) -> LineTool:
    return LineTool(context)


@pytest.fixture
def measure(context) -> MeasureTool:
    return MeasureTool(context)


def clicks(tool, points, **more) -> None:
    for point in points:
        tool.pointer(event(at=point, **more))


def draft(context):
    found = replay(context.journal.kept).draft
    return None if found is None else found.state


def of(context, cls) -> list:
    return context.session.of(cls)


def again(context, cls):
    """The next start: the journal as it is on the disk now."""
    journal = MemoryJournal()
    journal.kept = copy.deepcopy(context.journal.kept)
    other = Context(Session(journal), journal)
    tool = cls(other)
    found = other.session.draft
    return (tool if found is not None and tool.restore(found.state) else None), other


# --- line -------------------------------------------------------------------------------------
def test_line_has_the_clicked_vertices_and_selected_attributes(line, context):
    line.choose(type_id="fold_axis", set_name="F2")
    clicks(line, STRIA)
    made = line.finish()
    (found,) = of(context, Lineation)
    assert found.id == made
    assert found.vertices == STRIA
    assert (found.name, found.type_id, found.set_name) == ("F02", "fold_axis", "F2")
    assert (found.plane_id, found.slip) == ("", "")
    assert context.made == [made]
    assert draft(context) is None


def test_line_ignores_a_plane_type(line, context):
    line.set_type("joint", "J1")
    clicks(line, STRIA[:2])
    line.finish()
    assert of(context, Lineation)[0].type_id == "lineation"


def test_line_needs_two_distinct_points(line, context):
    clicks(line, STRIA[:1])
    few = Finding("feature.too-few-points", count=1, minimum=2)
    assert line.finish_problem() == few
    assert line.finish() is None
    assert line.is_open
    clicks(line, STRIA[:1])
    assert line.finish() is None, "two clicks at one place"
    assert line.is_open
    assert "points.coincident" in shown_codes(str(context.said[-1]))


def test_reading_follows_the_cursor_after_the_first_click(line, context):
    clicks(line, [(0.0, 0.0, 0.0)])
    assert context.shown[-1].reading == ("1 point",)
    line.pointer(event(Pointer.MOVE, (0.0, 5.0, -5.0), button=Button.NONE))
    assert context.shown[-1].reading[0] == "000/45"
    line.pointer(event(Pointer.MOVE, (5.0, 0.0, 0.0), button=Button.NONE))
    assert context.shown[-1].reading[0] == "090/00"
    clicks(line, [(0.0, 5.0, -5.0)])
    assert context.shown[-1].reading[:2] == ("000/45", "n 2")
    line.pointer(event(Pointer.MOVE, (5.0, 0.0, 0.0), button=Button.NONE))
    assert context.shown[-1].reading[0] == "000/45", "what is picked, not where the cursor is"


def test_reading_on_a_plane_shows_rake_and_angle_to_the_plane(line, context):
    line.choose(plane_id="f1", slip="normal")
    clicks(line, STRIA)
    reading = context.shown[-1].reading
    assert any(r.startswith("Rake ") and r.endswith("off F01") for r in reading)
    assert context.shown[-1].patch is not None
    line.finish()
    (found,) = of(context, Lineation)
    assert (found.plane_id, found.slip) == ("f1", "normal")
    assert context.measure(found).slip_rake_deg < 0.0


def test_line_without_a_plane_has_no_slip_sense(line, context):
    line.choose(slip="normal")
    assert line.next_line.slip == ""
    line.choose(plane_id="f1")
    clicks(line, STRIA[:2])
    line.choose(slip="dextral")
    assert draft(context)["slip"] == "dextral"
    line.choose(plane_id="")
    assert (draft(context)["plane_id"], draft(context)["slip"]) == ("", "")
    line.finish()
    assert of(context, Lineation)[0].slip == ""


def test_clicks_can_be_undone_moved_inserted_and_deleted(line, context):
    clicks(line, STRIA)
    assert line.undo()
    assert line.vertices == STRIA[:3]
    line.pointer(event(Pointer.DRAG_START, STRIA[1], handle=1))
    line.pointer(event(Pointer.DRAG_MOVE, (1.0, 0.3, 1.0), handle=1))
    line.pointer(event(Pointer.DRAG_END, (1.0, 0.4, 1.0), handle=1))
    assert line.vertices[1] == (1.0, 0.4, 1.0)
    line.undo()
    assert line.vertices == STRIA[:3]
    line.pointer(event(at=(1.5, 0.0, 1.2), ctrl=True))
    assert line.vertices[2] == (1.5, 0.0, 1.2)
    line.delete_vertex()
    assert line.vertices == STRIA[:3]
    line.cancel()
    assert not line.is_open
    assert of(context, Lineation) == []
    assert draft(context) is None


def test_continued_line_keeps_attributes_changed_meanwhile(line, context):
    clicks(line, STRIA[:3])
    made = line.finish()
    line.continue_feature(made)
    clicks(line, STRIA[3:])
    line.choose(type_id="fold_axis", plane_id="f1")
    context.session.apply(edits.set_attributes(context.session.records, [made], notes="worn"))
    line.finish()
    (found,) = of(context, Lineation)
    assert (found.vertices, found.notes, found.type_id) == (STRIA, "worn", "lineation")
    context.session.undo()
    assert of(context, Lineation)[0].vertices == STRIA[:3]


def test_only_a_line_is_continued_by_the_line_tool(line, context):
    with refused("tool.other-kind", DocumentError):
        line.continue_feature("f1")
    assert not line.is_open


# --- measure ------------------------------------------------------------------------------------
def test_distance_is_finished_by_its_second_click(measure, context):
    clicks(measure, [(0, 0, 0), (3, 4, 12)])
    assert not measure.is_open
    (found,) = of(context, Dimension)
    assert (found.name, found.kind) == ("D01", "distance")
    assert context.measure(found).dimension == {
        "distance_m": 13.0,
        "horizontal_m": 5.0,
        "vertical_m": 12.0,
        "trend_deg": pytest.approx(180.0 + math.degrees(math.atan2(3.0, 4.0))),
        "plunge_deg": pytest.approx(math.degrees(math.atan2(12.0, 5.0))),
    }
    context.session.undo()
    assert of(context, Dimension) == []
    context.session.redo()
    assert of(context, Dimension) == [found]
    context.session.apply(edits.delete(context.session.records, [found.id]))
    assert of(context, Dimension) == []


def test_distance_to_the_cursor_is_shown_before_the_second_click(measure, context):
    clicks(measure, [(0, 0, 0)])
    measure.pointer(event(Pointer.MOVE, (3, 4, -12), button=Button.NONE))
    assert context.shown[-1].reading == (
        "Distance 13.0 m",
        "Horizontal 5.00 m, downward 12.0 m",
        "Trend/plunge 037/67",
    )


@pytest.mark.parametrize(("kind", "points"), [("polyline", 2), ("area", 3)])
def test_lines_and_areas_end_with_enter_and_report_missing_points(measure, context, kind, points):
    ring = [(0, 0, 0), (2, 0, 0), (2, 3, 0), (0, 3, 0)]
    measure.choose(kind=kind)
    for count, point in enumerate(ring, 1):
        clicks(measure, [point])
        why = measure.finish_problem()
        assert (why is None) == (count >= points), why
        if count < points:
            assert measure.finish() is None
            few = Finding("feature.too-few-points", count=points - count, minimum=points)
            assert why == few
            assert context.said[-1].code == "feature.too-few-points"
    measure.finish()
    (found,) = of(context, Dimension)
    assert found.vertices == tuple(tuple(map(float, p)) for p in ring)
    figures = context.measure(found).dimension
    if kind == "area":
        assert figures["area_m2"] == pytest.approx(6.0)
        assert figures["perimeter_m"] == pytest.approx(10.0)
    else:
        assert figures["length_m"] == pytest.approx(7.0)


def test_area_outline_is_closed_with_one_handle_per_vertex(measure, context):
    measure.choose(kind="area")
    ring = [(0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (2.0, 3.0, 0.0)]
    clicks(measure, ring)
    line = context.shown[-1].line
    assert len(line) == 4
    assert tuple(line[-1]) == ring[-1], "the rubber band hangs from the last click"
    for handle, point in enumerate(line):
        measure.pointer(event(at=point, handle=handle))
        assert measure.vertices[measure.current_vertex] == tuple(point)
        assert tuple(context.shown[-1].line[context.shown[-1].marked]) == tuple(point)
        measure.mark(None)
    measure.pointer(event(Pointer.DRAG_START, (0, 0, 0), handle=1))
    measure.pointer(event(Pointer.DRAG_END, (0.5, 0, 0), handle=1))
    assert measure.vertices[0] == (0.5, 0.0, 0.0)


def test_thickness_without_a_plane_is_rejected(measure, context):
    measure.choose(kind="thickness")
    assert measure.hint() == Finding("thickness.no-plane").message
    clicks(measure, [(0, 0, 0), (0, 0, 2)])
    assert measure.is_open, "nothing to be measured across"
    assert measure.finish() is None
    assert context.said[-1].code == "thickness.no-plane"
    measure.choose(plane_id="f1")
    assert any(r.startswith("Thickness ") and " ± " in r for r in context.shown[-1].reading)
    assert context.shown[-1].patch is not None
    assert measure.finish() is not None
    (found,) = of(context, Dimension)
    assert found.plane_id == "f1"
    figures = context.measure(found).dimension
    assert 0.0 < figures["thickness_m"] < 2.0
    assert figures["thickness_error95_m"] > 0.0


def test_changing_the_kind_keeps_the_clicks(measure, context):
    measure.choose(kind="polyline")
    clicks(measure, [(0, 0, 0), (1, 0, 0), (2, 5, 0)])
    measure.choose(kind="area")
    assert len(measure.vertices) == 3
    measure.choose(kind="distance")
    assert measure.vertices == ((0.0, 0.0, 0.0), (2.0, 5.0, 0.0))
    measure.undo()
    assert len(measure.vertices) == 3
    measure.choose(plane_id="f1")
    measure.choose(kind="distance")
    measure.finish()
    assert of(context, Dimension)[0].plane_id == "", "a distance lies on no plane"


def test_distance_between_coincident_clicks_is_rejected(measure, context):
    clicks(measure, [(1, 1, 1), (1, 1, 1)])
    assert of(context, Dimension) == []
    assert context.said[-1].code == "points.coincident"
    clicks(measure, [(1, 1, 2)])
    assert of(context, Dimension)[0].vertices == ((1.0, 1.0, 1.0), (1.0, 1.0, 2.0))


def test_continued_distance_moves_its_end_points(measure, context):
    clicks(measure, [(0, 0, 0), (1, 0, 0)])
    made = of(context, Dimension)[0].id
    measure.continue_feature(made)
    measure.pointer(event(Pointer.DRAG_START, (1, 0, 0), handle=1))
    measure.pointer(event(Pointer.DRAG_END, (2, 0, 0), handle=1))
    clicks(measure, [(3, 0, 0)])
    assert measure.is_open, "the end moves until Enter"
    assert len(measure.vertices) == 2
    measure.finish()
    assert of(context, Dimension)[0].vertices == ((0.0, 0.0, 0.0), (3.0, 0.0, 0.0))


def test_a_measurement_stays_on_one_model(measure, context):
    clicks(measure, [(0, 0, 0)])
    clicks(measure, [(1, 0, 0)], model_id="m2")
    assert measure.is_open
    assert context.said[-1] == Finding("tool.other-model")


# --- drafts ------------------------------------------------------------------------------------
def test_every_step_of_a_line_is_restored_from_its_draft(line, context):
    clicks(line, STRIA[:2])
    old = line.finish()
    line.choose(plane_id="f1")
    steps = [
        lambda: clicks(line, STRIA[:1]),
        lambda: clicks(line, STRIA[1:3]),
        lambda: line.choose(slip="sinistral", set_name="S1"),
        lambda: line.move_vertex(0, (0.0, 0.1, 0.0)),
        line.undo,
        line.finish,
        lambda: line.continue_feature(old),
        lambda: clicks(line, STRIA[2:]),
        line.cancel,
    ]
    for step in steps:
        step()
        back, _ = again(context, LineTool)
        assert (back is not None) == line.is_open
        if back is not None:
            assert back.feature == line.feature
            assert back.attributes == line.attributes
            assert back.is_continued == line.is_continued


def test_every_step_of_a_measurement_is_restored_from_its_draft(measure, context):
    measure.choose(kind="thickness", plane_id="f1")
    clicks(measure, [(0, 0, 0)])
    back, other = again(context, MeasureTool)
    assert back.feature == measure.feature
    clicks(back, [(0, 0, 2)])
    assert of(other, Dimension)[0].kind == "thickness"
    measure.choose(kind="polyline")
    clicks(measure, [(0, 0, 3), (0, 1, 3)])
    back, _ = again(context, MeasureTool)
    assert (back.kind, back.vertices) == ("polyline", measure.vertices)


@pytest.mark.parametrize("cls", [LineTool, MeasureTool])
def test_damaged_drafts_are_rejected(context, cls):
    tool = cls(context)
    clicks(tool, STRIA[:1])
    good = draft(context)
    other = cls(context)
    for broken in (
        {},
        {**good, "tool": "trace"},
        {**good, "model_id": "gone"},
        {**good, "vertices": [["a", "b", "c"]]},
        {**good, "vertices": [[float("nan"), 0.0, 0.0]]},
        {**good, "vertices": []},
        {**good, "slip": "sideways", "kind": "volume"},
        *({k: v for k, v in good.items() if k != key} for key in good),
    ):
        assert not other.restore(broken), broken
        assert not other.is_open
    assert not TraceTool(context).restore(good)
    assert other.restore(good)


@pytest.mark.parametrize("cls", [LineTool, MeasureTool])
def test_click_that_cannot_be_written_is_discarded(context, cls):
    tool = cls(context)
    context.journal.refuse = DocumentError(Finding("disk.full"))
    clicks(tool, STRIA[:1])
    assert not tool.is_open
    context.journal.refuse = None
    clicks(tool, STRIA[:1])
    context.journal.refuse = DocumentError(Finding("disk.full"))
    clicks(tool, STRIA[1:2])
    assert tool.vertices == STRIA[:1]
    tool.cancel()
    assert tool.is_open
    assert context.said[-1].code == "disk.full"


def test_closing_a_project_resets_the_next_attributes(line: LineTool, context: Context) -> None:
    line.choose(type_id="own-1", set_name="S2", plane_id="f1", slip="normal")
    line.clear_state()
    assert line.next_line == NextLine()
    measure = MeasureTool(context)
    measure.next_plane_id = "f1"
    measure.clear_state()
    assert measure.next_plane_id == ""
