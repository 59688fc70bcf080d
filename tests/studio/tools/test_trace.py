"""The trace tool: from the first click to exactly one of finished or cancelled."""

from __future__ import annotations

import copy

import numpy as np
import pytest

from tests.messages import refused
from tests.project.conftest import MODEL, MemoryJournal
from tests.samples import ZIGZAG
from tests.studio.tools.fakes import Context, event
from vomstudio.core.errors import DocumentError
from vomstudio.core.findings import Finding
from vomstudio.project import edits
from vomstudio.project.journal.replay import replay
from vomstudio.project.kinds.trace import Trace
from vomstudio.project.session import Session
from vomstudio.studio.tools.interaction_types import Button, Pointer
from vomstudio.studio.tools.trace import TraceTool

LINE = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (2.0, 0.0, 0.0)]


@pytest.fixture
def context() -> Context:
    journal = MemoryJournal()
    session = Session(journal)
    session.apply(edits.add_model(session.records, MODEL))
    return Context(session, journal)


@pytest.fixture
def tool(context) -> TraceTool:
    return TraceTool(context)


def clicks(tool, points=ZIGZAG, **more) -> None:
    for point in points:
        tool.pointer(event(at=point, **more))


def the_traces(context) -> list[Trace]:
    return context.session.of(Trace)


def draft(context):
    """What the journal would offer back now."""
    found = replay(context.journal.kept).draft
    return None if found is None else found.state


# --- the ordinary way -------------------------------------------------------------------------
def test_trace_vertices_are_exactly_the_clicked_points(tool, context):
    clicks(tool)
    assert tool.vertices == ZIGZAG
    tool.finish()
    (trace,) = the_traces(context)
    assert trace.vertices == ZIGZAG
    assert trace.model_id == "m1"
    assert trace.model_hash == MODEL.content_hash


def test_finishing_a_trace_emits_one_signal_and_leaves_the_tool_idle(tool, context):
    clicks(tool)
    made = tool.finish()
    assert context.made == [made]
    assert not tool.is_open
    assert context.shown[-1] is None
    assert tool.finish() is None
    tool.cancel()
    assert context.made == [made]
    assert len(the_traces(context)) == 1
    assert draft(context) is None


def test_preview_takes_the_colour_of_a_changed_type_immediately(tool, context):
    clicks(tool)
    bedding = context.shown[-1].color
    tool.set_type("joint", "")
    assert context.shown[-1].color != bedding
    tool.set_type("bedding", "")
    assert context.shown[-1].color == bedding


def test_a_cancelled_trace_leaves_no_feature_and_no_draft(tool, context):
    clicks(tool)
    tool.cancel()
    assert not tool.is_open
    assert tool.finish() is None
    assert the_traces(context) == []
    assert context.made == []
    assert draft(context) is None


def test_double_click_finishes_only_an_open_trace(tool, context):
    tool.pointer(event(Pointer.DOUBLE_CLICK, ZIGZAG[0]))
    assert not tool.is_open
    clicks(tool)
    tool.pointer(event(Pointer.DOUBLE_CLICK, ZIGZAG[-1]))
    assert not tool.is_open
    assert len(the_traces(context)) == 1


def test_other_buttons_and_clicks_off_the_outcrop_add_nothing(tool, context):
    clicks(tool, ZIGZAG[:2])
    tool.pointer(event(at=ZIGZAG[2], button=Button.RIGHT))
    tool.pointer(event(at=None))
    assert tool.vertices == ZIGZAG[:2]
    assert context.said[-1] == Finding("tool.no-surface")


def test_every_click_is_journalled_before_it_is_shown(tool, context):
    for count, point in enumerate(ZIGZAG, 1):
        rows = len(context.journal.kept)
        tool.pointer(event(at=point))
        assert context.rows_when_shown[-1] == rows + 1
        assert [tuple(v) for v in draft(context)["vertices"]] == list(ZIGZAG[:count])
        assert len(context.shown[-1].line) == count


def test_trace_gets_the_type_and_set_selected_before_finishing(tool, context):
    clicks(tool)
    tool.set_type("fault", "main")
    assert draft(context)["type_id"] == "fault"
    tool.finish()
    (trace,) = the_traces(context)
    assert (trace.type_id, trace.set_name, trace.name) == ("fault", "main", "F01")


# --- one step back ------------------------------------------------------------------------------
def test_undo_reverts_every_step_back_to_the_first_click(tool, context):
    clicks(tool)
    tool.move_vertex(1, (1.0, 0.3, 0.5))
    tool.insert_vertex((1.5, 0.0, 0.7))
    tool.delete_vertex(0)
    for expected in (6, 5):
        assert tool.undo()
        assert len(tool.vertices) == expected
        assert len(draft(context)["vertices"]) == expected
    assert tool.undo()
    for count in (4, 3, 2, 1):
        assert tool.undo()
        assert tool.vertices == ZIGZAG[:count]
    assert tool.undo()
    assert not tool.is_open
    assert draft(context) is None
    assert not tool.undo()


def test_dragging_a_vertex_is_one_step(tool, context):
    clicks(tool)
    rows = len(context.journal.kept)
    tool.pointer(event(Pointer.DRAG_START, ZIGZAG[2], handle=2))
    for k in range(1, 5):
        tool.pointer(event(Pointer.DRAG_MOVE, (2.0, -0.1 + k / 10, 1.0), handle=2))
    assert len(context.journal.kept) == rows
    tool.pointer(event(Pointer.DRAG_END, (2.0, 0.4, 1.0), handle=2))
    assert len(context.journal.kept) == rows + 1
    assert tool.vertices[2] == (2.0, 0.4, 1.0)
    assert tool.undo()
    assert tool.vertices == ZIGZAG


def test_vertex_dragged_off_the_outcrop_stays_at_its_last_hit(tool):
    clicks(tool)
    tool.pointer(event(Pointer.DRAG_START, ZIGZAG[2], handle=2))
    tool.pointer(event(Pointer.DRAG_MOVE, (2.0, 0.1, 1.0), handle=2))
    tool.pointer(event(Pointer.DRAG_MOVE, None, handle=2))
    tool.pointer(event(Pointer.DRAG_END, (9.0, 9.0, 9.0), handle=2, model_id="m2"))
    assert tool.vertices[2] == (2.0, 0.1, 1.0)


# --- inserting, deleting -------------------------------------------------------------------------
@pytest.mark.parametrize("segment", range(4))
def test_inserted_vertex_is_placed_between_its_neighbours(tool, segment):
    clicks(tool)
    a, b = np.array(ZIGZAG[segment]), np.array(ZIGZAG[segment + 1])
    point = tuple(a + 0.4 * (b - a) + [0, 0, 0.01])
    tool.pointer(event(at=point, ctrl=True))
    assert tool.vertices == (*ZIGZAG[: segment + 1], point, *ZIGZAG[segment + 1 :])
    assert tool.current_vertex == segment + 1


def test_delete_removes_only_the_marked_vertex(tool, context):
    clicks(tool)
    tool.delete_vertex()
    assert tool.vertices == ZIGZAG
    tool.pointer(event(at=ZIGZAG[3], handle=3))
    assert tool.current_vertex == 3
    tool.delete_vertex()
    assert tool.vertices == (*ZIGZAG[:3], ZIGZAG[4])
    assert tool.current_vertex is None
    tool.delete_vertex()
    assert len(tool.vertices) == 4


def test_click_on_a_vertex_toggles_its_mark(tool):
    clicks(tool)
    tool.pointer(event(at=ZIGZAG[1], handle=1))
    assert tool.current_vertex == 1
    tool.pointer(event(at=ZIGZAG[1], handle=1))
    assert tool.current_vertex is None
    assert tool.vertices == ZIGZAG


def test_deleting_the_last_vertex_discards_a_new_trace(tool, context):
    clicks(tool, ZIGZAG[:1])
    tool.delete_vertex(0)
    assert not tool.is_open
    assert draft(context) is None


# --- what is refused ------------------------------------------------------------------------------
def test_point_on_another_model_is_rejected_with_a_reason(tool, context):
    clicks(tool, ZIGZAG[:3])
    tool.pointer(event(at=ZIGZAG[3], model_id="m2"))
    assert tool.vertices == ZIGZAG[:3]
    assert context.said[-1] == Finding("tool.other-model")


def test_click_on_a_removed_model_starts_no_trace(tool, context):
    tool.pointer(event(at=ZIGZAG[0], model_id="gone"))
    assert not tool.is_open
    assert context.said[-1] == Finding("model.removed")


@pytest.mark.parametrize("points", [LINE[:1], LINE[:2], LINE, [LINE[0]] * 4], ids=str)
def test_points_that_define_no_plane_are_rejected_and_the_trace_stays_open(tool, context, points):
    clicks(tool, points)
    rows = len(context.journal.kept)
    assert tool.finish() is None
    assert context.said
    assert tool.is_open
    assert tool.vertices == tuple(points)
    assert len(context.journal.kept) == rows
    tool.pointer(event(at=(1.0, 1.0, 0.3)))
    tool.pointer(event(at=(2.0, 2.0, 0.1)))
    tool.pointer(event(at=(3.0, 1.0, 0.4)))
    assert tool.finish() is not None


def test_collinear_points_show_their_problem_while_picking(tool, context):
    clicks(tool, LINE)
    count, *why = context.shown[-1].reading
    assert count == "3 points"
    assert tool.measurement.problem.code == "points.collinear"
    assert " ".join(why) == tool.measurement.problem.message


def test_reading_shows_the_attitude_and_one_reason(tool, context):
    clicks(tool)
    verdict = tool.measurement.verdict
    attitude, *why = context.shown[-1].reading
    assert attitude == context.format_attitude(tool.measurement)
    assert " ".join(why) == "".join(reason.message for reason in verdict.reasons[:1])


# --- continuing -------------------------------------------------------------------------------
@pytest.fixture
def old(tool, context) -> Trace:
    clicks(tool, ZIGZAG[:4])
    tool.finish()
    return the_traces(context)[0]


def test_continued_trace_keeps_its_id_and_name(tool, context, old):
    tool.continue_feature(old.id)
    assert tool.is_continued
    tool.pointer(event(at=ZIGZAG[4]))
    tool.finish()
    (after,) = the_traces(context)
    assert after.id == old.id
    assert after.name == old.name
    assert after.vertices == ZIGZAG
    context.session.undo()
    assert the_traces(context) == [old]


def test_continued_trace_shows_no_rubber_band_to_an_old_cursor_position(tool, context, old):
    tool.pointer(event(Pointer.MOVE, (9.0, 9.0, 9.0)))
    clicks(tool, ZIGZAG[:1])
    assert context.shown[-1].rubber is not None
    tool.cancel()
    tool.continue_feature(old.id)
    assert context.shown[-1].rubber is None
    tool.pointer(event(Pointer.MOVE, (9.0, 9.0, 9.0)))
    assert context.shown[-1].rubber is not None


def test_cancelled_continuation_leaves_the_trace_unchanged(tool, context, old):
    tool.continue_feature(old.id)
    tool.delete_vertex(0)
    tool.cancel()
    assert the_traces(context) == [old]
    assert draft(context) is None


def test_only_one_trace_is_open_at_a_time(tool, context, old):
    clicks(tool, ZIGZAG[:2])
    with refused("feature.open", DocumentError):
        tool.continue_feature(old.id)
    assert tool.vertices == ZIGZAG[:2]


def test_deleting_a_trace_while_it_is_continued_keeps_its_clicks(tool, context, old):
    """Delete it behind the tool's back (tree, undo of its creation): finishing says why, the
    clicks stay."""
    tool.continue_feature(old.id)
    tool.pointer(event(at=ZIGZAG[4]))
    context.session.apply(edits.delete(context.session.records, [old.id]))
    assert tool.finish() is None
    assert context.said
    assert tool.vertices == ZIGZAG
    context.session.undo()
    assert tool.finish() == old.id
    assert the_traces(context)[0].vertices == ZIGZAG


def test_attributes_changed_while_a_trace_is_continued_are_kept(tool, context, old):
    tool.continue_feature(old.id)
    tool.pointer(event(at=ZIGZAG[4]))
    context.session.apply(
        edits.set_attributes(context.session.records, [old.id], name="marl", notes="weathered")
    )
    tool.finish()
    (after,) = the_traces(context)
    assert (after.name, after.notes, after.vertices) == ("marl", "weathered", ZIGZAG)


# --- drafts -----------------------------------------------------------------------------------
def again(context) -> tuple[TraceTool, Context]:
    """The next start: the journal as it is on the disk now."""
    journal = MemoryJournal()
    journal.kept = copy.deepcopy(context.journal.kept)
    other = Context(Session(journal), journal)
    return TraceTool(other), other


def restored(context) -> TraceTool | None:
    tool, other = again(context)
    found = other.session.draft
    return tool if found is not None and tool.restore(found.state) else None


def test_every_step_of_a_trace_is_restored_from_its_draft(tool, context, old):
    steps = [
        lambda: tool.pointer(event(at=ZIGZAG[0])),
        lambda: tool.pointer(event(at=ZIGZAG[1])),
        lambda: tool.pointer(event(at=ZIGZAG[2])),
        lambda: tool.pointer(event(at=ZIGZAG[4])),
        lambda: tool.pointer(event(at=ZIGZAG[3], ctrl=True)),
        lambda: tool.move_vertex(0, (0.0, 0.1, 0.0)),
        lambda: tool.delete_vertex(1),
        lambda: tool.set_type("joint", "J1"),
        tool.undo,
        tool.undo,
        tool.finish,
        lambda: tool.continue_feature(old.id),
        lambda: tool.pointer(event(at=ZIGZAG[4])),
        tool.undo,
        lambda: tool.delete_vertex(0),
        tool.cancel,
        lambda: tool.pointer(event(at=ZIGZAG[0])),
        tool.undo,
    ]
    for step in steps:
        step()
        back = restored(context)
        assert (back is not None) == tool.is_open
        if back is not None:
            assert back.vertices == tool.vertices
            assert back.is_continued == tool.is_continued
            assert back.trace.id == tool.trace.id
            assert (back.trace.type_id, back.trace.set_name) == (
                tool.trace.type_id,
                tool.trace.set_name,
            )


def test_a_restored_trace_can_be_undone_and_finished(tool, context):
    clicks(tool, ZIGZAG)
    back, other = again(context)
    assert back.restore(other.session.draft.state)
    assert back.undo()
    assert back.vertices == ZIGZAG[:4]
    assert back.finish() is not None
    assert the_traces(other)[0].vertices == ZIGZAG[:4]
    assert draft(other) is None


def test_damaged_drafts_are_rejected(tool, context):
    clicks(tool, ZIGZAG)
    good = draft(context)
    other = TraceTool(context)
    for broken in (
        {},
        {**good, "tool": "plane"},
        {**good, "model_id": "gone"},
        {**good, "vertices": None},
        {**good, "vertices": [[0.0, 1.0]]},
        {**good, "vertices": [["a", "b", "c"]]},
        {**good, "vertices": [[float("nan"), 0.0, 0.0]]},
        {**good, "vertices": [[float("inf"), 0.0, 0.0]]},
        {**good, "vertices": []},
        *({k: v for k, v in good.items() if k != key} for key in good),
    ):
        assert not other.restore(broken), broken
        assert not other.is_open


def test_draft_with_a_missing_type_keeps_its_clicks(tool, context):
    clicks(tool, ZIGZAG)
    other = TraceTool(context)
    assert other.restore({**draft(context), "type_id": "gone"})
    assert other.vertices == ZIGZAG
    assert other.trace.type_id == "bedding"


# --- a journal that cannot be written ------------------------------------------------------------
def test_click_that_cannot_be_written_is_discarded(tool, context):
    context.journal.refuse = DocumentError(Finding("disk.full"))
    clicks(tool, ZIGZAG[:1])
    assert not tool.is_open
    assert [each.code for each in context.said] == ["disk.full"]
    context.journal.refuse = None
    clicks(tool, ZIGZAG[:2])
    context.journal.refuse = DocumentError(Finding("disk.full"))
    tool.pointer(event(at=ZIGZAG[2]))
    tool.insert_vertex(ZIGZAG[3])
    tool.delete_vertex(0)
    tool.undo()
    tool.set_type("fault", "")
    assert tool.vertices == ZIGZAG[:2]
    assert tool.trace.type_id == "bedding"
    tool.pointer(event(Pointer.DRAG_START, ZIGZAG[1], handle=1))
    tool.pointer(event(Pointer.DRAG_MOVE, ZIGZAG[3], handle=1))
    tool.pointer(event(Pointer.DRAG_END, ZIGZAG[3], handle=1))
    assert tool.vertices == ZIGZAG[:2]
    assert len(context.shown[-1].line) == 2
    context.journal.refuse = None
    assert tool.undo()
    assert tool.vertices == ZIGZAG[:1]
    clicks(tool, ZIGZAG[1:])
    assert tool.vertices == ZIGZAG


def test_trace_stays_open_if_the_journal_cannot_be_written(tool, context):
    clicks(tool)
    context.journal.refuse = DocumentError(Finding("disk.full"))
    assert tool.finish() is None
    assert tool.is_open
    tool.cancel()
    assert tool.is_open
    assert [each.code for each in context.said] == ["disk.full"] * 2
    context.journal.refuse = None
    assert tool.finish() is not None


def test_trace_restored_before_its_model_gets_its_resolution_at_finish(tool, context, monkeypatch):
    """The draft is restored while the model is still being read."""
    clicks(tool)
    back, other = again(context)
    assert back.restore(other.session.draft.state)
    assert back.trace.resolution is None

    class Face:
        def local_resolution(self, points):
            return 0.02

        def outcrop_normal(self, points):
            return np.array([0.0, 1.0, 0.0])

    monkeypatch.setattr(other, "surface", lambda model_id: Face())
    back.finish()
    (trace,) = the_traces(other)
    assert trace.resolution == 0.02
    assert trace.outcrop_normal == (0.0, 1.0, 0.0)


def test_poor_plane_is_not_shown_as_a_disc(tool, context):
    # A bend of four metres in one plane, and one whose points stand a metre off any plane.
    sure = [(0.0, 0.0, 0.0), (4.0, 2.0, 0.0), (8.0, 0.5, 0.01), (12.0, 4.0, 0.0), (16.0, 0.0, 0.0)]
    clicks(tool, sure)
    assert tool.measurement.verdict.quality != "poor"
    assert context.shown[-1].patch is not None
    tool.cancel()
    poor = [(0.0, 0.0, 0.0), (4.0, 0.1, 1.0), (8.0, 0.0, -1.0), (12.0, -0.1, 1.0), (16.0, 0.0, 0.0)]
    clicks(tool, poor)
    assert tool.measurement.verdict.quality == "poor"
    assert context.shown[-1].patch is None
